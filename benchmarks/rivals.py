"""What a simulated second costs at equal error of the mean speed: walkergen, MuJoCo and pymunk.

All simulate the same walker (koumakis2016, flexible, five coordinates; 90 Hz, 1.8 g, mu = 0.25)
from the same starts, each on one core with a ladder of steps. The error of a mean speed is that
against walkergen's own steps of 1 us. Restitution is 0, where the laws
of restitution are one, or Newton's, which is the engines' own. Friction within an impact differs
even so: the engines judge it by the slip at its end, walkergen follows the slip. With the engines'
rule in walkergen's integrator the speeds are 50.6 and 22.4 mm/s at 15 and 20 deg (e = 0) in place
of 48.4 and 20.7: a part of their error that no step takes away.

    python benchmarks/rivals.py [--seconds 3] [--runs 8] [--rivals mujoco,pymunk] [--install]

rival_walkers.py holds the engines' walkers. They never enter the project's environment: --install
puts them into a virtual environment that is removed at the end. CPU time covers the stepping alone,
not compiling or setting up.
"""

import argparse
import importlib.util
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from predictions import machine

from walkergen.files import templates
from walkergen.scene import GRAVITY, Scene
from walkergen.simulation import ensemble
from walkergen.simulation.compliant.state import walker_of
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import FIRST_TURN, Outcome
from walkergen.walker import solids
from walkergen.walker.design import Design

ENGINES = ("mujoco", "pymunk")
WORKER = str(Path(__file__).with_name("rival_walkers.py"))
FRICTION = 0.25
DISCARDED_S = 0.5


class Case(NamedTuple):
    """One walker on one plate."""

    tilt_deg: float
    restitution: float

    def __str__(self) -> str:
        return f"tilt {self.tilt_deg:g} deg, Newton e = {self.restitution:g}"


CASES = (Case(15.0, 0.0), Case(20.0, 0.0), Case(10.0, 0.5))


class Setting(NamedTuple):
    """One rung of an engine's ladder."""

    engine: str
    step_us: float
    extra: dict[str, int]

    def __str__(self) -> str:
        return " ".join([self.engine, *(f"{value} {name}" for name, value in self.extra.items())])


LADDER = (
    *(Setting("walkergen", step, {}) for step in (100.0, 70.0, 50.0, 20.0)),
    *(Setting("mujoco", step, {"contact steps": 5}) for step in (40.0, 30.0, 20.0)),
    *(Setting("mujoco", step, {"contact steps": 10}) for step in (10.0, 5.0)),
    Setting("pymunk", 50.0, {"iterations": 50}),
    *(Setting("pymunk", step, {"iterations": 100}) for step in (100.0, 50.0)),
    *(Setting("pymunk", step, {"iterations": 200}) for step in (100.0, 50.0, 20.0)),
)
"""Coarse to fine. MuJoCo's contacts with restitution are damped springs that last some steps."""


class Rung(NamedTuple):
    """What a setting reached in one case."""

    error: float
    """Of the mean speed, relative."""
    noise: float
    """Standard error of that error."""
    rate: float
    """Simulated seconds per CPU second."""


class Measured(NamedTuple):
    """Mean speeds of the runs of one setting, mm/s, and what they cost."""

    speeds: npt.NDArray[np.float64]
    simulated_s: float
    cpu_s: float

    @property
    def mean(self) -> float:
        """mm/s"""
        return float(self.speeds.mean())

    @property
    def standard_error(self) -> float:
        """Of the mean, from the spread of the runs, mm/s."""
        return float(self.speeds.std(ddof=1) / math.sqrt(len(self.speeds)))

    @property
    def rate(self) -> float:
        """Simulated seconds per CPU second."""
        return self.simulated_s / self.cpu_s


FINE_US = 1.0
"""Step of the reference, us."""


def scene_of(case: Case, step_us: float, runs: int, seconds: float) -> Scene:
    scene = templates.load("lane-90hz", "scenes", Scene)
    contact = {"restitution": case.restitution, "friction": FRICTION, "law": "newton"}
    run = {"step_us": step_us, "runs": runs, "seconds": seconds, "discard_seconds": DISCARDED_S}
    return scene.model_copy(
        update={
            "contact": scene.contact.model_copy(update=contact),
            "run": scene.run.model_copy(update=run),
            "legs": scene.legs.model_copy(update={"model": "compliant"}),
        }
    )


def with_walkergen(case: Case, step_us: float, runs: int, seconds: float) -> Measured:
    scene = scene_of(case, step_us, runs, seconds)
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=case.tilt_deg)
    plan = prepare(scene, design, solids.mass_of(design))
    summary, results = ensemble.measure(plan, lambda *_: None, threads=1)
    good = [result for result in results if result.outcome is Outcome.OK]
    if len(good) < runs:
        print(f"walkergen, {case}, {step_us:g} us: {summary.outcomes}")
    speeds = np.array([result.speed for result in good])
    cpu_s = sum(result.cpu_s for result in good)
    return Measured(speeds, len(good) * (seconds + DISCARDED_S), cpu_s)


