"""Walker of the 3D simulation: inertia of body and legs, springs, and points of contact, from its masses.

The mass matrix is that of relaxed legs. In the coordinates of `state` (C, shared turning rate W,
legs) it is block-diagonal: M, inertia about C, and the legs' own block.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation.effects import feet, legs, turning, walls
from walkergen.core.simulation.effects import motor as motors
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.effects.legs import hinge_stiffness, twist_stiffness
from walkergen.core.simulation.effects.resolve import Resolved
from walkergen.core.simulation.space.points import body_hull, contact_points, leg_axis
from walkergen.core.simulation.space.state import HALVINGS, Array, Options, Walker
from walkergen.core.simulation.world import World
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import LegMass, MassProperties, Spatial, centre_and_inertia

FLIGHT_LEVELS = 5
"""Tabulated flights of a step and longer: the longest is 2^(FLIGHT_LEVELS - 1) steps, 0.4 ms of the paper's walker."""

MAX_SERIES_NORM, SERIES_TERMS = 0.5, 14
"""Largest norm of a matrix, and number of terms that give its exponential exactly to rounding up to that norm."""

MAX_STEP_PHASE, MAX_STEP_PHASE_UP, MAX_STEP_PHASE_SIDEWAYS = 0.23, 1.6, 2.4
"""Length of a step times the frequency of a corner that bears its share of the walker, pressed as deep as a landing
presses it; and times the largest frequencies of all feet at that depth, along the normal and sideways: those of light
legs. At 3.3 sideways a thin leg's twist gained energy."""

MAX_STEP_RATIO = 3.0
"""Length of a step over the feet's own beyond which steps are refused."""

MAX_STEP_PERIODS, MIN_STEP_RATIO = 5e-3, 1 / 64
"""Longest step of soft feet, of the plate's period (56 us at 90 Hz): drive and legs are held for a frame of steps; and
the least part of what resolves the feet that a step is, however fast the plate."""

LOSSLESS_STEP_RATIO, LOSSLESS_DROP_MM = 1 / 32, 1.0
"""Share of that step where nothing takes energy, so that the step's own error would add up, and the drop (mm) whose
landing it then resolves: 1000 landings of corners keep the energy within 0.5 %."""

REST_SPEED_RATIO = 1e-6
"""Speed of landings on the plate, of what gravity gives in a period, below which the plate counts as at rest."""

FRAME_STEPS, MAX_FRAME_PERIODS = 24, 2.2e-2
"""Largest number of steps with a frozen pose, and longest such frame of the walker's own steps, in periods of the plate
(240 us at 90 Hz)."""

Z = np.array([0.0, 0.0, 1.0])


class _Limbs(NamedTuple):
    """Parts of the mass matrix from free legs with n coordinates (hinge angles and twists)."""

    momentum: Array
    """Linear momentum by each coordinate's rate, shape (3, n)."""
    spin: Array
    """Angular momentum about C, shape (3, n)."""
    inertia: Array
    """Kinetic energy's quadratic form with C fixed, shape (n, n)."""


def make_walker(case: Case, resolved: Resolved) -> tuple[Walker, Options]:
    """Return the simulator's data on a walker, and its time steps. Raises InputError without inertia tensors."""
    design, mass, scene = case.design, case.mass, case.scene
    if mass.spatial is None or any(leg.tensor is None for leg in mass.legs):
        raise InputError(f"{design.name}: motion in space needs inertia tensors, as of a mesh")
    free = [place for place, leg in enumerate(mass.legs) if leg.m > 0.0]
    freedoms = 0 if not free else 2 if resolved.is_on(legs.TWIST) else 1
    can_turn, n = resolved.is_on(turning.NAME), len(free) * freedoms
    total, centre, inertia = _total_mass_properties(mass, mass.spatial)
    inverse_inertia = np.asarray(np.linalg.inv(inertia), float)
    if not can_turn:
        inverse_inertia = np.diag([0.0, 0.0, 1.0 / inertia[2, 2]])
    limbs = _leg_momenta([(design.limbs[k], mass.legs[k]) for k in free], centre, freedoms)
    lock = inverse_inertia @ limbs.spin  # Lambda = I_C^-1 L of eq. 7.2
    # G of eq. 7.3: the legs' inertia without what the whole takes over
    leg_inertia = limbs.inertia - limbs.momentum.T @ limbs.momentum / total - limbs.spin.T @ lock
    springs, dampers = _hinge_constants(case, free, freedoms)
    points = contact_points(case, free, centre, resolved.is_on(walls.NAME), resolved.is_on(walls.LID))
    feet = points.pop("foot")
    walker = Walker(
        mass=total,
        inverse_mass=np.array([1.0, 1.0, float(can_turn)]) / total,
        inertia=inertia,
        inverse_inertia=inverse_inertia,
        centre=-centre,
        freedoms=freedoms,
        hinge_inertia=leg_inertia,
        hinge_mobility=np.asarray(np.linalg.inv(leg_inertia), float),
        stiffness=springs,
        damping=dampers,
        fast=springs * np.diag(np.linalg.inv(leg_inertia)),
        shift=limbs.momentum / total,
        lock=lock,
        **points,
        upward=_upward_components(points["wall_distance"]),
        friction=np.array([_point_friction(scene, design, foot) for foot in feet]),
        spring=np.zeros(0),
        tip=np.zeros(0),
        shear=np.zeros(0),
        damper=np.zeros(0),
        corners=body_hull(design, mass, centre),
        forced=np.zeros((2, n)),
        flights=np.zeros((0, n, n)),
    )
    rotor = resolved.acting.motor
    if motors.acts(rotor) and n > 0:
        walker = walker._replace(forced=_forced_swing(walker, rotor))
    return _add_feet(walker, case, feet)


