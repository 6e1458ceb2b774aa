"""Report of measured motion: estimates, each walker, speeds by plate speed, and curves."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from walkergen.analysis import facts, track_warnings
from walkergen.analysis.estimates import HEADINGS_KNOWN_REASON, LANE_REASON, NO_HEADINGS_REASON, NO_SLOPE_REASON, UNITS
from walkergen.analysis.facts import WALKER_ESTIMATES
from walkergen.analysis.motion import Motion
from walkergen.analysis.particle_scatter import WalkerMeans
from walkergen.analysis.tracks import Tracks
from walkergen.core import Quantity
from walkergen.core.files import formatting
from walkergen.files import quantity_format
from walkergen.files.report import Column, Report, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_WALKERS = 24
"""Largest number of walkers in a table that is printed."""

MIN_TURNED_SHARE = 0.05
"""Relative loss of the direction's autocorrelation below which its figure is left out, as walkers do not turn."""


@dataclass(frozen=True, kw_only=True, repr=False)
class AnalysisReport(Report):
    """Motion measured from tracks, each number with its error or the reason why it has none."""

    motion: Motion
    """Measured motion: estimates, walkers and curves."""
    notes: Sequence[str]
    """Sentences on the method, on doubts, and on omitted rows."""

    @property
    def estimates(self) -> dict[str, Quantity]:
        """Estimates by name: value, standard error, and the reason where both are None."""
        counted = self.motion.counted
        return {name: number._replace(sample=counted.get(name, "")) for name, number in self.motion.estimates.items()}

    @property
    def speed(self) -> Quantity:
        """Mean speed, mm/s, with its standard error; the reason where both are None."""
        return self.estimates["speed"]


ESTIMATE_COLUMNS = ("quantity", "value", "se", "scale_se", "low_95", "high_95", "refused", "walkers")
"""Columns of analysis.csv. scale_se: error from the film's scale, which all lengths share. refused: reason why a value
is missing. walkers: number of measured walkers, if not all."""

SPEED_COLUMNS = ("speed_mm_s", "speed_se_mm_s")
WALKER_COLUMNS = (
    "particle",
    "seen_s",
    *SPEED_COLUMNS,
    "speed_low_95_mm_s",
    "speed_high_95_mm_s",
    "turning_rad_s",
    "turning_se_rad_s",
    "refused",
)
"""Columns of walkers.csv, one row per walker."""

PLATE_SPEED_COLUMNS = ("plate_speed_mm_s", *SPEED_COLUMNS, "speed_scale_se_mm_s", "refused", "walkers")
"""Columns of plate_speed.csv."""


def make_report(tracks: Tracks, motion: Motion, title: str, folder: Path | None = None) -> AnalysisReport:
    """Return the report of the motion of tracks. `title`: name of their file. `folder`: None if nothing is written."""
    fit = motion.msd_fit.goodness if motion.msd_fit else ""
    reasons = [*track_warnings.find_all(tracks), *motion.doubts, track_warnings.describe_scale_error(motion.scale_se)]
    lines = [motion.method, fit, *reasons, tracks.note]
    notes = [f"{line}." for line in lines if line]
    found = facts.from_motion(motion) | {"bad_rows": tracks.bad_rows, "notes": notes}
    for walker in found["walkers"] if tracks.names else ():
        walker["name"] = tracks.names[walker["particle"]]
    hidden = len(motion.walkers) - MAX_WALKERS
    counted = [f"and {hidden} more walkers in walkers.csv"] if hidden > 0 else []
    headless = sum(number.refused == NO_HEADINGS_REASON for number in motion.estimates.values())
    counted += [f"{NO_HEADINGS_REASON}: {headless} more numbers need them"] if headless else []
    draw = partial(_draw_figure, tracks=tracks, motion=motion, title=title)
    return AnalysisReport(
        name="analysis",
        title=title,
        caption=f"{title}, displacements within {1e3 * motion.lag_s:g} ms",
        tables=list(_tables(motion, tracks.names)),
        facts=found,
        lines=[*counted, *_describe_line(motion), *notes],
        figures={name: partial(draw, name) for name in _figure_names(motion)},
        folder=folder,
        motion=motion,
        notes=notes,
    )


def _tables(motion: Motion, names: Mapping[int, str]) -> Iterator[Table]:
    """Yield the tables of a motion: estimates, walkers, and speeds by plate speed or curves."""
    estimates = {number.column: number for number in map(motion.estimates.__getitem__, UNITS)}
    rows = [
        (
            *(key, number.value, number.se, facts.scale_se(number, motion)),
            *(number.low_95, number.high_95, number.refused),
            "" if number.value is None else motion.counted.get(number.key, ""),
        )
        for key, number in estimates.items()
    ]
    if motion.by_plate_speed:
        yield _plate_speed_table(motion)
        yield Table("analysis", rows, ESTIMATE_COLUMNS)
        yield _walker_table(motion, names)
        return
    name, unit, value, bounds = quantity_format.columns(lambda row: estimates[row[0]])
    value = value._replace(cell=lambda row: _format_with_scale(estimates[row[0]], row[-1], motion))
    columns = [name, unit, value, bounds]
    readable = [
        row for row in rows if row[-2] not in (LANE_REASON, HEADINGS_KNOWN_REASON, NO_HEADINGS_REASON, NO_SLOPE_REASON)
    ]
    yield Table("analysis", rows, ESTIMATE_COLUMNS, columns, "Motion", read=readable)
    yield _walker_table(motion, names)
    yield from _curve_tables(motion)


