"""Parts and plates without predictions: single files for export, copies arranged for printing."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from walkergen import names, output, plates, solids, weights
from walkergen.design import Design
from walkergen.mass import Mesh
from walkergen.printing import export, plate
from walkergen.printing.printers import Printer

FORMATS: dict[str, Callable[[Mesh, str], bytes]] = {
    "stl": export.stl_bytes,
    "3mf": export.part_3mf,
}


class Order(NamedTuple):
    """What to print, on which printers."""

    members: Sequence[Design]
    copies: Sequence[int]
    """Of each member."""
    printers: Sequence[Printer]
    """All copies are arranged for each of them."""
    max_plates: int | None = None
    """More plates are refused."""
    max_parts: int = plate.MOST_PARTS
    """On a plate."""
    pictures: bool = True
    prusaslicer: bool = False
    """Declare the 3MF files PrusaSlicer's own."""


class Room(NamedTuple):
    """How many copies of a walker alone fit on one plate."""

    printer: str
    name: str
    fit: int


def export_parts(
    members: Sequence[Design],
    formats: Sequence[str],
    folder: Path,
    progress: Callable[[str, int, int], None],
) -> list[Path]:
    """Write every member in every format (keys of FORMATS) as folder/FORMAT/NAME.FORMAT."""
    written = []
    for number, design in enumerate(members, start=1):
        name, mesh = names.part(design), solids.build(design).walker
        for form in formats:
            path = folder / form / f"{name}.{form}"
            output.write(path, FORMATS[form](mesh, name))
            written.append(path)
        progress(name, number, len(members))
    return written


def how_many(members: Sequence[Design], printers: Sequence[Printer], max_parts: int) -> list[Room]:
    """How many copies of each member fit on one plate of each printer, if it held no others."""
    parts = [plate.Part.of(names.part(one), solids.build(one).walker) for one in members]
    return [
        Room(printer.name, part.name, min(plate.capacity(part, printer), max_parts))
        for printer in printers
        for part in parts
    ]


def make_plates(
    order: Order, folder: Path, progress: Callable[[str, int, int], None]
) -> tuple[list[plates.Place], list[Path]]:
    """Arrange copies for every printer; write 3MF files, maps and weights.csv.

    Raises PlateError, before anything is written, when a part is too large for a printer or more
    plates are needed than allowed.
    """
    meshes = [solids.build(design).walker for design in order.members]
    layouts = [
        plates.arrange(
            order.members, meshes, order.copies, printer, order.max_plates, order.max_parts
        )
        for printer in order.printers
    ]
    steps = sum(1 + len(layout.plates) * (1 + order.pictures) for layout in layouts)
    paths: list[Path] = []
    for layout in layouts:
        for name, data in plates.files(layout, "plate", order.pictures, order.prusaslicer):
            paths.append(folder / "plates" / name)
            output.write(paths[-1], data)
            progress(name, len(paths), steps)
    rows = [row for layout in layouts for row in plates.places(layout)]
    weights.write_template(folder, dict.fromkeys(row.item for row in rows))
    return rows, paths
