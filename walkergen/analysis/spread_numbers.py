"""Numbers of sums over tracks together with those of the fit of their squared displacement.

The fit of all samples, and of those without each one, finds the law. Sums without each walker, too few to find a law,
are fitted by the same one. `numbers` and `sums` have an entry for all samples, then for those without each one.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from walkergen.analysis import displacement_fit, estimates, verdicts
from walkergen.analysis.displacement_fit import DisplacementFit
from walkergen.analysis.estimates import Frame, mean
from walkergen.analysis.moments import Moments
from walkergen.analysis.persistent_walk import Spread
from walkergen.core.numerics import Array


def add_fit(
    numbers: list[dict[str, float]], sums: Sequence[Moments], frame: Frame, longest_lag: int
) -> tuple[list[dict[str, float]], DisplacementFit | None]:
    """Fit the squared displacement up to a lag (samples); return numbers with those of the fit, and the fit."""
    if frame.lane:
        return numbers, None
    lag, squares = _mean_squares(sums, frame, int((frame.grid.square_lags <= longest_lag).sum()))
    fit = displacement_fit.fit(lag, squares, _turning_rates(numbers, frame.headed))
    return _add_spreads(numbers, fit.spreads, frame), fit


def add_refit(
    numbers: list[dict[str, float]], sums: Sequence[Moments], frame: Frame, fit: DisplacementFit | None
) -> list[dict[str, float]]:
    """Add to the numbers of sums without each walker those of the law of an earlier `fit`."""
    if fit is None or not len(fit.errors):
        return numbers
    lag, squares = _mean_squares(sums, frame, len(fit.errors))
    turns = [sample["turning_bias"] if fit.spreads[0].turn else 0.0 for sample in numbers]
    return _add_spreads(numbers, displacement_fit.refit(lag, squares, turns, fit), frame)


def _mean_squares(sums: Sequence[Moments], frame: Frame, count: int) -> tuple[Array, list[Array]]:
    """Return the first `count` lags (s), and for each of the sums the mean squared displacement (mm^2) at them."""
    lag = frame.interval * frame.grid.square_lags[:count].astype(float)
    return lag, [np.asarray(mean(sample.square, sample.square_pairs), float)[:count] for sample in sums]


def _add_spreads(numbers: Sequence[dict[str, float]], fits: Iterable[Spread], frame: Frame) -> list[dict[str, float]]:
    """Add to each of the numbers those of its fit."""
    return [
        sample | estimates.from_spread(spread, frame.interval) for sample, spread in zip(numbers, fits, strict=True)
    ]


def _turning_rates(numbers: Sequence[Mapping[str, float]], headed: bool) -> list[float]:
    """Return the mean turning rate of each entry, rad/s; 0 if displacements are too noisy. `headed`: with headings."""
    if headed or verdicts.is_resolved(verdicts.jackknife_quantity(numbers, "amplitude")):
        return [sample["turning_bias"] for sample in numbers]
    return [0.0] * len(numbers)
