"""Numbers of crowds that published work speaks of, each 0 where chance alone rules; and of walkers alone.

Means of |m| over few walkers are large by chance; those over pairs of different walkers are not,
and are what stands here.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from evidence.crowds_published.cases import Case
from walkergen.core.numerics import Array, Complex
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.simulation.run import ENDED_WELL, RunResult
from walkergen.guests.crowd.population import Simulated
from walkergen.guests.crowd.statistics import CrowdFilm
from walkergen.guests.crowd.statistics import order as orders
from walkergen.points.trajectory import sample_rows

LAG_S = 0.1
"""Time over which a walker's velocity is its displacement, s: some periods of the plate."""

SAMPLE_INTERVAL_S = 0.02
"""Time between samples of a walker alone, s."""

NEIGHBOUR_LENGTHS = 1.25
"""Largest distance between neighbours, in lengths of their bodies."""


def crowd_quantities(crowd: Simulated, length: float) -> Mapping[str, Quantity]:
    """Quantities of a crowd of bodies of this length (mm), means over its runs."""
    films, by_run = crowd.films, crowd.statistics.by_run
    own: dict[str, tuple[str, Sequence[float] | Array]] = {
        "order": ("", [polar_order(film) for film in films]),
        "speed": ("mm_s", [mean_speed(film) for film in films]),
        "agreement": ("", [velocity_agreement(film, NEIGHBOUR_LENGTHS * length) for film in films]),
        "clustered": ("", 1.0 - by_run["alone"]),
        "largest": ("", by_run["largest_cluster"]),
        "near": ("", by_run["local_polar_order"]),
    }
    if not films[0].dish.period:
        own["circulation"] = "", [circulation(film) for film in films]
        own["at wall"] = "", by_run["wall_density"]
    return {key: mean(key, unit, values) for key, (unit, values) in own.items() if np.isfinite(values).all()}


def single_quantities(case: Case, results: Sequence[RunResult]) -> Mapping[str, Quantity]:
    """Speed and its spread between prints (mm/s), and the spin: turning x half length / speed."""
    good = [result for result in results if result.outcome in ENDED_WELL]
    if len(good) < 2:
        return {}
    lag, half = round(LAG_S / SAMPLE_INTERVAL_S), 0.5 * case.design.size.length
    paths, spins = [], []
    for result in good:
        rows = sample_rows(result)
        place = rows[:, 1] + 1j * rows[:, 2]
        seconds = float(rows[lag, 0] - rows[0, 0])
        paths.append(float(np.abs(place[lag:] - place[:-lag]).mean() / seconds))
        turn = abs(float(rows[-1, 3] - rows[0, 3])) / float(rows[-1, 0] - rows[0, 0])
        spins.append(half * turn / paths[-1])
    forward = [result.speed for result in good]
    sd, freedom = float(np.std(forward, ddof=1)), len(good) - 1
    return {
        "forward": mean("forward", "mm_s", forward),
        "between prints": Quantity("between prints", "mm_s", sd, sd / math.sqrt(2 * freedom), freedom),
        "speed": mean("speed", "mm_s", paths),
        "spin": mean("spin", "", spins),
    }


def polar_order(film: CrowdFilm) -> float:
    """Polar order: mean cosine between the headings of two walkers, 0 by chance, at most 1."""
    count = film.x.shape[1]
    return float((count * (orders.polar_order(film) ** 2).mean() - 1.0) / (count - 1.0))


def circulation(film: CrowdFilm) -> float:
    """Root of the mean product of how far two walkers go round the dish's middle, signed.

    Of each the sine between its place and its velocity: 1 where all go round one way, 0 by chance.
    """
    velocity, place = velocities(film)
    size = np.abs(velocity) * np.abs(place)
    sines = (np.conj(place) * velocity).imag / np.where(size > 0.0, size, 1.0)
    count = sines.shape[1]
    pairs = (sines.sum(axis=1) ** 2 - (sines**2).sum(axis=1)).mean() / (count * (count - 1))
    return math.copysign(math.sqrt(abs(pairs)), pairs)


def mean_speed(film: CrowdFilm) -> float:
    """Mean speed over LAG_S, mm/s, of all walkers."""
    return float(np.abs(velocities(film)[0]).mean())


def velocity_agreement(film: CrowdFilm, reach: float) -> float:
    """Mean cosine between the velocities of walkers nearer than `reach` (mm); NaN without any."""
    velocity, place = velocities(film)
    direction = velocity / np.where(velocity == 0.0, 1.0, np.abs(velocity))
    one, other = np.triu_indices(place.shape[1], 1)
    apart, period = place[:, one] - place[:, other], film.dish.period
    if period > 0.0:
        apart -= period * (np.round(apart.real / period) + 1j * np.round(apart.imag / period))
    near = np.abs(apart) < reach
    if not near.any():
        return math.nan
    return float((direction[:, one] * np.conj(direction[:, other])).real[near].mean())


def velocities(film: CrowdFilm) -> tuple[Complex, Complex]:
    """Velocities over LAG_S and places midway, as x + iy (mm/s and mm), shape (times, walkers)."""
    step = max(1, round(LAG_S / film.interval))
    place: Complex = film.x + 1j * film.y
    velocity: Complex = (place[step:] - place[:-step]) / (step * film.interval)
    middle: Complex = 0.5 * (place[step:] + place[:-step])
    return velocity, middle
