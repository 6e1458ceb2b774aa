"""Printability: findings on parts that would not print as drawn, before anything is written.

Slicers do not report most of these: PrusaSlicer 2.5 silently slices legs away and parts off the
bed (tests/core/printing/test_slicer.py).
"""

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.printing import pocket_checks, supports, upside_down_checks, walls
from walkergen.core.printing.findings import ROUNDING_MM, About, Finding, Level, Setting, make_finding, with_place
from walkergen.core.printing.packing import Part, Plate, border_width, spacing
from walkergen.core.printing.printers import Printer
from walkergen.core.printing.walls import Wall
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import sections, solids
from walkergen.core.walker.design import Design

ONE_LINE_RANGE, TWO_LINES_RANGE = (0.75, 1.45), (1.75, 1.95)
"""Ranges of thickness, in printed lines, that come out as one or two lines on all known slicers."""

MAX_DEVIATION = 0.10
"""Relative deviation of the plastic in a leg from its mesh beyond which there is a warning."""

MAX_LAYER_RATIO = 0.8
"""Largest layer height in nozzles that slicers' makers advise; PrusaSlicer refuses more than 1."""

MAX_SLENDERNESS = 20.0
"""Height over thickness above which a brim is advised. Assumed: the paper's walker (8 mm high on legs of 0.4 mm) was
printed without mention of one."""


def check_batch(
    designs: Sequence[Design], meshes: Sequence[Mesh], parts: Sequence[Part], plates: Sequence[Plate], printer: Printer
) -> list[Finding]:
    """Return the findings on a whole print. `designs`, `meshes` (as they lie on the bed) and `parts` match in order."""
    return [
        *check_printer(printer),
        *_check_materials(designs, parts),
        *(
            finding
            for design, mesh, part in zip(designs, meshes, parts, strict=True)
            for finding in check_part(part.name, design, mesh, printer)
        ),
        *(
            finding
            for number, plate in enumerate(plates, start=1)
            for finding in check_plate(f"plate {number}", plate, parts, printer)
        ),
    ]


BRIM_ADVICE = ("set brim_width_mm, and cut it off every leg", Setting("printer.brim_width_mm", supports.BRIM_MM))
"""Advice for a small contact area with the bed, and a common brim width."""


def check_part(name: str, design: Design, mesh: Mesh, printer: Printer) -> list[Finding]:
    """Return the findings on one walker as `printer` would print it: walls, gaps, layers, size, mesh.

    The mesh is in printing orientation (solids.orient_for_print).
    """
    findings = [
        *_check_walls(design, printer),
        *_check_gaps(design, printer),
        *_check_marks(design, printer),
        *_check_layers(design, printer),
        *_check_size(Part.from_mesh(name, mesh), printer),
        *_check_mesh(mesh),
        *_check_repairs(design),
        *pocket_checks.check_part(design, printer),
    ]
    if not solids.is_printed_on_side(design):
        findings += upside_down_checks.check_part(design, mesh, printer)
    if printer.brim_width_mm == 0.0 and modeller.count_bodies(mesh) == 1:
        findings += _check_adhesion(design, mesh, printer)
    return with_place(name, findings)


def check_piece(name: str, upright: Sequence[Wall], mesh: Mesh, printer: Printer) -> list[Finding]:
    """Return the findings on a part that is no walker, as its mesh lies on the bed. `upright` has its upright walls.

    Its mass is not predicted, so that walls count only if they fail or print otherwise than drawn.
    """
    wall_findings = [check_wall(wall, printer, MAX_DEVIATION) for wall in upright]
    findings = [*_check_size(Part.from_mesh(name, mesh), printer), *_check_mesh(mesh)]
    if printer.brim_width_mm == 0.0:
        findings += _check_slenderness(upright)
    return with_place(name, [*filter(None, wall_findings), *findings])


def check_printer(printer: Printer) -> list[Finding]:
    """Return the findings on a printer's settings, which hold for any print."""
    layer, nozzle, width = printer.layer_height_mm, printer.nozzle_mm, printer.line_width_mm
    findings = []
    if layer > MAX_LAYER_RATIO * nozzle + ROUNDING_MM:
        level: Level = "error" if layer > nozzle else "warning"
        what, most = "layers are thick for the nozzle", MAX_LAYER_RATIO * nozzle
        findings.append(make_finding(About.PRINTER, level, what, layer, most, "mm", "lower layer_height_mm"))
    if width <= layer:
        what, change = "lines are not wider than layers are high", "raise line_width_mm or lower layer_height_mm"
        findings.append(make_finding(About.PRINTER, "error", what, width, layer, "mm", change))
    return with_place(printer.name, findings)


