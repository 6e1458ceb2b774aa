"""Points of a sweep whose design is simulated as a crowd: its statistics with errors, and its outcome.

A point is one design in one scene (see `points.kinds`). A crowd takes minutes: its record holds every statistic, so
that others may be shown without a run. `keep`: names of the statistics that are shown.
"""

from collections.abc import Sequence

from walkergen.core import ENERGY_TOLERANCE, Printer, format_number, silent
from walkergen.guests.crowd import in_space, make, walker_counts
from walkergen.guests.crowd.population import Simulated
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.statistics.summary import UNITS, WHOLE_RUN_NUMBERS
from walkergen.points.model_kinds import Picture
from walkergen.points.point import Point, PointStatus, Record, status_record

GROUPS, SCENE, RUNS, MEETS_ERRORS = tuple(UNITS), "plane-90hz", walker_counts.DEFAULT_RUNS, False
KEPT = "packing", "polar_order", "nematic_order", "speed", "largest_cluster", "wall_density"

SIZE_COLUMNS = ("walkers", "runs", "seconds")
"""Columns of the crowd itself, before those of its statistics."""


def check(keep: Sequence[str], model: str, printer: Printer | None) -> None:
    """Accept any arguments, as a crowd has all statistics."""


def title(model: str) -> str:
    """Return "crowds", the source of the numbers as titles of tables name it."""
    return "crowds"


def columns(model: str, keep: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a record's columns for the statistics in `keep`, without the status."""
    return (*SIZE_COLUMNS, *(column for name in keep for column in statistic_columns(name)))


def statistic_columns(name: str) -> tuple[str, str, str, str]:
    """Return the names of the columns of a statistic: value, standard error, lower and upper bound of 95 %."""
    unit = f"_{UNITS[name]}" if UNITS[name] else ""
    return f"{name}{unit}", f"{name}_se{unit}", f"{name}_low_95{unit}", f"{name}_high_95{unit}"


def pictures(keep: Sequence[str]) -> tuple[Picture, ...]:
    """Return the pictures of a table, one for each statistic in `keep`."""
    made = []
    for name in keep:
        value, _, low, high = statistic_columns(name)
        made.append(Picture(name, value, low, high, name.replace("_", " ") + (" (mm/s)" if UNITS[name] else "")))
    return tuple(made)


def cost(point: Point) -> float:
    """Estimate the CPU seconds of a crowd from a short piece of a run. Raises as `evaluate` does."""
    request = CrowdRequest()
    population = in_space.make_population(request, point.scene, [point.design])
    return point.scene.run.runs * in_space.cpu_seconds(request, population)


def evaluate(point: Point) -> Record:
    """Simulate a crowd as `walkergen crowd` does, on this thread alone, and return its record.

    Raises InputError if it has no room or too many walkers, and KeyboardInterrupt if runs are missing.
    """
    request = CrowdRequest(threads=1)
    population = in_space.make_population(request, point.scene, [point.design])
    simulated = make.simulate(request, population, silent)
    if len(simulated.films) < point.scene.run.runs:
        raise KeyboardInterrupt
    measured = simulated.statistics
    sizes = len(population.kind_indices), measured.runs, point.scene.run.seconds
    record = _run_status(simulated) | dict(zip(SIZE_COLUMNS, sizes, strict=True))
    for name, estimate in measured.numbers.items():
        bounds = estimate.interval(0.95) or (None, None)
        values = estimate.value, estimate.se, *bounds
        record |= dict(zip(statistic_columns(name), values, strict=True))
    return record


def _run_status(simulated: Simulated) -> Record:
    """Return the status of a crowd's runs: whether walkers fell, energy is missing or errors are unknown."""
    if fallen := simulated.fallen:
        count = sum(simulated.outcomes.values())
        which = ", ".join(f"{count} {name}" for name, count in fallen.items())
        how = PointStatus.WALKERS_ENDED_BADLY
        return status_record(how, f"{how}: {which}, of {count} in all runs")
    if simulated.energy_error > ENERGY_TOLERANCE:
        share = format_number(100.0 * simulated.energy_error, 2)
        return status_record(
            PointStatus.UNBALANCED, f"{PointStatus.UNBALANCED}: {share} % unaccounted for; take a smaller run.step_us"
        )
    for name, number in simulated.statistics.numbers.items():
        if name not in WHOLE_RUN_NUMBERS and number.value is not None and number.se is None:
            return status_record(PointStatus.NOT_MET, f"error unknown: {number.refused}; take more runs")
    return status_record(PointStatus.OK)
