"""One run: an engine (model and method, ready to go), advanced block by block."""

import time
from collections.abc import Callable
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.scene import Scene
from walkergen.simulation import record

Array = npt.NDArray[np.float64]

X, PITCH = 0, 2
"""Places in every model's state."""

MOST_BLOCKS = 100_000
"""Longer runs have longer blocks: memory stays the same for any duration."""

FIRST_PITCH = 1e-3
"""Largest pitch of the first drop, rad: enough to leave the unstable level motion."""

PERIODS_PER_BLOCK = 4
"""A block, in periods of the drive: the time resolution of the speed's statistics."""


class Outcome(Enum):
    """How a run ended."""

    OK = "ok"
    STUCK = "stuck"
    """At rest on the plate to the end: no impact in the whole measured time."""
    TOPPLED = "toppled"
    FOLDED = "leg folded"
    LEFT = "left the lane"
    RUNAWAY = "energy without bound"
    """The relaxed model's impacts gain energy where H_rigid > H_flexible (physics.md section 5)."""
    ENERGY = "energy error"
    """More energy unaccounted for than scene.run.energy_tolerance allows."""
    FAILED = "no convergence"
    TOO_FEW = "too few data for an error bar"
    STOPPED = "stopped"


UNFINISHED = {Outcome.FAILED, Outcome.STOPPED, Outcome.RUNAWAY}
"""Ends that no energy balance explains; a fall or a folded leg must balance like any motion."""


class Engine(NamedTuple):
    """A model and a method, ready to run: kernels with their arguments."""

    model: str
    method: str
    advance: Callable[..., int]
    """advance(walker, plate, contact, options, state, duration, tally) -> status"""
    arguments: tuple[Any, ...]
    """(walker, plate, contact, options)"""
    start: Callable[[float, float, float], Array]
    """start(clearance in mm, pitch in rad, phase in rad) -> state at rest in the laboratory, the
    lower foot `clearance` over the plate"""
    energy: Callable[[Array], float]
    """Mechanical energy of a state, g mm^2/s^2."""
    failures: dict[int, Outcome]
    """Outcome of each status other than 0."""
    columns: tuple[str, ...]
    """Names of the state's places that a trajectory shows, from the first on."""
    period: float
    """Of the drive, s."""
    drop: float
    """Scale of the first drop's height, mm."""


class RunResult(NamedTuple):
    """One finished run."""

    number: int
    outcome: Outcome
    measured_s: float
    speed: float
    """Mean over the measured time, mm/s."""
    block_s: float
    block_speeds: Array
    """Mean speed of each block, mm/s."""
    energy_error: float
    tally: record.Tally
    cpu_s: float


def compile_kernels(engine: Engine) -> float:
    """Compile (or load from the disk cache) what the engine needs; returns the seconds it took."""
    started = time.perf_counter()
    state = engine.start(engine.drop, 0.0, 0.0)
    engine.advance(*engine.arguments, state, 1e-9, record.new(len(state)))
    return time.perf_counter() - started


def simulate(
    engine: Engine,
    scene: Scene,
    number: int,
    stopped: Callable[[], bool] = lambda: False,
    sample_interval: float | None = None,
    event_room: int | None = None,
) -> RunResult:
    """One run: a drop onto the plate, the discarded start, then the measured time in blocks."""
    started = time.thread_time()
    rng = np.random.default_rng([scene.run.seed, number])
    clearance, pitch, phase = rng.uniform((0.5, -1.0, 0.0), (1.5, 1.0, 2.0 * np.pi))
    state = engine.start(engine.drop * clearance, FIRST_PITCH * pitch, phase)
    outcome = Outcome.OK
    if scene.run.discard_seconds > 0:
        outcome = _advance(engine, state, scene.run.discard_seconds, record.new(len(state)), scene)

    tally = record.new(len(state), scene.run.seconds, sample_interval, event_room)
    blocks = round(scene.run.seconds / (PERIODS_PER_BLOCK * engine.period))
    blocks = min(max(blocks, 1), MOST_BLOCKS)
    block = scene.run.seconds / blocks
    places = np.empty(blocks + 1)
    places[0], energy = state[X], engine.energy(state)
    done = 0
    while done < blocks and outcome is Outcome.OK:
        if stopped():
            outcome = Outcome.STOPPED
            break
        outcome = _advance(engine, state, block, tally, scene)
        done += 1
        places[done] = state[X]

    error = _energy_error(tally.sums, engine.energy(state) - energy, energy)
    if outcome not in UNFINISHED and error > scene.run.energy_tolerance:
        outcome = Outcome.ENERGY
    if outcome is Outcome.OK and tally.counts[record.IMPACTS] == 0 and places[done] == places[0]:
        outcome = Outcome.STUCK
    speeds = np.diff(places[: done + 1]) / block
    speed = float(speeds.mean()) if done else 0.0
    cpu = time.thread_time() - started
    return RunResult(number, outcome, done * block, speed, block, speeds, error, tally, cpu)


def _advance(
    engine: Engine, state: Array, duration: float, tally: record.Tally, scene: Scene
) -> Outcome:
    status = engine.advance(*engine.arguments, state, duration, tally)
    if status != 0:
        return engine.failures[status]
    length = scene.arena.length_mm
    if length is not None and abs(state[X]) > 0.5 * length:
        return Outcome.LEFT
    return Outcome.OK


def _energy_error(sums: Array, gained: float, before: float) -> float:
    """Energy unaccounted for over the energy exchanged."""
    work = sums[record.PLATE_WORK]
    losses = sums[record.IMPACT_LOSS] + sums[record.FRICTION_LOSS] + sums[record.DAMPING_LOSS]
    exchanged = max(abs(work), abs(losses), abs(before))
    return float(abs(gained - (work - losses)) / exchanged) if exchanged else 0.0
