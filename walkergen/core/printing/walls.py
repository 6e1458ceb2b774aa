"""Walls: how much plastic a slicer lays into a wall of given thickness.

The formulas are PrusaSlicer's flow model (a line is a rectangle with round sides, so that lines
lie width - height (1 - pi/4) apart) and the thicknesses at which it takes one line more, both
confirmed on its G-code: PrusaSlicer 2.5.0, nozzle 0.4 mm, two perimeters, 90 thicknesses from 0.2
to 2.0 mm at lines of 0.40 and 0.45 mm, layers of 0.1, 0.2 and 0.3 mm; tests/core/printing/test_slicer.py repeats
a part of that. Plastic against the mesh in percent, layers 0.2 mm, measured midway along a leg:

    wall, mm    classic, thin walls off    classic, thin walls on    arachne
                0.40 line    0.45 line     0.40 line   0.45 line     0.40 line   0.45 line
    0.20          -100         -100            0           0            +70         +70
    0.30          -100         -100            0           0            +13         +13
    0.36          -100         -100            0           0             -6          -6
    0.40       -100..+79 (*)   -100            0           0            -11         -11
    0.46           +55          +77            0           0             -9          -9
    0.60           +19          +36            0           0             -7          -7
    0.64           +12          +27          +12           0             -7          -7
    0.70            +2          +16           +2         +16             -6          -6
    0.80           -11           +2          -11          +2             -5          -5
    0.90            -5          -10           -5         -10             -5          -5
    1.00            -4           -4           -4          -4             -4          -4
    1.20           +19           -4           -4          -4             -4          -4
    1.40            +2          +16            +2         -3             -3          -3

(*) A wall as thick as the line is on a knife's edge: rounding decides, leg by leg.
Other slicers share the two kinds of generator (Bambu Studio and OrcaSlicer also the code; Cura's
walls are arachne's), not every threshold.
"""

import math
from collections.abc import Callable, Hashable
from typing import NamedTuple, TypeVar

from walkergen.core.printing.findings import About
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.sections import section_of

Key = TypeVar("Key", bound=Hashable)

MIN_BEAD_RATIO = 0.85
"""Width of arachne's narrowest line, in nozzles (PrusaSlicer's default, on the sheet too)."""

MIN_FEATURE_RATIO = 0.25
"""Thickness of the thinnest wall that arachne prints, in nozzles (also PrusaSlicer's default)."""

MIN_THIN_WALL_RATIO = 1.0 / 3.0
"""Thickness of the thinnest wall that thin-wall detection prints, in nozzles."""

MAX_VANISHING_LINES = 1.02
"""Largest thickness in lines at which rounding may remove a wall (classic without thin walls)."""

UPRIGHT_TOLERANCE = 0.15
"""Relative uncertainty of the plastic of a leg which prints upright, a short line in each layer.
Assumed: not measured; that of a leg on its side is its section's `PLASTIC_TOLERANCE`."""

PERIMETER_COUNT = 2
"""Number of lines on either side of a wall before its inside is infill."""


class Wall(NamedTuple):
    """Upright wall of a walker as it prints."""

    name: str
    thickness: float
    """Thickness across the wall, mm."""
    slant: float
    """Cosine of its angle from the vertical: within a layer its thickness is divided by this."""
    height: float
    """Largest printing height, mm."""
    part: About = About.LEGS
    key: str = ""
    """Key that sets its thickness; "" where several do, or none."""

    @property
    def thickness_in_layer(self) -> float:
        """Thickness of the wall within a layer, mm."""
        return self.thickness / self.slant


def upright_walls(design: Design) -> list[Wall]:
    """Return a design's walls that print upright: distinct legs and braces, and a body that prints on its side."""
    on_side = solids.is_printed_on_side(design)
    key = f"legs.{design.kind}_thickness_mm" if design.has_legs_table else ""
    legs = [Wall(name, *sizes, key=key) for sizes, name in group_legs(design, lambda limb: _leg_sizes(limb, on_side))]
    braces = [
        Wall(name.replace("leg", "brace", 1) if name == "leg" else f"brace of {name}", *sizes)
        for sizes, name in group_legs(design, lambda limb: _brace_sizes(limb, on_side))
        if sizes is not None
    ]
    if not on_side:
        return legs + braces
    size = design.size
    return [*legs, *braces, Wall("body", min(size.thickness, size.length), 1.0, size.depth, About.BODY)]


