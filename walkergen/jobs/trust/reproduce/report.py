"""Report of the reproduction: the paper beside our numbers, and the tables behind the figures."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.analysis.motion import Curve
from walkergen.analysis.values import Value
from walkergen.files import report
from walkergen.files.report import Column, Report, Table
from walkergen.jobs.trust.published import FACTS
from walkergen.jobs.trust.reproduce.compare import Findings, Row, Theory
from walkergen.jobs.trust.reproduce.mechanisms import Mechanism
from walkergen.jobs.trust.reproduce.plane import Runs
from walkergen.jobs.trust.reproduce.sweeps import COUNTINGS, SUMS, TYPES, Assumption, Point

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ON_PLANE = ("contact", "tilt_deg")
POINT = ("contact", "model", "tilt_deg", "plate_speed_mm_s")
SPEED = ("speed_mm_s", "speed_se_mm_s")

MARKS = {"agrees": "=", "agrees within": "=", "differs by": "!", "undecided": "?"}
LEGEND = "± 2 standard errors; = agrees, ! differs, ? undecided: reproduce.md says by how much"


def of(findings: Findings, rows: Sequence[Row], title: str, folder: Path) -> Report:
    """Report of all that was found and compared, which lies in a folder."""
    tables = [table for of_figure in TABLES.values() for table in of_figure(findings)]
    marked = side_by_side(rows, findings.assumptions, _marked)
    return Report(
        name="reproduce",
        title=title,
        tables=[marked, compared(rows), *tables, labels(findings.labels)],
        facts=_facts(findings, rows),
        lines=[LEGEND],
        figures={name: partial(draw, name, findings) for name in TABLES},
        folder=folder,
    )


def _facts(findings: Findings, rows: Sequence[Row]) -> dict[str, Any]:
    listed = [row._asdict() | {"verdict": row.verdict._asdict()} for row in rows]
    ways = [
        {
            "mechanism": way.what,
            "design": way.name,
            "theory": way.theory._asdict(),
            "simulated": way.simulated.speed and way.simulated.speed._asdict(),
            "direction": way.direction,
        }
        for way in findings.mechanisms
    ]
    return {"rows": listed, "mechanisms": ways}


def draw(name: str, findings: Findings) -> "Figure":
    """Draw one of the figures, by its name in TABLES."""
    from walkergen.jobs.trust.reproduce import figures, mechanisms_figure

    if name == "mechanisms":
        return mechanisms_figure.draw(findings.mechanisms)
    return figures.FIGURES[name](findings)


def speeds(name: str, points: Sequence[Point]) -> Table:
    """Mean speed and impact speed with standard errors, a row per ensemble."""
    keys = (*POINT, *SPEED, "impact_speed_mm_s", "impact_speed_se_mm_s", "outcomes")
    rows = [(*_where(point), *_pair(point.speed), *_pair(point.impact_speed), point.outcomes) for point in points]
    return Table(name, rows, keys)


def types(points: Sequence[Point]) -> Table:
    """Share of every type of impacts, and of II and III, a row per ensemble and counting."""
    kinds = (*TYPES, *SUMS)
    shares = [name for kind in kinds for name in (f"share_{kind}", f"share_{kind}_se")]
    rows = [
        (*_where(point), counting, *(number for kind in kinds for number in point.shares[counting, kind]))
        for point in points
        if point.shares
        for counting in COUNTINGS
    ]
    return Table("figure3", rows, (*POINT, "counting", *shares))


def _pair(value: Value | None) -> tuple[float | None, float | None]:
    return (None, None) if value is None else value


def _where(point: Point) -> tuple[str, str, float, float]:
    return point.assumption, point.model, point.tilt_deg, point.plate_speed_mm_s


def theory(theories: Sequence[Theory]) -> Table:
    """Predicted curves, a row for each tilt."""
    rows = [
        (drawn.assumption, drawn.mode, float(tilt), float(speed), float(sd), bool(sticks))
        for drawn in theories
        for tilt, speed, sd, sticks in zip(*drawn.curve, strict=True)
    ]
    keys = ("contact", "mode", "tilt_deg", "speed_mm_s", "speed_sd_mm_s", "a_foot_can_stick")
    return Table("figure2_theory", rows, keys)


def labels(series: Mapping[float, Sequence[Point]]) -> Table:
    """Speeds in space, a row per restitution and tilt."""
    rows = [
        (label, point.tilt_deg, *_pair(point.speed), point.outcomes)
        for label, points in series.items()
        for point in points
    ]
    return Table("figure2_labels", rows, ("restitution", "tilt_deg", *SPEED, "outcomes"))


def squares(plane: Sequence[Runs]) -> Table:
    """Mean squared displacement on a plane, a row for each tilt and lag."""
    rows = _curves(plane, lambda runs: {"": runs.motion.msd})
    return Table("figure6", rows, (*ON_PLANE, "lag_s", "msd_mm2", "msd_se_mm2"))


def exponents(plane: Sequence[Runs]) -> Table:
    """Local exponent of the squared displacement, a row for each tilt and lag."""
    rows = _curves(plane, lambda runs: {"": runs.growth.exponents})
    return Table("figure6_exponents", rows, (*ON_PLANE, "lag_s", "exponent", "exponent_se"))


def densities(plane: Sequence[Runs]) -> Table:
    """Densities of displacements along and across, a row for each bin."""
    keys = (*ON_PLANE, "direction", "displacement_mm", "density_per_mm", "density_se_per_mm")

    def both(runs: Runs) -> dict[str, Curve]:
        return {"along": runs.motion.parallel, "across": runs.motion.orthogonal}

    return Table("figure6_densities", _curves(plane, both), keys)


def _curves(plane: Sequence[Runs], of: Callable[[Runs], dict[str, Curve]]) -> list[list[object]]:
    """Rows of curves, with the curve's name where it has one."""
    return [
        [runs.assumption, runs.tilt_deg, *([name] if name else []), *map(float, numbers)]
        for runs in plane
        for name, curve in of(runs).items()
        for numbers in zip(*curve, strict=True)
    ]


