"""Published walkers compared with ours: the sweeps over unknown properties, the table, the folder."""

from collections.abc import Sequence
from pathlib import Path

from evidence.walkers_published import predicted, report
from evidence.walkers_published.predicted import Predicted, Speeds
from evidence.walkers_published.published import SETS, STATEMENTS, Source, Statement
from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress, part_progress
from walkergen.files.report import Report
from walkergen.guests.sweep import sweep_file
from walkergen.guests.sweep.request import SweepRequest

CPU_S_PER_SET = 90.0
"""CPU time of a set whose points are not kept yet, s."""


def parse_sets(words: str | None) -> tuple[str, ...]:
    """Parse a comma-separated list of sets, in order; None selects all. Raises InputError."""
    chosen = SETS if words is None else tuple(word.strip() for word in words.split(","))
    for word in chosen:
        if word not in SETS:
            raise InputError(f"--only {word[:30]!r}: must be of {', '.join(SETS)}")
    return tuple(name for name in SETS if name in chosen)


def compare_walkers(sets: Sequence[str], folder: Path, progress: Progress) -> Report:
    """Write walkers_published.md and .csv.

    Each point of a sweep is stored when it is evaluated, so a stopped run continues. Equal sources
    give equal bytes. Statements of other sets, whose walkers are not requested, are left out.
    """
    speeds = {}
    for number, name in enumerate(sets):
        speeds[name] = run_sweep(_find_source(name), part_progress(progress, number, len(sets), name))
    rows = list(compare_statements(STATEMENTS, speeds))
    note = (
        "Each draw is simulated in space, 4 runs of 1.5 s after 0.5 s, by `walkergen sweep --file "
        "templates/published/sweeps/NAME.toml`; draws whose body touches the plate, which ends our runs, are left out"
    )
    result = report.make_report(rows, folder, note)
    with Folder(folder, "") as target:
        result.write(target, pictures=False)
    return result


def compare_statements(statements: Sequence[Statement], speeds: dict[str, list[Speeds]]) -> list[Predicted]:
    """Rows of all statements that are of these sets, or are not predicted."""
    return [
        predicted.predict_statement(statement, speeds.get(statement.source.ranges, []))
        for statement in statements
        if statement.missing or statement.source.ranges in speeds
    ]


def run_sweep(source: Source, progress: Progress) -> list[Speeds]:
    """Draws of a set, evaluated or kept. Raises InputError."""
    space = sweep_file.read_sweep(source.sweep).space
    table = SweepRequest(file=source.sweep).run(progress).table
    rows = [dict(zip(table.keys, row, strict=True)) for row in table.rows]
    return predicted.group_draws(space.keys, rows, [axis.key for axis in space.axes])


def _find_source(name: str) -> Source:
    return next(statement.source for statement in STATEMENTS if statement.source.ranges == name)


def expected_s(sets: Sequence[str]) -> float:
    """Wall time without anything kept and with compiled kernels, s, within a factor of two."""
    return CPU_S_PER_SET * len(sets)
