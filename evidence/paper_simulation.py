"""The paper's own model (its figure 4): a body in a plane whose legs relax instantly after each impact.

The flexible tensor of a foot (`tensors`) sets the impulse of an impact by the law of `impact`; the body alone receives
it, M dv = F, J dOmega = d x F. A foot that still approaches is struck again at the same instant, until it leaves or its
approach dies out below `World.snap` and it is closed. Flight is ballistic; its landings are found with a guarantee. A
plastic impact of the rigid body keeps a closed foot on the plate at every step of lasting contact, held or sliding; two
closed feet are carried by the plate; a foot that is not pressed opens (docs/physics.md section 5).

Limits. Lasting contact has errors of its step: speeds of the paper's walker are within 0.1 mm/s of exact contact.
While one foot is closed, another that leaves the plate for less than a step stays closed. Legs lighter than about 1e-4
of the body need more impacts than `MAX_IMPACTS`. If H_rigid > H_flexible, impacts can gain energy, which ends a run.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.drive import GRAVITY
from walkergen.core.numerics.kernels import kernel
from walkergen.core.scene import Scene
from walkergen.core.theory import tensors as inverse_mass
from walkergen.core.theory.impact import impact
from walkergen.core.theory.stationary import project_to_plane
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, to_centre_frame

Array = npt.NDArray[np.float64]
Point = tuple[float, float]

X, Y, PITCH, V_X, V_Y, SPIN, PHASE, BACK, FRONT, CONTACT_S = range(10)
"""Entries of a state: place of the centre of mass O, pitch (rad, counter-clockwise), rates; the plate's phase; 1.0 for
each closed foot; time with one."""

OK, FALLEN, ENDLESS = range(3)
"""Statuses of `advance`: ran to the end; pitched beyond `World.steepest`; impacts without end or bound."""

CONTACT_STEPS = 4000
"""Steps of lasting contact in a period of the plate."""

MAX_IMPACTS, MAX_STEPS, MAX_TRIALS = 1_000_000, 1_000_000, 60
MAX_SIMULTANEOUS_LANDINGS, INSTANT = (
    1000,
    1e-12,
)  # landings in a row that lie so close (rad of the plate) that no time passes
# Height, in tolerances, below which a foot takes part in a landing; speed of a runaway over that of plate and fall.
NEAR, RUNAWAY = 16.0, 1e3


class World(NamedTuple):
    """Walker, plate and contact; lengths in mm, vectors from O in the body's frame, the back foot first."""

    mass: float
    """Mass of the body alone, or of the whole where legs are rigid, g."""
    inertia: float
    """Moment of inertia about O of what `mass` counts, g mm^2."""
    feet: tuple[Point, Point]
    tensors: tuple[tuple[float, float, float], tuple[float, float, float]]
    """Entries xx, xy, yy (1/g) of the tensors that set the impulses, at pitch 0."""
    steepest: float
    """Pitch (rad) beyond which the walker has fallen."""
    amplitude: float
    omega: float
    restitution: float
    friction: float
    tolerance: float
    """Largest depth of a foot inside the plate, mm: tens of roundings of its height."""
    snap: float
    """Normal speed (mm/s) below which a foot on the plate stays: what the tolerance itself can feed, four times."""


class Run(NamedTuple):
    """Result of one run: mean speed over the measured time (mm/s), status of `advance`, landings."""

    speed: float
    status: int
    impacts: Array
    """Landings of feet, rows of t (s), foot (0 back, 1 front), F_x, F_y (g mm/s) of all impacts at that instant, v_x,
    v_y before (mm/s), type of the first (`impact.Kind`)."""


