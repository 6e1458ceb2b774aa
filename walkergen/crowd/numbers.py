"""Numbers of a point that is a crowd: all its statistics with their errors, and how it went.

A crowd takes minutes: its record holds every statistic, so that others may be shown without a run.
"""

from walkergen.crowd import in_space as crowd_space
from walkergen.crowd import make
from walkergen.crowd.members import RATE_HZ
from walkergen.crowd.runs import Simulated
from walkergen.crowd.statistics.measuring import TIMELESS, UNITS
from walkergen.files import words
from walkergen.files.progress import silent
from walkergen.points.point import OK, STATUS, Point, Record
from walkergen.simulation.run import Outcome

SIZE = ("walkers", "runs", "seconds")
"""Columns of the crowd itself, before those of its statistics."""


def columns(name: str) -> tuple[str, str, str, str]:
    """Columns of a statistic of `measuring.UNITS`: value, standard error, bounds of 95 %."""
    unit = f"_{UNITS[name]}" if UNITS[name] else ""
    return f"{name}{unit}", f"{name}_se{unit}", f"{name}_low_95{unit}", f"{name}_high_95{unit}"


def evaluate(point: Point) -> Record:
    """Simulate a crowd as `walkergen crowd` does, on this thread alone, and measure it.

    Raises InputError where it has no room or too many walkers, and KeyboardInterrupt where runs
    are missing.
    """
    job = crowd_space.asked(point.scene, [point.design], None, RATE_HZ)
    simulated = make.simulate(job, 1, silent)
    if len(simulated.films) < point.scene.run.runs:
        raise KeyboardInterrupt
    measured = simulated.statistics
    sizes = len(job.numbers), measured.runs, point.scene.run.seconds
    record: Record = {STATUS: _status(simulated), **dict(zip(SIZE, sizes, strict=True))}
    for name, estimate in measured.numbers.items():
        bounds = estimate.interval(0.95) or (None, None)
        values = estimate.value, estimate.se, *bounds
        record |= dict(zip(columns(name), values, strict=True))
    return record


def _status(simulated: Simulated) -> str:
    """How the runs of a crowd went."""
    if fallen := simulated.fallen:
        count = sum(simulated.outcomes.values())
        which = ", ".join(f"{count} {name}" for name, count in fallen.items())
        return f"some walkers ended badly: {which}, of {count} in all runs"
    if simulated.energy_error > simulated.job.scene.run.energy_tolerance:
        share = words.number(100.0 * simulated.energy_error, 2)
        return f"{Outcome.ENERGY.value}: {share} % unaccounted for; take a smaller run.step_us"
    for name, estimate in simulated.statistics.numbers.items():
        if name not in TIMELESS and estimate.value is not None and estimate.se is None:
            return f"error unknown: {estimate.refused}; take more runs"
    return OK
