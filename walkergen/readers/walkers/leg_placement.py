"""Automatic placement of legs under a body of any outline, and remedies for bodies that cannot stand on legs."""

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError, InputError, Remedy, SolidError
from walkergen.core.shapes import joining
from walkergen.core.walker.body import Body
from walkergen.core.walker.limbs import Legs, Limb, resolve_pair
from walkergen.core.walker.sections import section_of
from walkergen.readers.drawings import size_check
from walkergen.readers.walkers import leg_attachment, own_legs
from walkergen.readers.walkers.body_shapes import shape_of
from walkergen.readers.walkers.leg_rows import (
    MIN_EDGE_MM,
    MIN_LEG_WIDTH_MM,
    MIN_SPAN_PER_HEIGHT,
    SPAN_STEPS,
    Reach,
    Row,
    covered_intervals,
    find_rows,
    stability_margin,
)

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MAX_LENGTH_MM = 180.0
"""Length of a body, mm, that fits on the beds of all common printers."""

LENGTH_FACTORS = tuple(1.35**step for step in range(1, 8))
"""Sizes, over a body's own, that are tried in turn. The first one with stable legs is reported."""

LEG_LENGTH_FACTORS = (0.75, 0.5)
"""Lengths of legs, over the requested one, that are tried in turn. The first stable one is reported."""

INCH_MM = size_check.UNITS_MM["inches"]

FAMILY_MAX_TILT_DEG = 20.0
"""Tilt of the steepest legs of a family by default, deg."""


INSET_SHARES = (0.0, 0.04, 0.08, 0.12, 0.16, 0.2)
"""Insets of a mesh's outline, over the mesh's depth, that are tried in turn until all legs meet the mesh."""

DECIMALS = 6
"""Decimals of places and widths, mm: what is symmetric is so to the last bit."""


class UnplacedError(GeometryError):
    """No legs can be placed under the body so that the walker stands."""

    body: Body
    legs: Legs


class LegSpace(NamedTuple):
    """Room for legs under a body, seen from above, (along, across), mm."""

    ground: "BaseGeometry"
    """Area of the body."""
    free: "BaseGeometry"
    """Area that legs of the least width may cover."""
    centre: tuple[float, float]
    """Centre of mass."""
    radius: float
    """Minimum distance of feet from the centre, in every direction."""


class Placement(NamedTuple):
    """Legs that were found for a body."""

    limbs: tuple[Limb, ...]
    """The rear row first."""
    lean_deg: float
    """Largest lean, in any direction, that the walker recovers from, deg."""

    @property
    def words(self) -> str:
        """One line that describes the rows, widths and stability of the legs."""
        feet = sorted({limb.along for limb in self.limbs})
        widths = [sum(limb.width for limb in self.limbs if limb.along == along) for along in feet]
        width = f"{min(widths):.3g}" + (f" to {max(widths):.3g}" if max(widths) - min(widths) > 0.05 else "")
        return (
            f"legs found for the body: {len(feet)} rows, {width} mm wide, feet {feet[-1] - feet[0]:.3g} mm apart; "
            f"tips over beyond {self.lean_deg:.0f} deg"
        )


@lru_cache(maxsize=4096)
def find_placement(body_key: str, legs_key: str) -> Placement:
    """Find positions and widths of legs under a body, both given as JSON. Raises UnplacedError if no legs stand."""
    body, legs = Body.model_validate_json(body_key), Legs.model_validate_json(legs_key)
    if legs.placement is None:
        own_legs.check_without_legs(body_key)
    try:
        return _place_legs(body, legs)
    except GeometryError as error:
        mistake = UnplacedError(
            f"legs.placement: {error.text}", "legs.placement", helps=partial(_find_remedies, body_key, legs_key)
        )
        mistake.body, mistake.legs = body, legs
        raise mistake from None


def _place_legs(body: Body, legs: Legs) -> Placement:
    """Find the positions and widths of legs under a body. Raises GeometryError if no legs stand."""
    import shapely

    size = shape_of(body).size
    leg = resolve_pair(legs, size.depth, -0.5 * size.thickness)[0]
    ground, (along, up, across) = _footprint_and_centre(body.cache_key)
    centre, height, reach = (along, across), up - leg.foot_height, _leg_reach(leg)
    if body.flat:
        return _build_placement(leg, find_rows(ground, centre, height, reach), centre, height)
    for inset in INSET_SHARES:
        inset_ground = shapely.buffer(ground, -inset * size.depth)
        if inset_ground.is_empty:
            break
        placement = _build_placement(leg, find_rows(inset_ground, centre, height, reach), centre, height)
        try:
            return placement._replace(limbs=leg_attachment.extend_legs(body.cache_key, placement.limbs))
        except GeometryError:  # a leg misses the mesh: farther in there is more of it
            continue
    raise GeometryError("its underside is too narrow or too steep for legs")


def available_space(body: Body, legs: Legs) -> LegSpace:
    """Return the space for legs (with their tilt) under a body. Raises GeometryError for a body without a shape."""
    import shapely

    size = shape_of(body).size
    leg = resolve_pair(legs, size.depth, -0.5 * size.thickness)[0]
    ground, (along, up, across) = _footprint_and_centre(body.cache_key)
    reach = _leg_reach(leg)
    left, _, right, _ = ground.bounds
    positions = np.linspace(left - reach.front, right - reach.back, 4 * SPAN_STEPS)
    covered = covered_intervals(ground.buffer(-MIN_EDGE_MM), positions + reach.back, positions + reach.front)
    tops = [
        shapely.box(position + reach.back, low, position + reach.front, high)
        for position, pieces in zip(positions.tolist(), covered, strict=True)
        for low, high in pieces
        if high - low >= MIN_LEG_WIDTH_MM
    ]
    radius = 0.5 * MIN_SPAN_PER_HEIGHT * (up - leg.foot_height)
    return LegSpace(ground, shapely.union_all(tops), (along, across), radius)


