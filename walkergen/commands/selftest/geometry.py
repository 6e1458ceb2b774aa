"""Hard cases of geometry: closed bodies with the closed form's volume and inertia, or refusals."""

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from walkergen.commands.selftest import closed_forms
from walkergen.commands.selftest.case import GEOMETRY, Case, Check
from walkergen.core.errors import GeometryError
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design

KINDS, FEET = ("flexible", "braced"), ("flat", "square", "round")

EXACT_REASON = "true or false"
ROUNDING_REASON = "coordinates carry 16 digits; a leg's volume is a sum of some tens of products of them"
POLYGON_REASON = "a round foot is a polygon: what its edges cut off to leading order, within 2 % of that"


def _design(body: dict[str, Any] | None = None, **legs: Any) -> Design:
    """Make a design from its tables `body` and `legs`."""
    return Design.model_validate({"body": body or {}, "legs": legs})


def _name(design: Design) -> str:
    return f"{design.kind}, {design.limbs[0].foot} feet, tilt {design.tilt_deg:g} deg"


def _check_relative(what: str, value: float, expected: float, limit: float, reason: str) -> Check:
    """Check the relative deviation of a value from the expected one."""
    return Check(what, abs(value - expected) / abs(expected), limit, reason)


def _count_defects(mesh: Mesh) -> int:
    """Count edges that are not shared by exactly two triangles, one in each direction."""
    edges = np.concatenate([np.roll(mesh.triangles, -k, axis=1)[:, :2] for k in range(3)])
    keys, counts = np.unique(edges @ np.array([len(mesh.vertices), 1]), return_counts=True)
    backward = np.unique(edges @ np.array([1, len(mesh.vertices)]))
    return int((counts != 1).sum() + len(np.setxor1d(keys, backward)))


def _count_bodies(mesh: Mesh) -> int:
    """Count connected pieces, by spreading the least number of a vertex over triangles."""
    label, before = np.arange(len(mesh.vertices)), None
    while before is None or (label != before).any():
        before = label.copy()
        least = label[mesh.triangles].min(axis=1)
        for corner in range(3):
            np.minimum.at(label, mesh.triangles[:, corner], least)
        label = label[label]
    return len(np.unique(label[mesh.triangles]))


def _genus(mesh: Mesh) -> int:
    """Compute the genus of a closed body from Euler's number; two triangles have three edges."""
    euler = len(np.unique(mesh.triangles)) - len(mesh.triangles) // 2
    return 1 - euler // 2


def _check_sound(design: Design, segments: int = solids.FOOT_SEGMENTS) -> Iterator[Check]:
    """Check that the design is one closed body with its parts' volume and the closed forms' volume and inertia."""
    name, built = _name(design), solids.build(design, segments)
    depth = design.size.depth
    for part, mesh in (("walker", built.walker), ("leg", built.legs[0])):
        yield Check(f"{name}: open edges of the {part}", _count_defects(mesh), 0, EXACT_REASON)
        yield Check(f"{name}: bodies of the {part} - 1", abs(_count_bodies(mesh) - 1), 0, EXACT_REASON)
    windows = sum(solids.has_window(limb) for limb in design.limbs)
    yield Check(f"{name}: windows", abs(_genus(built.walker) - windows), 0, EXACT_REASON)
    meshes = built.walker, built.body, built.legs[0]
    whole, body, limb = (mass.weigh(mesh, 1.0) for mesh in meshes)
    parts = body.volume + 2.0 * limb.volume
    yield _check_relative(f"{name}: union against its parts", whole.volume, parts, 1e-12, ROUNDING_REASON)

    round_leg = closed_forms.leg(design)
    shape = closed_forms.subtract_part(round_leg, closed_forms.polygon_deficit(design, segments))
    cut = 1.0 - shape.area / round_leg.area
    reason, limit = (POLYGON_REASON, 1e-11 + 0.02 * cut) if cut else (ROUNDING_REASON, 1e-11)
    if design.rigid and design.limbs[0].foot == "flat":
        expected = depth * (shape.area + closed_forms.brace_area_outside(design))
        yield _check_relative(f"{name}: leg and brace", limb.volume, expected, limit, reason)
    elif design.rigid:
        brace = design.limbs[0].brace * design.limbs[0].length / math.cos(design.limbs[0].tilt)
        more = limb.volume / depth - shape.area
        yield Check(f"{name}: less than a leg", -more / shape.area, limit, reason)
        yield Check(f"{name}: more than leg and brace", (more - brace) / shape.area, 0, EXACT_REASON)
    else:
        yield _check_relative(f"{name}: leg's volume", limb.volume, depth * shape.area, limit, reason)
        # The missing part is at the leg's end: it counts up to 4 times its share in j.
        yield _check_relative(f"{name}: leg's inertia", limb.inertia, depth * shape.second, 4.0 * limit, reason)
        deviation = math.hypot(limb.centre[0] - shape.x, limb.centre[1] - shape.y)
        yield Check(f"{name}: leg's centre", deviation / design.limbs[0].length, limit, reason)


