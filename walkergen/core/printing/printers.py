"""Printers, their beds and processes, as templates/printers/*.toml or PrusaSlicer's profiles describe them.

PrusaSlicer's `File > Export > Export Config` writes lines KEY = VALUE. Keys that a profile lacks keep their defaults.
"""

import re
from collections.abc import Mapping
from functools import partial
from operator import eq
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting, safe_text
from walkergen.core.files.config import Name, Section

DEFAULT_CLEARANCE_MM = 0.2
"""Gap on every side between a printed wall and a part that goes in by hand. Assumed, as usual."""

MIN_LINE_RATIO, MAX_LINE_RATIO = 0.6, 2.5
"""Widths of a line over that of the nozzle, between which a nozzle lays it down."""


PROFILE_SUFFIXES = (".ini", ".json")
"""Endings of slicers' profiles; of these only PrusaSlicer's .ini is read."""

MAX_PROFILE_BYTES = 10_000_000

NUMBER_KEYS = {
    "height_mm": "max_print_height",
    "nozzle_mm": "nozzle_diameter",
    "layer_height_mm": "layer_height",
    "brim_width_mm": "brim_width",
    "skirt_distance_mm": "skirt_distance",
}
"""Keys of a printer, and the names that PrusaSlicer has for them."""

WIDTH_KEYS = ("perimeter_extrusion_width", "extrusion_width")
"""PrusaSlicer's names of the width of a line: mm, a share of the layer's height or the nozzle, or 0 for automatic."""

DEFAULT_WIDTH_RATIO = 1.125
"""Width of a line over that of the nozzle if a profile states none: PrusaSlicer's, for perimeters."""


