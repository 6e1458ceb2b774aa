"""Tables of speeds of the model in space over the range in which people build walkers.

`make calibrate-models` simulates their rows and writes discrepancy.npz (shaken plates) and
motors.npz (walkers with a motor) in walkergen/theory, which predictions read, and the rows in CSV
files beside this one, from which the tables can be fitted anew (`--refit`). Rows are points of the
store that sweeps use: what was computed before, or by a run that was killed, is not computed again.
"""

import argparse
import csv
import io
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import cases, fit, motor_cases, motor_fit
from evidence.tables.cases import Case
from walkergen.files import output
from walkergen.points import run, worker_pool
from walkergen.points.point import Point, Record
from walkergen.points.store import Store
from walkergen.theory import discrepancy, motors
from walkergen.theory.surrogate import Place
from walkergen.walker import solids

Array = npt.NDArray[np.float64]


class Kind(NamedTuple):
    """Kind of walkers that has a table of its own."""

    rows: Path
    """File of its rows."""
    columns: tuple[str, ...]
    """Columns of that file: numbers without unit; speeds and their standard errors over the peak
    speed of the plate, or of the motor's swing."""
    cases: Callable[[int], Iterator[Case]]
    whole: int
    """Number of rows of a whole table, about."""
    place: Callable[[Case], tuple[Array, float]]
    """Numbers of a row, and the peak speed of plate or swing, mm/s."""
    fit: Callable[[Array, int], dict[str, npt.NDArray[Any]]]
    table: Path
    report: Callable[[dict[str, npt.NDArray[Any]]], str]


def of_plate(case: Case) -> tuple[Array, float]:
    """Numbers of a walker on a shaken plate, and the plate's peak speed, mm/s."""
    place = discrepancy.place_of(case.scene, case.design, solids.mass_of(case.design))
    return np.array([case.design.rigid, *place]), case.scene.drive.peak_speed


def of_motor(case: Case) -> tuple[Array, float]:
    """Numbers of a walker with a motor, and the peak speed of its swing, mm/s."""
    tabled = motors.placed(case.scene, case.design, solids.mass_of(case.design))
    return np.array([*tabled.place[: motors.SHARED], *tabled.beside]), tabled.swing


MEASURED = ("speed", "se", "runs")

PLATES = Kind(
    Path(__file__).with_name("rows.csv"),
    ("braced", *Place._fields, *MEASURED),
    cases.cases,
    cases.COUNT,
    of_plate,
    fit.table,
    discrepancy.TABLE.path,
    fit.report,
)
"""Shaken plates; `braced` is 1 for braced legs."""

MOTORS = Kind(
    Path(__file__).with_name("motor_rows.csv"),
    (*motors.NAMES, *MEASURED),
    motor_cases.cases,
    motor_cases.COUNT,
    of_motor,
    motor_fit.table,
    motors.TABLE.path,
    motor_fit.report,
)

KINDS = {"plates": PLATES, "motors": MOTORS}


def rows(kind: Kind, chosen: Sequence[Case], cores: int) -> Iterator[Array]:
    """Rows of the table, simulated or found in the store; none of runs that end badly."""
    points = [Point(case.design, case.scene, simulated=True, keep=()) for case in chosen]
    progress = Progress(len(points))
    with worker_pool.local(cores) as workers:
        for case, done in zip(chosen, run.each(points, Store(), workers), strict=True):
            progress.add(0.0 if done.stored else _seconds(case))
            numbers = row(kind, case, done.record)
            if numbers is not None:
                yield numbers
    progress.end()


def with_settings(case: Case, settings: Sequence[str]) -> Case:
    """Case with keys of its scene set anew, each as in "run.step_us=2"."""
    values = dict(setting.split("=", 1) for setting in settings)
    return case._replace(scene=case.scene.variant(**{k: json.loads(v) for k, v in values.items()}))


def row(kind: Kind, case: Case, record: Record) -> Array | None:
    """Numbers of a row in the order of its columns; None without a speed that has an error."""
    speed, se, runs = (record.get(name) for name in ("speed_mm_s", "se_mm_s", "runs"))
    if speed is None or se is None or runs is None:
        return None
    place, peak = kind.place(case)
    return np.array([*place, float(speed) / peak, float(se) / peak, runs])


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
            file=sys.stderr,
            flush=True,
        )


def read(kind: Kind = PLATES) -> Array:
    """Rows of a file, in the order of its columns."""
    with kind.rows.open(encoding="utf-8", newline="") as stream:
        reader = csv.reader(stream)
        if tuple(next(reader)) != kind.columns:
            raise SystemExit(f"{kind.rows.name} is of another walkergen: simulate anew")
        return np.array([[float(value) for value in line] for line in reader])


def write(kind: Kind, table: Array) -> None:
    """Write a file of rows, numbers with five digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(kind.columns)
    writer.writerows([f"{value:.5g}" for value in row] for row in table)
    output.write(kind.rows, text.getvalue().encode())


def main() -> None:
    """Simulate the rows, or read them, and write the tables with their errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cores", type=int, default=worker_pool.cores(), help="processes to simulate in")
    parser.add_argument("--only", choices=KINDS, help="one of the tables; without: all")
    parser.add_argument(
        "--rows",
        type=int,
        help="rows of each table, about; without: 6700 of plates, in 45 minutes on two cores, and "
        f"{motor_cases.COUNT} of motors, in half an hour of one",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="key of every row's scene, such as run.step_us=2",
    )
    parser.add_argument("--refit", action="store_true", help="fit the stored rows anew, without simulating")
    options = parser.parse_args()
    for kind in [KINDS[options.only]] if options.only else KINDS.values():
        if not options.refit:
            chosen = [with_settings(case, options.set) for case in kind.cases(options.rows or kind.whole)]
            write(kind, np.array(list(rows(kind, chosen, options.cores))))
        fitted = kind.fit(read(kind), options.cores)
        output.write(kind.table, fit.as_bytes(fitted))
        print(kind.report(fitted))


if __name__ == "__main__":
    main()