def _check_all_sound(designs: Iterator[Design]) -> Iterator[Check]:
    """Check that each design is one closed body with the expected volume and inertia."""
    for design in designs:
        yield from _check_sound(design)


def _check_refused_design(what: str, word: str, body: dict[str, Any] | None = None, **legs: Any) -> Check:
    """Check that a design is refused by a text that begins with legs.tilt_deg and contains `word`.

    `what` names the case.
    """
    try:
        _design(body, **legs)
    except GeometryError as error:
        named = str(error).startswith("legs.") and word in str(error)
        return Check(f"{what}: refused as '{word}'", 0 if named else 1, 0, EXACT_REASON)
    return Check(f"{what}: refused as '{word}'", 1, 0, EXACT_REASON)


def _check_thin_legs() -> Iterator[Check]:
    """Check designs with legs of 0.05 mm."""
    thin: dict[str, Any] = {f"{part}_thickness_mm": 0.05 for part in ("flexible", "braced")}
    thin["brace_thickness_mm"] = 0.03
    combinations = itertools.product(KINDS, FEET, (0.0, 10.0, -45.0))
    return _check_all_sound(_design(kind=k, foot=f, tilt_deg=t, **thin) for k, f, t in combinations)


def _check_thick_legs() -> Iterator[Check]:
    """Check designs with legs of 5 mm, thicker than their bodies."""
    thick = {"flexible_thickness_mm": 5.0, "braced_thickness_mm": 5.0}
    combinations = itertools.product(KINDS, FEET, (0.0, 10.0, -30.0), (3.0, 0.05))
    return _check_all_sound(
        _design({"thickness_mm": body}, kind=k, foot=f, tilt_deg=t, **thick) for k, f, t, body in combinations
    )


def _check_coplanar_brace() -> Iterator[Check]:
    """Check an upright brace: it lies in the leg, and at equal thickness has the leg's sides."""
    tilts = (0.0, -0.0, 1e-12, -1e-12, 1e-7)
    for foot, tilt, brace in itertools.product(FEET, tilts, (0.5, 1.0 - 1e-12)):
        design = _design(kind="braced", foot=foot, tilt_deg=tilt, brace_thickness_mm=brace)
        yield from _check_sound(design)
    weighed = solids.weigh(upright := _design(kind="braced", tilt_deg=0.0), solids.build(upright))
    # The paper's walker, mm: density in g/mm^3 times the depth
    body, leg = closed_forms.rectangle(28.0, 3.0), closed_forms.rectangle(1.0, 7.5)
    area, lever = body.area + 2.0 * leg.area, 5.25  # from the body's middle to a leg's, along y
    drop = 2.0 * leg.area * lever / area
    second = body.second + 2.0 * (leg.second + leg.area * (6.5**2 + lever**2)) - area * drop**2
    density = 1.24e-3 * 8.0
    yield _check_relative("upright braced walker: M", float(weighed.M), density * area, 1e-12, ROUNDING_REASON)
    yield _check_relative("upright braced walker: J", float(weighed.J), density * second, 1e-12, ROUNDING_REASON)


def _check_opening_window() -> Iterator[Check]:
    """Check designs near the leg length at which a window between leg and brace opens."""
    for foot, tilt in itertools.product(FEET, (10.0, -40.0)):
        start = _design(kind="braced", foot=foot, tilt_deg=tilt)
        sin, cos = abs(math.sin(start.limbs[0].tilt)), math.cos(start.limbs[0].tilt)
        # The brace, 0.5 mm wide, then clears the leg, 1 mm wide, at the body
        length = 0.5 * (1.0 / cos + 0.5) / sin + (0.5 if foot == "round" else 0.0)
        for part in (-1e-6, -1e-12, 0.0, 2.0**-52, 1e-14, 1e-11, 1e-9, 1e-8, 1e-6):
            yield from _check_sound(_design(kind="braced", foot=foot, tilt_deg=tilt, length_mm=length * (1.0 + part)))


