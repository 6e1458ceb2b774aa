"""The ladders of steps and tolerances: short deterministic scenes, and long-run mean speeds."""

import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.accuracy import elastic
from walkergen.jobs.accuracy.ladder import Ladder, Rung, cpu_time, order
from walkergen.jobs.accuracy.models import Details, certificate, rung_of
from walkergen.jobs.accuracy.speeds import Survey
from walkergen.simulation import record
from walkergen.simulation.compliant import events, steps
from walkergen.simulation.model import Plan
from walkergen.simulation.run import ENDS, FIRST_TURN
from walkergen.simulation.world import OK, PITCH

Array = npt.NDArray[np.float64]

SHORT_STEPS = (500, 1000, 2000, 5000, 10_000, 20_000)
"""Numbers of steps per period of the drive in the short scenes."""

TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
EXACT = 1e-13
"""Relative tolerance of the reference by events."""

SNAP = 1e-4
"""Rebound speed (mm/s) below which a sequence of impacts ends in the short scenes, in place of
1e-3: it adds an error of its own, which must stay below those that are studied."""


ROUNDING = 1e-9
"""Share of the amplitude below which an error is mere rounding, without an order to be read off."""


class Short(NamedTuple):
    """Scene too short for chaos: a drop, and a part of the period."""

    name: str
    phase: float
    """Phase of the drive at the drop, rad."""
    periods: float


SHORTS = (Short("first landing", 4.0, 0.5), Short("two periods", 4.0, 2.0))


def short(survey: Survey, progress: Progress) -> Ladder:
    """Measure the error of the final state against step and tolerance, before chaos sets in."""
    if survey.complete == "space":
        return elastic.short(survey, progress)
    started = time.perf_counter()
    rungs: list[Rung] = []
    certified = []
    for number, scene in enumerate(SHORTS):
        progress(scene.name, number, len(SHORTS))
        exact = _by_events(survey, EXACT)
        true = _final(exact, scene)
        stepped = list(_by_steps(survey, scene, true))
        rungs += stepped
        if not survey.design.braced:  # a braced walker's events are located to rounding
            rungs += _by_tolerance(survey, scene, true)
        finest = stepped[-1]
        told = f"{finest.error:.1e} of it at {finest.setting}" if finest.error else "equal"
        certified.append(f"{scene.name}: steps approach it to {told}")
    survey.purse.pay(time.perf_counter() - started)
    return Ladder(
        "steps-short",
        "Error of the final state of short scenes against step and tolerance",
        "error of the feet's place, share of the drive's amplitude",
        "CPU time of the scene, s",
        f"events at tolerance {EXACT:g}, certified by the other method; " + "; ".join(certified),
        rungs,
        [*_orders(rungs)],
    )


def long(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of the long-run mean speed against the step, with common random phases."""
    reference = survey.reference(progress)
    unit = survey.unit(reference)
    rungs = []
    for found in survey.measure(survey.steps, progress):
        bias = survey.bias(found, reference)
        own: Details = {
            "step_us": found.setting.step_us,
            "bias_mm_s": None if bias is None else bias.size,
            "bias_se_mm_s": None if bias is None else bias.se,
        }
        rungs.append(rung_of(survey, found, reference, own))
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


def _by_events(survey: Survey, tolerance: float) -> Plan:
    plan = survey.plan(survey.events[0])
    if survey.design.braced:
        return plan
    return _with_options(plan, events.Options(tolerance, SNAP, 0.1 * plan.world.drive.period))


def _with_options(plan: Plan, options: events.Options | steps.Options) -> Plan:
    return plan._replace(world=plan.world._replace(options=options))


def _by_steps(survey: Survey, scene: Short, true: Array) -> Iterator[Rung]:
    plan = survey.plan(survey.own)
    for parts in SHORT_STEPS:
        step = plan.world.drive.period / parts
        stepped = _with_options(plan, steps.Options(step))
        yield _rung(survey, stepped, scene, true, f"step {1e6 * step:.3g} us", 1e6 * step)


def _by_tolerance(survey: Survey, scene: Short, true: Array) -> Iterator[Rung]:
    for tolerance in TOLERANCES:
        plan = _by_events(survey, tolerance)
        yield _rung(survey, plan, scene, true, f"tolerance {tolerance:g}", tolerance)


def _rung(
    survey: Survey, plan: Plan, scene: Short, true: Array, setting: str, value: float
) -> Rung:
    reach = np.array([1.0, 1.0, 0.5 * survey.design.foot_span])
    amplitude = plan.world.drive.amplitude
    error = float(np.abs((_final(plan, scene) - true) * reach).max() / amplitude)
    seconds = cpu_time(lambda: _final(plan, scene), repeats=3)
    series = f"{scene.name}: {plan.resolved.model}, {plan.resolved.method}"
    return Rung(series, setting, error, None, seconds, {"value": value})


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
        known = [
            (float(rung.details["value"] or 0.0), rung.error or 0.0)
            for rung in rungs
            if rung.series == series
        ]
        if max(error for _, error in known) < ROUNDING:
            yield f"{series}: exact to rounding: nothing but flights and impacts in this scene"
            continue
        slope, se = order(*zip(*((v, error) for v, error in known if error > 0), strict=True))
        claimed = "2 in the step" if series.endswith("step") else "1 in the tolerance"
        yield f"{series}: measured order {slope:.2f} ± {se:.2f}, claimed {claimed}"
