"""Poses of one run of the 3D simulation at a fixed rate, as movies and pages show them.

Axes as in the simulation: x along the lane, y up, z across, to the right of a walker that heads
along x. A corner is numbered as its point of contact: of every leg in turn left, right.
"""

from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Mask
from walkergen.core.numerics.kernels import kernel
from walkergen.core.simulation import run
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.space.pose import fill_points, plate_height, update_pose
from walkergen.core.simulation.space.state import (
    C_X,
    HEADING,
    HEIGHT,
    MODE,
    OPEN,
    PHASE,
    Q_0,
    Q_Z,
    ROW_LENGTH,
    SHOWN_X,
    SHOWN_Y,
    first_row,
    work_for,
)
from walkergen.core.walker import names


class Poses(NamedTuple):
    """Poses of a run in space, n of them."""

    times: Array
    """Times of the poses, shape (n,), s, from 0."""
    places: Array
    """Positions of the body's centre of mass, shape (n, 3), mm: x and z from the first pose (in a lane,
    z from its middle), y over the plate's mean height."""
    turns: Array
    """Unit quaternions, body axes to world: scalar, x, y, z, shape (n, 4)."""
    heading: Array
    """Heading, counter-clockwise from above, whole turns counted, shape (n,), rad."""
    corners: Array
    """Positions of the c = 2 x legs corners of the feet, shape (n, c, 3), mm."""
    gaps: Array
    """Distances of the corners from the plate, shape (n, c), mm; negative while they press."""
    closed: Mask
    """Whether the corners press on the plate, shape (n, c)."""
    plate: Array
    """Height of the plate over its mean, shape (n,), mm."""
    phase: Array
    """Phase of the drive, shape (n,), rad."""
    landings: Array
    """Landings of the corners, rows as in `record.Events`, in the order of their times."""
    outcome: run.Outcome
    legs: tuple[str, ...]
    """Names of the legs."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the corners of the feet, in the order of their numbers."""
        return tuple(f"{leg} {side}" for leg in self.legs for side in ("left", "right"))

    @property
    def rotations(self) -> Array:
        """Rotation matrices from body axes to world axes, shape (n, 3, 3)."""
        q, i, j, k = self.turns.T
        rows = [
            [1 - 2 * (j * j + k * k), 2 * (i * j - q * k), 2 * (i * k + q * j)],
            [2 * (i * j + q * k), 1 - 2 * (i * i + k * k), 2 * (j * k - q * i)],
            [2 * (i * k - q * j), 2 * (j * k + q * i), 1 - 2 * (i * i + j * j)],
        ]
        return np.moveaxis(np.array(rows), -1, 0)


def sample(plan: Plan, interval: float, number: int = 0) -> Poses:
    """Simulate run `number` of a plan. Return its poses every `interval` seconds, and all landings of feet."""
    result = run.simulate_with_impacts(plan, number, sample_interval=interval)
    world = run.drop_for_run(plan, number)[0].world
    samples = result.tally.samples
    rows = samples.rows[: samples.cursor[0]]
    states = np.ascontiguousarray(rows[:, 1:])
    walker = world.walker
    points, plate = np.empty((len(rows), len(walker.leg), 4)), np.empty(len(rows))
    _fill_points(world, states, points, plate)
    first, modes = first_row(walker), slice(MODE, None, ROW_LENGTH)
    on_plate = np.flatnonzero(walker.wall_distance == 0.0)
    # A run that ended before its first pose has none
    first_x, first_z = states[:1, SHOWN_X].sum(), -states[:1, SHOWN_Y].sum()
    start = np.array([first_x, 0.0, first_z if plan.scene.arena.kind == "plane" else 0.0])
    landings = run.recorded_impacts(result)
    landings = landings[np.isin(landings[:, 1], on_plate)]
    return Poses(
        times=rows[:, 0],
        places=np.column_stack([states[:, SHOWN_X], states[:, HEIGHT], -states[:, SHOWN_Y]]) - start,
        turns=states[:, Q_0 : Q_Z + 1],
        heading=states[:, HEADING],
        corners=points[:, on_plate, :3] - start,
        gaps=points[:, on_plate, 3],
        closed=states[:, first:][:, modes][:, on_plate] != OPEN,  # states end with rows of the contacts
        plate=plate,
        phase=states[:, PHASE],
        landings=landings[np.argsort(landings[:, 0], kind="stable")],
        outcome=result.outcome,
        legs=names.leg_names(plan.case.design),
    )


@kernel
def _fill_points(world, states, points, plate):
    """Fill `points` and `plate` with contact points and heights of the plate, mm, in n states.

    `points`: shape (n, contacts, 4) for x, y, z and the gap to the plate. `plate`: shape (n,).
    """
    for i in range(len(states)):
        state = states[i].copy()
        work = work_for(world.walker, state)
        update_pose(world, state, work)
        fill_points(world, state, work)
        plate[i] = plate_height(world, state)
        for k in range(points.shape[1]):
            for axis in range(3):
                total = state[C_X + axis]
                for j in range(3):
                    total += work.R[axis, j] * work.points[k].at[j]
                points[i, k, axis] = total
            points[i, k, 3] = work.points[k].gap
