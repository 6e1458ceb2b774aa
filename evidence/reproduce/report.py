"""Report of the reproduction: the paper compared with our numbers, and the tables behind the figures."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from evidence.published import FACTS
from evidence.reproduce.compare import Findings, Row
from evidence.reproduce.impact_types import COUNTINGS, SUMS, TYPES
from evidence.reproduce.mechanisms import Mechanism
from evidence.reproduce.motion import Runs
from evidence.reproduce.runs import Assumption, Point
from walkergen.analysis.motion import Curve
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.files import report
from walkergen.files.report import Report, Table

SPEED_KEYS = ("speed_mm_s", "speed_se_mm_s")
POINT_KEYS = ("contact", "model", "tilt_deg", "plate_speed_mm_s")

MARKS = {Verdict.AGREE: "=", Verdict.DISAGREE: "!", Verdict.UNDECIDED: "?"}
CAPTION = (
    "Statements of Koumakis, Gnoli, Maggi, Puglisi and Di Leonardo, Mechanism of self-propulsion in 3D-printed active "
    "granular particles (2016), against walkergen's theory and simulations of its own printed geometry"
)
LEGEND = "± 2 standard errors; = agrees, ! disagrees, ? undecided; reproduce.csv says by how much a number is off"


def make_report(findings: Findings, rows: Sequence[Row], folder: Path) -> Report:
    """Report of all that was found and compared, which lies in a folder."""
    tables = [table for of_figure in TABLES.values() for table in of_figure(findings)]
    listed = [row._asdict() | {"ours": row.ours.value, "se": row.ours.se} for row in rows]
    verdicts = [{"verdict": row.verdict.value, "off": row.distance} for row in rows]
    return Report(
        name="reproduce",
        title="The paper, side by side",
        caption=CAPTION,
        tables=[readable_table(rows, findings.assumptions), comparison_table(rows), *tables],
        facts={
            "rows": [own | word for own, word in zip(listed, verdicts, strict=True)],
            "mechanisms": list(mechanism_table(findings.mechanisms)),
        },
        lines=[LEGEND],
        folder=folder,
    )


def _value_and_error(quantity: Quantity) -> tuple[float | None, float | None]:
    return quantity.value, quantity.se


def _point_cells(point: Point) -> tuple[str, str, float, float]:
    return point.assumption.name, point.model, point.tilt_deg, point.plate_speed_mm_s


def speed_table(name: str, points: Sequence[Point]) -> Table:
    """Mean speed and impact speed with standard errors, a row per ensemble."""
    keys = (*POINT_KEYS, *SPEED_KEYS, "impact_speed_mm_s", "impact_speed_se_mm_s", "outcomes")
    rows = [
        (*_point_cells(point), *_value_and_error(point.speed), *_value_and_error(point.impact_speed), point.outcomes)
        for point in points
    ]
    return Table(name, rows, keys)


def type_table(points: Sequence[Point]) -> Table:
    """Share of every type of impacts, and of II and III, a row per ensemble and counting."""
    kinds = (*TYPES, *SUMS)
    rows = [
        (
            *_point_cells(point),
            counting,
            *(number for kind in kinds for number in _value_and_error(point.shares[counting, kind])),
        )
        for point in points
        if point.shares
        for counting in COUNTINGS
    ]
    names = [name for kind in kinds for name in (f"share_{kind}", f"share_{kind}_se")]
    return Table("figure3", rows, (*POINT_KEYS, "counting", *names))


def theory_table(findings: Findings) -> Table:
    """Predicted curves, a row for each tilt."""
    rows = [
        (drawn.assumption, drawn.mode, float(tilt), float(speed), float(sd), bool(sticks))
        for drawn in findings.theories
        for tilt, speed, sd, sticks in zip(*drawn.curve, strict=True)
    ]
    keys = ("contact", "mode", "tilt_deg", "speed_mm_s", "speed_sd_mm_s", "a_foot_can_stick")
    return Table("figure2_theory", rows, keys)


def restitution_table(series: Mapping[float, Sequence[Point]]) -> Table:
    """Speeds in space, a row per restitution and tilt."""
    rows = [(e, p.tilt_deg, *_value_and_error(p.speed), p.outcomes) for e, points in series.items() for p in points]
    return Table("figure2_restitutions", rows, ("restitution", "tilt_deg", *SPEED_KEYS, "outcomes"))


def plane_tables(plane: Sequence[Runs]) -> list[Table]:
    """Squared displacements, their exponents, densities and tracks every 40 ms: y to the left of x."""

    def table(name: str, keys: tuple[str, ...], of: Callable[[Runs], dict[str, Curve]]) -> Table:
        rows = [
            [runs.assumption, runs.tilt_deg, *([way] if way else []), *map(float, numbers)]
            for runs in plane
            for way, curve in of(runs).items()
            for numbers in zip(*curve, strict=True)
        ]
        return Table(name, rows, ("contact", "tilt_deg", *keys))

    tracks = []
    for runs in plane:
        interval = runs.tracks.interval
        for track in runs.tracks.tracks:
            assert track.heading is not None
            for at in range(0, len(track.position), round(runs.motion.lag_s / interval)):
                place = (*map(float, track.position[at]), float(track.heading[at]))
                tracks.append((runs.assumption, runs.tilt_deg, track.particle, float(at * interval), *place))
    density = ("direction", "displacement_mm", "density_per_mm", "density_se_per_mm")
    ways = ("contact", "tilt_deg", "particle", "t_s", "x_mm", "y_mm", "theta_rad")
    return [
        table("figure6", ("lag_s", "msd_mm2", "msd_se_mm2"), lambda runs: {"": runs.motion.msd}),
        table("figure6_exponents", ("lag_s", "exponent", "exponent_se"), lambda runs: {"": runs.growth.exponents}),
        table(
            "figure6_densities", density, lambda runs: {"along": runs.motion.parallel, "across": runs.motion.orthogonal}
        ),
        Table("figure6_tracks", tracks, ways),
    ]


class Way(NamedTuple):
    """Mechanism; the field names are the columns of mechanisms.csv."""

    mechanism: str
    design: str
    theory_mm_s: float | None
    theory_sd_mm_s: float | None
    theory: str
    model: str
    simulated_mm_s: float | None
    simulated_se_mm_s: float | None
    ratio: float | None
    ratio_se: float | None
    direction: str
    outcomes: str


def mechanism_table(measured: Sequence[Mechanism]) -> Table:
    """Theory and simulation of every mechanism."""
    rows = []
    for way in measured:
        theory = (*_value_and_error(way.theory), way.used, way.simulated.model)
        speeds = (*_value_and_error(way.simulated.speed), *_value_and_error(way.ratio))
        rows.append(Way(way.what, way.design.name, *theory, *speeds, way.direction, way.simulated.outcomes))
    columns = (
        report.text_column("mechanism", "mechanism"),
        report.text_column("walker", "design"),
        report.error_column("theory, mm/s", "theory_mm_s", "theory_sd_mm_s"),
        report.text_column("by", "theory"),
        report.error_column("simulated, mm/s", "simulated_mm_s", "simulated_se_mm_s"),
        report.error_column("simulated / theory", "ratio", "ratio_se"),
        report.text_column("direction", "direction"),
    )
    return Table("mechanisms", rows, Way._fields, columns, "Three mechanisms")


TABLES: Mapping[str, Callable[[Findings], Sequence[Table]]] = {
    "figure2": lambda findings: [
        speed_table("figure2", findings.tilts),
        theory_table(findings),
        type_table(findings.tilts),
    ],
    "figure2-restitutions": lambda findings: [restitution_table(findings.restitutions)],
    "figure5": lambda findings: [speed_table("figure5", findings.drives)],
    "figure6": lambda findings: plane_tables(findings.plane),
    "mechanisms": lambda findings: [mechanism_table(findings.mechanisms)],
}
"""Tables of the numbers that each part finds."""


def comparison_table(rows: Sequence[Row]) -> Table:
    """Comparisons with the paper's words and their place, a row each."""
    stated = ("fact", "figure", "quote", "where", "quantity", "unit", "stated", "margin")
    ours = ("model", "contact", "ours", "ours_se", "verdict", "by")
    lines = []
    for row in rows:
        fact, numbers = FACTS[row.fact], (*_value_and_error(row.ours), row.verdict.value, row.distance)
        lines.append((*fact[:6], fact.claim, fact.margin, row.model, row.assumption, *numbers))
    return Table("reproduce", lines, (*stated, *ours))


