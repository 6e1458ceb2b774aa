"""Closed forms of a walker's parts: areas, centres and second moments from the design alone.

Coordinates along (u, from the anchor to the foot) and across (v) a leg of length l and thickness s:
the leg is the strip |v| <= s/2 from the body's bottom face, u = -v tan(tilt), to its foot.
"""

import math
from typing import NamedTuple

from walkergen.core.walker.design import Design
from walkergen.core.walker.sections import section_of


class Shape(NamedTuple):
    """Area (mm^2), centre (mm) and polar second moment about it (mm^4) of a plane figure."""

    area: float
    x: float
    y: float
    second: float


def rectangle(length: float, height: float) -> Shape:
    """Return the shape of a rectangle centred at the origin."""
    area = length * height
    return Shape(area, 0.0, 0.0, area * (length**2 + height**2) / 12.0)


def leg(design: Design) -> Shape:
    """Return the shape of a leg without brace. Its anchor is the origin; a round foot is an exact half circle."""
    s, foot = design.limbs[0].thickness, design.limbs[0].foot
    k, r = -math.tan(design.limbs[0].tilt), 0.5 * s
    side = design.limbs[0].length - (r if foot == "round" else 0.0)
    # Integrals of 1, u, v, u^2 + v^2 over the strip up to a straight end at u = side ...
    area, along, across = side * s, 0.5 * side**2 * s - k**2 * s**3 / 24.0, -k * s**3 / 12.0
    second = side**3 * s / 3.0 + side * s**3 / 12.0
    if foot == "flat":  # ... or parallel to the plate, at u = side + k v,
        along, across = 0.5 * side**2 * s, 0.0
        second += side * k**2 * s**3 / 12.0
    elif foot == "round":  # ... and with the half circle's.
        disc = 0.5 * math.pi * r**2
        area, along = area + disc, along + disc * side + 2.0 / 3.0 * r**3
        second += disc * (side**2 + 0.5 * r**2) + 4.0 / 3.0 * side * r**3
    u, v = along / area, across / area
    return Shape(area, *_to_walker_axes(design, u, v), second - area * (u**2 + v**2))


def polygon_deficit(design: Design, segments: int) -> Shape:
    """Return a round foot's half circle minus its polygon with `segments` edges, to leading order.

    The deficit is uniform along the arc, whose mean lies 2 r / pi from the circle's middle. Zero for other feet.
    """
    if design.limbs[0].foot != "round":
        return Shape(0.0, 0.0, 0.0, 0.0)
    r = 0.5 * design.limbs[0].thickness
    area, offset = math.pi**3 * r**2 / (12.0 * segments**2), 2.0 * r / math.pi
    return Shape(area, *_to_walker_axes(design, design.limbs[0].length - r + offset, 0.0), area * (r**2 - offset**2))


def subtract_part(whole: Shape, part: Shape) -> Shape:
    """Subtract a part from a figure, by parallel axes."""
    area = whole.area - part.area
    x, y = whole.x - part.area * (part.x - whole.x) / area, whole.y - part.area * (part.y - whole.y) / area
    second = whole.second - part.second
    second -= part.area * whole.area / area * ((part.x - whole.x) ** 2 + (part.y - whole.y) ** 2)
    return Shape(area, x, y, second)


def _to_walker_axes(design: Design, u: float, v: float) -> tuple[float, float]:
    """Transform a position along (u) and across (v) a leg to the walker's x and y."""
    sin, cos = math.sin(design.limbs[0].tilt), math.cos(design.limbs[0].tilt)
    return cos * v - sin * u, -sin * v - cos * u


def brace_area_outside(design: Design) -> float:
    """Return the area (mm^2) that a flat-footed leg's brace adds to the leg.

    At a distance d between the centre lines, the brace is within the leg up to d = (w - b) / 2 and clear
    of it from d = (w + b) / 2 on, w and b their widths. d falls evenly from the brace's offset at
    the body to 0 at the foot.
    """
    limb = design.limbs[0]
    (strut,) = section_of(limb).struts(limb)
    cos, brace = math.cos(limb.tilt), strut.thickness
    height, offset = limb.length * cos, abs(strut.offset)
    within = 0.5 * (limb.thickness / cos - brace)
    if offset <= within:
        return 0.0
    partly = min(offset - within, brace)
    return height * (0.5 * partly**2 + brace * (offset - within - partly)) / offset
