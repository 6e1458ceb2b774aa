"""Check of a body's size: if it is not that of a walker, other units of its file are suggested."""

from collections.abc import Iterator
from functools import partial

from walkergen.core.errors import InputError, Remedy

MIN_LENGTH_MM, MAX_LENGTH_MM = 1.0, 500.0
"""Least and greatest length of the longest side of a body, mm, that is accepted."""

MAX_INCH_SIZE_MM = 3.0
"""Length of the longest side of a mesh below which it may be in inches, mm."""

UNITS_MM = {"inches": 25.4, "metres": 1000.0, "centimetres": 10.0, "micrometres": 1e-3}
"""Millimetres of other units."""

DEFAULT_LENGTH_MM = 28.0
"""Length of a drawing that states none, mm: that of the paper's walker."""


def readings(size: float, scale_mm: float) -> Iterator[tuple[str, float, float]]:
    """Yield units in which a body would have a walker's size: name, resulting longest side, and length of the unit, mm.

    `size`, mm, is the longest side if the file's unit is `scale_mm` mm.
    """
    for name, unit in UNITS_MM.items():
        if MIN_LENGTH_MM <= size * unit <= MAX_LENGTH_MM:
            yield name, size * unit, scale_mm * unit


def check_size(size: float, source: str, scale_mm: float = 1.0) -> None:
    """Raise InputError, which begins with `source`, for a body that is too small or large, and suggest other units.

    `size`, mm, is the longest side if the file's unit is `scale_mm` mm.
    """
    if MIN_LENGTH_MM < size <= MAX_LENGTH_MM:
        return
    units = [
        Remedy(f"read it in {name}: {length:.4g} mm", {"body.scale_mm": unit})
        for name, length, unit in readings(size, scale_mm)
    ]
    larger = Remedy(
        f"make it {DEFAULT_LENGTH_MM:g} mm long", {"body.length_mm": DEFAULT_LENGTH_MM, "body.scale_mm": None}
    )
    raise InputError(
        f"{source}: the longest side is {size:.4g} mm at {scale_mm:g} mm for each unit of the file, must lie in "
        f"{MIN_LENGTH_MM:g}..{MAX_LENGTH_MM:g} mm",
        helps=partial(tuple, [*units, larger]),
    )
