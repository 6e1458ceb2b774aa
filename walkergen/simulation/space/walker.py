"""Walker in space: inertia of body and legs, springs, and points of contact, from its masses.

The mass matrix is that of relaxed legs. In the coordinates of `state` (C, shared turning rate W,
legs) it is block-diagonal: M, inertia about C, and the legs' own block.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from walkergen.errors import InputError
from walkergen.simulation.effects import compliance, feet, local_contact, turning, twist, walls
from walkergen.simulation.effects.effect import Case
from walkergen.simulation.effects.resolve import Resolved
from walkergen.simulation.space.state import Array, Options, Walker
from walkergen.simulation.world import World
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, Spatial, joined

LEVELS = 8
"""Tabulated flights: the longest takes 2^(LEVELS - 1) steps."""

RESOLVED = 0.6
"""Length of a step times the largest normal frequency of the feet."""

COARSEST = 1.0
"""The same beyond which steps are refused: at 1.3 speeds are 20 % low."""

LONGEST = 1e-5
"""Longest step of soft feet, s: the drive and the legs are held for a frame of steps."""

Z = np.array([0.0, 0.0, 1.0])

NONE = np.zeros(2)


class _Limbs(NamedTuple):
    """Legs as the mass matrix sees them: columns of momenta for n coordinates, vectors from C."""

    momentum: Array
    """Linear momentum by each coordinate's rate, shape (3, n)."""
    spin: Array
    """Angular momentum about C, shape (3, n)."""
    inertia: Array
    """Kinetic energy's quadratic form with C fixed, shape (n, n)."""


def walker_of(case: Case, resolved: Resolved) -> tuple[Walker, Options]:
    """Walker and steps of a case. Raises InputError for masses without a third dimension."""
    design, mass, scene = case.design, case.mass, case.scene
    if mass.spatial is None:
        raise InputError(f"{design.name}: motion in space needs inertia tensors, as of a mesh")
    freedoms = 0 if mass.rigid else 2 if resolved.on(twist.NAME) else 1
    loose, n = resolved.on(turning.NAME), 2 * freedoms
    total, centre, inertia = _whole(mass, mass.spatial)
    inverse_inertia = np.asarray(np.linalg.inv(inertia), float)
    if not loose:
        inverse_inertia = np.diag([0.0, 0.0, 1.0 / inertia[2, 2]])
    limbs = _limbs(design, mass, mass.spatial, centre, freedoms)
    lock = inverse_inertia @ limbs.spin
    own = limbs.inertia - limbs.momentum.T @ limbs.momentum / total - limbs.spin.T @ lock
    springs, dampers = _hinges(case, freedoms)
    points = _points(case, mass, centre, resolved.on(walls.NAME))
    one = Walker(
        mass=total,
        inverse_mass=np.array([1.0, 1.0, float(loose)]) / total,
        inertia=inertia,
        inverse_inertia=inverse_inertia,
        centre=-centre,
        freedoms=freedoms,
        hinge_inertia=own,
        hinge_mobility=np.asarray(np.linalg.inv(own), float),
        stiffness=springs,
        damping=dampers,
        fast=springs * np.diag(np.linalg.inv(own)),
        shift=limbs.momentum / total,
        lock=lock,
        **points,
        upward=np.where(points["place"] > 0.0, 2, 0),
        friction=np.where(points["place"] > 0.0, scene.arena.wall_friction, scene.contact.friction),
        spring=np.zeros((0, 2)),
        damper=np.zeros(0),
        unloading=1.0,
        corners=_corners(design, mass, centre),
        flights=np.zeros((0, n, n)),
    )  # fmt: skip
    return _with_feet(one, case, resolved.on(local_contact.NAME))


def _whole(mass: MassProperties, spatial: Spatial) -> tuple[float, Array, Array]:
    """Mass of the whole walker, its centre C from O (at half depth), and its inertia about C."""
    masses = np.array([mass.M, mass.m, mass.m], float)
    centres = np.array([(0.0, 0.0), mass.a + mass.c_A, mass.b + mass.c_A])
    centre, inertia = joined(spatial, masses, centres)
    return float(masses.sum()), centre, inertia


