"""A corner that slides in two directions at once, against DOP853 (docs/physics.md section 7)."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from walkergen.numerics.kernels import kernel
from walkergen.simulation.space.forces import guess, solve
from walkergen.simulation.space.landings import settle
from walkergen.simulation.space.slider import dragged
from walkergen.simulation.space.state import NEAR, ROW

MOBILITY = np.array([[2.31, 0.9, 0.4], [0.9, 2.3, 0.3], [0.4, 0.3, 2.0]])
"""Inverse mass of a corner: normal, along, across, 1/g."""

NORMAL, TANGENTIAL, MU = 1.8e9, 1.44e9, 0.25
STEP = 0.6 / math.sqrt(NORMAL * MOBILITY[0, 0])


@kernel
def _land(state, near, H, A, h, sums):
    """Step one corner until it leaves, or for so many steps."""
    contact = near[0]
    for step in range(100_000):
        for p in range(3):
            contact.middle[p] += contact.speed[p] - contact.free[p]
            contact.free[p] = contact.speed[p]
        if guess(state, near, H, 1, h, 1.0, 0) > 0:
            solve(near, H, A, 1, h)
        else:
            for p in range(3):
                contact.force[p], contact.middle[p] = 0.0, contact.free[p]
        left = settle(state, near, 0, 0, 1.0, (step + 1) * h, h, sums)
        for p in range(3):
            contact.speed[p] = 2.0 * contact.middle[p] - contact.speed[p]
            contact.impulse[p] += h * contact.force[p]
        if left:
            return True
    return False


def impulse(velocity, damper, h, part):
    """Impulse (normal, along, across) of a landing that begins at a part of a step, by steps."""
    near, sums = np.zeros(1, NEAR), np.zeros(14)
    (contact,) = near
    contact.friction, contact.k_n, contact.k_t, contact.c_n = MU, NORMAL, TANGENTIAL, damper
    contact.speed[:] = contact.free[:] = contact.middle[:] = velocity
    contact.gap[0] = -velocity[0] * h * part
    assert _land(np.zeros(ROW), near, MOBILITY, np.zeros((3, 4)), h, sums)
    np.testing.assert_allclose(contact.speed - velocity, MOBILITY @ contact.impulse, atol=1e-9)
    inverse = np.linalg.inv(MOBILITY)
    lost = 0.5 * (velocity @ inverse @ velocity - contact.speed @ inverse @ contact.speed)
    return contact.impulse.copy(), sums, lost


class Corner:
    """The same by DOP853: phases of sticking and sliding end at events."""

    def __init__(self, damper):
        self.damper = damper

    def press(self, z):
        """Normal force of a state (gap, velocity, stretch, impulse)."""
        return -NORMAL * z[0] - self.damper * z[1]

    def force(self, z, slides):
        """Force of a corner (normal, along, across)."""
        press, stretch = self.press(z), z[4:6]
        size = math.hypot(*stretch)
        rub = MU * press / size * stretch if slides and size > 0.0 else TANGENTIAL * stretch
        return np.array([press, *-rub])

    def slopes(self, z, slides):
        """Time derivative of a state; a sliding stretch keeps to the circle of its limit."""
        force = self.force(z, slides)
        gained, slip = MOBILITY @ force, z[2:4].copy()
        if slides:
            slip -= self.excess(z) * z[4:6] / math.hypot(*z[4:6])
        return np.concatenate([z[1:2], gained, slip, force])

    def excess(self, z):
        """Rate (mm/s) at which the slip would lead the stretch out of the circle."""
        gained = MOBILITY @ self.force(z, True)
        shrinks = (NORMAL * z[1] + self.damper * gained[0]) * MU / TANGENTIAL
        return z[2:4] @ z[4:6] / math.hypot(*z[4:6]) + shrinks

    def impulse(self, velocity):
        """Impulse (normal, along, across) of a landing, to 1e-8 of it."""
        since = -1e-9 / velocity[0]  # s, so that press and stretch have begun
        z = np.array([-1e-9, *velocity, *since * velocity[1:], 0.0, 0.0, 0.0])
        limit = MU * self.press(z) / (TANGENTIAL * math.hypot(*z[4:6]))
        slides = limit < 1.0
        z[4:6] *= min(limit, 1.0)
        for _ in range(50):

            def leaves(t, z, slides=slides):
                return self.press(z) - 1e-7 * NORMAL * 1e-3

            def turns(t, z, slides=slides):
                if slides:
                    return self.excess(z)
                return MU * self.press(z) - TANGENTIAL * math.hypot(*z[4:6])

            leaves.terminal = turns.terminal = True
            leaves.direction = turns.direction = -1.0
            path = solve_ivp(
                lambda t, z, slides=slides: self.slopes(z, slides),
                (0.0, 1.0),
                z,
                "DOP853",
                rtol=1e-10,
                atol=1e-13,
                events=[leaves, turns],
            )
            z = path.y[:, -1]
            if len(path.t_events[0]):
                return z[6:9]
            slides = not slides
        raise AssertionError("no end")


CASES = [(3.0, -4.0), (12.0, 5.0), (-6.0, 20.0), (30.0, -1.0), (1.0, 1.0)]


@pytest.mark.parametrize("damper", [0.0, 0.6], ids=["elastic", "damped"])
@pytest.mark.parametrize("slip", CASES)
def test_corner_sliding_in_two_directions_lands_as_by_dop853(slip, damper):
    """A stretch that turns at half the rate has 0.615 across for 0.275 in the first case."""
    damper *= 2.0 * math.sqrt(NORMAL / MOBILITY[0, 0])
    velocity = np.array([-40.0, *slip])
    expected = Corner(damper).impulse(velocity)
    found = [impulse(velocity, damper, STEP / 64.0, part)[0] for part in (0.2, 0.7)]
    # 1e-4: second order, 1 to 10 % at the step itself
    np.testing.assert_allclose(found, [expected] * 2, atol=1e-4 * expected[0])


@pytest.mark.parametrize("damper", [0.0, 0.6], ids=["elastic", "damped"])
def test_landing_and_sliding_err_by_second_order(damper):
    """Worst over the places in a step at which the corner touches; five halvings."""
    damper *= 2.0 * math.sqrt(NORMAL / MOBILITY[0, 0])
    velocity = np.array([-40.0, 3.0, -4.0])
    expected = Corner(damper).impulse(velocity)
    parts = (np.arange(8) + 0.5) / 8.0
    worst = [
        max(np.abs(impulse(velocity, damper, STEP / n, part)[0] - expected).max() for part in parts)
        for n in (4, 8, 16, 32, 64, 128)
    ]
    slope = np.polyfit(np.log([4, 8, 16, 32, 64, 128]), np.log(worst), 1)[0]
    assert slope == pytest.approx(-2.0, abs=0.15)


def test_energy_of_a_landing_is_booked_whole():
    velocity = np.array([-40.0, 3.0, -4.0])
    for damper in (0.0, 3e4):
        _, sums, lost = impulse(velocity, damper, STEP / 4, 0.4)
        # rounding: what springs, damper and slider take is booked from the forces themselves
        assert sums.sum() == pytest.approx(lost, rel=1e-12)


@pytest.mark.parametrize("lag_deg", [5.0, 40.0, 80.0])
def test_stretch_lags_behind_a_turning_slip_as_its_equation_says(lag_deg):
    """On a circular drive n' = (u - (u.n) n) / R has the steady lag sin(lag) = rate R / |u|."""
    errors = []
    for steps in (50, 200):
        angle, n, radius, speed = 0.0, (1.0, 0.0), 1e-4, 10.0
        rate = math.sin(math.radians(lag_deg)) * speed / radius
        h = 2.0 * math.pi / rate / steps
        for _ in range(40 * steps):
            middle = angle + 0.5 * rate * h
            u = speed * math.cos(middle), speed * math.sin(middle)
            n = dragged(radius * n[0], radius * n[1], *u, 0.5 * h, radius)[2:]
            angle += rate * h
        behind = math.remainder(angle - math.atan2(n[1], n[0]), 2.0 * math.pi)
        errors.append(abs(behind - math.radians(lag_deg)))
    assert errors[0] < 0.05
    assert errors[1] < 0.1 * errors[0] + 1e-9  # 1/16 for second order


def test_stretch_inside_its_circle_moves_freely_and_then_along_its_edge():
    u, radius = (3.0, 4.0), 1.0
    assert dragged(0.0, 0.0, *u, 0.1, radius) == pytest.approx((0.6, 0.8) * 2)
    # half a radius back through the circle, then out of it at the other side
    there = dragged(-1.0, 0.0, 1.0, 0.0, 1.5, radius)
    assert there == pytest.approx((1.0, 0.0, 1.0, 0.0))
    assert dragged(-1.0, 0.0, 1.0, 0.0, 0.5, radius)[:2] == pytest.approx((-1.0, 0.0))
    assert dragged(0.0, 1.0, 5.0, 0.0, 1e3, radius) == pytest.approx((1.0, 0.0) * 2)
    assert dragged(0.0, 0.0, 0.0, 0.0, 1.0, radius) == (0.0, 0.0, 0.0, 0.0)
