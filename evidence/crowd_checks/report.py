"""Report of the checks of crowds in a plane: a row a quantity of space and of the plane, with their verdict."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from evidence.crowd_checks.checks import Cases
from evidence.crowd_checks.reasons import DENSEST, Changed
from evidence.quantities import compare, ratio
from walkergen.core.files import formatting as words
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.files import report
from walkergen.files.report import Column, Report, Table

NAME = "crowd_checks"

MARGIN = 0.1
"""Largest difference of the plane from space, as a share of the number in space."""

ALLOWED = {"": 0.05, "deg": 2.0, "mm": 0.3, "rad_s": 0.05}
"""Largest difference in each unit, for numbers near 0: a twentieth of an order or a share; a turn of two degrees; a
displacement at 1 mm/s in 0.3 s; a turning rate of three degrees a second."""

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


COMPARED_KEYS = ("speed", "polar_order", "nematic_order", "local_polar_order", "local_nematic_order")
"""Numbers that decide whether cards are valid at a packing, together with g."""

REASON_WORDS = {
    Verdict.AGREE: "",
    Verdict.DISAGREE: ": it is no reason",
    Verdict.UNDECIDED: ", within errors that leave open whether it is a reason",
    Verdict.MISSING: ", which is not known",
}
"""Words on a change as a reason of the difference, by the part of the difference that it removes."""

MIN_REASON_SHARE = 0.2
"""Smallest part of a difference that counts as a reason."""

RATIO_KEY_STARTS = ("speed", "g_")
"""Prefixes of the keys whose ratios are reported: these numbers are never near 0."""

FRICTION_COLUMNS = (
    Column("meeting", lambda row: str(row[0])),
    Column("in the plane", lambda row: _number(row[1]["along"])),
    Column("up or down", lambda row: _number(row[1]["up"])),
)
"""Columns of the impulses of friction."""


class Row(NamedTuple):
    """A quantity in space and in the plane."""

    check: str
    """single, binary or collective."""
    case: str
    space: Quantity
    plane: Quantity

    @property
    def expected(self) -> Quantity:
        """Number that the plane is compared with. In the single check it is the card's number, an input."""
        return self.space._replace(se=0.0) if self.check == "single" else self.space

    @property
    def apart(self) -> Quantity:
        """Plane less space."""
        return self.plane.minus(self.expected)

    @property
    def verdict(self) -> Verdict:
        """Verdict on the number in the plane."""
        return compare(self.plane, self.expected, MARGIN, ALLOWED.get(self.space.unit, 0.0))


class Checked(NamedTuple):
    """Results of the checks."""

    rows: Sequence[Row]
    assumed: float
    """Friction of body on body in space."""
    friction: float
    """Friction of the card in the plane: the friction of pairs in space along their faces."""
    rubbed: Cases
    """Impulses of friction over that along the normal, in the plane (along) and up or down (up), by meeting."""
    gained: Mapping[str, tuple[Quantity, Quantity]]
    """Speed of the second half of a crowd's record over that of the first, less 1, in space and in the plane."""
    changed: Sequence[Changed]
    """Speeds of the densest crowd, changed in one thing."""


def compare_cases(check: str, space: Cases, plane: Cases) -> Iterator[Row]:
    """Yield a row for each quantity that space and plane have with its error."""
    for case, numbers in space.items():
        for key, own in numbers.items():
            rival = plane.get(case, {}).get(key)
            if own.known and rival is not None and rival.known:
                yield Row(check, case, own, rival)


def make_report(checked: Checked, folder: Path, notes: Sequence[str]) -> Report:
    """Return the report of a folder. `notes` describe the runs."""
    rows = checked.rows
    cells = [_csv_row(row) for row in rows]
    columns = (
        report.text_column("check", "check"),
        report.text_column("case", "case"),
        Column("number", _quantity_name),
        Column("space", lambda row: _number(row.space)),
        Column("plane", lambda row: _number(row.plane)),
        Column("apart", _format_difference),
        report.text_column("verdict", "verdict"),
    )
    return Report(
        name=NAME,
        title="Walkers in a plane against walkers in space",
        tables=[
            Table(NAME, cells, KEYS),
            Table("rows", rows, (), columns, notes=(LEGEND,)),
            Table(
                "friction",
                list(checked.rubbed.items()),
                (),
                FRICTION_COLUMNS,
                "Friction of meetings in space, over the normal",
            ),
        ],
        facts={"rows": [dict(zip(KEYS, row, strict=True)) for row in cells]},
        lines=[
            *_count_verdicts(rows),
            _describe_friction(checked),
            *_describe_drift(checked),
            *_describe_packings(rows),
            *_describe_changes(checked),
            *notes,
        ],
        folder=folder,
    )