def _total_mass_properties(mass: MassProperties, spatial: Spatial) -> tuple[float, Array, Array]:
    """Return the whole walker's mass (g), its centre (mm, from the body's, at half depth), and its inertia about it."""
    masses = np.array([mass.M, *(leg.m for leg in mass.legs)], float)
    centres = np.array([(0.0, 0.0), *(leg.anchor + leg.c_A for leg in mass.legs)])
    centre, inertia = centre_and_inertia(spatial, mass.legs, masses, centres)
    return float(masses.sum()), centre, inertia


def _leg_momenta(legs: Sequence[tuple[Limb, LegMass]], centre: Array, freedoms: int) -> _Limbs:
    """Return momenta and inertia of the legs by their coordinates. `centre`: centre of mass from the body's, mm.

    With `freedoms` 1 a leg has a hinge, with 2 also a twist, linear along it and zero at its anchor.
    """
    n = len(legs) * freedoms
    limbs = _Limbs(np.zeros((3, n)), np.zeros((3, n)), np.zeros((n, n)))
    for number, (limb, leg) in enumerate(legs):
        assert leg.tensor is not None
        j, m, axis, arm = number * freedoms, float(leg.m), leg_axis(limb), np.array([*leg.c_A, 0.0])
        polar = float(axis @ leg.tensor @ axis)
        swung = m * np.cross(Z, arm)
        place = np.array([*leg.anchor, leg.across]) + arm - centre
        limbs.momentum[:, j] = swung
        limbs.spin[:, j] = np.cross(place, swung) + leg.tensor @ Z
        limbs.inertia[j, j] = m * arm @ arm + leg.tensor[2, 2]
        if freedoms > 1:
            limbs.spin[:, j + 1] = -0.5 * polar * axis
            limbs.inertia[j + 1, j + 1] = polar / 3.0
    return limbs


def _hinge_constants(case: Case, free: Sequence[int], freedoms: int) -> tuple[Array, Array]:
    """Return stiffness and damping, as in `Walker`, of the n coordinates of the legs numbered in `free`: (n,) each."""
    design, legs = case.design, case.scene.legs
    springs: list[float] = []
    dampers: list[float] = []
    for limb, leg in ((design.limbs[k], case.mass.legs[k]) for k in free):
        assert leg.tensor is not None
        axis = leg_axis(limb)
        modulus = design.material.youngs_modulus
        inertias = float(leg.inertia), float(axis @ leg.tensor @ axis) / 3.0
        stiff = hinge_stiffness(limb, modulus), twist_stiffness(limb, design.material)
        springs += stiff[:freedoms]
        dampers += [
            2.0 * legs.damping_ratio * math.sqrt(k * inertia)
            for k, inertia in zip(stiff[:freedoms], inertias[:freedoms], strict=True)
        ]
    return np.array(springs), np.array(dampers)


