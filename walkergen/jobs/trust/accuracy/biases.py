"""The ladder of observables: biases of all that is printed against the step, orders and costs."""

from collections.abc import Iterator

from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy import observed
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung, order
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.speeds import Survey
from walkergen.simulation import observables, resolution

RARE = 0.01
"""Share of a type of impact below which it is not studied."""

TOLD = 3.0
"""Standard errors by which the true value must differ from zero for shares of it to mean much."""

WITHIN = 0.05
"""Bias, as a share of the value, that the notes call resolved."""


def ladder(survey: Survey, progress: Progress) -> Ladder:
    """Measure the bias of every observable at every step of the complete model."""
    survey.measure(survey.steps, progress)
    rungs: list[Rung] = []
    notes = []
    for name in observed.NAMES:
        view = survey.showing(name)
        reference = _reference(view, progress)
        if reference is None:
            continue
        series = [*_rungs(view, reference, progress)]
        rungs += series
        notes.append(_note(view, series))
    true = survey.showing(observables.CONTACT).reference(progress)
    return Ladder(
        "observables",
        "Bias of everything that is printed against the step",
        "bias, share of the value",
        "CPU time of a simulated second, s",
        true.setting.label,
        rungs,
        (
            *notes,
            *(() if survey.complete == "space" else (f"Counts: {resolution.ENDLESS}.",)),
            "The figure shows the first eight; the table has all.",
        ),
        "step_us",
    )


def _reference(view: Survey, progress: Progress) -> Measured | None:
    """Measurement that counts as true; None of what is rare, or not told from zero."""
    (finest,) = view.measure(view.steps[:1], progress)
    if finest.value is None or finest.se is None or not abs(finest.value) > TOLD * finest.se:
        return None
    shares = (f"{observables.BY_IMPULSE}.", f"{observables.BY_NUMBER}.")
    rare = view.of.startswith(shares) and finest.value < RARE
    return None if rare else finest


def _rungs(view: Survey, reference: Measured, progress: Progress) -> Iterator[Rung]:
    """A rung for each step that is not the reference itself."""
    assert reference.value is not None
    size = abs(reference.value)
    for measured in view.measure(view.steps, progress):
        if measured.setting == reference.setting:
            continue
        bias = view.bias(measured, reference)
        yield Rung(
            view.of,
            f"{measured.setting.step_us:g} us",
            None if bias is None else abs(bias.size) / size,
            None if bias is None else bias.se / size,
            measured.cpu_per_s,
            {
                "step_us": measured.setting.step_us,
                "value": measured.value,
                "se": measured.se,
                "reference": reference.value,
                "reference_se": reference.se,
                "cpu_s_for_1_percent": measured.cost_of(0.01 * size) if measured.se else None,
            },
        )


def _note(view: Survey, rungs: list[Rung]) -> str:
    """Order of an observable's bias, and the longest step that resolves it to WITHIN."""
    longest = 1e6 * resolution.longest_step(view.plan(view.own))
    certain = [
        rung
        for rung in rungs
        if rung.error is not None
        and rung.error_sd is not None
        and rung.error > 2 * rung.error_sd
        and float(rung.details["step_us"] or 0.0) < longest  # no order beyond the legs' swing
    ]
    sentence = "no bias told from zero"
    if len(certain) >= 3:
        values = [float(rung.details["step_us"] or 0.0) for rung in certain]
        slope, se = order(values, [rung.error or 0.0 for rung in certain])
        sentence = f"measured order {slope:.2f} ± {se:.2f} of the {len(certain)} biases told from zero"
    elif certain:
        sentence = f"biases told from zero at {len(certain)} steps, too few for an order"
    counted = view.of == observables.IMPACTS or view.of.startswith(f"{observables.BY_NUMBER}.")
    if counted and view.complete != "space":
        return f"{view.of}: {sentence}; without limit, see below"
    resolving = 0.0
    for rung in rungs:  # finest first
        if rung.error is None or rung.error + 2.0 * (rung.error_sd or 0.0) > WITHIN:
            break
        resolving = float(rung.details["step_us"] or 0.0)
    resolved = f"up to {resolving:g} us" if resolving else "by no step measured"
    return f"{view.of}: {sentence}; within {100 * WITHIN:g} % (95 %) {resolved}"
