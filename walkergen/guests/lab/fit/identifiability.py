"""Summary of a posterior: parameters that were learnt, not learnt, or learnt only in combination."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.guests.lab.fit.parameters import Parameter
from walkergen.guests.lab.fit.posterior import Posterior

MAX_LEARNT_RATIO = 0.9
"""Standard deviation over that of the prior above which a parameter counts as not learnt."""

MAX_TRADE_ERROR = 0.5
"""Largest error of a combination, over that of a parameter in it, for parameters to trade off."""

MIN_COMPONENT = 0.3
"""Smallest component of a unit direction for a parameter to belong to it."""

MAX_DEVIATIONS = 2.0
"""Standard deviations of a measured value beyond which speeds that lead elsewhere disagree with it."""

MIN_PROBABILITY = 1e-3
"""Probability of a misfit below which a model is reported not to describe the speeds."""


class Summary(NamedTuple):
    """State of a parameter after the fit."""

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


def summarise_draws(parameters: Sequence[Parameter], draws: Array) -> tuple[Summary, ...]:
    """Return a summary of each parameter, from draws of the posterior, shape (k, parameters)."""
    rows = []
    grid = (np.arange(4096) + 0.5) / 4096
    for number, parameter in enumerate(parameters):
        column = draws[:, number]
        ends = np.quantile(column, (0.1587, 0.8413, 0.025, 0.975))
        mean, sd = float(column.mean()), float(column.std())
        narrowed = sd / float(parameter.quantiles(grid).std())
        row = (parameter.name, mean, sd, *map(float, ends), parameter.statement, narrowed)
        rows.append(Summary._make(row))
    return tuple(rows)


def unlearnt_notes(rows: Sequence[Summary]) -> list[str]:
    """Return a note on the parameters that the speeds constrain no better than the prior, if there are any."""
    names = [row.name for row in rows if row.narrowed > MAX_LEARNT_RATIO]
    if not names:
        return []
    return [f"not constrained by these speeds: {_join_names(names)}, as uncertain as before"]


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


def disagreement_notes(parameters: Sequence[Parameter], rows: Sequence[Summary]) -> list[str]:
    """Return a note on each fitted mean that is more than MAX_DEVIATIONS prior deviations off its measured prior."""
    notes = []
    for parameter, row in zip(parameters, rows, strict=True):
        prior = parameter.prior
        if parameter.flat or not prior.mean > 0.0:
            continue
        off = math.log(row.mean / prior.mean) if prior.factor else row.mean - prior.mean
        if abs(off) > MAX_DEVIATIONS * prior.sd:
            notes.append(
                f"{row.name} = {row.mean:.3g}: the speeds disagree with the measured {parameter.statement}. "
                "Check both, or the model itself is off for this walker"
            )
    return notes


def _join_names(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + f" and {names[-1]}"
