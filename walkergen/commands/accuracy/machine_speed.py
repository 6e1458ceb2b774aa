"""Speed of this machine: CPU time of a simulated second of one walker, measured once and cached for the user.

Costs of other settings are multiples of it (`cells`).
"""

import hashlib
import json
import os
import platform
import statistics
import time
from pathlib import Path

from walkergen.core import caches
from walkergen.core.files import output
from walkergen.core.numerics import kernels
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import compile_kernels, simulate
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points.experiments import Walker

BENCHMARK_WALKER, BENCHMARK_SCENE, BENCHMARK_TILT_DEG = "koumakis2016", "lane-90hz", 10.0
"""Walker, scene and tilt of the loop: the paper's walker in space, at the default step of its feet."""

LOOP_S, LOOP_COUNT = 1.0, 7
"""Simulated time of a loop, s, and number of loops for the median: half a second of CPU time together."""


def cpu_per_s() -> float:
    """Return the CPU time per simulated second of the benchmark walker here, from the cache or measured."""
    path = _cache_path()
    try:
        kept = float(json.loads(path.read_text(encoding="utf-8"))["cpu_s_per_s"])
        if kept > 0.0:
            return kept
    except (OSError, ValueError, KeyError, TypeError):
        pass  # never measured, or the cache is unreadable: measure again
    found = measure_cpu_per_s()
    output.write(path, json.dumps({"cpu_s_per_s": found, "machine": machine_description()}).encode(), lasting=False)
    return found


def measure_cpu_per_s(loops: int = LOOP_COUNT) -> float:
    """Measure the CPU time per simulated second of the benchmark walker: the median of `loops` runs."""
    plan = _loop_plan()
    compile_kernels(plan)
    return statistics.median(_time_loop(plan) for _ in range(loops)) / LOOP_S


def _loop_plan() -> Plan:
    """Return the plan of the benchmark walker's run."""
    design = templates.load(BENCHMARK_WALKER, "walkers", Design).variant(tilt_deg=BENCHMARK_TILT_DEG)
    scene = templates.load(BENCHMARK_SCENE, "scenes", Scene)
    walker = Walker(scene, design, solids.mass_of(design))
    return walker.with_run_settings(runs=1, seconds=LOOP_S, discard_seconds=0.0).plan()


def _time_loop(plan: Plan) -> float:
    """Return the CPU time of the run of a plan, s."""
    started = time.thread_time()
    simulate(plan, 0)
    return time.thread_time() - started


def _cache_path() -> Path:
    """Return the cache file of the speed, named by the machine and the kernels' sources."""
    name = hashlib.sha256(f"{machine_description()} {os.cpu_count()} {kernels.source_digest()}".encode()).hexdigest()[
        :16
    ]
    return caches.folder("pace") / f"{name}.json"


def machine_description() -> str:
    """Describe the machine on which times were measured."""
    import numba

    return (
        f"{_processor_name()}, {os.cpu_count()} cores, {platform.system()}, "
        f"Python {platform.python_version()}, numba {numba.__version__}"
    )


def _processor_name() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.exists() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())
