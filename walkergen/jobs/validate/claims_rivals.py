"""Claims against physics engines that share no code with ours; each only where it is installed."""

import importlib.util
import math
from collections.abc import Iterator

from walkergen.jobs.validate.claim import Claim, Effort, exact, missing
from walkergen.jobs.validate.ensembles import mean
from walkergen.scene import Scene
from walkergen.simulation import points
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.space.walker import mobility
from walkergen.walker import solids
from walkergen.walker.design import Design

GROUP = "rivals"

MUJOCO = "MuJoCo (E. Todorov, T. Erez, Y. Tassa, IROS 2012), our walker without twist of its legs"
EXTRA = "{} is not installed here: pip install 'walkergen[rivals]'"

FRICTION = 0.25

PLASTIC = {"stiffness_ratio": 10.0, "tangential_ratio": 8.0}
"""Feet ten times as stiff as ours, near the rigid corners of an engine."""

SAME_FEET = 0.1
"""Share by which speeds may differ since engines judge friction by the slip at a step's end: with
that rule planar speeds are 5 and 8 % higher (benchmarks/rivals.py)."""


def installed(name: str) -> bool:
    """True when a package can be imported."""
    return importlib.util.find_spec(name) is not None


def _plan(tilt_deg: float, effort: Effort, restitution: float = 0.02) -> Plan:
    """Plan of a walker without twist, on nearly plastic feet."""
    design = Design().variant(tilt_deg=tilt_deg)
    tables = {
        "drive": {"frequency_hz": 90.0, "gamma": 1.8},
        "contact": {"restitution": restitution, "friction": FRICTION},
        "arena": {"kind": "plane"},
        "effects": {"leg_twist": False},
        "legs": {"model": "space"},
        "feet": PLASTIC,
        "run": {"seconds": 0.5 * effort.seconds, "discard_seconds": 0.5, "runs": effort.runs},
    }
    return prepare(Scene.model_validate(tables), design, solids.mass_of(design))


def inverse_mass(effort: Effort) -> Iterator[Claim]:
    """Claim on the inverse mass at a corner of the walker in space, by MuJoCo's own dynamics."""
    names = ("normal", "along", "normal to along")
    if not installed("mujoco"):
        yield missing(GROUP, "inverse mass at a corner", "1/g", MUJOCO, EXTRA.format("MuJoCo"))
        return
    from walkergen.jobs.validate import mujoco_walker

    for tilt in (10.0, 35.0):
        plan = _plan(tilt, effort)
        ours = mobility(plan.world.walker)
        theirs = mujoco_walker.mobility(plan.case.design, plan.case.mass)
        for name, place in zip(names, ((0, 0), (1, 1), (0, 1)), strict=True):
            yield exact(
                GROUP, f"inverse mass at a back corner at {tilt:g} deg, {name}", "1/g",
                float(ours[place]), float(theirs[place]), 1e-9, "rounding of two factorisations",
                MUJOCO,
            )  # fmt: skip


def plastic_speeds(effort: Effort) -> Iterator[Claim]:
    """Claim on speeds of the walker in space on nearly plastic feet, against rigid corners."""
    tilts = (10.0, 15.0, 20.0)
    told = "speed at {:g} deg, nearly plastic feet"
    if not installed("mujoco"):
        for tilt in tilts:
            yield missing(GROUP, told.format(tilt), "mm/s", MUJOCO, EXTRA.format("MuJoCo"))
        return
    from walkergen.jobs.validate import mujoco_walker

    for tilt in tilts:
        plan = _plan(tilt, effort)
        case, walker = plan.case, plan.world.walker
        asked = points.Asked(plan.scene, case.design, case.mass)
        point = points.measure(asked, lambda *progress: None)
        ours = mean([result.speed for result in point.results])
        hinge = float(walker.stiffness[0]), float(walker.damping[0])
        count = 3 if effort.quick else 6
        runs = mujoco_walker.speeds(
            case.design, case.mass, hinge, FRICTION, plan.world.drive, 0.25 * effort.seconds + 0.5,
            range(count),
        )  # fmt: skip
        theirs = float(runs.mean()), float(runs.std(ddof=1) / math.sqrt(count))
        yield Claim(
            GROUP, told.format(tilt), "mm/s", *ours, *theirs, SAME_FEET * theirs[0],
            "10 %: engines judge friction by the slip at the end of a step", MUJOCO,
            "The two feet are not the same: our corners are springs, ten times as stiff as those "
            "of a printed leg, that give along the plate and rebound with 0.02; MuJoCo's stop "
            "within a step of 4 us and are damped along the plate as well. Where corners land "
            "within a contact time of each other, that decides (docs/physics.md section 5).",
        )  # fmt: skip


TESTS = (inverse_mass, plastic_speeds)
