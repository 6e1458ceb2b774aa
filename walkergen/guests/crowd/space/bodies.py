"""Input of the kernels for a crowd: its walkers, the shapes of their bodies, the ground, the contact law."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core import Array, Dish, Whole
from walkergen.core.simulation.record import Tally
from walkergen.core.simulation.space.state import Work, work_for
from walkergen.core.simulation.world import State, World
from walkergen.guests.crowd.space.shape import Shape, common_heights

DISC, RING, RECTANGLE, PERIODIC, ENDLESS = range(5)
"""Kinds of ground, by numbers."""

GROUND_NUMBERS = {"disc": DISC, "ring": RING, "rectangle": RECTANGLE, "periodic": PERIODIC}

X, Z, COS, SIN, LEAN_X, LEAN_Z, SPEED, LIFTED = range(8)
"""Columns of `Crowd.planar`, the top view of a body: position of C shifted by the deflection of the legs (mm), cosine
and sine of the heading, shift of a point per millimetre of its height if the body leans, upper bound of a point's
speed (mm/s), and vertical velocity of plate and walls (mm/s)."""

TOUCHES, DEEPEST, WORK, STORED, LOST, RUBBED, LATE, PRESSED, ALONG, UP = range(10)
"""Rows of `Crowd.book`, sums over all contacts: touches begun; largest compression (mm); work done on walkers along
the normal, energy stored now, loss along the normal by restitution, loss to friction (g mm^2/s^2); touches first seen
deeper than a tick explains; impulses along the normal, of friction in the plane and up or down (g mm/s)."""


class Mover(NamedTuple):
    """Data of one walker of a crowd for the kernels that move a single walker."""

    world: World
    state: State
    work: Work
    tally: Tally


class Free(NamedTuple):
    """Data of all N walkers that impulses change or read. The arrays share memory with the movers.

    n: largest number of leg coordinates of a walker; arrays of walkers with fewer are filled up.
    """

    state: Array
    """States, shape (N, s)."""
    sums: Array
    """`Tally.sums`, shape (N, 14)."""
    R: Array
    """Body axes -> world, shape (N, 3, 3)."""
    now: Array
    """Velocities of C and turning rates, body axes, shape (N, 6)."""
    coordinates: Whole
    """Number of leg coordinates of each walker, shape (N,)."""
    inverse_mass: Array
    """1/g, shape (N,)."""
    inverse_inertia: Array
    """In body axes, 1/(g mm^2), shape (N, 3, 3)."""
    shift: Array
    lock: Array
    """`shift` and `lock` are those of `space.state.Walker`, shape (N, 3, n)."""
    hinge_mobility: Array
    """Of the leg coordinates, as in `space.state.Walker`, shape (N, n, n)."""


class Bodies(NamedTuple):
    """Shapes of all kinds, one after the other."""

    kind: Whole
    """Kind of each walker, shape (N,)."""
    first: Whole
    """First corner of each kind, shape (kinds + 1,)."""
    first_edge: Whole
    corners: Array
    """Shape (v, 2), from C: forward, to the right, mm."""
    edges: Whole
    """Shape (e, 2), numbers of corners."""
    radius: Array
    reach: Array
    """Rounding radius of the core, and distance of the farthest point from C, of each kind, shape (kinds,), mm."""
    heights: Array
    """Lowest and highest height over C (mm) at which kind i meets kind j, shape (kinds, kinds, 2)."""
    ends: Array
    """Heights of bottom and top over C, shape (kinds, 2), mm."""
    box: Array
    """Middle x, z and half sizes along x, z of the core's bounding box, shape (kinds, 4), mm."""


class Ground(NamedTuple):
    """Dish of a crowd; lengths in mm."""

    kind: int
    outer: float
    """Radius of a disc or ring; half the length of a rectangle; half the side of a square."""
    inner: float
    """Inner radius of a ring; half the width of a rectangle."""
    period: float


