"""Ladders of settings: what formulas leave out, what each step costs and errs, by the mean speed."""

from collections.abc import Iterator

import numpy as np

from walkergen.errors import TheoryError
from walkergen.files import words
from walkergen.files.progress import Progress, part
from walkergen.jobs.trust.accuracy.budget import KINDS, widened
from walkergen.jobs.trust.accuracy.ladder import Details, Ladder, Rung, cpu_time
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.survey import Survey
from walkergen.simulation import ensemble
from walkergen.simulation.run import ENDED_WELL
from walkergen.theory.speed import Mode
from walkergen.theory.stationary import stationary

FRAMES = (4, 12, 24, 48)
"""Steps for which pose and contact directions are frozen."""

FEWEST_FRAMES = (4, 12)
"""Those that are measured where the budget does not allow all: longer ones may not end well."""

FRAMES_WEIGHT = 0.3
"""Weight of the ladder of frames in the survey's budget, where all settings together have 1."""


def models(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of formulas and of the own step against the finest, and their cost.

    The bias of formulas depends on the scene's impact_speed_factor, which they cannot predict.
    """
    reference = survey.reference(progress)
    unit = survey.unit(reference)
    rungs = [*formulas(survey, reference)]
    rungs += [_rung(survey, one, reference) for one in survey.measure([survey.own], progress)]
    unknown = _unknown_to_theory(survey)
    return Ladder(
        "models",
        "What formulas cost in truth, and what the simulation costs in time",
        f"bias of the mean speed, {unit.name}",
        f"CPU time for a mean speed known to {unit.fine:.2g} mm/s (one standard error), s",
        certificate(survey, progress),
        rungs,
        (
            "A formula takes microseconds because it is given the impact speed w, here "
            f"{survey.scene.impact_speed:.3g} mm/s, which a simulation finds out.",
            *([f"Left out: {unknown}"] if unknown else []),
        ),
    )


def steps(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of the long-run mean speed against the step, with common random phases."""
    reference = survey.reference(progress)
    unit = survey.unit(reference)
    rungs = []
    for measured in survey.measure(survey.steps, progress):
        bias = survey.bias(measured, reference)
        details: Details = {
            "step_us": measured.setting.step_us,
            "bias_mm_s": None if bias is None else bias.size,
            "bias_se_mm_s": None if bias is None else bias.se,
        }
        rungs.append(_rung(survey, measured, reference, details))
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
    )


