"""Simulation of the rows that the surrogate learns from: `python -m evidence.tables.simulate --out FILE`.

Each row of rows.csv states its setting, so all can be simulated again, in some four hours of one core. Rows are added
to the file one by one, and a run that was killed goes on after the last of them. With `--sampled N` new settings are
drawn (`settings.draw_settings`), held-out ones among them. With `--uncertain N` only those of N new settings are
simulated of which today's surrogate is neither sure nor ignorant: they reduce its error most for their time.
"""

import argparse
import csv
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

from evidence.tables import settings
from evidence.tables.settings import Row
from walkergen.cli import console
from walkergen.core import measure
from walkergen.core.errors import WalkergenError
from walkergen.core.simulation.run import Outcome
from walkergen.core.theory import surrogate
from walkergen.core.theory.surrogate import NORMAL_95, UnknownError
from walkergen.core.walker import solids
from walkergen.points import run_time, walkers, worker_pool
from walkergen.points.experiments import Walker

ROWS_PATH = Path(__file__).with_name("rows.csv")

RESULT_COLUMNS = ("speed_mm_s", "se_mm_s", "runs", "toppled")
"""Columns after the keys: mean speed of the runs that ended well, its standard error, and how many runs did and
toppled; blank where there is none."""

COLUMNS = ("held_out", *settings.KEYS, *RESULT_COLUMNS)

UNCERTAIN_RANGE = 0.7, 8.0
"""Error of the surrogate, over the largest of its answers, from and to which a setting counts as uncertain."""

MAX_ROW_CPU_S = 1.0
"""Largest CPU time, from the number of steps, of an uncertain setting that is simulated, s."""

CHUNK = 4
"""Rows that a worker takes at a time."""


def simulate_row(row: Row) -> Row:
    """Row with its simulated speed; its own blanks where the scene and the walker contradict each other."""
    case = settings.make_case(row)
    try:
        results = walkers.simulate(Walker(case.scene, case.design, solids.mass_of(case.design)), threads=1)
    except WalkergenError:
        return row | dict.fromkeys(RESULT_COLUMNS)
    summary = results.summary
    return row | {
        "speed_mm_s": summary.speed.value,
        "se_mm_s": summary.speed.se,
        "runs": float(summary.runs),
        "toppled": float(summary.outcomes.get(Outcome.TOPPLED.value, 0)),
    }


def read_rows(path: Path = ROWS_PATH) -> list[Row]:
    """Rows of a file by the names of their columns, None where one is blank."""
    with path.open(encoding="utf-8", newline="") as stream:
        return [{key: float(text) if text else None for key, text in line.items()} for line in csv.DictReader(stream)]


def sample_settings(count: int) -> Iterator[Row]:
    """Yield about `count` settings, with held-out ones spread among the others."""
    ratio = settings.ROWS // settings.TESTS
    tests = settings.draw_settings(count // ratio + 1, settings.SEED + 1, held_out=True)
    for number, row in enumerate(settings.draw_settings(count, settings.SEED, held_out=False)):
        if number % ratio == 0:
            yield from islice(tests, 1)
        yield row


def is_uncertain(row: Row) -> bool:
    """Return whether today's surrogate is uncertain of a setting that takes little time to simulate."""
    case = settings.make_case(row)
    walker = Walker(case.scene, case.design, solids.mass_of(case.design))
    run = case.scene.run
    try:
        cpu_s = run.runs * (run.seconds + run.discard_seconds) * run_time.rate_from_steps(walker.plan())
        if cpu_s > MAX_ROW_CPU_S:
            return False
        speed, se = surrogate.case_in_domain(*walker[:3], only_certain=False).nominal
    except UnknownError as error:
        return error.near is not None
    except WalkergenError:
        return False
    ratio = NORMAL_95 * se / surrogate.allowed_error(speed)
    return bool(UNCERTAIN_RANGE[0] < ratio < UNCERTAIN_RANGE[1])


def csv_row(row: Row) -> list[str]:
    """Cells of a row, numbers with five digits."""
    return ["" if (value := row[name]) is None else f"{value:.5g}" for name in COLUMNS]


def add_rows(path: Path, rows: Sequence[Row], cores: int) -> None:
    """Simulate rows, and add them to a file in their order."""
    with worker_pool.local_pool(cores) as pool, path.open("a", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        with console.progress("rows", wanted=True) as progress:
            for number, row in enumerate(pool.executor.map(simulate_row, rows, chunksize=CHUNK), 1):
                writer.writerow(csv_row(row))
                stream.flush()
                progress("rows", number, len(rows))


def main() -> None:
    """Simulate the rows that a file has not yet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cores", type=int, default=measure.core_count(), help="processes to simulate in")
    parser.add_argument("--sampled", type=int, help="number of new settings to draw; without: those of rows.csv")
    parser.add_argument("--uncertain", type=int, help="number of new settings to draw; uncertain ones are simulated")
    parser.add_argument("--out", type=Path, required=True, help="file of the rows")
    options = parser.parse_args()
    if options.uncertain is not None:
        drawn = settings.draw_settings(options.uncertain, settings.SEED + 3, held_out=False)
        wanted = list(filter(is_uncertain, drawn))
    else:
        wanted = read_rows() if options.sampled is None else list(sample_settings(options.sampled))
    done = len(read_rows(options.out)) if options.out.exists() else 0
    if not done:
        options.out.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    add_rows(options.out, wanted[done:], options.cores)


if __name__ == "__main__":
    main()
