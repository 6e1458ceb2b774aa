"""Pictures of plates, and sheets of caps."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from walkergen.core.printing.plates import DrawPlate


def plate_drawing() -> "DrawPlate":
    """Import matplotlib, and return the function that draws the pictures of a plate."""
    from walkergen.sheets import plate_map

    return plate_map.draw_pictures
