"""One run of a plan, advanced block by block."""

import math
import time
from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.space.model import pose
from walkergen.core.simulation.world import FAILED, FOLDED, OK, TOPPLED

MAX_BLOCKS = 100_000
"""Largest number of blocks: longer runs have longer blocks, which bounds the memory."""

MAX_DROP_TURN_RAD = 1e-3
"""Largest pitch and roll of the first drop, rad: enough to leave the unstable level motion."""

PERIODS_PER_BLOCK = 4
"""Length of a block in periods of the drive: the time resolution of the speed's statistics."""

FIRST_EVENT_ROOM, MAX_EVENT_ROOM = 1024, 2_000_000
"""Number of impacts that the arrays hold at first if all are kept: per period of the drive, and in all. A run with
more impacts than that is repeated."""

ENERGY_TOLERANCE = 0.05
"""Largest share of the exchanged energy that may remain unaccounted for."""


class Outcome(Enum):
    """How a run ended."""

    OK = "ok"
    STUCK = "stuck"
    """At rest on the plate to the end: no impact in the whole measured time."""
    TOPPLED = "toppled"
    FOLDED = "leg folded"
    LEFT = "left the ground"
    ENERGY = "energy error"
    """More energy unaccounted for than ENERGY_TOLERANCE allows."""
    FAILED = "no convergence"
    TOO_FEW = "too few data for an error bar"
    ORBIT = "on one periodic orbit"
    """Same orbit as all other runs: their agreement gives no error (`orbits`)."""
    STOPPED = "stopped"


ENDED_WELL = (Outcome.OK, Outcome.STUCK)
"""Outcomes of runs whose speed counts."""

STATUS_OUTCOMES = {TOPPLED: Outcome.TOPPLED, FAILED: Outcome.FAILED, FOLDED: Outcome.FOLDED}
"""Outcome of each status of `world` other than OK."""

UNBALANCED_OUTCOMES = {Outcome.FAILED, Outcome.STOPPED}
"""Outcomes whose energy need not balance; that of a fall or a folded leg must."""


class RunResult(NamedTuple):
    """Result of one run."""

    number: int
    outcome: Outcome
    measured_s: float
    speed: float
    """Mean speed over the measured time, mm/s: along the lane, or along the heading on a plane."""
    block_s: float
    block_speeds: Array
    """Mean speed of each block, mm/s."""
    energy_error: float
    tally: record.Tally
    cpu_s: float
    places: Array
    """Position in the plate's plane (along x, and to the left, mm) and heading (rad) at the ends of
    the blocks, shape (blocks + 1, 3)."""


def compile_kernels(plan: Plan) -> float:
    """Compile, or load from the disk cache, the kernels that the plan needs. Return the time that this took, s."""
    started = time.perf_counter()
    plan, state = drop_for_run(plan, 0)  # kernels are compiled for the array types of drawn noise and bumps
    plan.advance(state, 1e-9, record.new_tally())  # any time compiles them
    plan.energy(state)
    return time.perf_counter() - started


def drop_for_run(plan: Plan, number: int) -> tuple[Plan, Array]:
    """Return the plan of run `number`, with feet and plate drawn at random for this run, and the initial state.

    The walker drops from 0.5 to 1.5 amplitudes over the plate, at a random phase of the drive, pitch and roll.
    """
    run = plan.scene.run
    rng = np.random.default_rng([run.seed, number])
    if run.heading_deg == "uniform":
        heading = rng.spawn(1)[0].uniform(0.0, 2.0 * math.pi)  # a stream of its own: all else is drawn as without
    else:
        heading = math.radians(run.heading_deg[number % len(run.heading_deg)])
    return sample_drop(plan, rng, heading=heading)


def sample_drop(
    plan: Plan, rng: np.random.Generator, common_phase: float | None = None, heading: float = 0.0
) -> tuple[Plan, Array]:
    """Return the plan and initial state of one walker, both drawn at random from `rng` as for `drop_for_run`.

    `common_phase` (rad) of the drive replaces a random one, for walkers on one plate. `heading` is in rad.
    """
    low, high = (0.5, -1.0, 0.0, -1.0), (1.5, 1.0, 2.0 * np.pi, 1.0)
    clearance, pitch, phase, roll = rng.uniform(low, high)
    plan = plan.sample_print(rng)
    height = plan.equivalent_drive.amplitude * clearance
    phase = phase if common_phase is None else common_phase
    return plan, plan.initial_state(height, MAX_DROP_TURN_RAD * pitch, phase, MAX_DROP_TURN_RAD * roll, heading)


