"""Cutting pockets into a walker's body: for its motor, its battery and the wires between them.

A pocket is all the space that a part sweeps, with its clearance, while it is inserted from the
pocket's open side. The floor on the opposite side must be solid everywhere, for any body shape.
"""

import itertools
from collections.abc import Sequence

import manifold3d
import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import MIN_FLOOR_MM, Cylinder, Part
from walkergen.core.walker.mass import SolidMass

CIRCLE_SEGMENTS = 128
"""Edges of a round pocket: on a coin cell they lie within 3 um of the circle."""

ROUNDING_SHARE = 1e-6
"""Share of a volume that counts as rounding."""

OPENING_DIRECTIONS = {"up": (0.0, 1.0, 0.0), "down": (0.0, -1.0, 0.0), "side": (0.0, 0.0, 1.0)}
"""Directions of the openings of pockets, in the design's frame."""


def cut_pockets(design: Design, walker: Mesh, body: Mesh, roots: Sequence[Mesh]) -> tuple[Mesh, Mesh]:
    """Return the meshes of walker and body with the pockets for the design's motor and battery cut into them.

    `roots` are the legs with their ends inside the body. Raises GeometryError, whose message begins with the key, for
    parts that overlap each other or a leg, or have no floor.
    """
    solid, legs = modeller.to_solid(body), [modeller.to_solid(root) for root in roots]
    pocket_solids = _pocket_solids(design)
    if design.motor and design.battery:
        _check_overlap(design)
    for name, pocket in pocket_solids.items():
        _check_leg_clear(name, pocket, legs, design)
    for name, part in design.parts.items():
        others = [pocket for other, pocket in pocket_solids.items() if other not in (name, "channel")]
        _check_floor(name, part, solid, _unite(others), design)
    cavity = _pocket_union(design)
    cut = [modeller.check_solid(modeller.to_solid(mesh) - cavity) for mesh in (walker, body)]
    if any(len(modeller.split_bodies(piece)) != 1 for piece in cut):
        raise GeometryError(
            f"{_format_position(next(iter(design.parts)), design)}: the pockets cut the body into pieces. "
            "Move them, or make the body larger.",
            _position_key(next(iter(design.parts))),
        )
    return modeller.to_mesh(cut[0]), modeller.to_mesh(cut[1])


def check_marks_intact(design: Design, marked: Mesh, plain: Mesh) -> None:
    """Raise GeometryError if the pockets of a body remove a part of its marks.

    `marked` is the body with marks and `plain` the body without them, both without pockets.
    """
    strokes = modeller.to_solid(plain) - modeller.to_solid(marked)
    lost = modeller.check_solid(strokes ^ _pocket_union(design)).volume() / strokes.volume()
    if lost > ROUNDING_SHARE:
        key = "kind" if design.marks.kind != "none" else "serial"
        raise GeometryError(
            f"marks.{key} = {getattr(design.marks, key)!r}: the pockets remove {100.0 * lost:.2g} % "
            "of the mark. Remove it, make it smaller, or let the pockets open elsewhere.",
            f"marks.{key}",
        )


def without_pockets(design: Design) -> Design:
    """Return the design without its motor, battery and pockets."""
    empty = {"motor": None, "battery": None, "pockets": None}
    return design.model_copy(update=empty)


def part_meshes(design: Design) -> dict[str, Mesh]:
    """Return meshes of a design's motor and battery, by the names of their tables, in the design's frame."""
    return {
        name: modeller.to_mesh(_convex_hull(_cylinder_points(part.cylinder, design, 0.0)))
        for name, part in design.parts.items()
    }


def weigh_contents(design: Design) -> list[SolidMass]:
    """Compute the mass properties of motor and battery, each with its share of the glue, and of the wires.

    The wires are a thin rod between the middles of both parts. Their mass is added to a single part. Centres are in the
    design's frame.
    """
    cylinders, depth = [part.cylinder for part in design.parts.values()], design.size.depth
    extra = design.pocket_settings.glue_g / len(cylinders)
    if len(cylinders) == 1:
        extra += design.pocket_settings.wires_g
    parts = [_cylinder_mass(cylinder, cylinder.mass + extra, depth) for cylinder in cylinders]
    if len(parts) > 1 and design.pocket_settings.wires_g > 0.0:
        first, second = (part.centre for part in parts)
        rod, wires = second - first, design.pocket_settings.wires_g
        tensor = wires / 12.0 * (rod @ rod * np.eye(3) - np.outer(rod, rod))
        parts.append(SolidMass(wires, 0.5 * (first + second), tensor, 0.0))
    return parts


