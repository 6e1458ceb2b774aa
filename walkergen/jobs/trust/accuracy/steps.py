"""The ladders of steps: short deterministic scenes, and long-run mean speeds."""

import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy import space_steps
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung, cpu_time, order
from walkergen.jobs.trust.accuracy.models import Details, certificate, rung_of
from walkergen.jobs.trust.accuracy.speeds import Survey
from walkergen.simulation import record
from walkergen.simulation.compliant import steps
from walkergen.simulation.model import Plan
from walkergen.simulation.run import ENDS, FIRST_TURN
from walkergen.simulation.world import OK, PITCH

Array = npt.NDArray[np.float64]

SHORT_STEPS = (500, 1000, 2000, 5000, 10_000, 20_000)
"""Numbers of steps per period of the drive in the short scenes."""

EXACT = 200_000
"""Number of steps per period of the reference in the short scenes: ten times the finest."""


class Short(NamedTuple):
    """Scene too short for chaos: a drop, and a part of the period."""

    name: str
    phase: float
    """Phase of the drive at the drop, rad."""
    periods: float


SHORTS = (Short("first landing", 4.0, 0.5), Short("two periods", 4.0, 2.0))


def short(survey: Survey, progress: Progress) -> Ladder:
    """Measure the error of the final state against the step, before chaos sets in."""
    if survey.complete == "space":
        return space_steps.short(survey, progress)
    started = time.perf_counter()
    rungs: list[Rung] = []
    for number, scene in enumerate(SHORTS):
        progress(scene.name, number, len(SHORTS))
        true = _final(_stepped(survey, EXACT), scene)
        rungs += [_rung(survey, parts, scene, true) for parts in SHORT_STEPS]
    survey.budget.pay(time.perf_counter() - started)
    return Ladder(
        "steps-short",
        "Error of the final state of short scenes against the step",
        "error of the feet's place, share of the drive's amplitude",
        "CPU time of the scene, s",
        f"{EXACT} steps a period, {EXACT // SHORT_STEPS[-1]} times the finest here",
        rungs,
        [*_orders(rungs)],
    )


def long(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of the long-run mean speed against the step, with common random phases."""
    reference = survey.reference(progress)
    unit = survey.unit(reference)
    rungs = []
    for measured in survey.measure(survey.steps, progress):
        bias = survey.bias(measured, reference)
        step_details: Details = {
            "step_us": measured.setting.step_us,
            "bias_mm_s": None if bias is None else bias.size,
            "bias_se_mm_s": None if bias is None else bias.se,
        }
        rungs.append(rung_of(survey, measured, reference, step_details))
    return Ladder(
        "steps-long",
        "Bias of the long-run mean speed against the step",
        f"bias of the mean speed, {unit.name}",
        f"CPU time for a mean speed known to {unit.fine:.2g} mm/s (one standard error), s",
        certificate(survey, progress),
        rungs,
        (
            "All settings start from the same drops and phases. The motion is chaotic: a bias "
            "smaller than twice its standard error cannot be told from none.",
        ),
        "step_us",
    )


def _stepped(survey: Survey, parts: int) -> Plan:
    """Plan with so many steps a period."""
    plan = survey.plan(survey.own)
    options = steps.Options(plan.world.drive.period / parts)
    return plan._replace(world=plan.world._replace(options=options))


def _rung(survey: Survey, parts: int, scene: Short, true: Array) -> Rung:
    plan = _stepped(survey, parts)
    step = 1e6 * plan.world.options.step
    reach = np.array([1.0, 1.0, 0.5 * survey.design.foot_span])
    amplitude = plan.world.drive.amplitude
    error = float(np.abs((_final(plan, scene) - true) * reach).max() / amplitude)
    seconds = cpu_time(lambda: _final(plan, scene), repeats=3)
    series = f"{scene.name}: {survey.own.series}"
    return Rung(series, f"step {step:.3g} us", error, None, seconds, {"value": step})


def _final(plan: Plan, scene: Short) -> Array:
    """Place and pitch, shape (3,), at the end of a scene."""
    drive = plan.world.drive
    state = plan.start(drive.amplitude, FIRST_TURN, scene.phase)
    status = plan.advance(state, scene.periods * drive.period, record.new(len(state)))
    if status != OK:
        ended = ENDS[status].value
        raise InputError(f"the short scene {scene.name!r} ends as {ended}: try a weaker drive")
    return state[: PITCH + 1]


def _orders(rungs: Sequence[Rung]) -> Iterator[str]:
    """Lines with the measured and the claimed order of each series."""
    for series in dict.fromkeys(rung.series for rung in rungs):
        points = [
            (float(rung.details["value"] or 0.0), rung.error) for rung in rungs if rung.series == series and rung.error
        ]
        slope, se = order(*zip(*points, strict=True))
        yield f"{series}: measured order {slope:.2f} ± {se:.2f}, claimed 2 in the step"
