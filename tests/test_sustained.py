"""Sustained contact: rocking on one foot and sliding on both, against independent solutions."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from worlds import go, level_state, relaxed_walker, shaken

from walkergen.scene import GRAVITY
from walkergen.simulation import drive, record
from walkergen.simulation.drive import Drive
from walkergen.simulation.effects.harmonic import Harmonic
from walkergen.simulation.relaxed.state import lever
from walkergen.simulation.world import (
    BACKWARD,
    MODE_BACK,
    MODE_FRONT,
    OK,
    OPEN,
    PHASE,
    PITCH,
    SPIN,
    STICK,
    V_X,
    V_Y,
    Contact,
    X,
    Y,
)


def independent_motion(w, plate, friction, slip):
    """Right-hand side with the back foot closed: Newton, Euler and constraints as one system."""

    def derivative(t, q):
        _, _, pitch, v_x, v_y, Omega = q
        sin, cos = math.sin(pitch), math.cos(pitch)
        r_x = w.feet[0][0] * cos - w.feet[0][1] * sin
        r_y = w.feet[0][1] * cos + w.feet[0][0] * sin
        a_p = drive.acceleration(plate, q_phase + plate.omega * t)
        # unknowns a_x, a_y, alpha, F_x, N
        system = np.zeros((5, 5))
        right = np.zeros(5)
        system[0, [0, 3]] = w.mass, -1.0
        system[1, [1, 4]] = w.mass, -1.0
        right[1] = -w.mass * GRAVITY
        system[2, [2, 3, 4]] = w.inertia, r_y, -r_x
        system[3, [1, 2]] = 1.0, r_x
        right[3] = a_p + Omega**2 * r_y
        if slip == 0:
            system[4, [0, 2]] = 1.0, -r_y
            right[4] = Omega**2 * r_x
        else:
            system[4, [3, 4]] = 1.0, slip * friction
        a = np.linalg.solve(system, right)
        return [v_x, v_y, Omega, a[0], a[1], a[2]]

    q_phase = 0.4
    return derivative


@pytest.mark.parametrize(("friction", "slip"), [(3.0, 0), (0.1, -1)])
@pytest.mark.parametrize("gamma", [0.0, 0.5])
def test_rocking_block_follows_an_independent_integration(gamma, friction, slip):
    w = relaxed_walker()
    plate = shaken(gamma)
    state = level_state(w, plate, phase=0.4)
    state[PITCH] = 0.3
    r = lever(w.feet[0], math.sin(0.3), math.cos(0.3))
    state[SPIN] = -3.0
    state[Y] = drive.height(plate, 0.4) - r[1]
    state[V_Y] -= state[SPIN] * r[0]
    state[V_X] = state[SPIN] * r[1] + slip * 60.0
    state[MODE_BACK] = STICK if slip == 0 else BACKWARD
    start = state[:6].copy()
    assert go(w, plate, Contact(0.5, friction, 0), state, 0.03)[0] == OK
    assert (state[MODE_BACK] != OPEN) & (state[MODE_FRONT] == OPEN)
    truth = solve_ivp(
        independent_motion(w, plate, friction, slip), (0.0, 0.03), start, method="DOP853", rtol=1e-12, atol=1e-12
    )
    assert state[:6] == pytest.approx(truth.y[:, -1], abs=1e-8)  # both to about 1e-10


@pytest.mark.slow  # compiles
def test_block_slides_down_a_slope_as_coulomb_says():
    """On both feet of a tilted plate; with a second harmonic, to cover both effects at once."""
    w, slope, mu = relaxed_walker(), 0.4, 0.2
    plate = Drive(shaken(0.4).amplitude, 2 * math.pi * 90, Harmonic(0.1, 0.3))
    state = level_state(w, plate)
    tally = record.new(9)
    assert go(w, plate, Contact(0.0, mu, 0), state, 0.5, slope, tally)[0] == OK
    gained = drive.velocity(plate, state[PHASE]) - drive.velocity(plate, 0.0)
    g_x, g_y = GRAVITY * math.sin(slope), GRAVITY * math.cos(slope)
    assert tally.sums[record.CONTACT_TIME] == pytest.approx(0.5, abs=1e-6)
    assert state[V_X] == pytest.approx((g_x - mu * g_y) * 0.5 - mu * gained, rel=1e-6)
    held = level_state(w, plate)
    assert go(w, plate, Contact(0.0, 1.5, 0), held, 0.5, slope)[0] == OK
    assert abs(held[X]) < 1e-9  # it falls by a rounding before it stands


@pytest.mark.parametrize("restitution", [0.8, 0.9])
def test_a_foot_that_rests_takes_from_the_blows_of_the_other(restitution):
    """Each blow throws the resting foot down; the plate's impulse there leaves e - (1 + e) c^2.

    To lift the body instead left e + (1 + e) c, more than 1: the blows went on for ever.
    """
    w, still = relaxed_walker(**{"legs.contact_spacing_mm": 18.0}), shaken(1e-30)
    x, speed = w.feet[1][0], 6e-4
    own, other = 1.0 / w.mass + x * x / w.inertia, 1.0 / w.mass - x * x / w.inertia
    assert other < 0.0
    state, tally = level_state(w, still), record.new(9, event_room=60)
    state[SPIN] = -speed / (2.0 * x)  # the back foot rises, the front one rests
    state[V_Y] = -x * state[SPIN]
    assert go(w, still, Contact(restitution, 0.0, 0), state, 1e-3, tally=tally)[0] == OK
    blows = tally.events.rows[: tally.events.cursor[0]]
    ratios = blows[1:3, 5] / blows[:2, 5]
    assert (blows[:3, 1] == 0.0).all()
    expected = restitution - (1.0 + restitution) * (other / own) ** 2
    assert ratios == pytest.approx(expected, rel=5e-3)  # heights carry some 1e-13 mm of 1e-11
    assert OPEN not in (state[MODE_BACK], state[MODE_FRONT])
    assert len(blows) < 20
