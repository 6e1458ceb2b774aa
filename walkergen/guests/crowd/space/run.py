"""One run of a crowd: walkers released at their places, the discarded start, then the record.

Runs and walkers draw from their own random streams (seed, run, walker), the first as a single walker: results are the
same bits on any number of threads. All walkers are on one plate.
"""

import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Arena, Array, Design, InputError, MassProperties, Outcome, Plan, Scene
from walkergen.core import prepare as prepare_walker
from walkergen.core.numerics import kernels
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import sway
from walkergen.core.simulation.run import MAX_BLOCKS, PERIODS_PER_BLOCK, STATUS_OUTCOMES, sample_drop
from walkergen.core.simulation.space.model import energy, turn_to
from walkergen.core.simulation.space.pose import update_pose
from walkergen.core.simulation.space.state import C_X, C_Z, PHASE, TRAJECTORY_COLUMNS, work_for
from walkergen.core.simulation.world import OK, State, World
from walkergen.guests.crowd.space import bodies, steps
from walkergen.guests.crowd.space.result import CrowdRun, Impulses
from walkergen.guests.crowd.space.shape import Shape, make_shape

CONTACT_TIME_S = 1e-3 * 0.6
"""Contact time (s) of a corner and a face without restitution (docs/physics.md section 9)."""

MIN_TICKS_PER_TOUCH = 13.0
"""Minimum number of ticks in a touch: the loss in a crowd's contacts is then 1 to 3 % off the restitution's, and
half of that with double the ticks."""

Walkers = list[tuple[World, State]]
"""World and state of each walker."""


class CrowdPlan(NamedTuple):
    """Crowd that is ready to run: scene, kinds of walkers, initial poses, contact law and ground."""

    scene: Scene
    plans: tuple[Plan, ...]
    """Plan of each kind of walker."""
    shapes: tuple[Shape, ...]
    names: tuple[str, ...]
    kinds: tuple[int, ...]
    """Kind of each walker, length N."""
    places: Array
    """Initial positions x, y (mm) of the centres of mass C, and headings (rad), shape (N, 3)."""
    law: bodies.Law
    ground: bodies.Ground


def plane_scene(scene: Scene) -> Scene:
    """Return a scene in which a crowd's walkers are free to turn: a plane, with the lid and the walls of its arena.

    Raises InputError for a plate that sways, and for initial headings, which a crowd draws at random.
    """
    if scene.run.heading_deg != (0.0,):
        raise InputError("run.heading_deg: a crowd draws its headings at random. Leave the key out.")
    sway.check_still_plate(scene, "a crowd needs a plate that moves up and down equally everywhere")
    kept = scene.arena.model_dump(include={"lid_mm", "wall_friction", "wall_restitution"})
    return scene.model_copy(update={"arena": Arena(kind="plane", **kept)})


def prepare(
    scene: Scene,
    designs: Sequence[tuple[Design, MassProperties]],
    kinds: Sequence[int],
    places: Array,
    endless: bool = False,
) -> CrowdPlan:
    """Make a crowd's plan: walker i is `designs[kinds[i]]`, released with O at `places[i]`: x, y (mm), heading (rad).

    `endless` removes the scene's dish. Raises InputError if a scene or a design contradicts the model in space.
    """
    flat = plane_scene(scene)
    plans = tuple(prepare_walker(flat, design, mass) for design, mass in designs)
    shapes = tuple(
        make_shape(design, mass, plan.world.walker) for (design, mass), plan in zip(designs, plans, strict=True)
    )
    return CrowdPlan(
        flat,
        plans,
        shapes,
        tuple(design.name for design, _ in designs),
        tuple(kinds),
        _centre_places(places, [plans[kind] for kind in kinds]),
        _contact_law(flat, plans),
        bodies.make_ground(None if endless else scene.crowd.dish),
    )


