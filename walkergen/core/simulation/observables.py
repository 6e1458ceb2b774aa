"""Statistics of runs other than their speed, each with the error that the runs' scatter gives it.

Their names are the keys of `simulate --json` (`ensemble.Summary.facts`). In a table, a dot stands between its name
and that of the entry, as in type_fractions.sticking.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.simulation import record
from walkergen.core.simulation.run import RunResult

SPEED = "speed_mm_s"
IMPACTS, CONTACT = "impacts_per_s", "contact_fraction"
BY_IMPULSE, BY_NUMBER, POWERS = "type_fractions_by_impulse", "type_fractions", "energies_per_s"
"""Tables: shares of each type in the normal impulse of the feet's landings and in the number of impacts ("sticking":
share where a foot sticks); mean powers in g mm^2/s^3 (nW), from the plate, lost to impacts, friction and damping."""

POWER_ROWS = {
    "from_plate": record.PLATE_WORK,
    "impacts": record.IMPACT_LOSS,
    "friction": record.FRICTION_LOSS,
    "damping": record.DAMPING_LOSS,
}
"""Names of the powers and their rows in `Tally.sums`."""

COUNT_NAMES = (*record.KINDS, "sticking")
"""Names of shares of impacts by number, in the order of `Tally.counts` after all impacts."""

OBSERVABLE_NAMES = (
    SPEED,
    IMPACTS,
    CONTACT,
    *(f"{POWERS}.{name}" for name in POWER_ROWS),
    *(f"{BY_IMPULSE}.{name}" for name in record.KINDS),
    *(f"{BY_NUMBER}.{name}" for name in COUNT_NAMES),
)
"""Names of the observables."""

MIN_RUNS = 4
"""Smallest number of runs whose scatter serves as an error; with fewer, that error is itself off by half."""


def compute_observables(results: Sequence[RunResult]) -> dict[str, Quantity]:
    """Compute the observables of all runs together, by OBSERVABLE_NAMES without the speed.

    Each is one sum over the runs divided by another: a total by the time, a number of impacts by that of all impacts,
    or an impulse by that of all landings. Shares are 0 without impacts.
    """
    counts = np.array([result.tally.counts for result in results], dtype=float).reshape(-1, 9)
    sums = np.array([result.tally.sums for result in results]).reshape(-1, 14)  # a row for each run, as in `Tally`
    elapsed, impacts = sums[:, record.ELAPSED], counts[:, record.IMPACTS]
    impulses = sums[:, record.IMPULSES + 1 :]
    quotients = {IMPACTS: (impacts, elapsed), CONTACT: (sums[:, record.CONTACT_TIME], elapsed)}
    quotients |= {f"{POWERS}.{name}": (sums[:, row], elapsed) for name, row in POWER_ROWS.items()}
    impulse = impulses.sum(axis=1)
    quotients |= {f"{BY_IMPULSE}.{name}": (impulses[:, column], impulse) for column, name in enumerate(record.KINDS)}
    quotients |= {f"{BY_NUMBER}.{name}": (counts[:, 1 + column], impacts) for column, name in enumerate(COUNT_NAMES)}
    return {name: ratio_of_sums(name, numerator, denominator) for name, (numerator, denominator) in quotients.items()}


def ratio_of_sums(key: str, numerators: Array, denominators: Array) -> Quantity:
    """Return the sum of `numerators` over the sum of `denominators`, each of shape (runs,), with its standard error.

    The error is that of a ratio of means: from the scatter of the residuals numerator - value denominator of
    independent runs. `key` names the result.
    """
    total, runs = float(denominators.sum()), len(denominators)
    value = float(numerators.sum()) / total if total else 0.0
    if runs < MIN_RUNS:
        return Quantity(key, "", value, None, runs - 1.0, f"fewer than {MIN_RUNS} runs give no error")
    if not total:
        return Quantity(key, "", value, 0.0)
    scatter = float(np.sum((numerators - value * denominators) ** 2)) * runs / (runs - 1)
    return Quantity(key, "", value, math.sqrt(scatter) / abs(total), runs - 1.0)


def table_values(observed: Mapping[str, Quantity], table: str) -> dict[str, float]:
    """Return the values in one table (BY_IMPULSE, BY_NUMBER or POWERS), by their names without that of the table."""
    start = f"{table}."
    return {name.removeprefix(start): observed[name].number for name in observed if name.startswith(start)}