def frames(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of the mean speed against the length of frozen frames, at the own step."""
    reference = survey.reference(progress)
    unit, true = survey.unit(reference), reference.speed
    assert true.value is not None
    assert true.se is not None
    discard, rate = survey.scene.run.discard_seconds, survey.rate(survey.own)
    granted = survey.take("frames")
    lengths = FRAMES if granted > len(FRAMES) * survey.least(survey.own) else FEWEST_FRAMES
    runs = survey.budget.affords(granted / len(lengths), rate, discard, KINDS)
    plan = survey.plan(survey.own).lasting(seconds=runs.seconds, runs=runs.number)
    rungs = []
    for number, frame in enumerate(lengths):
        world = plan.world._replace(options=plan.world.options._replace(frame=frame))
        summary, _ = ensemble.measure(plan._replace(world=world), part(progress, number, len(lengths)))
        if summary.runs < runs.number:
            raise KeyboardInterrupt
        survey.budget.pay_runs(runs, rate, discard, summary.wall_s)
        good = set(summary.outcomes) <= {outcome.value for outcome in ENDED_WELL}
        error = se = None
        if good and summary.speed_mm_s is not None and summary.speed_se_mm_s is not None:
            error = abs(summary.speed_mm_s - true.value) / unit.size
            se = float(np.hypot(widened(runs.number) * summary.speed_se_mm_s, true.se)) / unit.size
        details: Details = {
            "steps_in_a_frame": float(frame),
            "frame_us": 1e6 * frame * plan.world.options.step,
            "speed_mm_s": summary.speed_mm_s,
            "speed_se_mm_s": summary.speed_se_mm_s,
            "energy_error": summary.energy_error,
            "outcomes": ensemble.listed(summary.outcomes),
        }
        setting = f"{frame} steps of {survey.own.step_us:g} us"
        rungs.append(Rung("frozen frames", setting, error, se, summary.cpu_s / summary.simulated_s, details))
    return Ladder(
        "frames",
        "Bias of the mean speed against the time for which pose and contact directions are frozen",
        f"bias of the mean speed, {unit.name}",
        "CPU time of a simulated second, s",
        f"{reference.setting.label}: {true.value:.2f} ± {true.se:.2f} mm/s",
        rungs,
        ("The bias includes that of the step, which is the same in all rungs.",),
    )


def least_of_frames(survey: Survey) -> float:
    """Wall time of the fewest and shortest runs for the fewest lengths of frames, s."""
    return len(FEWEST_FRAMES) * survey.least(survey.own)


def certificate(survey: Survey, progress: Progress) -> str:
    """Mean speed that counts as true, and how far the step next to the finest agrees on it."""
    reference = survey.reference(progress)
    (other,) = survey.measure([survey.certifying], progress)
    bias = survey.bias(other, reference)
    truth = (
        f"{reference.setting.label}: {reference.speed.value:.2f} ± {reference.speed.se:.2f} mm/s "
        f"({reference.runs} runs of {reference.seconds:g} s)"
    )
    if bias is None:
        return f"{truth}; NOT certified: {other.setting.label} ends as {other.outcomes}"
    rival = f"{other.setting.label} {other.speed.value:.2f} ± {other.speed.se:.2f}"
    if abs(bias.size) <= 2.0 * bias.se:
        return f"{truth}; certified to ± {words.number(bias.bound, 2)} mm/s: {rival}, which agrees"
    return f"{truth}; NOT certified: {rival}, {abs(bias.size) / bias.se:.1f} errors away"


def formulas(survey: Survey, reference: Measured) -> Iterator[Rung]:
    """Rungs of the analytical predictions: distance from the reference, and time of a call."""
    if _unknown_to_theory(survey):
        return
    design, contact, w = survey.design, survey.scene.contact, survey.scene.impact_speed
    unit, true = survey.unit(reference), reference.speed
    assert true.value is not None
    assert true.se is not None
    own: Mode = "paper" if design.alike else "coulomb"
    for mode in dict.fromkeys((own, "coulomb")):

        def factor(mode: Mode = mode) -> float:
            formula = stationary(design, survey.mass, contact.restitution, contact.friction, mode)
            return float(formula.factor)

        speed = factor() * w
        details: Details = {"speed_mm_s": speed, "speed_se_mm_s": None, "simulated_s": None, "outcomes": ""}
        title = "paper's eq. 15" if mode == "paper" else "Coulomb formula"
        error = abs(speed - true.value) / unit.size
        yield Rung(title, title, error, true.se / unit.size, cpu_time(factor), details)


def _unknown_to_theory(survey: Survey) -> str:
    """Reason for which the formula has no speed of this walker; "" where it has."""
    contact = survey.scene.contact
    try:
        stationary(survey.design, survey.mass, contact.restitution, contact.friction)
    except TheoryError as refused:
        return f"formula: {refused}"
    return ""


def _rung(survey: Survey, measured: Measured, reference: Measured, own: Details | None = None) -> Rung:
    """Rung of a measured setting with its bias and cost; `own` details precede the common ones."""
    bias, unit = survey.bias(measured, reference), survey.unit(reference)
    details: Details = {
        "speed_mm_s": measured.speed.value,
        "speed_se_mm_s": measured.speed.se,
        "simulated_s": measured.runs * measured.seconds,
        "outcomes": measured.outcomes,
    }
    return Rung(
        "simulation",
        measured.setting.label,
        None if bias is None else abs(bias.size) / unit.size,
        None if bias is None else bias.se / unit.size,
        measured.cpu_s if bias is None else measured.cost_of(unit.fine),
        (own or {}) | details,
    )
