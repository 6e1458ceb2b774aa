"""Hertzian tips against closed forms and a second program (docs/physics.md section 7)."""

import math

import numpy as np
import pytest
from corner_rival import Corner, Rival, land
from scipy.integrate import quad
from scipy.special import beta
from space_rival import land as land_walker
from space_rival import plan_of, weightless

from walkergen.commands.selftest.scenes import masses
from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import feet
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.state import C_X, C_Y, C_Z, LEGS, V_X, V_Y, V_Z, W_X, W_Z
from walkergen.core.simulation.space.tips import elastic_energy, response
from walkergen.core.simulation.world import OK
from walkergen.core.walker.design import Design

MASS, SPEED = 0.02, 100.0
"""Of one corner, g and mm/s: a landing of the paper's walker."""

TIP = 4.0 / 3.0 * 1.93e9 * math.sqrt(5e-3)
"""Hertz stiffness of the default tip."""

STIFF_LEG = 1e12
"""Leg (g/s^2) that takes 1e-8 of the depth."""


def corner_of(spring=STIFF_LEG, tip=TIP, e=1.0, **more):
    """A corner without friction, free to slip, that rebounds with e."""
    return Corner(np.eye(3) / MASS, spring, tip, 2.0 * feet.damping_ratio(e) * math.sqrt(MASS), **more)


def hertz(mass, speed, tip):
    """Greatest depth (mm) and time (s) of Hertz's impact: (5 m v^2 / 4 K)^(2/5), and 2.94 depth / v."""
    depth = (1.25 * mass * speed**2 / tip) ** 0.4
    return depth, 0.8 * beta(0.4, 0.5) * depth / speed


def step_of(corner, speed, parts):
    """Step that resolves an impact: 1 / omega of the tangent stiffness at the greatest depth, in parts."""
    depth = hertz(MASS, speed, corner.tip)[0]
    stiff = 1.0 / (1.0 / corner.spring + 1.0 / (1.5 * corner.tip * math.sqrt(depth)))
    return math.sqrt(MASS / stiff) / parts


