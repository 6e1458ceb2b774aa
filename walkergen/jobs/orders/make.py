"""Parts and plates without predictions: single files for export, copies arranged for printing."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.files import output
from walkergen.files.assignments import changed
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.printing import checks, export, orientation, packing, plates, profile, sheet, walls
from walkergen.printing.checks import Finding
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.shapes.mesh import Mesh
from walkergen.shapes.outlines import Polygon
from walkergen.walker import names, solids, weights
from walkergen.walker.design import Design

SOLID: dict[str, Callable[[Mesh, str], bytes]] = {"stl": export.stl_bytes, "3mf": export.part_3mf}
"""Formats of meshes as they lie on the bed."""

FORMATS = (*SOLID, *profile.FORMATS)

MJCF = "mjcf"
"""Format of MuJoCo, of a walker in a scene: several files."""


class Order(NamedTuple):
    """Choice of what to print, and on which printers."""

    members: Sequence[Design]
    copies: Sequence[int]
    """Number of copies of each member."""
    printers: Sequence[Printer]
    """Printers to arrange for, each with all copies."""
    max_plates: int | None = None
    """Largest number of plates; None: no limit."""
    max_parts: int = packing.MOST_PARTS
    """Largest number of parts on a plate."""
    pictures: bool = True
    prusaslicer: bool = False
    """True to declare the 3MF files PrusaSlicer's own."""
    serial: int | None = None
    """Number that the first copy bears, from which the others count; None: copies bear none."""
    strict: bool = False
    """True to refuse what prints otherwise than predicted, not only what fails."""


class Wall(NamedTuple):
    """Wall of a thickness that occurs among the members, as the printer prints it."""

    wall: str
    thickness_mm: float
    lines: float
    """Thickness of the wall in printed lines."""
    plastic_percent: float
    """Expected deviation of the wall's plastic from the mesh, percent."""


class Checked(NamedTuple):
    """Results of `check`."""

    walls: list[Wall]
    findings: list[Finding]
    parts: int
    plates: int
    """Number of plates; 0 when a part fits no plate."""
    orientations: list[str]
    """How the walkers lie on the bed, and with which supports."""


class Room(NamedTuple):
    """Number of copies of one walker that fit on one plate."""

    printer: str
    name: str
    fit: int


def export_parts(
    members: Sequence[Design], formats: Sequence[str], folder: Path, progress: Progress,
    scene: Scene | None = None,
) -> list[Path]:  # fmt: skip
    """Write every member in every format (of FORMATS) as folder/FORMAT/NAME.FORMAT.

    MJCF, of walkers in a scene, is folder/mjcf/NAME.xml with its STL files beside it. Raises
    InputError, before anything is written, for the drawing of a walker that has none, and for a
    scene that MJCF cannot hold.
    """
    models = [_model(design, scene) if MJCF in formats else [] for design in members]
    drawings = [
        profile.drawing_of(design) if any(form in profile.FORMATS for form in formats) else []
        for design in members
    ]
    written = []
    with Folder(folder, "") as target:
        for number, design in enumerate(members):
            name = names.part(design)
            mesh = solids.as_printed(design, solids.build(design).walker)
            drawn, model = drawings[number], models[number]
            for form in formats:
                for file, data in model if form == MJCF else [_single(form, name, mesh, drawn)]:
                    target.write(f"{form}/{file}", data)
                    written.append(folder / form / file)
            progress(name, number + 1, len(members))
    return written


def _single(form: str, name: str, mesh: Mesh, drawing: Sequence[Polygon]) -> tuple[str, bytes]:
    """Name and bytes of the file of a walker, its mesh or its drawing, in one of FORMATS."""
    data = SOLID[form](mesh, name) if form in SOLID else profile.FORMATS[form](drawing)
    return f"{name}.{form}", data


def _model(design: Design, scene: Scene | None) -> list[tuple[str, bytes]]:
    """Names and bytes of the MJCF of a walker in a scene. Raises InputError."""
    from walkergen.jobs.orders import mjcf

    assert scene is not None
    return list(mjcf.files(design, scene))


def export_part(design: Design, path: Path) -> None:
    """Write one walker into the file `path`, whose ending is one of FORMATS.

    The bytes are those of `export_parts`. Raises InputError for other endings, and for the drawing
    of a walker that has none.
    """
    form = path.suffix.removeprefix(".").lower()
    if form in SOLID:
        mesh = solids.as_printed(design, solids.build(design).walker)
        output.write(path, SOLID[form](mesh, names.part(design)))
    elif form in profile.FORMATS:
        output.write(path, profile.FORMATS[form](profile.drawing_of(design)))
    else:
        raise InputError(f"{str(path)!r}: must end in one of {', '.join(FORMATS)}, as walker.stl")


def how_many(members: Sequence[Design], printers: Sequence[Printer], max_parts: int) -> list[Room]:
    """Count the copies of each member that fit on one plate of each printer with no other parts."""
    built = [solids.build(design) for design in members]
    return [
        Room(printer.name, part.name, min(packing.capacity(part, printer), max_parts))
        for printer in printers
        for part in plates.unplaced(members, built, [1] * len(built), printer).parts
    ]


