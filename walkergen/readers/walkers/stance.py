"""Stance: walkers turned until they stand on their feet.

A walker stands level unless its design says `stance = "as built"`: then its legs may end at
different heights of the body's own frame, and the whole is turned in its plane until two feet are
level. The rest of the program gets the walker as it stands: a body that leans, on legs that
tilt against the plate's normal.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.files.config import Section
from walkergen.core.numerics import Array
from walkergen.core.walker.body import Body
from walkergen.core.walker.limbs import Leg, Limb, resolve_leg
from walkergen.readers.walkers.body_shapes import shape_of

MAX_LEAN_RAD = math.radians(60.0)
"""Largest lean of a body, rad."""


class _Parts(Section):
    """Tables that are read together, so that errors name the whole key: legs[2].friction."""

    body: Body
    legs: list[Leg]


def level_feet(data: Mapping[str, Any], default_tilt_deg: float) -> dict[str, Any]:
    """Turn a design with stance "as built" until two of its feet are level, and return its new data.

    `default_tilt_deg` is for legs without a tilt. The body becomes a profile and its legs keep their shapes. Braces are
    upright after the turn. Raises GeometryError if no turn levels the feet, and pydantic's errors for wrong keys.
    """
    for name in ("motor", "battery"):
        if data.get(name) is not None:
            raise GeometryError(
                f"{name}: a walker with stance = 'as built' cannot carry one. Remove it, or remove stance and "
                "give all feet one height."
            )
    parts = _Parts.model_validate({"body": data.get("body", {}), "legs": _leg_list(data)})
    legs, shape = parts.legs, shape_of(parts.body)
    if shape.side is None:
        raise GeometryError(
            "stance = 'as built': is for bodies in side view (a rectangle or profile_mm). Remove it and level the feet."
        )
    if any(leg.foot == "flat" for leg in legs):
        raise GeometryError(
            "stance = 'as built': a flat foot is cut for a level stance. Use foot = 'square' or 'round'"
        )
    limbs = [resolve_leg(leg, default_tilt_deg, shape.size.depth, -0.5 * shape.size.thickness) for leg in legs]
    back = min(limbs, key=lambda limb: limb.along)
    front = max(limbs, key=lambda limb: limb.along)
    lean = _find_lean(back, front)
    side = _rotate(np.asarray(shape.side), lean)
    low, high = side.min(axis=0), side.max(axis=0)
    side, middle = side - 0.5 * (low + high), 0.5 * (low + high)
    table = dict(data.get("body", {}))
    for key in ("length_mm", "thickness_mm", "profile_mm"):
        table.pop(key, None)
    table["profile_mm"] = side.tolist()
    standing_legs = [
        _standing_leg(leg, limb, lean, middle, -0.5 * float(high[1] - low[1]))
        for leg, limb in zip(_leg_list(data), limbs, strict=True)
    ]
    return {**data, "stance": "level", "body": table, "legs": standing_legs}


def _leg_list(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the list of legs in a design's data. Raises GeometryError for fewer than two."""
    legs = data.get("legs")
    if not isinstance(legs, list) or len(legs) < 2:
        raise GeometryError("stance = 'as built': needs a list [[legs]] of two legs or more")
    return legs


def _find_lean(back: Limb, front: Limb) -> float:
    """Return the angle (rad, counter-clockwise) that a body turns until two feet are level."""
    from scipy.optimize import brentq

    def height_difference(lean: float) -> float:
        """Return the height of the front foot above the back one, mm, on a body that leans."""
        return float(_foot_position(front, lean)[1] - _foot_position(back, lean)[1])

    if height_difference(-MAX_LEAN_RAD) * height_difference(MAX_LEAN_RAD) > 0.0:
        raise GeometryError(
            "stance = 'as built': the body would lean by more than "
            f"{math.degrees(MAX_LEAN_RAD):g} deg: make the legs more alike, or put them farther apart"
        )
    return float(brentq(height_difference, -MAX_LEAN_RAD, MAX_LEAN_RAD, xtol=1e-14))


def _rotate(points: Array, lean: float) -> Array:
    """Rotate points, shape (n, 2) or (2,), counter-clockwise by an angle, rad."""
    sin, cos = math.sin(lean), math.cos(lean)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]))


def _foot_position(limb: Limb, lean: float) -> Array:
    """Return the point at which a leg touches the plate if the walker leans by `lean` rad, shape (2,), mm."""
    turned = limb._replace(tilt=limb.tilt - lean)
    return _rotate(np.array(limb.anchor), lean) + turned.anchor_to_foot


def _standing_leg(leg: Mapping[str, Any], limb: Limb, lean: float, middle: Array, bottom: float) -> dict[str, Any]:
    """Return a leg's data after the turn by `lean`. `middle`, `bottom`: middle and underside of the turned body, mm."""
    tilt = limb.tilt - lean
    anchor, foot = _rotate(np.array(limb.anchor), lean) - middle, _foot_position(limb, lean) - middle
    end = anchor[1] - limb.length * math.cos(tilt)
    keys = {key: value for key, value in leg.items() if key != "mirrored"}
    return keys | {
        "tilt_deg": math.degrees(tilt),
        "along_mm": float(foot[0]),
        "length_mm": (bottom - end) / math.cos(tilt),
    }
