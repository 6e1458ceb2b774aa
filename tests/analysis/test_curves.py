"""Curves of quantities: tops, lines through zero and how far from them, with errors; types of impacts by hand."""

import math

import numpy as np
import pytest

from evidence import curves
from evidence.landings import QUIET_S
from evidence.reproduce import impact_types
from walkergen.core.numerics.quantity import Quantity


def speeds(values, se=0.1):
    return [Quantity("speed", "mm_s", value, se) for value in values]


def test_a_parabola_gives_its_own_top_and_the_error_of_the_grid():
    tilts = np.array([5.0, 8.0, 12.0, 15.0])
    place, height = curves.top(tilts, speeds(60.0 - (tilts - 11.0) ** 2, 1e-6))
    assert (place.value, height.value) == (pytest.approx(11.0), pytest.approx(60.0))
    assert place.se == pytest.approx(3.5 / math.sqrt(12.0), rel=0.01)


def test_the_tops_error_is_that_of_the_speeds():
    top = curves.top(np.array([5.0, 10.0, 15.0]), speeds((0.0, 90.0, 0.0), 2.0))
    assert top.place.value == 10.0
    assert top.height.se == pytest.approx(2.0, rel=0.05)  # 1.6 % for the draws


def test_a_line_through_zero_is_proportional_and_a_threshold_is_not():
    plate = np.array([10.0, 20.0, 30.0, 40.0])
    assert curves.slope(plate, speeds(2.0 * plate)).value == pytest.approx(2.0)
    assert curves.distance_from_line(plate, speeds(2.0 * plate)).value == pytest.approx(0.0, abs=1e-9)
    # 0, 0, 0, 80: slope 80 x 40/3000, rms distance by hand, in per cent of the mean
    slope = 80.0 * 40.0 / 3000.0
    rms = math.sqrt((slope**2 * 1400.0 + (80.0 - 40.0 * slope) ** 2) / 4.0)
    off = curves.distance_from_line(plate, speeds(80.0 * (plate > 35.0)))
    assert off.value == pytest.approx(100.0 * rms / 20.0)
    assert 0.0 < off.se < 1.0


def test_shares_of_types_by_hand():
    kinds = np.array([3, 3, 2, 1, 5, -2, -3, 4])
    assert impact_types.weighted_shares(kinds, np.ones(8)) == pytest.approx(np.array([2, 1, 1, 1, 1, 2]) / 8)
    weights = np.array([7.0, 0, 0, 1, 0, 0, 0, 0])
    assert impact_types.weighted_shares(kinds, weights)[:3] == pytest.approx([7 / 8, 0.0, 1 / 8])


def test_a_foot_in_space_lands_with_either_corner_once_within_the_quiet_time():
    rows = np.zeros((5, 7))
    # Time of landing, corner; in the order in which the contacts end.
    rows[:, :2] = np.array([(0.1, 1), (0.0, 0), (0.2, 3), (0.2, 2), (3.0, 0)]) * (QUIET_S, 1.0)
    assert list(impact_types.classify_impacts(rows, corners=2).landing) == [False, True, True, False, True]
