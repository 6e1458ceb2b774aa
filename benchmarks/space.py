"""What the model in space costs: simulated seconds per CPU second, and what changes them.

    python benchmarks/space.py [--seconds 2] [--runs 4] [--cold]

All ratios come from one run on one machine: a lane with walls and a plane; braced walkers (corners
without hinges) with walls (eight more points) and without; a plate at rest; a motor on the walker in
place of the plate, of the same push, along and across the run, also per landing; one thread against
two. With --cold also the time of the first result in a new process, with an empty folder of compiled
kernels and with a full one.
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

from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.run import compile_kernels
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import Motor

PLANE: dict[str, Any] = {"arena": {"kind": "plane"}}
REST: dict[str, Any] = {"drive": {"frequency_hz": 90.0, "gamma": 1e-6}}
FIRST = ["-m", "walkergen", "simulate", "--scene", "plane-90hz", "--seconds", "0.5", "--runs", "2"]


class Case(NamedTuple):
    """One walker in one scene."""

    name: str
    kind: str = "flexible"
    tables: Mapping[str, Any] = MappingProxyType({})
    axis: str = ""
    """Axis of the motor that drives it; "" for a plate."""


CASES = (
    Case("plane", tables=PLANE),
    Case("lane with walls"),
    Case("held in its plane", tables={"effects": {"off": ["roll_and_yaw"]}}),
    Case("no twist", tables=PLANE | {"effects": {"off": ["leg_twist"]}}),
    Case("noisy plate", tables=PLANE | {"plate": {"noise_ratio": 0.2}}),
    Case("braced, plane", "braced", PLANE),
    Case("braced, lane with walls", "braced"),
    Case("plate at rest", tables=PLANE | REST),
    Case("motor along", tables=PLANE, axis="along"),
    Case("motor across", tables=PLANE, axis="across"),
)
SHOWN = "plane"


def silent(what: str, done: int, total: int) -> None:
    """Show no progress."""


def plan_of(case: Case, seconds: float, runs: int) -> Plan:
    """Plan of a case at 10 deg."""
    design = Design().variant(tilt_deg=10.0, kind=case.kind)
    mass = solids.mass_of(design)
    run = {"seconds": seconds, "discard_seconds": 0.5, "runs": runs}
    tables: dict[str, Any] = {"run": run} | dict(case.tables)
    if case.axis:  # a motor of no mass in no pocket
        design = design.model_copy(update={"motor": Motor()})
        plate = Scene().drive
        moment = plate.amplitude * float(mass.total)
        tables["drive"] = {
            "kind": "motor",
            "frequency_hz": plate.frequency,
            "axis": case.axis,
            "eccentric_g_mm": moment,
        }
    return prepare(Scene.model_validate(tables), design, mass)


class Cost(NamedTuple):
    """Cost of an ensemble, kernels compiled before."""

    rate: float
    """Simulated seconds per CPU second."""
    landing_us: float
    """CPU time per landing of a corner, us."""


def summary(plan: Plan, threads: int) -> ensemble.Summary:
    """Run a plan, kernels compiled before."""
    compile_kernels(plan)
    started = time.perf_counter()
    results = batch.run_all(ensemble.runner(plan), plan.scene.run.runs, silent, threads)
    return ensemble.summarise(results, plan.equivalent_drive.peak_speed, time.perf_counter() - started)


def cost(plan: Plan, threads: int = 1) -> Cost:
    """Cost of the runs of a plan."""
    found = summary(plan, threads)
    rate = found.simulated_s / found.cpu_s
    impacts = found.numbers["impacts_per_s"].number
    return Cost(rate, 1e6 / (rate * impacts) if impacts else float("nan"))


def table(seconds: float, runs: int) -> None:
    """Print what every case costs, also over what space on a plane does."""
    costs = {case.name: cost(plan_of(case, seconds, runs)) for case in CASES}
    print(f"{'case':32s}  simulated s / CPU s  CPU time over the {SHOWN}'s  us a landing")
    for name, (rate, landing_us) in costs.items():
        print(f"{name:32s}  {rate:19.1f}  {costs[SHOWN].rate / rate:26.3g}  {landing_us:12.1f}")


def threads(seconds: float, runs: int) -> None:
    """Print what a second thread is worth."""
    (case,) = [case for case in CASES if case.name == SHOWN]
    plan = plan_of(case, 2.0 * seconds, 2 * runs)
    walls = {count: summary(plan, count).wall_s for count in (1, 2)}
    print(f"two threads are {walls[1] / walls[2]:.2f} times as fast as one ({os.cpu_count()} cores)")


def first_results() -> None:
    """Print the wall time of the first result in a new process, cold and warm."""
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("cold, with compilation", "warm"):
            started = time.perf_counter()
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            subprocess.run([sys.executable, *FIRST, "--quiet"], env=environment, check=True, timeout=600)
            print(f"first result, {kind}: {time.perf_counter() - started:.1f} s")


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
