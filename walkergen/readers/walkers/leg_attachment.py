"""Legs on a body whose underside is not flat: where each leg meets the body.

A leg's length counts from the lowest level of the body, so that feet of equal legs are level; where
the underside lies higher, the leg goes on up to it, and is cut flush with it.
"""

import atexit
import math
from functools import lru_cache

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.shapes import joining
from walkergen.core.walker.body import Body
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import SolidMass, weigh
from walkergen.core.walker.sections import section_of
from walkergen.readers.walkers.body_shapes import shape_of
from walkergen.readers.walkers.footing import find_footing

EMBEDDING_MM = 0.05
"""Depth of a leg inside the body beyond where its section is covered, mm."""


UP = np.array([0.0, 1.0, 0.0])


@lru_cache(maxsize=1024)
def extend_legs(body: str, limbs: tuple[Limb, ...]) -> tuple[Limb, ...]:
    """Return the legs, extended to the underside of a body (JSON). Raises GeometryError for legs that miss the body."""
    prepared = prepare_body(body)
    return tuple(_extend_leg(prepared, limb, number) for number, limb in enumerate(limbs, start=1))


@lru_cache(maxsize=16)
def prepare_body(body: str) -> joining.Body:
    """Convert a body, given as JSON, to a solid that legs can be joined to."""
    return joining.prepare_body(shape_of(Body.model_validate_json(body)).solid())


atexit.register(prepare_body.cache_clear)  # otherwise the modeller reports leaks at the end of the program


@lru_cache(maxsize=16)
def body_mass(body: str) -> SolidMass:
    """Return the mass properties of a body, given as JSON, at 1 g/mm^3."""
    return weigh(prepare_body(body).mesh, 1.0)


def _extend_leg(body: joining.Body, limb: Limb, number: int) -> Limb:
    """Return a leg that goes up to the underside of a body. `number`, from 1, is for messages."""
    depth = float(np.ptp(body.mesh.vertices[:, 2]))
    sin, cos = math.sin(limb.tilt), math.cos(limb.tilt)
    anchor = np.array([*limb.anchor, 0.5 * depth + limb.across])
    direction = np.array([sin, cos, 0.0])
    end = anchor - limb.length * direction
    key = f"legs[{number}].along_mm"
    footing = find_footing(body, end, direction, limb.thickness, limb.width, key)
    length = float(np.linalg.norm(footing.anchor - end))
    depth_inside = max(footing.reach - length, 0.0) * cos + 0.5 * limb.thickness * abs(sin)
    extended = limb._replace(length=length, bottom=float(footing.anchor[1]))
    # Beyond its anchor a leg goes straight up, as its struts do: offset from the anchor and thickness of each, mm
    upright = [(0.0, 2.0 * extended.half_width)] if sin else []
    upright += [(strut.offset, strut.thickness) for strut in section_of(extended).struts(extended)]
    thickness_above = math.inf if sin else footing.above - length
    for offset, thickness in upright:
        foot = np.array([extended.anchor[0] + offset, end[1], anchor[2]])
        straight = find_footing(body, foot, UP, thickness, limb.width, key)
        depth_inside = max(depth_inside, float(foot[1]) + straight.reach - extended.bottom)
        thickness_above = min(thickness_above, float(foot[1]) + straight.above - extended.bottom)
    if depth_inside + EMBEDDING_MM > thickness_above:
        raise GeometryError(
            f"{key}: the leg comes out of the body again, {thickness_above:.3g} mm above where it meets it"
        )
    return extended._replace(embedding=depth_inside + EMBEDDING_MM)
