"""Whole commands against their budgets: what a person waits for who asks one thing.

Each is a process of its own, as often as --repeats says; the least wall time counts, for whatever
else runs on the machine only adds. Kernels and byte code are there: an untimed call goes first.

    python benchmarks/starts.py [--repeats 5]

Ends with 1 where a command is over its budget: compare on an idle machine only.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time

BUDGETS_S = {
    ("--help",): 0.1,
    ("predict", "--tilt", "10"): 0.6,
    ("simulate", "--tilt", "10", "--seconds", "1", "--runs", "4"): 0.9,
    ("family", "--quiet"): 3.0,  # 20 walkers, with pictures
}
"""Wall times (s) that commands may take."""


def seconds(words: tuple[str, ...]) -> float:
    """Wall time of a command in an empty folder."""
    # Python keeps byte code, as it does for people
    unset = {"PYTHONDONTWRITEBYTECODE"}
    surroundings = {name: value for name, value in os.environ.items() if name not in unset}
    with tempfile.TemporaryDirectory() as folder:
        started = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "walkergen", *words],
            cwd=folder,
            check=True,
            env=surroundings,
            stdout=subprocess.DEVNULL,
        )
        return time.perf_counter() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    over = 0
    print(f"{'command':<50} {'budget_s':>8} {'least_s':>8} {'median_s':>8}")
    for words, budget in BUDGETS_S.items():
        seconds(words)
        taken = sorted(seconds(words) for _ in range(repeats))
        over += taken[0] > budget
        print(f"{' '.join(words):<50} {budget:8.2f} {taken[0]:8.2f} {taken[repeats // 2]:8.2f}")
    if hasattr(os, "getloadavg"):
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    sys.exit(int(over > 0))


if __name__ == "__main__":
    main()
