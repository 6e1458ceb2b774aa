"""Shape of the body and positions of the legs that a walker's keys define, and the faults of both.

Drawings and meshes are read, and legs are placed, by `walkergen.readers`. The readers are above the core and import
it. They are loaded when a design first needs one of them; a plain rectangle needs none.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from walkergen.core.errors import GeometryError, Remedy
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.body import Body, Shape, Size, rectangle_shape
from walkergen.core.walker.fittings import Cap, Marks, find_fit_problems
from walkergen.core.walker.limbs import Legs, Limb, Polygon, resolve_leg, resolve_pair
from walkergen.core.walker.mass import SolidMass
from walkergen.core.walker.sections import section_of
from walkergen.core.walker.spec import WalkerSpec

if TYPE_CHECKING:
    from walkergen.core.shapes import joining

MAX_HEIGHT_DIFFERENCE_MM = 0.005
"""Largest difference of the feet's heights of a walker that stands level, mm: as much as prints
differ anyway (feet.unevenness_sd_um)."""

ROUNDING_MM = 1e-9
"""Largest error, mm, of sums of lengths that people write."""


class Readers(Protocol):
    """Functions of `walkergen.readers`, whose docstrings are there.

    A str for a body or legs is their JSON, the key for caching results. `Any` is a `Design` or a `Placement`.
    """

    shape_of: Callable[[Body], Shape]
    prepare_body: "Callable[[str], joining.Body]"
    body_mass: Callable[[str], SolidMass]
    extend_legs: Callable[[str, tuple[Limb, ...]], tuple[Limb, ...]]
    find_placement: Callable[[str, str], Any]
    use_own_legs: Callable[[Mapping[str, Any]], Mapping[str, Any]]
    level_feet: Callable[[Mapping[str, Any], float], dict[str, Any]]
    format_mark: Callable[[Marks, Sequence[float], float], str]
    mark_problems: Callable[[Marks, Sequence[float], float, tuple[float, float, float]], list[str]]
    add_notches: Callable[[Any, Polygon], Polygon]
    engraved_profiles: Callable[[Any], list[Polygon]]
    cut_letters: Callable[[Mesh, Any], Mesh]
    place_on_body: Callable[[Cap, Mesh, float], Mesh]


def load_readers() -> Readers:
    """Import and return `walkergen.readers`, the functions that read files and place legs."""
    return cast(Readers, import_module("walkergen.readers"))


def shape_of(body: Body) -> Shape:
    """Return the shape of a body. Raises GeometryError if it has none, and InputError if a file cannot be read."""
    if body.plain:
        return rectangle_shape(body.length_mm, body.thickness_mm, body.depth_mm)
    return load_readers().shape_of(body)


def place_legs(spec: WalkerSpec) -> tuple[Limb, ...]:
    """Return a walker's legs, resolved to numbers, in the order of the file. Two equal legs are listed back, front.

    Raises GeometryError for a leg that does not meet the body.
    """
    shape, legs = shape_of(spec.body), spec.legs
    if shape.finished is not None:
        assert isinstance(legs, Legs)
        return shape.finished.limbs(legs.kind, shape.size.depth)
    if spec.has_automatic_legs:
        assert isinstance(legs, Legs)
        placed: tuple[Limb, ...] = load_readers().find_placement(spec.body.cache_key, legs.model_dump_json()).limbs
        return placed
    depth, bottom = shape.size.depth, -0.5 * shape.size.thickness
    if isinstance(legs, Legs):
        limbs = resolve_pair(legs, depth, bottom)
    else:
        limbs = tuple(resolve_leg(leg, spec.family_tilt_of_list_deg, depth, bottom) for leg in legs)
    if spec.body.plain or spec.body.flat:
        return limbs
    return load_readers().extend_legs(spec.body.cache_key, limbs)


def describe_placement(spec: WalkerSpec) -> str:
    """Describe the positions of automatic legs, or the legs of a mesh. Raises UnplacedError if no positions fit."""
    assert isinstance(spec.legs, Legs)
    if spec.is_complete_mesh:
        legs, up, forward = f"{len(place_legs(spec))} {spec.legs.kind} legs", spec.body.up, spec.body.forward
        cut = f"legs_below_mm = {spec.body.legs_below_mm:g} (up = {up}, forward = {forward})"
        return f"the mesh has {legs}, below {cut}. legs.placement = auto adds legs instead"
    words: str = load_readers().find_placement(spec.body.cache_key, spec.legs.model_dump_json()).words
    return words


def member_tilt_deg(spec: WalkerSpec) -> float:
    """Return the tilt, deg, by which a walker is named in a family; for a finished walker that of its first leg."""
    if spec.is_complete_mesh:
        return round(math.degrees(place_legs(spec)[0].tilt), 2) + 0.0
    return spec.tilt_from_keys_deg


def check_buildable(spec: WalkerSpec) -> None:
    """Raise GeometryError for parts that cannot be built, a line for each fault."""
    shape, legs = shape_of(spec.body), spec.legs
    if isinstance(legs, Legs) and not spec.has_automatic_legs:
        faults = [] if spec.is_complete_mesh else _pair_faults(legs, shape.size)
    else:
        faults = _list_faults(place_legs(spec), shape.size)
    if not faults and spec.body.flat:
        faults = _outline_faults(place_legs(spec), shape)
    find_remedies = partial(_suggest_placement, spec) if faults else tuple
    if not spec.marks.blank:
        faults += _mark_faults(spec, shape.size)
    if not faults and spec.parts:
        foot_height = min(limb.foot_height for limb in place_legs(spec))
        faults = find_fit_problems(spec.parts, spec.pocket_settings, shape.size, foot_height)
    if spec.pockets is not None and not spec.parts:
        faults.append("pockets: there is no motor or battery. Add a table [motor] or [battery], or remove [pockets].")
    if faults:
        raise GeometryError("\n".join(faults), helps=find_remedies)


def _suggest_placement(spec: WalkerSpec) -> Sequence[Remedy]:
    """Return the remedy to place two equal legs automatically if they then fit, otherwise []."""
    if not isinstance(spec.legs, Legs) or spec.has_automatic_legs or spec.is_complete_mesh:
        return []
    legs = spec.legs.model_copy(update={"placement": "auto"})
    try:
        check_buildable(spec.model_copy(update={"legs": legs}))
    except GeometryError:
        return []
    return [Remedy("place the legs automatically", {"legs.placement": "auto"})]


def _mark_faults(spec: WalkerSpec, size: Size) -> list[str]:
    """Return messages on the faults of a walker's marks, which it must have, and their fit on its body.

    Letters on a body in plan view are checked on its upper side.
    """
    marks, (length, thickness, depth) = spec.marks, size
    if spec.letters and spec.body.flat:  # letters on a body in plan view go into its upper side
        marks, thickness, depth = marks.model_copy(update={"kind": "text"}), depth, thickness
    faults = load_readers().mark_problems(
        marks, spec.family.tilt_deg, member_tilt_deg(spec), (length, thickness, depth)
    )
    if spec.body.plain or (spec.letters and spec.body.flat):
        return faults
    key = f"marks.serial = {marks.serial}" if marks.kind == "none" else f"marks.kind = {marks.kind!r}"
    rule = "digits and notches need a rectangular body. Text needs one, or a body with an outline. Remove it."
    return [f"{key}: {rule}", *faults]


def _pair_faults(legs: Legs, size: Size) -> list[str]:
    """Return messages on the faults of two equal legs, with the largest possible tilt if there is one."""
    problems = []
    for key, text in _pair_faults_at(legs, size, legs.tilt_deg):
        limit = _largest_tilt(legs, size)
        hint = f". A tilt up to {limit:.2f} deg is possible" if limit is not None else ""
        key = "tilt_deg" if limit is not None else key
        problems.append(f"legs.{key} = {getattr(legs, key) or size.depth:g} ({legs.kind}): {text}{hint}")
    return problems


def _list_faults(limbs: Sequence[Limb], size: Size) -> list[str]:
    """Return messages on the faults of a list of legs: of each leg, or else of crossing, height and stability."""
    problems = []
    for number, limb in enumerate(limbs, start=1):
        texts = [*_length_faults(limb), *_end_faults(limb, size.length), *_side_faults(limb, size.depth)]
        texts += [*section_of(limb).problems(limb), *_strut_faults([limb], size.length)]
        problems += [f"legs[{number}].along_mm = {limb.along:g}: {text}" for text in texts]
    return problems or [*_crossing_faults(limbs), *_height_faults(limbs), *_stability_faults(limbs)]


def _pair_faults_at(legs: Legs, size: Size, tilt_deg: float) -> list[tuple[str, str]]:
    """Return (key, message) for each fault of two equal legs at this tilt (deg). The key of [legs] is to be changed."""
    length, thickness, depth = size
    trial = legs.model_copy(update={"tilt_deg": tilt_deg})
    back, front = resolve_pair(trial, depth, -0.5 * thickness)
    problems = [("length_mm", text) for text in _length_faults(back)]
    problems += [("contact_spacing_mm", text) for text in _end_faults(_outer_leg(back, front), length)]
    problems += [("width_mm", text) for text in _side_faults(back, depth)]
    spacing, key = legs.contact_spacing_mm, "contact_spacing_mm"
    if 2.0 * back.half_width >= spacing:
        text = f"the legs overlap: each is {2.0 * back.half_width:.3f} mm wide along the plate. Make this larger"
        problems.append((key, text))
    problems += [("brace_thickness_mm", text) for text in section_of(back).problems(back)]
    for strut in section_of(back).struts(back):
        span = abs(strut.offset)
        if span + back.half_width + 0.5 * strut.thickness >= spacing:
            text = f"a leg crosses the other leg's brace: it spans {span:.3f} mm, but the feet are {spacing:g} mm apart"
            problems.append((key, text))
    return problems + [(key, text) for text in _strut_faults((back, front), length)]


def _outer_leg(back: Limb, front: Limb) -> Limb:
    """Return the leg whose anchor is farther from the middle of the body."""
    return max(back, front, key=lambda limb: abs(limb.anchor[0]))


def _length_faults(limb: Limb) -> list[str]:
    """Return a message if the leg is too short for its thickness, otherwise an empty list."""
    foot_radius = {"flat": 0.0, "square": 0.0, "round": 0.5 * limb.thickness}[limb.foot]
    shortest_side = limb.length - foot_radius
    if limb.foot != "flat":
        shortest_side -= 0.5 * limb.thickness * math.tan(abs(limb.tilt))
    if shortest_side > 0:
        return []
    return [
        f"the leg ({limb.thickness:g} mm thick, {limb.length:g} mm long) is too short for its thickness. "
        "Make it longer or thinner, or write foot = 'flat'"
    ]


def _end_faults(limb: Limb, body_length: float) -> list[str]:
    """Return a message if the leg extends beyond either end of a body of this length, mm, otherwise an empty list."""
    half_body, reach = 0.5 * body_length, abs(limb.anchor[0]) + limb.half_width
    if reach <= half_body:
        return []
    return [
        f"a leg extends beyond the body: it reaches x = {reach:.3f} mm, but the body ends at "
        f"{half_body:.3f} mm. Make the body longer, or the legs or their spacing shorter"
    ]


def _side_faults(limb: Limb, body_depth: float) -> list[str]:
    """Return a message if the leg extends beyond a side of a body of this depth, mm, otherwise an empty list."""
    reach = abs(limb.across) + 0.5 * limb.width
    if reach <= 0.5 * body_depth + ROUNDING_MM:
        return []
    return [
        f"the leg, {limb.width:g} mm wide (width_mm) at {limb.across:g} (across_mm), extends beyond the "
        f"body: it reaches z = {reach:.3f} mm, but the body ends at {0.5 * body_depth:.3f} mm. "
        "Move it, or make it narrower"
    ]


def _strut_faults(limbs: Sequence[Limb], body_length: float) -> list[str]:
    """Return a message if a brace extends beyond either end of a body of this length, mm, otherwise an empty list."""
    half_body = 0.5 * body_length
    struts = [(limb.anchor[0], strut) for limb in limbs for strut in section_of(limb).struts(limb)]
    reach = max((abs(x + strut.offset) + 0.5 * strut.thickness for x, strut in struts), default=0.0)
    if reach <= half_body:
        return []
    return [f"a brace extends beyond the body: it reaches x = {reach:.3f} mm, but the body ends at {half_body:.3f} mm"]


def _largest_tilt(legs: Legs, size: Size) -> float | None:
    """Return the largest tilt, deg, without fault of two equal legs, in 0..legs.tilt_deg; None if 0 deg has a fault."""
    if _pair_faults_at(legs, size, 0.0):
        return None
    good, bad = 0.0, legs.tilt_deg
    for _ in range(40):  # to far below 0.01 deg, to which the result is rounded
        middle = 0.5 * (good + bad)
        good, bad = (good, middle) if _pair_faults_at(legs, size, middle) else (middle, bad)
    return math.copysign(math.floor(abs(good) * 100) / 100, good)


def _crossing_faults(limbs: Sequence[Limb]) -> list[str]:
    """Return a message on each pair of legs that overlap."""
    import shapely

    problems = []
    sections = [
        shapely.union_all(
            [shapely.Polygon(piece + np.array(limb.anchor)) for piece in section_of(limb).profile(limb, segments=16)]
        )
        for limb in limbs
    ]
    for (i, limb), (j, other) in itertools.combinations(enumerate(limbs), 2):
        apart = abs(limb.across - other.across) - 0.5 * (limb.width + other.width)
        if apart >= -ROUNDING_MM:
            continue
        shared = sections[i].intersection(sections[j]).area
        if shared > ROUNDING_MM:
            problems.append(
                f"legs[{j + 1}].along_mm = {other.along:g}: the leg crosses leg {i + 1} (they share "
                f"{shared:.3g} mm2 in side view). Move them apart, along or across."
            )
    return problems


def _height_faults(limbs: Sequence[Limb]) -> list[str]:
    """Return a message on each leg whose foot does not reach the plate if the body is level."""
    lowest = min(limb.foot_height for limb in limbs)
    problems = []
    for number, limb in enumerate(limbs, start=1):
        missing_height = limb.foot_height - lowest
        if missing_height > MAX_HEIGHT_DIFFERENCE_MM:
            needed_length = limb.length + missing_height / math.cos(limb.tilt)
            problems.append(
                f"legs[{number}].length_mm = {limb.length:g}: the foot ends {missing_height:.3f} mm above "
                f"the lowest foot, so the walker is not level. {needed_length:.4f} mm would reach "
                "the plate."
            )
    return problems


def _stability_faults(limbs: Sequence[Limb]) -> list[str]:
    """Return a message if all feet are within a leg's thickness along the run, otherwise an empty list."""
    positions = [limb.along for limb in limbs]
    if max(positions) - min(positions) > max(limb.thickness for limb in limbs):
        return []
    return [
        f"legs[1].along_mm = {positions[0]:g}: all feet are at one position along the run, so the "
        "walker falls over. Put some in front of the others."
    ]


def _outline_faults(limbs: Sequence[Limb], shape: Shape) -> list[str]:
    """Return a message on each leg whose top is partly outside the outline of a body in plan view."""
    import shapely

    outer, *holes = shape.plan
    plan_area = shapely.Polygon(outer, holes)
    problems = []
    for number, limb in enumerate(limbs, start=1):
        x, half = limb.anchor[0], limb.half_width
        left, right = x - half, x + half
        for strut in section_of(limb).struts(limb):
            left = min(left, x + strut.offset - 0.5 * strut.thickness)
            right = max(right, x + strut.offset + 0.5 * strut.thickness)
        top = shapely.box(left, -limb.across - 0.5 * limb.width, right, -limb.across + 0.5 * limb.width)
        outside = top.difference(plan_area.buffer(ROUNDING_MM)).area
        if outside > 0.0:
            percent = max(1.0, 100 * outside / top.area)
            problems.append(
                f"legs[{number}].along_mm = {limb.along:g}: {percent:.0f} % of "
                "the top of the leg is outside the outline or under a hole. Move the leg, or make it "
                "narrower (width_mm)."
            )
    return problems
