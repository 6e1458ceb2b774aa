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
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import cases, motors, plates
from evidence.tables.cases import Case, Group
from walkergen.cli import show
from walkergen.files import output
from walkergen.points import run, worker_pool
from walkergen.points.point import Point, Record
from walkergen.points.store import Store
from walkergen.theory import discrepancy
from walkergen.theory import motors as theory_motors

Array = npt.NDArray[np.float64]


class Kind(NamedTuple):
    """Kind of walkers that has a table of its own."""

    rows: Path
    """File of its rows."""
    columns: tuple[str, ...]
    """Columns of that file: numbers without unit; speeds and their standard errors over the peak
    speed of the plate, or of the motor's swing."""
    groups: Sequence[Group]
    seed: int
    place: Callable[[Case], tuple[Array, float]]
    """Numbers of a row, and the peak speed of plate or swing, mm/s."""
    fit: Callable[[Array, int], dict[str, npt.NDArray[Any]]]
    table: Path

    def cases(self, rows: int) -> Iterator[Case]:
        """Walkers and scenes of about so many rows."""
        return cases.cases(self.groups, rows, self.seed)


MEASURED = ("speed", "se", "runs")

FOLDER = Path(__file__).parent

PLATES = Kind(
    FOLDER / "rows.csv",
    (*plates.COLUMNS, *MEASURED),
    plates.GROUPS,
    plates.SEED,
    plates.place,
    plates.table,
    discrepancy.TABLE.path,
)
MOTORS = Kind(
    FOLDER / "motor_rows.csv",
    (*motors.COLUMNS, *MEASURED),
    motors.GROUPS,
    motors.SEED,
    motors.place,
    motors.table,
    theory_motors.TABLE.path,
)
KINDS = {"plates": PLATES, "motors": MOTORS}


def rows(kind: Kind, chosen: Sequence[Case], cores: int) -> Iterator[Array]:
    """Rows of the table, simulated or found in the store; none of runs that end badly."""
    points = [Point(case.design, case.scene, simulated=True, keep=()) for case in chosen]
    with worker_pool.local(cores) as workers, show.progress("rows", wanted=True) as progress:
        for number, (case, done) in enumerate(zip(chosen, run.each(points, Store(), workers), strict=True), 1):
            progress("rows", number, len(points))
            numbers = row(kind, case, done.record)
            if numbers is not None:
                yield numbers


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


def report(name: str, arrays: Mapping[str, npt.NDArray[Any]]) -> str:
    """Errors of a table, as text."""
    lines = [f"{name}: error at rows left out by tenths, their own noise within (speeds over the peak, after asinh)"]
    errors = json.loads(str(arrays["facts"]))["errors"]
    by_kind = errors if "flexible" in errors else {name: errors}
    for kind, groups in by_kind.items():
        for group, of_group in groups.items():
            numbers = ", ".join(f"{key} {value:.3g}" for key, value in of_group.items())
            lines.append(f"{kind}, {group}: {numbers}")
    return "\n".join(lines)


def as_bytes(arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """File of the table, for `numpy.load`; equal arrays give equal bytes."""
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    return stream.getvalue()


def main() -> None:
    """Simulate the rows, or read them, and write the tables with their errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cores", type=int, default=worker_pool.cores(), help="processes to simulate in")
    parser.add_argument("--only", choices=KINDS, help="one of the tables; without: all")
    number = "rows of each table, about; without: 6700 of plates, in 45 minutes on two cores, and 2800 of motors"
    parser.add_argument("--rows", type=int, help=f"{number}, in half an hour of one")
    setting = "key of every row's scene, such as run.step_us=2"
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=setting)
    parser.add_argument("--refit", action="store_true", help="fit the stored rows anew, without simulating")
    options = parser.parse_args()
    for name, kind in KINDS.items():
        if options.only not in (None, name):
            continue
        if not options.refit:
            count = options.rows or cases.whole(kind.groups)
            chosen = [with_settings(case, options.set) for case in kind.cases(count)]
            write(kind, np.array(list(rows(kind, chosen, options.cores))))
        arrays = kind.fit(read(kind), options.cores)
        output.write(kind.table, as_bytes(arrays))
        print(report(name, arrays))


if __name__ == "__main__":
    main()