class Printer(Section):
    """Filament printer: its bed, its lines and the distances that it needs.

    Arguments are the keys of a printer's file. The size of the bed and the height are required.

    Raises
    ------
    pydantic.ValidationError
        If a key is missing, unknown or outside its range.
    InputError
        If the nozzle cannot extrude lines of this width.

    Examples
    --------
    >>> from walkergen.core import Printer
    >>> Printer(bed_width_mm=200.0, bed_depth_mm=200.0, height_mm=180.0, nozzle_mm=0.6).line_width_mm
    0.6
    """

    name: Name = "printer"
    description: Annotated[str, Field(max_length=2000)] = ""
    bed_width_mm: Annotated[float, Field(ge=50, le=5000)]
    """Width of the bed along x, as seen from the front."""
    bed_depth_mm: Annotated[float, Field(ge=50, le=5000)]
    """Depth of the bed along y, away from the front."""
    height_mm: Annotated[float, Field(ge=1, le=5000)]
    margin_mm: Annotated[float, Field(ge=0, le=20)] = 5.0
    """Distance that is kept free along every edge of the bed."""
    gap_mm: Annotated[float, Field(ge=0, le=50)] = 3.0
    """Distance that is kept free between the bounding boxes of two parts."""
    brim_width_mm: Annotated[float, Field(ge=0, le=50)] = 0.0
    """Width of the brim around every part on its first layer; it counts in margin and gap."""
    skirt_distance_mm: Annotated[float, Field(ge=0, le=50)] = 2.0
    """Distance from the outermost brims (or parts) to the skirt."""
    skirt_loops: Annotated[int, Field(ge=0, le=20)] = 0
    nozzle_mm: Annotated[float, Field(ge=0.05, le=3)] = 0.4
    line_width_mm: Annotated[float, Field(ge=0.05, le=5)] = 0.4
    layer_height_mm: Annotated[float, Field(ge=0.01, le=2)] = 0.2
    wall_generator: Literal["classic", "arachne"] = "classic"
    """Way the slicer draws walls: lines of equal width, or of a width that follows the wall."""
    thin_walls: bool = True
    """Printing of walls thinner than a line, which the classic generator else leaves out."""
    pocket_clearance_mm: Annotated[float, Field(ge=0, le=2)] = Field(
        default=DEFAULT_CLEARANCE_MM, exclude_if=partial(eq, DEFAULT_CLEARANCE_MM)
    )
    """Gap on every side that a part needs to go into its pocket, compared with a design's; left out
    of its data while it is the usual one."""
    origin: Literal["corner", "centre"] = "corner"
    """Place of a file's x = y = 0: the front left corner of the bed, or its middle."""

    @property
    def bed_corner(self) -> tuple[float, float]:
        """Coordinates in a file of the front left corner of the bed, mm."""
        if self.origin == "centre":
            return -0.5 * self.bed_width_mm, -0.5 * self.bed_depth_mm
        return 0.0, 0.0

    @classmethod
    def data_from_file(cls, path: Path) -> dict[str, Any] | None:
        """Return the keys of the printer that a slicer's profile describes.

        Parameters
        ----------
        path : Path
            File of a printer.

        Returns
        -------
        dict or None
            Keys of the printer, or None for a TOML file.
        """
        return read_profile(path) if path.suffix.lower() in PROFILE_SUFFIXES else None

    @model_validator(mode="before")
    @classmethod
    def _default_line_width(cls, data: Any) -> Any:
        """Return keys before validation, with lines as wide as the nozzle if only the nozzle is given."""
        if isinstance(data, dict) and "line_width_mm" not in data and isinstance(data.get("nozzle_mm"), (int, float)):
            return {**data, "line_width_mm": float(data["nozzle_mm"])}
        return data

    @model_validator(mode="after")
    def _check_line_width(self) -> Self:
        """Raise InputError for lines too narrow or too wide for the nozzle. Return the printer."""
        if not MIN_LINE_RATIO <= self.line_width_mm / self.nozzle_mm <= MAX_LINE_RATIO:
            low, high = MIN_LINE_RATIO * self.nozzle_mm, MAX_LINE_RATIO * self.nozzle_mm
            raise InputError(
                f"line_width_mm = {self.line_width_mm:g}: nozzle_mm = {self.nozzle_mm:g} lays down lines of "
                f"{low:.3g} to {high:.3g}; change one of them",
                "line_width_mm",
            )
        return self

    def adjust_other_keys(self, data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the keys of a printer after a user has set `values`, with the line width scaled to a new nozzle.

        The line width is not scaled if the user has set it too.

        Parameters
        ----------
        data : dict
            Keys of the printer, which contain the values already. They are not changed in place.
        values : mapping
            Values that the user has set, by keys.

        Returns
        -------
        dict
            Keys of the printer.
        """
        nozzle = data.get("nozzle_mm")
        if "nozzle_mm" in values and "line_width_mm" not in values and isinstance(nozzle, (int, float)):
            return {**data, "line_width_mm": round(self.line_width_mm / self.nozzle_mm * nozzle, 3)}
        return data


def read_profile(path: Path) -> dict[str, Any]:
    """Return the keys of a printer that PrusaSlicer's profile (.ini) states. Raises InputError for other profiles."""
    if path.suffix.lower() != ".ini":
        raise InputError(
            f"{path}: a slicer's profile? Give a TOML file (walkergen templates copy prusa-mk3s), or what PrusaSlicer "
            "exports as .ini: File > Export > Export Config",
            "printer",
        )
    lines = [line.partition("=") for line in file_reading.read_lines(path, "a slicer's profile", MAX_PROFILE_BYTES)]
    values = {key.strip(): value.strip() for key, mark, value in lines if mark and not key.startswith(("#", ";"))}
    is_bundle = any(key.startswith("[printer:") for key, _, _ in lines)
    if is_bundle or "bed_shape" not in values:
        problem = "a bundle of several sections" if is_bundle else "a slicer's file without bed_shape"
        raise InputError(
            f"{path}: {problem}. Choose one printer in PrusaSlicer and export it: File > Export > Export Config",
            "printer",
        )
    data: dict[str, Any] = {"description": f"as {safe_text.shorten_line(path.name)[:60]}, a slicer's profile, states"}
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
    """Return the keys for size and origin of a bed from its corners in mm, such as 0x0,250x0,250x210,0x210."""
    corners = [re.split("x", corner) for corner in shape.split(",")]
    numbers = [(_parse_number(corner[0]), _parse_number(corner[-1])) for corner in corners]
    points = [(x, y) for x, y in numbers if x is not None and y is not None]
    if len(points) < 3 or len(points) < len(numbers):
        raise InputError(
            f"{path}: bed_shape = {safe_text.shorten_line(shape)[:60]}: must be corners as 0x0,250x0,250x210,0x210",
            "printer",
        )
    (left, right), (front, back) = ((min(values), max(values)) for values in zip(*points, strict=True))
    origin = "centre" if left < 0 else "corner"
    return {"bed_width_mm": right - left, "bed_depth_mm": back - front, "origin": origin}


def _line_width(values: dict[str, str], nozzle: float) -> float:
    """Return the width of a line, mm, that a profile states, or DEFAULT_WIDTH_RATIO times `nozzle` (mm) without one."""
    for name in WIDTH_KEYS:
        text = values.get(name, "")
        number = _parse_number(text.removesuffix("%"))
        if number:
            return round(0.01 * number * nozzle, 3) if text.endswith("%") else number
    return round(DEFAULT_WIDTH_RATIO * nozzle, 3)


def _parse_number(text: str) -> float | None:
    """Parse a profile's value, or the first of its values for several extruders. Return None if it is no number."""
    return formatting.parse_number(text.split(",")[0])