def test_formulas_of_hertz_are_those_of_the_literature():
    """Depth (15 m v^2 / (16 E* sqrt R))^(2/5), time 2.87 (m^2 / (R E*^2 v))^(1/5): Johnson, section 11.4."""
    modulus, radius = 1.93e9, 5e-3
    depth, time = hertz(MASS, SPEED, TIP)
    assert depth == pytest.approx((15.0 * MASS * SPEED**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4, rel=1e-12)
    # 1e-3: 2.87 is rounded
    assert time == pytest.approx(2.87 * (MASS**2 / (radius * modulus**2 * SPEED)) ** 0.2, rel=1e-3)


@pytest.mark.parametrize("speed", [1.0, 100.0, 1e4])
def test_ball_presses_and_rebounds_by_hertzs_law(speed):
    corner = corner_of()
    depth, time = hertz(MASS, speed, TIP)
    h = step_of(corner, speed, 400)
    found = land(corner, (-speed, 0.0, 0.0), h)
    # 1e-4: second order in a step of 1/1200 of the contact, and in the place of the deepest step
    assert found.path[:, 0].max() == pytest.approx(depth, rel=1e-4)
    assert found.velocity[0] == pytest.approx(speed, rel=1e-4)
    # 1e-3: a step and a half, until the force ends
    assert h * found.path[:, 2].sum() == pytest.approx(time, rel=1e-3)


def test_walker_presses_its_tips_by_hertzs_law():
    """Level on four corners, braced: a quarter of its mass each. Tips of 1 MPa, whose legs do not give."""
    tables = {"plate": {"youngs_modulus_gpa": 1e-3}, "contact": {"restitution": 1.0, "friction": 0.0}}
    plan = weightless(plan_of(0, "braced", **tables))
    plan = plan.coarser(1 / 64)
    walker, speed = plan.world.walker, 100.0
    depth, time = hertz(0.25 * walker.mass, speed, walker.tip[0])
    state = plan.initial_state(1e-3, 0.0, 0.0)
    state[V_Y] = -speed
    begin, tally = plan.initial_state(0.0, 0.0, 0.0)[C_Y], record.new_tally(len(state))
    deepest, moment = 0.0, 0.002 * time
    while tally.counts[record.IMPACTS] < 4:
        assert plan.advance(state, moment, tally) == OK
        deepest = max(deepest, begin - state[C_Y])
    # 3e-4: the leg gives 2e-4 of the depth, and moments are 0.2 % of the contact apart
    assert deepest == pytest.approx(depth, rel=3e-4)
    assert tally.sums[record.CONTACT_TIME] == pytest.approx(time, rel=1e-3)
    assert state[V_Y] == pytest.approx(speed, rel=1e-4)


RATIOS = [0.01, 1.0, 100.0]
"""Tangent stiffness of the tip at its greatest depth over that of the leg."""


def leg_stiffness(ratio, speed):
    """Return the stiffness of a leg with this ratio to its tip."""
    return 1.5 * TIP * math.sqrt(hertz(MASS, speed, TIP)[0]) / ratio


@pytest.mark.parametrize("e", [0.1, 0.3, 0.5, 0.8, 0.95, 1.0])
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("speed", [1.0, 100.0, 1e4])
def test_corner_rebounds_with_its_restitution_at_any_speed_on_any_leg(speed, ratio, e):
    corner = corner_of(leg_stiffness(ratio, speed), e=e)
    by_steps = [land(corner, (-speed, 0.0, 0.0), step_of(corner, speed, 50), part).velocity[0] for part in (0.2, 0.8)]
    # 1e-3: second order in a step of 1/150 of the contact
    np.testing.assert_allclose(by_steps, e * speed, rtol=1e-3)


@pytest.mark.parametrize("e", [0.1, 0.5, 0.8])
@pytest.mark.parametrize("ratio", [*RATIOS, 0.0])
def test_law_gives_its_restitution_by_a_second_program(ratio, e):
    """Ratio 0: rigid legs."""
    corner = corner_of(leg_stiffness(ratio, SPEED) if ratio else STIFF_LEG, e=e)
    velocity, _ = Rival(corner).land((-SPEED, 0.0, 0.0))
    # 1e-6: it begins and ends at 1e-9 of the force
    assert velocity[0] == pytest.approx(e * SPEED, rel=1e-6)


@pytest.mark.parametrize("e", [0.02, 0.1, 0.3, 0.8])
def test_own_step_keeps_the_restitution(e):
    """At the step that the simulator takes, for a corner that bears its share of the walker."""
    plan = weightless(plan_of(0, "braced", contact={"restitution": e, "friction": 0.0}))
    walker, found = plan.world.walker, []
    for clearance in 1e-3 + 1e-3 * np.arange(8) / 8.0:
        state, _, _ = land_walker(plan, (0.0, -SPEED, 0.0), clearance=clearance, landings=4)
        found.append(state[V_Y] / SPEED)
    alone = walker.damper[0] / (2.0 * feet.damping_ratio(e))  # root of the mass that its damper is made for
    expected = feet.restitution(feet.damping_ratio(e) * alone / math.sqrt(0.25 * walker.mass))
    # 0.008: second order in a step of 1/14 of the contact; 0.0044 and 0.0012 measured at 0.3 and 0.8
    np.testing.assert_allclose(found, expected, rtol=0, atol=8e-3)


def scaled_plan(scale, **tables):
    """Plan of the paper's walker at 1.8 g with lengths, radius and moduli x s, times x sqrt(s)."""
    one = Design().variant(tilt_deg=10.0)
    lengths = {
        name: {k: v * scale if k.endswith("_mm") else v for k, v in section.items()}
        for name, section in one.model_dump(include={"body", "legs"}, exclude_none=True).items()
    }
    design = Design.model_validate(lengths | {"material": {"youngs_modulus_gpa": 3.0 * scale}})
    tables = tables | {
        "drive": {"frequency_hz": 90.0 / math.sqrt(scale), "gamma": 1.8},
        "arena": {"kind": "plane"},
        "feet": {"tip_radius_um": 5.0 * scale},
        "plate": {"youngs_modulus_gpa": 3.0 * scale},
    }
    return prepare(Scene.model_validate(tables), design, masses(design))


@pytest.mark.parametrize("step_us", [None, 15.0], ids=["own step", "given step"])
@pytest.mark.parametrize("power", [-5, -1, 1, 4])
def test_lengths_times_4_run_at_twice_the_speed_to_the_bit(power, step_us):
    """Lengths, radius and moduli x 4^n, frequency x 2^-n, the same gamma: powers of two change no bit."""
    states, own = [], scaled_plan(1.0).world.options.step
    # x^0.4 and x^(2/3), the factors of the automatic step, are those of scaled numbers only to rounding
    assert scaled_plan(4.0**power).world.options.step == pytest.approx(2.0**power * own, rel=1e-14)
    for length, seconds in ((1.0, 1.0), (4.0**power, 2.0**power)):
        plan = scaled_plan(length, run={"step_us": (1e6 * own if step_us is None else step_us) * seconds})
        state = plan.initial_state(0.0625 * length, 4e-3, 1.0, 1e-3)
        state[[V_X, V_Z]] = 12.0 * seconds, 3.0 * seconds
        tally = record.new_tally(len(state))
        assert plan.advance(state, 0.125 * seconds, tally) == OK
        assert tally.counts[record.IMPACTS] > 30
        n = len(plan.world.walker.stiffness)
        state[C_X : C_Z + 1] /= length
        state[V_X : V_Z + 1] /= seconds
        state[[*range(W_X, W_Z + 1), *range(LEGS + n, LEGS + 2 * n)]] *= seconds
        states.append(state[C_X : LEGS + 2 * n])
    found, expected = states
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("e", [0.02, 0.5, 1.0])
@pytest.mark.parametrize("parts", [1.0, 4.0, 64.0])
def test_plate_never_pulls(parts, e):
    """Not even in a step as coarse as is taken."""
    for ratio in RATIOS:
        corner = corner_of(leg_stiffness(ratio, SPEED), e=e)
        for part in (0.1, 0.5, 0.9):
            found = land(corner, (-SPEED, 0.0, 0.0), step_of(corner, SPEED, parts), part)
            assert (found.path[:, 1] > 0.0).all()
            assert found.velocity[0] > 0.0


@pytest.mark.parametrize("friction", [0.0, 0.25, 10.0])
@pytest.mark.parametrize("e", [0.1, 0.8, 1.0])
def test_energy_of_a_rebound_is_booked_whole(e, friction):
    """By the tangent in a step the springs give another energy than they hold: that part is of second order."""
    for ratio in RATIOS:
        corner = corner_of(leg_stiffness(ratio, SPEED), e=e, friction=friction)
        unbooked = []
        for parts in (10.0, 40.0):
            found = land(corner, (-SPEED, 30.0, -20.0), step_of(corner, SPEED, parts))
            unbooked.append(abs(found.sums.sum() - found.lost) / (0.5 * MASS * SPEED**2))
            # what a damper or the slider took is positive
            assert found.sums[record.IMPACT_LOSS] > -1e-3 * MASS * SPEED**2
            assert found.sums[record.FRICTION_LOSS] > -1e-3 * MASS * SPEED**2
        assert unbooked[0] < 2e-2
        assert unbooked[1] < 2e-3


def test_infinite_radius_is_a_rigid_tip():
    rigid = plan_of(10, feet={"rigid_tips": True}).world.walker
    assert np.isinf(rigid.tip).all()
    corner = corner_of(float(rigid.spring[0]), math.inf, e=0.5)
    h = 0.05 * math.sqrt(MASS / corner.spring)
    expected = land(corner, (-SPEED, 0.0, 0.0), h)
    depth, off = SPEED * math.sqrt(MASS / corner.spring), []
    for more in (1e3, 1e6):
        found = land(corner._replace(tip=more * corner.spring / math.sqrt(depth)), (-SPEED, 0.0, 0.0), h)
        off.append(abs(found.path[:, 0].max() / expected.path[:, 0].max() - 1.0))
        # the tip takes (F / K)^(2/3) of the depth: more^(-2/3)
        assert off[-1] < 2.0 * more ** (-2 / 3)
        np.testing.assert_allclose(found.velocity, expected.velocity, atol=0.01 * SPEED)
    assert off[1] < 0.03 * off[0]


SPRINGS = [(6.4e8, TIP), (1e6, TIP), (1e12, TIP), (6.4e8, 1e3 * TIP), (6.4e8, 1e-3 * TIP), (6.4e8, math.inf)]


@pytest.mark.parametrize(("spring", "tip"), SPRINGS)
@pytest.mark.parametrize("depth", [1e-12, 1e-7, 1e-3, 1.0])
def test_response_is_that_of_two_springs_in_series(spring, tip, depth):
    force, tangent, damping = response(spring, tip, depth)
    tip_depth = 0.0 if math.isinf(tip) else (force / tip) ** (2 / 3)
    assert force / spring + tip_depth == pytest.approx(depth, rel=1e-12)  # rounding
    step = 1e-4 * depth
    ahead, behind = (response(spring, tip, depth + d)[0] for d in (step, -step))
    # 1e-7: third order in the step of the difference, and its rounding
    assert tangent == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-7)
    energy = elastic_energy(spring, tip, depth)
    assert damping == pytest.approx(force**2 / (2.0 * energy), rel=1e-12)
    # in units of the depth, by y = x^2: the force of a tip alone is smooth in y
    work, _ = quad(lambda y: 2.0 * y * response(spring, tip, depth * y * y)[0] / force, 0.0, 1.0, epsrel=1e-11)
    assert energy == pytest.approx(work * force * depth, rel=1e-9)


def test_open_contacts_hold_no_energy():
    assert elastic_energy(6.4e8, TIP, 0.0) == elastic_energy(6.4e8, TIP, -1.0) == 0.0
