"""Cross-sections of legs, a module for each kind of leg, and the gaps between legs and braces."""

import itertools
import math
from collections.abc import Sequence
from typing import Protocol

from walkergen.core.walker.limbs import Kind, Limb, Polygon, Strut
from walkergen.core.walker.sections import braced, flexible


class CrossSection(Protocol):
    """Shape and stiffness of a kind of legs: the functions of a module in `walkergen.core.walker.sections`.

    To add a kind, write its module and add it to SECTIONS, its name and thickness to `limbs`, its look to
    `files.figures`.
    """

    PLASTIC_TOLERANCE: float
    """Relative uncertainty of the plastic of a whole leg that prints on its side."""

    def profile(self, limb: Limb, segments: int) -> list[Polygon]:
        """Return polygons in side view below the underside, counter-clockwise, each of shape (n, 2), mm.

        The first is the leg's, with its anchor at the origin. `segments` is the number of edges of a round foot.
        """

    def struts(self, limb: Limb) -> tuple[Strut, ...]:
        """Return the leg's braces, upright bars from its foot to the body; () without any."""

    def second_moment(self, limb: Limb) -> float:
        """Return the second moment of area about the axis across the run, mm^4."""

    def torsion_constant(self, limb: Limb) -> float:
        """Return the torsion constant about the leg's long axis, mm^4."""

    def axial(self, limb: Limb) -> float:
        """Return the stiffness along the leg over Young's modulus times the width, dimensionless."""

    def problems(self, limb: Limb) -> list[str]:
        """Return messages on faults for which the leg cannot be built on any body, [] without faults."""


SECTIONS: dict[Kind, CrossSection] = {"flexible": flexible, "braced": braced}


def section_of(limb: Limb) -> CrossSection:
    """Return the module with the shape and stiffness of legs of this leg's kind."""
    return SECTIONS[limb.kind]


def window_width(limb: Limb) -> float:
    """Return the width of the gap between a leg and its strut along the body's bottom face, mm.

    The gap is widest there. It is negative where leg and strut overlap, and 0 for legs without struts.
    """
    struts = section_of(limb).struts(limb)
    return min((abs(strut.offset) - (limb.half_width + 0.5 * strut.thickness) for strut in struts), default=0.0)


def leg_clearance(limbs: Sequence[Limb]) -> float:
    """Return the smallest gap along the run, mm, between legs or braces that overlap across it; infinity if none do."""
    gaps = [math.inf]
    for first, second in itertools.combinations(limbs, 2):
        back, front = sorted((first, second), key=lambda limb: limb.along)
        if abs(first.across - second.across) >= 0.5 * (first.width + second.width):
            continue
        spacing = front.along - back.along
        if back.tilt == front.tilt:
            gaps.append(spacing - (back.half_width + front.half_width))
        else:
            gaps.append(min(spacing, front.anchor[0] - back.anchor[0]) - (back.half_width + front.half_width))
        for limb in (back, front):
            for strut in section_of(limb).struts(limb):
                brace_reach = abs(strut.offset) + limb.half_width + 0.5 * strut.thickness
                gaps.append(spacing - brace_reach)
    return min(gaps)
