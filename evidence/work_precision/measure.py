"""Measurement of points.csv: `python -m evidence.work_precision.measure [--out FILE]`, forty minutes of one core.

Each engine runs the same walker (case.py) at its own settings. The true error of a setting is the difference of its
mean speed from that engine's own reference, so different contact laws do not count as errors. CPU time is
that of one core for a simulated second. Rows are added one by one; a second call goes on after the last.
"""

import argparse
import csv
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from evidence.work_precision.case import DISCARD_S, load_case
from walkergen import __version__
from walkergen.core.simulation.run import compile_kernels
from walkergen.points import walkers

POINTS_PATH = Path(__file__).with_name("points.csv")

OURS, MUJOCO, DRAKE = "walkergen", "MuJoCo", "Drake CENIC"

SECONDS = 2.0
"""Measured time of one run, s."""


class Setting(NamedTuple):
    """Setting of an engine: step over walkergen's own, steps in a period (MuJoCo), or accuracy (Drake)."""

    engine: str
    value: float
    runs: int
    is_reference: bool = False


SETTINGS = (
    *(Setting(OURS, share, 64) for share in (2.9, 2.2, 1.0, 0.5, 0.25)),
    Setting(OURS, 0.05, 640, is_reference=True),
    *(Setting(MUJOCO, steps, 32) for steps in (200.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0)),
    Setting(MUJOCO, 8000.0, 64, is_reference=True),
    *(Setting(DRAKE, accuracy, 32) for accuracy in (1e-2, 1e-3, 1e-4, 1e-5)),
    Setting(DRAKE, 1e-6, 16),
    Setting(DRAKE, 1e-7, 8),
    Setting(DRAKE, 1e-8, 8, is_reference=True),
)
"""Settings; the finest of each engine is its reference."""


class Row(NamedTuple):
    """Measured setting; the field names are columns."""

    engine: str
    setting: str
    is_reference: int
    speed_mm_s: float
    se_mm_s: float
    runs: int
    diverged: int
    cpu_s_per_s: float


def measure_row(setting: Setting) -> Row:
    """Measure a setting."""
    if setting.engine == OURS:
        return _measure_ours(setting)
    simulate, label = _rival(setting)
    started = time.process_time()
    speeds = np.array([simulate(seed) for seed in range(setting.runs)])
    cpu_s = (time.process_time() - started) / (setting.runs * (SECONDS + DISCARD_S))
    well = speeds[np.isfinite(speeds)]
    mean = float(well.mean()) if len(well) else float("nan")
    se = float(well.std(ddof=1) / np.sqrt(len(well))) if len(well) > 1 else float("nan")
    diverged = setting.runs - len(well)
    return Row(setting.engine, label, int(setting.is_reference), mean, se, setting.runs, diverged, cpu_s)


def _rival(setting: Setting) -> tuple[Callable[[int], float], str]:
    """Return the simulation of a rival engine for a seed, and the name of its setting."""
    case = load_case()
    if setting.engine == MUJOCO:
        from evidence.work_precision import mujoco_walker

        step_us = 1e6 * case.period / setting.value
        return lambda seed: mujoco_walker.simulate_speed(case, setting.value, SECONDS, seed), f"{step_us:.3g} us"
    from evidence.work_precision import drake_walker

    walker = drake_walker.DrakeWalker(case)
    return lambda seed: drake_walker.simulate_speed(walker, setting.value, SECONDS, seed), f"{setting.value:g}"


def _measure_ours(setting: Setting) -> Row:
    """Measure a setting of walkergen."""
    own = load_case().walker
    step_us = 1e6 * setting.value * own.plan().world.options.step
    timing = {"runs": setting.runs, "seconds": SECONDS, "discard_seconds": DISCARD_S, "seed": 5}
    walker = own.with_run_settings(**timing, step_us=step_us)
    compile_kernels(walker.plan())
    summary = walkers.simulate(walker, threads=1).summary
    cpu_s = summary.cpu_s / (setting.runs * (SECONDS + DISCARD_S))
    speed, reference = summary.speed, int(setting.is_reference)
    return Row(OURS, f"{step_us:.3g} us", reference, speed.number, speed.se or 0.0, setting.runs, 0, cpu_s)


def read_rows(path: Path = POINTS_PATH) -> list[Row]:
    """Read the measured settings."""
    with path.open(encoding="utf-8", newline="") as stream:
        lines = csv.reader(line for line in stream if not line.startswith("#"))
        next(lines)
        return [Row(e, s, int(r), float(v), float(se), int(n), int(d), float(c)) for e, s, r, v, se, n, d, c in lines]


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write the measured settings, with numbers of four digits."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        stream.write(f"# walkergen {__version__}, {_versions()}: python -m evidence.work_precision.measure\n")
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(Row._fields)
        table.writerows([f"{cell:.4g}" if isinstance(cell, float) else cell for cell in row] for row in rows)


def _versions() -> str:
    from importlib import metadata

    return ", ".join(f"{name} {metadata.version(name)}" for name in ("mujoco", "drake"))


def main() -> None:
    """Measure what a file lacks, and add it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=POINTS_PATH)
    path = parser.parse_args().out
    rows = read_rows(path) if path.exists() else []
    for setting in SETTINGS[len(rows) :]:
        rows.append(measure_row(setting))
        write_rows(path, rows)
        print(rows[-1], flush=True)


if __name__ == "__main__":
    main()
