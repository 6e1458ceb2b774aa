"""What space costs: simulated seconds per CPU second against planar models, and what changes them.

    python benchmarks/space.py [--seconds 2] [--runs 4] [--cold]

All ratios come from one run on one machine: space against the compliant walker in its plane; a lane
with walls and a plane; braced walkers (corners without hinges) with walls (eight more points) and
without; a plate at rest; one thread against two. With --cold also the time of the first result in
a new process, with an empty folder of compiled kernels and with a full one.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from predictions import machine

from walkergen.scene import Scene
from walkergen.simulation import ensemble
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

PLANE: dict[str, Any] = {"arena": {"kind": "plane"}}
REST: dict[str, Any] = {"drive": {"frequency_hz": 90.0, "gamma": 1e-6}}
FIRST = ["-m", "walkergen", "simulate", "--scene", "plane-90hz", "--seconds", "0.5", "--runs", "2"]


class Case(NamedTuple):
    """One walker in one scene."""

    name: str
    model: str
    kind: str = "flexible"
    tables: Mapping[str, Any] = MappingProxyType({})


CASES = (
    Case("compliant, lane", "compliant"),
    Case("space, plane", "space", tables=PLANE),
    Case("space, lane with walls", "space"),
    Case("space, held in its plane", "space", tables={"effects": {"roll_and_yaw": False}}),
    Case("space, no twist", "space", tables=PLANE | {"effects": {"leg_twist": False}}),
    Case("space, noisy plate", "space", tables=PLANE | {"plate": {"noise_ratio": 0.2}}),
    Case("space, braced, plane", "space", "braced", PLANE),
    Case("space, braced, lane with walls", "space", "braced"),
    Case("space, plate at rest", "space", tables=PLANE | REST),
)
SHOWN = "space, plane"


def silent(what: str, done: int, total: int) -> None:
    """Show no progress."""


def plan_of(case: Case, seconds: float, runs: int) -> Plan:
    """Plan of a case at 10 deg."""
    design = Design().variant(tilt_deg=10.0, kind=case.kind)
    run = {"seconds": seconds, "discard_seconds": 0.5, "runs": runs}
    scene = Scene.model_validate({"legs": {"model": case.model}, "run": run} | dict(case.tables))
    return prepare(scene, design, solids.mass_of(design))


def per_cpu_second(plan: Plan, threads: int = 1) -> float:
    """Simulated seconds per CPU second of an ensemble, kernels compiled before."""
    found, _ = ensemble.measure(plan, silent, threads)
    return found.simulated_s / found.cpu_s


def table(seconds: float, runs: int) -> None:
    """Print simulated seconds per CPU second, and CPU time over that of space on a plane."""
    rates = {case.name: per_cpu_second(plan_of(case, seconds, runs)) for case in CASES}
    print(f"{'case':32s}  simulated s / CPU s  CPU time over {SHOWN}'s")
    for name, rate in rates.items():
        print(f"{name:32s}  {rate:19.1f}  {rates[SHOWN] / rate:.3g}")


def threads(seconds: float, runs: int) -> None:
    """Print what a second thread is worth."""
    (case,) = [case for case in CASES if case.name == SHOWN]
    plan = plan_of(case, 2.0 * seconds, 2 * runs)
    walls = {count: ensemble.measure(plan, silent, count)[0].wall_s for count in (1, 2)}
    print(
        f"two threads are {walls[1] / walls[2]:.2f} times as fast as one ({os.cpu_count()} cores)"
    )


def first_results() -> None:
    """Print the wall time of the first result in a new process, cold and warm."""
    with tempfile.TemporaryDirectory() as folder:
        for told in ("cold, with compilation", "warm"):
            started = time.perf_counter()
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            subprocess.run(
                [sys.executable, *FIRST, "--quiet"], env=environment, check=True, timeout=600
            )
            print(f"first result, {told}: {time.perf_counter() - started:.1f} s")


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--cold", action="store_true")
    chosen = parser.parse_args()
    print(machine())
    table(chosen.seconds, chosen.runs)
    threads(chosen.seconds, chosen.runs)
    if chosen.cold:
        first_results()


if __name__ == "__main__":
    main()
