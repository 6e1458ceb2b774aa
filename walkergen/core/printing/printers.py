"""Printers, their beds and processes, as templates/printers/*.toml describe them."""

from collections.abc import Mapping
from functools import partial
from operator import eq
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from walkergen.core.errors import InputError
from walkergen.core.files.config import Name, Section
from walkergen.core.printing import slicer_profile

DEFAULT_CLEARANCE_MM = 0.2
"""Gap on every side between a printed wall and a part that goes in by hand. Assumed, as usual."""

MIN_LINE_RATIO, MAX_LINE_RATIO = 0.6, 2.5
"""Widths of a line over that of the nozzle, between which a nozzle lays it down."""


class Printer(Section):
    """Filament printer. The ranges of its keys leave a usable bed whatever margin is chosen."""

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
        """Read the printer of a slicer's profile; None for a TOML file."""
        return slicer_profile.read_printer(path) if path.suffix.lower() in slicer_profile.SUFFIXES else None

    @model_validator(mode="before")
    @classmethod
    def _default_line_width(cls, data: Any) -> Any:
        if isinstance(data, dict) and "line_width_mm" not in data and isinstance(data.get("nozzle_mm"), (int, float)):
            return {**data, "line_width_mm": float(data["nozzle_mm"])}
        return data

    @model_validator(mode="after")
    def _check_line_width(self) -> Self:
        """Raise InputError for lines that the nozzle does not lay down."""
        if not MIN_LINE_RATIO <= self.line_width_mm / self.nozzle_mm <= MAX_LINE_RATIO:
            low, high = MIN_LINE_RATIO * self.nozzle_mm, MAX_LINE_RATIO * self.nozzle_mm
            raise InputError(
                f"line_width_mm = {self.line_width_mm:g}: nozzle_mm = {self.nozzle_mm:g} lays down lines of "
                f"{low:.3g} to {high:.3g}; change one of them",
                "line_width_mm",
            )
        return self

    def without_stale_keys(self, data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """Return data with the lines' width scaled to a new nozzle, if only the nozzle was set."""
        nozzle = data.get("nozzle_mm")
        if "nozzle_mm" in values and "line_width_mm" not in values and isinstance(nozzle, (int, float)):
            return {**data, "line_width_mm": round(self.line_width_mm / self.nozzle_mm * nozzle, 3)}
        return data
