"""Whole commands against their goals: what a person waits for who asks one thing.

Each is a process of its own; all commands take turns in several rounds, and the least CPU time
(user) counts, because other programs on the machine only add to it. Kernels and byte code are there: an
untimed round goes first. Below each group stand its rivals: the libraries that it rests on, imported
and no more, and a bare script of manifold3d that writes the same parts.

    python benchmarks/starts.py [--repeats 3] [--only plate,family] [--long]

With --long also commands of a minute, once each. Ends with 1 where a command is over its goal.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

SWEEP = """design = "koumakis2016"
[grid]
"legs.tilt_deg" = [0.0, 5.0, 10.0, 15.0, 20.0]
"legs.flexible_thickness_mm" = [0.3, 0.35, 0.4, 0.45]
"legs.length_mm" = [7.5, 8.0, 8.5, 9.0, 9.5]
"body.length_mm" = [14.0, 15.0, 16.0, 17.0, 18.0]
"""
"""Sweep of 500 walkers."""

MODELLERS = str(Path(__file__).with_name("modellers.py").resolve())

BOTH = ("--legs", "flexible,braced", "--quiet")
GOALS_S: dict[tuple[str, ...], float | None] = {
    ("--help",): 0.1,
    ("predict", "--tilt", "10"): 0.35,
    ("export",): 0.35,
    ("plate",): 0.6,
    ("simulate", "--tilt", "10", "--seconds", "1", "--runs", "4"): 0.9,
    ("export", "--tilt", "0:39.5:0.5", *BOTH): None,
    ("family", "--tilt", "0:39.5:0.5", *BOTH, "--no-pictures"): 1.2,
    ("family", "--tilt", "0:39.5:0.5", *BOTH): 2.5,
    ("family", "--tilt", "0:39.5:0.125", *BOTH, "--no-pictures"): None,
    ("export", "--sweep", "sweep.toml", "--quiet"): None,
    ("analyse", "few.csv", "--fps", "25"): 0.6,
    ("movie", "--tilt", "10", "--quiet"): 3.0,
}
"""CPU times (s) that commands may take; None where a row is there to compare with."""

CROWD = ("crowd", "--count", "30", "--arena", "disc:169", "--runs", "1", "--no-pictures", "--quiet")
LONG_S: dict[tuple[str, ...], float | None] = {
    ("analyse", "many.csv", "--fps", "25"): 8.0,
    (*CROWD, "--seconds", "20"): 25.0,
    ("simulate", "--scene", "plane-90hz", "--seconds", "20", "--runs", "30", "--quiet"): None,
}
"""The same of long ones: a million rows of 100 particles; 30 walkers on 0.3 of a dish, and as many that are alone."""

TRACKS = {"few.csv": (10, 200), "many.csv": (100, 10_000)}
"""Files of tracks: particles and frames."""

MEAN_SQUARE = """import sys, pandas, trackpy
rows = pandas.read_csv(sys.argv[1]).rename(columns={"track": "particle", "x_mm": "x", "y_mm": "y"})
trackpy.emsd(rows, 1, 25, max_lagtime=100)
"""
"""Script that reads tracks and takes their mean squared displacement with trackpy, and no more."""

RIVALS = {
    "import typer, pydantic, numpy": ("-c", "import typer, pydantic, numpy"),
    "import numba, scipy.linalg": ("-c", "import numba, numba.np.arraymath, scipy.linalg"),
    "import matplotlib.figure": ("-c", "import matplotlib.figure, matplotlib.backends.backend_agg"),
    "bare manifold3d, 160 parts": (MODELLERS, "--all", "bare", "parts"),
    "manifold3d and trimesh, 160 parts": (MODELLERS, "--all", "trimesh", "parts"),
    "trackpy, few.csv": ("-c", MEAN_SQUARE, "few.csv"),
}
LONG_RIVALS = {"trackpy, many.csv": ("-c", MEAN_SQUARE, "many.csv")}

SMALL, LARGE = 160, 634
PARTS = {
    count: ("family", "--tilt", f"0:39.5:{step}", *BOTH, "--no-pictures")
    for count, step in ((SMALL, "0.5"), (LARGE, "0.125"))
}
"""Families whose difference is what a further part costs; its goal is 3 ms."""


class Cost(NamedTuple):
    """Cost of a process."""

    cpu_s: float
    wall_s: float
    memory_mib: float


def cost(words: tuple[str, ...]) -> Cost:
    """Cost of Python with these words, in a new folder."""
    # Python keeps byte code, as it does for people
    surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "sweep.toml").write_text(SWEEP)
        for name in TRACKS.keys() & set(words):
            _write_tracks(Path(folder, name), *TRACKS[name])
        started = time.perf_counter()
        with Path(folder, "errors").open("w+") as errors:
            streams = {"stdout": subprocess.DEVNULL, "stderr": errors}
            process = subprocess.Popen([sys.executable, *words], cwd=folder, env=surroundings, **streams)
            _, status, usage = os.wait4(process.pid, 0)
            if status:
                errors.seek(0)
                raise SystemExit(f"{' '.join(words)}: ended with {status}: {errors.read()}")
        return Cost(usage.ru_utime, time.perf_counter() - started, usage.ru_maxrss / 1024.0)


def _write_tracks(path: Path, particles: int, frames: int) -> None:
    """Write tracks of particles that run at 60 mm/s and turn by chance within 2 s, at 25 frames a second."""
    rng = np.random.default_rng(1)
    headings = np.cumsum(rng.normal(0.0, 0.2, (frames, particles)), axis=0) + rng.uniform(0.0, 6.3, particles)
    x, y = (np.cumsum(2.4 * turn(headings), axis=0) for turn in (np.cos, np.sin))
    frame, track = np.divmod(np.arange(frames * particles), particles)
    rows = np.column_stack([frame, track, x.ravel(), y.ravel(), headings.ravel()])
    np.savetxt(path, rows, "%d,%d,%.4f,%.4f,%.5f", header="frame,track,x_mm,y_mm,theta_rad", comments="")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", default="", help="commands, comma-separated; rivals are always there")
    parser.add_argument("--long", action="store_true", help="also commands of a minute, once each")
    options = parser.parse_args()
    only = {word for word in options.only.split(",") if word}
    every = GOALS_S | (LONG_S if options.long else {})
    commands = {words: goal for words, goal in every.items() if not only or words[0] in only}
    rows = {" ".join(words): ("-m", "walkergen", *words) for words in commands} | RIVALS
    rows |= LONG_RIVALS if options.long else {}
    once_only = {" ".join(words) for words in LONG_S} | set(LONG_RIVALS)
    taken: dict[str, list[Cost]] = {name: [] for name in rows}
    for number in range(options.repeats + 1):
        for name, words in rows.items():
            if name in once_only and number != options.repeats:
                continue
            once = cost(words)
            taken[name] += [once] if number else []
    goals = {" ".join(words): goal for words, goal in commands.items()}
    print(f"{'process':<74}{'goal_s':>8}{'cpu_s':>8}{'wall_s':>8}{'MiB':>6}")
    least = {name: Cost(*map(min, zip(*costs, strict=True))) for name, costs in taken.items()}
    for name, best in least.items():
        goal = goals.get(name)
        print(f"{name:<74}{goal or '':>8}{best.cpu_s:8.2f}{best.wall_s:8.2f}{best.memory_mib:6.0f}")
    few, many = (least.get(" ".join(words)) for words in PARTS.values())
    if few and many:
        print(f"a further part of a family: {1e3 * (many.cpu_s - few.cpu_s) / (LARGE - SMALL):.1f} ms, goal 3")
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    sys.exit(int(any(goal and least[name].cpu_s > goal for name, goal in goals.items())))


if __name__ == "__main__":
    main()