def group_legs(design: Design, key: Callable[[Limb], Key]) -> list[tuple[Key, str]]:
    """Group a design's legs by the function `key`, and return each distinct result with the name of its legs.

    The name is "leg" if all legs share the result, otherwise it lists numbers from 1, as "legs[1], legs[3]".
    """
    sharing: dict[Key, list[str]] = {}
    for number, limb in enumerate(design.limbs, start=1):
        sharing.setdefault(key(limb), []).append(f"legs[{number}]")
    return [(shared, "leg" if len(sharing) == 1 else ", ".join(names)) for shared, names in sharing.items()]


def with_article(name: str) -> str:
    """Return the name of a wall or leg in a sentence: "the leg", but "legs[2]"."""
    return name if name.startswith("legs[") else f"the {name}"


def _leg_sizes(limb: Limb, on_side: bool) -> tuple[float, float, float]:
    """Return thickness (mm), slant (see Wall) and height (mm) of a leg printed as a wall, on its side or upright."""
    if on_side:
        return limb.thickness, 1.0, limb.width
    slant, height = math.cos(limb.tilt), -limb.anchor_to_foot[1]
    if limb.width < limb.thickness / slant:
        return limb.width, 1.0, height
    return limb.thickness, slant, height


def _brace_sizes(limb: Limb, on_side: bool) -> tuple[float, float, float] | None:
    """Return thickness (mm), slant (1) and height (mm) of a leg's brace printed as a wall, or None without a brace."""
    for strut in section_of(limb).struts(limb):
        if on_side:
            return strut.thickness, 1.0, limb.width
        return min(strut.thickness, limb.width), 1.0, -limb.anchor_to_foot[1]
    return None


def printed_thickness(thickness: float, printer: Printer) -> float:
    """Return the thickness, mm, of a solid wall with the plastic that a slicer lays into a wall; 0 if it lays none.

    Within 1 % of the measured G-code up to four lines, except near the thicknesses that add a line;
    thicker walls are filled by infill and assumed to be as drawn, which holds within 3.5 %.
    """
    width, rounding = printer.line_width_mm, line_rounding(printer)
    if thickness > 2.0 * PERIMETER_COUNT * (width + rounding):
        return thickness
    if printer.wall_generator == "arachne":
        if thickness <= vanishing_thickness(printer):
            return 0.0
        return max(MIN_BEAD_RATIO * printer.nozzle_mm, thickness - rounding)
    return _classic_thickness(thickness, printer)


def plastic_deviation(thickness: float, printer: Printer) -> float:
    """Return the excess of plastic in a wall of this thickness (mm), as a share of the drawn: -1 if it gets none."""
    return printed_thickness(thickness, printer) / thickness - 1.0


def leg_plastic_ratio(limb: Limb, printer: Printer, side: bool = True) -> float:
    """Return the expected volume of plastic in a leg and its brace, divided by the volume of their mesh.

    `side` is True for a leg that prints on its side, False for one that prints upright.
    """
    slant = 1.0 if side else math.cos(limb.tilt)
    pieces = [(limb.thickness / slant, limb.length * slant)]
    pieces += [(strut.thickness, limb.length * math.cos(limb.tilt)) for strut in section_of(limb).struts(limb)]
    drawn_area = sum(thickness * length for thickness, length in pieces)
    return sum(printed_thickness(thickness, printer) * length for thickness, length in pieces) / drawn_area


def vanishing_thickness(printer: Printer) -> float:
    """Return the largest thickness of a wall that may get no plastic, mm."""
    if printer.wall_generator == "arachne":
        return MIN_FEATURE_RATIO * printer.nozzle_mm + line_rounding(printer)
    if printer.thin_walls:
        return MIN_THIN_WALL_RATIO * printer.nozzle_mm
    return MAX_VANISHING_LINES * printer.line_width_mm


def line_rounding(printer: Printer) -> float:
    """Return the excess width, mm, of a printed line, whose sides are round, over a rectangle of equal area."""
    return (1.0 - 0.25 * math.pi) * printer.layer_height_mm


def _classic_thickness(thickness: float, printer: Printer) -> float:
    """Return `printed_thickness`, mm, of classic walls: pairs of equal lines from outside, and a filled gap between."""
    if thickness <= vanishing_thickness(printer):
        return 0.0
    width, rounding = printer.line_width_mm, line_rounding(printer)
    spacing = width - rounding
    # With thin walls on, a pair is laid only where its lines overlap by less than 40 %.
    min_pair_spacing = 0.6 * spacing if printer.thin_walls else 0.0
    if thickness <= width + min_pair_spacing:
        return thickness
    pairs = 2 if thickness > width + 2.0 * spacing + min_pair_spacing else 1
    lines = 2.0 * pairs * spacing
    unfilled = rounding + 0.12 * width  # a gap up to this width is left open
    return lines if thickness <= lines + unfilled else thickness - rounding
