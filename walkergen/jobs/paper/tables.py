"""Tables of the reproduction: CSV with every digit, a page and a console table to read."""

from collections.abc import Callable, Iterator, Mapping, Sequence

from rich import box
from rich.table import Table

from walkergen.analysis.motion import Curve
from walkergen.files.tables import csv_text
from walkergen.jobs.paper.compare import Row, Theory
from walkergen.jobs.paper.plane import Runs
from walkergen.jobs.paper.sweeps import COUNTINGS, SUMS, TYPES, Assumption, Point
from walkergen.published import FACTS

ON_PLANE = ("contact", "tilt_deg")
POINT = ("contact", "model", "tilt_deg", "plate_speed_mm_s")


def speeds_to_csv(points: Sequence[Point]) -> str:
    """Format as CSV, a line per ensemble: mean speed and impact speed with standard errors."""
    columns = (*POINT, "speed_mm_s", "speed_se_mm_s", "impact_speed_mm_s", "impact_speed_se_mm_s")
    rows = (
        [*_where(point), *(point.speed or ("", "")), *(point.impact_speed or ("", "")),
         point.outcomes]
        for point in points
    )  # fmt: skip
    return csv_text((*columns, "outcomes"), rows)


def types_to_csv(points: Sequence[Point]) -> str:
    """Format as CSV, a line per ensemble and counting: share of every type, and of II and III."""
    kinds = (*TYPES, *SUMS)
    shares = [name for kind in kinds for name in (f"share_{kind}", f"share_{kind}_se")]
    rows = (
        [*_where(point), counting,
         *(number for kind in kinds for number in point.shares[counting, kind])]
        for point in points if point.shares
        for counting in COUNTINGS
    )  # fmt: skip
    return csv_text((*POINT, "counting", *shares), rows)


def theory_to_csv(theories: Sequence[Theory]) -> str:
    """Format as CSV, a line for each tilt of each predicted curve."""
    rows = (
        [theory.assumption, theory.mode, float(tilt), float(speed), float(sd), bool(sticks)]
        for theory in theories
        for curve in (theory.curve,)
        for tilt, speed, sd, sticks in zip(
            curve.tilt_deg, curve.speed, curve.sd, curve.can_stick, strict=True
        )
    )
    columns = ("contact", "mode", "tilt_deg", "speed_mm_s", "speed_sd_mm_s", "a_foot_can_stick")
    return csv_text(columns, rows)


def labels_to_csv(labels: Mapping[float, Sequence[Point]]) -> str:
    """Format as CSV the speeds in space, a line per restitution and tilt."""
    rows = (
        [label, point.tilt_deg, *(point.speed or ("", "")), point.outcomes]
        for label, series in labels.items()
        for point in series
    )
    return csv_text(("restitution", "tilt_deg", "speed_mm_s", "speed_se_mm_s", "outcomes"), rows)


def squares_to_csv(plane: Sequence[Runs]) -> str:
    """Format as CSV, a line for each tilt and lag: mean squared displacement on a plane."""
    columns = (*ON_PLANE, "lag_s", "msd_mm2", "msd_se_mm2")
    return csv_text(columns, _curves(plane, lambda one: {"": one.motion.msd}))


def exponents_to_csv(plane: Sequence[Runs]) -> str:
    """Format as CSV, a line for each tilt and lag: local exponent of the squared displacement."""
    columns = (*ON_PLANE, "lag_s", "exponent", "exponent_se")
    return csv_text(columns, _curves(plane, lambda one: {"": one.growth.exponents}))


def densities_to_csv(plane: Sequence[Runs]) -> str:
    """Format as CSV, a line for each bin: densities of displacements along and across."""
    columns = (*ON_PLANE, "direction", "displacement_mm", "density_per_mm", "density_se_per_mm")

    def both(one: Runs) -> dict[str, Curve]:
        return {"along": one.motion.parallel, "across": one.motion.orthogonal}

    return csv_text(columns, _curves(plane, both))


def _curves(
    plane: Sequence[Runs], of: Callable[[Runs], dict[str, Curve]]
) -> Iterator[list[object]]:
    """Rows of curves, with the curve's name where it has one."""
    for one in plane:
        for name, curve in of(one).items():
            start = [one.assumption, one.tilt_deg, *([name] if name else [])]
            for numbers in zip(*curve, strict=True):
                yield [*start, *map(float, numbers)]