class Law(NamedTuple):
    """Contact laws of bodies with bodies (first) and walls (second)."""

    spring: float
    """Stiffness of either end of an upright edge over the mass that it moves, 1/s^2."""
    kept: tuple[float, float]
    """Share of the normal work that a contact gives back: restitution squared."""
    friction: tuple[float, float]
    margin: float
    """Largest change of a body's speed by a landing before its gaps are updated, mm/s."""
    tick: float
    """Longest time step of contacts, s."""


class Crowd(NamedTuple):
    """A crowd in motion."""

    movers: Any
    """Typed list of `Mover`, length N."""
    free: Free
    bodies: Bodies
    ground: Ground
    law: Law
    planar: Array
    """Top view of the bodies, shape (N, 8)."""
    status: Whole
    """Status of `world` of each walker, shape (N,); a walker that is not OK lies where it fell."""
    touching: npt.NDArray[np.uint8]
    """1 where i and j > i touch, and on the diagonal i and a wall, shape (N, N)."""
    book: Array
    """Sums over contacts, rows TOUCHES to UP, shape (10,)."""
    tick: Array
    """Time step of contacts now, shape (1,), s."""


def make_bodies(kinds: Sequence[int], shapes: tuple[Shape, ...]) -> Bodies:
    """Return the shapes of all kinds as arrays for kernels. `kinds`: index in `shapes` of each walker."""
    first = np.cumsum([0, *(len(shape.corners) for shape in shapes)])
    edges = [shape.edges + start for shape, start in zip(shapes, first, strict=False)]
    return Bodies(
        np.array(kinds, np.int64),
        first,
        np.cumsum([0, *(len(part) for part in edges)]),
        np.vstack([shape.corners for shape in shapes]),
        np.vstack(edges),
        np.array([shape.radius for shape in shapes]),
        np.array([shape.reach for shape in shapes]),
        common_heights(shapes),
        np.array([(shape.bottom, shape.top) for shape in shapes]),
        np.array([_bounding_box(shape.corners) for shape in shapes]),
    )


def _bounding_box(corners: Array) -> Array:
    """Return middle x, z and half sizes along x, z of the bounding box of `corners`, shape (4,), mm."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    return np.concatenate([0.5 * (low + high), 0.5 * (high - low)])


def make_ground(dish: Dish | None) -> Ground:
    """Make the ground of a dish; None gives an endless plane."""
    if dish is None:
        return Ground(ENDLESS, 0.0, 0.0, 0.0)
    inner = dish.sizes[1] if len(dish.sizes) > 1 else 0.0
    return Ground(GROUND_NUMBERS[dish.kind], 0.5 * dish.sizes[0], 0.5 * inner, dish.period)


def make_movers(worlds: Sequence[World], states: Sequence[State], tallies: Sequence[Tally]) -> tuple[list[Mover], Free]:
    """Return the movers of walkers, and arrays over all walkers that share memory with the movers."""
    count = len(worlds)
    max_coordinates = max(len(world.walker.stiffness) for world in worlds)
    free = Free(
        np.zeros((count, max(map(len, states)))),
        np.zeros((count, 14)),
        np.zeros((count, 3, 3)),
        np.zeros((count, 6)),
        np.zeros(count, np.int64),
        np.zeros(count),
        np.zeros((count, 3, 3)),
        np.zeros((count, 3, max_coordinates)),
        np.zeros((count, 3, max_coordinates)),
        np.zeros((count, max_coordinates, max_coordinates)),
    )
    movers = []
    for i, (world, state, tally) in enumerate(zip(worlds, states, tallies, strict=True)):
        walker, n = world.walker, len(world.walker.stiffness)
        free.state[i, : len(state)], free.sums[i] = state, tally.sums
        free.coordinates[i], free.inverse_mass[i] = n, walker.inverse_mass[0]
        free.inverse_inertia[i] = walker.inverse_inertia
        free.shift[i, :, :n], free.lock[i, :, :n] = walker.shift, walker.lock
        free.hinge_mobility[i, :n, :n] = walker.hinge_mobility
        work = work_for(walker, state)._replace(R=free.R[i], now=free.now[i])
        own_state = free.state[i, : len(state)]
        movers.append(Mover(world, own_state, work, tally._replace(sums=free.sums[i])))
    return movers, free