def _cylinder_mass(cylinder: Cylinder, mass: float, depth: float) -> SolidMass:
    """Return the mass properties of a solid cylinder of this mass, g, in a body of this depth, mm."""
    transverse_inertia = mass * (3.0 * cylinder.radius**2 + cylinder.height**2) / 12.0
    tensor = transverse_inertia * np.eye(3)
    tensor[cylinder.axis, cylinder.axis] = 0.5 * mass * cylinder.radius**2
    volume = np.pi * cylinder.radius**2 * cylinder.height
    return SolidMass(mass, np.array(cylinder.centre_in_design(depth)), tensor, volume)


def wall_between(design: Design, max_thickness: float) -> float:
    """Return the thinnest wall between the pockets of motor and battery within the body's box, mm.

    It is 0 if one opens into the other. It is `max_thickness` (mm) if the wall is thicker or there is only one pocket.
    The channel of the wires, which is meant to join them, does not count.
    """
    if len(design.parts) < 2:
        return max_thickness
    size = design.size
    box = manifold3d.Manifold.cube((size.length, size.thickness, size.depth))
    box = box.translate((-0.5 * size.length, -0.5 * size.thickness, 0.0))
    pocket_solids = [_swept_volume(part, design) ^ box for part in design.parts.values()]
    if not modeller.check_solid(pocket_solids[0] ^ pocket_solids[1]).is_empty():
        return 0.0
    return float(pocket_solids[0].min_gap(pocket_solids[1], max_thickness))


def _pocket_solids(design: Design) -> dict[str, manifold3d.Manifold]:
    """Return the solids to cut away: each pocket by the name of its part, and the wires' "channel"."""
    cuts = {name: _swept_volume(part, design) for name, part in design.parts.items()}
    if len(cuts) > 1 and design.pocket_settings.channel_mm > 0.0:
        cuts["channel"] = _channel_solid(design)
    return cuts


def _pocket_union(design: Design) -> manifold3d.Manifold:
    """Return the union of all pockets and of the wires' channel."""
    return _unite(list(_pocket_solids(design).values()))


def _unite(solids: Sequence[manifold3d.Manifold]) -> manifold3d.Manifold:
    return manifold3d.Manifold.batch_boolean(list(solids), manifold3d.OpType.Add)


def _convex_hull(points: Array) -> manifold3d.Manifold:
    """Return the convex hull of points, shape (n, 3), mm."""
    return modeller.check_solid(manifold3d.Manifold.hull_points(points))


def _cylinder_points(cylinder: Cylinder, design: Design, clearance: float) -> Array:
    """Return points on the rims of a cylinder with clearance (mm) on every side, shape (2 CIRCLE_SEGMENTS, 3), mm."""
    angles = 2.0 * np.pi * np.arange(CIRCLE_SEGMENTS) / CIRCLE_SEGMENTS
    radius, half = cylinder.radius + clearance, 0.5 * cylinder.height + clearance
    ring = np.zeros((CIRCLE_SEGMENTS, 3))
    ring[:, cylinder.axis - 2] = radius * np.cos(angles)
    ring[:, cylinder.axis - 1] = radius * np.sin(angles)
    end = np.zeros(3)
    end[cylinder.axis] = half
    middle: Array = np.array(cylinder.centre_in_design(design.size.depth))
    return np.concatenate([middle + ring - end, middle + ring + end])


def _swept_volume(part: Part, design: Design) -> manifold3d.Manifold:
    """Return a part's pocket: all space that the part and its clearance fill, or pass while the part is inserted."""
    points = _cylinder_points(part.cylinder, design, design.pocket_settings.clearance_mm)
    return _convex_hull(
        np.concatenate([points, points + _exit_distance(points, design) * np.array(OPENING_DIRECTIONS[part.opens])])
    )


def _exit_distance(points: Array, design: Design) -> float:
    """Return a distance, mm, by which points in or near the body, shape (n, 3), leave it in any direction."""
    return float(2.0 * sum(design.size) + np.ptp(points, axis=0).sum())


