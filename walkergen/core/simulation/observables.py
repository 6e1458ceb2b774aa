"""Statistics of runs other than their speed, each with the error that the runs' scatter gives it.

Names are those of `ensemble.Summary.facts`, with a dot before the part of a table: what `simulate --json`
prints, and what ladders of accuracy study.
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


def observe(results: Sequence[RunResult]) -> dict[str, Quantity]:
    """Return the observables over all time of the runs, by the names of OBSERVABLE_NAMES, without the speed.

    Each is a quotient of sums: by time, by the number of impacts, or by their impulse. Shares of
    runs without impacts are 0.
    """
    counts = np.array([result.tally.counts for result in results], dtype=float).reshape(-1, 9)
    sums = np.array([result.tally.sums for result in results]).reshape(-1, 14)
    elapsed, impacts = sums[:, record.ELAPSED], counts[:, record.IMPACTS]
    impulses = sums[:, record.IMPULSES + 1 :]
    per = {IMPACTS: (impacts, elapsed), CONTACT: (sums[:, record.CONTACT_TIME], elapsed)}
    per |= {f"{POWERS}.{name}": (sums[:, row], elapsed) for name, row in POWER_ROWS.items()}
    whole = impulses.sum(axis=1)
    per |= {f"{BY_IMPULSE}.{name}": (impulses[:, place], whole) for place, name in enumerate(record.KINDS)}
    per |= {f"{BY_NUMBER}.{name}": (counts[:, 1 + place], impacts) for place, name in enumerate(COUNT_NAMES)}
    return {name: ratio_of_sums(name, above, below) for name, (above, below) in per.items()}


def ratio_of_sums(key: str, above: Array, below: Array) -> Quantity:
    """Return the sum of `above` over the sum of `below`, shape (runs,), with the error of a ratio of means.

    The error is that of the residuals above - value below between independent runs.
    """
    whole, runs = float(below.sum()), len(below)
    value = float(above.sum()) / whole if whole else 0.0
    if runs < MIN_RUNS:
        return Quantity(key, "", value, None, runs - 1.0, f"fewer than {MIN_RUNS} runs give no error")
    if not whole:
        return Quantity(key, "", value, 0.0)
    scatter = float(np.sum((above - value * below) ** 2)) * runs / (runs - 1)
    return Quantity(key, "", value, math.sqrt(scatter) / abs(whole), runs - 1.0)


def table_values(observed: Mapping[str, Quantity], table: str) -> dict[str, float]:
    """Return the values of the observables of one table (BY_IMPULSE, BY_NUMBER or POWERS) by their names."""
    start = f"{table}."
    return {name.removeprefix(start): observed[name].number for name in observed if name.startswith(start)}
