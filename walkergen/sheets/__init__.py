"""Pictures of plates, and sheets of caps."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from walkergen.core.printing.plates import DrawPlate


def plate_drawing() -> "DrawPlate":
    """Return the function that draws a plate; it loads matplotlib."""
    from walkergen.sheets import plate_map

    return plate_map.draw_pictures
