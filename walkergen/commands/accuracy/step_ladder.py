"""The ladders of steps: biases of the mean speed and of everything that is printed, orders and costs.

A rung of a ladder is a step with its error and cost.
"""

from collections.abc import Sequence

from walkergen.commands.accuracy.report import Ladder, Rung, format_order
from walkergen.commands.accuracy.survey import OBSERVABLE_NAMES, StepMeasurement, Survey
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.simulation import observables

MIN_IMPACT_SHARE = 0.01
"""Share of a type of impact below which it is not studied."""

MIN_SIGNIFICANCE_SE = 3.0
"""Smallest ratio of the true value to its standard error at which relative errors are meaningful."""

RESOLVED_BIAS_SHARE = 0.05
"""Bias, as a share of the value, that the notes call resolved."""


def measure_speed(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of the long-run mean speed against the step, with common random phases."""
    survey.measure_reference(progress)
    measurements = survey.measure(survey.steps, progress)
    return Ladder(
        "steps-long",
        "Bias of the long-run mean speed against the step",
        f"bias of the mean speed, share of {formatting.format_number(survey.unit)} mm/s",
        f"CPU time for a mean speed known to {0.01 * survey.unit:.2g} mm/s (one standard error), s",
        format_reference(survey),
        [_speed_rung(survey, measured) for measured in measurements],
        (
            "All steps start from the same drops and phases. The motion is chaotic: a bias "
            "smaller than twice its standard error is not distinguishable from zero.",
        ),
    )


def format_reference(survey: Survey) -> str:
    """Return the mean speed that counts as true, and how far the next finest step agrees with it, in words."""
    reference, other = (survey.measured[step] for step in survey.steps[:2])
    runs = f"{reference.runs} runs of {reference.seconds:g} s"
    truth = f"{reference.label}: {reference.speed.value:.2f} ± {reference.speed.se:.2f} mm/s ({runs})"
    bias = survey.bias(other)
    if bias.value is None or not bias.se:
        return f"{truth}; NOT certified: {other.label} ends as {other.outcomes}"
    rival = f"{other.label} {other.speed.value:.2f} ± {other.speed.se:.2f}"
    if abs(bias.value) <= bias.half_width():
        known_to = formatting.format_number(abs(bias.value) + bias.half_width(), 2)
        return f"{truth}; certified to ± {known_to} mm/s: {rival}, which agrees"
    return f"{truth}; NOT certified: {rival}, {abs(bias.value) / bias.se:.1f} errors away"


def _speed_rung(survey: Survey, measured: StepMeasurement) -> Rung:
    """Return the rung of a measured step for the mean speed."""
    bias, unit = survey.bias(measured), survey.unit
    return Rung(
        "simulation",
        measured.label,
        None if bias.value is None else abs(bias.value) / unit,
        None if bias.value is None or bias.se is None else bias.se / unit,
        measured.cpu_s if bias.value is None else measured.cpu_time_for(0.01 * unit),
        {
            "step_us": measured.step_us,
            "bias_mm_s": bias.value,
            "bias_se_mm_s": bias.se,
            "speed_mm_s": measured.speed.value,
            "speed_se_mm_s": measured.speed.se,
            "simulated_s": measured.runs * measured.seconds,
            "outcomes": measured.outcomes,
        },
    )


def measure_observables(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of every observable at every step."""
    survey.measure_reference(progress)
    finest, *coarser = survey.measure(survey.steps, progress)
    rungs: list[Rung] = []
    notes = []
    for name in OBSERVABLE_NAMES:
        true = finest.quantity(name)
        if _is_clear(true):
            rungs += [_observable_rung(measured, true) for measured in coarser]
            notes.append(_describe_bias(name, abs(true.number), coarser, true))
    return Ladder(
        "observables",
        "Bias of every printed quantity against the step",
        "bias, share of the value",
        "CPU time of a simulated second, s",
        finest.label,
        rungs,
        notes,
    )


def _is_clear(reference: Quantity) -> bool:
    """Return whether a reference value is neither rare nor near zero."""
    if reference.value is None or reference.se is None or not abs(reference.value) > MIN_SIGNIFICANCE_SE * reference.se:
        return False
    shares = (f"{observables.BY_IMPULSE}.", f"{observables.BY_NUMBER}.")
    return not (reference.key.startswith(shares) and reference.value < MIN_IMPACT_SHARE)


def _observable_rung(measured: StepMeasurement, reference: Quantity) -> Rung:
    """Return the rung of an observable at a coarser step, compared with its reference value."""
    assert reference.value is not None
    size, value = abs(reference.value), measured.quantity(reference.key)
    bias, error, sd = value.minus(reference), None, None
    if bias.value is not None and bias.se is not None:
        error, sd = abs(bias.value) / size, bias.se / size
    return Rung(
        reference.key,
        f"{measured.step_us:g} us",
        error,
        sd,
        measured.cpu_per_s,
        {
            "step_us": measured.step_us,
            "value": value.value,
            "se": value.se,
            "reference": reference.value,
            "reference_se": reference.se,
            "cpu_s_for_1_percent": measured.cpu_time_for(0.01 * size, reference.key) if value.se else None,
        },
    )


def _describe_bias(name: str, size: float, measurements: Sequence[StepMeasurement], reference: Quantity) -> str:
    """Describe the order of an observable's bias, and the longest step that resolves it.

    Resolved: within RESOLVED_BIAS_SHARE of `size`, the modulus of its `reference`.
    """
    biases = [(measured.step_us, measured.quantity(name).minus(reference)) for measured in measurements]  # finest first
    certain = [(step, abs(bias.value)) for step, bias in biases if bias.value and abs(bias.value) > bias.half_width()]
    sentence = "no significant bias"
    if len(certain) >= 3:
        sentence = f"{format_order(*zip(*certain, strict=True))} of the {len(certain)} significant biases"
    elif certain:
        sentence = f"significant biases at {len(certain)} steps, too few for an order"
    resolving = 0.0
    for step, bias in biases:
        if bias.value is None or abs(bias.value) + bias.half_width() > RESOLVED_BIAS_SHARE * size:
            break
        resolving = step
    resolved = f"up to {resolving:g} us" if resolving else "for no measured step"
    return f"{name}: {sentence}; within {100 * RESOLVED_BIAS_SHARE:g} % (95 %) {resolved}"
