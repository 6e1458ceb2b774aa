"""Loss of direction between walls, from pairs of directions that start where no wall can be reached.

The error follows from the number of independent pairs. If the heading diffuses, squared turns of pairs that overlap by
a share s of their lag have the correlation s^2. The ratio of the correlations at two lags of the same pairs contains no
noise of the places. A pair needs free motion for its lag and for the window of its second direction.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import interval_laws, lag_sums, moments
from walkergen.analysis.estimates import MIN_SAMPLES, Settings, quantity, refusal
from walkergen.analysis.tracks import Track
from walkergen.core.numerics import Array, Mask
from walkergen.core.numerics.distributions import student_quantile
from walkergen.core.numerics.quantity import Quantity

MIN_LAG_RATIO, LAG_COUNT, WINDOW_COUNT = 3, 24, 5
"""Least ratio of a pair's lag to the first one, number of lags, and number of windows, each twice the one before."""

NOISE_CORRELATION = 3.0
"""Number of pairs over that of those whose noise is independent: displacements with a common place have -1/2."""

MAX_LOSS = 1.0
"""Largest loss of direction at a lag, as an exponent: beyond it chance decides."""


class _Pairs(NamedTuple):
    """Pairs of directions at a lag."""

    first: int
    """First lag, samples."""
    lag: int
    sums: Array
    """Sums of each walker that has pairs, shape (walkers, 4): products of directions at the first lag and at `lag`,
    about its own mean turning, the number of pairs, and their correlations."""

    @property
    def lost(self) -> Array:
        """Loss of direction at the first lag and at `lag`, as exponents."""
        return np.asarray(-np.log(self.sums[:, :2].sum(axis=0) / self.sums[:, 2].sum()))

    @property
    def samples(self) -> float:
        """Number of independent pairs, less those that further walkers' mean turning takes."""
        _, _, count, overlaps = self.sums.sum(axis=0)
        return max(float(count**2 / overlaps) - len(self.sums) + 1.0, 1.0 + 1e-9)

    @property
    def rate(self) -> float:
        """Rate of losing direction, 1/sample, with the bias of the mean turning removed."""
        independent = self.samples + len(self.sums) - 1.0
        return float(np.diff(self.lost)[0]) / (self.lag - self.first) * independent / (self.samples - 1.0)

    def exponents(self, rate: float) -> tuple[float, float]:
        """Return the loss of direction by turning at a `rate` (1/sample), and with noise, at the lag."""
        turned = rate * self.lag
        return turned, turned + max(float(self.lost[0]) - rate * self.first, 0.0)

    def error(self, rate: float) -> float:
        """Return the relative standard error of the rate."""
        turned, total = self.exponents(rate)
        growth, noise = math.sinh(min(total, 50.0)) / total, total - turned
        # Noise of the places differs from pair to pair, but neighbouring displacements share some
        of_noise = NOISE_CORRELATION * (4.0 * turned * noise + 2.0 * noise**2) / self.sums[:, 2].sum()
        return float(growth * math.sqrt(2.0 / self.samples + of_noise / turned**2))


