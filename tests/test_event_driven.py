"""Laws of the event-driven simulator: flight, sustained contact, and the run as a whole."""

import math

import mpmath
import numpy as np
import pytest

from walkergen.mass import MassProperties
from walkergen.simulation import plate as drive
from walkergen.simulation import record
from walkergen.simulation.plate import Contact, Plate
from walkergen.simulation.relaxed import walker as walkers
from walkergen.simulation.relaxed.event_driven import FAILED, INSIDE, OK, TOPPLED, advance
from walkergen.simulation.relaxed.walker import (
    MODE_BACK,
    MODE_FRONT,
    OMEGA,
    PHASE,
    PITCH,
    STICK,
    V_X,
    V_Y,
    FlexibleTensors,
    Walker,
    X,
    Y,
)
from walkergen.theory.tensors import feet

GRAVITY = 9806.65
BODY = 28.0 * 8.0 * 3.0 * 1.24e-3
INERTIA = BODY * (28.0**2 + 9.0) / 12
CORNERS = ((-14.0, -1.5), (14.0, -1.5), (-14.0, 1.5), (14.0, 1.5))
LEVEL = Plate(0.0, 2 * math.pi * 90, None)


def shaken(gamma: float, frequency: float = 90.0) -> Plate:
    omega = 2 * math.pi * frequency
    return Plate(gamma * GRAVITY / omega**2, omega, None)


def walker(tilt_deg: float = 0.0, flexible: bool = False) -> Walker:
    tilt = math.radians(tilt_deg)
    c = 3.75 * np.array([-math.sin(tilt), -math.cos(tilt)])
    a = np.array([-6.5 + 7.5 * math.sin(tilt), -1.5])
    leg = 0.02976
    mass = MassProperties(
        BODY, INERTIA, leg, leg * 7.5**2 / 12, a, a + np.array([13.0, 0.0]), c, c, not flexible
    )
    d_y = float(a[1] + 2 * c[1])
    return walkers.new(
        BODY, INERTIA, (-6.5, d_y), (6.5, d_y), CORNERS, feet(mass) if flexible else None
    )


def go(w, plate, contact, state, duration, slope=None, tally=None):
    tally = record.new(9) if tally is None else tally
    options = walkers.options_for(w, plate, GRAVITY, slope)
    status = advance(w, plate, contact, options, state, duration, tally)
    return status, tally


def energy(w, state):
    return 0.5 * (w.M * (state[V_X] ** 2 + state[V_Y] ** 2) + w.J * state[OMEGA] ** 2) + (
        w.M * GRAVITY * state[Y]
    )


def gaps(w, plate, state):
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    h = drive.height(plate, state[PHASE])
    return [state[Y] + d[1] * cos + d[0] * sin - h for d in (w.d_back, w.d_front)]


# Bouncing


@pytest.mark.slow  # compiles
def test_ball_on_a_resting_plate_keeps_its_energy():
    w, start = walker(), walkers.level_state(walker(), LEVEL, gap=0.1)
    state = start.copy()
    period = 2 * math.sqrt(2 * 0.1 / GRAVITY)
    status, tally = go(w, LEVEL, Contact(1.0, 0.0, 0), state, 1e5 * period)
    assert status == OK
    assert tally.counts[0] == pytest.approx(2e5, abs=4)  # two feet
    rest = w.M * GRAVITY * 9.0
    assert energy(w, state) - rest == pytest.approx(energy(w, start) - rest, rel=1e-9)
    assert state[X] == 0.0
    assert state[PITCH] == 0.0


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9])
def test_bounces_end_at_the_sum_of_their_series_and_rest_costs_nothing(e):
    w = walker()
    state = walkers.level_state(w, LEVEL, gap=0.1)
    status, tally = go(w, LEVEL, Contact(e, 0.0, 0), state, 1e5)
    fall = math.sqrt(2 * 0.1 / GRAVITY)
    end = fall * (1 + e) / (1 - e)
    snap = walkers.options_for(w, LEVEL).snap_speed
    assert status == OK
    # the snap leaves out the last bounces; 1e-10 s of rounding in 1e5 s
    cut = 2 * snap / (GRAVITY * (1 - e)) + 1e-9
    assert 1e5 - tally.sums[record.CONTACT_TIME] == pytest.approx(end, abs=cut)
    assert (state[MODE_BACK], state[MODE_FRONT]) == (STICK, STICK)
    assert tally.counts[0] < 600


