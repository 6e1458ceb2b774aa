"""Cross-sections of legs, a file each: what follows from a leg's kind."""

from typing import Protocol

from walkergen.core.walker.limbs import Kind, Limb, Polygon, Strut
from walkergen.core.walker.sections import braced, flexible


class CrossSection(Protocol):
    """Cross-section of a kind of legs: a module of `walkergen.core.walker.sections`, as flexible.py.

    A new one is its file, its line in `section_of`, its name and its thickness in `limbs`, its look in `files.figures`.
    """

    PLASTIC_TOLERANCE: float
    """Relative uncertainty of the plastic of a whole leg that prints on its side."""

    def profile(self, limb: Limb, segments: int) -> list[Polygon]:
        """Return the polygons below the underside, counter-clockwise, the leg's first; anchor at the origin."""

    def struts(self, limb: Limb) -> tuple[Strut, ...]:
        """Return the supports next to the leg."""

    def second_moment(self, limb: Limb) -> float:
        """Return the second moment of area about the axis across the run, mm^4."""

    def torsion_constant(self, limb: Limb) -> float:
        """Return the torsion constant about the leg's long axis, mm^4."""

    def axial(self, limb: Limb) -> float:
        """Return the stiffness along the leg, over Young's modulus times the width."""

    def problems(self, limb: Limb) -> list[str]:
        """Return the reasons why the leg cannot be built on any body."""


SECTIONS: dict[Kind, CrossSection] = {"flexible": flexible, "braced": braced}


def section_of(limb: Limb) -> CrossSection:
    """Return the cross-section of a leg."""
    return SECTIONS[limb.kind]
