"""Summary of a posterior: parameters that the speeds determine, do not determine, or determine only in combination."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.guests.lab.fit.parameters import Parameter
from walkergen.guests.lab.fit.posterior import Posterior

MAX_LEARNT_RATIO = 0.9
"""Standard deviation over that of the prior above which a parameter counts as not determined by the speeds."""

MAX_TRADE_ERROR = 0.5
"""Largest error of a combination, over that of a single parameter in it, at which a note reports the combination."""

MIN_COMPONENT = 0.3
"""Smallest component of a combination's unit vector for a parameter to belong to it."""

MAX_DEVIATIONS = 2.0
"""Distance between a measured value and the fit, in standard deviations, beyond which the speeds disagree with it."""

MAX_ROW_DEVIATIONS = 2.5
"""Standard deviations from the fit beyond which a measured speed is an outlier, as 1 of 80 correct ones is."""

MIN_PROBABILITY = 1e-3
"""Probability of a misfit below which a model is reported not to describe the speeds."""


class Summary(NamedTuple):
    """Posterior of a parameter: mean, standard deviation, bounds, and the prior as text."""

    name: str
    mean: float
    sd: float
    low_68: float
    high_68: float
    low_95: float
    high_95: float
    prior: str
    narrowed: float
    """Standard deviation over that of the prior."""
    measured: bool = False
    """Whether scene or design state the prior as measured, with its standard deviation; otherwise it is assumed."""


def summarise_draws(parameters: Sequence[Parameter], draws: Array) -> tuple[Summary, ...]:
    """Return a summary of each parameter, from draws of the posterior, shape (k, parameters)."""
    rows = []
    grid = (np.arange(4096) + 0.5) / 4096
    for number, parameter in enumerate(parameters):
        column = draws[:, number]
        ends = np.quantile(column, (0.1587, 0.8413, 0.025, 0.975))
        mean, sd = float(column.mean()), float(column.std())
        narrowed = sd / float(parameter.quantiles(grid).std())
        row = (parameter.name, mean, sd, *map(float, ends), parameter.statement, narrowed, False)
        rows.append(Summary._make(row))
    return tuple(rows)


def unlearnt_notes(rows: Sequence[Summary]) -> list[str]:
    """Return a note on the parameters that the speeds constrain no better than the prior, if there are any."""
    names = [row.name for row in rows if row.narrowed > MAX_LEARNT_RATIO]
    if not names:
        return []
    return [f"not constrained by these speeds: {_join_names(names)} are as uncertain as before"]


def trade_off_notes(parameters: Sequence[Parameter], draws: Array) -> list[str]:
    """Return notes on parameters that are determined only in combination.

    Combinations are eigenvectors of the correlation of the parameters' logarithms, that is, products of powers. `draws`
    of the posterior, shape (k, columns), have the parameters as their first columns.
    """
    if len(parameters) < 2:
        return []
    logs = np.log(np.maximum(draws[:, : len(parameters)], 1e-6))
    sd = logs.std(axis=0)
    levels, vectors = np.linalg.eigh(np.corrcoef(logs.T))
    notes = []
    for level, vector in zip(levels, vectors.T, strict=True):
        parts = [index for index, part in enumerate(vector) if abs(part) > MIN_COMPONENT]
        parts.sort(key=lambda index: -abs(vector[index]))
        first = parts[0]
        power = vector / sd / (vector[first] / sd[first])
        error = float(np.std(logs[:, parts] @ power[parts]))
        if len(parts) < 2 or np.sqrt(level) > MAX_TRADE_ERROR or error > MAX_TRADE_ERROR * sd[first]:
            continue
        names = [parameters[index].name for index in parts]
        product = " x ".join(
            parameters[index].name + ("" if index == first else f"^{power[index]:.2g}") for index in parts
        )
        notes.append(
            f"{_join_names(names)} trade off: {product} is known to {100 * error:.0f} %, but {parameters[first].name} "
            f"alone only to {100 * sd[first]:.0f} %"
        )
    return notes


def misfit_notes(sampled: Posterior, count: int, model: str) -> list[str]:
    """Return a note if even the best parameters of the `model` do not describe the `count` speeds; [] otherwise."""
    from scipy.stats import chi2

    chance = float(chi2.sf(sampled.chi2, count))
    if chance > MIN_PROBABILITY:
        return []
    return [
        f"the model {model} does not describe these speeds: chi2 {sampled.chi2:.3g} for {count} "
        f"speeds at best (probability {chance:.1g}). Bands and errors assume that it does"
    ]


def disagreements(parameters: Sequence[Parameter], rows: Sequence[Summary]) -> list[str]:
    """Return a sentence for each measured value from which the speeds move a fit by more than chance would.

    Speeds that agree with a normal prior (mean p, variance P) move a fit (f, F) by f - p with the variance P - F.
    Values that the speeds hardly constrain are left out: their P - F is noise of the draws.
    """
    sentences = []
    for parameter, row in zip(parameters, rows, strict=True):
        prior = parameter.prior
        if parameter.flat or not row.measured or not prior.mean > 0.0 or row.narrowed > MAX_LEARNT_RATIO:
            continue
        off, sd = row.mean - prior.mean, row.sd
        if prior.factor:
            off, sd = math.log(row.mean / prior.mean), row.sd / row.mean
        number = abs(off) / math.sqrt(prior.sd**2 - sd**2)
        if number > MAX_DEVIATIONS:
            sentences.append(
                f"speeds and the measured {row.name.replace('_', ' ')} disagree: the speeds move it to "
                f"{formatting.format_with_error(row.mean, row.sd)} from {parameter.statement}, by {number:.1f} times "
                "what chance does"
            )
    return sentences


def outlier_notes(speeds: Sequence[float], middles: Sequence[float], sds: Sequence[float], tilts: Array) -> list[str]:
    """Return a note on each measured speed (mm/s) farther than MAX_ROW_DEVIATIONS from the fit.

    `middles`, `sds`: speeds of one more print at each row, with the standard deviation of a measurement of it.
    """
    return [
        f"outlier: the row of {tilt:g} deg and {formatting.format_number(speed, 3)} mm/s lies {off:.1f} standard "
        f"deviations from the fit, {formatting.format_number(middle, 3)} mm/s. Check this print and its film"
        for speed, middle, sd, tilt in zip(speeds, middles, sds, tilts, strict=True)
        if (off := abs(speed - middle) / sd) > MAX_ROW_DEVIATIONS
    ]


def _join_names(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + f" and {names[-1]}"
