"""Planar walkers on two unlike feet: rivals, mirror images, order of the file, energy, limits."""

import math

import numpy as np
import pytest
from compliant_rival import Rival
from worlds import (
    SHAKEN,
    UNLIKE,
    go,
    hinged_state,
    relaxed_world,
    shaken,
    unlike_design,
    unlike_hinged,
    unlike_relaxed,
    world_of,
)

from walkergen.errors import InputError
from walkergen.jobs.trust.selftest.scenes import masses
from walkergen.scene import GRAVITY, Scene
from walkergen.simulation import record
from walkergen.simulation.compliant import steps
from walkergen.simulation.compliant.chain import LOOSE, chain_of, energy, free_acceleration, mobility_of
from walkergen.simulation.compliant.contact import Instant, both_feet, restitutions
from walkergen.simulation.plan import prepare
from walkergen.simulation.relaxed import state as relaxed
from walkergen.simulation.world import (
    ANGLE_BACK,
    ANGLE_FRONT,
    MODE_BACK,
    OK,
    PITCH,
    SPIN,
    STICK,
    V_X,
    V_Y,
    Contact,
    X,
    Y,
    mirrored,
)
from walkergen.walker.design import Design

CORNERS = ((-14.0, 1.5), (14.0, 1.5), (-14.0, 4.5), (14.0, 4.5))
LEVELS = ((-5.0, -9.0), (8.0, -9.0))


def swung(walker, seed=3):
    """Somewhere in the air, everything moving."""
    rng = np.random.default_rng(seed)
    state = hinged_state(walker, 0.02, 0.3, 1.0)
    state[[V_X, V_Y, SPIN]] = rng.normal(size=3) * (20.0, 20.0, 3.0)
    state[ANGLE_BACK:] = rng.normal(size=4) * (0.2, 0.2, 9.0, 9.0)
    return state


def rigid(feet=LEVELS):
    """Rigid body of 1 g on two feet."""
    return relaxed.new(1.0, 68.0, feet, CORNERS)


def test_three_bodies_on_unlike_hinges():
    walker = unlike_hinged()
    world = world_of(walker, slope=0.1)
    state, rival = swung(walker), Rival(world)
    rival.start = 1.0
    chain = chain_of(walker, state, LOOSE)
    W = mobility_of(chain)
    expected = rival.mobility(state)
    # 1e-11: rounding of the rival's 13 x 13 system
    np.testing.assert_allclose(
        [W.bb_xx, W.bb_xy, W.bb_yy, W.ff_xx, W.ff_xy, W.ff_yy, W.bf_xx, W.bf_xy, W.bf_yx, W.bf_yy],
        expected[[0, 0, 1, 2, 2, 3, 0, 0, 1, 1], [0, 1, 1, 2, 3, 3, 2, 3, 2, 3]],
        rtol=0,
        atol=1e-11 * W.bb_xx,
    )
    a, _ = rival.acceleration(*rival.coordinates(state), 0.0)
    found = free_acceleration(world, state, chain)
    np.testing.assert_allclose(found, a[[0, 1, 2, 5, 8]], rtol=1e-10, atol=1e-10 * abs(a).max())