def reference_ball(gamma, e, gap, phase, duration):
    """Height over the mean plate and velocity after `duration`, in 30 digits."""
    mpmath.mp.dps = 30
    g, omega = mpmath.mpf(GRAVITY), 2 * mpmath.pi * 90
    A = gamma * g / omega**2
    plate = lambda t: A * mpmath.sin(phase + omega * t)  # noqa: E731
    speed = lambda t: A * omega * mpmath.cos(phase + omega * t)  # noqa: E731
    t0, y0, v0 = mpmath.mpf(0), plate(0) + gap, speed(0)
    bounces = 0
    while True:
        height = lambda t, t0=t0, y0=y0, v0=v0: (  # noqa: E731
            y0 + v0 * (t - t0) - g * (t - t0) ** 2 / 2 - plate(t)
        )
        step, t = mpmath.mpf("1e-5"), t0 + mpmath.mpf("1e-7")
        while t < duration and height(t + step) > 0:
            t += step
        if t >= duration:
            s = duration - t0
            return y0 + v0 * s - g * s**2 / 2, v0 - g * s, bounces
        hit = mpmath.findroot(height, (t, t + step), solver="anderson", tol=1e-40)
        arriving = v0 - g * (hit - t0)
        t0, y0, v0 = hit, plate(hit), speed(hit) - e * (arriving - speed(hit))
        bounces += 1


def test_ball_on_a_moving_plate_follows_thirty_digits():
    w, plate = walker(), shaken(3.0)
    state = walkers.level_state(w, plate, phase=0.7, gap=0.3)
    go(w, plate, Contact(0.8, 0.0, 0), state, 0.08)
    y, v, bounces = reference_ball(3, mpmath.mpf(0.8), mpmath.mpf(0.3), mpmath.mpf(0.7), 0.08)
    assert bounces >= 4
    # rounding of 1e-15, multiplied by at most ten per bounce
    assert state[Y] - 9.0 == pytest.approx(float(y), abs=1e-9)
    assert state[V_Y] == pytest.approx(float(v), abs=1e-6)


@pytest.mark.parametrize("offset", [1e-9, -1e-9])
def test_grazing_contact_is_found_however_short(offset):
    """Plate and foot touch at a double root of the gap; 1e-9 mm decides, for half a microsecond."""
    w, plate = walker(), shaken(3.0)
    touch, before = 1.2, 1.5e-3
    state = walkers.level_state(w, plate, phase=touch, gap=offset)
    state[Y] -= before * (state[V_Y] + 0.5 * GRAVITY * before)
    state[V_Y] += GRAVITY * before
    state[PHASE] -= plate.omega * before
    _, tally = go(w, plate, Contact(0.5, 0.0, 0), state, before + 1e-4)
    assert (tally.counts[0] > 0) == (offset < 0)


@pytest.mark.slow  # compiles
@pytest.mark.parametrize("flexible", [True, False])
def test_below_one_g_the_walker_never_leaves(flexible):
    w, plate = walker(10.0, flexible), shaken(0.999)
    state = walkers.level_state(w, plate)
    status, tally = go(w, plate, Contact(0.9, 0.1, 0), state, 1e4)
    assert status == OK
    assert tally.counts[0] == 0
    assert tally.sums[record.CONTACT_TIME] == pytest.approx(1e4, abs=1e-6)
    assert state[X] == 0.0


