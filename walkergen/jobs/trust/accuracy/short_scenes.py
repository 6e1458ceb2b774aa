"""The ladder of short scenes: errors against the step before chaos sets in, and their order."""

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy.ladder import Details, Ladder, Rung, cpu_time, order_in_words
from walkergen.jobs.trust.accuracy.survey import OWN, Survey
from walkergen.simulation import record
from walkergen.simulation.plan import Plan, prepare
from walkergen.simulation.run import ENDS, FIRST_TURN
from walkergen.simulation.space.state import HEIGHT, PITCH, SHOWN_X
from walkergen.simulation.world import OK, State

Array = npt.NDArray[np.float64]

SHARES: Sequence[float] = (1.5, 1.2, 1.0, 0.7, 0.5, 0.35, 0.25)
EXACT_SHARE = 1.0 / 32.0
"""Steps over that which resolves the feet, and that of the reference."""

DROPS, FEWEST_DROPS = 32, 8
"""Landings over which the mean error is taken, where the budget allows, and those that still
average the instants inside a step: the error bar is twice as long."""

PASSES = 1.0 / EXACT_SHARE + 6.0 * sum(1.0 / share for share in SHARES)
"""Cost of the landings over that of simulating them once: six times each step, to time them."""

SETTLED_S, SLIDE_S = 0.02, 0.005
"""Time (s) in which a walker settles on a slope, and time of its slide that is compared."""

STEEP_DEG = 10.0
"""Slope of the sliding scene beyond the angle of friction, deg."""

WEIGHT = 0.05
"""Weight of the ladder in the survey's budget, where all settings together have 1."""


class Short(NamedTuple):
    """Scene too short for chaos: states to start from, and the time they run."""

    name: str
    starts: Sequence[State]
    seconds: float
    claimed: str
    """Claimed order of the error of the mean in the step."""
    stepped: Callable[[float], Plan]
    """Plan by its step, one of SHARES."""
    amplitude: float
    """Amplitude of its plate, mm: the unit of its errors."""


def ladder(survey: Survey, progress: Progress) -> Ladder:
    """Measure errors of short scenes against the step.

    Errors are those of the mean over a scene's starts, so that the instants at which landings lie
    inside a step average out as they do in long runs.
    """
    drops = min(max(int(survey.take("steps-short") / _landing_s(survey)), FEWEST_DROPS), DROPS)
    scenes = [_sliding(survey), _landings(survey, drops)]
    rungs: list[Rung] = []
    notes = []
    for number, scene in enumerate(scenes):
        progress(scene.name, number, len(scenes))
        true = _ends(survey, scene, scene.stepped(EXACT_SHARE))
        own = [_rung(survey, scene, scene.stepped(share), true) for share in SHARES]
        steps_us = [float(rung.details["step_us"] or 0.0) for rung in own]
        measured = order_in_words(steps_us, [rung.error or np.nan for rung in own])
        notes.append(f"{scene.name}: {measured}, claimed {scene.claimed}")
        rungs += own
    return Ladder(
        "steps-short",
        "Error of the mean over short scenes against the step",
        "error of the mean place, share of the drive's amplitude",
        "CPU time of the scene, s",
        f"steps {1.0 / EXACT_SHARE:g} times finer than what resolves the feet",
        rungs,
        notes,
    )


def least(survey: Survey) -> float:
    """Wall time of the short scenes with the fewest drops, s."""
    return FEWEST_DROPS * _landing_s(survey)


def _landing_s(survey: Survey) -> float:
    """Time of one landing at all steps, s."""
    return PASSES * 0.5 / survey.scene.drive.frequency * survey.rate(survey.own)


def _sliding(survey: Survey) -> Short:
    """Slide down a slope from rest, on a plate too calm to throw the walker."""
    scene = survey.scene_of(OWN)
    drive = {"frequency_hz": scene.drive.frequency, "gamma": 0.3}
    slope = min(float(np.degrees(np.arctan(scene.contact.friction))) + STEEP_DEG, 59.0)
    tables = scene.model_dump(exclude_none=True) | {"drive": drive, "plate": {"slope_deg": slope}}
    plan = prepare(type(scene).model_validate(tables), survey.design, survey.mass)
    fine = _stepped(survey, plan)(0.25)
    state = plan.start(0.0, 0.0, 1.0)
    fine.advance(state, SETTLED_S, record.new(len(state)))
    claimed = "2: nothing begins or ends in a step"
    return Short("sliding", [state], SLIDE_S, claimed, _stepped(survey, plan), plan.world.drive.amplitude)


def _landings(survey: Survey, drops: int) -> Short:
    """Drop the walker over half a period, from many heights, pitches, rolls and phases."""
    plan = survey.plan(OWN)
    drive, rng = plan.world.drive, np.random.default_rng(1)
    starts = [
        plan.start(
            drive.amplitude * rng.uniform(0.5, 1.5),
            FIRST_TURN * rng.normal(),
            rng.uniform(3.5, 4.5),
            FIRST_TURN * rng.normal(),
        )
        for _ in range(drops)
    ]
    claimed = "1: contacts close inside a step"
    return Short("landings", starts, 0.5 * drive.period, claimed, _stepped(survey, plan), drive.amplitude)


def _stepped(survey: Survey, plan: Plan) -> Callable[[float], Plan]:
    """Function that gives the plan with a share of the step that resolves the feet."""

    def stepped(share: float) -> Plan:
        run = plan.scene.run.model_copy(update={"step_us": max(share * survey.resolving_us, 0.01)})
        return prepare(plan.scene.model_copy(update={"run": run}), survey.design, survey.mass)

    return stepped


def _ends(survey: Survey, scene: Short, plan: Plan) -> Array:
    """Place, height and pitch (mm at the feet) at the ends of a scene, shape (starts, 3)."""
    ends, started = [], time.perf_counter()
    for start in scene.starts:
        state = start.copy()
        status = plan.advance(state, scene.seconds, record.new(len(state)))
        if status != OK:
            raise InputError(f"the short scene {scene.name!r} ends as {ENDS[status].value}: try a weaker drive")
        ends.append(state[[SHOWN_X, HEIGHT, PITCH]])
    survey.budget.pay(time.perf_counter() - started)
    return np.asarray(np.array(ends) * (1.0, 1.0, 0.5 * survey.design.foot_span))


def _rung(survey: Survey, scene: Short, plan: Plan, true: Array) -> Rung:
    step_us = 1e6 * plan.world.options.step
    off = (_ends(survey, scene, plan) - true) / scene.amplitude
    sizes = np.abs(off.mean(axis=0))
    worst = int(sizes.argmax())
    se = float(off[:, worst].std(ddof=1) / np.sqrt(len(off))) if len(off) > 1 else None
    seconds = cpu_time(lambda: _ends(survey, scene, plan), repeats=3)
    details: Details = {"step_us": step_us, "each": float(np.sqrt((off**2).mean(axis=0)).max())}
    return Rung(scene.name, f"step {step_us:.3g} us", float(sizes[worst]), se, seconds, details)
