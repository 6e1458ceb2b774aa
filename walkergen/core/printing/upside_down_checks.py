"""Checks of walkers that print upside down, flat on their upper side, with their legs up.

Their layers lie across the legs: a leg is a staircase of sections, weaker and softer than one whose
layers run along it, and nothing carries what juts out of the layer below by too much.
"""

import math
from collections.abc import Iterator

from walkergen.core.printing import walls
from walkergen.core.printing.findings import ROUNDING_MM, About, Finding, Setting, make_finding
from walkergen.core.printing.printers import Printer
from walkergen.core.printing.supports import MAX_OVERHANG_DEG, MIN_OVERHANG_MM2, overhang_area
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.design import Design

MAX_STEP_RATIO = 0.5
"""Largest step of a leg from layer to layer, over its thickness, on which a layer still lies."""

MIN_MODULUS_SD_PERCENT = 20.0
"""Standard deviation of Young's modulus, percent, below which a leg that bends across its layers
is called less certain than that. Assumed, from the spread of printed bars pulled across layers."""


def check_part(design: Design, mesh: Mesh, printer: Printer) -> Iterator[Finding]:
    """Yield the findings on legs and overhangs of one walker whose `mesh` lies upside down on the bed, z = 0."""
    yield from _check_tilt(design)
    yield from _check_layer_steps(design, printer)
    yield from _check_modulus_spread(design)
    yield from _check_overhang(design, mesh)


def _check_tilt(design: Design) -> Iterator[Finding]:
    """Yield a warning for each kind of leg that tilts too far to print without supports."""
    for tilt, name in walls.group_legs(design, lambda limb: round(abs(math.degrees(limb.tilt)), 9)):
        if tilt > MAX_OVERHANG_DEG:
            what = f"{walls.with_article(name)} prints upright, over air"
            yield make_finding(About.LEGS, "warning", what, tilt, MAX_OVERHANG_DEG, "deg", "tilt it less")


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
        change = f"print it with supports from the bed under the body, which a plate's print settings switch on{turn}"
        yield make_finding(About.BODY, "warning", what, area, MIN_OVERHANG_MM2, "mm2", change)
