"""Model B: laws that hold for it, and its rival (docs/physics.md sections 5 and 6)."""

import math

import numpy as np
import pytest
from compliant_rival import Rival
from worlds import SHAKEN, hinged_state, hinged_walker, shaken, world_of

from walkergen.jobs.trust.selftest.scenes import masses
from walkergen.simulation import record
from walkergen.simulation.compliant import steps
from walkergen.simulation.compliant.chain import LOOSE, chain_of, energy, free_acceleration, gaps, mobility_of
from walkergen.simulation.compliant.state import walker_of
from walkergen.simulation.world import (
    ANGLE_BACK,
    ANGLE_FRONT,
    MODE_BACK,
    MODE_FRONT,
    OK,
    OPEN,
    PHASE,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    V_X,
    V_Y,
    Contact,
    X,
    Y,
)
from walkergen.theory import tensors
from walkergen.theory.impact import Law, impact
from walkergen.walker.design import Design
from walkergen.walker.mass import scaled

FINE = 2e-8
"""Step (s) whose error, of second order, is below what is compared with an integration."""


def run(walker, contact, state, duration, drive=SHAKEN, **keep):
    tally = record.new(state.size, duration, **keep)
    return steps.advance(world_of(walker, drive, contact), state, duration, tally), tally


def tilted_state(walker, seed=3):
    """Somewhere in the air, everything moving."""
    rng = np.random.default_rng(seed)
    state = hinged_state(walker, 0.02, 0.3, 1.0)
    state[[V_X, V_Y, SPIN]] = rng.normal(size=3) * (20.0, 20.0, 3.0)
    state[ANGLE_BACK:] = rng.normal(size=4) * (0.2, 0.2, 9.0, 9.0)
    return state


def test_inverse_mass_at_the_feet_is_that_of_three_bodies_on_hinges():
    walker = hinged_walker(10)
    state = tilted_state(walker)
    W = mobility_of(chain_of(walker, state, LOOSE))
    chain = np.array(
        [
            [W.bb_xx, W.bb_xy, W.bf_xx, W.bf_xy],
            [W.bb_xy, W.bb_yy, W.bf_yx, W.bf_yy],
            [W.bf_xx, W.bf_yx, W.ff_xx, W.ff_xy],
            [W.bf_xy, W.bf_yy, W.ff_xy, W.ff_yy],
        ]
    )
    # 1e-11: rounding of the rival's 13 x 13 system
    np.testing.assert_allclose(chain, Rival(world_of(walker)).mobility(state), rtol=0, atol=1e-11 * W.bb_xx)


def momentum(walker, state):
    """Momentum (x, y) of three bodies and their angular momentum about the centre of all; that centre."""
    rival = Rival(world_of(walker))
    p, v = rival.coordinates(state)
    places, speeds, masses = p.reshape(3, 3), v.reshape(3, 3), rival.masses.reshape(3, 3)
    m = masses[:, 0]
    centre, mean = m @ places[:, :2] / m.sum(), m @ speeds[:, :2] / m.sum()
    arms, moves = places[:, :2] - centre, speeds[:, :2] - mean
    turning = float(m @ (arms[:, 0] * moves[:, 1] - arms[:, 1] * moves[:, 0]) + masses[:, 2] @ speeds[:, 2])
    return np.array([*(m.sum() * mean), turning]), centre


@pytest.mark.slow
def test_a_flight_of_100_s_keeps_angular_momentum():
    """Nearly without weight, legs swinging and damped, in 1e6 steps; before, it was of second order in them."""
    for ratio in (0.0, 0.05):
        walker = hinged_walker(10, damping_ratio=ratio)
        world = world_of(walker, options=steps.Options(3e-5))
        acting = world.acting._replace(gravity=world.acting.gravity._replace(size=1e-3, into=1e-3))
        state = hinged_state(walker, 500.0)
        state[[V_X, V_Y, SPIN]] = 1e-3, 0.0, 20.0
        state[ANGLE_BACK:] = 0.05, -0.03, 40.0, 10.0
        before, _ = momentum(walker, state)
        assert steps.advance(world._replace(acting=acting), state, 100.0, record.new(state.size)) == OK
        after, _ = momentum(walker, state)
        # rounding of 1e-16 in each step adds up to 1e-10 at most
        assert after[2] == pytest.approx(before[2], rel=1e-10)
        assert after[0] == pytest.approx(before[0], abs=1e-10 * walker.mass * 20.0)


