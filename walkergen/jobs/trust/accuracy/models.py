"""The ladder of models: from the paper's formula to the complete walker, most often in space."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from walkergen.errors import TheoryError
from walkergen.files import words
from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung, cpu_time
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.speeds import Survey
from walkergen.theory.speed import Mode
from walkergen.theory.stationary import stationary

Details = dict[str, float | str | None]


TITLES = (
    "What each model of the walker leaves out, and what it costs",
    "What the plane and the law of impact cost in truth, and what space costs in time",
)
"""Titles of the ladder: in a plane, in space."""


def ladder(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of every model against the complete model, and its cost.

    The bias of formulas depends on the scene's impact_speed_factor, which they cannot predict.
    """
    reference = survey.reference(progress)
    settings = [*survey.simpler, survey.own]
    unit = survey.unit(reference)
    rungs = [*formulas(survey, reference)]
    rungs += [rung_of(survey, measured, reference) for measured in survey.measure(settings, progress)]
    return Ladder(
        "models",
        TITLES[survey.complete == "space"],
        f"bias of the mean speed, {unit.name}",
        f"CPU time for a mean speed known to {unit.fine:.2g} mm/s (one standard error), s",
        certificate(survey, progress),
        rungs,
        (
            "A formula takes microseconds because it is given the impact speed w, here "
            f"{survey.scene.impact_speed:.3g} mm/s, which a simulation finds out.",
            *(f"Left out: {reason}" for reason in _left_out(survey)),
        ),
    )


def certificate(survey: Survey, progress: Progress) -> str:
    """Mean speed that counts as true, and how far the step next to the finest agrees on it."""
    reference = survey.reference(progress)
    (other,) = survey.measure([survey.certifying], progress)
    bias = survey.bias(other, reference)
    truth = (
        f"{reference.setting.label}: {reference.value:.2f} ± {reference.se:.2f} mm/s "
        f"({reference.runs} runs of {reference.seconds:g} s)"
    )
    if bias is None:
        return f"{truth}; NOT certified: {other.setting.label} ends as {other.outcomes}"
    rival = f"{other.setting.label} {other.value:.2f} ± {other.se:.2f}"
    if abs(bias.size) <= 2.0 * bias.se:
        return f"{truth}; certified to ± {words.number(bias.bound, 2)} mm/s: {rival}, which agrees"
    return f"{truth}; NOT certified: {rival}, {abs(bias.size) / bias.se:.1f} errors away"


def formulas(survey: Survey, reference: Measured) -> Iterator[Rung]:
    """Rungs of the analytical predictions: distance from the reference, and time of a call."""
    unit = survey.unit(reference)
    contact, w = survey.scene.contact, survey.scene.impact_speed
    if _unknown_to_theory(survey):
        return
    mode_of_scene: Mode = "paper" if contact.law == "poisson" and survey.design.alike else "coulomb"
    modes: tuple[Mode, ...] = tuple(dict.fromkeys((mode_of_scene, "coulomb")))
    assert reference.value is not None
    assert reference.se is not None
    for mode in modes:

        def call(mode: Mode = mode) -> np.ndarray[Any, Any]:
            e, mu = contact.restitution, contact.friction
            return stationary(survey.design, survey.mass, e, mu, mode, contact.law).factor

        speed = float(call()) * w
        error = abs(speed - reference.value) / unit.size
        details = {"speed_mm_s": speed, "speed_se_mm_s": None, "simulated_s": None, "outcomes": ""}
        name = "paper's eq. 15" if mode == "paper" else "Coulomb formula"
        yield Rung(name, name, error, reference.se / unit.size, cpu_time(call), details)


def _left_out(survey: Survey) -> Iterator[str]:
    """Reasons for which planar models and the formula do not know this walker."""
    for reason in (*survey.refusals.values(), _unknown_to_theory(survey)):
        if reason:
            yield reason


def _unknown_to_theory(survey: Survey) -> str:
    """Reason for which the formula has no speed of this walker; "" where it has."""
    contact = survey.scene.contact
    try:
        stationary(survey.design, survey.mass, contact.restitution, contact.friction, law=contact.law)
    except TheoryError as refused:
        return f"formula: {refused}"
    return ""


def rung_of(survey: Survey, measured: Measured, reference: Measured, own: Details | None = None) -> Rung:
    """Rung of a measured setting with its bias and cost; `own` details precede the common ones."""
    bias, unit = survey.bias(measured, reference), survey.unit(reference)
    return Rung(
        measured.setting.series,
        measured.setting.label,
        None if bias is None else abs(bias.size) / unit.size,
        None if bias is None else bias.se / unit.size,
        measured.cpu_s if bias is None else measured.cost_of(unit.fine),
        (own or {}) | _details_of(measured),
    )


def _details_of(measured: Measured) -> Details:
    """Details of a measured speed: the further columns of the table."""
    return {
        "speed_mm_s": measured.value,
        "speed_se_mm_s": measured.se,
        "simulated_s": measured.runs * measured.seconds,
        "outcomes": measured.outcomes,
    }