def _format_with_scale(number: Quantity, count: str, motion: Motion) -> str:
    """Format a value with its error, that due to the film's scale, and the `count` of walkers if it is not of all."""
    by_scale = facts.scale_se(number, motion)
    scale = f" ± {formatting.format_number(by_scale, 2)} (scale)" if by_scale and number.known else ""
    return quantity_format.format_value(number) + scale + (f" ({count})" if count else "")


def _plate_speed_table(motion: Motion) -> Table:
    """Return the table of mean speeds by plate speed."""
    speeds = {plate: (speed, "" if speed.value is None else count) for plate, speed, count in motion.by_plate_speed}
    rows = [
        (plate, speed.value, speed.se, facts.scale_se(speed, motion), speed.refused, count)
        for plate, (speed, count) in speeds.items()
    ]
    columns = (
        Column("plate speed (mm/s)", lambda row: f"{row[0]:g}"),
        Column("speed (mm/s)", lambda row: _format_with_scale(*speeds[row[0]], motion)),
    )
    return Table("plate_speed", rows, PLATE_SPEED_COLUMNS, columns, "Speed by plate speed")


def _walker_table(motion: Motion, names: Mapping[int, str]) -> Table:
    """Return the table of single walkers, with their names if they have any; the report prints the first ones."""
    rows, by_number = [], {walker.particle: walker for walker in motion.walkers}
    for walker in motion.walkers:
        speed, turning = (walker.mean(name) for name in WALKER_ESTIMATES)
        numbers = (speed.value, speed.se, speed.low_95, speed.high_95, turning.value, turning.se)
        name = (names[walker.particle],) if names else ()
        rows.append((walker.particle, walker.seconds, *numbers, speed.refused, *name))
    turns = any("turning_bias" in walker.means for walker in motion.walkers)
    headings = ("speed (mm/s)", "turning (rad/s)")[: 1 + turns]
    columns = [
        Column("walker", lambda row: names.get(row[0], str(row[0]))),
        Column("seen (s)", lambda row: formatting.format_number(row[1], 3), right=True),
        *(
            Column(heading, _walker_cell(name, by_number))
            for heading, name in zip(headings, WALKER_ESTIMATES, strict=False)
        ),
    ]
    keys = (*WALKER_COLUMNS, "name") if names else WALKER_COLUMNS
    return Table("walkers", rows, keys, columns, "Walkers", read=rows[:MAX_WALKERS])


def _walker_cell(name: str, by_number: Mapping[int, WalkerMeans]) -> Callable[[tuple[int, ...]], str]:
    """Return a function that formats the estimate `name` of a row's walker. The row begins with its particle number."""
    return lambda row: quantity_format.format_value(by_number[row[0]].mean(name))


def _describe_line(motion: Motion) -> Iterator[str]:
    """Yield a text on the line of speed against plate speed; nothing unless the motion has such a line."""
    line = motion.line
    if line is None:
        return
    scale = facts.scale_se(line.slope._replace(unit="mm_s"), motion)
    scale_error = f" ± {formatting.format_number(scale, 2)} by the scale" if scale else ""
    yield (
        f"speed = ({formatting.format_with_error(*line.slope.pair)}{scale_error}) x plate speed, a "
        f"line through the origin; chi² {formatting.format_number(line.chi2)} for {line.points - 1} degrees of "
        f"freedom, probability {formatting.format_number(line.p_value, 2)}"
    )


def _curve_tables(motion: Motion) -> Iterator[Table]:
    """Yield the tables of the curves, which the report does not print."""
    squared = (*motion.msd, facts.scale_errors(motion), *motion.exponent[1:])
    keys = ("lag_s", "msd_mm2", "se_mm2", "scale_se_mm2", "exponent", "exponent_se")
    yield Table("msd", facts.curve_points(squared), keys)
    yield Table("correlation", facts.curve_points(motion.correlation), ("lag_s", "value", "se"))
    sides = {"parallel": motion.parallel, "orthogonal": motion.orthogonal}
    rows = [(name, *point) for name, curve in sides.items() for point in facts.curve_points(curve)]
    yield Table("density", rows, ("direction", "mm", "density_per_mm", "se_per_mm"))


def _figure_names(motion: Motion) -> Iterator[str]:
    """Yield the names of the figures for which the motion has data."""
    yield "trajectories"
    if motion.by_plate_speed:
        yield "plate_speed"
        return
    if sum(walker.mean("speed").value is not None for walker in motion.walkers) > 1:
        yield "walkers"
    if (motion.msd.value > 0).any():
        yield "msd"
    if len(motion.parallel.at):
        yield "density"
    correlation = motion.correlation.value
    if (correlation < (1.0 - MIN_TURNED_SHARE) * correlation[:1]).any():  # if less is lost, the curve is flat
        yield "correlation"


def _draw_figure(name: str, tracks: Tracks, motion: Motion, title: str) -> "Figure":
    from walkergen.guests.track.analyse import figures
    from walkergen.points.track_figure import draw_tracks

    if name == "trajectories":
        return draw_tracks(tracks, title)
    return figures.MOTION_FIGURES[name](motion, title)
