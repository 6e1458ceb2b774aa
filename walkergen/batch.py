"""Parts and plates without predictions: single files for export, copies arranged for printing."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from walkergen import names, output, solids
from walkergen.design import Design
from walkergen.mass import Mesh
from walkergen.printing import export, plate
from walkergen.printing.printers import Printer

FORMATS: dict[str, Callable[[Mesh, str], bytes]] = {
    "stl": export.stl_bytes,
    "3mf": export.part_3mf,
}


class Row(NamedTuple):
    """Where one copy lies; x, y of its lower left corner on the bed."""

    plate: int
    part: str
    copy: int
    x_mm: float
    y_mm: float


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


def make_plates(
    members: Sequence[Design],
    printer: Printer,
    copies: int,
    max_plates: int | None,
    folder: Path,
) -> tuple[list[Row], list[Path]]:
    """Arrange copies of the members and write one 3MF a plate.

    Raises PlateError when a part is too large or more plates are needed than allowed.
    """
    meshes = [solids.build(design).walker for design in members]
    parts = [
        plate.Part.of(names.part(design), mesh, copies)
        for design, mesh in zip(members, meshes, strict=True)
    ]
    rows, paths = [], []
    for number, one in enumerate(plate.pack(parts, printer, max_plates), start=1):
        path = folder / "plates" / f"plate_{printer.name}_{number}.3mf"
        output.write(path, plate.plate_3mf(one, parts, meshes, printer, path.stem))
        paths.append(path)
        rows += [Row(number, parts[p.part].name, p.copy, p.x, p.y) for p in one.placements]
    return rows, paths
