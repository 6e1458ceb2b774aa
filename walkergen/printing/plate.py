"""Plates: copies of parts in rows on a printer's bed, on as many plates as they need.

Parts lie as they are given, profile on the bed, and are not turned: rows of a family stay in the
order of its members. Lengths in mm; the packing itself is in whole micrometres, so that no
rounding brings two parts closer than the gap.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import rectpack

from walkergen.errors import PlateError
from walkergen.mass import Mesh
from walkergen.printing import export
from walkergen.printing.printers import Printer

MOST_PARTS = 5000


class Part(NamedTuple):
    """The bounding box of a shape, and how many to print."""

    name: str
    width: float
    """Along x, mm."""
    depth: float
    """Along y, mm."""
    height: float
    """Along z, mm."""
    copies: int

    @classmethod
    def of(cls, name: str, mesh: Mesh, copies: int = 1) -> "Part":
        """The part that a mesh makes."""
        width, depth, height = (mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).tolist()
        return cls(name, width, depth, height, copies)


class Placement(NamedTuple):
    """Where one copy lies: the lower left corner of its bounding box."""

    part: int
    """Index into the parts."""
    copy: int
    """From 1."""
    x: float
    """From the left edge of the bed, mm."""
    y: float
    """From the front edge of the bed, mm."""


class Plate(NamedTuple):
    """What is printed at once, in the order of the parts."""

    placements: tuple[Placement, ...]


def capacity(part: Part, printer: Printer) -> int:
    """How many copies of one part fit on one plate: a plain grid; 0 when it is too large."""
    if _micrometres(part.height) > _micrometres(printer.height_mm):
        return 0
    (bed_width, bed_depth), (width, depth) = _bed(printer), _cell(part, printer)
    return (bed_width // width) * (bed_depth // depth)


def pack(parts: Sequence[Part], printer: Printer, max_plates: int | None = None) -> list[Plate]:
    """Place all copies, each on the first plate with room, as far to the front as it goes.

    Raises PlateError when a part is larger than the usable bed or taller than the printer, when
    more than `max_plates` are needed, and for more than MOST_PARTS copies.
    """
    total = sum(part.copies for part in parts)
    if total > MOST_PARTS:
        raise PlateError(f"{total} parts: at most {MOST_PARTS} are arranged at once; make fewer")
    _check_sizes(parts, printer)
    plates = _packed(parts, printer)
    if max_plates is not None and len(plates) > max_plates:
        placed = sum(len(plate.placements) for plate in plates[:max_plates])
        raise PlateError(
            f"{total} parts need {len(plates)} plates of {printer.name}, {max_plates} allowed "
            f"(room for {placed} parts): allow more plates or print fewer parts"
        )
    return plates


def plate_3mf(
    plate: Plate, parts: Sequence[Part], meshes: Sequence[Mesh], printer: Printer, title: str
) -> bytes:
    """3MF file of one plate in the printer's coordinates; `meshes` in the order of the parts."""
    used = sorted({placement.part for placement in plate.placements})
    solid_of = {part: number for number, part in enumerate(used)}
    solids = [export.Solid(parts[part].name, meshes[part]) for part in used]
    centred = printer.origin == "centre"
    left = -0.5 * printer.bed_width_mm if centred else 0.0
    front = -0.5 * printer.bed_depth_mm if centred else 0.0
    items = [
        export.Item(solid_of[part], f"{parts[part].name}-{copy}", left + x, front + y)
        for part, copy, x, y in plate.placements
    ]
    return export.threemf_bytes(solids, items, title)


def _packed(parts: Sequence[Part], printer: Printer) -> list[Plate]:
    """Skyline packing, bottom left first (rectpack); every cell is a part and the gap behind it."""
    packer = rectpack.newPacker(
        bin_algo=rectpack.PackingBin.BFF,
        pack_algo=rectpack.SkylineBl,
        sort_algo=rectpack.SORT_NONE,
        rotation=False,
    )
    for index, part in enumerate(parts):
        for copy in range(1, part.copies + 1):
            packer.add_rect(*_cell(part, printer), rid=(index, copy))
    packer.add_bin(*_bed(printer), count=MOST_PARTS)
    packer.pack()
    return [Plate(tuple(_placement(cell, printer.margin_mm) for cell in sheet)) for sheet in packer]


def _placement(cell: rectpack.geometry.Rectangle, margin: float) -> Placement:
    part, copy = cell.rid
    return Placement(part, copy, margin + 1e-3 * cell.x, margin + 1e-3 * cell.y)


def _bed(printer: Printer) -> tuple[int, int]:
    """The usable bed in micrometres, larger by the gap that the last cell of a row carries."""
    width, depth = (math.floor(round(1e3 * length, 6)) for length in printer.usable_bed)
    gap = _micrometres(printer.gap_mm)
    return width + gap, depth + gap


def _cell(part: Part, printer: Printer) -> tuple[int, int]:
    gap = _micrometres(printer.gap_mm)
    return _micrometres(part.width) + gap, _micrometres(part.depth) + gap


def _micrometres(length: float) -> int:
    """Rounded up, unless it is the noise of a sum: less than a picometre above the micrometre."""
    return math.ceil(round(1e3 * length, 6))


def _check_sizes(parts: Sequence[Part], printer: Printer) -> None:
    too_large = [part for part in parts if capacity(part, printer) == 0]
    if not too_large:
        return
    part, others = too_large[0], len(too_large) - 1
    width, depth = printer.usable_bed
    raise PlateError(
        f"{part.name}: {part.width:.7g} x {part.depth:.7g} x {part.height:.7g} mm (width x depth x "
        f"height) does not fit {printer.name}: {width:g} x {depth:g} mm inside margins of "
        f"{printer.margin_mm:g} mm, {printer.height_mm:g} mm high"
        + (f"; neither do {others} more" if others else "")
    )
