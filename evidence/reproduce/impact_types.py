"""Types of impacts of a foot, and their shares among the impacts of runs, counted in three ways."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from evidence import landings
from walkergen.core.numerics import Array, Mask, Whole
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.theory.impact import Kind

TYPES = {
    "III": (Kind.III,),
    "II": (Kind.II,),
    "I": (Kind.I,),
    "IV": (Kind.IV,),
    "from rest": (Kind.FROM_REST,),
    "mirrored": (Kind.II_MIRRORED, Kind.III_MIRRORED),
}
"""Types of impacts; from rest: v_x = 0 exactly before; mirrored: II or III of a foot that slides
backward before."""

SUMS = {"II+III": ("II", "III"), "II+III+rest": ("II", "III", "from rest"), "III+rest": ("III", "from rest")}
"""Shares taken together: an impact from rest is the limit of type III for v_x to 0."""

COUNTINGS = ("every impact", "landings", "by impulse")
"""Ways to take a share: of all impacts, in space every contact of a corner from the first force to the last, in the
paper's model all impacts of a foot at one instant by the type of the first; of landings, a foot's first impact after a
time without any (`landings.MIN_QUIET_S`); or of the normal impulse of these impacts."""

Shares = Mapping[tuple[str, str], Quantity]
"""Shares by counting and type, or sum of types."""


class Impacts(NamedTuple):
    """Impacts of one run, arrays with an entry for each."""

    kind: Whole
    impulse: Array
    speed: Array
    """Normal speed before the impact, mm/s."""
    landing: Mask


def classify_impacts(rows: Array, corners: int) -> Impacts:
    """Impacts in the record of a run, whose events count so many corners to a foot."""
    impacts = landings.impacts_in(rows)
    return Impacts(
        impacts.kind, impacts.F_y, -impacts.v_y, landings.find_landings(impacts.time, impacts.foot // corners)
    )


def mean_shares(runs: Sequence[Impacts]) -> Shares:
    """Return mean shares over runs that all have landings; empty for fewer than two."""
    if len(runs) < 2:
        return {}
    weights = [(np.ones(len(run.kind)), run.landing.astype(np.float64), run.impulse) for run in runs]
    rows = [[weighted_shares(run.kind, own) for own in ways] for run, ways in zip(runs, weights, strict=True)]
    table, names = np.array(rows), list(TYPES)
    return {
        (counting, name): mean(name, "", table[:, row, [names.index(kind) for kind in kinds]].sum(axis=1))
        for row, counting in enumerate(COUNTINGS)
        for name, kinds in ({name: (name,) for name in names} | SUMS).items()
    }


def weighted_shares(kind: Whole, weights: Array) -> Array:
    """Shares in the order of TYPES of impacts with weights."""
    amounts = [float(weights[np.isin(kind, kinds)].sum()) for kinds in TYPES.values()]
    return np.array(amounts) / float(weights.sum())
