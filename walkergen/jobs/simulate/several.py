"""Simulation of several walkers in one scene: a row each, predicted and simulated."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rich import box
from rich.table import Table

from walkergen.analysis.estimates import Estimate, with_error
from walkergen.files.progress import Progress
from walkergen.jobs.simulate import orbit, tables
from walkergen.scene import Scene
from walkergen.simulation import points
from walkergen.simulation.ensemble import listed
from walkergen.simulation.plan import prepare
from walkergen.simulation.points import Asked
from walkergen.theory import prediction
from walkergen.walker import names, solids
from walkergen.walker.design import Design

ORBIT = "(o)"
"""Mark of a speed whose runs all end on one orbit."""


class Row(NamedTuple):
    """Walker with its predicted speed and that of its runs; the field names are keys of JSON."""

    name: str
    tilt_deg: float
    legs: str
    model: str
    method: str
    predicted_mm_s: float
    theory_mm_s: float
    speed_mm_s: float | None
    """Mean speed of the runs; None when none ended well."""
    speed_se_mm_s: float | None
    speed_low_95_mm_s: float | None
    speed_high_95_mm_s: float | None
    """Bounds of 95 % by runs and step, or of prints on an orbit; None when they are unknown."""
    runs: int
    outcomes: Mapping[str, int]
    warnings: Sequence[str]
    orbit: Mapping[str, Any] | None
    """Orbit that all runs share, so that they tell no error; None where they differ."""


def asked(scene: Scene, members: Sequence[Design]) -> list[Asked]:
    """Points of walkers in a scene, weighed. Raises InputError for one that cannot be simulated."""
    found = [Asked(scene, member, solids.mass_of(member)) for member in members]
    for one in found:
        prepare(*one[:3])
    return found


def each(wanted: Sequence[Asked], progress: Progress) -> Iterator[Row]:
    """Simulate walkers in turn, all from the same random starts, and yield a row when one is done.

    Raises KeyboardInterrupt rather than yield a row with runs missing.
    """
    titles = [names.part(one.design) for one in wanted]
    for one, name, point in zip(
        wanted, titles, points.each(wanted, titles, progress, None), strict=True
    ):
        found = point.summary
        shared = orbit.of(point, one, progress)
        if shared is not None:
            found = orbit.of_prints(found, shared)
        predicted = prediction.predict(one.design, one.mass, one.scene)
        yield Row(
            name, one.design.tilt_deg, one.design.kind, point.model, point.method,
            predicted.speed_mm_s, predicted.theory_mm_s, found.speed_mm_s, found.speed_se_mm_s,
            found.speed_low_95_mm_s, found.speed_high_95_mm_s, found.runs, found.outcomes,
            point.warnings, None if shared is None else tables.orbit_as_dict(shared),
        )  # fmt: skip


def to_table(rows: Sequence[Row], title: str) -> Table:
    """Table for the console, of at most 80 letters while outcomes are few."""
    table = Table(title=title, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("tilt\ndeg", "legs", "model", "predicted\nmm/s", "simulated\nmm/s",
                    "95 %\nmm/s", "runs", "outcomes"):  # fmt: skip
        left = heading in ("legs", "model", "outcomes")
        table.add_column(heading, justify="left" if left else "right", no_wrap=not left)
    for row in rows:
        table.add_row(
            f"{row.tilt_deg:g}", row.legs, row.model, _fixed(row.predicted_mm_s), _speed(row),
            _bounds(row), str(row.runs), listed(row.outcomes),
        )  # fmt: skip
    return table


def notes(rows: Sequence[Row]) -> list[str]:
    """Notes below the table: what marks mean."""
    kinds = {row.orbit["kind"]: None for row in rows if row.orbit is not None}
    return [
        f"{ORBIT}: all runs end so ({' or '.join(kinds)}) and tell no error; 95 % are of prints"
    ] * bool(kinds)


def _speed(row: Row) -> str:
    """Mean speed of the runs with its standard error."""
    if row.speed_mm_s is None:
        return "none"
    if row.orbit is not None:
        return f"{row.speed_mm_s:.2f} {ORBIT}"
    if row.speed_se_mm_s is None:
        return f"{row.speed_mm_s:.2f} ± ?"
    return with_error(Estimate(row.speed_mm_s, row.speed_se_mm_s))


def _bounds(row: Row) -> str:
    low, high = row.speed_low_95_mm_s, row.speed_high_95_mm_s
    return "unknown" if low is None or high is None else f"{_fixed(low)} to {_fixed(high)}"


def _fixed(value: float) -> str:
    """Format a number with a decimal, without a minus on zero."""
    return f"{round(value, 1) + 0.0:.1f}"
