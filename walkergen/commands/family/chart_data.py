"""What a family's chart shows beside its members: predicted between them, measured, the paper's."""

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from walkergen.analysis.speeds import Measured
from walkergen.core.theory.prediction import Curve
from walkergen.core.walker.limbs import Kind
from walkergen.files.report import Table


class Speed(NamedTuple):
    """Speed at a tilt; the field names are the columns of speed.csv."""

    what: Literal["predicted", "measured", "paper"]
    legs: str
    tilt_deg: float
    speed_mm_s: float
    speed_low_68_mm_s: float | None = None
    speed_high_68_mm_s: float | None = None
    speed_low_95_mm_s: float | None = None
    speed_high_95_mm_s: float | None = None
    theory_mm_s: float | None = None
    """Speed by the theory; None but with a predicted one."""
    foot_can_stick: Literal["yes", "no"] | None = None
    """Whether a foot can stick, so that the paper's formula fails; None but with a predicted one."""


NORMAL_95 = 1.96
"""Standard errors on either side that hold a normal number with 95 %."""


class ChartData(NamedTuple):
    """Speeds that speed.png shows and family.csv has not; speed.csv holds them."""

    curves: Mapping[Kind, Curve]
    """Predicted speed and theory against tilt by kind of legs."""
    measured: Measured | None = None
    stated: tuple[float, float] | None = None
    """Tilt (deg) and speed (mm/s) that the paper states for this walker on this plate."""


def assign_member_tilts(measured: Measured, tilts: Mapping[str, float]) -> Measured:
    """Measured speeds as those of members whose legs follow no common tilt, by their kind of legs.

    `tilts` are the members' own, deg; speeds of kinds without a member are left out.
    """
    own = np.array([legs in tilts for legs in measured.legs], dtype=bool)
    return measured._replace(
        tilt=np.array([tilts[legs] for legs in measured.legs if legs in tilts], dtype=float),
        legs=[legs for legs in measured.legs if legs in tilts],
        speed=measured.speed[own],
        se=None if measured.se is None else measured.se[own],
        plate_speed=measured.plate_speed[own],
    )


def speed_rows(chart_data: ChartData) -> list[Speed]:
    """Speeds beside the members, a row a point."""
    rows = []
    for kind, curve in chart_data.curves.items():
        columns = np.column_stack([curve.tilt_deg, curve.speed, curve.bounds[[1, 2, 0, 3]].T, curve.theory]).tolist()
        for (tilt, speed, low68, high68, low95, high95, theory), sticks in zip(columns, curve.can_stick, strict=True):
            if math.isnan(speed):  # to be simulated
                continue
            stick: Literal["yes", "no"] = "yes" if sticks else "no"
            rows.append(Speed("predicted", kind, tilt, speed, low68, high68, low95, high95, theory, stick))
    if (measured := chart_data.measured) is not None:
        errors = [math.nan] * len(measured.speed) if measured.se is None else measured.se
        for kind, tilt, speed, se in zip(measured.legs, measured.tilt, measured.speed, errors, strict=True):
            row = Speed("measured", kind, float(tilt), float(speed))
            if not math.isnan(se):
                low, high = float(speed - NORMAL_95 * se), float(speed + NORMAL_95 * se)
                row = Speed("measured", kind, *row[2:4], float(speed - se), float(speed + se), low, high)
            rows.append(row)
    if chart_data.stated is not None:
        rows.append(Speed("paper", "flexible", *chart_data.stated))
    return rows


def table(chart_data: ChartData) -> Table:
    """Table of the speeds beside the members."""
    return Table("speed", speed_rows(chart_data), Speed._fields)
