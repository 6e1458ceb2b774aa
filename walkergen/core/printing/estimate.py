"""Estimate of what a plate takes: plastic, filament, layers and time, from its parts as sliced."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.printing import slicer, walls
from walkergen.core.printing.findings import ROUNDING_MM
from walkergen.core.printing.packing import Part, Plate
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Mesh

OUTLINE_SPEED_MM_S, LINE_SPEED_MM_S = 20.0, 43.0
"""Time of a layer: its outline at the first speed, all its lines at the second, mm/s. Fitted to
PrusaSlicer 2.5's own times at its default speeds: the shipped walkers, 1 to 20 of them, on four
printers, in layers of 0.1 to 0.3 mm."""

TIME_TOLERANCE = 0.25
"""Relative error of the time at those speeds: 14 % below to 24 % above in that fit."""


class Load(NamedTuple):
    """Plastic of one part."""

    grams: float
    """Mass as sliced, g."""
    density: float
    """Density of its material, g/cm^3."""
    sides: float
    """Area of its sides, which is its layers' outlines times their height, mm^2."""


class Estimate(NamedTuple):
    """Plastic and time of a plate, without skirt, brim and purge."""

    grams: float
    metres: float
    """Length of filament, m."""
    layers: int
    seconds: float
    """Time of the layers, s; see TIME_TOLERANCE."""


def side_area(mesh: Mesh) -> float:
    """Compute the area of a mesh on the bed, seen from all sides: that of its faces' upright parts."""
    first, second, third = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    normals = 0.5 * np.cross(second - first, third - first)
    return float(np.hypot(normals[:, 0], normals[:, 1]).sum())


def plate_totals(plate: Plate, parts: Sequence[Part], loads: Sequence[Load], printer: Printer) -> Estimate:
    """Estimate of a plate; `loads` are those of one copy of each of the parts, in their order."""
    placed = [placement.part for placement in plate.placements]
    copies, height = [loads[part] for part in placed], printer.layer_height_mm
    volume = sum(1e3 * load.grams / load.density for load in copies)
    lines = volume / (height * (printer.line_width_mm - walls.line_rounding(printer)))
    outlines = sum(load.sides for load in copies) / height
    tallest = max(parts[part].height for part in placed)
    return Estimate(
        grams=sum(load.grams for load in copies),
        metres=1e-3 * volume / (0.25 * math.pi * slicer.FILAMENT_DIAMETER_MM**2),
        layers=max(1, math.floor(tallest / height + 0.5 + ROUNDING_MM)),
        seconds=outlines / OUTLINE_SPEED_MM_S + lines / LINE_SPEED_MM_S,
    )


def format_duration(seconds: float) -> str:
    """Format a time with two digits, in the largest unit that gives a value of at least two."""
    unit, length = next((pair for pair in (("h", 3600.0), ("min", 60.0)) if seconds >= 2.0 * pair[1]), ("s", 1.0))
    return f"{float(f'{seconds / length:.2g}'):g} {unit}"
