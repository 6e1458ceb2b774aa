"""Additional data of a family's chart: predictions between members, measured speeds, the paper's speed."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis.speeds import Measured
from walkergen.core.theory.prediction import Curve
from walkergen.core.walker.limbs import Kind
from walkergen.files.report import Table

BOUNDS = tuple(f"speed_{end}_{level}_mm_s" for level in (68, 95) for end in ("low", "high"))
KEYS = ("what", "legs", "tilt_deg", "speed_mm_s", *BOUNDS, "theory_mm_s", "foot_can_stick")
"""Columns of speed.csv: predicted, measured and the paper's speeds. Only predictions have theory and feet."""

NORMAL_95 = 1.96
"""Standard errors on either side that enclose 95 % of a normal distribution."""


class ChartData(NamedTuple):
    """Speeds in speed.png that family.csv does not contain; they are saved in speed.csv."""

    curves: Mapping[Kind, Curve]
    """Predicted speed and theory against tilt by kind of legs."""
    measured: Measured | None = None
    stated: tuple[float, float] | None = None
    """Tilt (deg) and speed (mm/s) that the paper states for this walker on this plate."""


def assign_member_tilts(measured: Measured, tilts: Mapping[str, float]) -> Measured:
    """Assign measured speeds to members whose legs follow no common tilt, by their kind of legs.

    `tilts` are the members' own, deg. Speeds of kinds without a member are left out.
    """
    has_member = np.array([legs in tilts for legs in measured.legs], dtype=bool)
    return measured._replace(
        tilt=np.array([tilts[legs] for legs in measured.legs if legs in tilts], dtype=float),
        legs=[legs for legs in measured.legs if legs in tilts],
        speed=measured.speed[has_member],
        se=None if measured.se is None else measured.se[has_member],
        plate_speed=measured.plate_speed[has_member],
    )


def table(chart_data: ChartData) -> Table:
    """Make the table of the additional speeds, one row per point."""
    rows: list[tuple[Any, ...]] = []
    for kind, curve in chart_data.curves.items():
        # From the order of QUANTILES (95 and 68 % low, 68 and 95 % high) to that of BOUNDS
        columns = np.column_stack([curve.tilt_deg, curve.speed, curve.bounds[[1, 2, 0, 3]].T, curve.theory]).tolist()
        for (tilt, *bounds, theory), sticks in zip(columns, curve.can_stick, strict=True):
            if math.isnan(bounds[0]):  # to be simulated
                continue
            rows.append(("predicted", kind, tilt, *bounds, theory, "yes" if sticks else "no"))
    if (measured := chart_data.measured) is not None:
        errors = [math.nan] * len(measured.speed) if measured.se is None else measured.se
        for kind, tilt, speed, se in zip(measured.legs, measured.tilt, measured.speed, errors, strict=True):
            bounds = (
                [None] * 4
                if math.isnan(se)
                else [float(speed + side * se) for side in (-1.0, 1.0, -NORMAL_95, NORMAL_95)]
            )
            rows.append(("measured", kind, float(tilt), float(speed), *bounds, None, None))
    if chart_data.stated is not None:
        rows.append(("paper", "flexible", *chart_data.stated, *[None] * 6))
    return Table("speed", rows, KEYS)
