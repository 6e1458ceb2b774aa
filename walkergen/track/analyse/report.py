"""Report of measured motion: estimates, each walker, speeds by plate speed, and curves."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from walkergen.analysis import facts
from walkergen.analysis.between import Alone
from walkergen.analysis.doubts import of_scale
from walkergen.analysis.estimates import HEADINGS_KNOWN, IN_A_LANE, UNITS, Estimate, with_error
from walkergen.analysis.facts import OF_WALKERS
from walkergen.analysis.motion import Array, Motion
from walkergen.analysis.tracks import Tracks
from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = {"mm_s": "mm/s", "mm2_s": "mm²/s", "per_s": "1/s", "rad_s": "rad/s", "rad2_s": "rad²/s"}
"""Units as they are printed where they are not part of a key."""

NAMES = {f"{name}_{unit}": (name.replace("_", " "), SHOWN.get(unit, unit)) for name, unit in UNITS.items()}
"""Names and units that people read, by the quantities of analysis.csv."""

MOST_WALKERS = 24
"""Largest number of walkers in a table that is printed."""

TURNED = 0.05
"""Share of the direction that is lost, below which walkers do not turn."""


@dataclass(frozen=True, kw_only=True, repr=False)
class AnalysisReport(Report):
    """Motion that tracks tell, each number with its error or the reason why it has none."""

    motion: Motion
    """Everything that was measured, with curves."""
    notes: Sequence[str]
    """Method and doubts, and rows that were left out."""

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Estimates by name: value, standard error, and the reason where both are None."""
        return self.motion.estimates

    @property
    def speed(self) -> Estimate:
        """Mean speed, mm/s, with its standard error; the reason where both are None."""
        return self.estimates["speed"]


class Measured(NamedTuple):
    """Estimate; the field names are the columns of analysis.csv."""

    quantity: str
    """Name with its unit."""
    value: float | None
    se: float | None
    scale_se: float | None
    """Error by the scale of the film, which all lengths share."""
    low_95: float | None
    high_95: float | None
    refused: str
    """Reason why it is not known."""


class Walker(NamedTuple):
    """Walker by itself; the field names are the columns of walkers.csv."""

    particle: int
    seen_s: float
    speed_mm_s: float | None
    speed_se_mm_s: float | None
    speed_low_95_mm_s: float | None
    speed_high_95_mm_s: float | None
    turning_rad_s: float | None
    turning_se_rad_s: float | None
    refused: str


class AtPlate(NamedTuple):
    """Speed at a plate speed; the field names are the columns of plate_speed.csv."""

    plate_speed_mm_s: float
    speed_mm_s: float | None
    speed_se_mm_s: float | None
    speed_scale_se_mm_s: float | None
    refused: str


def of(tracks: Tracks, motion: Motion, title: str, folder: Path | None = None) -> AnalysisReport:
    """Report of the motion of tracks, of a file called `title`."""
    fit = motion.msd_fit.goodness if motion.msd_fit else ""
    lines = [motion.method, fit, *motion.doubts, of_scale(motion.scale_se), tracks.note]
    notes = [f"{line}." for line in lines if line]
    more = {"bad_rows": tracks.bad_rows, "notes": notes}
    hidden = len(motion.walkers) - MOST_WALKERS
    counted = [f"and {hidden} more walkers in walkers.csv"] if hidden > 0 else []
    draw = partial(_draw, tracks=tracks, motion=motion, title=title)
    return AnalysisReport(
        name="analysis",
        title=title,
        caption=f"{title}, displacements within {1e3 * motion.lag_s:g} ms",
        tables=list(_tables(motion)),
        facts=facts.of(motion) | more,
        lines=[*counted, *_line(motion), *notes],
        figures={name: partial(draw, name) for name in _drawn(motion)},
        folder=folder,
        motion=motion,
        notes=notes,
    )


def _tables(motion: Motion) -> Iterator[Table]:
    estimates = [_estimate(motion, name, unit) for name, unit in UNITS.items()]
    if motion.by_plate_speed:
        rows = [
            AtPlate(plate, *speed[:2], facts.scale_se(speed.value, "mm_s", motion), speed.reason)
            for plate, speed in motion.by_plate_speed
        ]
        yield report.table("plate_speed", rows, AT_PLATES, "Speed by plate speed")
        yield report.table("analysis", estimates)
        yield _walkers(motion)
        return
    readable = [row for row in estimates if row.refused not in (IN_A_LANE, HEADINGS_KNOWN)]
    yield Table("analysis", estimates, Measured._fields, ESTIMATES, "Motion", read=readable)
    yield _walkers(motion)
    yield from _curves(motion)


def _estimate(motion: Motion, name: str, unit: str) -> Measured:
    value, se, reason, *_ = motion.estimates[name]
    by_scale, ends = facts.scale_se(value, unit, motion), facts.ends(motion.estimates[name])
    return Measured(f"{name}_{unit}", value, se, by_scale, *ends, reason)


