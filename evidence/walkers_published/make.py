"""Published walkers beside ours: the sweeps over what is not known of them, the table, the folder."""

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

CPU_S = 90.0
"""CPU time of a set whose points are not kept yet, s."""


def choose(words: str | None) -> tuple[str, ...]:
    """Parse a comma-separated list of sets, in order; None selects all. Raises InputError."""
    chosen = SETS if words is None else tuple(word.strip() for word in words.split(","))
    for word in chosen:
        if word not in SETS:
            raise InputError(f"--only {word[:30]!r}: must be of {', '.join(SETS)}")
    return tuple(name for name in SETS if name in chosen)


def make(sets: Sequence[str], folder: Path, progress: Progress) -> Report:
    """Write walkers_published.md and .csv.

    The points of sweeps are kept as they are evaluated: a run that was stopped goes on where it was. Equal sources
    give equal bytes. Statements of other sets, whose walkers are not asked for, are left out.
    """
    speeds = {}
    for number, name in enumerate(sets):
        speeds[name] = swept(_source(name), part_progress(progress, number, len(sets), name))
    rows = list(rows_of(STATEMENTS, speeds))
    note = (
        "Each draw is simulated in space, 4 runs of 1.5 s after 0.5 s, by `walkergen sweep --file "
        "templates/published/sweeps/NAME.toml`; draws whose body touches the plate, which ends our runs, are left out"
    )
    result = report.of(rows, folder, note)
    with Folder(folder, "") as target:
        result.write(target, pictures=False)
    return result


def rows_of(statements: Sequence[Statement], speeds: dict[str, list[Speeds]]) -> list[Predicted]:
    """Rows of all statements that are of these sets, or are not predicted."""
    return [
        predicted.predicted(statement, speeds.get(statement.source.ranges, []))
        for statement in statements
        if statement.missing or statement.source.ranges in speeds
    ]


def swept(source: Source, progress: Progress) -> list[Speeds]:
    """Draws of a set, evaluated or kept. Raises InputError."""
    space = sweep_file.read_sweep(source.sweep).space
    table = SweepRequest(file=source.sweep).run(progress).table
    rows = [dict(zip(table.keys, row, strict=True)) for row in table.rows]
    return predicted.draws(space.keys, rows, [axis.key for axis in space.axes])


def _source(name: str) -> Source:
    return next(statement.source for statement in STATEMENTS if statement.source.ranges == name)


def expected_s(sets: Sequence[str]) -> float:
    """Wall time without anything kept and with compiled kernels, s, within a factor of two."""
    return CPU_S * len(sets)