def _forced_swing(walker: Walker, rotor: motors.Rotor) -> Array:
    """Return the legs' angles that a rotor forces in lasting flight, by cosine and sine of its phase, shape (2, n)."""
    omega, push = rotor.omega, rotor.moment * rotor.omega**2
    pushes = push * np.array([rotor.first, rotor.second])
    torques = np.cross(rotor.position + walker.centre, pushes)
    lag_torques = -(pushes @ walker.shift + torques @ walker.lock)
    stiff = np.diag(walker.stiffness) - omega**2 * walker.hinge_inertia
    turned = omega * np.diag(walker.damping)
    both = np.block([[stiff, turned], [-turned, stiff]])
    return np.asarray(np.linalg.solve(both, lag_torques.ravel()).reshape(2, -1))


def _upward_components(place: Array) -> Array:
    """Return the upward parts of contact directions, shape (k, 3). `place`: > 0 walls, 0 plate, < 0 lid."""
    upward = np.zeros((len(place), 3))
    upward[place == 0.0, 0], upward[place < 0.0, 0], upward[place > 0.0, 2] = 1.0, -1.0, 1.0
    return upward


def _point_friction(scene: Scene, design: Design, foot: int) -> float:
    """Return the friction of a contact point of leg `foot`, or that of walls and lid if `foot` is -1."""
    if foot < 0:
        return scene.arena.wall_friction
    own = design.limbs[foot].friction
    return scene.contact.friction if own is None else own


def _add_feet(walker: Walker, case: Case, feet_of_points: Array) -> tuple[Walker, Options]:
    """Return the walker with elastic feet and tabulated flights, and its steps. `feet_of_points`: legs, or -1."""
    scene, material = case.scene, case.design.material
    of_legs = [feet.corner_contact(scene, limb, material) for limb in case.design.limbs]
    H, wall = mobility(walker), walker.wall_distance != 0.0
    # Walls and lid are as stiff as the first leg's corners
    of_points = [of_legs[max(number, 0)] for number in feet_of_points]
    wall_ratio = feet.damping_ratio(scene.arena.wall_restitution)
    ratio = np.where(wall, wall_ratio, np.array([foot.damping_ratio for foot in of_points]))
    # Restitution is that of a frictionless impact: there is no tangential damper
    own = np.diag(H)[0::3]
    walker = walker._replace(
        spring=np.array([foot.spring for foot in of_points]),
        tip=np.array([foot.tip for foot in of_points]),
        shear=np.full(len(of_points), scene.feet.tangential_ratio),
        damper=2.0 * ratio / np.sqrt(np.where(own > 0.0, own, np.inf)),
    )
    period = 2.0 * math.pi / scene.drive.omega
    landing_speed = feet.LANDING_SPEED_RATIO * case.equivalent_drive.peak_speed
    own_step = _resolving_step(walker, H, landing_speed, MAX_STEP_PERIODS * period)
    if scene.run.step_us is None and _keeps_energy(walker, landing_speed, period):
        drop_speed = math.sqrt(2.0 * GRAVITY * LOSSLESS_DROP_MM)
        own_step = LOSSLESS_STEP_RATIO * _resolving_step(walker, H, drop_speed, MAX_STEP_PERIODS * period)
    step = _choose_step(scene.run.step_us, own_step)
    frame = min(FRAME_STEPS, max(round(MAX_FRAME_PERIODS * period / own_step), 1))
    flights = _flight_propagators(walker, step, len(walker.stiffness), period)
    return walker._replace(flights=flights), Options(step, frame)


def _resolving_step(walker: Walker, H: Array, speed: float, longest: float) -> float:
    """Return the step (s), at most `longest`, that resolves feet that land at a speed (mm/s).

    `H`: mobility of all contacts, shape (3 k, 3 k), 1/g.
    """
    corners = np.flatnonzero(walker.wall_distance == 0.0)
    share = walker.mass / len(corners)
    pressed = np.array([feet.landing_stiffness(tip, share, speed) for tip in walker.tip[corners]])
    stiff = 1.0 / (1.0 / walker.spring[corners] + 1.0 / pressed)
    sideways = np.concatenate([3 * corners + 1, 3 * corners + 2])
    up = math.sqrt(_largest_eigenvalue(H[np.ix_(3 * corners, 3 * corners)], stiff))
    slip = math.sqrt(_largest_eigenvalue(H[np.ix_(sideways, sideways)], np.tile(walker.shear[corners] * stiff, 2)))
    # Eq. 7.12: 0.23 / omega of the landing, and the fastest modes of all feet
    own = min(MAX_STEP_PHASE / math.sqrt(stiff.max() / share), MAX_STEP_PHASE_UP / up, MAX_STEP_PHASE_SIDEWAYS / slip)
    # An overdamped corner settles in its damper's time, 1 / (2 zeta omega)
    damped = walker.damper[corners] * np.sqrt(np.diag(H)[3 * corners])
    own /= max(1.0, float(damped.max()))
    return _round_step(min(own, max(longest, MIN_STEP_RATIO * own)), longest)


