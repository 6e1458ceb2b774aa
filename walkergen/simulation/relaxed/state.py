"""The relaxed-legs walker (docs/physics.md section 5, model A): its parameters and its points.

A rigid body (x, y, pitch) on two feet fixed to it. The flexible tensor of a foot sets the impulse,
which the body alone receives. A braced walker has no flexible tensors: its rigid tensor sets it.

Pitch turns counter-clockwise; a point d of the body lies at O + r, r = R(pitch) d, and moves at
(v_x - spin r_y, v_y + spin r_x).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import Drive, derivative_bound, height, velocity
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.world import PHASE, PITCH, RIGID_SIZE, SPIN, V_X, V_Y, State, World, X, Y
from walkergen.theory.tensors import InverseMass
from walkergen.theory.tensors import feet as tensors_of
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, from_centre
from walkergen.walker.planar import in_plane

Array = npt.NDArray[np.float64]
Point = tuple[float, float]

# Two entries behind a trial state: plate work and friction loss on the way to it, g mm^2/s^2.
TRIAL_WORK, TRIAL_FRICTION, TRIAL_SIZE = 9, 10, 11


class Tensor(NamedTuple):
    """Symmetric inverse-mass tensor of one foot, 1/g."""

    xx: float
    xy: float
    yy: float


class Walker(NamedTuple):
    """Body on two feet; vectors in mm, in the body's frame, O its centre of mass."""

    mass: float
    """Mass of the body (flexible legs) or of the whole (braced), g."""
    inertia: float
    """Moment of inertia about O of what `mass` counts, g mm^2."""
    feet: tuple[Point, Point]
    """Vectors O -> foot, the back foot first."""
    corners: tuple[Point, Point, Point, Point]
    """Vectors O -> corners of the body: the run ends when a corner touches the plate."""
    safe_pitch: float
    """Below this |pitch| (rad) every corner is higher than the lower foot (`safe_pitch`)."""
    flexible: tuple[Tensor, Tensor] | tuple[None, None]
    """Tensors of the feet (paper, eqs 8-12), at pitch 0, that set impulses; None: the rigid one."""


class Options(NamedTuple):
    """Tolerances, which belong together (`options_for`)."""

    gap_tolerance: float
    """Depth to which a foot may be inside the plate, mm: tens of roundings of its height."""
    snap_speed: float
    """Normal speed (mm/s) below which closed feet stay; above sqrt(2 a gap_tolerance), a speed that
    the tolerance itself can feed (docs/physics.md section 5, trap 2)."""


def options_for(walker: Walker, drive: Drive, gravity: float) -> Options:
    """Tolerances that scale with the sizes of walker and drive and with `gravity` (mm/s^2)."""
    size = max(math.hypot(*point) for point in (*walker.feet, *walker.corners))
    gap = 64 * np.finfo(float).eps * (size + abs(drive.amplitude))
    largest_acceleration = gravity + derivative_bound(drive, 2)
    return Options(gap, 4.0 * math.sqrt(2.0 * largest_acceleration * gap))


def coarser(world: World, factor: float) -> World:
    """World with a gap tolerance `factor` times larger and the snap speed that belongs to it."""
    gap, snap = world.options
    return world._replace(options=Options(factor * gap, math.sqrt(factor) * snap))


def resting(world: World) -> float:
    """Speed (mm/s) below which a foot does not rebound."""
    return float(world.options.snap_speed)


def safe_pitch(feet: tuple[Point, Point], corners: tuple[Point, ...]) -> float:
    """Smallest |pitch| (rad) at which a corner is as low as the lower foot; 0..pi."""
    smallest = math.pi
    for corner in corners:
        for sign in (1.0, -1.0):
            crossings = [math.atan2(corner[1] - foot[1], sign * (foot[0] - corner[0])) for foot in feet]
            smallest = min(smallest, max(crossings))
    return max(smallest, 0.0)


def new(
    mass: float,
    inertia: float,
    feet: tuple[Point, Point],
    corners: tuple[Point, Point, Point, Point],
    flexible: tuple[InverseMass, ...] | None = None,
) -> Walker:
    """Walker from its numbers (g, mm); `flexible`: the back and the front foot's tensor (1/g)."""
    tensors: tuple[Tensor, Tensor] | tuple[None, None] = (None, None)
    if flexible is not None:
        back, front = (Tensor(float(H.xx), float(H.xy), float(H.yy)) for H in flexible)
        tensors = (back, front)
    return Walker(float(mass), float(inertia), feet, corners, safe_pitch(feet, corners), tensors)


