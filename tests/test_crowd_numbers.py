"""Numbers of crowds that published work speaks of: known crowds, and none where chance rules."""

import math

import numpy as np
import pytest

from evidence.crowds_published import numbers
from evidence.crowds_published.published import FINDINGS
from walkergen.crowd.statistics.film import NO_OUTLINES, of_places
from walkergen.dish import parse


def crowd(place, heading, dish="disc:200", interval=0.02):
    """Film of walkers at places x + iy (mm), shape (times, walkers)."""
    poses = np.zeros((*place.shape, 6))
    poses[..., 0], poses[..., 1], poses[..., 2] = place.real, place.imag, heading
    times = np.arange(len(place)) * interval
    return of_places(times, poses, ("walker",) * place.shape[1], NO_OUTLINES, parse(dish))


def turning(count=5, rate=0.3, radius=40.0, own=0.0):
    """Walkers on a circle about the middle, headed along it."""
    times = 0.02 * np.arange(100)
    angle = rate * times[:, None] + 2.0 * math.pi * np.arange(count) / count + own
    return crowd(radius * np.exp(1j * angle), angle + math.copysign(0.5 * math.pi, rate))


def straggling(seed, count=6, times=400):
    """Walkers that step at random, headed at random."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(times, count, 2)) @ [1.0, 1j]
    return crowd(np.cumsum(steps, axis=0), rng.uniform(-math.pi, math.pi, (times, count)))


def test_walkers_that_run_as_one_are_in_order_and_agree():
    times = 0.02 * np.arange(50)
    place = 60.0 * times[:, None] * np.exp(0.4j) + np.array([0.0, 10.0, 10j])
    run = crowd(place, np.full(place.shape, 0.4))
    assert numbers.order(run) == pytest.approx(1.0)
    assert numbers.agreement(run, 20.0) == pytest.approx(1.0)
    assert numbers.speed(run) == pytest.approx(60.0)


@pytest.mark.parametrize("rate", [0.3, -0.3])
def test_walkers_round_the_middle_circulate_and_are_in_no_order(rate):
    run = turning(rate=rate)
    assert numbers.circulation(run) == pytest.approx(1.0, abs=1e-3)
    assert numbers.order(run) == pytest.approx(-0.25)  # five headings that add up to nothing
    assert numbers.speed(run) == pytest.approx(0.3 * 40.0, rel=1e-3)


def test_chance_is_no_order_no_circulation_and_no_agreement():
    found = [straggling(seed) for seed in range(12)]
    for number in (numbers.order, lambda run: numbers.agreement(run, 1e9)):
        values = np.array([number(run) for run in found])
        assert abs(values.mean()) < 4.0 * values.std(ddof=1) / math.sqrt(len(values))
    squares = np.array([math.copysign(value**2, value) for value in map(numbers.circulation, found)])
    assert abs(squares.mean()) < 4.0 * squares.std(ddof=1) / math.sqrt(len(squares))


def test_neighbours_across_the_edge_of_a_periodic_square_count():
    times = 0.02 * np.arange(20)
    place = 10.0 * times[:, None] + np.array([-49.0, 49.0])
    heading = np.zeros(place.shape)
    assert math.isnan(numbers.agreement(crowd(place, heading), 5.0))
    across = crowd(place, heading, "periodic:100")
    assert numbers.agreement(across, 5.0) == pytest.approx(1.0)


def test_every_statement_has_a_source_that_was_read_or_no_number():
    for finding in FINDINGS.values():
        assert finding.source.read
        assert finding.source.address.startswith("https://")
        for value in finding.values:
            said = finding.quote.replace("0.36 cm", "3.6 cm").replace("0.25 cm", "2.5 cm")
            assert f"{value:g}" in said, f"{finding.key}: {value:g} is not in the words quoted"
