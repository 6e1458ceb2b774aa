"""Sums over all pairs of samples a lag apart, with gaps (NaN) allowed, by fast Fourier transform.

Sums and numbers of pairs are separate, so that those of tracks, and of pieces of tracks, add up. `free_time` is the
time (samples) after each sample before a wall can be reached, `lags` are in samples.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy import fft

from walkergen.core.numerics import Array, Complex, Mask, Whole


@functools.cache
def fft_length(size: int) -> int:
    """Return the least length >= `size` with only the prime factors 2, 3 and 5, which transforms quickly."""
    powers = (three * five for three in 3 ** np.arange(21) for five in 5 ** np.arange(14) if three * five < 2 * size)
    return min(int(power) << max(math.ceil(math.log2(size / power)), 0) for power in powers)


def sum_squares(position: Array, lags: Whole) -> tuple[Array, Array]:
    """Compute the sum of |r(t + lag) - r(t)|^2 and the number of pairs, each of shape (lags,).

    `position` has shape (times, dimensions), `lags` are in samples. The mean drift is removed before the transforms
    and added back afterwards, so that digits are lost to the spread about it, not to the length of the
    run: relative errors stay near 1e-16 (spread / displacement)^2 (after Calandrini et al. 2011).
    """
    seen: Mask = ~np.isnan(position.sum(axis=1))
    reachable = lags < len(position)
    total, pairs = np.zeros(len(lags)), np.zeros(len(lags))
    if seen.sum() < 2:
        return total, pairs
    near = lags[reachable]
    times = np.arange(len(position), dtype=float)
    first, last = np.flatnonzero(seen)[[0, -1]]
    drift = (position[last] - position[first]) / (last - first)
    about_drift = position - drift * times[:, None]
    about_drift = np.where(seen[:, None], about_drift - about_drift[seen].mean(axis=0), 0.0)
    size = fft_length(2 * len(position))
    weight = fft.rfft(seen.astype(float), size)

    def correlate(left: Complex, right: Complex) -> Array:
        """Return the cross-correlation of two series at the lags, from their transforms."""
        product: Array = fft.irfft(np.conj(left) * right, size)[near]
        return product

    count = np.rint(correlate(weight, weight))
    sums = np.zeros(len(near))
    for axis in range(position.shape[1]):
        values, squared = (fft.rfft(about_drift[:, axis] ** power, size) for power in (1, 2))
        spread = correlate(weight, squared) + correlate(squared, weight) - 2 * correlate(values, values)
        shift = correlate(weight, values) - correlate(values, weight)
        run = drift[axis] * near
        sums += spread + run * (2 * shift + run * count)
    total[reachable], pairs[reachable] = np.maximum(sums, 0.0), count
    return total, pairs


def sum_products(series: Complex, lags: Whole) -> tuple[Complex, Array]:
    """Compute the sum of conj(z(t)) z(t + lag) and the number of pairs, each of shape (lags,).

    `series` has shape (times,) and values of order 1: errors are near 1e-16 times their number.
    """
    return sum_cross_products(series, series, lags)


def sum_cross_products(first: Complex, second: Complex, lags: Whole) -> tuple[Complex, Array]:
    """Compute sums of conj(first(t)) second(t + lag) and numbers of pairs by lag, of series of the same length."""
    reachable = lags < len(first)
    total, pairs = np.zeros(len(lags), complex), np.zeros(len(lags))
    near = lags[reachable]
    if not len(near):
        return total, pairs
    size = fft_length(2 * len(first))

    def transform(series: Complex) -> tuple[Complex, Complex]:
        """Return the transforms of a series, with 0 for NaN, and of its mask: 1 where it is known, else 0."""
        seen = ~np.isnan(series)
        return fft.fft(np.where(seen, series, 0.0), size), fft.fft(seen.astype(float), size)

    values, weight = transform(first)
    others, weights = (values, weight) if second is first else transform(second)
    total[reachable] = fft.ifft(np.conj(values) * others)[near]
    pairs[reachable] = np.rint(fft.ifft(np.conj(weight) * weights).real[near])
    return total, pairs


def sum_free_pairs(
    values_at: Callable[[int], npt.NDArray[Any]], lags: Whole, free_time: Whole
) -> tuple[npt.NDArray[Any], Array]:
    """Sum the values at a lag of pairs with `free_time` >= lag; return sums and numbers of pairs by lag."""
    sums, counts = [], []
    for lag in map(int, lags):
        values = values_at(lag)
        values = values[(free_time[: len(values)] >= lag) & ~np.isnan(values)]
        sums.append(values.sum())
        counts.append(float(len(values)))
    return np.array(sums), np.array(counts)


def log_spaced_lags(longest: int, count: int, shortest: int = 1) -> Whole:
    """Return at most `count` whole lags from `shortest` to `longest`, even on a logarithmic scale."""
    if longest < shortest:
        return np.zeros(0, np.int64)
    return np.unique(np.rint(np.geomspace(shortest, longest, count)).astype(np.int64))
