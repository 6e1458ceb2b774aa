"""The members of a family read back from its files: a row of family.csv and a mesh from stl/."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.jobs.page.contents import Contents

TABLE = "family.csv"
STL_HEADER_BYTES, STL_RECORD_BYTES = 84, 50
NUMBERS = ("tilt_deg", "speed_mm_s", "speed_sd_mm_s")
TEXTS = ("legs", "law")
MOST_ROWS = 2000

Corners = npt.NDArray[np.float32]


class Member(NamedTuple):
    """One walker as its files tell."""

    name: str
    row: dict[str, str]
    """Its line of family.csv, as text."""
    corners: Corners | None
    """(triangles, 3, 3) in mm, exactly as in the STL file; None when that is missing."""

    @property
    def legs(self) -> str:
        """Kind of the legs."""
        return self.row["legs"]

    @property
    def tilt_deg(self) -> float:
        """Tilt of the legs, deg."""
        return float(self.row["tilt_deg"])

    def number(self, column: str) -> float | None:
        """A number of its row; None where the table has no such column or leaves it empty."""
        text = self.row.get(column, "")
        return number(text) if text else None


def number(text: str) -> float | None:
    """The finite number that a text is, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def of(contents: Contents) -> list[Member]:
    """The members in the manifest's order, which is also that of the rows of family.csv.

    Raises InputError when the table is missing, is not one of ours or has another length, and when
    an STL file cannot be read.
    """
    names = contents.manifest.members
    rows = _rows(contents, len(names))
    members = []
    for name, row in zip(names, rows, strict=True):
        file = f"stl/{name}.stl"
        data = contents.files.get(file)
        members.append(Member(name, row, None if data is None else corners(data, file)))
    return members


def corners(data: bytes, file: str) -> Corners:
    """Corners (triangles, 3, 3) of a binary STL file. Raises InputError, naming the file."""
    count = int.from_bytes(data[80:84], "little")
    size = STL_HEADER_BYTES + STL_RECORD_BYTES * count
    if len(data) != size or count == 0:
        raise InputError(
            f"{file}: {len(data)} bytes is no binary STL file of {count} triangles; "
            "write the folder again with `walkergen family`"
        )
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    found: Corners = np.frombuffer(data, record, offset=STL_HEADER_BYTES)["corners"]
    if not np.isfinite(found).all():
        raise InputError(f"{file}: a corner is not finite; write the folder again")
    return found


def _rows(contents: Contents, expected: int) -> list[dict[str, str]]:
    """Rows of the table, with all that the page cannot do without; raises InputError."""
    if TABLE not in contents.files:
        raise InputError(
            f"{TABLE}: missing; the page is made from it: write the folder again with "
            "`walkergen family`"
        )
    rows = contents.records(TABLE).rows
    if len(rows) != expected or not 0 < expected <= MOST_ROWS:
        raise InputError(
            f"{TABLE}: {len(rows)} rows for {expected} members of the manifest; a page shows 1 to "
            f"{MOST_ROWS}, a row each"
        )
    for line, row in rows:
        for column in NUMBERS:
            if number(row.get(column, "")) is None:
                raise InputError(
                    f"{TABLE}:{line}: {column}: must be a number, not {row.get(column, '')!r}"
                )
        for column in TEXTS:
            if not row.get(column):
                raise InputError(f"{TABLE}:{line}: {column}: missing")
    return [row for _, row in rows]
