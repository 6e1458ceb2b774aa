"""Model B: laws that hold for both methods and both walkers (physics.md sections 5 and 6)."""

import math

import numpy as np
import pytest
from compliant_rival import Rival

from walkergen.design import Design
from walkergen.mass import MassProperties
from walkergen.simulation import record
from walkergen.simulation.compliant import event_driven, time_stepping
from walkergen.simulation.compliant.chain import (
    chain_of,
    energy,
    free_acceleration,
    gaps,
    mobility_of,
)
from walkergen.simulation.compliant.legs import (
    ANGLE_BACK,
    ANGLE_FRONT,
    FOLDED,
    MODE_BACK,
    MODE_FRONT,
    OK,
    PHASE,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    TOPPLED,
    V_X,
    V_Y,
    X,
    Y,
    new_state,
    walker_of,
)
from walkergen.simulation.plate import Contact, Plate
from walkergen.theory import tensors
from walkergen.theory.impact import Law, impact

OMEGA = 2.0 * math.pi * 90.0
G = 9806.65
METHODS = {
    "events": (event_driven.advance, event_driven.Options()),
    "steps": (time_stepping.advance, time_stepping.Options(1e-5)),
}
both = pytest.mark.parametrize("method", METHODS)


def plate_of(gamma):
    return Plate(gamma * G / OMEGA**2, OMEGA, None)


PLATE = plate_of(1.8)


def masses(design):
    """Body 28 x 8 x 3, thin uniform legs; braced legs without mass."""
    M = 28.0 * 8.0 * 3.0 * 1.24e-3
    m = 0.0 if design.braced else 7.5 * 0.4 * 8.0 * 1.24e-3
    c = 0.5 * np.array(design.anchor_to_foot)
    a, b = (np.array(anchor) for anchor in design.anchors)
    J = M * (28.0**2 + 3.0**2) / 12.0
    return MassProperties(M, J, m, m * 7.5**2 / 12.0, a, b, c, c, design.braced)


def walker_at(tilt, kind="flexible", **options):
    design = Design().variant(tilt_deg=float(tilt), kind=kind)
    return walker_of(design, masses(design), **options)


def stiff(walker, factor, ratio=None):
    legs = walker.legs
    k = factor * legs.stiffness
    c = legs.damping * math.sqrt(factor)
    if ratio is not None:
        c = 2.0 * ratio * math.sqrt(k * legs.inertia)
    return walker._replace(legs=legs._replace(stiffness=k, damping=c))


def run(method, walker, contact, state, duration, plate=PLATE, **keep):
    advance, options = METHODS[method]
    tally = record.new(state.size, duration, **keep)
    return advance(walker, plate, contact, options, state, duration, tally), tally


def tilted_state(walker, seed=3):
    """Somewhere in the air, everything moving."""
    rng = np.random.default_rng(seed)
    state = new_state(walker, PLATE, 0.02, 0.3, 1.0)
    state[[V_X, V_Y, SPIN]] = rng.normal(size=3) * (20.0, 20.0, 3.0)
    if walker.legs is not None:
        state[ANGLE_BACK:] = rng.normal(size=4) * (0.2, 0.2, 9.0, 9.0)
    return state


def test_inverse_mass_at_the_feet_is_that_of_three_bodies_on_hinges():
    walker = walker_at(10)
    state = tilted_state(walker)
    W = mobility_of(chain_of(walker, state, 0.0))
    chain = np.array(
        [
            [W.bb_xx, W.bb_xy, W.bf_xx, W.bf_xy],
            [W.bb_xy, W.bb_yy, W.bf_yx, W.bf_yy],
            [W.bf_xx, W.bf_yx, W.ff_xx, W.ff_xy],
            [W.bf_xy, W.bf_yy, W.ff_xy, W.ff_yy],
        ]
    )
    # 1e-11: rounding of the rival's 13 x 13 system
    np.testing.assert_allclose(
        chain, Rival(walker, PLATE).mobility(state), rtol=0, atol=1e-11 * W.bb_xx
    )


def test_free_acceleration_is_that_of_three_bodies_on_hinges():
    walker = walker_at(20, slope=0.1)
    state, rival = tilted_state(walker), Rival(walker, PLATE)
    rival.start = state[PHASE]
    a, _ = rival.acceleration(*rival.coordinates(state), 0.0)
    found = free_acceleration(walker, state, chain_of(walker, state, 0.0), 0.0)
    expected = a[[0, 1, 2, 5, 8]]
    # 1e-10: rounding of the rival, whose largest entry (a leg's) is 1e7 rad/s^2
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10 * abs(expected).max())


