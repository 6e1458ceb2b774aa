"""Delay of the velocity behind the heading, caused by inertia.

The delay function is d(t) = <v(t) . e(0)> - <v(0) . e(t)> (C. Scholz, S. Jahanshahi, A. Ldov, H. Loewen, Nat. Commun.
9, 5156, 2018). It is 0 if the velocity follows the heading e without delay, and positive if the velocity is late. Let
the velocity average earlier headings with a mean delay s. Then the integral of d from 0 to t is 2 s (f(0) - f(t)),
where f is the mean of the two correlations. This is exact for an exponential memory as t grows.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.analysis import lag_sums, moments
from walkergen.analysis.estimates import MIN_SAMPLES
from walkergen.analysis.motion import Curve
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core import Array, Complex, Quantity, Whole, jackknife_error

CUTOFF_SHARE = 0.5
"""Share of the correlation at lag 0 below which the integral of the delay function ends."""

MIN_PIECES = 16
"""Smallest number of samples into which the tracks of few walkers are cut."""

MAX_LAGS = 4000


class Delay(NamedTuple):
    """Delay of the velocity behind the heading."""

    mean: Quantity
    """Mean delay, s; refused where headings do not turn or data are too few."""
    until: float
    """Upper limit of the integral of the delay function, s."""
    function: Curve
    """Delay function by lag, mm/s."""


def measure(tracks: Tracks) -> Delay:
    """Measure the delay function of tracks with headings, and the mean delay, with a jackknife over walkers."""
    series = [_velocities_and_headings(track, tracks.interval) for track in tracks.tracks if _has_heading(track)]
    if len(series) < moments.MIN_PARTICLES:
        cuts = math.ceil(MIN_PIECES / max(len(series), 1))
        series = [
            (velocity, unit)
            for velocities, headings in series
            for velocity, unit in zip(np.array_split(velocities, cuts), _split_headings(headings, cuts), strict=True)
        ]
    longest = max((len(velocity) for velocity, _ in series), default=0) // 4
    empty = np.zeros(0)
    if len(series) < MIN_SAMPLES or longest < 4:
        reason = f"{len(series)} independent samples, but at least {MIN_SAMPLES} are needed. Film for longer"
        return Delay(Quantity("delay", "s", None, refused=reason), math.nan, Curve(empty, empty, empty))
    lags = np.arange(min(longest, MAX_LAGS), dtype=np.int64)
    sums = np.array([_correlation_sums(velocity, unit, lags) for velocity, unit in series])
    total = sums.sum(axis=0)
    # Of all samples, then without each in turn
    correlations = np.array([_correlations(each) for each in (total, *(total - left_out for left_out in sums))])
    functions = correlations[:, 0] - correlations[:, 1]
    mean = correlations.mean(axis=1)
    at_zero_lag = 1.5 * mean[:, 0] - 0.5 * mean[:, 1]
    below_cutoff = np.flatnonzero(mean[0] < CUTOFF_SHARE * at_zero_lag[0])
    end = max(int(below_cutoff[0]), 2) if len(below_cutoff) else len(lags) - 1
    lost = at_zero_lag - 0.5 * (mean[:, end] + mean[:, end - 1])
    areas = tracks.interval * functions[:, :end].sum(axis=1)
    curve = Curve(tracks.interval * (lags.astype(float) + 0.5), functions[0], jackknife_error(functions[1:]))
    return Delay(_mean_delay(areas, lost), end * tracks.interval, curve)


def inertial_delay_function(lag: Array, speed: float, diffusion: float, turning: float, relaxation: float) -> Array:
    """Compute the delay function (mm/s) of a particle with inertia, whose turning has no memory.

    Parameters
    ----------
    lag : ndarray
        Lags, s.
    speed : float
        Speed that propulsion alone would give, mm/s.
    diffusion : float
        Rotational diffusion of the heading, rad^2/s.
    turning : float
        Mean turning rate, rad/s.
    relaxation : float
        Relaxation time of the velocity (> 0), s.
    """
    decay = complex(diffusion, -turning)
    heading_memory, velocity_memory = np.exp(-decay * lag), np.exp(-lag / relaxation)
    velocity_first = heading_memory / (1.0 + decay * relaxation)
    heading_first = (heading_memory - velocity_memory) / (1.0 - decay * relaxation)
    heading_first = heading_first + velocity_memory / (1.0 + decay.conjugate() * relaxation)
    return np.asarray(speed * (heading_first - velocity_first).real)


def _mean_delay(areas: Array, lost: Array) -> Quantity:
    """Return the mean delay, half of `areas` / `lost`, with its jackknife error, s.

    `areas`: integrals of the delay function, mm. `lost`: loss of the mean correlation over the same lags, mm/s. Both
    have the value of all n samples first, then those without each sample in turn, shape (n + 1,).
    """
    error = float(jackknife_error(lost[1:, None])[0])
    if not lost[0] > 3.0 * error:
        reason = "headings hardly turn, or there is no speed along them. Film for longer"
        return Quantity("delay", "s", None, refused=reason)
    delays = 0.5 * areas / lost
    se = float(jackknife_error(delays[1:, None])[0])
    return Quantity("delay", "s", float(delays[0]), se, len(delays) - 2.0)


def _has_heading(track: Track) -> bool:
    """Return whether a track has headings and at least one interval."""
    return track.heading is not None and len(track.position) > 1


def _velocities_and_headings(track: Track, interval: float) -> tuple[Complex, Complex]:
    """Return velocities over each interval (mm/s) and unit vectors of the headings, complex numbers x + i y."""
    assert track.heading is not None
    return np.diff(moments.complex_position(track)) / interval, np.exp(1j * track.heading)


def _split_headings(unit: Complex, cuts: int) -> list[Complex]:
    """Split n + 1 headings (unit vectors) into `cuts` pieces; neighbours share one heading, so that n steps remain."""
    parts = np.array_split(np.arange(len(unit) - 1), cuts)
    return [unit[part[0] : part[-1] + 2] if len(part) else unit[:1] for part in parts]


def _correlation_sums(velocity: Complex, unit: Complex, lags: Whole) -> Array:
    """Return four rows, shape (4, lags): sum of v(t) . e(0), its number of pairs, sum of v(0) . e(t), its pairs.

    Velocities are means over an interval: the time between v and e is half an interval more than the lag.
    """
    after, pairs = lag_sums.sum_cross_products(unit[:-1], velocity, lags)
    before, others = lag_sums.sum_cross_products(velocity, unit[1:], lags)
    return np.array([after.real, pairs, before.real, others])


def _correlations(sums: Array) -> Array:
    """Return the means of v(t) . e(0) and v(0) . e(t), shape (2, lags), from the sums of `_correlation_sums`."""
    after, pairs, before, others = sums
    return np.array([after / np.maximum(pairs, 1.0), before / np.maximum(others, 1.0)])