def task_of(case: Case, setting: Setting, runs: int, seconds: float) -> dict[str, Any]:
    """All that a rival needs to know; its step divides the period, and it starts as ours does."""
    scene = scene_of(case, setting.step_us, runs, seconds)
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=case.tilt_deg)
    mass = solids.mass_of(design)
    walker = walker_of(design, mass, damping_ratio=scene.legs.damping_ratio)
    limbs = [leg._asdict() for leg in walker.legs]
    drive = scene.drive
    period = 1.0 / drive.frequency
    count = round(period / (1e-6 * setting.step_us))
    starts = []
    for number in range(runs):
        rng = np.random.default_rng([scene.run.seed, number])
        clearance, pitch, phase = rng.uniform((0.5, -1.0, 0.0), (1.5, 1.0, 2.0 * np.pi))
        starts.append((drive.amplitude * clearance, FIRST_TURN * pitch, phase))
    return {
        "walker": walker._asdict() | {"legs": limbs},
        "amplitude": drive.amplitude,
        "omega": drive.omega,
        "gravity": GRAVITY,
        "restitution": case.restitution,
        "friction": FRICTION,
        "step": period / count,
        "steps_per_period": count,
        "starts": starts,
        "periods": 10 * math.ceil(0.1 * seconds / period),
        "discarded_periods": 10 * math.ceil(0.1 * DISCARDED_S / period),
    } | setting.extra


def with_rival(python: str, case: Case, setting: Setting, runs: int, seconds: float) -> Measured:
    said = subprocess.run(
        [python, WORKER, setting.engine],
        check=True,
        text=True,
        stdout=subprocess.PIPE,
        input=json.dumps(task_of(case, setting, runs, seconds)),
    ).stdout
    found = json.loads(said.splitlines()[-1])
    return Measured(np.array(found["speeds"]), found["simulated_s"], found["cpu_s"])


def compare(case: Case, ladder: list[Setting], python: str, options: argparse.Namespace) -> list[Rung]:
    """Print a case's table; returns what each setting of the ladder reached."""
    exact = with_walkergen(case, FINE_US, options.runs, options.reference)
    print(
        f"\n{case}, mu = {FRICTION:g}: steps of {FINE_US:g} us {exact.mean:.2f} +- "
        f"{exact.standard_error:.2f} mm/s at {exact.rate:.1f} s/CPU s"
    )
    print(f"{'engine':<24}{'step us':>8}{'s/CPU s':>9}{'mean speed mm/s':>18}{'error %':>16}")
    found = []
    for setting in ladder:
        if setting.engine == "walkergen":
            made = with_walkergen(case, setting.step_us, options.runs, options.seconds)
        else:
            made = with_rival(python, case, setting, options.runs, options.seconds)
        error = made.mean / exact.mean - 1.0
        noise = math.hypot(made.standard_error, exact.standard_error) / exact.mean
        speed = f"{made.mean:.2f} +- {made.standard_error:.2f}"
        print(
            f"{setting!s:<24}{setting.step_us:>8g}{made.rate:>9.2f}{speed:>18}"
            f"{100 * error:>+9.1f} +- {100 * noise:.1f}",
            flush=True,
        )
        found.append(Rung(error, noise, made.rate))
    return found


def conclude(ladder: list[Setting], cases: list[list[Rung]], accepted: float) -> None:
    """Print each engine's fastest setting whose error is accepted in every case, and the ratio.

    One case alone is no judge: errors of either sign cancel at some step by accident.
    """
    print(f"\nfastest with an error of at most {100 * accepted:g} % in every case (s/CPU s: over all cases)")
    each = list(zip(*cases, strict=True))
    worst = [max(rungs, key=lambda rung: abs(rung.error)) for rungs in each]
    rates = [len(cases) / sum(1.0 / rung.rate for rung in rungs) for rungs in each]
    ours = math.nan
    for engine in dict.fromkeys(setting.engine for setting in ladder):
        places = [place for place, setting in enumerate(ladder) if setting.engine == engine]
        good = [at for at in places if abs(worst[at].error) <= accepted]
        if good:
            best, remark = max(good, key=rates.__getitem__), ""
        else:
            best, remark = min(places, key=lambda at: abs(worst[at].error)), "; none is accepted"
        ours = rates[best] if engine == "walkergen" else ours
        error = f"{100 * worst[best].error:+.1f} +- {100 * worst[best].noise:.1f} %"
        print(
            f"{ladder[best]!s:<24}{ladder[best].step_us:>8g}{rates[best]:>9.2f}"
            f"   largest error {error:<15} walkergen / {engine}: {ours / rates[best]:.1f}"
            f"{remark}"
        )


def isolated_python(folder: Path) -> str:
    """A virtual environment of its own for the engines that the project does not depend on."""
    print(f"installing {' and '.join(ENGINES)} into {folder} ...", file=sys.stderr)
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    subprocess.run([str(python), "-m", "pip", "install", "-qq", *ENGINES], check=True)
    return str(python)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=3.0, help="measured, of each run")
    parser.add_argument("--reference", type=float, default=6.0, help="the same, of the reference")
    parser.add_argument("--runs", type=int, default=8)
    parser.add_argument("--accepted", type=float, default=0.05, help="relative error of the speed")
    parser.add_argument("--rivals", default=",".join(ENGINES), help="comma-separated")
    parser.add_argument("--install", action="store_true", help="engines in a temporary environment")
    options = parser.parse_args()
    rivals = [name for name in options.rivals.split(",") if name]
    for name in rivals:
        if name not in ENGINES:
            parser.error(f"--rivals {name!r}: choose from {', '.join(ENGINES)}")
    if hasattr(os, "sched_setaffinity"):  # Linux: one core for certain
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    print(machine())
    began = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="walkergen-rivals-") as folder:
        python = isolated_python(Path(folder)) if options.install and rivals else sys.executable
        for name in rivals:
            if not options.install and importlib.util.find_spec(name) is None:
                print(f"{name} skipped: not installed; pip install {name}, or use --install")
                rivals = [other for other in rivals if other != name]
        ladder = [setting for setting in LADDER if setting.engine in ("walkergen", *rivals)]
        found = [compare(case, ladder, python, options) for case in CASES]
    conclude(ladder, found, options.accepted)
    print(f"{time.perf_counter() - began:.0f} s in all")


if __name__ == "__main__":
    main()
