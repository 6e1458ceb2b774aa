"""Tables of predictions: CSV with every digit, Markdown and console with those that matter."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

from rich import box
from rich.table import Table

from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text
from walkergen.theory.prediction import Prediction

if TYPE_CHECKING:
    from walkergen.simulation.ensemble import Summary

HEADINGS = (
    "tilt", "legs", "M", "J", "m", "j", "speed", "68 %", "95 %", "eq. 15", "back", "front", "mean",
)  # fmt: skip
UNITS = (
    "deg", "", "g", "g mm²", "g", "g mm²", "mm/s", "mm/s", "mm/s", "mm/s", "v/w", "v/w", "v/w",
)  # fmt: skip
DETAILS = ("J", "j", "back", "front", "mean")
"""Columns that the console omits, to fit into 80 characters."""
MORE_DETAILS = (*DETAILS, "M", "m", "95 %")
"""Columns that it omits beside simulated speeds."""
RUNS = (
    "mean of the runs in place of the theory's speed; its bounds hold their scatter and step, not "
    "what is not known of contact and print: simulate --uncertain"
)
"""Note on a speed that runs gave."""

SURE = 1.96
"""Standard deviations on either side that hold a normal number with 95 %."""

SMALL = 0.5
"""Difference of speeds, mm/s, that verdicts in whole mm/s do not see."""


class Simulated(NamedTuple):
    """Results of a member's ensemble in the family's table; the field names are columns."""

    sim_speed_mm_s: float | None
    sim_se_mm_s: float | None
    """Standard error of the simulated speed; None when the data are too few."""
    sim_low_95_mm_s: float | None
    sim_high_95_mm_s: float | None
    sim_model: str
    sim_method: str
    sim_outcomes: str
    verdict: str
    """Agreement of the predicted speed with the simulated one."""


def verdict(row: Prediction, summary: "Summary") -> str:
    """Say whether the bounds of 95 % of the runs meet those of 68 % of the prediction.

    Speeds within SMALL agree. A prediction by the theory alone gives way to the runs.
    """
    speed, low, high = summary.speed_mm_s, summary.speed_low_95_mm_s, summary.speed_high_95_mm_s
    if speed is None or low is None or high is None:
        return "unknown"
    if row.speed_by == "theory":
        return "the runs stand"
    off = row.speed_mm_s - speed
    meet = low <= row.speed_high_68_mm_s and row.speed_low_68_mm_s <= high
    return "agree" if meet or abs(off) <= SMALL else f"off by {off:+.0f}"


def with_runs(row: Prediction, one: Simulated) -> Prediction:
    """Row in which the speed of the runs stands for the theory's, where they tell one."""
    speed, low, high = one.sim_speed_mm_s, one.sim_low_95_mm_s, one.sim_high_95_mm_s
    if row.speed_by != "theory" or speed is None or low is None or high is None:
        return row
    return row._replace(
        speed_mm_s=speed, speed_sd_mm_s=0.5 * (high - low) / SURE, speed_by="runs",
        speed_low_68_mm_s=speed + (low - speed) / SURE,
        speed_high_68_mm_s=speed + (high - speed) / SURE,
        speed_low_95_mm_s=low, speed_high_95_mm_s=high, note=RUNS,
    )  # fmt: skip


class Weighing(NamedTuple):
    """Weighed mass of a member beside its mesh's; the field names are columns."""

    weighings: int
    """Number of weighings on which the row rests."""
    mass_g: float
    """Mass of the whole walker used for the prediction, g."""
    mass_se_g: float | None
    """Standard error of `mass_g`; None when it is not known."""
    mass_mesh_g: float
    speed_mesh_mm_s: float
    """Speed predicted with the mesh's masses."""


def to_csv(
    rows: Sequence[Prediction],
    simulated: Sequence[Simulated] = (),
    weighed: Sequence[Weighing] = (),
) -> str:
    """Format as CSV, a line per member; columns are the rows' fields, numbers have every digit."""
    tables = [table for table in (rows, simulated, weighed) if table]
    header = [field for table in tables for field in table[0]._fields]
    lines = ([value for part in row for value in part] for row in zip(*tables, strict=True))
    return csv_text(header, lines)


def weighed_table(
    rows: Sequence[Prediction], weighed: Sequence[Weighing], style: box.Box = box.SIMPLE_HEAD
) -> Table:
    """Table of weighed masses and their speeds beside those of the mesh."""
    table = Table(box=style, padding=(0, 1 if style is box.MARKDOWN else 0))
    for heading in ("tilt", "legs", "weighings", "mass\ng", "mesh's\ng", "speed\nmm/s",
                    "mesh's\nmm/s", "change\nmm/s"):  # fmt: skip
        text = heading if style is not box.MARKDOWN else heading.replace("\n", " ")
        table.add_column(text, justify="left" if heading == "legs" else "right", no_wrap=True)
    for row, one in zip(rows, weighed, strict=True):
        error = "" if one.mass_se_g is None else f" ± {words.number(one.mass_se_g, 2)}"
        table.add_row(
            f"{row.tilt_deg:g}", row.legs, str(one.weighings), f"{_short(one.mass_g)}{error}",
            _short(one.mass_mesh_g), _fixed(row.speed_mm_s, 2), _fixed(one.speed_mesh_mm_s, 2),
            _fixed(row.speed_mm_s - one.speed_mesh_mm_s, 2),
        )  # fmt: skip
    return table


