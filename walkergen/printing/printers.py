"""Printer: the bed and the process; read from templates/printers/*.toml."""

from typing import Annotated, Literal

from pydantic import Field

from walkergen.files.config import Name, Section


class Printer(Section):
    """A filament printer. The ranges leave a usable bed whatever margin is chosen."""

    name: Name = "printer"
    description: Annotated[str, Field(max_length=2000)] = ""
    bed_width_mm: Annotated[float, Field(ge=50, le=5000)]
    """Along x, seen from the front."""
    bed_depth_mm: Annotated[float, Field(ge=50, le=5000)]
    """Along y, away from the front."""
    height_mm: Annotated[float, Field(gt=0, le=5000)]
    margin_mm: Annotated[float, Field(ge=0, le=20)] = 5.0
    """Kept free along every edge of the bed."""
    gap_mm: Annotated[float, Field(ge=0, le=50)] = 3.0
    """Kept free between the bounding boxes of two parts."""
    brim_width_mm: Annotated[float, Field(ge=0, le=50)] = 0.0
    """Printed around every part on its first layer; counts in margin and gap."""
    skirt_distance_mm: Annotated[float, Field(ge=0, le=50)] = 2.0
    """From the outermost brims (or parts) to the skirt."""
    skirt_loops: Annotated[int, Field(ge=0, le=20)] = 0
    nozzle_mm: Annotated[float, Field(ge=0.05, le=3)] = 0.4
    line_width_mm: Annotated[float, Field(ge=0.05, le=5)] = 0.4
    layer_height_mm: Annotated[float, Field(ge=0.01, le=2)] = 0.2
    wall_generator: Literal["classic", "arachne"] = "classic"
    """How the slicer draws walls: lines of one width, or of a width that follows the wall."""
    thin_walls: bool = True
    """Classic only: print walls thinner than a line, which get no plastic otherwise."""
    origin: Literal["corner", "centre"] = "corner"
    """Where a file's x = y = 0 lies: the front left corner of the bed, or its middle."""

    @property
    def usable_bed(self) -> tuple[float, float]:
        """Width and depth of the bed inside its margins, mm."""
        return self.bed_width_mm - 2.0 * self.margin_mm, self.bed_depth_mm - 2.0 * self.margin_mm

    @property
    def bed_corner(self) -> tuple[float, float]:
        """Where the front left corner of the bed lies in a file's coordinates, mm."""
        if self.origin == "centre":
            return -0.5 * self.bed_width_mm, -0.5 * self.bed_depth_mm
        return 0.0, 0.0