def tracks_to_csv(plane: Sequence[Runs]) -> str:
    """Format as CSV the tracks on a plane, every 40 ms: y to the left of x."""
    columns = (*ON_PLANE, "particle", "t_s", "x_mm", "y_mm", "theta_rad")
    rows = (
        [one.assumption, one.tilt_deg, track.particle, float(at * one.tracks.interval),
         *map(float, track.position[at]), float(track.heading[at])]
        for one in plane
        for track in one.tracks.tracks if track.heading is not None
        for at in range(0, len(track.position), round(one.motion.lag_s / one.tracks.interval))
    )  # fmt: skip
    return csv_text(columns, rows)


def rows_to_csv(rows: Sequence[Row]) -> str:
    """Format as CSV, a line per comparison, with the paper's words and their place."""
    columns = ("fact", "figure", "quote", "where", "quantity", "unit", "stated", "margin", "model",
               "contact", "ours", "ours_se", "verdict", "by")  # fmt: skip
    lines = []
    for row in rows:
        fact = FACTS[row.fact]
        stated = (fact.key, fact.figure, fact.quote, fact.where, fact.quantity, fact.unit)
        ours = (row.model, row.assumption, row.ours, row.se, row.verdict.word, row.verdict.by)
        lines.append([*stated, fact.claim, fact.margin, *ours])
    return csv_text(columns, lines)


def _where(point: Point) -> tuple[str, str, float, float]:
    return point.assumption, point.model, point.tilt_deg, point.plate_speed_mm_s


def to_table(rows: Sequence[Row], assumptions: Sequence[Assumption]) -> Table:
    """Table for a page: a line for a fact and a model, a column for a set of contact numbers."""
    table = Table(box=box.MARKDOWN)
    for heading in ("", "the paper", "our number from", *(one.label for one in assumptions)):
        table.add_column(heading, no_wrap=True)
    for fact, model, first, cells in _lines(rows, assumptions):
        start = (name(fact), FACTS[fact].claim) if first else ("", "")
        table.add_row(*start, model, *(map(_told, cells)))
    return table


def to_console(rows: Sequence[Row], assumptions: Sequence[Assumption]) -> Table:
    """Table for the console, within 80 characters: = agrees, ! differs, ? undecided."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("the paper", "our number from"):
        table.add_column(heading)
    for one in assumptions:
        contact = one.scene.contact
        heading = f"e {contact.restitution:g}\nμ {contact.friction:g}"
        table.add_column(heading, justify="right", no_wrap=True)
    for fact, model, first, cells in _lines(rows, assumptions):
        start = f"{fact} {FACTS[fact].claim}" if first else ""
        table.add_row(start, model, *(map(_marked, cells)))
    return table


def _lines(
    rows: Sequence[Row], assumptions: Sequence[Assumption]
) -> Iterator[tuple[str, str, bool, list[Row | None]]]:
    """Fact, model, True for the fact's first line, and the rows by assumption."""
    last = ""
    for fact, model in dict.fromkeys((row.fact, row.model) for row in rows):
        same = {row.assumption: row for row in rows if (row.fact, row.model) == (fact, model)}
        yield fact, model, fact != last, [same.get(one.name) for one in assumptions]
        last = fact


def name(fact: str) -> str:
    """Number and quantity of a fact."""
    return f"{list(FACTS).index(fact) + 1}. {FACTS[fact].quantity}"


def _told(row: Row | None) -> str:
    if row is None:
        return ""
    if row.ours is None:
        return str(row.verdict)
    return f"{number(row.ours, row.se)}: {row.verdict}"


def _marked(row: Row | None) -> str:
    if row is None or row.ours is None:
        return "-"
    mark = {"agrees": "=", "agrees within": "=", "differs by": "!", "undecided": "?"}
    return f"{number(row.ours, row.se)} {mark[row.verdict.word]}"


def number(value: float, se: float | None) -> str:
    """Format a number to the first digits that its error leaves, with twice the error (95 %)."""
    wide = 2.0 * (se or 0.0)
    if wide < 0.005:
        return f"{value:.3g}"
    digits = max(0, -int(f"{wide:e}".split("e")[1]) + (f"{wide:e}"[0] in "12"))
    digits = min(digits, 2)
    return f"{round(value, digits) + 0.0:.{digits}f} ± {wide:.{digits}f}"