@pytest.mark.parametrize("foot", [0, 1])
def test_landing_of_either_foot_is_that_of_an_independent_integration(foot):
    walker = unlike_hinged()
    contacts = tuple(Contact(0.0, mu, 0) for mu in (0.05, 0.1))
    mu = contacts[foot].friction

    def impulse(rival, p, v, t):
        """Plastic impact of a foot that slides on: its friction in full."""
        hinges, _ = rival.hinges(p, v)
        rows = rival.foot(p, v, foot)[1]
        H = np.column_stack([rows @ rival.solve(hinges, np.zeros(4), row, hinges)[0] for row in rows])
        w = rows[1] @ v - SHAKEN.amplitude * SHAKEN.omega * math.cos(rival.phase(t))
        normal = -w / (H[1, 1] - mu * H[1, 0])
        return normal * np.array([-mu, 1.0])

    state = hinged_state(walker, 0.01, 0.05 if foot == 0 else -0.05, 0.3)
    state[V_Y], state[V_X] = -20.0, 800.0
    script = [("open", 0.0, lambda F, gap, u: gap, None)]
    if foot == 0:
        script += [("forward", mu, lambda F, gap, u: F[1], impulse), ("open", 0.0, None, None)]
    else:  # its swing takes the front foot off the plate at once
        script += [("open", 0.0, None, impulse)]
    world = world_of(walker, contact=contacts, options=steps.Options(2e-8))
    p, v = Rival(world).landing(state.copy(), 1.2e-3, foot, script)
    tally = record.new(state.size)
    assert steps.advance(world, state, 1.2e-3, tally) == OK
    assert tally.counts[0] == 1
    # 1e-9 mm and rad; rates carry the legs' frequency of 1e4 rad/s
    np.testing.assert_allclose(state[[X, Y, PITCH]], p[:3], rtol=0, atol=1e-9)
    angles = state[[ANGLE_BACK, ANGLE_FRONT]]
    np.testing.assert_allclose(angles, p[[5, 8]] - p[2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(state[[V_X, V_Y, SPIN]], v[:3], rtol=0, atol=1e-5)


def test_energy_balance_closes_and_mirror_image_runs_the_other_way():
    walker = unlike_hinged()
    world, image = world_of(walker, contact=UNLIKE), world_of(unlike_hinged(True))
    image = image._replace(contacts=UNLIKE[::-1])
    state = hinged_state(walker, 0.05, 0.002, 1.0)
    other, before = mirrored(state), energy(world, state)
    tally = record.new(state.size)
    assert steps.advance(world, state, 0.03, tally) == OK
    assert steps.advance(image, other, 0.03, record.new(other.size)) == OK
    assert tally.counts[0] > 10
    # chaos grows the roundings of some thirty impacts
    modes = slice(MODE_BACK, MODE_BACK + 2)
    seen = mirrored(other)
    seen[modes] = state[modes]
    np.testing.assert_allclose(seen, state, rtol=0, atol=1e-6)
    error = record.energy_error(tally.sums, energy(world, state) - before, before)
    assert error < 1e-2  # second order in h


@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_mirror_image_of_relaxed_feet(kind):
    walker = unlike_relaxed(kind=kind)
    state = relaxed.start(relaxed_world(walker, SHAKEN, UNLIKE), 0.05, 0.002, 1.0)
    other = mirrored(state)
    assert go(walker, SHAKEN, UNLIKE, state, 0.03)[0] == OK
    assert go(unlike_relaxed(True, kind), SHAKEN, UNLIKE[::-1], other, 0.03)[0] == OK
    np.testing.assert_allclose(mirrored(other)[:7], state[:7], rtol=0, atol=1e-6)


@pytest.mark.parametrize("model", ["relaxed", "compliant"])
def test_order_of_the_legs_in_the_file_does_not_matter(model):
    scene = Scene.model_validate({"legs": {"model": model}})
    design = unlike_design()
    own = [
        leg.model_copy(update={"friction": mu, "restitution": e})
        for leg, mu, e in zip(design.legs, (0.1, 0.6), (0.3, 0.9), strict=True)
    ]
    found = []
    for legs in (own, own[::-1]):
        changed = design.model_copy(update={"legs": legs})
        plan = prepare(scene, changed, masses(changed))
        assert [contact.friction for contact in plan.world.contacts] == [0.1, 0.6]
        assert [contact.restitution for contact in plan.world.contacts] == [0.3, 0.9]
        found.append(plan.world.walker)
    assert found[0] == found[1]


def test_flight_is_of_second_order_on_unlike_springs_and_dampers():
    walker = unlike_hinged()
    back, front = walker.legs
    legs = back._replace(damping=4.0 * back.damping), front._replace(damping=4.0 * front.damping)
    world = world_of(walker._replace(legs=legs), shaken(0.0), UNLIKE)
    start, duration = hinged_state(walker, 50.0, drive=shaken(0.0)), 4e-3
    start[ANGLE_BACK], start[SPIN] = 0.05, 3.0
    exact, fine = start.copy(), world._replace(options=steps.Options(1e-7, 1))
    assert steps.advance(fine, exact, duration, record.new(exact.size)) == OK
    errors, lost = [], []
    for step in (2e-5, 1e-5, 5e-6):
        state, tally = start.copy(), record.new(start.size)
        options = steps.Options(step, 1)
        assert steps.advance(world._replace(options=options), state, duration, tally) == OK
        errors.append(abs(state - exact)[ANGLE_BACK:].max())
        gained = energy(world, state) - energy(world, start)
        lost.append(abs(gained + tally.sums[record.DAMPING_LOSS]))
    assert walker.swing.excess != 0.0
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    assert lost[0] / lost[2] == pytest.approx(16.0, rel=0.3)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_two_feet_break_away_at_the_friction_that_their_loads_make(way):
    """Loads on feet at -5 and 8 mm, 9 mm below O, when both reach their limits of 0.1 and 0.6."""
    pair = Contact(0.0, 0.1, 0), Contact(0.0, 0.6, 0)
    one = rigid()
    # sum N_i = 1, sum N_i (x_i - way mu_i h) = 0: the drag that holds points up the slope
    back, front = -5.0 - way * 0.1 * 9.0, 8.0 - way * 0.6 * 9.0
    loads = np.linalg.solve([[1.0, 1.0], [back, front]], [1.0, 0.0])
    joint = float(loads @ (0.1, 0.6))
    for share, moves in ((0.999, False), (1.001, True)):
        slope = way * math.atan(share * joint)
        state = relaxed.start(relaxed_world(one, shaken(0.0), pair, slope), 0.0, 0.0, 0.0)
        assert go(one, shaken(0.0), pair, state, 0.05, slope)[0] == OK
        a = GRAVITY * (abs(math.sin(slope)) - joint * math.cos(slope)) if moves else 0.0
        # A stretch in closed form, but for 1e-8 s that the start spends landing
        assert way * state[V_X] == pytest.approx(a * 0.05, abs=1e-4)
        assert (state[MODE_BACK] == STICK) == (not moves)


def test_unlike_restitutions_create_no_energy_where_feet_throw_each_other_down():
    """A level drop with most of the mass in the middle: the impulse of a foot lifts the other's."""
    contacts = Contact(0.0, 0.2, 0), Contact(1.0, 0.2, 0)
    for inertia in (5.0, 68.0, 500.0):
        walker = unlike_hinged()._replace(inertia=inertia)
        world = world_of(walker, shaken(0.0), contacts)
        state = hinged_state(walker, 0.0, drive=shaken(0.0))
        state[V_Y], state[V_X] = -100.0, 30.0
        before, tally = energy(world, state), record.new(state.size)
        chain = chain_of(walker, state, LOOSE)
        now = Instant(chain, mobility_of(chain), np.empty((4, 5)), tally)
        both_feet(world, restitutions(world), state, now)
        lost = before - energy(world, state)
        assert lost == pytest.approx(tally.sums[record.IMPACT_LOSS], rel=1e-9)
        assert lost > -1e-9 * before


@pytest.mark.parametrize(("feet", "expected"), [(LEVELS, -0.451), (((-6.5, -9.0), (6.5, -9.0)), -0.420)])
def test_rigid_walker_of_two_materials_has_the_speed_of_small_steps(feet, expected):
    """Rival: the fixed-step simulator of tests/test_balance.py, 8 runs of 10 s."""
    pair = Contact(0.8, 0.1, 0), Contact(0.8, 0.6, 0)
    walker = rigid(feet)
    ratios = []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        start = relaxed.start(relaxed_world(walker, SHAKEN, pair), 0.14, 1e-3 * rng.uniform(-1, 1), rng.uniform(0, 6))
        go(walker, SHAKEN, pair, start, 0.5)
        tally, x = record.new(start.size, event_room=20_000), start[X]
        assert go(walker, SHAKEN, pair, start, 4.0, tally=tally)[0] == OK
        rows = tally.events.rows[: tally.events.cursor[0]]
        ratios.append((start[X] - x) / 4.0 / -(rows[:, 3] @ rows[:, 5] / rows[:, 3].sum()))
    assert np.mean(ratios) == pytest.approx(expected, abs=0.05)


FIVE = [{"along_mm": x, "across_mm": 0.0, "width_mm": 2.0} for x in (-10.0, -5.0, 0.0, 5.0, 10.0)]
MIXED = [{"along_mm": -6.5, "kind": "braced", "brace_thickness_mm": 0.5}, {"along_mm": 6.5}]


def test_more_feet_and_mixed_kinds_go_to_space():
    for legs, words in ((FIVE, "two feet in the plane"), (MIXED, "one kind")):
        design = Design.model_validate({"legs": legs})
        mass = masses(design)
        for model in ("relaxed", "compliant"):
            with pytest.raises(InputError, match=f"model {model}: .*{words}.*legs.model 'space'"):
                prepare(Scene.model_validate({"legs": {"model": model}}), design, mass)
        auto = Scene.model_validate({"run": {"accepted_error": 2.0}})
        assert prepare(auto, design, mass).resolved.model == "space"
    braced = Design.model_validate({"legs": [leg | {"kind": "braced"} for leg in FIVE]})
    scene = Scene.model_validate({})
    assert prepare(scene, braced, masses(braced)).resolved.model == "space"
    with pytest.raises(InputError, match=r"model rigid: .* two feet in the plane"):
        prepare(Scene.model_validate({"legs": {"model": "rigid"}}), braced, masses(braced))
