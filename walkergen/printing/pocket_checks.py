"""Checks of pockets for motor and battery: whether parts go in, and what prints over air."""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.printing.findings import NOISE_MM, Finding, new
from walkergen.printing.printers import Printer
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.payload import Part

WIDEST_BRIDGE_MM = 10.0
"""Longest ceiling that is bridged from wall to wall without sagging into the pocket. Assumed, the
usual rule of makers' test prints."""


def of_part(design: Design, printer: Printer) -> Iterator[Finding]:
    """Findings on the pockets of one walker, in whichever way it lies."""
    clearance, wanted = design.fit.clearance_mm, printer.pocket_clearance_mm
    if design.parts and clearance < wanted - NOISE_MM:
        yield new("warning", f"{' and '.join(design.parts)} may not go into the pocket as this "
                  "printer prints it", clearance, wanted, "mm",
                  f"set pockets.clearance_mm = {wanted:g}")  # fmt: skip
    channel = design.fit.channel_mm
    if len(design.parts) > 1 and 0.0 < channel < 2.0 * printer.line_width_mm:
        yield new("warning", "the channel of the wires may fuse", channel,
                  2.0 * printer.line_width_mm, "mm", "raise pockets.channel_mm, or make it 0 and "
                  "lead the wires outside")  # fmt: skip
    for name, part in design.parts.items():
        wall = thinnest_wall(part, design)
        if wall < printer.line_width_mm - NOISE_MM:
            yield new("warning", f"the wall around the pocket of the {name} is thinner than a "
                      "printed line, or open", wall, printer.line_width_mm, "mm",
                      f"move the {name} inward, or make the body larger")  # fmt: skip
        span = ceiling(part, design)
        if span > WIDEST_BRIDGE_MM:
            better = "side" if solids.on_side(design) else "down"
            yield new("warning", f"the pocket of the {name} prints with its floor over air", span,
                      WIDEST_BRIDGE_MM, "mm", f"set {name}.opens = {better!r}, or print it with "
                      "supports on the bed")  # fmt: skip


def ceiling(part: Part, design: Design) -> float:
    """Span of the bridge that ends a pocket at the top, as the walker lies, mm; 0 without one.

    A pocket that opens to the top of the print has none. Else it is the shorter way between two
    walls: along, or the other level axis unless the pocket is open there.
    """
    side = solids.on_side(design)
    if part.opens == ("side" if side else "down"):
        return 0.0
    room = [2.0 * (half + design.fit.clearance_mm) for half in part.cylinder.half]
    if side:
        return room[0]  # it opens up or down, which is level in the print
    return min(room[0], math.inf if part.opens == "side" else room[2])


def thinnest_wall(part: Part, design: Design) -> float:
    """Thinnest wall between a pocket that opens up or down and the edge of the body, mm.

    0 where the pocket breaks through it; infinite where there is no outline to tell by: of a mesh,
    and of a pocket that opens to the side, which may stand out of the body's upper edge.
    """
    import shapely

    if part.opens == "side" or design.body.mesh is not None:
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
        outer, *holes = design.body.shape.plan
        ground = shapely.Polygon(outer, holes)
    return float(hole.distance(ground.boundary)) if ground.contains(hole) else 0.0
