"""Test of the surrogate in `predict`: random settings, each compared with its nominal run.

`python -m evidence.tables.held_out` draws settings of every key, a third of them at the ends of ranges, keeps the
first 200 that the surrogate answers, simulates each directly and writes docs/surrogate.csv and its picture;
docs/appendix/surrogate.md has the results. Settings are of another seed than the rows that the surrogate learnt from.
"""

import argparse
import contextlib
import csv
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from evidence.tables import settings
from evidence.tables.settings import Row
from walkergen.cli import console
from walkergen.core import measure
from walkergen.core.errors import WalkergenError
from walkergen.core.scene import Run
from walkergen.core.theory import surrogate
from walkergen.core.theory.prediction import STANDING_MM_S
from walkergen.core.theory.surrogate import NORMAL_95, FallsError, UnknownError
from walkergen.core.walker import solids
from walkergen.files import figures
from walkergen.points import walkers, worker_pool
from walkergen.points.experiments import Walker
from walkergen.points.short_simulation import MAX_FALL_SHARE

DOCS = Path(__file__).parents[2] / "docs"

SETTING_COUNT, SEED = 200, 2026

DIRECT_RUN = Run(seconds=4.0, discard_seconds=0.5, runs=16, seed=77)
"""Runs of the direct simulation."""

MEDIAN_SHARE, MEDIAN_MM_S = 0.04, 0.5


class Compared(NamedTuple):
    """Setting that the surrogate answered, and its direct run; the field names are columns."""

    tilt_deg: float
    lane: int
    lively: int
    """Number of keys that left their defaults."""
    surrogate_mm_s: float | None
    """None where the surrogate answers that the walker falls over."""
    half_95_mm_s: float | None
    direct_mm_s: float | None
    direct_se_mm_s: float | None
    falls: float


def answered_settings(rows: Iterator[Row], counts: list[int]) -> Iterator[Row]:
    """Yield the settings that the surrogate answers. `counts` counts all settings."""
    for row in rows:
        case = settings.make_case(row)
        counts[0] += 1
        try:
            surrogate.case_in_domain(case.scene, case.design, solids.mass_of(case.design))
        except FallsError:
            pass
        except UnknownError:
            continue
        yield row


def compare_setting(row: Row) -> Compared | None:
    """Compare the surrogate with the direct run of a setting. Return None if it cannot be simulated."""
    case = settings.make_case(row)
    mass = solids.mass_of(case.design)
    speed, half = None, None
    with contextlib.suppress(FallsError):
        speed, se = surrogate.case_in_domain(case.scene, case.design, mass).nominal
        half = NORMAL_95 * se
    scene = case.scene.model_copy(update={"run": DIRECT_RUN})
    try:
        summary = walkers.simulate(Walker(scene, case.design, mass), threads=1).summary
    except WalkergenError:
        return None
    lively = sum(row[name] != key.default for name, key in settings.KEYS.items())
    falls = summary.outcomes.get("toppled", 0) / summary.runs
    lane = int(row["play_mm"] is not None)
    return Compared(row["tilt_deg"] or 0.0, lane, lively, speed, half, summary.speed.value, summary.speed.se, falls)


def is_right(row: Compared) -> bool:
    """Return whether the kind is correct: it runs that way, or stands within 1 mm/s, and does not fall over.

    Within the 95 % bounds of the direct runs either kind is correct.
    """
    falls = row.falls >= MAX_FALL_SHARE or row.direct_mm_s is None
    if row.surrogate_mm_s is None or row.half_95_mm_s is None or falls or row.direct_mm_s is None:
        return falls and row.surrogate_mm_s is None
    noise = NORMAL_95 * (row.direct_se_mm_s or 0.0)
    if abs(row.surrogate_mm_s) < STANDING_MM_S and abs(row.surrogate_mm_s) <= row.half_95_mm_s:
        return abs(row.direct_mm_s) < STANDING_MM_S + noise
    return row.surrogate_mm_s * row.direct_mm_s > 0.0 or abs(row.direct_mm_s) <= noise