@pytest.mark.parametrize("gamma", [1.0, 1 + 1e-9, 1 + 1e-4, 1.8, 50.0])
@pytest.mark.parametrize("flexible", [True, False])
def test_energy_balance_closes_and_feet_stay_out(gamma, flexible):
    rng = np.random.default_rng(int(gamma * 10))
    for friction in (0.0, 0.1, 5.0, 1e3):
        w, plate = walker(10.0, flexible), shaken(gamma)
        for e in (0.0, 0.8, 1.0):
            state = walkers.level_state(w, plate, rng.uniform(0, 6), gap=0.02)
            state[OMEGA] = rng.normal()
            state[V_X] = 10 * rng.normal()
            start = energy(w, state)
            status, tally = go(w, plate, Contact(e, friction, 0), state, 0.3)
            assert status in (OK, TOPPLED)
            assert np.all(np.isfinite(state))
            tolerance = walkers.options_for(w, plate).gap_tolerance
            assert min(gaps(w, plate, state)) >= -20 * tolerance
            s = tally.sums
            losses = s[record.IMPACT_LOSS] + s[record.FRICTION_LOSS]
            turnover = abs(start) + abs(s[record.PLATE_WORK]) + abs(losses)
            # 1e-11 per step of the rocking integrator
            assert energy(w, state) - start == pytest.approx(
                s[record.PLATE_WORK] - losses, abs=1e-9 * turnover
            )


# Symmetries


def mirrored(w: Walker) -> Walker:
    def flip(d):
        return (-d[0], d[1])

    flexible = w.flexible and FlexibleTensors(
        w.flexible.front._replace(xy=-w.flexible.front.xy),
        w.flexible.back._replace(xy=-w.flexible.back.xy),
    )
    corners = tuple(flip(c) for c in (w.corners[1], w.corners[0], w.corners[3], w.corners[2]))
    return w._replace(
        d_back=flip(w.d_front), d_front=flip(w.d_back), corners=corners, flexible=flexible
    )


@pytest.mark.parametrize("flexible", [True, False])
def test_mirror_image_runs_backwards_exactly(flexible):
    plate = shaken(1.8)
    w = walker(10.0, flexible)
    sign = np.array([-1, 1, -1, -1, 1, -1, 1])
    for contact in (Contact(0.9, 0.1, 0), Contact(0.5, 2.0, 2), Contact(0.0, 0.25, 1)):
        state = walkers.level_state(w, plate, 1.0, gap=0.05)
        state[OMEGA], state[V_X] = 0.7, 3.0
        other = state.copy()
        other[:7] *= sign
        go(w, plate, contact, state, 0.4)
        go(mirrored(w), plate, contact, other, 0.4)
        assert abs(state[X]) > 0.0
        assert np.array_equal(other[:7], sign * state[:7])


def test_level_landing_of_a_symmetric_walker_makes_no_drift():
    w, plate = walker(0.0, flexible=True), shaken(1.8)
    state = walkers.level_state(w, plate, gap=0.1)
    go(w, plate, Contact(0.9, 0.1, 0), state, 5.0)
    assert state[X] == 0.0
    assert state[PITCH] == 0.0


def test_shift_by_a_period_changes_nothing():
    w, plate = walker(10.0, flexible=True), shaken(1.8)
    states = [walkers.level_state(w, plate, 1.0, gap=0.05) for _ in range(2)]
    states[1][PHASE] += 2 * math.pi
    for state in states:
        state[OMEGA] = 0.7
        go(w, plate, Contact(0.9, 0.1, 0), state, 0.02)
    assert states[0] == pytest.approx(states[1], abs=1e-9)  # rounding of the phase


def test_two_calls_agree_with_one():
    w, plate = walker(10.0, flexible=True), shaken(1.8)
    one = walkers.level_state(w, plate, 1.0, gap=0.05)
    one[OMEGA] = 0.7
    two = one.copy()
    go(w, plate, Contact(0.9, 0.1, 0), one, 0.02)
    for part in (0.0071, 0.0029, 0.01):
        go(w, plate, Contact(0.9, 0.1, 0), two, part)
    assert two == pytest.approx(one, abs=1e-8)  # tolerance of the rocking integrator