@lru_cache(maxsize=64)
def _find_remedies(body_key: str, legs_key: str) -> list[Remedy]:
    """Return up to two remedies with which legs stand under a body. Body and legs are given as JSON."""
    body, legs = Body.model_validate_json(body_key), Legs.model_validate_json(legs_key)
    length = shape_of(body).size.length
    sizes = [float(math.ceil(factor * length)) for factor in LENGTH_FACTORS] if body.scales_with_length else []
    # Kinds of changes in the order of preference: descriptions, and new values of the body's keys
    kinds_of_changes: list[list[tuple[str, dict[str, Any]]]] = [
        [("read it in inches", {"scale_mm": INCH_MM})] if _is_tiny(body) else [],
        [("lay it down", axes) for axes in _other_orientations(body)],
        [("put a plate under it", {"base": True})] if body.is_flat_or_mesh and not body.base else [],
        [(f"make it {size:g} mm long", {"length_mm": size}) for size in sizes if size < MAX_LENGTH_MM],
    ]
    remedies = []
    for changes in kinds_of_changes:
        helpful = ((words, keys) for words, keys in changes if _can_stand(body.with_keys(**keys), legs))
        remedies += [Remedy(words, {f"body.{key}": keys[key] for key in keys}) for words, keys in islice(helpful, 1)]
    lengths = (float(f"{share * legs.length_mm:.3g}") for share in LEG_LENGTH_FACTORS)
    shorter = (mm for mm in lengths if _can_stand(body, legs.model_copy(update={"length_mm": mm})))
    remedies += [Remedy(f"make the legs {mm:g} mm long", {"legs.length_mm": mm}) for mm in islice(shorter, 1)]
    return [_drop_other_size(remedy) for remedy in remedies[:2]] or [Remedy("make the shape wider", {})]


def _drop_other_size(remedy: Remedy) -> Remedy:
    """Return a remedy that also removes scale_mm if it sets length_mm, and the reverse."""
    other = {"body.length_mm": "body.scale_mm", "body.scale_mm": "body.length_mm"}
    return remedy._replace(values={**{other[key]: None for key in remedy.values if key in other}, **remedy.values})


def _other_orientations(body: Body) -> list[dict[str, Any]]:
    """Return the body's keys for other orientations of a mesh: turned about its forward axis, or onto its front."""
    if body.mesh is None or body.legs_below_mm is not None:
        return []
    (across,) = set("xyz") - {body.up[-1], body.forward[-1]}
    return [{"up": across}, {"up": body.forward, "forward": body.up}]


def _is_tiny(body: Body) -> bool:
    """Return whether a mesh states no unit and is so small that it may be in inches."""
    has_no_unit = body.mesh is not None and body.scale_mm is None and body.given_length_mm is None
    return has_no_unit and body.legs_below_mm is None and max(shape_of(body).size) < size_check.MAX_INCH_SIZE_MM


def _can_stand(body: Body, legs: Legs) -> bool:
    """Return whether legs stand under a body, with their tilt and with that of the steepest member of a family."""
    try:
        for tilt in {legs.tilt_deg, max(legs.tilt_deg, FAMILY_MAX_TILT_DEG)}:
            _place_legs(body, legs.model_copy(update={"tilt_deg": tilt}))
    except (InputError, SolidError):
        return False
    return True


@lru_cache(maxsize=16)
def _footprint_and_centre(body_key: str) -> "tuple[BaseGeometry, tuple[float, float, float]]":
    """Return a body's area from above (along, across), and centre of mass (along, up, across), mm from its middle."""
    import shapely

    shape = shape_of(Body.model_validate_json(body_key))
    if shape.plan:
        outer, *holes = (contour * (1.0, -1.0) for contour in shape.plan)  # the page's up is to the left
        ground = shapely.Polygon(outer, holes)
        if shape.mesh is None:
            return ground, (ground.centroid.x, 0.0, ground.centroid.y)
    prepared = leg_attachment.prepare_body(body_key)
    along, up, across = leg_attachment.body_mass(body_key).centre.tolist()
    middle = 0.5 * shape.size.depth
    if not shape.plan:
        ground = shapely.affinity.translate(joining.plan_projection(prepared.solid), 0.0, -middle)
    return ground, (along, up, across - middle)


def _leg_reach(leg: Limb) -> Reach:
    """Return where the top of a leg and its braces begin and end along the direction of running, mm from its foot."""
    anchor = -leg.anchor_to_foot[0]
    ends = [anchor - leg.half_width, anchor + leg.half_width]
    for strut in section_of(leg).struts(leg):
        ends += [anchor + strut.offset - 0.5 * strut.thickness, anchor + strut.offset + 0.5 * strut.thickness]
    return Reach(min(ends), max(ends))


def _build_placement(leg: Limb, rows: Sequence[Row], centre: tuple[float, float], height: float) -> Placement:
    """Return a placement with a copy of `leg` for each leg of `rows`. `centre`, `height`: of the centre of mass, mm."""
    limbs = tuple(
        leg._replace(along=round(row.along, DECIMALS), across=round(across, DECIMALS), width=round(width, DECIMALS))
        for row in rows
        for across, width in row.legs
    )
    return Placement(limbs, math.degrees(math.atan2(stability_margin(rows, centre), height)))