def test_what_turns_a_walker_on_one_smooth_foot_is_the_plate_alone():
    """The weight tells the contact's impulse in a step, its lever in the middle of the step the turn."""
    walker = hinged_walker(20)
    world = world_of(walker, shaken(0.0), Contact(0.0, 0.0, 0))
    state = hinged_state(walker, 0.0, 0.05, 0.3, world.drive)
    state[V_X] = 30.0
    assert steps.advance(world, state, 2e-4, record.new(state.size)) == OK
    before, _ = momentum(walker, state)
    middle, h = state.copy(), world.options.step
    middle[[X, Y, PITCH]] += 0.5 * h * state[[V_X, V_Y, SPIN]]
    middle[[ANGLE_BACK, ANGLE_FRONT]] += 0.5 * h * state[[RATE_BACK, RATE_FRONT]]
    rival = Rival(world)
    p, v = rival.coordinates(middle)
    _, centre = momentum(walker, middle)
    foot = 0 if state[MODE_BACK] != OPEN else 1
    place = rival.foot(p, v, foot)[0]
    assert sorted(state[[MODE_BACK, MODE_FRONT]] != OPEN) == [False, True]
    assert steps.advance(world, state, h, record.new(state.size)) == OK
    after, _ = momentum(walker, state)
    mass = walker.mass + sum(leg.mass for leg in walker.legs)
    impulse = after[1] - before[1] + mass * world.acting.gravity.size * h
    assert impulse > 0.0
    assert after[0] == pytest.approx(before[0], rel=1e-13)
    assert after[2] - before[2] == pytest.approx((place - centre)[0] * impulse, rel=1e-10)


def test_free_acceleration_is_that_of_three_bodies_on_hinges():
    walker = hinged_walker(20)
    world = world_of(walker, slope=0.1)
    state, rival = tilted_state(walker), Rival(world)
    rival.start = state[PHASE]
    a, _ = rival.acceleration(*rival.coordinates(state), 0.0)
    found = free_acceleration(world, state, chain_of(walker, state, LOOSE))
    expected = a[[0, 1, 2, 5, 8]]
    # 1e-10: rounding of the rival, whose largest entry (a leg's) is 1e7 rad/s^2
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10 * abs(expected).max())


@pytest.mark.parametrize("tilt", [5, 20, 35])
def test_chain_differs_from_the_papers_tensor_by_the_other_leg(tilt):
    design = Design().variant(tilt_deg=float(tilt))
    differences = []
    for lightness in (1.0, 1e-3):
        mass = scaled(masses(design), 1.0, lightness)
        walker = walker_of(design, mass)
        W = mobility_of(chain_of(walker, hinged_state(walker, 1.0), LOOSE))
        paper = tensors.feet(mass)[0]
        differences.append(abs(W.bb_yy - paper.yy) / (1.0 / mass.M))
    assert 0.0 < differences[0] < 2.0 * 0.0298 / 0.833  # order m/M of the body's own 1/M
    assert differences[1] < 2e-3 * differences[0]  # and in proportion to m


@pytest.mark.parametrize("ratio", [0.0, 0.05, 1.0, 3.0])
def test_free_leg_swings_with_the_frequency_and_decay_of_an_oscillator(ratio):
    mass = masses(Design())._replace(M=1e9, J=1e11)
    held = walker_of(Design(), mass, damping_ratio=ratio)  # a body too heavy to follow
    legs = held.legs[0]
    state = hinged_state(held, 50.0, drive=shaken(0.0))
    state[ANGLE_BACK], state[RATE_FRONT] = 1e-3, 2.0
    duration = 1.7e-3
    status, _ = run(held, Contact(0.5, 0.2, 0), state, duration, shaken(0.0))
    A = np.array([[0.0, 1.0], [-legs.stiffness / legs.inertia, -legs.damping / legs.inertia]])
    values, vectors = np.linalg.eig(A + np.diag([0.0, -1e-3 if ratio == 1.0 else 0.0]))
    flow = (vectors * np.exp(values * duration)) @ np.linalg.inv(vectors)
    back, front = (flow @ [1e-3, 0.0]).real, (flow @ [0.0, 2.0]).real
    assert status == OK
    # 2e-6 of the amplitudes: critical damping is nudged by 1e-7 for the rival's eigenvectors
    np.testing.assert_allclose(state[[ANGLE_BACK, ANGLE_FRONT]], [back[0], front[0]], atol=2e-9)
    np.testing.assert_allclose(state[[RATE_BACK, RATE_FRONT]], [back[1], front[1]], atol=2e-5)


def _impulse(rival, p, v, t, e, mu):
    hinges, _ = rival.hinges(p, v)
    rows = rival.foot(p, v, 0)[1]
    H = np.column_stack([rows @ rival.solve(hinges, np.zeros(4), row, hinges)[0] for row in rows])
    u = rows @ v
    u[1] -= SHAKEN.amplitude * SHAKEN.omega * math.cos(rival.phase(t))
    hit = impact(H[0, 0], H[0, 1], H[1, 1], u[0], u[1], e, mu, 0)
    return np.array([hit.F_x, hit.F_y])


