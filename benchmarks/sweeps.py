"""What a sweep costs beyond the simulations in it: overhead, workers, re-runs, memory.

Rivals, in the same run: the bare simulation of the same points in a loop, one worker in place of
two, the first run in place of the second, a tenth of the points.

    python benchmarks/sweeps.py [--points 10000] [--simulated 48]
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep import axes
from walkergen.guests.sweep import evaluation as run
from walkergen.guests.sweep.make import make_sweep
from walkergen.guests.sweep.request import SweepRequest
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points import walkers
from walkergen.points.experiments import Walker
from walkergen.points.point import Point
from walkergen.points.store import Store
from walkergen.points.worker_pool import local_pool

REPEATS = 3

MEMORY = """
import resource, sys
from walkergen.cli import command_line
from walkergen.points import experiments
if __name__ == "__main__":
    try:
        command_line(["sweep", "--set", sys.argv[1], "--workers", "1", "--no-pictures", "--quiet",
             "--out", sys.argv[2]])
    except SystemExit:
        pass
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def silent(what: str, done: int, total: int) -> None:
    """Progress that reports nothing."""


def request_of(count: int, model: str = "prediction") -> SweepPoints:
    design = templates.load("koumakis2016", "walkers", Design)
    scene = templates.load("lane-90hz", "scenes", Scene).variant(**{"run.runs": 4, "run.seconds": 4.0})
    space = axes.Space((axes.parse(f"legs.tilt_deg=1:40:{39 / (count - 1):.9g}"),))
    return SweepPoints(design, scene, space, model)


def overhead(count: int, folder: Path) -> None:
    """Points of short runs through the store against their masses and simulations in a loop."""
    request = request_of(count, "space")
    short = request.scene.variant(**{"run.runs": 4, "run.seconds": 0.05, "run.discard_seconds": 0.0})
    asked = [one for one in request._replace(scene=short).points() if isinstance(one, Point)]
    list(run.evaluate_points(asked[:1], Store(folder / "warm")))
    times = []
    for number in range(REPEATS):
        started = time.perf_counter()
        for one in asked:
            walkers.simulate(Walker(one.scene, one.design, solids.mass_of(one.design)), silent, 1)
        middle = time.perf_counter()
        list(run.evaluate_points(asked, Store(folder / f"overhead{number}")))
        times.append((middle - started, time.perf_counter() - middle))
    bare, whole = (1e3 * min(column) / count for column in zip(*times, strict=True))
    print(f"{count} simulated points: {bare:.2f} ms each in a loop, {whole - bare:+.2f} ms here")


def workers(count: int, folder: Path) -> None:
    """One worker process against two, after they have started."""
    times = []
    for number in (1, 2):
        request = request_of(count, "space")
        asked = [one for one in request.points() if isinstance(one, Point)]
        asked = [one._replace(scene=one.scene.variant(**{"run.runs": 16})) for one in asked]
        with local_pool(number) as pool:
            store = Store(folder / f"workers{number}")
            list(run.evaluate_points(asked[: 2 * number], store, pool))
            started = time.perf_counter()
            list(run.evaluate_points(asked[4:], store, pool))
            times.append(time.perf_counter() - started)
    print(f"two workers: {times[0] / times[1]:.2f} times one ({times[0]:.1f} s, {times[1]:.1f} s)")


def time_predictions(count: int, folder: Path) -> None:
    """Predicted points on one core, and the same sweep again, finished, and extended by one."""
    request, store = request_of(count), Store(folder / "predicted")
    bare = SweepRequest.from_values({"pictures": False}, shell=True)
    tilts = axes.Axis("legs.tilt_deg", (*request.space.axes[0].values, 40.5))
    one_more = request._replace(space=axes.Space((tilts,)))
    for kind, one in (("first", request), ("again", request), ("one more", one_more)):
        started, used = time.perf_counter(), time.process_time()
        make_sweep(bare, one, folder / "table", store, None, silent)
        print(
            f"{count} predicted points, {kind}: {time.perf_counter() - started:.2f} s "
            f"({time.process_time() - used:.2f} s CPU)"
        )


def memory(count: int, folder: Path) -> None:
    """Peak memory of a sweep, and of one with a tenth of its points."""
    script = folder / "memory.py"
    script.write_text(MEMORY)
    for number in (count // 10, count):
        step = f"legs.tilt_deg=1:40:{39 / number:.9g}"
        words = [sys.executable, str(script), step, str(folder / f"memory{number}")]
        peak = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        print(f"{number} points: {float(peak):.0f} MB at most")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--simulated", type=int, default=48)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        overhead(chosen.simulated, folder)
        workers(chosen.simulated, folder)
        time_predictions(chosen.points, folder)
        memory(chosen.points, folder)


if __name__ == "__main__":
    main()
