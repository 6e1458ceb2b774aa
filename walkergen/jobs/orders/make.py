"""Parts and plates without predictions: single files for export, copies arranged for printing."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from walkergen.files import output
from walkergen.files.progress import Progress
from walkergen.printing import checks, export, walls
from walkergen.printing import layout as plates
from walkergen.printing import packing as plate
from walkergen.printing.checks import Finding
from walkergen.printing.printers import Printer
from walkergen.walker import names, solids, weights
from walkergen.walker.design import Design
from walkergen.walker.mass import Mesh

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
    strict: bool = False
    """Refuse what prints otherwise than predicted, not only what fails."""


class Wall(NamedTuple):
    """A thickness among the members' walls, and what the printer makes of it."""

    wall: str
    thickness_mm: float
    lines: float
    """Thickness in printed lines."""
    plastic_percent: float
    """Expected deviation of its plastic from the mesh."""


class Checked(NamedTuple):
    """What `check` found."""

    walls: list[Wall]
    findings: list[Finding]
    parts: int
    plates: int
    """0 when a part fits no plate."""


class Room(NamedTuple):
    """How many copies of a walker alone fit on one plate."""

    printer: str
    name: str
    fit: int


def export_parts(
    members: Sequence[Design],
    formats: Sequence[str],
    folder: Path,
    progress: Progress,
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


def check(members: Sequence[Design], copies: Sequence[int], printer: Printer) -> Checked:
    """Run the printability checks on copies of the members, arranged; writes nothing."""
    built = [solids.build(design) for design in members]
    parts = [
        plate.Part.of(names.part(one), own.walker) for one, own in zip(members, built, strict=True)
    ]
    if all(plate.capacity(part, printer) for part in parts):
        layout = plates.arrange(members, built, copies, printer)
    else:  # which the findings tell, part by part
        layout = plates.checked(printer, members, built, parts, [])
    walls_seen = {
        (name, thickness): Wall(
            name,
            thickness,
            thickness / printer.line_width_mm,
            100.0 * walls.deviation(thickness, printer),
        )
        for design in members
        for name, thickness in checks.walls_of(design).items()
    }
    return Checked(
        list(walls_seen.values()), list(layout.findings), sum(copies), len(layout.plates)
    )


def make_plates(
    order: Order,
    folder: Path,
    progress: Progress,
    tell: Callable[[Sequence[Finding]], None],
) -> tuple[list[plates.Place], list[Path]]:
    """Arrange copies for every printer; write 3MF files, maps, print sheets and weights.csv.

    `tell` is called with the printability checks' findings. Raises, before anything is written,
    PlateError when a part is too large for a printer or more plates are needed than allowed, and
    PrintabilityError when a part would not print (strict: would print otherwise than predicted).
    """
    built = [solids.build(design) for design in order.members]
    layouts = [
        plates.arrange(
            order.members, built, order.copies, printer, order.max_plates, order.max_parts
        )
        for printer in order.printers
    ]
    findings = [
        # With several printers it matters which.
        one._replace(where=f"{layout.printer.name}: {one.where}") if len(layouts) > 1 else one
        for layout in layouts
        for one in layout.findings
    ]
    tell(findings)
    checks.refuse(findings, order.strict)
    steps = sum(
        plates.COMMON_FILES + len(layout.plates) * (1 + order.pictures) for layout in layouts
    )
    paths: list[Path] = []
    for layout in layouts:
        for name, data in plates.files(layout, "plate", order.pictures, order.prusaslicer):
            paths.append(folder / "plates" / name)
            output.write(paths[-1], data)
            progress(name, len(paths), steps)
    rows = [row for layout in layouts for row in plates.places(layout)]
    weights.write_template(folder, dict.fromkeys(row.item for row in rows))
    return rows, paths
