"""Report of the checks of crowds in a plane: a row a quantity of space and of the plane, with their verdict."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from evidence.crowd_checks.checks import Cases
from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table
from walkergen.numerics.quantity import Quantity, Verdict

NAME = "crowd_checks"

MARGIN = 0.1
"""Share of the number of space by which the plane may differ: a card that is off by more moves who meets whom."""

ALLOWED = {"": 0.05, "deg": 2.0, "mm": 0.3, "rad_s": 0.05}
"""The same by units, of what may be near 0: a twentieth of an order or a share; a turn of two degrees, hardly seen
in a film; a way of 1 mm/s in 0.3 s; a turn of three degrees a second."""

KEYS = (
    *("check", "case", "quantity", "space", "space_se", "plane", "plane_se"),
    *("apart", "apart_low_95", "apart_high_95", "verdict"),
)
"""Columns of crowd_checks.csv."""

LEGEND = (
    "± one standard error: alone over runs, of pairs over pairs, of crowds over runs; apart are the bounds of 95 % of "
    "plane less space, in the single check by the plane's error alone, whose input is the card of space. They agree "
    f"where these bounds lie within {100 * MARGIN:g} % of space, or within {ALLOWED['']:g}, {ALLOWED['deg']:g} deg, "
    f"{ALLOWED['mm']:g} mm and {ALLOWED['rad_s']:g} rad/s where that is more; disagree where they lie outside"
)


class Row(NamedTuple):
    """A quantity in space and in the plane."""

    check: str
    """single, binary or collective."""
    case: str
    space: Quantity
    plane: Quantity

    @property
    def expected(self) -> Quantity:
        """What the plane is compared with: in the single check the card's own number, which is its input."""
        return self.space._replace(se=0.0) if self.check == "single" else self.space

    @property
    def apart(self) -> Quantity:
        """Plane less space."""
        return self.plane.less(self.expected)

    @property
    def verdict(self) -> Verdict:
        """Whether the plane has what space has."""
        return self.plane.beside(self.expected, MARGIN, ALLOWED.get(self.space.unit, 0.0))


def rows_of(check: str, space: Cases, plane: Cases) -> Iterator[Row]:
    """Rows of a check: of each quantity that both know with its error."""
    for case, numbers in space.items():
        for key, own in numbers.items():
            rival = plane.get(case, {}).get(key)
            if own.known and rival is not None and rival.known:
                yield Row(check, case, own, rival)


def of(rows: Sequence[Row], folder: Path, notes: Sequence[str]) -> Report:
    """Report of rows that lie in a folder; `notes` say how they were made."""
    cells = [_cells(row) for row in rows]
    columns = (
        report.text("check", "check"),
        report.text("case", "case"),
        Column("number", _name),
        Column("space", lambda row: _stated(row.space)),
        Column("plane", lambda row: _stated(row.plane)),
        Column("apart", _apart),
        report.text("verdict", "verdict"),
    )
    return Report(
        name=NAME,
        title="Walkers in a plane against walkers in space",
        tables=[Table(NAME, cells, KEYS), Table("rows", rows, (), columns, notes=(LEGEND,))],
        facts={"rows": [dict(zip(KEYS, row, strict=True)) for row in cells]},
        lines=[*_counted(rows), *notes],
        folder=folder,
    )


def _cells(row: Row) -> tuple[Any, ...]:
    """Row of the CSV."""
    space, plane, apart = row.space, row.plane, row.apart
    bounds = apart.interval() or (None, None)
    numbers = space.value, space.se, plane.value, plane.se, apart.value, *bounds
    return row.check, row.case, space.column, *numbers, row.verdict.value


def _counted(rows: Sequence[Row]) -> Iterator[str]:
    """How many of each check agree, and what disagrees by how much."""
    for check in dict.fromkeys(row.check for row in rows):
        own = [row for row in rows if row.check == check]
        counts = Counter(row.verdict for row in own)
        yield f"{check}: " + ", ".join(f"{counts[word]} {word}" for word in Verdict if counts[word])
        for row in own:
            if row.verdict == Verdict.DISAGREE:
                yield f"{row.case}, {_name(row)}: {_stated(row.plane)} in the plane, {_stated(row.space)} in space"


def _name(row: Row) -> str:
    unit = row.space.unit.replace("2", "²").replace("_s", "/s")
    return row.space.key.replace("_", " ") + (f" ({unit})" if unit else "")


def _stated(number: Quantity) -> str:
    return words.with_error(number.value or 0.0, number.se or 0.0)


def _apart(row: Row) -> str:
    apart = row.apart
    return " to ".join(words.to_digits_of(apart.se or 0.0, apart.interval() or ()))