def _axis(design: Design) -> Array:
    """Unit vector anchor -> foot along a relaxed leg's centre line, shape (3,)."""
    return np.array([-math.sin(design.tilt), -math.cos(design.tilt), 0.0])


def _limbs(
    design: Design, mass: MassProperties, spatial: Spatial, centre: Array, freedoms: int
) -> _Limbs:
    """Momenta of the legs' coordinates; the twist is linear along a leg, zero at its anchor."""
    n, m, axis = 2 * freedoms, float(mass.m), _axis(design)
    found = _Limbs(np.zeros((3, n)), np.zeros((3, n)), np.zeros((n, n)))
    arm = np.array([*mass.c_A, 0.0])
    polar = float(axis @ spatial.leg @ axis)
    for leg, anchor in enumerate((mass.a, mass.b) if freedoms else ()):
        j = leg * freedoms
        swung = m * np.cross(Z, arm)
        place = np.array([*anchor, 0.0]) + arm - centre
        found.momentum[:, j] = swung
        found.spin[:, j] = np.cross(place, swung) + spatial.leg @ Z
        found.inertia[j, j] = m * arm @ arm + spatial.leg[2, 2]
        if freedoms > 1:
            found.spin[:, j + 1] = -0.5 * polar * axis
            found.inertia[j + 1, j + 1] = polar / 3.0
    return found


def _hinges(case: Case, freedoms: int) -> tuple[Array, Array]:
    """Stiffness and damping of the legs' coordinates, shape (n,) each."""
    design, mass, legs = case.design, case.mass, case.scene.legs
    if freedoms == 0 or mass.spatial is None:
        return np.zeros(0), np.zeros(0)
    axis = _axis(design)
    inertias = (
        float(mass.j + mass.m * mass.c_A @ mass.c_A),
        float(axis @ mass.spatial.leg @ axis) / 3.0,
    )
    springs = (compliance.stiffness(design, legs.spring), twist.stiffness(design))
    dampers = [
        2.0 * legs.damping_ratio * math.sqrt(k * inertia)
        for k, inertia in zip(springs, inertias, strict=True)
    ]
    return np.array(springs[:freedoms] * 2), np.array(dampers[:freedoms] * 2)


def _points(case: Case, mass: MassProperties, centre: Array, walled: bool) -> dict[str, Any]:
    """Points of contact: both corners of both feet, and the body's upright edges between walls."""
    design, half = case.design, 0.5 * case.design.body.depth_mm
    foot, axis = mass.c_A + mass.c_T, _axis(design)[:2]
    rows: list[Any] = []
    for leg, anchor in enumerate((mass.a, mass.b)):
        for side in (-half, half):
            root = np.array([*anchor, 0.0]) - centre
            # A braced foot is a point of the body
            rows.append(
                (-1, root + np.array([*foot, side]), NONE, 0.0, NONE, 0.0) if mass.rigid
                else (leg, root, foot, side, axis, 0.0)
            )  # fmt: skip
    if walled:
        middle, end = np.array(design.anchors[0]) - mass.a, 0.5 * design.body.length_mm
        for x in (-end, end):
            for z in (-half, half):
                root = np.array([x - middle[0], -middle[1], z]) - centre
                rows.append((-1, root, NONE, 0.0, NONE, 0.5 * walls.gap(case)))
    keys = ("leg", "root", "reach", "side", "axis", "place")
    return {
        key: np.array(values) for key, values in zip(keys, zip(*rows, strict=True), strict=True)
    }


def _corners(design: Design, mass: MassProperties, centre: Array) -> Array:
    """Corners of the body from C, shape (8, 3)."""
    middle = np.array(design.anchors[0]) - mass.a
    body = design.body
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    half = 0.5 * np.array([body.length_mm, body.thickness_mm, body.depth_mm])
    return np.asarray(signs * half - np.array([*middle, 0.0]) - centre)


