"""The ladders of steps in space: short scenes, and the length of frozen frames."""

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.progress import Progress, part
from walkergen.jobs.trust.accuracy.budget import KINDS, widened
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung, cpu_time, order
from walkergen.jobs.trust.accuracy.setting import Setting
from walkergen.jobs.trust.accuracy.speeds import Survey
from walkergen.simulation import ensemble, record
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import ENDED_WELL, ENDS, FIRST_TURN
from walkergen.simulation.space.state import HEIGHT, PITCH, SHOWN_X
from walkergen.simulation.world import OK, State

Array = npt.NDArray[np.float64]

SHARES = (1.5, 1.2, 1.0, 0.7, 0.5, 0.35, 0.25)
"""Steps over that which resolves the feet."""

EXACT = 1.0 / 32.0
"""Step of the reference over that which resolves the feet."""

FRAMES = (4, 12, 24, 48)
"""Steps for which pose and contact directions are frozen."""

FEWEST_FRAMES = (4, 12)
"""Those that are measured where the budget does not allow all: longer ones may not end well."""

DROPS = 32
"""Landings over which the mean error is taken, where the budget allows."""

FEWEST_DROPS = 8
"""Landings that still average the instants inside a step: the error bar is twice as long."""

PASSES = 1.0 / EXACT + 6.0 * sum(1.0 / share for share in SHARES)
"""Cost of the landings over that of simulating them once: six times each step, to time them."""

SETTLED_S, SLIDE_S = 0.02, 0.005
"""Time (s) in which a walker settles on a slope, and time of its slide that is compared."""

STEEP_DEG = 10.0
"""Slope of the sliding scene beyond the angle of friction, deg."""

WEIGHTS = {"steps-short": 0.05, "frames": 0.3}
"""Weights of the ladders in the survey's budget, where all settings together have 1."""


class Short(NamedTuple):
    """Scene too short for chaos: states to start from, and the time they run."""

    name: str
    plan: Plan
    starts: Sequence[State]
    seconds: float
    claimed: str
    """Claimed order of the error of the mean in the step."""


def short(survey: Survey, progress: Progress) -> Ladder:
    """Measure errors in sliding and landing against the step, before chaos sets in.

    Errors are those of the mean over a scene's starts, so that the instants at which landings lie
    inside a step average out as they do in long runs.
    """
    rungs: list[Rung] = []
    notes = []
    granted = survey.take("steps-short")
    drops = min(max(int(granted / _landing_s(survey)), FEWEST_DROPS), DROPS)
    scenes = [_sliding(survey), _landings(survey, drops)]
    for number, scene in enumerate(scenes):
        progress(scene.name, number, len(scenes))
        true = _ends(survey, scene, _stepped(survey, scene.plan, EXACT))
        series = [_rung(survey, scene, share, true) for share in SHARES]
        errors = [rung.error or np.nan for rung in series]
        slope, se = order(SHARES, errors)
        notes.append(f"{scene.name}: measured order {slope:.2f} ± {se:.2f}, claimed {scene.claimed}")
        rungs += series
    return Ladder(
        "steps-short",
        "Error of the mean over short scenes against the step",
        "error of the mean place, share of the drive's amplitude",
        "CPU time of the scene, s",
        f"steps {1.0 / EXACT:g} times finer than what resolves the feet",
        rungs,
        notes,
        "value",
    )