def _check_flush_leg() -> Iterator[Check]:
    """Check a leg whose side lies in the body's end face: built at the limit, refused an ulp beyond."""
    for kind, foot in itertools.product(KINDS, FEET):
        design = _design(kind=kind, foot=foot, tilt_deg=0.0)
        flush = 13.0 + design.limbs[0].thickness  # 13 mm between the contacts
        yield from _check_sound(_design({"length_mm": flush}, kind=kind, foot=foot, tilt_deg=0.0))
        short = {"length_mm": math.nextafter(flush, 0.0)}
        legs: dict[str, Any] = {"kind": kind, "foot": foot, "tilt_deg": 0.0}
        yield _check_refused_design(f"{_name(design)}: an ulp beyond", "extends beyond the body", short, **legs)


def _check_edge_anchor() -> Iterator[Check]:
    """Check the tilt at which an anchor's leg reaches the body's edge: built there, not beyond."""
    for kind, foot, tilt in itertools.product(KINDS, FEET, (10.0, 45.0, -30.0)):
        legs: dict[str, Any] = {"kind": kind, "foot": foot, "tilt_deg": tilt}
        design = _design(**legs)
        half_width = 0.5 * design.limbs[0].thickness / math.cos(design.limbs[0].tilt)
        edge = 2.0 * (max(abs(limb.anchor[0]) for limb in design.limbs) + half_width)
        yield from _check_sound(_design({"length_mm": edge}, **legs))
        short = {"length_mm": math.nextafter(edge, 0.0)}
        yield _check_refused_design(f"{_name(design)}: an ulp beyond", "extends beyond the body", short, **legs)
        legs["tilt_deg"] = tilt + math.copysign(1e-9, tilt)
        what = f"{_name(design)}: 1e-9 deg beyond"
        yield _check_refused_design(what, "extends beyond the body", {"length_mm": edge}, **legs)


def _check_refusals() -> Iterator[Check]:
    """Check that a design is refused if its parts cross, vanish, or only touch without a common volume."""
    yield _check_refused_design(
        "feet as far apart as they are wide", "the legs overlap", tilt_deg=0.0, contact_spacing_mm=0.4
    )
    yield _check_refused_design(
        "round feet on a leg of no side", "too short for its thickness", foot="round", tilt_deg=0.0, length_mm=0.2
    )
    yield _check_refused_design(
        "a brace wider than its foot",
        "thicker than its foot",
        kind="braced",
        foot="round",
        tilt_deg=0.0,
        brace_thickness_mm=math.nextafter(1.0, 2.0),
    )
    yield _check_refused_design(
        "a leg through the other's brace",
        "crosses the other leg's brace",
        kind="braced",
        tilt_deg=30.0,
        contact_spacing_mm=4.5,
    )
    yield _check_refused_design("legs flat on the body", "extends beyond the body", tilt_deg=85.0)


def _scale_design(design: Design, scale: float) -> Design:
    """Return a design with all lengths multiplied by `scale`."""
    data = design.model_dump(include={"body", "legs"}, exclude_none=True)
    for table in data.values():
        table.update({key: scale * v for key, v in table.items() if key.endswith("_mm")})
    return Design.model_validate(data)


def _check_scaling() -> Iterator[Check]:
    """Check designs a thousand times smaller and larger: masses go as l^3, inertias as l^5."""
    for kind, foot, scale in itertools.product(KINDS, FEET, (1e-3, 1e3)):
        design = _design(kind=kind, foot=foot)
        scaled = _scale_design(design, scale)
        yield from _check_sound(scaled)
        mass, scaled_mass = (solids.mass_of(walker) for walker in (design, scaled))
        for what, power in (("M", 3), ("J", 5)):
            value, reference = float(getattr(scaled_mass, what)), float(getattr(mass, what))
            yield _check_relative(
                f"{_name(design)} x {scale:g}: {what}", value, reference * scale**power, 1e-12, ROUNDING_REASON
            )


