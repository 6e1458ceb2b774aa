"""Plates: copies of parts in rows on a printer's bed, on as many plates as they need.

Parts keep their orientation, z up, and are not turned: rows of a family stay in the order of its members. Lengths in
mm; the packing itself is in whole micrometres, so that no rounding brings two parts closer than the gap.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import PlateError
from walkergen.core.printing import export
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import threemf
from walkergen.core.shapes.mesh import Mesh

MAX_PARTS, MAX_ARRANGED_PARTS = 5000, 50_000
"""Most parts on a plate, which are also the most copies of a part; and on all plates of a batch."""

THREEMF_SUFFIX, STL_SUFFIX = ".3mf", ".stl"
"""Suffixes of plates' files."""


class Part(NamedTuple):
    """Bounding box of a shape, and the number of its copies."""

    name: str
    width: float
    """Size along x, mm."""
    depth: float
    """Size along y, mm."""
    height: float
    """Size along z, mm."""
    copies: int
    serial: int | None = None
    """Number of its only copy; None if copies are alike, and numbered from 1."""
    supports: bool = False
    """Whether it prints with supports from the bed."""
    run_direction: int | None = None
    """1 for a walker that runs to the right as it lies, -1 to the left, 0 for neither; None for a part without legs."""

    @classmethod
    def from_mesh(cls, name: str, mesh: Mesh, copies: int = 1, serial: int | None = None) -> "Part":
        """Return the bounding box of a mesh as a part."""
        width, depth, height = (mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).tolist()
        return cls(name, width, depth, height, copies, serial)

    @property
    def solid_name(self) -> str:
        """Name of the part's solid in a 3MF file, with its serial number if it has one."""
        return self.name if self.serial is None else f"{self.name}_no{self.serial}"


class Placement(NamedTuple):
    """Position of one copy: the lower left corner of its bounding box."""

    part: int
    """Index into the parts."""
    copy: int
    """Number of the copy: from 1, or its serial number."""
    x: float
    """Distance from the left edge of the bed, mm."""
    y: float
    """Distance from the front edge of the bed, mm."""


class Plate(NamedTuple):
    """Copies that are printed together, in the order of the parts."""

    placements: tuple[Placement, ...]


def border_width(printer: Printer) -> float:
    """Return the distance from the edge of the bed to the first part, mm: its margin, brim and skirt."""
    # Half a line more than the loops: PrusaSlicer's skirts lie that far out.
    skirt = printer.skirt_distance_mm + (printer.skirt_loops + 0.5) * printer.line_width_mm
    return printer.margin_mm + printer.brim_width_mm + (skirt if printer.skirt_loops else 0.0)


def spacing(printer: Printer) -> float:
    """Return the distance between the bounding boxes of two parts, mm: the gap and two brims."""
    return printer.gap_mm + 2.0 * printer.brim_width_mm


