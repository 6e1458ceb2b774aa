"""Fields of requests that print: copies, plates, printers."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from walkergen.core.files import columns
from walkergen.field_values import parse_tilt
from walkergen.request import Flag, file_flag

MAX_COPIES = 5000
"""Largest number of copies in a request."""


def _parse_copies(value: Any) -> int | dict[float, int]:
    """Return the number of copies of each walker (8), or numbers by tilt in deg ("10:20,15:40", {10: 20, 15: 40})."""
    if isinstance(value, Mapping):
        pairs = list(value.items())
    elif isinstance(value, str) and ":" in value:
        pairs = [(word, count) for word, _, count in (piece.partition(":") for piece in value.split(","))]
    else:
        return _parse_count(value)
    if not pairs:
        raise ValueError("no tilt. Write copies by tilt: {10: 20, 15: 40}")
    quotas: dict[float, int] = {}
    for word, count in pairs:
        tilt = parse_tilt(word)
        quotas[tilt] = quotas.get(tilt, 0) + _parse_count(count)
    return quotas


def _parse_count(value: Any) -> int:
    """Return a number of copies from text or a number. Raises ValueError unless it is whole, 1 to MAX_COPIES."""
    plain = value.item() if hasattr(value, "item") else value
    count = columns.parse_count(plain, MAX_COPIES) if isinstance(plain, str) else plain
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAX_COPIES:
        raise ValueError(
            f"{str(value)[:30]!r} must be a whole number in 1..{MAX_COPIES}. Write 8, or TILT:COPIES,TILT:COPIES."
        )
    return count


Machines = Annotated[Any, file_flag("printers", "Printers: templates or TOML files.")]
Copies = Annotated[
    Any,
    BeforeValidator(_parse_copies),
    Flag(
        "Copies of each walker, 1 by default: 8, or by tilt: 10:20,15:40.",
        "COPIES",
        takes="int | Mapping[float, int] | str",
    ),
]
Caps = Annotated[Literal["aruco"] | None, Flag("Markers of caps to glue on, for `track`: aruco.", "MARKERS")]
MaxParts = Annotated[int, Field(ge=1, le=5000), Flag("Largest number of parts on a plate.", "N")]
ForPrusaSlicer = Annotated[bool, Flag("Let PrusaSlicer list and slice all copies as one object.")]
Strict = Annotated[bool, Flag("Treat warnings as errors.")]
MaxPlates = Annotated[int | None, Field(ge=1, le=1000), Flag("Largest number of plates to use.", "N")]