def walker_of(design: Design, mass: MassProperties) -> Walker:
    """Walker of one design and its (unbatched) mass properties, on two feet in its plane."""
    flat = in_plane(design, mass)
    size = design.size
    corners = np.array(
        [(x, y) for y in (-0.5 * size.thickness, 0.5 * size.thickness) for x in (-0.5 * size.length, 0.5 * size.length)]
    )
    low_left, low_right, high_left, high_right = ((float(x), float(y)) for x, y in from_centre(design, mass, corners))
    back, front = (leg.anchor + (leg.c_A + leg.c_T) for leg in flat.mass.legs)
    return new(
        float(mass.M),
        float(mass.J),
        ((float(back[0]), float(back[1])), (float(front[0]), float(front[1]))),
        (low_left, low_right, high_left, high_right),
        None if mass.rigid else tensors_of(flat.mass),
    )


def level_pitch(walker: Walker) -> float:
    """Pitch at which both feet stand on the plate, rad."""
    (back_x, back_y), (front_x, front_y) = walker.feet
    return math.atan((back_y - front_y) / (front_x - back_x))


def start(
    world: World, clearance: float, pitch: float = 0.0, phase: float = 0.0, roll: float = 0.0, heading: float = 0.0
) -> State:
    """A state at rest in the laboratory, its lower foot `clearance` (mm) over the plate."""
    walker, state = world.walker, np.zeros(RIGID_SIZE)
    state[PITCH], state[PHASE] = pitch, phase
    sin, cos = math.sin(pitch), math.cos(pitch)
    lower = min(lever(foot, sin, cos)[1] for foot in walker.feet)
    state[Y] = height(world.drive, phase) + clearance - lower
    return state


def energy(world: World, state: State) -> float:
    """Mechanical energy of the relaxed body, g mm^2/s^2."""
    walker = world.walker
    kinetic = walker.mass * (state[V_X] ** 2 + state[V_Y] ** 2) + walker.inertia * state[SPIN] ** 2
    lifted = across(world.acting) * state[Y] - along(world.acting) * state[X]
    return float(0.5 * kinetic + walker.mass * lifted)


def feet(world: World, state: State) -> Array:
    """Places and velocities of the feet, shape (2, 4), as in `Model.feet`."""
    sin, cos, spin = math.sin(state[PITCH]), math.cos(state[PITCH]), state[SPIN]
    ground, rising = height(world.drive, state[PHASE]), velocity(world.drive, state[PHASE])
    rows = []
    for foot in world.walker.feet:
        r_x, r_y = lever(foot, sin, cos)
        place = (state[X] + r_x, state[Y] + r_y - ground)
        rows.append((*place, state[V_X] - spin * r_y, state[V_Y] + spin * r_x - rising))
    return np.array(rows)


def momentum(world: World, state: State) -> float:
    """Momentum of the body along the plate, g mm/s."""
    return float(world.walker.mass * state[V_X])


@kernel
def lever(d: Point, sin: float, cos: float) -> Point:
    """Rotate d into the plate's frame: r = R(pitch) d, from the sine and cosine of the pitch."""
    return d[0] * cos - d[1] * sin, d[1] * cos + d[0] * sin


@kernel
def rigid_tensor(walker: Walker, r: Point) -> Tensor:
    """Rigid inverse-mass tensor at r: I/M + P(r)/J (paper, eq. 4), in the plate's frame, 1/g."""
    return Tensor(
        1.0 / walker.mass + r[1] * r[1] / walker.inertia,
        -r[0] * r[1] / walker.inertia,
        1.0 / walker.mass + r[0] * r[0] / walker.inertia,
    )


@kernel
def levers(walker: Walker, pitch: float) -> tuple[Point, Point]:
    """Vectors from O to the back and the front foot, in the plate's frame."""
    sin, cos = math.sin(pitch), math.cos(pitch)
    return lever(walker.feet[0], sin, cos), lever(walker.feet[1], sin, cos)


@kernel
def impulse_tensor(own, rigid, sin, cos):
    """Tensor that sets the impulse, in the plate's frame: R own R^T; `rigid` if `own` is None."""
    if own is None:
        return rigid
    squares, product = cos * cos - sin * sin, cos * sin
    return Tensor(
        (cos * cos) * own.xx - 2.0 * product * own.xy + (sin * sin) * own.yy,
        product * (own.xx - own.yy) + squares * own.xy,
        (sin * sin) * own.xx + 2.0 * product * own.xy + (cos * cos) * own.yy,
    )