def capacity(part: Part, printer: Printer) -> int:
    """Return the number of copies of a part that fit on one plate in a grid; 0 for a part larger than the printer."""
    if _round_up_micrometres(part.height) > _round_up_micrometres(printer.height_mm):
        return 0
    (bed_width, bed_depth), (width, depth) = _bed_micrometres(printer), _cell_size(part, printer)
    return max(0, bed_width // width) * max(0, bed_depth // depth)


def pack(
    parts: Sequence[Part], printer: Printer, max_plates: int | None = None, max_parts: int = MAX_PARTS
) -> list[Plate]:
    """Return plates with all copies in rows, in the order of the parts, at most `max_parts` on a plate.

    The rows of a plate together lie in the middle of the bed. Raises PlateError when a part is larger than the usable
    bed or taller than the printer, when more than `max_plates` are needed, and for more than MAX_ARRANGED_PARTS copies.
    """
    total = sum(part.copies for part in parts)
    check_part_count(total)
    _check_sizes(parts, printer)
    plates = _pack_rows(parts, printer, max_parts)
    if max_plates is not None and len(plates) > max_plates:
        placed = sum(len(plate.placements) for plate in plates[:max_plates])
        raise PlateError(
            f"{total} parts need {len(plates)} beds of {printer.name}, but ‹max_plates=›{max_plates} holds {placed}. "
            "Allow more beds, or print fewer parts."
        )
    return plates


def check_part_count(total: int) -> None:
    """Raise PlateError for more parts than one call can arrange."""
    if total > MAX_ARRANGED_PARTS:
        raise PlateError(f"{total} parts: at most {MAX_ARRANGED_PARTS} can be arranged in one run. Print fewer copies.")


def plate_3mf(
    plate: Plate,
    parts: Sequence[Part],
    meshes: Sequence[Mesh],
    printer: Printer,
    title: str,
    thumbnail: bytes | None = None,
) -> bytes:
    """Return the bytes of a 3MF file of one plate in the printer's coordinates. `meshes` and `parts` match in order.

    `thumbnail` is a PNG that file managers show.
    """
    used = sorted({placement.part for placement in plate.placements})
    solid_of = {part: number for number, part in enumerate(used)}
    solids = [export.Solid(parts[part].solid_name, meshes[part], parts[part].supports) for part in used]
    left, front = printer.bed_corner
    items = [
        export.Item(solid_of[part], item_name(parts[part], copy), left + x, front + y)
        for part, copy, x, y in plate.placements
    ]
    return export.threemf_bytes(solids, items, title, thumbnail)


def plate_file(
    plate: Plate,
    parts: Sequence[Part],
    meshes: Sequence[Mesh],
    printer: Printer,
    title: str,
    thumbnail: bytes | None = None,
    prusaslicer: bool = False,
) -> tuple[str, bytes]:
    """Return the suffix and the bytes of one plate's file: 3MF, or STL if lib3mf is not installed.

    `prusaslicer` declares a 3MF file to be PrusaSlicer's own, and raises InputError without lib3mf.
    """
    if prusaslicer or threemf.is_available():
        data = plate_3mf(plate, parts, meshes, printer, title, thumbnail)
        return THREEMF_SUFFIX, export.declare_prusaslicer(data) if prusaslicer else data
    return STL_SUFFIX, export.stl_bytes(plate_mesh(plate, meshes, printer), title)


def plate_mesh(plate: Plate, meshes: Sequence[Mesh], printer: Printer) -> Mesh:
    """Return the mesh of all copies of a plate, in the printer's coordinates, standing on z = 0."""
    corner = np.array([*printer.bed_corner, 0.0])
    vertices, triangles, before = [], [], 0
    for part, _, x, y in plate.placements:
        mesh = meshes[part]
        moved = mesh.vertices - mesh.vertices.min(axis=0) + corner + (x, y, 0.0)
        vertices.append(moved)
        triangles.append(mesh.triangles + before)
        before += len(moved)
    return Mesh(np.concatenate(vertices), np.concatenate(triangles))


def plate_suffix() -> str:
    """Return the suffix of the files of plates on this machine."""
    return THREEMF_SUFFIX if threemf.is_available() else STL_SUFFIX


def item_name(part: Part, copy: int) -> str:
    """Return the name of one printed copy, such as walker_t10.0_flexible_s0.40-3."""
    return f"{part.name}-{copy}"


def _pack_rows(parts: Sequence[Part], printer: Printer, max_parts: int) -> list[Plate]:
    """Return plates of copies in rows, left to right and front to back, each row as deep as its deepest part."""
    bed_width, bed_depth = _bed_micrometres(printer)
    plates: list[Plate] = []
    placed: list[tuple[int, int, int, int]] = []  # copies on the current plate: part, copy, x, y; micrometres
    x = y = right = row_depth = 0
    for index, part in enumerate(parts):
        width, depth = _cell_size(part, printer)
        first = part.serial or 1
        for copy in range(first, first + part.copies):
            if x + width > bed_width:
                x, y, row_depth = 0, y + row_depth, 0
            if y + depth > bed_depth or len(placed) == max_parts:
                plates.append(_center_on_bed(placed, (right, y + row_depth), printer))
                placed, x, y, right, row_depth = [], 0, 0, 0, 0
            placed.append((index, copy, x, y))
            x, row_depth = x + width, max(row_depth, depth)
            right = max(right, x)
    return [*plates, _center_on_bed(placed, (right, y + row_depth), printer)] if placed else plates


def _center_on_bed(placed: Sequence[tuple[int, int, int, int]], used: tuple[int, int], printer: Printer) -> Plate:
    """Return a plate of copies, (part, copy, x, y) each, moved to the middle of the free bed.

    `x`, `y` and `used` are in whole micrometres. `used` is the width and depth that all copies take, with gaps.
    """
    edge, (bed_width, bed_depth) = border_width(printer), _bed_micrometres(printer)
    right, back = (bed_width - used[0]) // 2, (bed_depth - used[1]) // 2
    return Plate(
        tuple(Placement(part, copy, edge + 1e-3 * (x + right), edge + 1e-3 * (y + back)) for part, copy, x, y in placed)
    )


def _free_bed(printer: Printer) -> tuple[float, float]:
    """Return the width and depth of the bed inside its border, mm."""
    return (printer.bed_width_mm - 2.0 * border_width(printer), printer.bed_depth_mm - 2.0 * border_width(printer))


def _bed_micrometres(printer: Printer) -> tuple[int, int]:
    """Return width and depth of the free bed, um, larger by a gap, since each cell of `_cell_size` ends with one."""
    width, depth = (math.floor(round(1e3 * length, 6)) for length in _free_bed(printer))
    gap = _round_up_micrometres(spacing(printer))
    return width + gap, depth + gap


def _cell_size(part: Part, printer: Printer) -> tuple[int, int]:
    """Return the width and depth of a part with the gap to its neighbours, micrometres."""
    gap = _round_up_micrometres(spacing(printer))
    return _round_up_micrometres(part.width) + gap, _round_up_micrometres(part.depth) + gap


def _round_up_micrometres(length: float) -> int:
    """Convert mm to whole micrometres, rounded up. An excess below a picometre is rounding noise and ignored."""
    return math.ceil(round(1e3 * length, 6))


def _check_sizes(parts: Sequence[Part], printer: Printer) -> None:
    """Raise PlateError for parts that do not fit on an empty plate."""
    too_large = [part for part in parts if capacity(part, printer) == 0]
    if not too_large:
        return
    part, others = too_large[0], len(too_large) - 1
    width, depth = _free_bed(printer)
    raise PlateError(
        f"{part.name}: {part.width:.7g} x {part.depth:.7g} x {part.height:.7g} mm (width x depth x "
        f"height) does not fit {printer.name}. Its bed is {width:g} x {depth:g} mm inside margins of "
        f"{border_width(printer):g} mm, and it prints {printer.height_mm:g} mm high. "
        + (f"{others} more do not fit either. " if others else "")
        + "Choose a larger printer, or make the part smaller."
    )
