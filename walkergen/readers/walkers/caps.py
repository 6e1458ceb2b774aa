"""Caps: markers on top of walkers that show a camera above their place, heading and number.

A cap is a square tile with a marker of OpenCV's ArUco, glued flat onto the middle of the body's
upper side. The marker's upper edge points to the front. The tile has a notch on this side. The
tile is printed apart, face up: its black cells are pockets to be inked, or are raised to be printed
in a second colour; or it is paper. Frame of a tile: its middle at the origin, x to the front, y to
the left, z from 0 up. Source of the bits: OpenCV 5.0, DICT_4X4_100, whose first half is
DICT_4X4_50; Garrido-Jurado et al., Pattern Recognition 47 (2014) 2280.
"""

from functools import lru_cache

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array, Mask
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.shapes.modeller import Engraving, extrude
from walkergen.core.walker.fittings import MARKER_CELLS, TILE_CELLS, Cap

MARKER_CODES = (
    "b5320f9a332d9946549e79cd9e2ec4f2fedacf56f99111a70eb72a0f24b1263e466566006c5e76af868bb02bccd5"
    "dd82fe479471ace4a5542123346f441557b29ecff0cb08ae0929187504ff0df61c5a17182a28328c38b224e82eeb"
    "2d3f4b64502e5013519455685d415f9768016867612461e96b126fe567df7e1b80a083448ba2937a846c852a859c"
    "9c899fa1bb7cbc04b65bbfc8b7abca1fc962d958d3d5cc98c7a0c537e95df925fbbbee2af74d35758aad76170acf"
    "064b2dc149d843f44f364fd369e470c7"
)
"""White cells of each marker: four hexadecimal digits, a row each, its left cell highest."""

BORDER_CELLS = 1
"""Cells of the black frame around a marker's code."""
CODE_CELLS = MARKER_CELLS - 2 * BORDER_CELLS
"""Cells along the side of a marker's code."""
QUIET_CELLS = (TILE_CELLS - MARKER_CELLS) // 2
"""White cells around a marker, without which its edge cannot be found."""

OVERLAP_CELLS = 0.02
"""Overlap of black cells of the code with those that touch them at a corner only, as a part of a cell:
a solid has no edge that four faces share."""

NOTCH_CELLS = 0.5
"""Depth of the notch at the front, cells; its width is two depths."""

MIN_SUPPORTED_SHARE = 0.4
"""Least part of a tile that lies on the body."""


def white_cells(number: int) -> Mask:
    """Return True for each white cell of a whole marker, rows from its upper edge down, shape (6, 6)."""
    bits = np.array([bit == "1" for bit in f"{int(MARKER_CODES[4 * number : 4 * number + 4], 16):016b}"])
    return np.pad(bits.reshape(CODE_CELLS, CODE_CELLS), BORDER_CELLS)


def symmetric_numbers() -> set[int]:
    """Return the numbers of markers that are rotations of their own mirror images."""
    return {
        number
        for number in range(len(MARKER_CODES) // 4)
        if any((np.rot90(white_cells(number)[:, ::-1], turn) == white_cells(number)).all() for turn in range(4))
    }


def black_rectangles(cap: Cap, overlap: float = 0.0) -> list[Array]:
    """Return the rectangles whose union is the black of a cap: corners counter-clockwise, shape (4, 2) each, mm.

    Cells of the code are larger on all sides by `overlap`, a share of a cell.
    """
    half, inner = 0.5 * MARKER_CELLS, 0.5 * CODE_CELLS
    boxes = [  # least x, least y, greatest x, greatest y, in cells: the black frame first
        (-half, inner, half, half),
        (-half, -half, half, -inner),
        (-half, -half, -inner, half),
        (inner, -half, half, half),
    ]
    for row, column in np.argwhere(~white_cells(cap.number)[BORDER_CELLS:-BORDER_CELLS, BORDER_CELLS:-BORDER_CELLS]):
        x, y = inner - row, inner - column  # the upper left corner of a cell seen from above
        boxes.append((x - 1.0 - overlap, y - 1.0 - overlap, x + overlap, y + overlap))
    return [
        cap.cell * np.array([(low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)])
        for low_x, low_y, high_x, high_y in boxes
    ]


def tile_outline(cap: Cap) -> Array:
    """Return the outline of a tile with its notch in the middle of the front, counter-clockwise, mm."""
    half, notch = 0.5 * cap.side, NOTCH_CELLS * cap.cell
    return np.array(
        [(-half, -half), (half, -half), (half, -notch), (half - notch, 0.0), (half, notch), (half, half), (-half, half)]
    )


@lru_cache(maxsize=256)
def build_tile(cap: Cap) -> Mesh:
    """Build the closed mesh of a tile as it prints, face up. Raises SolidError."""
    cells = Engraving(black_rectangles(cap, OVERLAP_CELLS), cap.relief_mm)
    if cap.kind == "engraved":
        return extrude([tile_outline(cap)], cap.thickness, windows=0, engraving=cells)
    tile = extrude([tile_outline(cap)], cap.thickness, windows=0)
    if cap.kind == "paper":
        return tile
    raised = extrude(cells.profiles, cap.thickness + cap.relief_mm, pieces=True)
    return modeller.to_mesh(modeller.check_solid(modeller.to_solid(tile) + modeller.to_solid(raised)))


def place_on_body(cap: Cap, body: Mesh, depth: float) -> Mesh:
    """Return the mesh of a cap on the upper side of a body, in the body's frame. `depth`: the body's along z, mm.

    Raises GeometryError for a body whose upper side is too small for the cap.
    """
    top = float(body.vertices[:, 1].max())
    if (supported := _supported_share(cap, body, top, depth)) < MIN_SUPPORTED_SHARE:
        raise GeometryError(
            f"cap.marker_mm = {cap.marker_mm:g}: {100 * supported:.0f} % of the cap's {cap.side:.4g} mm "
            f"square lie on the middle of the body's upper side, at least {100 * MIN_SUPPORTED_SHARE:g} % hold "
            "it: make it smaller, or the body wider or flat on top",
            "cap.marker_mm",
        )
    x, y, z = build_tile(cap).vertices.T  # to the front, to the left, up
    placed = np.column_stack([x, z + top, 0.5 * depth - y])
    return build_tile(cap)._replace(vertices=placed)


def _supported_share(cap: Cap, body: Mesh, top: float, depth: float) -> float:
    """Return the share of a tile that lies on the flat top of a body, at height `top` and `depth` across, mm."""
    import shapely

    corners = body.vertices[body.triangles]
    flat = corners[(corners[:, :, 1] > top - 1e-6 * max(1.0, abs(top))).all(axis=1)]
    faces = shapely.union_all([shapely.Polygon(face) for face in flat[:, :, [0, 2]]])
    half = 0.5 * cap.side
    tile = shapely.box(-half, 0.5 * depth - half, half, 0.5 * depth + half)
    return float(faces.intersection(tile).area / tile.area)