def frames(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of the mean speed against the length of frozen frames, at the own step."""
    reference = survey.reference(progress)
    unit = survey.unit(reference)
    assert reference.value is not None
    assert reference.se is not None
    discard, rate = survey.scene.run.discard_seconds, survey.rate(survey.own)
    granted = survey.take("frames")
    several = granted > len(FRAMES) * survey.least(survey.own)
    lengths = FRAMES if several else FEWEST_FRAMES
    runs = survey.budget.affords(granted / len(lengths), rate, discard, KINDS)
    plan = survey.plan(survey.own).lasting(seconds=runs.seconds, runs=runs.number)
    rungs = []
    for number, frame in enumerate(lengths):
        world = plan.world._replace(options=plan.world.options._replace(frame=frame))
        frame_progress = part(progress, number, len(lengths))
        summary, _ = ensemble.measure(plan._replace(world=world), frame_progress)
        if summary.runs < runs.number:
            raise KeyboardInterrupt
        survey.budget.pay_runs(runs, rate, discard, summary.wall_s)
        good = set(summary.outcomes) <= {outcome.value for outcome in ENDED_WELL}
        error = se = None
        if good and summary.speed_mm_s is not None and summary.speed_se_mm_s is not None:
            error = abs(summary.speed_mm_s - reference.value) / unit.size
            speed_se = widened(runs.number) * summary.speed_se_mm_s
            se = float(np.hypot(speed_se, reference.se)) / unit.size
        details: dict[str, float | str | None] = {
            "steps_in_a_frame": float(frame),
            "frame_us": 1e6 * frame * plan.world.options.step,
            "speed_mm_s": summary.speed_mm_s,
            "speed_se_mm_s": summary.speed_se_mm_s,
            "energy_error": summary.energy_error,
            "outcomes": ensemble.listed(summary.outcomes),
        }
        setting = f"{frame} steps of {survey.own.step_us:g} us"
        cost = summary.cpu_s / summary.simulated_s
        rungs.append(Rung("frozen frames", setting, error, se, cost, details))
    return Ladder(
        "frames",
        "Bias of the mean speed against the time for which pose and contact directions are frozen",
        f"bias of the mean speed, {unit.name}",
        "CPU time of a simulated second, s",
        f"{reference.setting.label}: {reference.value:.2f} ± {reference.se:.2f} mm/s",
        rungs,
        ("The bias includes that of the step, which is the same in all rungs.",),
        "frame_us",
    )


def least_of_frames(survey: Survey) -> float:
    """Wall time of the fewest and shortest runs for the fewest lengths of frames, s."""
    return len(FEWEST_FRAMES) * survey.least(survey.own)


def least_of_short(survey: Survey) -> float:
    """Wall time of the short scenes with the fewest drops, s."""
    return FEWEST_DROPS * _landing_s(survey)


def _landing_s(survey: Survey) -> float:
    """Time of one landing at all steps, s."""
    return PASSES * 0.5 / survey.scene.drive.frequency * survey.rate(survey.own)


def _sliding(survey: Survey) -> Short:
    """Slide down a slope from rest, on a plate too calm to throw the walker."""
    scene = survey.scene_of(Setting("space", None))
    drive = {"frequency_hz": scene.drive.frequency, "gamma": 0.3}
    slope = min(float(np.degrees(np.arctan(scene.contact.friction))) + STEEP_DEG, 59.0)
    tables = scene.model_dump(exclude_none=True) | {"drive": drive, "plate": {"slope_deg": slope}}
    plan = prepare(type(scene).model_validate(tables), survey.design, survey.mass)
    fine = _stepped(survey, plan, 0.25)
    state = plan.start(0.0, 0.0, 1.0)
    fine.advance(state, SETTLED_S, record.new(len(state)))
    return Short("sliding", plan, (state,), SLIDE_S, "2: nothing begins or ends in a step")


def _landings(survey: Survey, drops: int) -> Short:
    """Drop the walker over half a period, from many heights, pitches, rolls and phases."""
    plan = survey.plan(Setting("space", None))
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
    return Short("landings", plan, starts, 0.5 * drive.period, "1: contacts close inside a step")


def _stepped(survey: Survey, plan: Plan, share: float) -> Plan:
    """Plan with steps `share` times that which resolves the feet."""
    run = plan.scene.run.model_copy(update={"step_us": max(share * survey.resolving_us, 0.01)})
    scene = plan.scene.model_copy(update={"run": run})
    return prepare(scene, survey.design, survey.mass)


def _ends(survey: Survey, scene: Short, plan: Plan) -> Array:
    """Place, height and pitch (mm at the feet) at the ends of a scene, shape (starts, 3)."""
    ends, started = [], time.perf_counter()
    for start in scene.starts:
        state = start.copy()
        status = plan.advance(state, scene.seconds, record.new(len(state)))
        if status != OK:
            ended = ENDS[status].value
            raise InputError(f"the short scene {scene.name!r} ends as {ended}: try a weaker drive")
        ends.append(state[[SHOWN_X, HEIGHT, PITCH]])
    survey.budget.pay(time.perf_counter() - started)
    reach = np.array([1.0, 1.0, 0.5 * survey.design.foot_span])
    return np.asarray(np.array(ends) * reach)


def _rung(survey: Survey, scene: Short, share: float, true: Array) -> Rung:
    amplitude = scene.plan.world.drive.amplitude
    plan = _stepped(survey, scene.plan, share)
    off = (_ends(survey, scene, plan) - true) / amplitude
    worst = int(np.abs(off.mean(axis=0)).argmax())
    several = len(off) > 1
    se = float(off[:, worst].std(ddof=1) / np.sqrt(len(off))) if several else None
    step = share * survey.resolving_us
    seconds = cpu_time(lambda: _ends(survey, scene, plan), repeats=3)
    details: dict[str, float | str | None] = {"value": step, "each": float(np.sqrt((off**2).mean(axis=0)).max())}
    error = float(np.abs(off.mean(axis=0))[worst])
    return Rung(scene.name, f"step {step:.3g} us", error, se, seconds, details)