WEIGHED = (
    "Weighed: whole walkers alone (grams) scale every mass alike, which changes the predicted "
    "speed by the legs' frequency alone; a body or leg weighed apart (body_g, leg_g) changes it "
    "more."
)


def to_table(
    rows: Sequence[Prediction], title: str = "", simulated: Sequence[Simulated] = ()
) -> Table:
    """Table for the console; rows with a note carry its number."""
    table = Table(title=title or None, box=box.SIMPLE_HEAD, padding=(0, 0))
    columns = _columns(rows, simulated)
    omitted = MORE_DETAILS if simulated else DETAILS
    shown = [name for name in columns if name[0] not in omitted]
    for heading, unit in shown:
        left = heading in ("legs", "simulated", "ended", "verdict")
        justify: Literal["left", "right"] = "left" if left else "right"
        table.add_column(f"{heading}\n{unit}", justify=justify, no_wrap=heading != "ended")
    for cells in zip(*(columns[name] for name in shown), strict=True):
        table.add_row(*cells)
    return table


def to_markdown(
    rows: Sequence[Prediction], title: str, caption: str, simulated: Sequence[Simulated] = ()
) -> str:
    """Format a Markdown page with the table and its notes."""
    table = Table(box=box.MARKDOWN)
    columns = _columns(rows, simulated)
    for heading, unit in columns:
        name = f"{heading} ({unit})" if unit else heading
        table.add_column(name, justify="left" if heading == "legs" else "right", no_wrap=True)
    for cells in zip(*columns.values(), strict=True):
        table.add_row(*cells)
    body = as_markdown(table)
    listed = "\n".join(f"{number}. {note}" for number, note in enumerate(notes_of(rows), start=1))
    return f"# {title}\n\n{caption}\n\n{body}\n\n{listed}\n".rstrip() + "\n"


def weighed_markdown(rows: Sequence[Prediction], weighed: Sequence[Weighing]) -> str:
    """Format the table of weighed masses as a section of a Markdown page."""
    return (
        f"\n## Weighed\n\n{WEIGHED}\n\n{as_markdown(weighed_table(rows, weighed, box.MARKDOWN))}\n"
    )


def _columns(
    rows: Sequence[Prediction], simulated: Sequence[Simulated]
) -> dict[tuple[str, str], list[str]]:
    """Columns of cells by (heading, unit)."""
    notes = notes_of(rows)
    cells = zip(*(_cells(row, notes) for row in rows), strict=True)
    columns = {
        key: list(column)
        for key, column in zip(zip(HEADINGS, UNITS, strict=True), cells, strict=True)
    }
    if simulated:
        columns["simulated", "mm/s, 95 %"] = [_simulated(one) for one in simulated]
        columns["verdict", ""] = [one.verdict for one in simulated]
        columns["model", ""] = [one.sim_model for one in simulated]
        columns["ended", ""] = [one.sim_outcomes for one in simulated]
    return columns


def _simulated(one: Simulated) -> str:
    if one.sim_speed_mm_s is None:
        return "-"
    bounds = _range(one.sim_low_95_mm_s, one.sim_high_95_mm_s)
    return f"{_fixed(one.sim_speed_mm_s, 1)}, {bounds}"


def notes_of(rows: Sequence[Prediction]) -> list[str]:
    """List the distinct notes of a table in order; note k is marked [k] in the table."""
    return list(dict.fromkeys(row.note for row in rows if row.note))


def _cells(row: Prediction, notes: list[str]) -> list[str]:
    mark = f" [{notes.index(row.note) + 1}]" if row.note else ""
    return [
        f"{row.tilt_deg:g}",
        row.legs,
        _short(row.M_g),
        _short(row.J_g_mm2),
        _short(row.m_g),
        _short(row.j_g_mm2),
        f"{_fixed(row.speed_mm_s, 1)}{mark}",
        _range(row.speed_low_68_mm_s, row.speed_high_68_mm_s),
        _range(row.speed_low_95_mm_s, row.speed_high_95_mm_s),
        _fixed(row.theory_mm_s, 1),
        _fixed(row.factor_back, 3),
        _fixed(row.factor_front, 3),
        _fixed(row.factor_mean, 3),
    ]


def _range(low: float | None, high: float | None) -> str:
    """Format bounds, or say that they are unknown."""
    return "unknown" if low is None or high is None else f"{_fixed(low, 0)} to {_fixed(high, 0)}"


def _fixed(value: float, digits: int) -> str:
    """Format a number with fixed decimals, without a minus on zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _short(value: float | None) -> str:
    """Format four significant digits with trailing zeros; a dash for a missing value."""
    return "-" if value is None else f"{value:#.4g}".rstrip(".")