def check_plate(name: str, plate: Plate, parts: Sequence[Part], printer: Printer) -> list[Finding]:
    """Return the findings on the plate `name`: parts whose bounding boxes leave the bed, overlap, or are too close."""
    boxes = np.array(
        [(p.x, p.y, p.x + parts[p.part].width, p.y + parts[p.part].depth) for p in plate.placements]
    ).reshape(-1, 4)
    labels = [f"{name}: {parts[p.part].name}-{p.copy}" for p in plate.placements]
    return [*_check_bed_limits(labels, boxes, printer), *_check_spacing(labels, boxes, printer)]


def _check_walls(design: Design, printer: Printer) -> Iterator[Finding]:
    """Yield the findings on upright walls of a walker that fail, or print with another mass than predicted."""
    mass_sd = 0.01 * design.weighed.mass_sd_percent
    yield from filter(None, (check_wall(wall, printer, mass_sd) for wall in walls.upright_walls(design)))


def check_wall(wall: Wall, printer: Printer, mass_sd: float) -> Finding | None:
    """Return the worst finding on a wall, or None if it prints well.

    There is advice if its plastic deviates from the drawn by more than `mass_sd`, a share.
    """
    width, section, slant = printer.line_width_mm, wall.thickness_in_layer, wall.slant
    lines, expected = section / width, walls.plastic_deviation(section, printer)
    better = _nearest_good_thickness(wall.thickness, printer, slant)
    change, name = f"{better:g} mm would do", walls.with_article(wall.name)

    def wall_finding(level: Level, what: str, seen: float, limit: float, unit: str, change: str) -> Finding:
        """Return a finding on this wall, with `better`, the thickness, as its setting if `change` proposes that."""
        setting = Setting(wall.key, better) if wall.key and "would do" in change else None
        return make_finding(wall.part, level, what, seen, limit, unit, change, setting)

    if lines < ONE_LINE_RANGE[0]:
        what = f"{name} is thinner than {ONE_LINE_RANGE[0]:g} printed lines"
        return wall_finding("error", what, wall.thickness, ONE_LINE_RANGE[0] * width * slant, "mm", change)
    if section <= walls.vanishing_thickness(printer):
        what = f"{name} gets no plastic, thin walls not being detected"
        min_thickness = walls.vanishing_thickness(printer) * slant
        return wall_finding("error", what, wall.thickness, min_thickness, "mm", f"set thin_walls = true; or {change}")
    label = f"{name} ({wall.thickness:g} mm,"
    if ONE_LINE_RANGE[1] < lines < TWO_LINES_RANGE[0]:
        what = f"{label} plastic {expected:+.0%}) is more than one line and less than two"
        return wall_finding("warning", what, lines, ONE_LINE_RANGE[1], "lines", change)
    what = f"plastic in {label} {lines:.2f} lines) differs from the mesh's"
    weigh = f"weigh it after the print{_classic_walls_hint(lines, printer)}"
    if abs(expected) > MAX_DEVIATION:
        return wall_finding("warning", what, 100 * expected, 100 * MAX_DEVIATION, "%", f"{change}, or {weigh}")
    if abs(expected) > mass_sd:
        return wall_finding("advice", what, 100 * expected, 100 * mass_sd, "%", weigh)
    return None


def _is_good_thickness(thickness: float, printer: Printer) -> bool:
    """Return whether a wall of this thickness, mm, prints, and with nearly the plastic that is drawn."""
    lines = thickness / printer.line_width_mm
    return (
        thickness > walls.vanishing_thickness(printer)
        and lines >= ONE_LINE_RANGE[0]
        and not ONE_LINE_RANGE[1] < lines < TWO_LINES_RANGE[0]
        and abs(walls.plastic_deviation(thickness, printer)) <= MAX_DEVIATION
    )


def _nearest_good_thickness(thickness: float, printer: Printer, slant: float) -> float:
    """Return the closest thickness, mm, rounded to 0.01 mm, at which a wall prints well.

    `slant` is the cosine of the wall's tilt.
    """
    start, steps = round(100 * thickness), itertools.count()
    candidates = (max(0, start + sign * step) / 100 for step in steps for sign in (1, -1))
    return next(
        candidate for candidate in candidates if candidate > 0 and _is_good_thickness(candidate / slant, printer)
    )