def body_world(
    mass: float,
    inertia: float,
    feet: tuple[Point, Point],
    scene: Scene,
    tensors: tuple[inverse_mass.InverseMass, ...] | None = None,
    corners: tuple[Point, ...] = (),
) -> World:
    """Return the world of a body on two feet (g, mm) and the plate and contact of a scene.

    `tensors` set the impulses of the back and the front foot, the rigid body's without them. A body without `corners`
    never falls.
    """
    amplitude, omega = scene.drive.amplitude, scene.drive.omega
    if tensors is None:
        tensors = tuple(inverse_mass.rigid_tensor(mass, inertia, np.asarray(foot)) for foot in feet)
    back, front = ((float(H.xx), float(H.xy), float(H.yy)) for H in tensors)
    tolerance = 64 * np.finfo(float).eps * (max(math.hypot(*point) for point in (*feet, *corners)) + amplitude)
    snap = 4.0 * math.sqrt(2.0 * (GRAVITY + amplitude * omega**2) * tolerance)
    contact = scene.contact.restitution, scene.contact.friction
    return World(
        mass, inertia, feet, (back, front), _max_pitch(feet, corners), amplitude, omega, *contact, tolerance, snap
    )


def walker_world(scene: Scene, design: Design, mass: MassProperties) -> World:
    """Return the world of a walker on two feet in its plane, with its legs' own tensors."""
    flat, size = project_to_plane(design, mass), design.size
    ends = np.array([(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * (size.length, size.thickness)
    corners = tuple((float(x), float(y)) for x, y in to_centre_frame(design.limbs, mass, ends))
    back, front = ((float(x), float(y)) for x, y in (leg.foot for leg in flat.mass.legs))
    return body_world(float(mass.M), float(mass.J), (back, front), scene, inverse_mass.foot_tensors(flat.mass), corners)


def initial_state(world: World, clearance: float, pitch: float = 0.0, phase: float = 0.0) -> Array:
    """Return a state at rest in the laboratory, its lower foot `clearance` (mm) over the plate."""
    state = np.zeros(CONTACT_S + 1)
    state[PITCH], state[PHASE] = pitch, phase
    lower = min(x * math.sin(pitch) + y * math.cos(pitch) for x, y in world.feet)
    state[Y] = world.amplitude * math.sin(phase) + clearance - lower
    return state


def energy(world: World, state: Array) -> float:
    """Return the mechanical energy of a state, g mm^2/s^2."""
    moving = 0.5 * (state[V_X] ** 2 + state[V_Y] ** 2)
    return float(world.mass * (moving + GRAVITY * state[Y]) + 0.5 * world.inertia * state[SPIN] ** 2)


def simulate(scene: Scene, design: Design, mass: MassProperties) -> list[Run]:
    """Simulate the runs of a scene: drops from 0.5 to 1.5 amplitudes at random phases, pitched by up to 1 mrad."""
    world, run, runs = walker_world(scene, design, mass), scene.run, list[Run]()
    for number in range(run.runs):
        random = np.random.default_rng([run.seed, number])
        clearance, pitch, phase = random.uniform((0.5, -1e-3, 0.0), (1.5, 1e-3, 2.0 * math.pi))
        state = initial_state(world, clearance * world.amplitude, pitch, phase)
        status, _ = advance(world, state, run.discard_seconds)
        began, impacts = state[X], np.zeros((0, 7))
        if status == OK:
            status, impacts = advance(world, state, run.seconds)
        runs.append(Run(float(state[X] - began) / run.seconds, status, impacts))
    return runs


def advance(world: World, state: Array, seconds: float) -> tuple[int, Array]:
    """Advance a state in place; return a status and the landings, rows as in `Run.impacts`."""
    began, room = state.copy(), 256 + int(20.0 * seconds * world.omega / math.tau)
    while True:
        rows = np.zeros((room, 7))
        status, count = _advance(world, state, seconds, rows)
        if count <= room:
            return int(status), rows[:count]
        state[:], room = began, count


def _max_pitch(feet: tuple[Point, Point], corners: tuple[Point, ...]) -> float:
    """Return the smallest |pitch| (rad) at which a corner is as low as the lower foot; infinite without corners."""
    pitches = (
        max(math.atan2(y - foot[1], sign * (foot[0] - x)) for foot in feet) for x, y in corners for sign in (1.0, -1.0)
    )
    return max(min(pitches, default=math.inf), 0.0)


@kernel
def _advance(world: World, state: Array, seconds: float, rows: Array) -> tuple[int, int]:
    """Advance a state in place; fill `rows` as far as they go; return a status and the number of landings."""
    t, count, at_once, before = 0.0, 0, 0, np.empty_like(state)
    while t < seconds:
        landing = np.zeros(2, np.bool_)
        if state[BACK] + state[FRONT] > 0.0:
            dt = _hold(world, state, min(2.0 * math.pi / world.omega / CONTACT_STEPS, seconds - t), before, landing)
            state[CONTACT_S] += dt
        else:
            dt = _fly(world, state, seconds - t, landing)
        t += dt
        at_once = at_once + 1 if dt * world.omega < INSTANT else 0
        if abs(state[PITCH]) > world.steepest:
            return FALLEN, count
        if landing[0] or landing[1]:
            ended, count = _land(world, state, t, landing, rows, count)
            if not ended or at_once > MAX_SIMULTANEOUS_LANDINGS:
                return ENDLESS, count
    return OK, count


@kernel
def _lever(world, foot, pitch):
    """Return the vector O -> foot in the plate's frame, mm."""
    x, y = world.feet[foot]
    return x * math.cos(pitch) - y * math.sin(pitch), y * math.cos(pitch) + x * math.sin(pitch)


@kernel
def _rigid_tensor(mass, inertia, r):
    """Return the entries xx, xy, yy of the rigid tensor at r (paper, eq. 4), 1/g."""
    return 1.0 / mass + r[1] * r[1] / inertia, -r[0] * r[1] / inertia, 1.0 / mass + r[0] * r[0] / inertia


@kernel
def _rotate_tensor(own, pitch):
    """Return the entries of a tensor at pitch 0 turned into the plate's frame, R own R^T."""
    sin, cos = math.sin(pitch), math.cos(pitch)
    xx, xy, yy = own
    return (
        cos * cos * xx - 2.0 * cos * sin * xy + sin * sin * yy,
        cos * sin * (xx - yy) + (cos * cos - sin * sin) * xy,
        sin * sin * xx + 2.0 * cos * sin * xy + cos * cos * yy,
    )


@kernel
def _drift(world, state, dt):
    """Move a state in place through `dt` seconds of flight."""
    state[X] += dt * state[V_X]
    state[Y] += dt * (state[V_Y] - 0.5 * GRAVITY * dt)
    state[PITCH] += dt * state[SPIN]
    state[V_Y] -= GRAVITY * dt
    state[PHASE] = (state[PHASE] + world.omega * dt) % (2.0 * math.pi)


@kernel
def _gap(world, state, foot, t=0.0):
    """Return the height of a foot over the plate (mm) and its rate after `t` seconds of flight."""
    r_x, r_y = _lever(world, foot, state[PITCH] + state[SPIN] * t)
    phase = state[PHASE] + world.omega * t
    height = state[Y] + t * (state[V_Y] - 0.5 * GRAVITY * t) + r_y - world.amplitude * math.sin(phase)
    rate = state[V_Y] - GRAVITY * t + state[SPIN] * r_x - world.amplitude * world.omega * math.cos(phase)
    return height, rate


@kernel
def _fly(world, state, limit, landing):
    """Fly to the first landing within `limit` s; mark the feet that land; return the time flown.

    With a bound of a gap's second derivative each gap has a time before which it cannot close. Steps of such times
    cannot jump over a landing, and approach it to second order.
    """
    t = 0.0
    for _ in range(MAX_STEPS):
        wait = limit - t
        for foot in range(2):
            gap, rate = _gap(world, state, foot, t)
            landing[foot] = gap <= 0.0 and rate < 0.0
            bound = GRAVITY + world.amplitude * world.omega**2
            bound += state[SPIN] ** 2 * math.hypot(world.feet[foot][0], world.feet[foot][1])
            margin = max(gap, 0.0) + world.tolerance
            root = math.sqrt(rate * rate + 2.0 * bound * margin)
            wait = min(wait, 2.0 * margin / (root - rate) if rate < 0.0 else (rate + root) / bound)
        if landing[0] or landing[1] or t >= limit:
            break
        t += wait
    _drift(world, state, t)
    return t


@kernel
def _land(world, state, t, landing, rows, count):
    """Strike the feet on the plate, at one instant, until none approaches; (True if that ends, number of landings)."""
    usual = world.amplitude * world.omega + math.sqrt(GRAVITY * math.hypot(world.feet[0][0], world.feet[0][1]))
    noted, ended = np.zeros((2, 7)), False
    for foot in range(2):
        landing[foot] = landing[foot] or _gap(world, state, foot)[0] <= NEAR * world.tolerance
    for _ in range(MAX_IMPACTS):
        ended = not _strike(world, state, landing, noted)
        if ended or abs(state[V_X]) + abs(state[V_Y]) > RUNAWAY * usual:
            break
    _close(world, state, landing)
    for foot in range(2):
        if noted[foot, 6] != 0.0:
            if count < rows.shape[0]:
                rows[count] = noted[foot]
                rows[count, 0], rows[count, 1] = t, foot
            count += 1
    return ended, count


@kernel
def _close(world, state, landing):
    """Close the landed feet that neither approach nor leave; with one closed, also a foot that falls back in a step."""
    back, front = abs(_gap(world, state, 0)[1]), abs(_gap(world, state, 1)[1])
    slow = 2.0 * math.pi / world.omega / CONTACT_STEPS * (GRAVITY + world.amplitude * world.omega**2)
    least = slow if landing[0] and landing[1] and min(back, front) <= world.snap else world.snap
    state[BACK] = 1.0 if landing[0] and back <= least else 0.0
    state[FRONT] = 1.0 if landing[1] and front <= least else 0.0
    if state[BACK] + state[FRONT] == 2.0:
        state[V_Y], state[SPIN] = world.amplitude * world.omega * math.cos(state[PHASE]), 0.0


@kernel
def _strike(world, state, landing, noted):
    """Strike each landing foot until it no longer approaches; return True if one was struck.

    Impulses of simultaneous feet follow from the velocity before and are scaled. The pair thus gains no energy that
    each alone does not, and a mirror image stays one. Rows of `noted` take the impulses of a foot, and velocity and
    type before the first of them.
    """
    v_x, v_y, spin, alone, struck = 0.0, 0.0, 0.0, 0.0, 0
    for foot in range(2):
        rate = _gap(world, state, foot)[1]
        if landing[foot] and rate < -world.snap:
            r_x, r_y = _lever(world, foot, state[PITCH])
            slip = state[V_X] - state[SPIN] * r_y
            F_x, F_y, kind = _sequence(world, foot, (r_x, r_y), state[PITCH], slip, rate)
            if noted[foot, 6] == 0.0:
                noted[foot, 4], noted[foot, 5], noted[foot, 6] = slip, rate, kind
            noted[foot, 2] += F_x
            noted[foot, 3] += F_y
            torque = r_x * F_y - r_y * F_x
            alone += (F_x**2 + F_y**2) / world.mass + torque**2 / world.inertia
            v_x, v_y, spin = v_x + F_x / world.mass, v_y + F_y / world.mass, spin + torque / world.inertia
            struck += 1
    scale = 1.0
    if struck == 2:
        scale = alone / (world.mass * (v_x**2 + v_y**2) + world.inertia * spin**2)
    state[V_X] += scale * v_x
    state[V_Y] += scale * v_y
    state[SPIN] += scale * spin
    return struck > 0


@kernel
def _sequence(world, foot, r, pitch, v_x, v_y):
    """Compute the impulse (g mm/s) of one foot's impacts at one instant, and the type of the first.

    The flexible tensor sets each impulse, the rigid tensor the velocity after it.
    """
    own, rigid = _rotate_tensor(world.tensors[foot], pitch), _rigid_tensor(world.mass, world.inertia, r)
    F_x, F_y, kind = 0.0, 0.0, 0
    for _ in range(MAX_IMPACTS):
        hit = impact(own[0], own[1], own[2], v_x, v_y, world.restitution, world.friction)
        kind = hit.kind if kind == 0 else kind
        F_x, F_y = F_x + hit.F_x, F_y + hit.F_y
        v_x += rigid[0] * hit.F_x + rigid[1] * hit.F_y
        v_y += rigid[1] * hit.F_x + rigid[2] * hit.F_y
        if v_y >= -world.snap:
            break
    return F_x, F_y, kind


@kernel
def _hold(world, state, step, before, landing):
    """Move a walker with closed feet by `step` s or to the landing of the other foot; return the time moved."""
    other, both = 0 if state[BACK] == 0.0 else 1, state[BACK] + state[FRONT] == 2.0
    above, rate = _gap(world, state, other)
    if not both and above <= 0.0 and rate < 0.0:
        landing[other] = True
        return 0.0
    before[:], dt = state, step
    for _ in range(MAX_TRIALS):
        _press(world, state, dt)
        gap, rate = _gap(world, state, other)
        landing[other] = not both and gap < 0.0 and rate < 0.0
        if not landing[other] or above <= 0.0 or gap >= -NEAR * world.tolerance:
            break
        dt *= above / (above - gap)
        state[:] = before
    return dt


@kernel
def _press(world, state, dt):
    """Move a walker with closed feet by `dt` s in place; a foot that is not pressed opens."""
    _drift(world, state, dt)
    v_x, spin = state[V_X], state[SPIN]
    if state[BACK] + state[FRONT] == 2.0:
        _stand(world, state)
    if state[BACK] + state[FRONT] == 1.0:
        _pivot(world, state, 0 if state[BACK] > 0.0 else 1)
    # The forces acted over the whole step: their impulses moved the body by half of it.
    state[X] += 0.5 * dt * (state[V_X] - v_x)
    state[PITCH] += 0.5 * dt * (state[SPIN] - spin)
    if state[BACK] + state[FRONT] > 0.0:
        state[Y] -= _gap(world, state, 0 if state[BACK] > 0.0 else 1)[0]


@kernel
def _stand(world, state):
    """Let the plate carry a body on both feet, which may slide; open those whose normal force would pull."""
    normal = world.mass * (world.amplitude * world.omega * math.cos(state[PHASE]) - state[V_Y])
    along = -world.mass * state[V_X]
    along = math.copysign(min(abs(along), world.friction * max(normal, 0.0)), along)
    back, front = _lever(world, 0, state[PITCH]), _lever(world, 1, state[PITCH])
    on_front = (back[1] * along - back[0] * normal) / (front[0] - back[0])  # torques about O balance
    state[BACK], state[FRONT] = 1.0 if on_front < normal else 0.0, 1.0 if on_front > 0.0 else 0.0
    if state[BACK] + state[FRONT] == 2.0:
        state[V_X] += along / world.mass
        state[V_Y] += normal / world.mass


@kernel
def _pivot(world, state, foot):
    """Keep one foot on the plate, held or sliding, by a plastic impact of the rigid body; open it if it rises."""
    r_x, r_y = _lever(world, foot, state[PITCH])
    H = _rigid_tensor(world.mass, world.inertia, (r_x, r_y))
    slip, rate = state[V_X] - state[SPIN] * r_y, _gap(world, state, foot)[1]
    hit = impact(H[0], H[1], H[2], slip, rate, 0.0, world.friction)
    state[BACK + foot] = 1.0 if hit.kind != 0 else 0.0
    state[V_X] += hit.F_x / world.mass
    state[V_Y] += hit.F_y / world.mass
    state[SPIN] += (r_x * hit.F_y - r_y * hit.F_x) / world.inertia
