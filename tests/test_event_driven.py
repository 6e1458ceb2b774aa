"""Laws of the event-driven simulator: flight, sustained contact, and the run as a whole."""

import math

import mpmath
import numpy as np
import pytest
from worlds import go, level_state, relaxed_walker, relaxed_world, shaken

from walkergen.scene import GRAVITY
from walkergen.simulation import drive, record
from walkergen.simulation.world import FAILED, OK, PHASE, PITCH, SPIN, V_Y, Contact, X, Y


def gaps(w, plate, state):
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    h = drive.height(plate, state[PHASE])
    return [state[Y] + d[1] * cos + d[0] * sin - h for d in w.feet]


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
    w, plate = relaxed_walker(), shaken(3.0)
    state = level_state(w, plate, phase=0.7, gap=0.3)
    go(w, plate, Contact(0.8, 0.0, 0), state, 0.08)
    y, v, bounces = reference_ball(3, mpmath.mpf(0.8), mpmath.mpf(0.3), mpmath.mpf(0.7), 0.08)
    assert bounces >= 4
    # rounding of 1e-15, multiplied by at most ten per bounce
    assert state[Y] - 9.0 == pytest.approx(float(y), abs=1e-9)
    assert state[V_Y] == pytest.approx(float(v), abs=1e-6)


def test_two_calls_agree_with_one():
    w, plate = relaxed_walker(10.0, flexible=True), shaken(1.8)
    one = level_state(w, plate, 1.0, gap=0.05)
    one[SPIN] = 0.7
    two = one.copy()
    go(w, plate, Contact(0.9, 0.1, 0), one, 0.02)
    for part in (0.0071, 0.0029, 0.01):
        go(w, plate, Contact(0.9, 0.1, 0), two, part)
    assert two == pytest.approx(one, abs=1e-8)  # tolerance of the rocking integrator


def test_samples_and_events_do_not_disturb_and_obey_the_laws():
    w, plate, contact = relaxed_walker(10.0, flexible=True), shaken(1.8), Contact(0.9, 0.1, 0)
    plain = level_state(w, plate, 1.0, gap=0.05)
    plain[SPIN] = 0.7
    state = plain.copy()
    go(w, plate, contact, plain, 0.5)
    tally = record.new(9, 0.5, 1e-4, 4000)
    go(w, plate, contact, state, 0.5, tally=tally)
    assert np.array_equal(state, plain)
    rows = tally.samples.rows[: tally.samples.cursor[0]]
    assert len(rows) == 5001
    lowest = min(min(gaps(w, plate, row[1:])) for row in rows)
    assert lowest >= -20 * relaxed_world(w, plate, contact).options.gap_tolerance
    events = tally.events.rows[: tally.events.cursor[0]]
    assert len(events) > 50
    assert np.all(events[:, 3] > 0)
    assert np.all(np.abs(events[:, 2]) <= 0.1 * events[:, 3] * (1 + 1e-12))
    assert np.all(events[:, 5] < 0)
    assert np.all(np.diff(events[:, 0]) >= 0)


def test_braced_walker_makes_no_way():
    """docs/physics.md section 5: below 2 mm/s always."""
    w, plate = relaxed_walker(10.0), shaken(1.8)
    state = level_state(w, plate, 1.0, gap=0.05)
    state[SPIN] = 0.7
    status, tally = go(w, plate, Contact(0.8, 0.25, 0), state, 500.0)
    assert status == OK
    assert abs(state[X] / 500.0) < 2.0
    assert tally.counts[0] > 10_000
    assert status != FAILED