def readable_table(rows: Sequence[Row], assumptions: Sequence[Assumption]) -> Table:
    """Table to read: a row for a fact and a model, a column for a set of contact numbers."""
    keys = ("the paper", "our number from", *(assumption.label for assumption in assumptions))
    lines, last = list[tuple[Any, ...]](), ""
    for fact, model in dict.fromkeys((row.fact, row.model) for row in rows):
        same = {row.assumption: _format_with_mark(row) for row in rows if (row.fact, row.model) == (fact, model)}
        cells = [same.get(assumption.name, "") for assumption in assumptions]
        lines.append((f"{fact_name(fact)}: {FACTS[fact].claim}" if fact != last else "", model, *cells))
        last = fact
    return Table("comparison", lines, keys, report.key_columns(keys, keys))


def fact_name(fact: str) -> str:
    """Return the number and quantity of a fact."""
    return f"{list(FACTS).index(fact) + 1}. {FACTS[fact].quantity}"


def _format_with_mark(row: Row) -> str:
    """Our number and the mark of the verdict on it."""
    return f"{format_number(row.ours)} {MARKS[row.verdict]}" if row.ours.value is not None else "-"


def format_number(quantity: Quantity) -> str:
    """Format a number to the first digits that its error leaves, with twice the error (95 %)."""
    if quantity.value is None:
        return ""
    wide = 2.0 * (quantity.se or 0.0)
    if wide < 0.005:
        return f"{quantity.value:.3g}"
    digits = max(0, -int(f"{wide:e}".split("e")[1]) + (f"{wide:e}"[0] in "12"))
    digits = min(digits, 2)
    return f"{round(quantity.value, digits) + 0.0:.{digits}f} ± {wide:.{digits}f}"
