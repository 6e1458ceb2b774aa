"""Numbers of one film of a crowd that published work speaks of, each 0 where chance alone rules.

Means of |m| over few walkers are large by chance; those over pairs of different walkers are not,
and are what stands here.
"""

import math

import numpy as np
import numpy.typing as npt

from walkergen.crowd.statistics import CrowdFilm
from walkergen.crowd.statistics import order as orders

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

LAG_S = 0.1
"""Time over which a walker's velocity is its displacement, s: some periods of the plate."""


def order(film: CrowdFilm) -> float:
    """Polar order: mean cosine between the headings of two walkers, 0 by chance, at most 1."""
    count = film.x.shape[1]
    return float((count * (orders.polar(film) ** 2).mean() - 1.0) / (count - 1.0))


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


def speed(film: CrowdFilm) -> float:
    """Mean speed over LAG_S, mm/s, of all walkers."""
    return float(np.abs(velocities(film)[0]).mean())


def agreement(film: CrowdFilm, reach: float) -> float:
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
