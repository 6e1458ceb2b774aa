"""Members of a family read back from its files: a row of family.csv and a mesh from stl/."""

import re
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files import words
from walkergen.jobs.page.report.chart_data import LARGEST
from walkergen.jobs.page.report.contents import Contents
from walkergen.shapes import stl
from walkergen.shapes.stl import Corners

TABLE = "family.csv"
NUMBERS = ("tilt_deg", "speed_mm_s")
TEXTS = ("legs", "law")
ERROR = re.compile(r"_(se|sd|error)(_|$)")
"""Names of columns that hold errors, which cannot be negative."""
MOST_ROWS = 2000


class Member(NamedTuple):
    """Walker of a family, as its files describe it."""

    name: str
    row: dict[str, str]
    """Row of family.csv, text by column."""
    corners: Corners | None
    """Corners (triangles, 3, 3) in mm, exactly as in the STL file; None without that file."""

    @property
    def legs(self) -> str:
        """Kind of the legs."""
        return self.row["legs"]

    @property
    def tilt_deg(self) -> float:
        """Tilt of the legs, deg."""
        return float(self.row["tilt_deg"])

    def number(self, column: str) -> float | None:
        """Number in a column of the row; None where there is no such column, or no number in it."""
        text = self.row.get(column, "")
        return words.value(text) if text else None


def of(contents: Contents) -> list[Member]:
    """Members in the manifest's order, which is also that of the rows of family.csv.

    Raises InputError when the table is missing, is not one of ours or has another length, and when
    an STL file is not sound.
    """
    names = contents.manifest.members
    rows = _rows(contents, len(names))
    members = []
    for name, row in zip(names, rows, strict=True):
        file = f"stl/{name}.stl"
        data = contents.files.get(file)
        members.append(Member(name, row, None if data is None else stl.unpack(data, file)[0]))
    return members


def _rows(contents: Contents, expected: int) -> list[dict[str, str]]:
    """Rows of the table, with all that the page cannot do without; raises InputError."""
    if TABLE not in contents.files:
        raise InputError(f"{TABLE}: missing; the page is made from it: write the folder again with `walkergen family`")
    rows = contents.records(TABLE).rows
    if len(rows) != expected or not 0 < expected <= MOST_ROWS:
        raise InputError(
            f"{TABLE}: {len(rows)} rows for {expected} members of the manifest; a page shows 1 to "
            f"{MOST_ROWS}, a row each"
        )
    for line, row in rows:
        for column, text in row.items():
            value = words.value(text)
            if (column in NUMBERS and value is None) or (value is not None and abs(value) > LARGEST):
                raise InputError(f"{TABLE}:{line}: {column}: must be a number within ±{LARGEST:g}, not {text[:40]!r}")
            if value is not None and value < 0.0 and ERROR.search(column):
                raise InputError(f"{TABLE}:{line}: {column}: must be >= 0, not {text[:40]!r}")
        for column in (*TEXTS, *NUMBERS):
            if not row.get(column):
                raise InputError(f"{TABLE}:{line}: {column}: missing")
    return [row for _, row in rows]