def _centre_places(places: Array, walker_plans: Sequence[Plan]) -> Array:
    """Return poses of centres of mass from poses of origins O: x, y (mm) and heading (rad), shape (N, 3)."""
    centres = np.asarray(places, float).copy()
    for row, plan in zip(centres, walker_plans, strict=True):
        forward, left = -plan.world.walker.centre[0], plan.world.walker.centre[2]
        c, s = math.cos(row[2]), math.sin(row[2])
        row[:2] += c * forward - s * left, s * forward + c * left
    return centres


def _contact_law(scene: Scene, plans: Sequence[Plan]) -> bodies.Law:
    """Return the contact law with its time step, a power of two times the walkers' own step."""
    step = min(plan.world.options.step for plan in plans)
    tick = step * 2.0 ** math.floor(math.log2(CONTACT_TIME_S / MIN_TICKS_PER_TOUCH / step))
    return bodies.Law(
        0.5 * (math.pi / CONTACT_TIME_S) ** 2,  # eq. 9.1, half of it at either end of an edge
        (scene.crowd.restitution**2, scene.arena.wall_restitution**2),
        (scene.crowd.friction, scene.arena.wall_friction),
        scene.drive.peak_speed,
        tick,
    )


def simulate(
    plan: CrowdPlan,
    number: int,
    rate_hz: float,
    stopped: Callable[[], bool] = lambda: False,
    progress: Callable[[float], None] = lambda seconds: None,
) -> CrowdRun:
    """Simulate run `number` with `rate_hz` frames a second, until `stopped()`. `progress` receives seconds done."""
    started, run = time.thread_time(), plan.scene.run
    walkers = release_walkers(plan, number)
    crowd, walkers = make_crowd(plan, walkers)
    blocks = 1 if len(walkers) == 1 else _block_count(plan, run.discard_seconds)
    advance(crowd, run.discard_seconds, blocks, stopped)
    tallies = [record.new_tally(len(TRAJECTORY_COLUMNS), run.seconds, 1.0 / rate_hz) for _ in walkers]
    crowd, walkers = attach_records(plan, walkers, crowd, tallies)
    energies, stored = _energies(walkers), float(steps.contact_energy(crowd))
    done = advance(crowd, run.seconds, _block_count(plan, run.seconds), stopped, progress)
    gained = _energies(walkers) - energies
    energy_errors = [
        record.energy_error(sums, change, before)
        for sums, change, before in zip(crowd.free.sums, gained, energies, strict=True)
    ]
    frames = min(int(tally.samples.cursor[0]) for tally in tallies)
    rows = np.array([tally.samples.rows[:frames] for tally in tallies])
    book = crowd.book
    return CrowdRun(
        number,
        _outcomes(crowd, done < run.seconds),
        tuple(plan.names[kind] for kind in plan.kinds),
        rows[0, :, 0],
        rows[:, :, 1:].transpose(1, 0, 2),
        int(book[bodies.TOUCHES]),
        float(book[bodies.DEEPEST]),
        max(energy_errors),
        _contact_energy_error(book, float(steps.contact_energy(crowd)) - stored),
        {"normal": -float(book[bodies.WORK]), "friction": float(book[bodies.RUBBED])},
        Impulses(*(float(book[row]) for row in (bodies.PRESSED, bodies.ALONG, bodies.UP))),
        time.thread_time() - started,
    )


def release_walkers(plan: CrowdPlan, number: int) -> Walkers:
    """Return each walker's world and state in run `number`, at rest. All share the noise and the phase of one plate."""
    walkers: Walkers = []
    seed, phase = plan.scene.run.seed, None
    for i, (kind, place_of) in enumerate(zip(plan.kinds, plan.places, strict=True)):
        rng = np.random.default_rng([seed, number] if i == 0 else [seed, number, i])
        own_plan, state = sample_drop(plan.plans[kind], rng, phase)
        world = own_plan.world
        if walkers:
            plate = walkers[0][0].acting
            acting = world.acting._replace(noise=plate.noise, roughness=plate.roughness)
            world = world._replace(acting=acting)
        phase = float(state[PHASE])
        _place_walker(world, state, *place_of)
        walkers.append((world, state))
    return walkers