def _check_far_origin() -> Iterator[Check]:
    """Check weighing a kilometre away: without a local origin inertias lose all their digits."""
    reason = "1e6 mm away a coordinate is rounded to 1e-10 mm, 3e-10 of a leg's thickness"
    for scale in (1e-3, 1.0, 1e3):
        shift = scale * np.array([1e6, -1e6, 1e6])
        built = solids.build(_scale_design(_design(), scale))
        meshes = {"walker": built.walker, "body": built.body, "leg": built.legs[0]}
        for part, mesh in meshes.items():
            here = mass.weigh(mesh, 1.0)
            there = mass.weigh(mesh.shift(shift), 1.0)
            what = f"{part} x {scale:g}"
            yield _check_relative(f"{what}: volume", there.volume, here.volume, 1e-9, reason)
            yield _check_relative(f"{what}: inertia", there.inertia, here.inertia, 1e-9, reason)
            deviation = float(np.abs(there.centre - shift - here.centre).max()) / scale
            yield Check(f"{what}: centre, mm / {scale:g}", deviation, 1e-9, reason)


def _check_round_feet() -> Iterator[Check]:
    """Check arcs from two edges to four thousand: never larger than the circle's."""
    for tilt in (0.0, 20.0, -45.0):
        design = _design(foot="round", tilt_deg=tilt)
        exact, missing_areas = closed_forms.leg(design).area, []
        for segments in (2, 3, 16, 64, 4096):
            leg = solids.build(design, segments).legs[0]
            yield Check(f"{_name(design)}, {segments} edges: open", _count_defects(leg), 0, EXACT_REASON)
            area = mass.weigh(leg, 1.0).volume / design.size.depth
            missing_areas.append(exact - area)
            what = f"{_name(design)}, {segments} edges: larger than the circle"
            yield Check(what, -missing_areas[-1] / exact, 1e-14, ROUNDING_REASON)
        ratio = missing_areas[2] / missing_areas[3]
        reason = "16 times at four times the edges; the lowest point shifts some edges' lengths"
        yield Check(f"{_name(design)}: not of second order", abs(ratio - 16.0), 0.5, reason)


def _check_mirror_image() -> Iterator[Check]:
    """Check that opposite tilts give mirrored volume, inertia and centre."""
    for kind, foot, tilt in itertools.product(KINDS, FEET, (1e-12, 17.0, 60.0)):
        pair = [_design(kind=kind, foot=foot, tilt_deg=sign * tilt) for sign in (1.0, -1.0)]
        left, right = (mass.weigh(solids.build(design).walker, 1.0) for design in pair)
        name = _name(pair[0])
        yield _check_relative(f"{name}: mirrored volume", right.volume, left.volume, 1e-12, ROUNDING_REASON)
        yield _check_relative(f"{name}: mirrored inertia", right.inertia, left.inertia, 1e-12, ROUNDING_REASON)
        deviation = abs(right.centre[0] + left.centre[0]) / 28.0
        yield Check(f"{name}: mirrored centre", deviation, 1e-13, ROUNDING_REASON)


CASES: tuple[Case, ...] = tuple(
    Case(name, "geometry", source, GEOMETRY, check)
    for name, source, check in (
        ("legs of 0.05 mm", "closed forms of strips; Euler's number", _check_thin_legs),
        ("legs thicker than the body", "closed forms of strips; Euler's number", _check_thick_legs),
        ("brace coplanar with the leg", "closed forms of strips; parallel axes", _check_coplanar_brace),
        ("a window of no width", "closed forms of strips; Euler's number", _check_opening_window),
        ("leg flush with the body's end", "Euclid: a point on a line, and an ulp off it", _check_flush_leg),
        ("anchor at the body's edge", "trigonometry: a strip cut aslant, s / cos", _check_edge_anchor),
        ("parts that meet or vanish", "Euclid: strips that cross, and lengths of 0", _check_refusals),
        ("a thousand times smaller and larger", "dimensional analysis: M ~ l^3, J ~ l^5", _check_scaling),
        ("a kilometre from the origin", "translation changes no volume or inertia", _check_far_origin),
        ("edges of a round foot", "area of a circle and of its polygon", _check_round_feet),
        ("mirror image of a solid", "mirror symmetry", _check_mirror_image),
    )
)
"""Hard cases of the solids and their mass properties."""
