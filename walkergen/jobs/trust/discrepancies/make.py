"""Table of speeds of the model in space over the range in which people build walkers.

`make calibrate-models` simulates its rows and writes the discrepancy.npz in walkergen/theory, which
predictions read, and rows.csv beside this file, from which the table can be fitted anew
(`--refit`). Rows are points of the store that sweeps use: what was computed before, or by a run
that was killed, is not computed again.
"""

import argparse
import csv
import io
import json
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from walkergen.files import output
from walkergen.jobs.trust.discrepancies import fit
from walkergen.jobs.trust.discrepancies.cases import COUNT, Case, cases
from walkergen.points import run, worker_pool
from walkergen.points.point import Point, Record
from walkergen.points.store import Store
from walkergen.theory import discrepancy
from walkergen.theory.discrepancy import Place
from walkergen.walker import solids

Array = npt.NDArray[np.float64]

ROWS = Path(__file__).with_name("rows.csv")

COLUMNS = ("braced", *Place._fields, "speed", "se", "runs")
"""Columns of rows.csv: 1 for braced legs; numbers without unit; speeds and their standard errors
over the plate's peak speed."""


def rows(chosen: Sequence[Case], cores: int) -> Iterator[Array]:
    """Rows of the table, simulated or found in the store; none of runs that end badly."""
    points = [Point(case.design, case.scene, simulated=True, keep=()) for case in chosen]
    progress = Progress(len(points))
    with worker_pool.local(cores) as workers:
        for case, done in zip(chosen, run.each(points, Store(), workers), strict=True):
            progress.add(0.0 if done.stored else _seconds(case))
            numbers = row(case, done.record)
            if numbers is not None:
                yield numbers
    progress.end()


def with_settings(case: Case, settings: Sequence[str]) -> Case:
    """Case with keys of its scene set anew, each as in "run.step_us=2"."""
    values = dict(setting.split("=", 1) for setting in settings)
    return case._replace(scene=case.scene.variant(**{k: json.loads(v) for k, v in values.items()}))


def row(case: Case, record: Record) -> Array | None:
    """Numbers of a row in the order of COLUMNS; None without a speed that has an error."""
    speed, se, runs = (record.get(name) for name in ("speed_mm_s", "se_mm_s", "runs"))
    if speed is None or se is None or runs is None:
        return None
    place = discrepancy.place_of(case.scene, case.design, solids.mass_of(case.design))
    peak = case.scene.drive.peak_speed
    return np.array([case.design.braced, *place, float(speed) / peak, float(se) / peak, runs])


def _seconds(case: Case) -> float:
    run = case.scene.run
    return run.runs * (run.seconds + run.discard_seconds)


class Progress:
    """Lines on the error stream: what is done, what it cost, what is left."""

    def __init__(self, count: int) -> None:
        self.count, self.done, self.simulated = count, 0, 0.0
        self.started = self.shown = time.monotonic()

    def add(self, seconds: float) -> None:
        """Count a row, and the seconds that were simulated for it."""
        self.done += 1
        self.simulated += seconds
        if time.monotonic() - self.shown > 10.0:
            self.shown = time.monotonic()
            self._tell()

    def end(self) -> None:
        """Tell the cost of the whole."""
        self._tell()

    def _tell(self) -> None:
        elapsed = time.monotonic() - self.started
        left = elapsed / self.done * (self.count - self.done)
        print(
            f"{self.done} of {self.count} rows in {elapsed / 60:.1f} min, {self.simulated:.0f} s "
            f"simulated; about {left / 60:.1f} min left",
            file=sys.stderr, flush=True,
        )  # fmt: skip


def read() -> Array:
    """Rows of rows.csv, in the order of COLUMNS."""
    with ROWS.open(encoding="utf-8", newline="") as stream:
        reader = csv.reader(stream)
        if tuple(next(reader)) != COLUMNS:
            raise SystemExit(f"{ROWS.name} is of another walkergen: simulate anew")
        return np.array([[float(value) for value in line] for line in reader])


def write(table: Array) -> None:
    """Write rows.csv, numbers with five digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([f"{value:.5g}" for value in row] for row in table)
    output.write(ROWS, text.getvalue().encode())


def main() -> None:
    """Simulate the rows, or read them, and write the table with its errors."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        "--cores", type=int, default=worker_pool.cores(), help="processes to simulate in"
    )
    parser.add_argument(
        "--rows",
        type=int,
        default=COUNT,
        help="rows of the table, about: 6700 take 45 minutes on two cores",
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="key of every row's scene, such as run.step_us=2")  # fmt: skip
    parser.add_argument(
        "--refit", action="store_true", help="fit rows.csv anew, without simulating"
    )
    options = parser.parse_args()
    if not options.refit:
        every = [with_settings(case, options.set) for case in cases(options.rows)]
        write(np.array(list(rows(every, options.cores))))
    fitted = fit.table(read(), options.cores)
    output.write(discrepancy.TABLE, fit.as_bytes(fitted))
    print(fit.report(fitted))


if __name__ == "__main__":
    main()
