"""Printer of a slicer's profile: bed, height, nozzle, lines and layers of a file that PrusaSlicer exports.

`File > Export > Export Config` writes lines KEY = VALUE. What a profile does not say stays as usual.
"""

import re
from pathlib import Path
from typing import Any

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting, safe_text

SUFFIXES = (".ini", ".json")
"""Endings of slicers' profiles; of these only PrusaSlicer's .ini is read."""

MAX_BYTES = 10_000_000

NUMBER_KEYS = {
    "height_mm": "max_print_height",
    "nozzle_mm": "nozzle_diameter",
    "layer_height_mm": "layer_height",
    "brim_width_mm": "brim_width",
    "skirt_distance_mm": "skirt_distance",
}
"""Keys of a printer, and the names that PrusaSlicer has for them."""

WIDTH_KEYS = ("perimeter_extrusion_width", "extrusion_width")
"""Its names of the width of a line: mm, a share of the layer's height or of the nozzle, or 0 for its own."""

DEFAULT_WIDTH_RATIO = 1.125
"""Width of a line over the nozzle's that it takes where none is given: that of its perimeters."""


def read_printer(path: Path) -> dict[str, Any]:
    """Return a printer's keys found in a profile. Raises InputError for a profile of another kind."""
    if path.suffix.lower() != ".ini":
        raise InputError(
            f"{path}: a slicer's profile? Give a TOML file (walkergen templates copy prusa-mk3s), or what PrusaSlicer "
            "exports as .ini: File > Export > Export Config",
            "printer",
        )
    lines = [line.partition("=") for line in file_reading.read_lines(path, "a slicer's profile", MAX_BYTES)]
    values = {key.strip(): value.strip() for key, mark, value in lines if mark and not key.startswith(("#", ";"))}
    if "bed_shape" not in values or any(key.startswith("[printer:") for key, _, _ in lines):
        raise InputError(
            f"{path}: a slicer's file, but not of one printer with its bed_shape: export it in PrusaSlicer by "
            "File > Export > Export Config",
            "printer",
        )
    data: dict[str, Any] = {"description": f"as {safe_text.shorten_line(path.name)[:60]}, a slicer's profile, says"}
    data |= _parse_bed(path, values["bed_shape"])
    data |= {
        key: number for key, name in NUMBER_KEYS.items() if (number := _parse_number(values.get(name, ""))) is not None
    }
    data.setdefault("height_mm", 200.0)
    data["line_width_mm"] = _line_width(values, data.get("nozzle_mm", 0.4))
    if (loops := _parse_number(values.get("skirts", ""))) is not None:
        data["skirt_loops"] = int(loops)
    if values.get("perimeter_generator") in ("classic", "arachne"):
        data["wall_generator"] = values["perimeter_generator"]
    if "thin_walls" in values:
        data["thin_walls"] = values["thin_walls"] == "1"
    return data


def _parse_bed(path: Path, shape: str) -> dict[str, Any]:
    """Return size and origin of a bed from its corners, as 0x0,250x0,250x210,0x210."""
    corners = [re.split("x", corner) for corner in shape.split(",")]
    numbers = [(_parse_number(corner[0]), _parse_number(corner[-1])) for corner in corners]
    places = [(x, y) for x, y in numbers if x is not None and y is not None]
    if len(places) < 3 or len(places) < len(numbers):
        raise InputError(
            f"{path}: bed_shape = {safe_text.shorten_line(shape)[:60]}: must be corners as 0x0,250x0,250x210,0x210",
            "printer",
        )
    (left, right), (front, back) = ((min(values), max(values)) for values in zip(*places, strict=True))
    origin = "centre" if left < 0 else "corner"
    return {"bed_width_mm": right - left, "bed_depth_mm": back - front, "origin": origin}


def _line_width(values: dict[str, str], nozzle: float) -> float:
    """Return the width of a line, mm."""
    for name in WIDTH_KEYS:
        text = values.get(name, "")
        number = _parse_number(text.removesuffix("%"))
        if number:
            return round(0.01 * number * nozzle, 3) if text.endswith("%") else number
    return round(DEFAULT_WIDTH_RATIO * nozzle, 3)


def _parse_number(text: str) -> float | None:
    """Return the first number of a value with one per extruder; None if it is not a number."""
    return formatting.parse_number(text.split(",")[0])
