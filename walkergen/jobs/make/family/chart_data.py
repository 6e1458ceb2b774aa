"""What a family's chart shows beside its members: predicted between them, measured, the paper's."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis.speeds import Measured
from walkergen.files.report import Table
from walkergen.theory.prediction import Curve
from walkergen.walker.limbs import Kind

Array = npt.NDArray[np.float64]

KEYS = (
    "what",
    "legs",
    "tilt_deg",
    "speed_mm_s",
    "speed_low_68_mm_s",
    "speed_high_68_mm_s",
    "speed_low_95_mm_s",
    "speed_high_95_mm_s",
    "theory_mm_s",
    "foot_can_stick",
)

SURE = 1.96
"""Standard errors on either side that hold a normal number with 95 %."""


class ChartData(NamedTuple):
    """Speeds that speed.png shows and family.csv has not; speed.csv holds them."""

    curves: Mapping[Kind, Curve]
    """Predicted speed and theory against tilt by kind of legs."""
    measured: Measured | None = None
    stated: tuple[float, float] | None = None
    """Tilt (deg) and speed (mm/s) that the paper states for this walker on this plate."""


def ends(speed: Array, se: Array, errors: float = SURE) -> tuple[Array, Array]:
    """Ends of the bars of measured speeds, mm/s, so many standard errors away."""
    return speed - errors * se, speed + errors * se


def of_members(measured: Measured, tilts: Mapping[str, float]) -> Measured:
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


def table(chart_data: ChartData) -> Table:
    """Table with a row a point: `what` is predicted, measured or the paper's."""
    rows: list[tuple[object, ...]] = []
    for kind, curve in chart_data.curves.items():
        low95, low68, high68, high95 = curve.bounds
        columns = (curve.tilt_deg, curve.speed, low68, high68, low95, high95, curve.theory)
        rows += [
            ("predicted", kind, *map(_cell, values), "yes" if sticks else "no")
            for *values, sticks in zip(*columns, curve.can_stick, strict=True)
        ]
    if (measured := chart_data.measured) is not None:
        speed = measured.speed
        se = np.full(len(speed), np.nan) if measured.se is None else measured.se
        seen = (measured.tilt, speed, *ends(speed, se, 1.0), *ends(speed, se))
        rows += [
            ("measured", kind, *map(_cell, values), None, None)
            for kind, values in zip(measured.legs, zip(*seen, strict=True), strict=True)
        ]
    if chart_data.stated is not None:
        rows.append(("paper", "flexible", *chart_data.stated, *[None] * 6))
    return Table("speed", rows, KEYS)


def _cell(value: float) -> float | None:
    """Every digit of a number; nothing where it is unknown."""
    return None if np.isnan(value) else float(value)
