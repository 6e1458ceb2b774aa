"""Checks of pockets for motor and battery: whether parts fit in, thin walls, ceilings printed over air."""

import math
from collections.abc import Iterator
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from walkergen.core.printing.findings import ROUNDING_MM, About, Finding, make_finding
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.walker import pockets, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import Part

if TYPE_CHECKING:
    import shapely

MAX_BRIDGE_MM = 10.0
"""Longest ceiling that is bridged from wall to wall without sagging into the pocket. Assumed, the
usual rule of makers' test prints."""

SLICE_COUNT = 8
"""Number of slices that measure the walls of a pocket open to the side."""


def check_part(design: Design, printer: Printer) -> Iterator[Finding]:
    """Yield the findings on the pockets of one walker, printed on its side or upside down."""

    def warning(what: str, seen: float, limit: float, change: str) -> Finding:
        """Return a warning on the pockets, with sizes in mm."""
        return make_finding(About.POCKETS, "warning", what, seen, limit, "mm", change)

    line, parts = printer.line_width_mm, design.parts
    clearance, needed = design.pocket_settings.clearance_mm, printer.pocket_clearance_mm
    if parts and clearance < needed - ROUNDING_MM:
        what = f"{' and '.join(parts)} may not go into the pocket as this printer prints it"
        yield warning(what, clearance, needed, f"set pockets.clearance_mm = {needed:g}")
    channel = design.pocket_settings.channel_mm
    if len(parts) > 1 and 0.0 < channel < 2.0 * line:
        change = "raise pockets.channel_mm, or make it 0 and lead the wires outside"
        yield warning("the channel of the wires may fuse", channel, 2.0 * line, change)
    wall_between_pockets = pockets.wall_between(design, line)
    if wall_between_pockets < line - ROUNDING_MM:
        what = "the wall between the pockets of motor and battery is thinner than a printed line, or open"
        yield warning(what, wall_between_pockets, line, "move one of them (along_mm, across_mm, up_mm)")
    for name, part in parts.items():
        wall, span = thinnest_wall(part, design), ceiling_span(part, design)
        if wall < line - ROUNDING_MM:
            what = f"the wall around the pocket of the {name} is thinner than a printed line, or open"
            yield warning(what, wall, line, f"move the {name} inward, or make the body larger")
        if span > MAX_BRIDGE_MM:
            better = "side" if solids.is_printed_on_side(design) else "down"
            what = f"the pocket of the {name} prints with its floor over air"
            yield warning(what, span, MAX_BRIDGE_MM, f"set {name}.opens = {better!r}")


def ceiling_span(part: Part, design: Design) -> float:
    """Return the span, mm, of the bridge of plastic over a pocket in the print, or 0 if the pocket is open at that end.

    That end is open if the pocket opens down in a body that prints upside down, or to the side in one on its side. The
    bridge joins the two nearer walls: those along the body, or those across it unless the pocket opens to the side.
    """
    is_on_side = solids.is_printed_on_side(design)
    if part.opens == ("side" if is_on_side else "down"):
        return 0.0
    pocket_size = [2.0 * (half + design.pocket_settings.clearance_mm) for half in part.cylinder.half]
    if is_on_side:
        return pocket_size[0]  # it opens up or down, which is level in the print
    return min(pocket_size[0], math.inf if part.opens == "side" else pocket_size[2])


def thinnest_wall(part: Part, design: Design) -> float:
    """Return the thinnest wall, mm, between a pocket and the edge of the body in planes across its opening direction.

    It is 0 where the pocket breaks through. It is infinite if the body is a mesh, whose outline is unknown, and the
    pocket opens above or below.
    """
    import shapely

    if part.opens == "side":
        return _side_wall(part, design)
    if design.body.mesh is not None:
        return math.inf
    size, cylinder, clearance = design.size, part.cylinder, design.pocket_settings.clearance_mm
    x, z = cylinder.centre[0], cylinder.centre[2]
    if cylinder.axis == 1:
        hole = shapely.Point(x, -z).buffer(cylinder.radius + clearance, quad_segs=32)
    else:
        half_length, half_depth = cylinder.half[0] + clearance, cylinder.half[2] + clearance
        hole = shapely.box(x - half_length, -z - half_depth, x + half_length, -z + half_depth)
    plan_area = shapely.box(*(0.5 * np.array([-size.length, -size.depth, size.length, size.depth])))
    if design.body.flat:
        outer, *holes = design.shape.plan
        plan_area = shapely.Polygon(outer, holes)
    return float(hole.distance(plan_area.boundary)) if plan_area.contains(hole) else 0.0


def _side_wall(part: Part, design: Design) -> float:
    """Return the thinnest wall around a pocket open to the side, from slices of the body across its opening, mm.

    Where the part stands out of the body's upper edge there is no wall above it.
    """
    import shapely

    cylinder, clearance = part.cylinder, design.pocket_settings.clearance_mm
    (x, y, z), half = cylinder.centre_in_design(design.size.depth), cylinder.half
    if cylinder.axis == 2:
        pocket = shapely.Point(x, y).buffer(cylinder.radius + clearance, quad_segs=32)
    else:
        half_length, half_height = half[0] + clearance, half[1] + clearance
        pocket = shapely.box(x - half_length, y - half_height, x + half_length, y + half_height)
    body = modeller.to_solid(solids.build(pockets.without_pockets(design)).body)
    # Range of z of the slices: from where the part is widest, up to the opening
    ends = z - (half[2] if cylinder.axis == 2 else 0.0), min(z + half[2], design.size.depth)
    heights = ends[0] + (np.arange(SLICE_COUNT) + 0.5) / SLICE_COUNT * (ends[1] - ends[0])
    return min(
        _wall_thickness(pocket, _combine_contours(body.slice(float(height)).to_polygons())) for height in heights
    )


def _combine_contours(contours: list[np.ndarray]) -> "shapely.Geometry":
    """Return the area inside contours, each of shape (n, 2). Contours inside others are holes."""
    import shapely

    areas = [shapely.Polygon(contour) for contour in contours]
    return reduce(shapely.symmetric_difference, areas, shapely.Polygon())


def _wall_thickness(pocket: "shapely.Geometry", body: "shapely.Geometry") -> float:
    """Return the smallest distance of a pocket from the edge of the body in one slice, y up, mm.

    If the pocket opens through the body's upper edge, edges beside the opening are no walls. If it leaves the body
    elsewhere, return 0.
    """
    import shapely

    if body.is_empty:
        return 0.0
    if body.contains(pocket):
        return float(pocket.distance(body.boundary))
    left, bottom, right, top = pocket.bounds
    margin = 2.0 * sum(map(abs, (*pocket.bounds, *body.bounds)))
    above = shapely.box(left, bottom, right, top + margin)
    lip = body.boundary.intersection(above)
    if lip.is_empty:
        return 0.0
    height = lip.bounds[1] - ROUNDING_MM
    below = shapely.box(left - margin, bottom - margin, right + margin, height)
    inside = pocket.intersection(below)
    filled = body.union(shapely.box(left, height, right, top + margin))
    edge = body.boundary.intersection(below)
    return float(inside.distance(edge)) if filled.contains(inside) else 0.0
