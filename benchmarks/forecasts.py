"""Forecast and actual times of commands: CPU seconds of one core.

The process keeps to one core, where clock time equals CPU time on a busy machine too; what a
forecast itself takes, compilation included, is left out. Numbers that are kept from earlier runs are not used.

    python benchmarks/forecasts.py [--only sweep]
"""

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from walkergen import inputs
from walkergen.command_table import load_request
from walkergen.core import caches
from walkergen.core.files.progress import Expected, silent

SPEEDS = "tilt_deg,plate_speed_mm_s,speed_mm_s,speed_se_mm_s\n10,31.2,60,3\n20,31.2,90,5\n"

RUNS = {"runs": 4, "seconds": 5.0}

SETTINGS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("simulate", RUNS),
    ("simulate", RUNS | {"scene": "plane-90hz", "tilt": "5"}),
    ("simulate", RUNS | {"tilt": "5,15,30"}),
    ("simulate", RUNS | {"set": {"scene.feet.rigid_tips": True}}),
    ("simulate", {"error": "3%"}),
    ("simulate", {"uncertain": True, "draws": 16, "seconds": 2.0}),
    ("sweep", {"set": ["legs.tilt_deg=1:60:0.25"]}),
    ("sweep", {"set": ["legs.tilt_deg=2:40:2", "scene.run.runs=4", "scene.run.seconds=2"], "model": "space"}),
    (
        "sweep",
        {"set": ["scene.contact.friction=0.1:0.5:0.05", "scene.run.runs=2", "scene.run.seconds=6"], "model": "space"},
    ),
    ("sweep", {"set": ["legs.tilt_deg=5:40:2.5"], "model": "space", "error": "10%"}),
    ("fit", {"model": "space", "predict": "15"}),
    ("crowd", {"count": 3, "seconds": 2.0, "runs": 2, "pictures": False}),
    ("crowd", {"count": 8, "arena": "disc:120", "seconds": 1.0, "runs": 2, "pictures": False}),
    ("movie", {}),
    ("movie", {"tilt": "5,10", "seconds": 4.0}),
)


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Keep to one core and this process, and to a store of points of this run."""
    kept: Callable[[str], Path] = caches.folder
    caches.folder = lambda name: folder if name == "points" else kept(name)

    @contextmanager
    def no_pool(*_: object) -> Iterator[None]:
        yield None

    inputs.open_pool = no_pool
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    yield


def cpu_seconds() -> float:
    """CPU time of this process and of those that it has waited for, s."""
    times = os.times()
    return times.user + times.children_user


def compare_forecast(name: str, values: dict[str, Any], folder: Path) -> tuple[float | None, float]:
    """Forecast of a command and the time after it, s; None without a forecast."""
    forecasts: list[tuple[float | None, float]] = []

    def record(find: Callable[[], Expected | None]) -> None:
        expected = find()
        forecasts.append((None if expected is None else expected.seconds, cpu_seconds()))

    more: dict[str, Any] = {}
    if name == "fit":
        more["speeds"] = folder / "speeds.csv"
        more["speeds"].write_text(SPEEDS)
    if name in ("crowd", "fit", "movie"):
        more["out"] = folder / ("film.gif" if name == "movie" else "folder")
    request = load_request(name).from_values(values | more)
    request.register_time_callback(record)
    request.run(silent)
    return (forecasts[0][0], cpu_seconds() - forecasts[0][1]) if forecasts else (None, 0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", help="begin of the lines to print, as sweep")
    wanted = parser.parse_args().only or ""
    print(f"{'forecast':>8} {'took':>7} {'ratio':>6}   command")
    for name, values in SETTINGS:
        words = " ".join([name, *(f"{key}={value}" for key, value in values.items())])
        if not words.startswith(wanted):
            continue
        with tempfile.TemporaryDirectory() as made, alone(Path(made)):
            forecast, took = compare_forecast(name, values, Path(made))
        ratio = "" if forecast is None else f"{forecast / took:6.2f}"
        print(f"{'-' if forecast is None else f'{forecast:.2f}':>7} {took:7.2f} {ratio:>6}   {words}", flush=True)


if __name__ == "__main__":
    started = time.perf_counter()
    main()
    print(f"{time.perf_counter() - started:.0f} s, load {os.getloadavg()[0]:.1f}", file=sys.stderr)
