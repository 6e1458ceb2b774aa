"""Laws of the event-driven simulator: flight, sustained contact, and the run as a whole."""

import math

import mpmath
import numpy as np
import pytest
from level_walker import level_state

from walkergen.simulation import drive as drive
from walkergen.simulation import record
from walkergen.simulation.drive import Contact, Plate
from walkergen.simulation.relaxed import walker as walkers
from walkergen.simulation.relaxed.event_driven import FAILED, OK, advance
from walkergen.simulation.relaxed.walker import OMEGA, PHASE, PITCH, V_X, V_Y, Walker, X, Y
from walkergen.theory.tensors import feet
from walkergen.walker.mass import MassProperties

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
    state = level_state(w, plate, phase=0.7, gap=0.3)
    go(w, plate, Contact(0.8, 0.0, 0), state, 0.08)
    y, v, bounces = reference_ball(3, mpmath.mpf(0.8), mpmath.mpf(0.3), mpmath.mpf(0.7), 0.08)
    assert bounces >= 4
    # rounding of 1e-15, multiplied by at most ten per bounce
    assert state[Y] - 9.0 == pytest.approx(float(y), abs=1e-9)
    assert state[V_Y] == pytest.approx(float(v), abs=1e-6)


def test_two_calls_agree_with_one():
    w, plate = walker(10.0, flexible=True), shaken(1.8)
    one = level_state(w, plate, 1.0, gap=0.05)
    one[OMEGA] = 0.7
    two = one.copy()
    go(w, plate, Contact(0.9, 0.1, 0), one, 0.02)
    for part in (0.0071, 0.0029, 0.01):
        go(w, plate, Contact(0.9, 0.1, 0), two, part)
    assert two == pytest.approx(one, abs=1e-8)  # tolerance of the rocking integrator


def test_samples_and_events_do_not_disturb_and_obey_the_laws():
    w, plate, contact = walker(10.0, flexible=True), shaken(1.8), Contact(0.9, 0.1, 0)
    plain = level_state(w, plate, 1.0, gap=0.05)
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
    state = level_state(w, plate, 1.0, gap=0.05)
    state[OMEGA] = 0.7
    status, tally = go(w, plate, Contact(0.8, 0.25, 0), state, 500.0)
    assert status == OK
    assert abs(state[X] / 500.0) < 2.0
    assert tally.counts[0] > 10_000
    assert status != FAILED
