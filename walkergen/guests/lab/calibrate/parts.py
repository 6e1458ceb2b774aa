"""Parts of a calibration plate: strips for Young's modulus, a block for friction and density.

Strips print like legs on their side: a wall of whole lines along the strip, layers across its width. So they measure
the bending modulus of such a leg, not that of solid plastic.
"""

import math
from typing import NamedTuple

import manifold3d
import numpy as np

from walkergen.core import Design, Printer
from walkergen.core.printing import walls
from walkergen.core.printing.packing import border_width
from walkergen.core.scene import GRAVITY
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.shapes.modeller import Engraving, extrude
from walkergen.guests.lab import beams
from walkergen.guests.lab.beams import Strip
from walkergen.readers.drawings.lettering import text_outline

STRIP_NUMBERS = (1, 2, 3, 4)
"""Numbers of the strips, which are about as many lines thick."""

WIDTH_MM = 5.0
"""Width of the strips, which is their height on the bed, before it is rounded to whole layers: wide enough for a nut,
narrow enough for a beam (beams.CLAMP_FACTOR)."""

TARGET_RING_HZ = 40.0
"""Frequency at which strips shall ring: 3 frames a swing at 120 a second. Coins and nuts then bend them by mm."""

LENGTH_STEP_MM, MIN_LENGTH_MM, MIN_SLENDERNESS = 5.0, 25.0, 20.0
"""Step of free lengths; shortest one; smallest one over the thickness, where shear adds 0.1 % to the deflection."""

CLAMP_MM = (20.0, 10.0)
"""Length and depth of the block at a strip's end, which a clamp or a vice holds."""

DIGIT_MM, DIGIT_DEPTH_MM = 6.0, 0.4
"""Height and depth of the number engraved on that block."""

BLOCK_MM = (30.0, 12.0, 12.0)
"""Length, width and height of the sliding block, before the height is rounded to whole layers."""

CHAMFER_MM = 0.6
"""Chamfer of the sliding block's edges on the bed. A first layer spreads, and the block would slide on its edges."""

HEAVY_BEND_RATIO, LIGHT_BEND_RATIO = 0.1, 0.05
"""Target depths over length of a strip under the heaviest and a light weight."""


class DrawnStrip(NamedTuple):
    """Strip of the plate as drawn."""

    name: str
    strip: Strip
    heavy_g: float
    light_g: float
    """Weights (g) near the tip that bend it by HEAVY_BEND_RATIO and LIGHT_BEND_RATIO of its length, as computed."""
    ring_hz: float
    """Frequency at which it rings, computed from the design's modulus and density."""


def make_strips(design: Design, printer: Printer) -> list[DrawnStrip]:
    """Return strips to print, each a whole number of lines thick. One of them may have the thickness of the first leg.

    Their lengths follow from the design's material, and the printer's bed.
    """
    layer_height, leg = printer.layer_height_mm, design.limbs[0].thickness
    rounding = walls.line_rounding(printer)
    spacing = printer.line_width_mm - rounding
    width = max(1, round(WIDTH_MM / layer_height)) * layer_height
    longest = printer.bed_width_mm - 2.0 * border_width(printer) - CLAMP_MM[0]
    strips = []
    for lines in STRIP_NUMBERS:
        thickness = round(lines * spacing + rounding, 3)
        if abs(leg - thickness) < 0.5 * spacing:
            thickness = leg
        strip = Strip(thickness, width, _free_length(thickness, design, longest))
        strips.append(_make_strip(f"strip_{lines}", strip, design))
    return strips


def _free_length(thickness: float, design: Design, longest: float) -> float:
    """Compute the free length (mm) of a strip that rings at TARGET_RING_HZ, in whole steps, up to `longest` (mm)."""
    material = design.material
    speed = math.sqrt(material.youngs_modulus / (1e-3 * material.density_g_cm3 * 12.0))
    length = math.sqrt(beams.FIRST_MODE * thickness * speed / (2.0 * math.pi * TARGET_RING_HZ))
    least = max(MIN_LENGTH_MM, MIN_SLENDERNESS * thickness)
    most = max(least, LENGTH_STEP_MM * math.floor(longest / LENGTH_STEP_MM))
    return min(max(LENGTH_STEP_MM * round(length / LENGTH_STEP_MM), least), most)


def _make_strip(name: str, strip: Strip, design: Design) -> DrawnStrip:
    """Return a strip with the weights that bend it and its ringing frequency, from the design's modulus and density."""
    bending = beams.bending_stiffness(design.material.youngs_modulus, strip)
    length = beams.effective_length(strip.length, strip)
    mass = beams.moving_mass(1e-3 * design.material.density_g_cm3, strip)
    heavy, light = (3.0 * bending * bend / (GRAVITY * length**2) for bend in (HEAVY_BEND_RATIO, LIGHT_BEND_RATIO))
    return DrawnStrip(name, strip, heavy, light, beams.natural_frequency(bending, mass, length))


def strip_mesh(drawn: DrawnStrip) -> Mesh:
    """Build the mesh of a strip in one piece with its block, as printed, z up from the bed."""
    long, deep = CLAMP_MM
    block = np.array([(-long, -0.5 * deep), (0.0, -0.5 * deep), (0.0, 0.5 * deep), (-long, 0.5 * deep)])
    half, end = 0.5 * drawn.strip.thickness, drawn.strip.length
    # The strip reaches into the block, so that both become one
    bar = np.array([(-0.5 * long, -half), (end, -half), (end, half), (-0.5 * long, half)])
    number = drawn.name.rpartition("_")[2]
    middle = np.array([-0.5 * long, 0.0])
    digits = [glyph + middle for glyph in text_outline(number, DIGIT_MM, connected=False, source="strip")]
    return extrude([block, bar], drawn.strip.width, windows=0, engraving=Engraving(digits, DIGIT_DEPTH_MM))


def air_percent(drawn: DrawnStrip, printer: Printer) -> float:
    """Compute the percentage of a strip's cross-section that the printer's lines leave open."""
    return max(-100.0 * walls.plastic_deviation(drawn.strip.thickness, printer), 0.0)


def block_size(printer: Printer) -> tuple[float, float, float]:
    """Return length, width and height of the block, mm, the height in whole layers."""
    long, wide, high = BLOCK_MM
    layer = printer.layer_height_mm
    return long, wide, max(1, round(high / layer)) * layer


def block_mesh(printer: Printer) -> Mesh:
    """Build the mesh of the block, as printed, chamfered all round on the bed."""
    (long, wide, high), cut = block_size(printer), CHAMFER_MM
    corners = [
        (x * (0.5 * long - inset), y * (0.5 * wide - inset), z)
        for inset, z in ((cut, 0.0), (0.0, cut), (0.0, high))
        for x in (-1.0, 1.0)
        for y in (-1.0, 1.0)
    ]
    return modeller.to_mesh(manifold3d.Manifold.hull_points(np.array(corners)))


def block_volume(long: float, wide: float, high: float) -> float:
    """Return the volume (mm^3) of the block with these measured sizes (mm), less its chamfer."""
    cut = CHAMFER_MM
    return long * wide * high - cut**2 * (long + wide) + 4.0 / 3.0 * cut**3