def persistence(tracks: Sequence[Track], settings: Settings, speed: Quantity) -> dict[str, Quantity]:
    """Return the rate of losing direction, its time and length, with bounds of a variance, or refused."""
    names = "persistence_rate", "persistence_time", "persistence_length"
    windows = [0] if settings.headed else [settings.grid.step << doubling for doubling in range(WINDOW_COUNT)]
    found = [pairs for window in windows for pairs in _find_pairs(tracks, window)]
    usable = [pairs for pairs in found if pairs.samples >= MIN_SAMPLES and pairs.rate > 0.0]
    if not usable:
        most = f"{max((pairs.samples for pairs in found), default=0.0):.0f} independent pairs of directions"
        reason = f"{most} out of reach of walls; at least {MIN_SAMPLES}: film for longer, or in a larger box"
        return {name: refusal(name, reason) for name in names}
    typical = max(usable, key=lambda pairs: pairs.samples).rate
    best = min(usable, key=lambda pairs: pairs.error(typical) if pairs.lost[1] < MAX_LOSS else math.inf)
    rate, interval = best.rate, settings.interval
    turned, total = best.exponents(rate)
    noise = rate * (total - turned) / turned / interval
    error, widening = _error_over_walkers(best, best.error(rate))
    freedom = max(2.0 * (total / (turned * error * widening)) ** 2 - 1.0, 1.0)
    per_s = quantity(names[0], rate / interval, error * rate / interval, freedom)._replace(noise=noise)
    time = quantity(names[1], interval / rate, error * interval / rate, freedom)._replace(noise=noise, power=-1)
    if per_s.interval() is None or time.interval() is None:
        reason = f"the loss of direction within {best.lag * interval:.3g} s is not resolved: a larger box resolves it"
        return {name: refusal(name, reason) for name in names}
    length = refusal(names[2], "the speed is not resolved")
    if speed.value and speed.se is not None:
        size, share = abs(speed.value) * time.number, math.hypot(error, speed.se / speed.value)
        length = quantity(names[2], size, share * size, freedom)._replace(noise=noise / abs(speed.value), power=-1)
    return dict(zip(names, (per_s, time, length), strict=True))


def _find_pairs(tracks: Sequence[Track], window: int) -> list[_Pairs]:
    """Return pairs at lags from MIN_LAG_RATIO times the first; without headings directions span `window` samples."""
    first, units, reach = window + 1, [], []
    for track in tracks:
        vectors = moments.direction_vectors(track, window)
        sizes = np.abs(vectors)
        units.append(np.divide(vectors, sizes, where=sizes > 0.0, out=np.full_like(vectors, np.nan)))
        assert track.reach is not None
        reach.append(track.reach[: len(vectors)] - window)
    longest = max((int(each.max(initial=0)) for each in reach), default=0)
    found = []
    for lag in map(int, lag_sums.log_spaced_lags(longest, LAG_COUNT, MIN_LAG_RATIO * first)):
        rows = []
        for unit, free in zip(units, reach, strict=True):
            if len(unit) <= lag:
                continue
            near, far = (np.conj(unit[:-lag]) * unit[at : len(unit) - lag + at] for at in (first, lag))
            known = (free[:-lag] >= lag) & ~np.isnan(near + far)
            if known.any():
                overlaps = _sum_overlaps(known, first, lag)
                rows.append((abs(near[known].sum()), abs(far[known].sum()), np.count_nonzero(known), overlaps))
        if rows and (sums := np.array(rows, dtype=float)).all():
            found.append(_Pairs(first, lag, sums))
    return found


def _error_over_walkers(pairs: _Pairs, error: float) -> tuple[float, float]:
    """Return the relative error, that over walkers if they differ by more, and the widening of its bounds."""
    if len(pairs.sums) < 2:
        return error, 1.0
    parts = (pairs.sums, *(np.delete(pairs.sums, walker, axis=0) for walker in range(len(pairs.sums))))
    whole, *left_out = (float(np.diff(pairs._replace(sums=part).lost)[0]) for part in parts)
    number = interval_laws.with_walker_error(Quantity("", "", whole, error * whole, pairs.samples), left_out, False)
    if number.freedom == pairs.samples:
        return error, 1.0
    return number.pair[1] / whole, student_quantile(number.freedom, 0.975) / student_quantile(math.inf, 0.975)


def _sum_overlaps(starts: Mask, first: int, lag: int) -> float:
    """Return the sum of correlations between all pairs of starts, over half the relative variance of one pair.

    Squared turns of two times have a covariance that goes as the square of the time that both contain. What a pair
    measures is the squared turn of its `lag` less that of its `first` lag.
    """
    common = lag - np.arange(lag)
    squares = (common**2 - np.minimum(common, first) ** 2) / (lag - first) ** 2
    counts = [np.count_nonzero(starts[: len(starts) - step] & starts[step:]) for step in range(lag)]
    return float(2.0 * (squares @ counts) - squares[0] * counts[0])