@pytest.mark.parametrize("tilt", [5, 20, 35])
def test_chain_differs_from_the_papers_tensor_by_the_other_leg(tilt):
    design = Design().variant(tilt_deg=float(tilt))
    differences = []
    for lightness in (1.0, 1e-3):
        mass = masses(design)
        mass = mass._replace(m=mass.m * lightness, j=mass.j * lightness)
        walker = walker_of(design, mass)
        W = mobility_of(chain_of(walker, new_state(walker, PLATE, 1.0), 0.0))
        paper = tensors.feet(mass)[0]
        differences.append(abs(W.bb_yy - paper.yy) / (1.0 / mass.M))
    assert 0.0 < differences[0] < 2.0 * 0.0298 / 0.833  # order m/M of the body's own 1/M
    assert differences[1] < 2e-3 * differences[0]  # and in proportion to m


@both
@pytest.mark.parametrize("ratio", [0.0, 0.05, 1.0, 3.0])
def test_free_leg_swings_with_the_frequency_and_decay_of_an_oscillator(method, ratio):
    mass = masses(Design())._replace(M=1e9, J=1e11)
    held = walker_of(Design(), mass, damping_ratio=ratio)  # a body too heavy to follow
    legs = held.legs
    state = new_state(held, plate_of(0.0), 50.0)
    state[ANGLE_BACK], state[RATE_FRONT] = 1e-3, 2.0
    duration = 1.7e-3
    status, _ = run(method, held, Contact(0.5, 0.2, 0), state, duration, plate_of(0.0))
    A = np.array([[0.0, 1.0], [-legs.stiffness / legs.inertia, -legs.damping / legs.inertia]])
    values, vectors = np.linalg.eig(A + np.diag([0.0, -1e-3 if ratio == 1.0 else 0.0]))
    flow = (vectors * np.exp(values * duration)) @ np.linalg.inv(vectors)
    back, front = (flow @ [1e-3, 0.0]).real, (flow @ [0.0, 2.0]).real
    assert status == OK
    # 2e-6 of the amplitudes: critical damping is nudged by 1e-7 for the rival's eigenvectors; the
    # event-driven flow keeps 1e-9 per step
    np.testing.assert_allclose(state[[ANGLE_BACK, ANGLE_FRONT]], [back[0], front[0]], atol=2e-9)
    np.testing.assert_allclose(state[[RATE_BACK, RATE_FRONT]], [back[1], front[1]], atol=2e-5)


def _impulse(rival, p, v, t, e, mu):
    hinges, _ = rival.hinges(p, v)
    rows = rival.foot(p, v, 0)[1]
    H = np.column_stack([rows @ rival.solve(hinges, np.zeros(4), row, hinges)[0] for row in rows])
    u = rows @ v
    u[1] -= PLATE.amplitude * OMEGA * math.cos(rival.phase(t))
    hit = impact(H[0, 0], H[0, 1], H[1, 1], u[0], u[1], e, mu, 0)
    return np.array([hit.F_x, hit.F_y])


LANDINGS = {
    "sticks, then slides": (
        Contact(0.0, 10.0, 0),
        [
            ("open", 0.0, lambda F, gap, u: gap, None),
            (
                "stick",
                10.0,
                lambda F, gap, u: 10.0 * F[1] - abs(F[0]),
                lambda *now: _impulse(*now, 0.0, 10.0),
            ),
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
            (
                "forward",
                0.05,
                lambda F, gap, u: F[1],
                lambda *now: _impulse(*now, 0.0, 0.05),
            ),
            ("open", 0.0, None, None),
        ],
    ),
}


