"""Legs that are part of a mesh: its underside ends in separate feet on which the mesh stands.

A cut slightly above the lowest point leaves a piece for each foot. The legs end where, farther up, the number of
pieces first changes: there the body begins.
"""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple, get_args

import manifold3d
import numpy as np
from pydantic import ValidationError

from walkergen.core.errors import GeometryError, InputError, Remedy, SolidError
from walkergen.core.shapes import modeller
from walkergen.core.walker.body import Axis, Body
from walkergen.core.walker.limbs import Kind
from walkergen.core.walker.mass import weigh
from walkergen.readers.walkers import leg_attachment, leg_cutting
from walkergen.readers.walkers.body_mesh import rotation

FOOT_SHARE = 0.02
"""Height of the cut that shows the feet, over the mesh's height. Lower ends of legs differ less."""

SCAN_STEPS = 40
"""Heights that are searched for the end of the legs, before bisection."""

BISECTIONS = 20

MIN_SLENDERNESS = 1.0
"""Length of a leg, over the smaller side of its section, below which it is a bump."""

MIN_FLEXIBLE_RATIO = 12.0
"""Length of a leg over its thickness, below which it counts as rigid. The paper's flexible legs have 19."""

MIN_LEAN = 0.02
"""Mean lean of legs, over their length, below which they count as upright."""


class OwnLegs(NamedTuple):
    """Legs that were found in a mesh."""

    number: int
    kind: Kind
    keys: dict[str, Any]
    """Values of the body's keys by which walkergen uses these legs."""

    @property
    def remedy(self) -> Remedy:
        """Remedy that uses these legs."""
        values = {**{f"body.{key}": value for key, value in self.keys.items()}, "legs.kind": self.kind}
        return Remedy(f"use its {self.number} legs", values)


def use_own_legs(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a walker's data with the keys for the legs that its mesh has, unless the data describe other legs.

    Nothing is changed if the mesh stands on legs in several orientations, but not in that of the file.
    """
    legs = data.get("legs", {})
    if not isinstance(legs, Mapping) or not set(legs) <= {"kind"}:
        return data
    try:
        body = Body.model_validate(data["body"])
        found = find_own_legs(body.cache_key)
    except (ValidationError, InputError, SolidError):  # the design reports it when it is validated
        return data
    if not found or (len(found) > 1 and "up" in found[0].keys):
        return data
    return {**data, "body": {**data["body"], **found[0].keys}, "legs": {"kind": found[0].kind, **legs}}


def check_without_legs(body_key: str) -> None:
    """Raise GeometryError, with remedies, for a body (JSON) that is a mesh with legs."""
    if found := find_own_legs(body_key):
        several = Remedy("add legs all the same", {"legs.placement": "auto"})
        raise GeometryError(
            f"legs.placement: the mesh already stands on {found[0].number} legs",
            "legs.placement",
            helps=lambda: [*(own.remedy for own in found[:2]), several],
        )


@lru_cache(maxsize=64)
def find_own_legs(body_key: str) -> tuple[OwnLegs, ...]:
    """Return the legs of a body (JSON) that is a mesh, for each orientation in which it stands on legs.

    The orientation of the file comes first. A body with `up` or `forward` has no other.
    """
    body = Body.model_validate_json(body_key)
    if body.mesh is None or body.legs_below_mm is not None:
        return ()
    solid, given = leg_attachment.prepare_body(body_key).solid, rotation(body.up, body.forward, "body")
    found = []
    for up in (body.up, *(axis for axis in get_args(Axis) if axis != body.up and "up" not in body.model_fields_set)):
        forwards: list[Axis] = [axis for axis in get_args(Axis)[::2] if axis != up[-1]]
        if "forward" in body.model_fields_set:
            forwards = [body.forward] if body.forward[-1] != up[-1] else []
        turns = [rotation(up, forward, "body") @ given.T for forward in forwards]
        if turns and (walker := _cut_walker(_rotate(solid, turns[0]))):
            cut, below = walker
            if side := _forward_side(cut) if len(turns) > 1 else 0:
                cut = leg_cutting.cut_legs(modeller.to_mesh(_rotate(solid, turns[side])), below)
            keys = {"up": up, "forward": forwards[side], "legs_below_mm": below}
            is_rigid = any(leg.struts > 1 or leg.length < MIN_FLEXIBLE_RATIO * leg.thickness for leg in cut.legs)
            kind: Kind = "braced" if is_rigid else "flexible"
            changed = {key: value for key, value in keys.items() if value != getattr(body, key)}
            found.append(OwnLegs(len(cut.legs), kind, changed))
    return tuple(found)


def _rotate(solid: manifold3d.Manifold, turn: Any) -> manifold3d.Manifold:
    """Rotate a solid by a matrix of shape (3, 3)."""
    return solid.transform(np.column_stack([turn, np.zeros(3)]))


def _cut_walker(solid: manifold3d.Manifold) -> "tuple[leg_cutting.CutWalker, float] | None":
    """Return a solid (y up) cut into body and legs, and the height of the cut, mm, or None if it stands on no legs."""
    low, high = solid.bounding_box()[1], solid.bounding_box()[4]
    below = _leg_height(lambda share: _count_pieces(solid, low + share * (high - low))) * (high - low)
    below = math.floor(1000.0 * below) / 1000.0  # whole micrometres, a little below the body
    if below <= 0.0:
        return None
    try:
        cut = leg_cutting.cut_legs(modeller.to_mesh(solid), below)
    except GeometryError:  # what is above falls apart: no body
        return None
    import shapely

    feet_end = low + FOOT_SHARE * (high - low)
    feet = np.concatenate([leg.mesh.vertices[leg.mesh.vertices[:, 1] <= feet_end] for leg in cut.legs])
    hull = shapely.MultiPoint(feet[:, [0, 2]]).convex_hull
    stands = hull.contains(shapely.Point(weigh(cut.mesh, 1.0).centre[[0, 2]]))
    is_slender = all(leg.length >= MIN_SLENDERNESS * min(leg.thickness, leg.width) for leg in cut.legs)
    return (cut, below) if stands and is_slender else None


def _count_pieces(solid: manifold3d.Manifold, height: float) -> int:
    """Return the number of pieces of a solid below a height."""
    return len(modeller.split_bodies(modeller.check_solid(solid.trim_by_plane((0.0, -1.0, 0.0), -height))))


def _leg_height(count: Callable[[float], int]) -> float:
    """Return the share of the height at which legs end, 0 without legs. `count` returns the pieces below a share."""
    feet = count(FOOT_SHARE)
    if feet < 2:
        return 0.0
    shares: list[float] = np.linspace(FOOT_SHARE, 1.0, SCAN_STEPS + 1).tolist()
    changed = next((step for step, share in enumerate(shares) if count(share) != feet), 0)
    good, bad = shares[max(changed - 1, 0)], shares[changed]
    for _ in range(BISECTIONS):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if count(middle) == feet else (good, middle)
    return good


def _forward_side(cut: leg_cutting.CutWalker) -> int:
    """Return the horizontal axis along which a walker runs, 0 for x or 1 for z: that of its lean, or the longer one."""
    anchors, feet = (np.array([getattr(leg, name) for leg in cut.legs])[:, [0, 2]] for name in ("anchor", "foot"))
    lean = np.abs(anchors - feet).mean(axis=0)
    if lean.max() > MIN_LEAN * np.mean([leg.length for leg in cut.legs]):
        return int(np.argmax(lean))
    return int(np.argmax(np.ptp(feet, axis=0)))