def check(members: Sequence[Design], copies: Sequence[int], printer: Printer) -> Checked:
    """Run the printability checks on arranged copies of the members; writes nothing."""
    built = [solids.build(design) for design in members]
    layout = plates.unplaced(members, built, copies, printer)
    if all(packing.capacity(part, printer) for part in layout.parts):
        layout = plates.arrange(members, built, copies, printer)
    else:  # a part is too large for any plate: the findings name it
        layout = plates.checked(layout)
    unlike_walls = dict.fromkeys(
        Wall(
            wall.name,
            wall.thickness,
            wall.section / printer.line_width_mm,
            100.0 * walls.deviation(wall.section, printer),
        )
        for design in members
        for wall in walls.of_design(design)
    )
    attitudes = dict.fromkeys(orientation.words(design) for design in members)
    return Checked(
        list(unlike_walls), list(layout.findings), sum(copies), len(layout.plates), list(attitudes)
    )


def make_plates(
    order: Order, folder: Path, progress: Progress, tell: Callable[[Sequence[Finding]], None]
) -> tuple[list[plates.Place], list[Path]]:
    """Arrange copies for every printer; write 3MF files, maps, print sheets and weights.csv.

    Members of several designs go onto the same plates, and have a weights_DESIGN.csv each.
    Plates of an earlier run for the same printer that this run does not make, and that nobody
    changed since, are removed.
    `tell` is called with the printability checks' findings. Raises, before anything is written,
    PlateError when a part is too large for a printer or more plates are needed than allowed, and
    PrintabilityError when a part would not print (strict: would print otherwise than predicted).
    """
    members, copies = numbered(order)
    built = [solids.build(design) for design in members]
    layouts = [
        plates.arrange(members, built, copies, printer, order.max_plates, order.max_parts)
        for printer in order.printers
    ]
    findings = [
        # With several printers findings name the printer.
        finding._replace(where=f"{layout.printer.name}: {finding.where}")
        if len(layouts) > 1
        else finding
        for layout in layouts
        for finding in layout.findings
    ]
    tell(findings)
    checks.refuse(findings, order.strict)
    steps = sum(
        plates.COMMON_FILES + len(layout.plates) * (1 + order.pictures) + 1 for layout in layouts
    )
    paths: list[Path] = []
    for layout in layouts:
        # A manifest a printer, so that plates for one do not sweep away those for another.
        with Folder(folder / "plates", f"plate_{layout.printer.name}.json") as target:
            for name, data in plates.files(layout, "plate", order.pictures, order.prusaslicer):
                target.write(name, data)
                paths.append(target.path / name)
                progress(name, len(paths), steps)
            target.finish(_facts(layout))
            paths.append(target.path / target.manifest)
            progress(target.manifest, len(paths), steps)
    rows = [row for layout in layouts for row in plates.places(layout)]
    return rows, [*paths, *_write_forms(order.members, rows, folder)]


def numbered(order: Order) -> tuple[Sequence[Design], Sequence[int]]:
    """Members and copies of an order; with serial numbers every copy is a member of its own.

    Numbers count over all members, so that no two copies of an order share one. Raises
    GeometryError for a copy that has no room for its number, InputError for too large a number.
    """
    if order.serial is None:
        return order.members, order.copies
    packing.check_number(sum(order.copies))
    every = [design for design, count in zip(order.members, order.copies, strict=True)
            for _ in range(count)]  # fmt: skip
    members = [
        changed(design, {"marks.serial": number}, design.name)
        for number, design in enumerate(every, start=order.serial)
    ]
    return members, [1] * len(members)


def _facts(layout: plates.Layout) -> dict[str, Any]:
    """Facts for a printer's manifest: inputs resolved, findings, versions of the software."""
    by_name = names.by_design(layout.members)
    return {
        # Of several members of a design the first: names tell the tilts and kinds of the others.
        "designs": {name: members[0].model_dump(mode="json") for name, members in by_name.items()},
        "bodies": {name: sheet.body_facts(members[0]) for name, members in by_name.items()},
        "members": [part.name for part in layout.parts],
        "copies": [part.copies for part in layout.parts],
        "serial": [part.serial for part in layout.parts if part.serial is not None],
        "printer": layout.printer.model_dump(mode="json"),
        "print": sheet.facts(layout.printer, layout.findings),
        "versions": output.versions(),
    }


def _write_forms(
    members: Sequence[Design], rows: Sequence[plates.Place], folder: Path
) -> list[Path]:
    """Write forms for the masses of each design's copies, but for those somebody filled in."""
    design_of = dict(zip(names.parts(members), members, strict=True))
    items: dict[str, dict[str, None]] = {}
    for row in rows:  # with several printers a copy has several rows
        items.setdefault(design_of[row.name].name, {})[row.item] = None
    written = []
    for name, own in items.items():
        written.append(weights.write_template(folder, own, weights.form(members, name)))
    return [path for path in written if path is not None]