def tracks(plane: Sequence[Runs]) -> Table:
    """Tracks on a plane, every 40 ms: y to the left of x."""
    keys = (*ON_PLANE, "particle", "t_s", "x_mm", "y_mm", "theta_rad")
    rows = [
        (
            runs.assumption,
            runs.tilt_deg,
            track.particle,
            float(at * runs.tracks.interval),
            *map(float, track.position[at]),
            float(track.heading[at]),
        )
        for runs in plane
        for track in runs.tracks.tracks
        if track.heading is not None
        for at in range(0, len(track.position), round(runs.motion.lag_s / runs.tracks.interval))
    ]
    return Table("figure6_tracks", rows, keys)


class Way(NamedTuple):
    """Mechanism; the field names are the columns of mechanisms.csv."""

    mechanism: str
    design: str
    theory_mm_s: float
    theory_sd_mm_s: float
    theory: str
    model: str
    simulated_mm_s: float | None
    simulated_se_mm_s: float | None
    ratio: float | None
    ratio_se: float | None
    direction: str
    outcomes: str


def mechanisms(measured: Sequence[Mechanism]) -> Table:
    """Theory and simulation of every mechanism."""
    rows = [
        Way(
            way.what,
            way.name,
            *way.theory,
            way.used,
            way.simulated.model,
            *_pair(way.simulated.speed),
            *_pair(way.ratio),
            way.direction,
            way.simulated.outcomes,
        )
        for way in measured
    ]
    columns = (
        report.text("mechanism", "mechanism"),
        report.text("walker", "design"),
        Column("theory, mm/s", lambda row: f"{number(row.theory_mm_s, row.theory_sd_mm_s)} ({row.theory})"),
        Column("simulated, mm/s", lambda row: number(row.simulated_mm_s, row.simulated_se_mm_s) or "none ended well"),
        Column("simulated / theory", lambda row: number(row.ratio, row.ratio_se)),
        report.text("direction", "direction"),
    )
    return Table("mechanisms", rows, Way._fields, columns, "Three mechanisms")


TABLES: Mapping[str, Callable[[Findings], Sequence[Table]]] = {
    "figure2": lambda findings: [speeds("figure2", findings.tilts), theory(findings.theories)],
    "figure3": lambda findings: [types(findings.tilts)],
    "figure5": lambda findings: [speeds("figure5", findings.drives)],
    "figure6": lambda findings: [*(table(findings.plane) for table in (squares, exponents, densities, tracks))],
    "mechanisms": lambda findings: [mechanisms(findings.mechanisms)],
}
"""Tables of the numbers that each figure shows."""


def compared(rows: Sequence[Row]) -> Table:
    """Comparisons with the paper's words and their place, a row each."""
    keys = (
        "fact",
        "figure",
        "quote",
        "where",
        "quantity",
        "unit",
        "stated",
        "margin",
        "model",
        "contact",
        "ours",
        "ours_se",
        "verdict",
        "by",
    )
    lines = [
        (
            *FACTS[row.fact][:6],
            FACTS[row.fact].claim,
            FACTS[row.fact].margin,
            row.model,
            row.assumption,
            row.ours,
            row.se,
            row.verdict.word,
            row.verdict.by,
        )
        for row in rows
    ]
    return Table("reproduce", lines, keys)


def side_by_side(rows: Sequence[Row], assumptions: Sequence[Assumption], cell: Callable[[Row], str]) -> Table:
    """Table to read: a row for a fact and a model, a column for a set of contact numbers."""
    keys = ("the paper", "our number from", *(assumption.label for assumption in assumptions))
    lines, last = [], ""
    for fact, model in dict.fromkeys((row.fact, row.model) for row in rows):
        same = {row.assumption: row for row in rows if (row.fact, row.model) == (fact, model)}
        cells = [cell(same[assumption.name]) if assumption.name in same else "" for assumption in assumptions]
        lines.append((f"{name(fact)}: {FACTS[fact].claim}" if fact != last else "", model, *cells))
        last = fact
    return Table("comparison", lines, keys, report.every(keys, keys))


def name(fact: str) -> str:
    """Number and quantity of a fact."""
    return f"{list(FACTS).index(fact) + 1}. {FACTS[fact].quantity}"


def verdict(row: Row) -> str:
    """Our number and the verdict on it."""
    return ": ".join(filter(None, (number(row.ours, row.se), str(row.verdict))))


def _marked(row: Row) -> str:
    """Our number and the mark of the verdict on it."""
    return "-" if row.ours is None else f"{number(row.ours, row.se)} {MARKS[row.verdict.word]}"


def number(value: float | None, se: float | None) -> str:
    """Format a number to the first digits that its error leaves, with twice the error (95 %)."""
    if value is None:
        return ""
    wide = 2.0 * (se or 0.0)
    if wide < 0.005:
        return f"{value:.3g}"
    digits = max(0, -int(f"{wide:e}".split("e")[1]) + (f"{wide:e}"[0] in "12"))
    digits = min(digits, 2)
    return f"{round(value, digits) + 0.0:.{digits}f} ± {wide:.{digits}f}"
