"""Numbers of motion that follow from a fit of the mean squared displacement, added to those from sums over tracks.

`numbers` (values by name) and `sums`: one entry for all samples, then one with each sample left out. The fit to these
finds the law of the displacement (with or without runs). Sums with each walker left out are fitted by that law.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from walkergen.analysis import displacement_fit, estimates, verdicts
from walkergen.analysis.displacement_fit import DisplacementFit
from walkergen.analysis.estimates import Settings, mean
from walkergen.analysis.moments import Moments
from walkergen.analysis.persistent_walk import Spread
from walkergen.core.numerics import Array


def add_fit(
    numbers: list[dict[str, float]], sums: Sequence[Moments], settings: Settings, longest_lag: int
) -> tuple[list[dict[str, float]], DisplacementFit | None]:
    """Fit the squared displacement up to a lag (samples). Return extended `numbers`, and the fit or None."""
    if settings.lane:
        return numbers, None
    lag, squares = _mean_squares(sums, settings, int((settings.grid.square_lags <= longest_lag).sum()))
    fit = displacement_fit.fit(lag, squares, _turning_rates(numbers, settings.headed))
    return _with_fit_numbers(numbers, fit.spreads, settings), fit


def add_refit(
    numbers: list[dict[str, float]], sums: Sequence[Moments], settings: Settings, fit: DisplacementFit | None
) -> list[dict[str, float]]:
    """Fit `sums`, with each walker left out, by an earlier fit's law. Return `numbers` with those of the fits added."""
    if fit is None or not len(fit.errors):
        return numbers
    lag, squares = _mean_squares(sums, settings, len(fit.errors))
    turns = [sample["turning_bias"] if fit.spreads[0].turn else 0.0 for sample in numbers]
    return _with_fit_numbers(numbers, displacement_fit.refit(lag, squares, turns, fit), settings)


def _mean_squares(sums: Sequence[Moments], settings: Settings, count: int) -> tuple[Array, list[Array]]:
    """Return the first `count` lags (s), and for each of the sums the mean squared displacements (mm^2) by lag."""
    lag = settings.interval * settings.grid.square_lags[:count].astype(float)
    return lag, [np.asarray(mean(sample.square, sample.square_pairs), float)[:count] for sample in sums]


def _with_fit_numbers(
    numbers: Sequence[dict[str, float]], fits: Iterable[Spread], settings: Settings
) -> list[dict[str, float]]:
    """Return each entry of `numbers` with the numbers of its fit added."""
    return [
        sample | estimates.from_spread(spread, settings.interval) for sample, spread in zip(numbers, fits, strict=True)
    ]


def _turning_rates(numbers: Sequence[Mapping[str, float]], headed: bool) -> list[float]:
    """Return the mean turning rate of each entry, rad/s; 0 if displacements are too noisy. `headed`: with headings."""
    if headed or verdicts.is_resolved(verdicts.jackknife_quantity(numbers, "amplitude")):
        return [sample["turning_bias"] for sample in numbers]
    return [0.0] * len(numbers)