def simulate(
    plan: Plan,
    number: int,
    stopped: Callable[[], bool] = lambda: False,
    sample_interval: float | None = None,
    sample_size: int | None = None,
    event_room: int = 0,
) -> RunResult:
    """Simulate one run: a drop, the discarded start, then the measured time in blocks.

    Parameters
    ----------
    plan : Plan
        Plan of the walker and its scene.
    number : int
        Number of the run, from 0. With the scene's seed it determines the drop.
    stopped : callable, optional
        Function without arguments that is called after each block. The run ends when it returns True.
    sample_interval : float, optional
        Time between kept states, s; none are kept by default.
    sample_size : int, optional
        Number of leading entries of a state to keep; all by default.
    event_room : int, default: 0
        Number of impacts for which memory is reserved.

    Returns
    -------
    RunResult
        Outcome, mean speed (mm/s), speeds of the blocks, and everything recorded.

    Notes
    -----
    The same plan and number give the same run.

    References
    ----------
    docs/physics.md section 7.

    Examples
    --------
    >>> from walkergen.core import Design, Scene, mass_of, prepare, simulate
    >>> design = Design()
    >>> plan = prepare(Scene(), design, mass_of(design)).with_run_settings(seconds=0.05)
    >>> simulate(plan, 0).outcome
    <Outcome.OK: 'ok'>
    """
    started = time.thread_time()
    run = plan.scene.run
    plan, state = drop_for_run(plan, number)
    size = len(state) if sample_size is None else sample_size
    tally = record.new_tally(size, run.seconds, sample_interval, event_room)
    outcome = Outcome.OK
    if run.discard_seconds > 0:
        outcome = _make_advancer(plan, state, record.new_tally())(run.discard_seconds)

    advance = _make_advancer(plan, state, tally)
    blocks = round(run.seconds / (PERIODS_PER_BLOCK * plan.world.drive.period))
    blocks = min(max(blocks, 1), MAX_BLOCKS)
    block = run.seconds / blocks
    places = np.empty((blocks + 1, 3))
    places[0], energy = pose(state), plan.energy(state)
    done = 0
    while done < blocks and outcome is Outcome.OK:
        if stopped():
            outcome = Outcome.STOPPED
            break
        outcome = advance(block)
        done += 1
        places[done] = pose(state)

    error = record.energy_error(tally.sums, plan.energy(state) - energy, energy)
    if outcome not in UNBALANCED_OUTCOMES and error > ENERGY_TOLERANCE:
        outcome = Outcome.ENERGY
    if outcome is Outcome.OK and tally.counts[record.IMPACTS] == 0 and places[done, 0] == places[0, 0]:
        outcome = Outcome.STUCK
    speeds = _block_distances(places[: done + 1], plan.scene.arena.kind == "plane") / block
    speed = float(speeds.mean()) if done else 0.0
    cpu = time.thread_time() - started
    return RunResult(number, outcome, done * block, speed, block, speeds, error, tally, cpu, places[: done + 1])


def _block_distances(poses: Array, on_plane: bool) -> Array:
    """Return the distance run in each block, mm: along x, or along the mean heading. `poses`: rows (x, y, heading)."""
    displacements = np.diff(poses, axis=0)
    if not on_plane:
        return displacements[:, 0]
    heading = 0.5 * (poses[1:, 2] + poses[:-1, 2])
    return np.asarray(displacements[:, 0] * np.cos(heading) + displacements[:, 1] * np.sin(heading))


def simulate_with_impacts(
    plan: Plan,
    number: int,
    stopped: Callable[[], bool] = lambda: False,
    sample_interval: float | None = None,
    sample_size: int | None = None,
) -> RunResult:
    """Simulate one run as `simulate` does, with all impacts recorded. Repeat it with more memory until all fit."""
    expected_room = FIRST_EVENT_ROOM * plan.scene.run.seconds / plan.world.drive.period
    room = 256 + int(min(expected_room, MAX_EVENT_ROOM))
    while True:
        result = simulate(plan, number, stopped, sample_interval, sample_size, room)
        impacts, tally = recorded_impacts(result), result.tally
        if len(impacts) < room:  # unused rows are dropped
            return result._replace(tally=tally._replace(events=tally.events._replace(rows=impacts.copy())))
        room *= 4


def recorded_impacts(result: RunResult) -> Array:
    """Return the recorded impacts of a run, shape (impacts, 7), with the columns of `record.Events`."""
    events = result.tally.events
    return np.asarray(events.rows[: events.cursor[0]])


def _make_advancer(plan: Plan, state: Array, tally: record.Tally) -> Callable[[float], Outcome]:
    """Return a function of a time (s) that advances `state` in place, fills `tally` and returns the outcome."""
    move = plan.advancer(state, tally)
    arena = plan.scene.arena
    half_sizes = [math.inf if size is None else 0.5 * size for size in (arena.length_mm, arena.width_mm)]

    def advance(seconds: float) -> Outcome:
        status = move(seconds)
        if status != OK:
            return STATUS_OUTCOMES[status]
        x, y, _ = pose(state)
        has_left = abs(x) > half_sizes[0] or abs(y) > half_sizes[1]
        return Outcome.LEFT if has_left else Outcome.OK

    return advance