def test_scaled_walker_runs_the_scaled_way():
    """Lengths x 1e-3, times x sqrt(1e-3): the same run in scaled units (tolerances scale too)."""
    w, plate, scale = walker(10.0), shaken(1.8), 1e-3
    time = math.sqrt(scale)
    small = walkers.new(
        w.M,
        w.J * scale**2,
        (w.d_back[0] * scale, w.d_back[1] * scale),
        (w.d_front[0] * scale, w.d_front[1] * scale),
        tuple((c[0] * scale, c[1] * scale) for c in CORNERS),
    )
    small_plate = Plate(plate.amplitude * scale, plate.omega / time, None)
    state = walkers.level_state(w, plate, 1.0, gap=0.05)
    state[OMEGA] = 0.7
    little = walkers.level_state(small, small_plate, 1.0, gap=0.05 * scale)
    little[OMEGA] = 0.7 / time
    go(w, plate, Contact(0.8, 0.25, 0), state, 0.03)
    go(small, small_plate, Contact(0.8, 0.25, 0), little, 0.03 * time)
    units = [scale, scale, 1.0, scale / time, scale / time, 1 / time, 1.0]
    assert little[:7] / units == pytest.approx(state[:7], abs=1e-8)  # rounding, x10 per impact


# Hard starts


def test_start_a_rounding_inside_the_plate_is_a_start_on_it():
    w = walker()
    state = walkers.level_state(w, LEVEL, gap=-1e-12)
    assert go(w, LEVEL, Contact(0.9, 0.1, 0), state, 1.0)[0] == OK
    assert gaps(w, LEVEL, state) == pytest.approx([0.0, 0.0], abs=1e-13)
    deep = walkers.level_state(w, LEVEL, gap=-0.1)
    assert go(w, LEVEL, Contact(0.9, 0.1, 0), deep, 1.0)[0] == INSIDE


def test_falling_over_is_reported_at_the_angle_where_the_corner_touches():
    w = walker(10.0)
    state = walkers.level_state(w, LEVEL, gap=1.0)
    state[OMEGA], state[V_Y] = 20.0, 150.0
    status, tally = go(w, LEVEL, Contact(0.0, 1.0, 0), state, 10.0)
    assert status == TOPPLED
    assert w.safe_pitch == pytest.approx(math.radians(44.6), abs=1e-2)
    assert abs(state[PITCH]) >= w.safe_pitch
    assert tally.sums[record.ELAPSED] < 0.5
    rotate = [walkers.lever(c, math.sin(state[PITCH]), math.cos(state[PITCH])) for c in CORNERS]
    assert state[Y] + min(r[1] for r in rotate) == pytest.approx(0.0, abs=1e-11)


# The record, and known long runs


def test_samples_and_events_do_not_disturb_and_obey_the_laws():
    w, plate, contact = walker(10.0, flexible=True), shaken(1.8), Contact(0.9, 0.1, 0)
    plain = walkers.level_state(w, plate, 1.0, gap=0.05)
    plain[OMEGA] = 0.7
    state = plain.copy()
    go(w, plate, contact, plain, 0.5)
    tally = record.new(9, 0.5, 1e-4, 4000)
    go(w, plate, contact, state, 0.5, tally=tally)
    assert np.array_equal(state, plain)
    rows = tally.samples.rows[: tally.samples.cursor[0]]
    assert len(rows) == 5001
    lowest = min(min(gaps(w, plate, row[1:])) for row in rows)
    assert lowest >= -20 * walkers.options_for(w, plate).gap_tolerance
    events = tally.events.rows[: tally.events.cursor[0]]
    assert len(events) > 50
    assert np.all(events[:, 3] > 0)
    assert np.all(np.abs(events[:, 2]) <= 0.1 * events[:, 3] * (1 + 1e-12))
    assert np.all(events[:, 5] < 0)
    assert np.all(np.diff(events[:, 0]) >= 0)


def test_braced_walker_makes_no_way():
    """physics.md section 5: below 2 mm/s always."""
    w, plate = walker(10.0), shaken(1.8)
    state = walkers.level_state(w, plate, 1.0, gap=0.05)
    state[OMEGA] = 0.7
    status, tally = go(w, plate, Contact(0.8, 0.25, 0), state, 500.0)
    assert status == OK
    assert abs(state[X] / 500.0) < 2.0
    assert tally.counts[0] > 10_000
    assert status != FAILED
