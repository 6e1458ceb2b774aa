"""Whole commands against their goals: what a person waits for who asks one thing.

Each is a process of its own; of several rounds, in which all commands take turns, the least CPU time
(user) counts, for whatever else runs on the machine only adds. Kernels and byte code are there: an
untimed round goes first. Below each group stand its rivals: the libraries that it rests on, imported
and no more, and a bare script of manifold3d that writes the same parts.

    python benchmarks/starts.py [--repeats 3] [--only plate,family]

Ends with 1 where a command is over its goal.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

SWEEP = """design = "koumakis2016"
[grid]
"legs.tilt_deg" = [0.0, 5.0, 10.0, 15.0, 20.0]
"legs.flexible_thickness_mm" = [0.3, 0.35, 0.4, 0.45]
"legs.length_mm" = [7.5, 8.0, 8.5, 9.0, 9.5]
"body.length_mm" = [14.0, 15.0, 16.0, 17.0, 18.0]
"""
"""Sweep of 500 walkers."""

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
}
"""CPU times (s) that commands may take; None where a row is there to compare with."""

RIVALS = {
    "import typer, pydantic, numpy": ("-c", "import typer, pydantic, numpy"),
    "import numba, scipy.linalg": ("-c", "import numba, numba.np.arraymath, scipy.linalg"),
    "import matplotlib.figure": ("-c", "import matplotlib.figure, matplotlib.backends.backend_agg"),
    "bare manifold3d, 160 parts": (str(Path(__file__).with_name("modellers.py").resolve()), "--all", "parts"),
}

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
        started = time.perf_counter()
        process = subprocess.Popen([sys.executable, *words], cwd=folder, env=surroundings, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        if status:
            raise SystemExit(f"{' '.join(words)}: ended with {status}")
        return Cost(usage.ru_utime, time.perf_counter() - started, usage.ru_maxrss / 1024.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", default="", help="commands, comma-separated; rivals are always there")
    options = parser.parse_args()
    only = {word for word in options.only.split(",") if word}
    commands = {words: goal for words, goal in GOALS_S.items() if not only or words[0] in only}
    rows = {" ".join(words): ("-m", "walkergen", *words) for words in commands} | RIVALS
    taken: dict[str, list[Cost]] = {name: [] for name in rows}
    for number in range(options.repeats + 1):
        for name, words in rows.items():
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
