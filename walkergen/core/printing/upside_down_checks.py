"""Checks of walkers that print upside down, flat on their upper side, with their legs up.

Their layers lie across the legs: a leg is a staircase of sections, weaker and softer than one whose
layers run along it, and nothing carries what juts out of the layer below by too much.
"""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.printing import walls
from walkergen.core.printing.findings import ROUNDING_MM, About, Finding, Setting, make_finding
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import pockets, solids
from walkergen.core.walker.design import Design

MAX_OVERHANG_DEG = 45.0
"""Largest angle from the vertical at which walls print without supports, the usual rule."""

MAX_STEP_RATIO = 0.5
"""Largest step of a leg from layer to layer, over its thickness, on which a layer still lies."""

MIN_OVERHANG_MM2 = 1.0
"""Area over air above which there is a warning. Assumed: threads bridge that much."""

MIN_MODULUS_SD_PERCENT = 20.0
"""Standard deviation of Young's modulus, percent, below which a leg that bends across its layers
is called less certain than that. Assumed, from the spread of printed bars pulled across layers."""


def check_part(design: Design, mesh: Mesh, printer: Printer) -> Iterator[Finding]:
    """Yield the findings on one walker whose `mesh` lies upside down on the bed, z = 0."""
    yield from _check_tilt(design)
    yield from _check_layer_steps(design, printer)
    yield from _check_modulus_spread(design)
    yield from _check_overhang(design, mesh)


def overhang_area(design: Design, mesh: Mesh) -> float:
    """Return the area of the body's faces over air that look down by more than MAX_OVERHANG_DEG, mm^2.

    The mesh lies upside down on z = 0. Legs, above the body, are not counted, nor are engraved
    letters, whose strokes are bridged. Pockets have a check of their own (pocket_checks).
    """
    if design.parts:
        plain_design = pockets.without_pockets(design)
        return overhang_area(plain_design, solids.orient_for_print(plain_design, solids.build(plain_design).walker))
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    downward_areas: Array = -0.5 * normals[:, 2]
    # 1e-9 more, so that rounding does not count faces of exactly that angle
    is_steep = downward_areas > (math.sin(math.radians(MAX_OVERHANG_DEG)) + 1e-9) * areas
    heights = corners[:, :, 2]
    engraving_depth = design.marks.depth_mm if design.letters else 0.0
    is_in_air = heights.max(axis=1) > mesh.vertices[:, 2].min() + engraving_depth + ROUNDING_MM
    is_body = heights.min(axis=1) < design.size.thickness - ROUNDING_MM
    return float(areas[is_steep & is_in_air & is_body].sum())


def _check_tilt(design: Design) -> Iterator[Finding]:
    """Yield a warning for each kind of leg that tilts too far to print without supports."""
    for tilt, name in walls.group_legs(design, lambda limb: round(abs(math.degrees(limb.tilt)), 9)):
        if tilt > MAX_OVERHANG_DEG:
            what, change = (
                f"{walls.with_article(name)} prints upright, over air",
                "tilt it less, or print it with supports",
            )
            yield make_finding(About.LEGS, "warning", what, tilt, MAX_OVERHANG_DEG, "deg", change)


def _check_layer_steps(design: Design, printer: Printer) -> Iterator[Finding]:
    """Yield a warning for each kind of leg whose layers step aside by too much of its thickness."""
    for (slope, thickness), name in walls.group_legs(design, lambda limb: (math.tan(abs(limb.tilt)), limb.thickness)):
        step, limit = printer.layer_height_mm * slope, MAX_STEP_RATIO * thickness
        if step > limit + ROUNDING_MM:
            lower = math.floor(100.0 * limit / slope) / 100.0
            advice = f"lower layer_height_mm to {lower:g}, or " if lower > 0.0 else ""
            thinner = Setting("printer.layer_height_mm", lower) if lower > 0.0 else None
            what = f"{walls.with_article(name)} prints as a staircase: a layer's step against half the thickness"
            yield make_finding(About.LEGS, "warning", what, step, limit, "mm", f"{advice}make the leg thicker", thinner)


def _check_modulus_spread(design: Design) -> Iterator[Finding]:
    """Yield advice to assume more uncertainty of Young's modulus, since legs bend across their layers."""
    material = design.material
    spread = 100.0 * material.youngs_modulus_sd_gpa / material.youngs_modulus_gpa
    if not design.rigid and spread < MIN_MODULUS_SD_PERCENT:
        enough = math.ceil(MIN_MODULUS_SD_PERCENT * material.youngs_modulus_gpa) / 100.0
        what = "legs printed upright bend across their layers, which is weaker and softer: the deviation of E"
        change = f"raise material.youngs_modulus_sd_gpa to {enough:g}, or measure it (calibrate plate)"
        wider = Setting("material.youngs_modulus_sd_gpa", enough)
        yield make_finding(About.LEGS, "advice", what, spread, MIN_MODULUS_SD_PERCENT, "%", change, wider)


def _check_overhang(design: Design, mesh: Mesh) -> Iterator[Finding]:
    """Yield a warning if too large an area of the body prints over air."""
    area = overhang_area(design, mesh)
    if area > MIN_OVERHANG_MM2:
        turn = ", or turn the mesh by body.up" if design.body.mesh is not None else ""
        what = f"the body hangs over air by more than {MAX_OVERHANG_DEG:g} deg as it lies, upside down"
        change = f"print it with supports on the bed{turn}"
        yield make_finding(About.BODY, "warning", what, area, MIN_OVERHANG_MM2, "mm2", change)
