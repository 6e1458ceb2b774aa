"""Checks of pockets for motor and battery: whether parts go in, walls, what prints over air."""

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
    """Yield the findings on the pockets of one walker, whichever way it lies."""

    def warning(what: str, seen: float, limit: float, change: str) -> Finding:
        return make_finding(About.POCKETS, "warning", what, seen, limit, "mm", change)

    line, parts = printer.line_width_mm, design.parts
    clearance, wanted = design.fit.clearance_mm, printer.pocket_clearance_mm
    if parts and clearance < wanted - ROUNDING_MM:
        what = f"{' and '.join(parts)} may not go into the pocket as this printer prints it"
        yield warning(what, clearance, wanted, f"set pockets.clearance_mm = {wanted:g}")
    channel = design.fit.channel_mm
    if len(parts) > 1 and 0.0 < channel < 2.0 * line:
        change = "raise pockets.channel_mm, or make it 0 and lead the wires outside"
        yield warning("the channel of the wires may fuse", channel, 2.0 * line, change)
    between = pockets.wall_between(design, line)
    if between < line - ROUNDING_MM:
        what = "the wall between the pockets of motor and battery is thinner than a printed line, or open"
        yield warning(what, between, line, "move one of them (along_mm, across_mm, up_mm)")
    for name, part in parts.items():
        wall, span = thinnest_wall(part, design), ceiling_span(part, design)
        if wall < line - ROUNDING_MM:
            what = f"the wall around the pocket of the {name} is thinner than a printed line, or open"
            yield warning(what, wall, line, f"move the {name} inward, or make the body larger")
        if span > MAX_BRIDGE_MM:
            better = "side" if solids.is_printed_on_side(design) else "down"
            what = f"the pocket of the {name} prints with its floor over air"
            change = f"set {name}.opens = {better!r}, or print it with supports on the bed"
            yield warning(what, span, MAX_BRIDGE_MM, change)


def ceiling_span(part: Part, design: Design) -> float:
    """Return the span of the bridge that closes a pocket at the top, in printing orientation, mm; 0 without one.

    A pocket that opens to the top of the print has none. Else it is the shorter way between two
    walls: along, or the other level axis unless the pocket is open there.
    """
    side = solids.is_printed_on_side(design)
    if part.opens == ("side" if side else "down"):
        return 0.0
    room = [2.0 * (half + design.fit.clearance_mm) for half in part.cylinder.half]
    if side:
        return room[0]  # it opens up or down, which is level in the print
    return min(room[0], math.inf if part.opens == "side" else room[2])


def thinnest_wall(part: Part, design: Design) -> float:
    """Return the thinnest wall between a pocket and the edge of the body, across the way to its opening, mm.

    0 where the pocket breaks through it; infinite where there is no outline to tell by: of a mesh
    into which a pocket opens from above or below.
    """
    import shapely

    if part.opens == "side":
        return _side_wall(part, design)
    if design.body.mesh is not None:
        return math.inf
    size, own, clearance = design.size, part.cylinder, design.fit.clearance_mm
    x, z = own.centre[0], own.centre[2]
    if own.axis == 1:
        hole = shapely.Point(x, -z).buffer(own.radius + clearance, quad_segs=32)
    else:
        wide, deep = own.half[0] + clearance, own.half[2] + clearance
        hole = shapely.box(x - wide, -z - deep, x + wide, -z + deep)
    ground = shapely.box(*(0.5 * np.array([-size.length, -size.depth, size.length, size.depth])))
    if design.body.flat:
        outer, *holes = design.shape.plan
        ground = shapely.Polygon(outer, holes)
    return float(hole.distance(ground.boundary)) if ground.contains(hole) else 0.0


def _side_wall(part: Part, design: Design) -> float:
    """Return the thinnest wall of a pocket open to the side, in slices of the body along the part, mm.

    Where the part stands out of the body's upper edge there is no wall above it.
    """
    import shapely

    own, clearance = part.cylinder, design.fit.clearance_mm
    (x, y, z), half = own.centre_in_design(design.size.depth), own.half
    if own.axis == 2:
        room = shapely.Point(x, y).buffer(own.radius + clearance, quad_segs=32)
    else:
        wide, high = half[0] + clearance, half[1] + clearance
        room = shapely.box(x - wide, y - high, x + wide, y + high)
    body = modeller.to_solid(solids.build(pockets.without_pockets(design)).body)
    # A part that lies across narrows behind its middle, its room does not before it
    ends = z - (half[2] if own.axis == 2 else 0.0), min(z + half[2], design.size.depth)
    places = ends[0] + (np.arange(SLICE_COUNT) + 0.5) / SLICE_COUNT * (ends[1] - ends[0])
    return min(_wall_thickness(room, _combine_contours(body.slice(float(at)).to_polygons())) for at in places)


def _combine_contours(contours: list[np.ndarray]) -> "shapely.Geometry":
    """Return the area of contours; contours inside others are holes."""
    import shapely

    areas = [shapely.Polygon(contour) for contour in contours]
    return reduce(shapely.symmetric_difference, areas, shapely.Polygon())


def _wall_thickness(room: "shapely.Geometry", body: "shapely.Geometry") -> float:
    """Return the smallest distance of a pocket's space from the edge of a slice of the body, y up, mm.

    Where the room stands out above, the lip there counts for no wall; 0 where it does elsewhere.
    """
    import shapely

    if body.is_empty:
        return 0.0
    if body.contains(room):
        return float(room.distance(body.boundary))
    left, bottom, right, top = room.bounds
    far = 2.0 * sum(map(abs, (*room.bounds, *body.bounds)))
    above = shapely.box(left, bottom, right, top + far)
    lip = body.boundary.intersection(above)
    if lip.is_empty:
        return 0.0
    height = lip.bounds[1] - ROUNDING_MM
    below = shapely.box(left - far, bottom - far, right + far, height)
    inside = room.intersection(below)
    filled = body.union(shapely.box(left, height, right, top + far))
    edge = body.boundary.intersection(below)
    return float(inside.distance(edge)) if filled.contains(inside) else 0.0
