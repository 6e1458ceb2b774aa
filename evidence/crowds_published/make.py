"""Our crowds beside published ones: walkers alone, their crowds, and the sign of each statement."""

import os
from pathlib import Path

from evidence.crowds_published import alone as crowd_alone
from evidence.crowds_published import report as crowd_report
from evidence.crowds_published import runs as crowd_runs
from evidence.crowds_published.cases import ALONE, Case, Size, alone, crowds
from evidence.crowds_published.claims import Found, Numbers, compared
from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.files.report import Report
from walkergen.simulation import experiments

FEWEST_RUNS = 3
"""Fewest runs of a crowd, whose spread gives the errors."""

SHORTEST_S = 0.5
"""Shortest runs of a crowd, s: some times of what its numbers are means over."""

CPU_PER_S = 0.07
"""CPU time of a simulated second of a walker, s, in jams, where contacts take each tick."""

MEAN_WALKERS = 15
"""Walkers of a crowd, mean of all cases."""


def make(size: Size, folder: Path, progress: Progress) -> Report:
    """Write reproduce.md and .csv, crowds.csv, crowds.png and .pdf.

    Equal sizes give equal bytes of every CSV. Ctrl-C leaves no file. Raises InputError for runs too
    few or too short to tell errors.
    """
    check(size)
    singles, many = alone(size), crowds(size)
    steps = len(singles) + len(many)
    found: dict[tuple[str, float], Numbers] = {}
    asked = crowd_alone.asked(singles)
    titles = [f"alone, {case.series} {case.setting:g}" for case in singles]

    def part(start: int) -> Progress:
        return lambda what, done, of: progress(what, 100 * start + 100 * done // of, 100 * steps)

    def first(what: str, done: int, of: int) -> None:
        progress(what, 100 * len(singles) * done // of, 100 * steps)

    for case, point in zip(singles, experiments.each(asked, titles, first, None), strict=True):
        found[case.series, case.setting] = crowd_alone.numbers(case, point.results)
    for number, case in enumerate(many, start=len(singles)):
        found[case.series, case.setting] = _crowd(case, part(number))
    return _written(found, size, folder)


def _crowd(case: Case, progress: Progress) -> Numbers:
    return crowd_runs.numbers(crowd_runs.simulated(case, progress), case.design.size.length)


def _written(found: Found, size: Size, folder: Path) -> Report:
    from walkergen.files import figures

    rows = compared(found)
    note = (
        f"Each number: {size.runs} runs of {size.seconds:g} s after {size.discard_seconds:g} s, of "
        f"walkers alone {ALONE}; 90 Hz and 1.8 g where nothing else is said; seed {size.seed}"
    )
    with Folder(folder, "") as target:
        for table in (crowd_report.table(rows), crowd_report.points(rows)):
            target.write(f"{table.name}.csv", table.csv().encode())
        figure = crowd_report.draw(rows)
        target.write("crowds.png", figures.png(figure))
        target.write("crowds.pdf", figures.pdf(figure))
        target.write("reproduce.md", crowd_report.to_markdown(rows, f"{note}.").encode())
    return crowd_report.of(rows, folder, note)


def check(size: Size) -> None:
    """Refuse runs that could not tell errors. Raises InputError."""
    if size.runs < FEWEST_RUNS:
        raise InputError(f"--runs {size.runs}: at least {FEWEST_RUNS}, whose spread gives the errors")
    if size.seconds < SHORTEST_S:
        raise InputError(f"--seconds {size.seconds:g}: at least {SHORTEST_S:g}, for means")


def expected_s(size: Size) -> float:
    """Wall time on an idle machine with compiled kernels, s, within a factor of two."""
    walkers = MEAN_WALKERS * size.runs * len(crowds(size)) + ALONE * len(alone(size))
    return CPU_PER_S * walkers * (size.seconds + size.discard_seconds) / (os.cpu_count() or 1)
