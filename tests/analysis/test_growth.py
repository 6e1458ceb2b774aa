"""Growth of the squared displacement by known walks: ballistic, diffusive, and persistent ones in between."""

import math

import numpy as np
import pytest

from evidence.reproduce import growth
from walkergen.analysis import persistent_walk
from walkergen.analysis.tracks import Track, Tracks

INTERVAL, LENGTH = 0.004, 2500


def tracks_of(positions, headings=None):
    """Tracks of complex positions (mm), their headings along x where none are given."""
    headings = [np.zeros(len(one)) for one in positions] if headings is None else headings
    pairs = enumerate(zip(positions, headings, strict=True))
    every = (Track(number, np.stack([place.real, place.imag], axis=1), heading) for number, (place, heading) in pairs)
    return Tracks(tuple(every), INTERVAL, 0, "")


def persistent(rate, runs=16, length=LENGTH, speed=10.0):
    """Walks of constant speed (mm/s) whose heading diffuses at a rate (1/s), with their headings.

    Directions decorrelate as exp(-rate t): variance 2 rate t of the heading.
    """
    rng = np.random.default_rng(6)
    turns = rng.normal(scale=math.sqrt(2.0 * rate * INTERVAL), size=(runs, length))
    headings = np.cumsum(turns, axis=1)
    return tracks_of(np.cumsum(speed * INTERVAL * np.exp(1j * headings), axis=1), headings)


def test_a_straight_run_has_the_exponent_two_at_every_lag():
    time = INTERVAL * np.arange(LENGTH)
    grown = growth.measure_growth(tracks_of([speed * time + 0j for speed in (50.0, 60.0, 70.0)]))
    assert grown.exponents.value == pytest.approx(2.0, abs=1e-9)  # rounding of the transforms
    assert (grown.smallest.value, grown.late.value) == (pytest.approx(2.0, abs=1e-9),) * 2
    assert grown.crossover.value is None


def test_a_random_walk_has_the_exponent_one_and_no_crossover():
    steps = np.random.default_rng(1).normal(size=(32, LENGTH, 2)) @ (1.0, 1.0j)
    grown = growth.measure_growth(tracks_of(np.cumsum(steps, axis=1)))
    for exponent in (grown.first, grown.late):
        assert exponent.value == pytest.approx(1.0, abs=4.0 * exponent.se)
        assert exponent.se < 0.2
    assert grown.crossover.value is None  # below halfway from the first lag on


@pytest.mark.parametrize("rate", [2.0, 8.0])
def test_a_persistent_walk_crosses_over_where_its_formula_does(rate):
    lag = np.geomspace(0.01, 10.0, 4001)
    slope = np.gradient(
        np.log(persistent_walk.squared_displacement(lag, persistent_walk.Spread(1.0, rate, 0.0, 0.0))), np.log(lag)
    )
    expected = float(np.interp(-growth.CROSSOVER_EXPONENT, -slope, lag))
    grown = growth.measure_growth(persistent(rate, runs=64))
    # The slope over a quarter of a decade shifts the crossing by less than 3 %
    margin = 3.0 * grown.crossover.se + 0.03 * expected
    assert grown.crossover.value == pytest.approx(expected, abs=margin)
    assert margin < 0.3 * expected
    # To a quarter of 10 s
    squares = persistent_walk.squared_displacement(
        np.array([growth.LATE_LAG_S, 2.5]), persistent_walk.Spread(1.0, rate, 0.0, 0.0)
    )
    late = math.log(squares[1] / squares[0]) / math.log(2.5 / growth.LATE_LAG_S)
    assert grown.late.value == pytest.approx(late, abs=3.0 * grown.late.se + 0.01)
    assert grown.late.se < 0.1


def test_runs_too_short_or_at_rest_have_no_exponents():
    assert growth.measure_growth(tracks_of([np.zeros(LENGTH, complex)] * 3)).first.value is None
    assert not len(growth.measure_growth(tracks_of([np.arange(20.0) + 0j] * 3)).exponents.at)