def _place_walker(world: World, state: State, x: float, y: float, heading: float) -> None:
    """Change `state` in place: centre of mass at (x, y), mm, feet on the plate, turned to `heading`, rad."""
    turn_to(state, heading)
    state[C_X], state[C_Z] = x, -y
    update_pose(world, state, work_for(world.walker, state))


def make_crowd(plan: CrowdPlan, walkers: Walkers) -> tuple[bodies.Crowd, Walkers]:
    """Return a crowd with empty records, and its walkers, whose states now are views of the crowd's arrays."""
    return _assemble_crowd(plan, walkers, [record.new_tally() for _ in walkers])


def attach_records(
    plan: CrowdPlan, walkers: Walkers, before: bodies.Crowd, tallies: Sequence[record.Tally]
) -> tuple[bodies.Crowd, Walkers]:
    """Return a crowd that continues `before` with new records `tallies`, and its walkers as `make_crowd` does."""
    crowd, walkers = _assemble_crowd(plan, walkers, tallies)
    crowd.planar[:], crowd.status[:] = before.planar, before.status
    crowd.touching[:] = before.touching
    return crowd, walkers


def _assemble_crowd(plan: CrowdPlan, walkers: Walkers, tallies: Sequence[record.Tally]) -> tuple[bodies.Crowd, Walkers]:
    """Return a crowd of these walkers, and the walkers with states that are views of the crowd's arrays."""
    count, (worlds, states) = len(walkers), zip(*walkers, strict=True)
    movers, free = bodies.make_movers(worlds, states, tallies)
    crowd = bodies.Crowd(
        kernels.typed_list(movers),
        free,
        bodies.make_bodies(plan.kinds, plan.shapes),
        plan.ground,
        plan.law,
        np.zeros((count, 8)),
        np.full(count, OK),
        np.zeros((count, count), np.uint8),
        np.zeros(10),
        np.zeros(1),
    )
    return crowd, [(mover.world, mover.state) for mover in movers]


def _block_count(plan: CrowdPlan, seconds: float) -> int:
    """Return the number of equal blocks in which `seconds` are simulated. The last bits of results depend on it."""
    period = plan.plans[0].world.drive.period
    return min(max(round(seconds / (PERIODS_PER_BLOCK * period)), 1), MAX_BLOCKS)


def advance(
    crowd: bodies.Crowd,
    seconds: float,
    blocks: int,
    stopped: Callable[[], bool],
    progress: Callable[[float], None] = lambda seconds: None,
) -> float:
    """Advance a crowd, in place, by `seconds` in equal blocks. Return the simulated seconds.

    It ends early if `stopped()` is true before a block, or all have fallen. `progress` receives the seconds so far.
    """
    if seconds <= 0.0:
        return 0.0
    block, done = seconds / blocks, 0.0
    pairs = np.zeros((8 * len(crowd.status), 2), np.int64)
    code = kernels.entry_point(steps.advance, crowd, pairs, block)
    for number in range(blocks):
        if stopped() or not np.any(crowd.status == OK):
            return done
        left = block
        while left > 0.0:
            left -= code(crowd, pairs, left)
            if left > 0.0:
                pairs = np.zeros((2 * len(pairs), 2), np.int64)
        done = (number + 1) / blocks * seconds
        progress(done)
    return done


def _energies(walkers: Walkers) -> Array:
    """Compute each walker's energy without the energy of contacts with other bodies, g mm^2/s^2."""
    return np.array([energy(*walker) for walker in walkers])


def _contact_energy_error(book: Array, gain: float) -> float:
    """Return the share of the contacts' normal work that neither losses nor the `gain` of stored energy explain."""
    lost = book[bodies.LOST]
    taken = max(abs(book[bodies.WORK]), lost, abs(gain))
    return float(abs(book[bodies.WORK] + gain + lost) / taken) if taken else 0.0


def _outcomes(crowd: bodies.Crowd, unfinished: bool) -> tuple[str, ...]:
    """Return each walker's outcome. Walkers that are well in an `unfinished` run were stopped."""
    good = Outcome.STOPPED if unfinished else Outcome.OK
    return tuple((good if status == OK else STATUS_OUTCOMES[int(status)]).value for status in crowd.status)
