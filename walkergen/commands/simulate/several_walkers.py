"""Simulation of several walkers in one scene: a row for each, with predicted and simulated speed."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from walkergen.commands.simulate import make, quantities
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress, part_progress
from walkergen.core.numerics.quantity import Quantity, column_values
from walkergen.core.scene import Scene
from walkergen.core.simulation.ensemble import format_outcomes
from walkergen.core.simulation.run import Outcome
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.files import report
from walkergen.files.report import Column, Report, Table
from walkergen.points import speed_prediction, walkers
from walkergen.points.effect_selection import Simplest, find_simplest
from walkergen.points.experiments import Walker

ORBIT_MARK = "(o)"
"""Mark of a speed whose runs all end on one orbit."""


class Row(NamedTuple):
    """Walker with its predicted speed and its simulated speed. The names of the fields are keys in JSON."""

    name: str
    tilt_deg: float
    legs: str
    predicted_mm_s: float | None
    theory_mm_s: float
    speed: Quantity
    """Mean speed of the runs. Its bounds contain the errors of runs and step or, on an orbit, those of prints."""
    runs: int
    outcomes: Mapping[str, int]
    warnings: Sequence[str]
    orbit: Mapping[str, Any] | None
    """Orbit that all runs share, so that they have no statistical error; None if they differ."""
    effects: Mapping[str, Any] | None
    """Effects that an accepted error left out; None without an accepted error."""


def prepare_walkers(scene: Scene, members: Sequence[Design], progress: Progress) -> list[Simplest]:
    """Return each walker in the scene, without the effects that the scene's accepted error leaves out.

    Raises InputError for a walker that cannot be simulated.
    """
    all_walkers = [Walker(scene, member, solids.mass_of(member)) for member in members]
    for walker in all_walkers:
        walker.plan()
    return [
        find_simplest(walker, part_progress(progress, number, len(all_walkers), names.part_name(walker.design)))
        for number, walker in enumerate(all_walkers)
    ]


def simulate_each(found: Sequence[Simplest], progress: Progress) -> Iterator[Row]:
    """Simulate walkers in turn, all from the same random starts, and yield each finished row.

    Raises KeyboardInterrupt instead of yielding a row with missing runs.
    """
    wanted = [simple.walker for simple in found]
    titles = [names.part_name(walker.design) for walker in wanted]
    for simple, name, point in zip(found, titles, walkers.simulate_each(wanted, titles, progress), strict=True):
        walker, summary = simple.walker, point.summary
        shared = make.find_shared_orbit(point, progress)
        if shared is not None:
            summary = make.with_print_bounds(summary, shared)
        summary = simple.widen(summary)
        predicted = speed_prediction.predict(walker.design, walker.mass, walker.scene, model="known")
        yield Row(
            name,
            walker.design.tilt_deg,
            walker.design.kind,
            predicted.speed.value,
            predicted.theory_mm_s,
            summary.speed,
            summary.runs,
            summary.outcomes,
            point.warnings,
            None if shared is None else quantities.orbit_as_dict(shared),
            simple.facts.get("effects"),
        )


def make_report(rows: Sequence[Row], scene: Scene, found: Sequence[Simplest]) -> Report:
    """Make the report of simulated walkers. After Ctrl-C it has only the finished ones."""
    title = f"{found[0].walker.design.name} on {scene.name}, {quantities.format_drive(scene)}"
    row_facts = [column_values(row, 95) for row in rows]
    kinds = {row.orbit["kind"]: None for row in rows if row.orbit is not None}
    note = f"{ORBIT_MARK}: all runs end this way ({' or '.join(kinds)}), without statistical error; 95 % covers prints"
    return Report(
        name="simulate",
        title=title,
        facts={"rows": row_facts, "partial": len(rows) < len(found)},
        lines=[*([note] if kinds else []), *_format_omissions(found[: len(rows)])],
        tables=[
            Table("simulate", [tuple(row.values()) for row in row_facts], [*row_facts[0]], COLUMNS, title, read=rows)
        ]
        if rows
        else [],
        warnings=list(dict.fromkeys(warning for row in rows for warning in row.warnings)),
    )


def _format_omissions(found: Sequence[Simplest]) -> Iterator[str]:
    """Yield lines on the effects that were left out of each walker's scene, and on those that were not."""
    for simple in found:
        for name, value in simple.lines:
            yield f"{names.part_name(simple.walker.design)}, {name}: {value}"


def _format_speed(row: Row) -> str:
    """Format the mean speed of the runs with its standard error."""
    _, _, speed, se, *_ = row.speed
    if speed is None:
        return "none"
    if row.orbit is not None:
        return f"{formatting.format_fixed(speed, 2)} {ORBIT_MARK}"
    return f"{formatting.format_fixed(speed, 2)} ± ?" if se is None else formatting.format_with_error(speed, se)


def _format_bounds(row: Row) -> str:
    bounds = row.speed.interval()
    return (
        f"{formatting.format_fixed(bounds[0], 1)} to {formatting.format_fixed(bounds[1], 1)}" if bounds else "unknown"
    )


def _format_outcomes(row: Row) -> str:
    """Format the outcomes of the runs, except for the orbit that marks the speed."""
    return format_outcomes(
        {
            outcome: count
            for outcome, count in row.outcomes.items()
            if row.orbit is None or outcome != Outcome.ORBIT.value
        }
    )


COLUMNS = (
    Column("tilt\ndeg", lambda row: f"{row.tilt_deg:g}", right=True),
    report.text_column("legs", "legs"),
    report.fixed_column("predicted\nmm/s", "predicted_mm_s", 1),
    Column("simulated\nmm/s", _format_speed, right=True),
    Column("95 %\nmm/s", _format_bounds, right=True),
    Column("runs", lambda row: str(row.runs), right=True),
    Column("outcomes", _format_outcomes),
)
"""At most 80 letters while outcomes are few."""
