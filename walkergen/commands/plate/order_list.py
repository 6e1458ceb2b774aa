"""Order list: a CSV file with walkers of several designs to print together, and the number of copies of each."""

from collections.abc import Mapping
from pathlib import Path

from walkergen.core.errors import InputError
from walkergen.core.files import columns, config, file_reading, formatting
from walkergen.core.printing import packing
from walkergen.core.walker import names
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import KINDS, Kind
from walkergen.files import templates

REQUIRED_COLUMNS, OPTIONAL_COLUMNS = ("design", "tilt_deg", "copies"), ("legs",)
MAX_BYTES = 1_000_000


def read_orders(path: Path) -> tuple[list[Design], list[int]]:
    """Return the walkers of an order list, in its order, and the number of copies of each.

    A row has the columns design (a template, or the path of a TOML file relative to the list), tilt_deg and legs (those
    of the design if blank), and copies (1 to packing.MAX_PARTS). Copies in rows of the same walker are added. Raises
    InputError with a line for each mistake, and PlateError for more parts than can be arranged together.
    """
    table = columns.parse_records(file_reading.read_lines(path, columns.FORMAT_NAME, MAX_BYTES), str(path))
    expected = (
        f" and, optionally, {', '.join(OPTIONAL_COLUMNS)}, separated by commas; seen: {', '.join(table.names)[:80]!r}"
    )
    columns.check_names(table.names, path, REQUIRED_COLUMNS, OPTIONAL_COLUMNS, expected)
    if not table.rows:
        raise InputError(f"{path}: no rows after the header. Add a row for each walker to print.")
    if len(table.rows) > packing.MAX_PARTS:
        raise InputError(f"{path}: {len(table.rows)} rows, at most {packing.MAX_PARTS} are possible. Split the list.")
    designs = _DesignCache(path.parent)
    members: dict[str, Design] = {}
    copies: dict[str, int] = {}
    problems: list[str] = []
    for line, row in table.rows:
        try:
            count, member = _parse_copies(row["copies"]), designs.member(row, line)
        except InputError as error:
            problems += [f"{path}:{line}: {text}" for text in error.text.splitlines()]
            continue
        name = names.part_name(member, member.name)
        members.setdefault(name, member)
        copies[name] = copies.get(name, 0) + count
    if problems:
        raise config.mistakes_error(problems, path)
    packing.check_part_count(sum(copies.values()))
    return list(members.values()), list(copies.values())


class _DesignCache:
    """Designs of a list, each read once. Two designs with the same name must be equal."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.read: dict[str, Design] = {}
        """Designs by their entries in the rows."""
        self.first: dict[str, tuple[int, Design]] = {}
        """First design of each name, in lower case for case-insensitive file systems, and its line."""

    def member(self, row: Mapping[str, str], line: int) -> Design:
        """Return the walker of the row at this line of the list. Raises InputError."""
        design = self._load_design(row["design"].strip(), line)
        tilt, kind = _parse_tilt(row["tilt_deg"]), _parse_kind(row.get("legs", ""))
        tilt = design.tilt_deg if tilt is None else tilt
        (member,) = design.members([tilt], [kind or design.kind])
        return member

    def _load_design(self, entry: str, line: int) -> Design:
        """Return the design of an entry (template or path) on a line of the list. Raises InputError."""
        if not entry:
            raise InputError(
                "design is blank. Enter the name of a template or the path of a TOML file, or remove the row."
            )
        if entry not in self.read:
            self.read[entry] = templates.load(entry, "walkers", Design, self.folder)
        design = self.read[entry]
        first_line, first = self.first.setdefault(design.name.casefold(), (line, design))
        if first != design:
            raise InputError(
                f"design {entry[:80]!r} is called {design.name}, and line {first_line} has another design "
                f"called {first.name}. Change the key `name` of one of them."
            )
        return design


def _parse_copies(cell: str) -> int:
    count = columns.parse_count(cell, packing.MAX_PARTS)
    if count is None:
        raise InputError(f"copies = {cell.strip()[:30]!r}: must be a whole number in 1..{packing.MAX_PARTS}")
    return count


def _parse_tilt(cell: str) -> float | None:
    """Parse the tilt in a cell, deg; None if it is blank. The design checks its range."""
    if not cell.strip():
        return None
    value = formatting.parse_number(cell)
    if value is None:
        raise InputError(
            f"tilt_deg = {cell.strip()[:30]!r}: must be a number in -85..85, or blank for the design's own"
        )
    return value + 0.0  # without the sign of a zero, which would make a second walker


def _parse_kind(cell: str) -> Kind | None:
    """Parse the kind of legs in a cell; None if it is blank."""
    word = cell.strip()
    kind = next((kind for kind in KINDS if kind == word), None)
    if word and kind is None:
        raise InputError(f"legs = {word[:30]!r}: must be {' or '.join(KINDS)}, or blank for the design's own")
    return kind