def _channel_solid(design: Design) -> manifold3d.Manifold:
    """Return the wires' channel from pocket floor to pocket floor, open to the side where both pockets open."""
    parts = list(design.parts.values())
    half = 0.5 * design.pocket_settings.channel_mm
    corners = half * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    points = np.concatenate([_channel_end(part, design) + corners for part in parts])
    if parts[0].opens == parts[1].opens:
        out = _exit_distance(points, design) * np.array(OPENING_DIRECTIONS[parts[0].opens])
        points = np.concatenate([points, points + out])
    return _convex_hull(points)


def _channel_end(part: Part, design: Design) -> Array:
    """Return the middle of the channel's end in a part's pocket, on its floor and within the body, shape (3,), mm."""
    half, opening = 0.5 * design.pocket_settings.channel_mm, np.array(OPENING_DIRECTIONS[part.opens])
    cylinder = part.cylinder
    middle = np.array(cylinder.centre_in_design(design.size.depth))
    middle -= opening * (np.array(cylinder.half) + design.pocket_settings.clearance_mm - half)
    limit = max(0.5 * design.size.thickness - MIN_FLOOR_MM - half, 0.0)
    middle[1] = min(max(middle[1], -limit), limit)
    return middle


def _check_overlap(design: Design) -> None:
    """Raise GeometryError if motor and battery overlap."""
    motor, battery = (_convex_hull(_cylinder_points(part.cylinder, design, 0.0)) for part in design.parts.values())
    shared = modeller.check_solid(motor ^ battery).volume()
    if shared > ROUNDING_SHARE * motor.volume():
        raise GeometryError(
            f"{_format_position('motor', design)}: motor and battery overlap (by {shared:.3g} "
            "mm3). Move one of them (along_mm, across_mm, up_mm).",
            _position_key("motor"),
        )


def _check_leg_clear(name: str, cut: manifold3d.Manifold, legs: Sequence[manifold3d.Manifold], design: Design) -> None:
    """Raise GeometryError if a pocket cuts a leg or the end of a leg inside the body.

    `name` is that of the pocket's part, or "channel" for the channel of the wires. `cut` is the solid to cut away.
    """
    for number, leg in enumerate(legs, start=1):
        lost = modeller.check_solid(leg ^ cut).volume()
        if lost > ROUNDING_SHARE * leg.volume():
            what, remedy = f"the pocket of the {name}", "Move it, or the leg."
            if name == "channel":
                what, remedy = "the channel", "Make it narrower (0 for none), or move the motor."
            raise GeometryError(
                f"{_format_position(name, design)}: {what} cuts leg {number}, or its root in the body (by "
                f"{lost:.3g} mm3). {remedy}",
                _position_key(name),
            )


def _check_floor(
    name: str, part: Part, body: manifold3d.Manifold, other_pocket: manifold3d.Manifold, design: Design
) -> None:
    """Raise GeometryError unless solid plastic closes a part's pocket opposite its opening. `body`: without pockets."""
    points = _cylinder_points(part.cylinder, design, design.pocket_settings.clearance_mm)
    inward = np.array(OPENING_DIRECTIONS["up" if part.opens == "down" else "down"])
    layer = _convex_hull(points + MIN_FLOOR_MM * inward) - _convex_hull(points)
    # The floor counts only below the lowest points of a round part
    floor = modeller.check_solid(layer.trim_by_plane(inward.tolist(), float((points @ inward).max()) - MIN_FLOOR_MM))
    outside, shared = (
        modeller.check_solid(lost).volume() / floor.volume() for lost in (floor - body, floor ^ body ^ other_pocket)
    )
    if outside + shared > ROUNDING_SHARE:
        where, key = "outside the body or over a hole", _position_key(name)
        if shared > outside:
            where, key = f"in the pocket of the {'motor' if name == 'battery' else 'battery'}", f"{name}.up_mm"
        raise GeometryError(
            f"{key} = {getattr(part, key.partition('.')[2]):g}: the floor of its pocket must be {MIN_FLOOR_MM:g} mm of "
            f"plastic, but {100.0 * max(outside, shared):.2g} % of it is {where}. Move the {name} (along_mm, "
            "across_mm, up_mm), or make the body larger.",
            key,
        )


def _format_position(name: str, design: Design) -> str:
    """Format, as "key = value", the position of a part along the body, or the width of the "channel"."""
    value = design.pocket_settings.channel_mm if name == "channel" else design.parts[name].along_mm
    return f"{_position_key(name)} = {value:g}"


def _position_key(name: str) -> str:
    """Return the key of a part's position along the body, or of the width of the "channel"."""
    return "pockets.channel_mm" if name == "channel" else f"{name}.along_mm"