def _classic_walls_hint(lines: float, printer: Printer) -> str:
    """Return the advice to use classic walls, for a wall (as thick as `lines` lines) that gains by it, or ""."""
    if printer.wall_generator == "classic" or lines > ONE_LINE_RANGE[1]:
        return ""
    return '; wall_generator = "classic" with thin_walls = true prints it as drawn'


def _check_gaps(design: Design, printer: Printer) -> Iterator[Finding]:
    """Yield warnings for gaps between legs, or between leg and brace, that are narrower than a line."""
    width = printer.line_width_mm
    for window, name in walls.group_legs(design, sections.window_width):
        if 0.0 < window < width:
            what = f"the window between {'leg and brace' if name == 'leg' else f'leg and brace of {name}'} may fuse"
            change = "tilt the legs more, or less; the legs are braced either way"
            yield make_finding(About.LEGS, "warning", what, window, width, "mm", change)
    clearance = sections.leg_clearance(design.limbs)
    if clearance < width:
        what = f"{'the two' if len(design.limbs) == 2 else 'two'} legs may fuse"
        change = "raise legs.contact_spacing_mm" if design.has_legs_table else "move them apart"
        yield make_finding(About.LEGS, "warning", what, clearance, width, "mm", change)


def _check_marks(design: Design, printer: Printer) -> Iterator[Finding]:
    """Yield advice if the strokes of the marks are narrower than a line."""
    marks, width = design.marks, printer.line_width_mm
    if not marks.blank and marks.line_mm < width - ROUNDING_MM:
        kind = "serial number" if marks.kind == "none" else marks.kind
        what = f"the {kind} may close up: their strokes against a line"
        yield make_finding(About.MARKS, "advice", what, marks.line_mm, width, "mm", "raise marks.line_mm")


def _check_layers(design: Design, printer: Printer) -> Iterator[Finding]:
    """Yield the findings on upright sizes of a printed walker that are no whole number of layers."""
    height, size = printer.layer_height_mm, design.size
    if solids.is_printed_on_side(design):
        yield from _check_whole_layers(About.BODY, "depth", size.depth, height, "body.depth_mm")
        for width, name in walls.group_legs(design, lambda limb: limb.width):
            if width != size.depth:
                yield from _check_whole_layers(
                    About.LEGS, f"width of {walls.with_article(name)}", width, height, "its width_mm"
                )
    elif design.body.mesh is None:
        key = "body.thickness_mm" if design.body.profile_mm is None else "the height of profile_mm"
        yield from _check_whole_layers(About.BODY, "body's thickness", size.thickness, height, key)


def _check_whole_layers(part: About, what: str, length: float, height: float, key: str) -> Iterator[Finding]:
    """Yield the findings on a `length` in layers of this `height`, mm. `what` is its name, and `key` sets it."""
    layers = length / height
    # PrusaSlicer prints a layer if its middle is in the part.
    whole = math.floor(layers + 0.5 + ROUNDING_MM)
    if layers <= 0.5:
        change = f"raise {key} or lower layer_height_mm"
        yield make_finding(part, "error", f"the {what} is less than half a layer", length, 0.5 * height, "mm", change)
    elif abs(layers - whole) > ROUNDING_MM:
        printed = float(f"{max(1, whole) * height:.6g}")
        change = f"make {key} {printed:g}, which is what prints"
        setting = Setting(key, printed) if key.startswith("body.") else None
        what = f"the {what} is not a whole number of layers"
        yield make_finding(part, "warning", what, layers, whole, "layers", change, setting)


def _check_materials(designs: Sequence[Design], parts: Sequence[Part]) -> Iterator[Finding]:
    """Yield a warning for the first part whose material has another density than that of the first part."""
    densities = [design.material.density_g_cm3 for design in designs]
    for density, part in zip(densities, parts, strict=True):
        if density != densities[0]:
            what = "one filament prints a plate, and the parts before it have another density"
            change = "print each material on plates of its own"
            yield from with_place(
                part.name, [make_finding(About.WALKER, "warning", what, density, densities[0], "g/cm3", change)]
            )
            return


