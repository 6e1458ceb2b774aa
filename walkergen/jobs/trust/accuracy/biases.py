"""The ladder of observables: biases of all that is printed against the step, orders and costs."""

from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung, order_in_words
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.survey import NAMES, Survey
from walkergen.numerics.quantity import Quantity
from walkergen.simulation import observables

RARE = 0.01
"""Share of a type of impact below which it is not studied."""

TOLD = 3.0
"""Standard errors by which the true value must differ from zero for shares of it to mean much."""

WITHIN = 0.05
"""Bias, as a share of the value, that the notes call resolved."""


def ladder(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of every observable at every step."""
    finest, *coarser = survey.measure(survey.steps, progress)
    survey.reference(progress)
    rungs: list[Rung] = []
    notes = []
    for name in NAMES:
        true = finest.of(name)
        if _told(true):
            own = [_rung(measured, true) for measured in coarser]
            rungs += own
            notes.append(_note(name, own))
    return Ladder(
        "observables",
        "Bias of everything that is printed against the step",
        "bias, share of the value",
        "CPU time of a simulated second, s",
        finest.setting.label,
        rungs,
        notes,
    )


def _told(true: Quantity) -> bool:
    """Whether a true value is neither rare nor near zero."""
    if true.value is None or true.se is None or not abs(true.value) > TOLD * true.se:
        return False
    shares = (f"{observables.BY_IMPULSE}.", f"{observables.BY_NUMBER}.")
    return not (true.key.startswith(shares) and true.value < RARE)


def _rung(measured: Measured, true: Quantity) -> Rung:
    """Rung of an observable at a step that is not the finest."""
    assert true.value is not None
    size, seen = abs(true.value), measured.of(true.key)
    bias, error, sd = seen.less(true), None, None
    if bias.value is not None and bias.se is not None:
        error, sd = abs(bias.value) / size, bias.se / size
    return Rung(
        true.key,
        f"{measured.setting.step_us:g} us",
        error,
        sd,
        measured.cpu_per_s,
        {
            "step_us": measured.setting.step_us,
            "value": seen.value,
            "se": seen.se,
            "reference": true.value,
            "reference_se": true.se,
            "cpu_s_for_1_percent": measured.cost_of(0.01 * size, true.key) if seen.se else None,
        },
    )


def _note(name: str, rungs: list[Rung]) -> str:
    """Order of an observable's bias, and the longest step that resolves it to WITHIN."""
    points = [
        (float(rung.details["step_us"] or 0.0), rung.error, rung.error_sd or 0.0) for rung in rungs
    ]  # finest first
    certain = [(step, error) for step, error, sd in points if error is not None and error > 2.0 * sd]
    sentence = "no bias told from zero"
    if len(certain) >= 3:
        sentence = f"{order_in_words(*zip(*certain, strict=True))} of the {len(certain)} biases told from zero"
    elif certain:
        sentence = f"biases told from zero at {len(certain)} steps, too few for an order"
    resolving = 0.0
    for step, error, sd in points:
        if error is None or error + 2.0 * sd > WITHIN:
            break
        resolving = step
    resolved = f"up to {resolving:g} us" if resolving else "by no step measured"
    return f"{name}: {sentence}; within {100 * WITHIN:g} % (95 %) {resolved}"