def _keeps_energy(walker: Walker, speed: float, period: float) -> bool:
    """Return whether nothing gives or takes energy: no friction, no dampers, and a plate at rest.

    `speed` is that of a landing on the moving plate, mm/s, and `period` that of the plate, s.
    """
    takes_none = not (walker.friction.any() or walker.damper.any() or walker.damping.any())
    return takes_none and speed < REST_SPEED_RATIO * GRAVITY * period


def _round_step(step: float, unit: float) -> float:
    """Round a step to six digits of a unit, s. A scaled walker then has the same step to the bit."""
    return unit * float(f"{step / unit:.6g}")


def _largest_eigenvalue(block: Array, factors: Array) -> float:
    """Return the largest eigenvalue of a mobility, shape (m, m), 1/g, times `factors`, shape (m,), g/s^2 or g/s."""
    if np.all(factors == factors[0]):
        return float(factors[0]) * float(np.linalg.eigvalsh(block)[-1])
    square_roots = np.sqrt(factors)
    return float(np.linalg.eigvalsh(square_roots[:, None] * block * square_roots)[-1])


def _choose_step(given_us: float | None, resolving_step: float) -> float:
    """Return the step, s: the scene's `given_us` (us), else `resolving_step` (s). Raises InputError if too long."""
    if given_us is None:
        return resolving_step
    if 1e-6 * given_us > MAX_STEP_RATIO * resolving_step:
        raise InputError(
            f"run.step_us = {given_us:g}: longer than a contact of these feet. Give at most "
            f"{1e6 * MAX_STEP_RATIO * resolving_step:.3g}, or leave the key out ({1e6 * resolving_step:.3g})."
        )
    return 1e-6 * given_us


def coarser(world: World, factor: float) -> World:
    """Return the world with steps `factor` times longer, and flights tabulated for these steps."""
    walker, step = world.walker, factor * world.options.step
    flights = _flight_propagators(walker, step, len(walker.stiffness), world.drive.period)
    return world._replace(walker=walker._replace(flights=flights), options=world.options._replace(step=step))


def mobility(walker: Walker) -> Array:
    """Return the inverse mass of all contacts of a level, relaxed walker, shape (3 k, 3 k), 1/g."""
    size = 6 + len(walker.stiffness)
    J = np.zeros((3 * len(walker.leg), size))
    for k, leg in enumerate(walker.leg):
        point = walker.root[k] + [*walker.reach[k], walker.side[k]]
        along, up, across = np.eye(3)
        axes = (across, along, up) if walker.wall_distance[k] > 0.0 else (up, along, across)
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


def _flight_propagators(walker: Walker, step: float, n: int, period: float) -> Array:
    """Return propagators of n coordinates of legs in flights of step 2^i s, shape (HALVINGS + FLIGHT_LEVELS, 2 n, 2 n).

    i begins at -HALVINGS. The unit of time is a power of two near the time in which legs swing by a radian, so that a
    scaled walker has the same bits. `period` is the plate's, s.
    """
    if n == 0:
        return np.zeros((HALVINGS + FLIGHT_LEVELS, 0, 0))
    unit, rates = 2.0 ** math.frexp(period / 512.0)[1], np.zeros((2 * n, 2 * n))
    rates[:n, n:] = np.eye(n)
    rates[n:, :n] = -walker.hinge_mobility * walker.stiffness * unit**2
    rates[n:, n:] = -walker.hinge_mobility * walker.damping * unit
    flights = np.array(
        [matrix_exponential(step / unit * 2.0**level * rates) for level in range(-HALVINGS, FLIGHT_LEVELS)]
    )
    flights[:, :n, n:] *= unit
    flights[:, n:, :n] /= unit
    return flights


def matrix_exponential(matrix: Array) -> Array:
    """Compute the exponential of a small square matrix by a series and repeated squares, as scipy.linalg does.

    Importing scipy.linalg takes a tenth of a simulation's start.
    """
    size = float(np.abs(matrix).sum(axis=0).max())
    squares = max(math.frexp(size / MAX_SERIES_NORM)[1], 0)
    part = matrix / 2.0**squares
    term = found = np.eye(len(matrix))
    for order in range(1, SERIES_TERMS + 1):
        term = term @ part / order
        found = found + term
    for _ in range(squares):
        found = found @ found
    return found