def _with_feet(walker: Walker, case: Case, local: bool) -> tuple[Walker, Options]:
    """Walker with its elastic contacts and tabulated flights, and the steps that resolve them."""
    foot = feet.foot_of(case.scene, case.design, local)
    n, n_points = len(walker.stiffness), len(walker.leg)
    H = mobility(walker)
    wall = walker.place > 0.0
    label = case.scene.arena.wall_restitution
    ratio = np.where(wall, feet.damping_ratio(label), foot.damping_ratio)
    spring = np.tile([foot.normal, foot.tangential], (n_points, 1))
    # The label is that of a frictionless impact: there is no tangential damper
    own = np.diag(H)[0::3]
    damper = 2.0 * ratio * np.sqrt(foot.normal / np.where(own > 0.0, own, np.inf))
    on_plate = np.flatnonzero(~wall)
    block = H[np.ix_(3 * on_plate, 3 * on_plate)]
    fastest = math.sqrt(foot.normal * foot.unloading * float(np.linalg.eigvalsh(block)[-1]))
    step = _step(case.scene.run.step_us, fastest)
    return walker._replace(
        spring=spring, damper=damper, unloading=foot.unloading, flights=_flights(walker, step, n)
    ), Options(step)


def _step(given_us: float | None, fastest: float) -> float:
    """Length of a step, s, for feet whose fastest normal oscillation is `fastest` rad/s.

    Raises InputError for a given length that would step over whole contacts.
    """
    if given_us is None:
        return min(RESOLVED / fastest, LONGEST)
    longest = min(COARSEST / fastest, 10.0 * LONGEST)
    if 1e-6 * given_us > longest:
        raise InputError(
            f"run.step_us = {given_us:g}: steps over the contacts of these feet, which oscillate "
            f"at {1e-3 * fastest / (2.0 * math.pi):.3g} kHz; at most {1e6 * longest:.3g}, or leave "
            f"the key out ({1e6 * min(RESOLVED / fastest, LONGEST):.3g})"
        )
    return 1e-6 * given_us


def coarser(world: World, factor: float) -> World:
    """World with steps `factor` times longer, and flights tabulated for them."""
    walker, step = world.walker, factor * world.options.step
    flights = _flights(walker, step, len(walker.stiffness))
    return world._replace(
        walker=walker._replace(flights=flights), options=world.options._replace(step=step)
    )


def mobility(walker: Walker) -> Array:
    """Inverse mass of all contacts of a level, relaxed walker, shape (3 k, 3 k), 1/g."""
    size = 6 + len(walker.stiffness)
    J = np.zeros((3 * len(walker.leg), size))
    for k, leg in enumerate(walker.leg):
        point = walker.root[k] + [*walker.reach[k], walker.side[k]]
        along, up, across = np.eye(3)
        axes = (across, along, up) if walker.place[k] > 0.0 else (up, along, across)
        for p, direction in enumerate(axes):
            turn = np.cross(point, direction)
            row = J[3 * k + p]
            row[:3], row[3:6] = direction, turn
            row[6:] = -direction @ walker.shift - turn @ walker.lock
            if leg >= 0:
                j = 6 + leg * walker.freedoms
                across_leg = np.array([-walker.axis[k, 1], walker.axis[k, 0], 0.0])
                moved = (np.cross(Z, [*walker.reach[k], 0.0]), walker.side[k] * across_leg)
                for own in range(walker.freedoms):
                    row[j + own] += direction @ moved[own]
    M = np.zeros((size, size))
    M[:3, :3], M[3:6, 3:6] = np.diag(walker.inverse_mass), walker.inverse_inertia
    M[6:, 6:] = walker.hinge_mobility
    return np.asarray(J @ M @ J.T)


def _flights(walker: Walker, step: float, n: int) -> Array:
    """Propagators of the legs in flight for step 2^i seconds, shape (LEVELS, 2 n, 2 n)."""
    if n == 0:
        return np.zeros((LEVELS, 0, 0))
    from scipy.linalg import expm

    rates = np.zeros((2 * n, 2 * n))
    rates[:n, n:] = np.eye(n)
    rates[n:, :n] = -walker.hinge_mobility * walker.stiffness
    rates[n:, n:] = -walker.hinge_mobility * walker.damping
    return np.array([expm(step * 2.0**level * rates) for level in range(LEVELS)])
