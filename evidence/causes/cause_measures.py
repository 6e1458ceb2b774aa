"""What evidence.causes.causes measures of the paper's walker, on its plate with one thing changed."""

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis import landings
from walkergen.files import templates
from walkergen.jobs.trust.reproduce import motion
from walkergen.lab import drops, resting
from walkergen.numerics import kernels
from walkergen.numerics.quantity import Quantity, mean
from walkergen.scene import Scene
from walkergen.simulation import ensemble
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.record import Tally
from walkergen.simulation.run import ENDED_WELL, RunResult, impacts_of
from walkergen.simulation.space.state import PHASE, V_X
from walkergen.simulation.world import OK, State, World
from walkergen.theory.impact import Kind
from walkergen.walker import solids
from walkergen.walker.design import Design

GAMMAS = (1.2, 1.4, 1.8, 2.2)
"""Peak accelerations over g of the speeds at 15 deg; the line through zero is that of the last."""

SLOW_S = 14.0
"""Measured time of a run at 35 deg, s: exponents reach a quarter of it."""

KICKS = 32
"""Kicks that a plate which moves to and fro gives in a period."""


class Setting(NamedTuple):
    """One cause at one size."""

    cause: str
    size: str
    likely: bool
    """Whether the paper's set-up may well have had that."""
    keys: Mapping[str, Any] = MappingProxyType({})
    """Keys of the scene; those that begin with "walker." are the design's."""
    to_and_fro: tuple[float, float] | None = None
    """Amplitude of a plate's motion along x over that of the vertical one, and its phase, rad."""
    shake: float = 1.0
    """Acceleration under the walker over the one that is stated, where a bent plate moves more."""


def plan_of(one: Setting, label: float, tilt: float, runs: int, seconds: float, gamma: float = 1.8) -> Plan:
    """Plan of the paper's walker with one cause, on its plane unless the cause is a lane."""
    scene = templates.load("plane-90hz", "scenes", Scene)
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=tilt)
    walker = {key[7:]: value for key, value in one.keys.items() if key.startswith("walker.")}
    keys = {
        "run.runs": runs,
        "run.seconds": seconds,
        "run.discard_seconds": 0.5,
        "legs.model": "space",
        "contact.restitution": label,
        "drive.gamma": one.shake * gamma,
    }
    keys |= {key: value for key, value in one.keys.items() if not key.startswith("walker.")}
    design = design.variant(**walker) if walker else design
    plan = prepare(scene.variant(**keys), design, solids.mass_of(design))
    if one.to_and_fro is None:
        return plan
    return plan._replace(model=plan.model._replace(advance=kicked(plan, *one.to_and_fro)))


def kicked(plan: Plan, ratio: float, shift: float) -> Callable[[World, State, float, Tally], int]:
    """What advances a state on a plate that moves along x by ratio A sin(phase + shift) as well.

    In the plate's frame that is a uniform acceleration. The walker gets it as kicks, half of one
    before each slice of a period and half after it (of second order in the slice). Constant kicks
    give the speed of a slope of 3 deg: 111 ± 5 for 107 ± 3 mm/s at 10 deg, 17 ± 1 for 16 ± 1 at 35.
    """
    drive, ready = plan.world.drive, list[Any]()
    speed = ratio * drive.amplitude * drive.omega

    def advance(world: World, state: State, seconds: float, tally: Tally) -> int:
        slices = max(round(KICKS * seconds / drive.period), 1)
        step = seconds / slices
        if not ready:
            ready.append(kernels.entry(plan.model.advance, world, state, step, tally))
        for _ in range(slices):
            turn = state[PHASE] + shift + 0.5 * drive.omega * step * np.arange(3)
            before, middle, after = speed * np.cos(turn)
            state[V_X] -= middle - before
            status = int(ready[0](world, state, step, tally))
            if status != OK:
                return status
            state[V_X] -= after - middle
        return OK

    return advance


def runs_of(plan: Plan, impacts: bool = False, interval: float | None = None) -> list[RunResult]:
    """Runs that ended well, one after another on one core."""
    results = ensemble.run(plan, lambda *_: None, 1, impacts, interval)
    return [result for result in results if result.outcome in ENDED_WELL]


def fast(one: Setting, label: float) -> Iterator[Quantity]:
    """Speed at 10 deg, mm/s, and share of types II and III among its landings."""
    results = runs_of(plan_of(one, label, 10.0, 12, 3.0), impacts=True)
    yield mean("speed", "mm_s", [result.speed for result in results])
    yield mean("types", "", [_usual(result) for result in results])


def _usual(result: RunResult) -> float:
    """Share of types II and III among the landings of a run."""
    impacts = landings.impacts_in(impacts_of(result))
    kinds = impacts.kind[landings.of_feet(impacts.time, impacts.foot // landings.CORNERS)]
    return float(np.isin(kinds, (Kind.II, Kind.III)).mean())


def bounce(one: Setting, label: float) -> Iterator[Quantity]:
    """Rebound of drops by 1 mm at 10 deg: level, and turned by up to 1 mrad, a print a drop."""
    plan = plan_of(one, label, 10.0, 1, 1.0)
    plan = resting.plan_of(plan.scene, plan.case.design)
    turns = np.random.default_rng(2016).uniform(-1e-3, 1e-3, (16, 2))
    for name, starts in (("level", np.zeros((4, 2))), ("rebound", turns)):
        lets = [drops.Let(1.0, pitch, roll, number) for number, (pitch, roll) in enumerate(starts.tolist())]
        ratios = [drops.rebound(plan, let).ratio for let in lets]
        yield mean(name, "", [ratio for ratio in ratios if ratio is not None])


def onset(one: Setting, label: float) -> Iterator[Quantity]:
    """Speed at 15 deg over the plate's, over that at the largest acceleration: 1 on a line."""
    plans = [plan_of(one, label, 15.0, 8, 3.0, gamma) for gamma in GAMMAS]
    speeds = [mean("speed", "mm_s", [result.speed for result in runs_of(plan)]) for plan in plans]
    for gamma, speed in zip(GAMMAS[:-1], speeds[:-1], strict=True):
        share, scale = speed.over(speeds[-1]), GAMMAS[-1] / gamma
        yield Quantity(f"line {gamma:g}", "", scale * (share.value or 0.0), scale * (share.se or 0.0))


def slow(one: Setting, label: float) -> Iterator[Quantity]:
    """Speed at 35 deg, crossover (s), exponent of the squared displacement at 1 s, turning rate."""
    results = runs_of(plan_of(one, label, 35.0, 12, SLOW_S), interval=motion.INTERVAL)
    runs = motion.of("", 35.0, results)
    if runs is None:
        return
    curve = runs.growth.exponents
    yield runs.speed._replace(key="slow speed")
    yield runs.growth.crossover
    second = int(np.abs(np.log(curve.at)).argmin())
    yield Quantity("exponent", "", float(curve.value[second]), float(curve.se[second]))
    headings = [track.heading for track in runs.tracks.tracks if track.heading is not None]
    yield mean("turning", "rad_s", [abs(float(each[-1] - each[0])) / SLOW_S for each in headings])


MEASURES: dict[str, tuple[Callable[[Setting, float], Iterator[Quantity]], str]] = {
    "fast": (fast, "types"),
    "bounce": (bounce, "rebound"),
    "onset": (onset, "line 1.8"),
    "slow": (slow, "turning"),
}
"""Measures by name, each with its last quantity: what was cut short is measured again."""