def summarize(rows: Sequence[Compared], asked: int) -> list[str]:
    """Summarize the comparison, a line for each goal; the direct runs' own 95 % are added in squares."""
    speeds = [row for row in rows if row.surrogate_mm_s is not None]
    good = [row for row in speeds if row.direct_mm_s is not None and row.direct_se_mm_s is not None]
    predicted, half, direct, se = (
        np.array([getattr(row, name) for row in good], float)
        for name in ("surrogate_mm_s", "half_95_mm_s", "direct_mm_s", "direct_se_mm_s")
    )
    off, noise = np.abs(predicted - direct), NORMAL_95 * se
    near = np.maximum(MEDIAN_SHARE * np.abs(direct), MEDIAN_MM_S)
    goal = settings.goal_error(direct)
    falls = np.mean([row.falls > 0.0 for row in speeds])
    fallen = [row.falls >= MAX_FALL_SHARE for row in rows if row.surrogate_mm_s is None]
    return [
        f"{asked} settings asked, {len(rows)} answered ({100 * len(rows) / asked:.0f} %), {len(good)} speeds compared",
        f"falls over: predicted for {len(fallen)}, true of {sum(fallen)}",
        f"median error {np.median(off):.2f} mm/s, {np.median(off / near):.2f} of 4 % or 0.5 mm/s",
        f"within 10 % or 1 mm/s: {np.sum(off <= goal)} ({100 * np.mean(off <= goal):.1f} %); the direct runs' own "
        f"error taken off: {100 * np.mean(off <= np.hypot(goal, noise)):.1f} %",
        f"within the stated 95 %: {100 * np.mean(off <= np.hypot(half, noise)):.1f} %",
        f"mean of surrogate less direct: {np.mean(predicted - direct):+.2f} mm/s",
        f"runs that fell over in {100 * falls:.1f} % of those with a speed",
        f"outcome (runs on, backward, stands, falls over) right in {100 * np.mean([*map(is_right, rows)]):.1f} %",
    ]


def read_rows() -> list[Compared]:
    """Return the rows of the stored table."""
    with (DOCS / "surrogate.csv").open(encoding="utf-8", newline="") as stream:
        return [
            Compared(*(float(text) if text else None for text in line.values()))  # type: ignore[arg-type]
            for line in csv.DictReader(stream)
        ]


def draw_picture(rows: Sequence[Compared]) -> bytes:
    """Draw predicted against simulated speeds. Scales are linear below 1 mm/s, and the goal is a band."""
    figure, axes = figures.new_axes("Surrogate compared with direct runs")
    good = [row for row in rows if row.direct_mm_s is not None and row.surrogate_mm_s is not None]
    x = np.array([row.direct_mm_s for row in good], float)
    y = np.array([row.surrogate_mm_s for row in good])
    halves = np.array([row.half_95_mm_s for row in good])
    ends = 1.3 * max(np.abs(x).max(), np.abs(y).max())
    line = np.concatenate([-np.geomspace(ends, 0.01, 200), np.geomspace(0.01, ends, 200)])
    goal = settings.goal_error(line)
    axes.fill_between(line, line - goal, line + goal, color="0.88", linewidth=0, label="10 % or 1 mm/s")
    axes.plot(line, line, color="0.4", linewidth=0.8)
    figures.draw_points(axes, (x, y, halves), figures.MEASURED, label="a setting, 95 %")
    for scale in (axes.set_xscale, axes.set_yscale):
        scale("symlog", linthresh=1.0, linscale=0.5)
    figures.label_axes(axes, "simulated directly (mm/s)", "surrogate (mm/s)")
    axes.set(xlim=(-ends, ends), ylim=(-ends, ends))
    axes.legend(loc="upper left")
    return figures.png(figure)


def main() -> None:
    """Run the test, and write its table and its picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cores", type=int, default=measure.core_count(), help="processes to simulate in")
    parser.add_argument("--answered", type=int, default=SETTING_COUNT, help="settings that the surrogate answers")
    options = parser.parse_args()
    counts = [0]
    chosen = list(
        islice(
            answered_settings(settings.draw_settings(100 * options.answered, SEED, held_out=False), counts),
            options.answered,
        )
    )
    rows: list[Compared] = []
    with worker_pool.local_pool(options.cores) as pool, console.progress("settings", wanted=True) as progress:
        for number, row in enumerate(pool.executor.map(compare_setting, chosen), 1):
            rows += [] if row is None else [row]
            progress("settings", number, len(chosen))
    with (DOCS / "surrogate.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(Compared._fields)
        writer.writerows([("" if value is None else f"{value:.5g}") for value in row] for row in rows)
    (DOCS / "surrogate.png").write_bytes(draw_picture(rows))
    print("\n".join(summarize(rows, counts[0])))


if __name__ == "__main__":
    main()
