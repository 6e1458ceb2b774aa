"""Estimate of what a plate takes: plastic, filament, layers and time, from its parts as sliced."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.printing import slicer, walls
from walkergen.printing.findings import NOISE_MM
from walkergen.printing.packing import Part, Plate
from walkergen.printing.printers import Printer

SPEED_MM_S = 22.0
"""Length of line that is laid down in a second, travel included, mm/s: measured as 21.2 to 23.1 in
PrusaSlicer 2.5's own times at its default speeds, for 1 to 20 walkers on shipped printers."""


class Estimate(NamedTuple):
    """Plastic and time of a plate, without skirt, brim and purge."""

    grams: float
    metres: float
    """Length of filament, m."""
    layers: int
    seconds: float
    """Time of the layers at SPEED_MM_S, s."""


def of_plate(
    one: Plate,
    parts: Sequence[Part],
    grams: Sequence[float],
    densities: Sequence[float],
    printer: Printer,
) -> Estimate:
    """Estimate of a plate from mass (g, as sliced) and density (g/cm^3) of each of the parts."""
    placed = [placement.part for placement in one.placements]
    volume = sum(1e3 * grams[part] / densities[part] for part in placed)
    height = printer.layer_height_mm
    tallest = max(parts[part].height for part in placed)
    line = height * (printer.line_width_mm - walls.line_rounding(printer))
    return Estimate(
        grams=sum(grams[part] for part in placed),
        metres=1e-3 * volume / (0.25 * math.pi * slicer.FILAMENT_MM**2),
        layers=max(1, math.floor(tallest / height + 0.5 + NOISE_MM)),
        seconds=volume / line / SPEED_MM_S,
    )


def duration(seconds: float) -> str:
    """Time to two digits, in the largest unit of which there are at least two."""
    unit, length = next(
        (pair for pair in (("h", 3600.0), ("min", 60.0)) if seconds >= 2.0 * pair[1]), ("s", 1.0)
    )
    return f"{float(f'{seconds / length:.2g}'):g} {unit}"
