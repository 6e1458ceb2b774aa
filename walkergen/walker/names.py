"""Names of parts and the legend of their marks: both say what varies within a family."""

from collections.abc import Sequence

import numpy as np

from walkergen.walker.design import Design
from walkergen.walker.marks import Marks


def part(design: Design) -> str:
    """Name of a walker, such as walker_t10.0_flexible_s0.40; unique within a family."""
    tilt = _decimal(design.tilt_deg, 1)
    return f"walker_t{tilt}_{design.kind}_s{_decimal(design.limbs[0].thickness, 2)}"


def legend(members: Sequence[Design]) -> str:
    """Markdown table of the mark for each tilt; "" without marks."""
    marks = {design.tilt_deg: design.mark for design in members if design.mark}
    if not marks:
        return ""
    lines = [f"| {tilt:g} | `{mark}` |" for tilt, mark in sorted(marks.items())]
    head = "| tilt (deg) | mark |\n|-----------:|:-----|"
    return f"{how_to_read(members[0].marks)}\n\n{head}\n" + "\n".join(lines) + "\n"


def how_to_read(marks: Marks) -> str:
    """Instructions for reading the marks of a printed part; "" without marks."""
    if marks.kind == "none":
        return ""
    if marks.kind == "digits":
        return "Digits on the side that printed last: the tilt in degrees. Hold the legs down."
    unit = 2.0 * marks.line_mm
    return (
        f"Notches in the edge opposite the legs: read from the start, ### ({3 * unit:g} mm wide, "
        f"at one end of the body); # is narrow ({unit:g} mm), ## wide ({2 * unit:g} mm)."
    )


def _decimal(value: float, digits: int) -> str:
    """Format a number with all its digits, at least `digits` after the point, never an exponent."""
    return np.format_float_positional(value + 0.0, unique=True, min_digits=digits)
