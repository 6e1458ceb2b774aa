"""Our crowds compared with published ones: walkers alone, their crowds, and the sign of each statement."""

import os
from pathlib import Path

from evidence.crowds_published import numbers, report
from evidence.crowds_published.cases import SINGLE_RUNS, Case, Size, crowd_cases, single_cases
from evidence.crowds_published.compared import Numbers, compare_findings
from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.walker import solids
from walkergen.files.report import Report
from walkergen.guests.crowd import in_space
from walkergen.guests.crowd.make import simulate
from walkergen.guests.crowd.population import Simulated
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.points import walkers
from walkergen.points.experiments import Walker

MIN_RUNS = 3
"""Fewest runs of a crowd, whose spread gives the errors."""

MIN_SECONDS = 0.5
"""Shortest runs of a crowd, s: some times of what its numbers are means over."""

RATE_HZ = 20.0
"""Frames a second of crowds: two in the time over which velocities are taken."""

CPU_PER_S = 0.07
"""CPU time of a simulated second of a walker, s, in jams, where contacts take each tick."""

MEAN_WALKERS = 15
"""Walkers of a crowd, mean of all cases."""


def compare_crowds(size: Size, folder: Path, progress: Progress) -> Report:
    """Write crowds_published.md and .csv, crowds.csv, crowds.png and .pdf.

    Equal sizes give equal bytes of every CSV. Ctrl-C leaves no file. Raises InputError for runs too
    few or too short to tell errors.
    """
    check_size(size)
    note = (
        f"Each number: {size.runs} runs of {size.seconds:g} s after {size.discard_seconds:g} s, of "
        f"walkers alone {SINGLE_RUNS}; 90 Hz and 1.8 g unless stated otherwise; seed {size.seed}"
    )
    result = report.make_report(list(compare_findings(simulate_cases(size, progress))), folder, note)
    with Folder(folder, "") as target:
        result.write(target, pictures=True)
    return result


def simulate_cases(size: Size, progress: Progress) -> Numbers:
    """Quantities of every walker alone and of every crowd."""
    singles, many = single_cases(size), crowd_cases(size)
    steps, found = 100 * (len(singles) + len(many)), dict[tuple[str, float], dict[str, Quantity]]()
    lonely = [
        Walker(case.scene, case.design, solids.mass_of(case.design), sample_interval=numbers.SAMPLE_INTERVAL_S)
        for case in singles
    ]
    titles = [f"alone, {case.series} {case.setting:g}" for case in singles]

    def report_singles(what: str, done: int, of: int) -> None:
        progress(what, 100 * len(singles) * done // of, steps)

    for case, point in zip(singles, walkers.simulate_each(lonely, titles, report_singles), strict=True):
        found[case.series, case.setting] = dict(numbers.single_quantities(case, point.results))
    for number, case in enumerate(many, start=len(singles)):

        def report_crowd(_: str, done: int, of: int, case: Case = case, number: int = number) -> None:
            progress(f"{case.series} {case.setting:g}", 100 * number + 100 * done // of, steps)

        found[case.series, case.setting] = dict(
            numbers.crowd_quantities(_simulate_crowd(case, report_crowd), case.design.size.length)
        )
    return found


def _simulate_crowd(case: Case, progress: Progress) -> Simulated:
    """All runs of a crowd; equal on any number of threads. Ctrl-C is raised again."""
    request = CrowdRequest(rate_hz=RATE_HZ)
    crowd = simulate(request, in_space.make_population(request, case.scene, [case.design]), progress)
    if len(crowd.runs) < case.scene.run.runs:  # those that Ctrl-C left would be another sample
        raise KeyboardInterrupt
    return crowd


def check_size(size: Size) -> None:
    """Refuse runs that could not tell errors. Raises InputError."""
    if size.runs < MIN_RUNS:
        raise InputError(f"--runs {size.runs}: must be at least {MIN_RUNS}. Their spread gives the errors.")
    if size.seconds < MIN_SECONDS:
        raise InputError(f"--seconds {size.seconds:g}: must be at least {MIN_SECONDS:g}, for means")


def expected_s(size: Size) -> float:
    """Wall time on an idle machine with compiled kernels, s, within a factor of two."""
    walkers = MEAN_WALKERS * size.runs * len(crowd_cases(size)) + SINGLE_RUNS * len(single_cases(size))
    return CPU_PER_S * walkers * (size.seconds + size.discard_seconds) / (os.cpu_count() or 1)
