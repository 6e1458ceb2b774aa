"""Simulation of the rows that the surrogate learns from: `python -m evidence.tables.simulate`.

Rows stand in rows.csv beside this file, made in their order and added at once: a run that was killed goes on
from the last whole line. 11 700 rows take three hours of one core.
"""

import argparse
import csv
import time
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path

from evidence.tables import settings
from evidence.tables.settings import Row
from walkergen.cli import show
from walkergen.errors import WalkergenError
from walkergen.points import walkers, worker_pool
from walkergen.simulation.experiments import Walker
from walkergen.simulation.run import Outcome
from walkergen.walker import solids

ROWS = Path(__file__).with_name("rows.csv")

MEASURED = ("speed_mm_s", "se_mm_s", "runs", "toppled")
"""Columns beside the keys: mean speed of the runs that ended well, its standard error, and how many runs did and
toppled; blank where none tells."""

COLUMNS = ("held_out", *settings.KEYS, *MEASURED)

CHUNK = 16
"""Rows that a worker takes at a time."""


def measured(row: Row) -> Row:
    """Row with its simulated speed; its own blanks where the scene and the walker contradict each other."""
    case = settings.case(row)
    try:
        results = walkers.simulate(Walker(case.scene, case.design, solids.mass_of(case.design)), threads=1)
    except WalkergenError:
        return row | dict.fromkeys(MEASURED)
    summary = results.summary
    return row | {
        "speed_mm_s": summary.speed_mm_s,
        "se_mm_s": summary.speed_se_mm_s,
        "runs": float(summary.runs),
        "toppled": float(summary.outcomes.get(Outcome.TOPPLED.value, 0)),
    }


def read(path: Path = ROWS) -> list[Row]:
    """Rows of a file by the names of their columns, None where one is blank."""
    with path.open(encoding="utf-8", newline="") as stream:
        return [{key: float(text) if text else None for key, text in line.items()} for line in csv.DictReader(stream)]


def wanted() -> Iterator[Row]:
    """Settings of all rows, held-out ones spread among the others."""
    ratio = settings.ROWS // settings.TESTS
    tests = settings.rows(settings.TESTS, settings.SEED + 1, held_out=True)
    for number, row in enumerate(settings.rows(settings.ROWS, settings.SEED, held_out=False)):
        if number % ratio == 0:
            yield from islice(tests, 1)
        yield row


def line(row: Row) -> list[str]:
    """Cells of a row, numbers with five digits."""
    return ["" if (value := row[name]) is None else f"{value:.5g}" for name in COLUMNS]


def add(path: Path, rows: Sequence[Row], cores: int, seconds: float) -> None:
    """Simulate rows in their order, and add them to a file, until the time is over."""
    end = time.monotonic() + seconds
    with worker_pool.local(cores) as pool, path.open("a", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        with show.progress("rows", wanted=True) as progress:
            made = chain.from_iterable(
                pool.executor.map(measured, rows[first : first + CHUNK * cores], chunksize=1)
                for first in range(0, len(rows), CHUNK * cores)
                if time.monotonic() < end
            )
            for number, row in enumerate(made, 1):
                writer.writerow(line(row))
                stream.flush()
                progress("rows", number, len(rows))


def main() -> None:
    """Simulate the rows that are not there yet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cores", type=int, default=worker_pool.cores(), help="processes to simulate in")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="time to begin rows in")
    parser.add_argument("--out", type=Path, default=ROWS, help="file of the rows")
    options = parser.parse_args()
    done = len(read(options.out)) if options.out.exists() else 0
    if not done:
        options.out.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    add(options.out, list(islice(wanted(), done, None)), options.cores, options.seconds)


if __name__ == "__main__":
    main()