def _check_size(part: Part, printer: Printer) -> Iterator[Finding]:
    """Yield errors for a part that is larger than the bed inside its border, or higher than the printer."""
    borders = 2.0 * border_width(printer)
    for what, seen, limit in (
        ("width", part.width, printer.bed_width_mm - borders),
        ("depth", part.depth, printer.bed_depth_mm - borders),
        ("height", part.height, printer.height_mm),
    ):
        if seen > limit + ROUNDING_MM:
            change = "make it smaller or take a larger printer"
            yield make_finding(
                About.WALKER, "error", f"its {what} as printed exceeds the printer's", seen, limit, "mm", change
            )


def _check_mesh(mesh: Mesh) -> Iterator[Finding]:
    """Yield an error unless the mesh is one closed body."""
    bodies = modeller.count_bodies(mesh)
    if bodies != 1:
        change = "enlarge details below about 1e-5 mm, which files do not hold"
        yield make_finding(About.WALKER, "error", "the mesh is not one closed body", bodies, 1, "bodies", change)


def _check_repairs(design: Design) -> Iterator[Finding]:
    """Yield a warning if the shape of the body differs from its file."""
    if changes := design.shape.changes:
        what = f"the body's file was not taken as it is ({'; '.join(changes)})"
        yield make_finding(
            About.BODY, "warning", what, len(changes), 0, "changes", "look at its picture before the print"
        )


def _check_adhesion(design: Design, mesh: Mesh, printer: Printer) -> Iterator[Finding]:
    """Yield advice to print a brim, for a small area on the bed and for high, thin walls."""
    area = supports.contact_area(mesh, printer)
    if area < supports.MIN_CONTACT_MM2:
        what = "little of it holds on to the bed"
        yield make_finding(About.WALKER, "advice", what, area, supports.MIN_CONTACT_MM2, "mm2", *BRIM_ADVICE)
    yield from _check_slenderness(walls.upright_walls(design))


def _check_slenderness(upright: Sequence[Wall]) -> Iterator[Finding]:
    """Yield advice on walls that print high and thin."""
    for wall in upright:
        slenderness = wall.height / wall.thickness
        if slenderness > MAX_SLENDERNESS * (1.0 + ROUNDING_MM):
            what = f"{walls.with_article(wall.name)} prints high and thin: height over thickness"
            yield make_finding(wall.part, "advice", what, slenderness, MAX_SLENDERNESS, "", *BRIM_ADVICE)


def _check_bed_limits(labels: Sequence[str], boxes: Array, printer: Printer) -> Iterator[Finding]:
    """Yield errors for parts, brims and skirt beyond the bed.

    `labels` are the names of the parts, and `boxes`, shape (n, 4), their left, front, right and back sides, mm.
    """
    bed = np.array([printer.bed_width_mm, printer.bed_depth_mm])
    brim = printer.brim_width_mm
    skirt = printer.skirt_distance_mm + (printer.skirt_loops + 0.5) * printer.line_width_mm
    rings = {"the part": 0.0} | ({"its brim": brim} if brim else {})
    if printer.skirt_loops:  # half a line more: measured on PrusaSlicer's skirts
        rings["the skirt around it"] = brim + skirt
    for what, ring_width in rings.items():
        excess = np.maximum(ring_width - boxes[:, :2], boxes[:, 2:] + ring_width - bed).max(axis=1)
        for index in np.flatnonzero(excess > ROUNDING_MM)[:1]:
            change = "raise margin_mm, or make brim or skirt smaller"
            leaves = make_finding(About.PLATE, "error", f"{what} leaves the bed", excess[index], 0.0, "mm", change)
            yield from with_place(labels[index], [leaves])


def _check_spacing(labels: Sequence[str], boxes: Array, printer: Printer) -> Iterator[Finding]:
    """Yield a finding for each two parts that are too close or overlap. Arguments as for `_check_bed_limits`."""
    brims, min_gap = 2.0 * printer.brim_width_mm, spacing(printer)
    for first, box in enumerate(boxes):
        later = boxes[first + 1 :]
        gaps = np.maximum(later[:, :2] - box[2:], box[:2] - later[:, 2:]).max(axis=1)
        for second in np.flatnonzero(gaps < min_gap - ROUNDING_MM):
            other = labels[first + 1 + int(second)].split(": ")[-1]
            overlap = gaps[second] < brims - ROUNDING_MM
            level: Level = "error" if overlap else "warning"
            what = "with its brim, if any, overlaps" if overlap else "is closer than the gap to"
            close = make_finding(About.PLATE, level, f"{what} {other}", gaps[second], min_gap, "mm", "move them apart")
            yield from with_place(labels[first], [close])
