"""A corner that slides along and across together, against DOP853 (docs/physics.md section 7)."""

import math

import numpy as np
import pytest
from corner_rival import Corner, Rival, land

from walkergen.core.simulation import record
from walkergen.core.simulation.space.tips import stretch_directions

MOBILITY = np.array([[2.31, 0.9, 0.4], [0.9, 2.3, 0.3], [0.4, 0.3, 2.0]])
"""Inverse mass of a corner: normal, along, across, 1/g."""

SPRING, MU = 1.8e9, 0.25
RIGID, SOFT = math.inf, 1.8e8
"""Hertz stiffness of the tips; the soft one is 0.7 % as stiff as the leg under the largest load."""

FREQUENCY = {RIGID: math.sqrt(SPRING * MOBILITY[0, 0]), SOFT: 5.2e3}
"""Angular frequency of the corner pressed most, 1/s."""


def corner_of(tip, ratio):
    """Corner with a tip and a damping ratio."""
    return Corner(MOBILITY, SPRING, tip, 2.0 * ratio / math.sqrt(MOBILITY[0, 0]), friction=MU)


def step_of(tip):
    return 0.6 / FREQUENCY[tip]


CASES = [(3.0, -4.0), (12.0, 5.0), (-6.0, 20.0), (30.0, -1.0), (1.0, 1.0)]


DAMPED = pytest.mark.parametrize("ratio", [0.0, 0.6], ids=["elastic", "damped"])
TIPS = pytest.mark.parametrize("tip", [RIGID, SOFT], ids=["rigid", "soft"])


@TIPS
@DAMPED
@pytest.mark.parametrize("slip", CASES)
def test_corner_sliding_in_two_directions_lands_as_by_dop853(slip, ratio, tip):
    """A stretch that turns at half the rate has 0.615 across for 0.275 in the first case."""
    corner, velocity = corner_of(tip, ratio), np.array([-40.0, *slip])
    _, expected = Rival(corner).land(velocity)
    found = [land(corner, velocity, step_of(tip) / 64.0, part).impulse for part in (0.2, 0.7)]
    # 1e-4: second order, 1 to 10 % at the step itself
    np.testing.assert_allclose(found, [expected] * 2, atol=1e-4 * expected[0])


@TIPS
@DAMPED
def test_landing_and_sliding_err_by_second_order(ratio, tip):
    """Worst over the places in a step at which the corner touches; five halvings.

    The damper of a Hertzian tip begins as depth^(1/4), whose slope is infinite: the first step errs by h^(5/4), 4 % of
    its damper's impulse, which shows from a tenth of the own step on.
    """
    corner, velocity = corner_of(tip, ratio), np.array([-40.0, 3.0, -4.0])
    _, expected = Rival(corner).land(velocity)
    parts = (np.arange(8) + 0.5) / 8.0
    worst = [
        max(np.abs(land(corner, velocity, step_of(tip) / n, part).impulse - expected).max() for part in parts)
        for n in (4, 8, 16, 32, 64, 128)
    ]
    assert worst[0] < 2e-3 * expected[0]
    slope = np.polyfit(np.log([4, 8, 16, 32, 64, 128]), np.log(worst), 1)[0]
    assert slope == pytest.approx(-2.0, abs=0.15) or (tip == SOFT and ratio > 0.0 and slope < -1.2)


def test_energy_of_a_landing_is_booked_whole():
    velocity = np.array([-40.0, 3.0, -4.0])
    for ratio in (0.0, 0.5):
        found = land(corner_of(RIGID, ratio), velocity, step_of(RIGID) / 4, 0.4)
        # rounding: what springs, damper and slider take is booked from the forces themselves
        assert found.sums.sum() == pytest.approx(found.lost, rel=1e-12)
        found = land(corner_of(SOFT, ratio), velocity, step_of(SOFT) / 4, 0.4)
        # 1e-2: the tip's spring is its tangent in a step, second order (test_tips.py)
        assert found.sums.sum() == pytest.approx(found.lost, rel=1e-2)
        assert found.sums[record.FRICTION_LOSS] > 0.0


@pytest.mark.parametrize("lag_deg", [5.0, 40.0, 80.0])
def test_stretch_lags_behind_a_turning_slip_by_its_equation(lag_deg):
    """On a circular drive n' = (u - (u.n) n) / R has the steady lag sin(lag) = rate R / |u|."""
    errors = []
    for steps in (50, 200):
        angle, n, radius, speed = 0.0, (1.0, 0.0), 1e-4, 10.0
        rate = math.sin(math.radians(lag_deg)) * speed / radius
        h = 2.0 * math.pi / rate / steps
        for _ in range(40 * steps):
            middle = angle + 0.5 * rate * h
            u = speed * math.cos(middle), speed * math.sin(middle)
            n = stretch_directions(radius * n[0], radius * n[1], *u, 0.5 * h, radius)[2:]
            angle += rate * h
        behind = math.remainder(angle - math.atan2(n[1], n[0]), 2.0 * math.pi)
        errors.append(abs(behind - math.radians(lag_deg)))
    assert errors[0] < 0.05
    assert errors[1] < 0.1 * errors[0] + 1e-9  # 1/16 for second order


def test_stretch_inside_its_circle_moves_freely_and_then_along_its_edge():
    u, radius = (3.0, 4.0), 1.0
    assert stretch_directions(0.0, 0.0, *u, 0.1, radius) == pytest.approx((0.6, 0.8) * 2)
    # half a radius back through the circle, then out of it at the other side
    there = stretch_directions(-1.0, 0.0, 1.0, 0.0, 1.5, radius)
    assert there == pytest.approx((1.0, 0.0, 1.0, 0.0))
    assert stretch_directions(-1.0, 0.0, 1.0, 0.0, 0.5, radius)[:2] == pytest.approx((-1.0, 0.0))
    assert stretch_directions(0.0, 1.0, 5.0, 0.0, 1e3, radius) == pytest.approx((1.0, 0.0) * 2)
    assert stretch_directions(0.0, 0.0, 0.0, 0.0, 1.0, radius) == (0.0, 0.0, 0.0, 0.0)