def _value(row: Measured) -> str:
    return _with_scale(row.value, row.se, row.scale_se, row.refused)


def _with_scale(value: float | None, se: float | None, by_scale: float | None, refused: str) -> str:
    """Value with its error and, where the scale has one, that of the scale beside it."""
    if value is None or se is None:
        return refused
    scale = f" ± {words.number(by_scale, 2)} (scale)" if by_scale else ""
    return words.with_error(value, se) + scale


def _bounds(row: Measured) -> str:
    """Bounds of 95 % to two digits of the error; '' without any."""
    if row.low_95 is None or row.high_95 is None or not row.se:
        return ""
    return " to ".join(words.to_digits_of(row.se, (row.low_95, row.high_95)))


ESTIMATES = (
    Column("", lambda row: NAMES[row.quantity][0]),
    Column("", lambda row: NAMES[row.quantity][1]),
    Column("value ± standard error", _value),
    Column("95 %", _bounds),
)

AT_PLATES = (
    Column("plate speed (mm/s)", lambda row: f"{row.plate_speed_mm_s:g}"),
    Column("speed (mm/s)", lambda row: _with_scale(*row[1:])),
)


def _walkers(motion: Motion) -> Table:
    """Table of each walker by itself; people read the first."""
    rows, alone = [], {walker.particle: walker for walker in motion.walkers}
    for walker in motion.walkers:
        speed, turning = (walker.of(name) for name in OF_WALKERS)
        ends = facts.ends(speed)
        rows.append(Walker(walker.particle, walker.seconds, *speed[:2], *ends, *turning[:2], speed.reason))
    turns = any("turning_bias" in walker.estimates for walker in motion.walkers)
    headings = ("speed (mm/s)", "turning (rad/s)")[: 1 + turns]
    columns = [
        report.text("walker", "particle"),
        report.number("seen (s)", "seen_s", 3),
        *(_own(heading, name, alone) for heading, name in zip(headings, OF_WALKERS, strict=False)),
    ]
    return Table("walkers", rows, Walker._fields, columns, "Walkers", read=rows[:MOST_WALKERS])


def _own(heading: str, name: str, alone: Mapping[int, Alone]) -> Column:
    """Column of an estimate of each walker by itself."""
    return Column(heading, lambda row: _or_alone(alone[row.particle].of(name)))


def _or_alone(estimate: Estimate) -> str:
    """Value with its error, or by itself with the reason why that is not known."""
    if estimate.value is None or estimate.se is not None:
        return with_error(estimate)
    return f"{words.number(estimate.value)} ± ?: {estimate.reason}"


def _line(motion: Motion) -> Iterator[str]:
    """Description of the line through the origin, of tracks at several plate speeds."""
    line = motion.line
    if line is None:
        return
    scale = facts.scale_se(line.slope, "mm_s", motion)
    scale_error = f" ± {words.number(scale, 2)} by the scale" if scale else ""
    yield (
        f"speed = ({words.with_error(line.slope, line.slope_se)}{scale_error}) x plate speed, a "
        f"line through the origin; chi² {words.number(line.chi2)} for {line.points - 1} degrees of "
        f"freedom, probability {words.number(line.p_value, 2)}"
    )


def _curves(motion: Motion) -> Iterator[Table]:
    """Tables of the curves, for CSV and Python alone."""
    squared = (*motion.msd, facts.scale_errors(motion), *motion.exponent[1:])
    keys = ("lag_s", "msd_mm2", "se_mm2", "scale_se_mm2", "exponent", "exponent_se")
    yield Table("msd", _points(squared), keys)
    yield Table("correlation", _points(motion.correlation), ("lag_s", "value", "se"))
    sides = {"parallel": motion.parallel, "orthogonal": motion.orthogonal}
    rows = [(name, *point) for name, curve in sides.items() for point in _points(curve)]
    yield Table("density", rows, ("direction", "mm", "density_per_mm", "se_per_mm"))


def _points(curve: Sequence[Array]) -> list[tuple[float | None, ...]]:
    """Points of a curve; None where a number is not known."""
    return [tuple(None if math.isnan(value) else float(value) for value in point) for point in zip(*curve, strict=True)]


def _drawn(motion: Motion) -> Iterator[str]:
    """Names of the figures that the motion allows."""
    yield "trajectories"
    if motion.by_plate_speed:
        yield "plate_speed"
        return
    if sum(walker.of("speed").value is not None for walker in motion.walkers) > 1:
        yield "walkers"
    if (motion.msd.value > 0).any():
        yield "msd"
    if len(motion.parallel.at):
        yield "density"
    correlation = motion.correlation.value
    if (correlation < (1.0 - TURNED) * correlation[:1]).any():  # less is lost: nothing to see
        yield "correlation"


def _draw(name: str, tracks: Tracks, motion: Motion, title: str) -> "Figure":
    from walkergen.points.track_figure import tracks_figure
    from walkergen.track.analyse import figures

    if name == "trajectories":
        return tracks_figure(tracks, title)
    return figures.OF_MOTION[name](motion, title)