LANDINGS = {
    "sticks, then slides": (
        Contact(0.0, 10.0, 0),
        [
            ("open", 0.0, lambda F, gap, u: gap, None),
            ("stick", 10.0, lambda F, gap, u: 10.0 * F[1] - abs(F[0]), lambda *now: _impulse(*now, 0.0, 10.0)),
            ("forward", 10.0, lambda F, gap, u: F[1], None),
            ("open", 0.0, None, None),
        ],
    ),
    "bounces, no friction": (
        Contact(0.7, 0.0, 0),
        [
            ("open", 0.0, lambda F, gap, u: gap, None),
            ("open", 0.0, lambda F, gap, u: gap, lambda *now: _impulse(*now, 0.7, 0.0)),
            ("open", 0.0, lambda F, gap, u: gap, lambda *now: _impulse(*now, 0.7, 0.0)),
            ("open", 0.0, None, lambda *now: _impulse(*now, 0.7, 0.0)),
        ],
    ),
    "slides": (
        Contact(0.0, 0.05, 0),
        [
            ("open", 0.0, lambda F, gap, u: gap, None),
            ("forward", 0.05, lambda F, gap, u: F[1], lambda *now: _impulse(*now, 0.0, 0.05)),
            ("open", 0.0, None, None),
        ],
    ),
}


@pytest.mark.parametrize("name", LANDINGS)
def test_single_landing_is_that_of_an_independent_integration(name):
    contact, script = LANDINGS[name]
    walker = hinged_walker(20)
    state = hinged_state(walker, 0.01, 0.05, 0.3)
    state[V_Y], state[V_X] = -20.0, 150.0 if name == "slides" else 10.0
    duration = 5.2e-4 if name.startswith("bounces") else 1.2e-3
    p, v = Rival(world_of(walker)).landing(state.copy(), duration, 0, script)
    tally = record.new(state.size)
    world = world_of(walker, contact=contact, options=steps.Options(FINE))
    assert steps.advance(world, state, duration, tally) == OK
    assert tally.counts[0] == (3 if name.startswith("bounces") else 1)
    found = state[[X, Y, PITCH]]
    # 1e-9 mm and rad; rates carry the legs' frequency of 1e4 rad/s
    np.testing.assert_allclose(found, p[:3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(state[[ANGLE_BACK, ANGLE_FRONT]], p[[5, 8]] - p[2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(state[[V_X, V_Y, SPIN]], v[:3], rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    ("tilt", "contact"), [(10, Contact(0.3, 0.25, Law.POISSON.value)), (20, Contact(0.0, 0.25, Law.STRONGE.value))]
)
def test_energy_balance_closes(tilt, contact):
    walker = hinged_walker(tilt)
    state = hinged_state(walker, 0.05, 0.002, 1.0)
    before = energy(world_of(walker), state)
    status, tally = run(walker, contact, state, 0.1)
    sums = tally.sums
    lost = sums[record.IMPACT_LOSS] + sums[record.FRICTION_LOSS] + sums[record.DAMPING_LOSS]
    assert status == OK
    assert sums[record.PLATE_WORK] > 100.0
    # second order in h
    assert energy(world_of(walker), state) - before == pytest.approx(
        sums[record.PLATE_WORK] - lost, abs=2e-2 * sums[record.PLATE_WORK]
    )


@pytest.mark.parametrize(("friction", "law"), [(0.25, 0), (1e3, 0), (0.25, 1), (0.25, 2)])
def test_no_foot_enters_the_plate_and_impulses_stay_in_the_cone(friction, law):
    walker = hinged_walker(10)
    state = hinged_state(walker, 0.05, 0.002, 1.0)
    status, tally = run(walker, Contact(0.5, friction, law), state, 0.06, sample_interval=5e-4, event_room=4000)
    assert status == OK
    depth = 0.0
    for row in tally.samples.rows[: tally.samples.cursor[0]]:
        depth = min(depth, *gaps(SHAKEN, row[1:], chain_of(walker, row[1:], LOOSE)))
    assert depth > -2e-5  # a dip within one step, a h^2 / 8 with a up to 1e6 mm/s^2
    impacts = tally.events.rows[: tally.events.cursor[0]]
    assert len(impacts) > 10
    assert np.all(np.abs(impacts[:, 2]) <= friction * impacts[:, 3] * (1 + 1e-12))


def test_two_halves_make_a_whole():
    walker, contact = hinged_walker(10), Contact(0.3, 0.25, 0)
    whole = hinged_state(walker, 0.01, 0.002, 1.0)
    halves = whole.copy()
    run(walker, contact, whole, 8e-3)
    for _ in range(2):
        run(walker, contact, halves, 4e-3)
    np.testing.assert_allclose(halves, whole, rtol=0, atol=1e-2)  # the cut of one step
