"""Walkers seen from the side: legs that look alike there are one leg of the plane.

The theory knows the run and the height only. A leg of width W, or a pair of legs
side by side, is one planar leg: masses and widths add up, and with the widths the stiffnesses.
Limit: in space such a pair lands one after the other where the walker rolls.
"""

from typing import NamedTuple

from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import LegMass, MassProperties


class Planar(NamedTuple):
    """Walker in the plane; its legs from back to front."""

    mass: MassProperties
    limbs: tuple[Limb, ...]
    """Legs of the plane, as wide as the legs that they represent together."""


def project_to_plane(design: Design, mass: MassProperties) -> Planar:
    """Project a walker to its side view; two equal legs stay unchanged."""
    if design.pair:
        return Planar(mass, design.limbs)
    groups: dict[tuple[object, ...], list[tuple[Limb, LegMass]]] = {}
    for limb, leg in zip(design.limbs, mass.legs, strict=True):
        key = limb._replace(width=0.0, across=0.0, thickness_sd=0.0)
        groups.setdefault(key, []).append((limb, leg))
    merged = sorted((_merge_legs(group) for group in groups.values()), key=lambda pair: pair[0].along)
    return Planar(mass._replace(legs=tuple(leg for _, leg in merged)), tuple(limb for limb, _ in merged))


def _merge_legs(group: list[tuple[Limb, LegMass]]) -> tuple[Limb, LegMass]:
    (limb, leg), legs = group[0], [leg for _, leg in group]
    return (
        limb._replace(width=sum(limb.width for limb, _ in group)),
        leg._replace(m=sum(leg.m for leg in legs), j=sum(leg.j for leg in legs)),
    )
