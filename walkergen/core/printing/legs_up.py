"""Checks of walkers that print upside down, flat on their upper side, with their legs up.

Their layers lie across the legs: a leg is a staircase of sections, weaker and softer than one whose
layers run along it, and nothing carries what juts out of the layer below by too much.
"""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.core.printing import walls
from walkergen.core.printing.findings import NOISE_MM, About, Finding, Setting, new
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Array, Mesh
from walkergen.core.walker import pockets, solids
from walkergen.core.walker.design import Design

STEEPEST_DEG = 45.0
"""Largest angle from the vertical at which walls print without supports, the usual rule."""

WIDEST_STEP = 0.5
"""Largest step of a leg from layer to layer, over its thickness, on which a layer still lies."""

SMALLEST_OVERHANG_MM2 = 1.0
"""Area over air above which there is a warning. Assumed: threads bridge that much."""

LEAST_SPREAD_PERCENT = 20.0
"""Standard deviation of Young's modulus, percent, below which a leg that bends across its layers
is called less certain than that. Assumed, from the spread of printed bars pulled across layers."""


def of_part(design: Design, mesh: Mesh, printer: Printer) -> Iterator[Finding]:
    """Yield the findings on one walker whose `mesh` lies upside down on the bed, z = 0."""
    yield from _steep(design)
    yield from _stairs(design, printer)
    yield from _soft(design)
    yield from _overhang(design, mesh)


def overhang(design: Design, mesh: Mesh) -> float:
    """Area of the body's faces over air that look down by more than STEEPEST_DEG allows, mm^2.

    The mesh lies upside down on z = 0. Legs, above the body, are not counted, nor are engraved
    letters, whose strokes are bridged; pockets have a check of their own (pocket_checks).
    """
    if design.parts:
        bare = pockets.without(design)
        return overhang(bare, solids.as_printed(bare, solids.build(bare).walker))
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    down: Array = -0.5 * normals[:, 2]
    # A picometre aside, so that faces of exactly that angle are as rounding has them
    steep = down > (math.sin(math.radians(STEEPEST_DEG)) + 1e-9) * areas
    heights = corners[:, :, 2]
    pocket = design.marks.depth_mm if design.letters else 0.0
    in_air = heights.max(axis=1) > mesh.vertices[:, 2].min() + pocket + NOISE_MM
    of_body = heights.min(axis=1) < design.size.thickness - NOISE_MM
    return float(areas[steep & in_air & of_body].sum())


def _steep(design: Design) -> Iterator[Finding]:
    for tilt, name in walls.alike(design, lambda limb: round(abs(math.degrees(limb.tilt)), 9)):
        if tilt > STEEPEST_DEG:
            what, change = f"{walls.the(name)} prints upright, over air", "tilt it less, or print it with supports"
            yield new(About.LEGS, "warning", what, tilt, STEEPEST_DEG, "deg", change)


def _stairs(design: Design, printer: Printer) -> Iterator[Finding]:
    for (slope, thickness), name in walls.alike(design, lambda limb: (math.tan(abs(limb.tilt)), limb.thickness)):
        step, limit = printer.layer_height_mm * slope, WIDEST_STEP * thickness
        if step > limit + NOISE_MM:
            lower = math.floor(100.0 * limit / slope) / 100.0
            advice = f"lower layer_height_mm to {lower:g}, or " if lower > 0.0 else ""
            thinner = Setting("printer.layer_height_mm", lower) if lower > 0.0 else None
            what = f"{walls.the(name)} prints as a staircase: a layer's step against half the thickness"
            yield new(About.LEGS, "warning", what, step, limit, "mm", f"{advice}make the leg thicker", thinner)


def _soft(design: Design) -> Iterator[Finding]:
    material = design.material
    spread = 100.0 * material.youngs_modulus_sd_gpa / material.youngs_modulus_gpa
    if not design.rigid and spread < LEAST_SPREAD_PERCENT:
        enough = math.ceil(LEAST_SPREAD_PERCENT * material.youngs_modulus_gpa) / 100.0
        what = "legs printed upright bend across their layers, which is weaker and softer: the deviation of E"
        change = f"raise material.youngs_modulus_sd_gpa to {enough:g}, or measure it (calibrate plate)"
        wider = Setting("material.youngs_modulus_sd_gpa", enough)
        yield new(About.LEGS, "advice", what, spread, LEAST_SPREAD_PERCENT, "%", change, wider)


def _overhang(design: Design, mesh: Mesh) -> Iterator[Finding]:
    area = overhang(design, mesh)
    if area > SMALLEST_OVERHANG_MM2:
        turn = ", or turn the mesh by body.up" if design.body.mesh is not None else ""
        what = f"the body hangs over air by more than {STEEPEST_DEG:g} deg as it lies, upside down"
        change = f"print it with supports on the bed{turn}"
        yield new(About.BODY, "warning", what, area, SMALLEST_OVERHANG_MM2, "mm2", change)
