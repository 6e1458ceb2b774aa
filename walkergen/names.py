"""Names of files and printed objects: they say what varies between the members of a family."""

import re
from pathlib import Path

import numpy as np

from walkergen.design import Design


def part(design: Design) -> str:
    """Name of one walker, such as walker_t10.0_flexible_s0.40; unique within a family."""
    tilt = _decimal(design.legs.tilt_deg, 1)
    return f"walker_t{tilt}_{design.legs.kind}_s{_decimal(design.leg_thickness, 2)}"


def results(path: Path, out: Path | None, what: str) -> Path:
    """Folder for what is made of a file: below `out`, or below out/ and the file's own name.

    A folder of its own within, so that what other commands wrote there stays.
    """
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", path.stem).strip("-")[:64] or "results"
    return (out or Path("out") / name) / what


def _decimal(value: float, digits: int) -> str:
    """All digits of a number, at least `digits` after the point, never an exponent."""
    return np.format_float_positional(value + 0.0, unique=True, min_digits=digits)