@pytest.mark.parametrize("name", LANDINGS)
def test_single_landing_is_that_of_an_independent_integration(name):
    contact, script = LANDINGS[name]
    walker = walker_at(20)
    state = new_state(walker, PLATE, 0.01, 0.05, 0.3)
    state[V_Y], state[V_X] = -20.0, 150.0 if name == "slides" else 10.0
    duration = 5.2e-4 if name.startswith("bounces") else 1.2e-3
    p, v = Rival(walker, PLATE).landing(state.copy(), duration, 0, script)
    advance, options = event_driven.advance, event_driven.Options(tolerance=1e-13)
    tally = record.new(state.size)
    assert advance(walker, PLATE, contact, options, state, duration, tally) == OK
    assert tally.counts[0] == (3 if name.startswith("bounces") else 1)
    found = state[[X, Y, PITCH]]
    # 1e-9 mm and rad; rates carry the legs' frequency of 1e4 rad/s
    np.testing.assert_allclose(found, p[:3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        state[[ANGLE_BACK, ANGLE_FRONT]], p[[5, 8]] - p[2], rtol=0, atol=1e-9
    )
    np.testing.assert_allclose(state[[V_X, V_Y, SPIN]], v[:3], rtol=0, atol=1e-6)


@both
@pytest.mark.parametrize(
    ("tilt", "kind", "contact"),
    [
        (10, "flexible", Contact(0.3, 0.25, Law.POISSON)),
        (20, "flexible", Contact(0.0, 0.25, Law.STRONGE)),
        (10, "braced", Contact(0.5, 0.25, Law.POISSON)),
    ],
)
def test_energy_balance_closes(method, tilt, kind, contact):
    walker = walker_at(tilt, kind)
    state = new_state(walker, PLATE, 0.05, 0.002, 1.0)
    before = energy(walker, state)
    status, tally = run(method, walker, contact, state, 0.1)
    sums = tally.sums
    lost = sums[record.IMPACT_LOSS] + sums[record.FRICTION_LOSS] + sums[record.DAMPING_LOSS]
    assert status == OK
    assert sums[record.PLATE_WORK] > 100.0
    # events: the snap of 1e-3 mm/s and the projection; steps: second order in h
    share = 1e-5 if method == "events" else 2e-2
    assert energy(walker, state) - before == pytest.approx(
        sums[record.PLATE_WORK] - lost, abs=share * sums[record.PLATE_WORK]
    )


@both
def test_mirror_image_runs_backwards(method):
    walker, mirrored = walker_at(15), walker_at(-15)
    state = new_state(walker, PLATE, 0.03, 0.004, 1.0)
    state[V_X], state[ANGLE_BACK] = 12.0, 1e-3
    image = state.copy()
    for index in (X, V_X, PITCH, SPIN):
        image[index] *= -1.0
    image[[ANGLE_BACK, ANGLE_FRONT]] = -state[[ANGLE_FRONT, ANGLE_BACK]]
    for who, where in ((walker, state), (mirrored, image)):
        assert run(method, who, Contact(0.4, 0.25, 0), where, 0.012)[0] == OK
    # 1e-6 mm: rounding grown by the chaos of two landings (e-fold within 4-13 ms)
    np.testing.assert_allclose(image[[X, Y, PITCH]], state[[X, Y, PITCH]] * [-1, 1, -1], atol=1e-6)


@both
@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_symmetric_walker_that_lands_on_both_feet_does_not_drift(method, restitution):
    walker = walker_at(0)
    state = new_state(walker, PLATE, 0.03, 0.0, 1.0)
    status, _ = run(method, walker, Contact(restitution, 0.25, 0), state, 0.05)
    assert status == OK
    assert abs(state[X]) < 1e-7  # rounding, grown over four landings


@both
@pytest.mark.parametrize(("friction", "law"), [(0.25, 0), (1e3, 0), (0.25, 1), (0.25, 2)])
def test_no_foot_enters_the_plate_and_impulses_stay_in_the_cone(method, friction, law):
    walker = walker_at(10)
    state = new_state(walker, PLATE, 0.05, 0.002, 1.0)
    status, tally = run(
        method, walker, Contact(0.5, friction, law), state, 0.06,
        sample_interval=5e-4, event_room=4000,
    )  # fmt: skip
    assert status == OK
    depth = 0.0
    for row in tally.samples.rows[: tally.samples.cursor[0]]:
        depth = min(depth, *gaps(PLATE, row[1:], chain_of(walker, row[1:], 0.0)))
    # events: rounding; steps: a dip within one step, a h^2 / 8 with a up to 1e6 mm/s^2
    assert depth > (-1e-11 if method == "events" else -2e-5)
    impacts = tally.events.rows[: tally.events.cursor[0]]
    assert len(impacts) > 10
    assert np.all(np.abs(impacts[:, 2]) <= friction * impacts[:, 3] * (1 + 1e-12))


@both
@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_below_one_g_it_never_leaves_the_plate(method, kind):
    walker, plate = walker_at(10, kind), plate_of(0.9)
    state = new_state(walker, plate, 0.0)
    contact = Contact(0.5, 0.25, 0)
    # legs that are let go from their relaxed angle first bounce for a while
    assert run(method, damped(walker), contact, state, 0.1, plate)[0] == OK
    status, tally = run(method, damped(walker), contact, state, 0.05, plate)
    assert status == OK
    assert tally.sums[record.CONTACT_TIME] == pytest.approx(0.05, abs=1e-9)
    assert state[MODE_BACK] != 0
    assert state[MODE_FRONT] != 0


def damped(walker):
    return walker if walker.legs is None else stiff(walker, 1.0, 1.0)


@both
def test_resting_walker_on_stiffer_legs_approaches_the_braced_one(method):
    """Static deflection without friction in proportion to 1 / k_t."""
    sunk = []
    for factor in (1e2, 1e4):
        walker, plate = stiff(walker_at(20), factor, 1.0), plate_of(0.0)
        state = new_state(walker, plate, 0.0)
        height = state[Y]
        assert run(method, walker, Contact(0.0, 0.0, 0), state, 0.03, plate)[0] == OK
        sunk.append(height - state[Y])
    legs, reach = walker.legs, 7.5 * math.sin(math.radians(20))
    load = 0.5 * walker.mass * G
    # both feet alike up to the legs' own weight and the shift of the load, a few per cent
    assert sunk[0] == pytest.approx(load * reach**2 * 1e2 / legs.stiffness, rel=0.2)
    assert sunk[0] / sunk[1] == pytest.approx(100.0, rel=1e-2)  # the rest: finite angles


@both
def test_weak_legs_fold_and_a_tipped_walker_topples(method):
    soft = stiff(walker_at(35), 1e-5, 1.0)
    state = new_state(soft, plate_of(0.0), 0.0)
    assert run(method, soft, Contact(0.0, 0.25, 0), state, 0.5, plate_of(0.0))[0] in (
        FOLDED,
        TOPPLED,
    )
    walker = walker_at(10)
    state = new_state(walker, PLATE, 0.1, 0.5, 0.0)
    state[SPIN] = 20.0
    assert run(method, walker, Contact(0.3, 0.25, 0), state, 0.5)[0] == TOPPLED


@both
@pytest.mark.parametrize(
    ("gamma", "contact", "ratio"),
    [
        (50.0, Contact(0.8, 0.25, 0), 0.05),
        (1.8, Contact(1.0, 0.0, 0), 0.0),
        (1.8, Contact(0.0, 1e3, 0), 3.0),
        (1.0 + 1e-9, Contact(0.5, 0.25, 1), 0.05),
    ],
)
def test_hard_cases_stay_finite(method, gamma, contact, ratio):
    walker, plate = stiff(walker_at(10), 1.0, ratio), plate_of(gamma)
    state = new_state(walker, plate, -1e-12, 0.0, 0.1)
    status, _ = run(method, walker, contact, state, 0.03, plate)
    assert status in (OK, TOPPLED)
    assert np.all(np.isfinite(state))
    assert 0.0 <= state[PHASE] < 2.0 * math.pi


@both
def test_without_friction_nothing_moves_the_centre_of_mass_sideways(method):
    walker = walker_at(20)
    state = new_state(walker, PLATE, 0.03, 0.01, 1.0)
    run(method, walker, Contact(0.5, 0.0, 0), state, 0.05)
    rival = Rival(walker, PLATE)
    _, v = rival.coordinates(state)
    momentum = rival.masses[[0, 3, 6]] @ v[[0, 3, 6]]
    # g mm/s; events: rounding; steps: the legs' turn within a step, second order in h
    assert abs(momentum) < (1e-9 if method == "events" else 2e-3)


@both
def test_two_halves_make_a_whole(method):
    walker, contact = walker_at(10), Contact(0.3, 0.25, 0)
    whole = new_state(walker, PLATE, 0.01, 0.002, 1.0)
    halves = whole.copy()
    run(method, walker, contact, whole, 8e-3)
    for _ in range(2):
        run(method, walker, contact, halves, 4e-3)
    # events: tolerance; steps: the cut of one step, third order in h
    np.testing.assert_allclose(halves, whole, rtol=0, atol=1e-5 if method == "events" else 1e-2)