def _csv_row(row: Row) -> tuple[Any, ...]:
    """Return a row of the CSV file."""
    space, plane, apart = row.space, row.plane, row.apart
    bounds = apart.interval() or (None, None)
    numbers = space.value, space.se, plane.value, plane.se, apart.value, *bounds
    return row.check, row.case, space.column, *numbers, row.verdict.value


def _count_verdicts(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the number of each verdict for each check, and every disagreement."""
    for check in dict.fromkeys(row.check for row in rows):
        own = [row for row in rows if row.check == check]
        counts = Counter(row.verdict for row in own)
        yield f"{check}: " + ", ".join(f"{counts[word]} {word}" for word in Verdict if counts[word])
        for row in own:
            if row.verdict == Verdict.DISAGREE:
                numbers = f"{_number(row.plane)} in the plane, {_number(row.space)} in space"
                yield f"{row.case}, {_quantity_name(row)}: {numbers}"


def _describe_friction(checked: Checked) -> str:
    """Describe the friction in space, with its share up or down the faces, which a plane lacks."""
    up = sum(one["up"].number for one in checked.rubbed.values()) / len(checked.rubbed)
    return (
        f"friction of {checked.assumed:g} gives {checked.friction:.2g} of the normal impulse along the faces in the "
        f"plane, which is the card's friction, and {up:.2g} up or down them, which a plane has not"
    )


DRIFT_WORDS = {
    Verdict.AGREE: f"stationary to {100 * MARGIN:g} %",
    Verdict.DISAGREE: "not stationary",
    Verdict.UNDECIDED: "undecided whether stationary",
    Verdict.MISSING: "not known",
}
"""Words on a change of the speed."""


def _describe_drift(checked: Checked) -> Iterator[str]:
    """Yield whether each crowd was stationary in its record."""
    for case, pair in checked.gained.items():
        changes = [f"{100 * one.number:.2g} ± {100 * (one.se or 0.0):.2g} %" for one in pair]
        still = [DRIFT_WORDS[one.compare_with_range(-MARGIN, MARGIN)] for one in pair]
        yield (
            f"{case}: from the first half of the record to the second the speed changes by {changes[0]} in space "
            f"({still[0]}), by {changes[1]} in the plane ({still[1]})"
        )


def _describe_changes(checked: Checked) -> Iterator[str]:
    """Yield the difference of space and plane in the densest crowd, also after each change."""
    case = f"packing {DENSEST:g}"
    speeds = (row for row in checked.rows if row.case == case and row.space.key == "speed")
    for row in speeds:
        yield f"{case}: the plane is faster by {_number(row.apart)} mm/s, {_number(row.plane)} for {_number(row.space)}"
        for one in checked.changed:
            if one.space is None:
                change = one.plane.minus(row.plane)
                yield f"{case}, {one.name}: the plane has {_number(one.plane)} mm/s, {_number(change)} more than it has"
                continue
            apart = one.plane.minus(one.space)
            closed = row.apart.minus(apart)
            yield (
                f"{case}, {one.name}: {_number(one.plane)} mm/s in the plane, {_number(one.space)} in space, apart "
                f"by {_number(apart)}: {_number(closed)} mm/s of the difference go with it"
                f"{REASON_WORDS[closed.compare_with_range(MIN_REASON_SHARE * abs(row.apart.number), math.inf)]}"
            )


def _describe_packings(rows: Sequence[Row]) -> Iterator[str]:
    """Yield for each packing whether the crowd of cards has the speed, the orders and the g of space."""
    own = [row for row in rows if row.check == "collective" and row.space.key.startswith((*COMPARED_KEYS, "g_"))]
    for case in dict.fromkeys(row.case for row in own):
        named = {_quantity_name(row): row for row in own if row.case == case}
        shares = [
            f"{name} {_number(ratio(row.plane, row.space))}"
            for name, row in named.items()
            if row.space.key.startswith(RATIO_KEY_STARTS)
        ]
        off = [name for name, row in named.items() if row.verdict == Verdict.DISAGREE]
        open_ = [name for name, row in named.items() if row.verdict == Verdict.UNDECIDED]
        words = [f"off in {', '.join(off)}"] if off else []
        words += [f"undecided in {', '.join(open_)}"] if open_ else []
        yield f"{case}: cards {'; '.join(words) or 'hold'}; plane over space: {', '.join(shares)}"


def _quantity_name(row: Row) -> str:
    unit = row.space.unit.replace("2", "²").replace("_s", "/s")
    return row.space.key.replace("_", " ") + (f" ({unit})" if unit else "")


def _number(number: Quantity) -> str:
    return words.format_with_error(number.value or 0.0, number.se or 0.0)


def _format_difference(row: Row) -> str:
    apart = row.apart
    return " to ".join(words.format_to_error(apart.se or 0.0, apart.interval() or ()))
