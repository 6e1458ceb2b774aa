"""Advice on what to run to meet an error: immediate from stored measurements, or measured within a time budget."""

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from walkergen.commands.accuracy import cell_estimates, machine_speed, step_ladder
from walkergen.commands.accuracy.cell_estimates import Estimate
from walkergen.commands.accuracy.choice import MAX_BIAS_SHARE, Candidate, Choice, choose
from walkergen.commands.accuracy.report import Answer, Answers, mark_accepted
from walkergen.commands.accuracy.survey import Survey
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress
from walkergen.core.tolerance import Tolerance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ERROR_LEVELS = tuple(Tolerance(share, True) for share in (0.2, 0.1, 0.05, 0.02, 0.01))
"""Errors listed on the page."""

SOURCE_LAW = "law"
"""Source of answers below the reference's own error: they extrapolate the fitted law of the step's bias."""

SOURCE_BUDGET = "now"
"""Source of answers that were measured within this budget."""

DOUBLE_STEP_RATIO = 1.9
"""Smallest ratio of two steps on a ladder that counts as a factor of two."""

FREE_RATIO = 1.1
"""Largest ratio of waiting times at which the smaller of two errors counts as free."""

MAX_BUDGET_S = 86_400.0
"""Longest time, s, that is recommended for a survey."""

AnswerAndChoice = tuple[Answer, Choice | None]
"""Answer and the choice that it states, or None."""


def answer_from_cells(estimate: Estimate, title: str, accepted: float | None) -> Answers:
    """Return answers for all ERROR_LEVELS from the stored cells. The answer within an `accepted` error is marked."""
    candidates = estimate.candidates(machine_speed.cpu_per_s())
    found = [find_in_cells(estimate, candidates, wanted) for wanted in ERROR_LEVELS]
    found, free = drop_free(found)
    rows, unmet = mark_accepted([answer for answer, _ in found], accepted)

    def draw() -> "Figure":
        return draw_choice(f"{title} ({estimate.known})", candidates, rows, floor=estimate.law.floor)

    return Answers(rows, [*free, *describe(estimate), *unmet], draw)


def drop_free(found: Sequence[AnswerAndChoice]) -> tuple[list[AnswerAndChoice], list[str]]:
    """Return answers without the largest errors that save no time, and a line that says so, if there are any."""
    kept = list(found)
    while kept[1:] and (kept[1][0].expected_s or math.inf) <= FREE_RATIO * (kept[0][0].expected_s or 0.0):
        del kept[0]
    if len(kept) == len(found):
        return kept, []
    least, wait_s = kept[0][0].error, kept[0][0].expected_s or 0.0
    return kept, [f"Errors above {least} save no time: {least} takes {formatting.format_duration(wait_s)}."]


def find_in_cells(estimate: Estimate, candidates: Sequence[Candidate], wanted: Tolerance) -> AnswerAndChoice:
    """Return the answer for one error from the stored cells."""
    choice = choose(candidates, wanted.value)
    if choice is None:
        least = formatting.format_number(100.0 * candidates[-1].bias / MAX_BIAS_SHARE, 2)
        why = f"The shipped data have no step for errors below {least} %. Run simulate ‹error=›{wanted}."
        return Answer(wanted, "-", None, None, None, estimate.known, why), None
    source = SOURCE_LAW if choice.error < estimate.law.floor else estimate.known
    reason_suffix = "" if estimate.cell else f", to a factor of {cell_estimates.SCALED_SCATTER_FACTOR:g}"
    return _make_answer(wanted, choice, source, reason_suffix), choice


def _make_answer(wanted: Tolerance, choice: Choice, known: str, known_to: str = "") -> Answer:
    """Return the answer that states a choice. `known` is its source; `known_to` is added to its reason."""
    takes_s = choice.wall_time_s(os.cpu_count() or 1)
    return Answer(wanted, choice.candidate.flags, choice.runs, choice.seconds, takes_s, known, choice.reason + known_to)


def describe(estimate: Estimate) -> list[str]:
    """Return lines that explain the source of the numbers and the definition of the error."""
    law, unit = estimate.law, estimate.unit
    bias, bias_se = law.slopes[-1].share.pair
    scale = (
        "the speed"
        if unit == estimate.speed
        else f"{formatting.format_number(unit, 3)} mm/s, a fifth of the plate's speed"
    )
    source = {
        "measured": "Measured for this walker on this plate.",
        "scaled": "Scaled from the paper's walker on its plate, at tilts of 1 to 30 deg and "
        "restitutions of 0.5 to 0.9. The scatter is uncertain by a factor of "
        f"{cell_estimates.SCALED_SCATTER_FACTOR:g}. Measure this walker with ‹budget›, or run simulate ‹error›.",
    }[estimate.known]
    return [
        source,
        f"Errors are half-widths of the 95 % interval, as a share of {scale}. Bias and scatter add in squares.",
        f"Bias of the automatic step: {100 * bias:+.1f} ± {100 * bias_se:.1g} %, averaged over {law.cells} walkers and "
        f"scenes. The reference has a twentieth of this step, and an error of {100 * law.floor:.2g} %. "
        "Smaller errors are extrapolated from the order of the bias.",
    ]


def answer_from_survey(survey: Survey, title: str, progress: Progress) -> Answers:
    """Return the answers of a survey of all steps. Answers beyond the budget come from the stored cells."""
    reference = survey.measure_reference(progress)
    measured = survey.measure(survey.steps, progress)
    candidates = [survey.to_candidate(one) for one in measured]
    estimate = cell_estimates.estimate(survey.design, survey.scene)
    shipped_candidates = estimate.candidates(machine_speed.cpu_per_s())
    found, free = drop_free(
        [_refine(find_in_cells(estimate, shipped_candidates, wanted)[0], candidates, survey) for wanted in ERROR_LEVELS]
    )
    rows, unmet = mark_accepted([answer for answer, _ in found], survey.scene.run.accepted_error)
    refined = [str(row.error) for row in rows if row.known == SOURCE_BUDGET]
    lines = [
        *free,
        f"Reference: {step_ladder.format_reference(survey)}",
        f"Measured within this budget: {', '.join(refined) or 'no row'}. The others are shipped values.",
        *describe(estimate),
        *unmet,
    ]

    def draw() -> "Figure":
        floor = reference.speed.half_width() / survey.unit
        known = [one for one in candidates if math.isfinite(one.bias)]
        return draw_choice(title, known, rows, floor)

    return Answers(rows, lines, draw)


def _refine(stored: Answer, candidates: Sequence[Candidate], survey: Survey) -> AnswerAndChoice:
    """Return the measured answer, or the stored one with a reason if the budget was too short."""
    wanted = stored.error
    choice = choose_measured(candidates, wanted.value)
    if choice is None:
        advice = advise_budget(candidates, wanted, survey)
        return stored._replace(why=f"{stored.why.rstrip('.')}. This budget: {advice}"), None
    return _make_answer(wanted, choice, SOURCE_BUDGET), choice


def choose_measured(candidates: Sequence[Candidate], allowed: float) -> Choice | None:
    """Return the cheapest choice among measured steps; None if no step meets the error.

    A step counts only if the next step of double length also has a bias within the error. Without such a step,
    the longest measured one is checked. Longer steps are refused, and a cliff may lie beyond the next step.
    """
    return choose(
        [one for one in candidates if _double_step_bias(one, candidates) <= MAX_BIAS_SHARE * allowed], allowed
    )


def _double_step_bias(candidate: Candidate, candidates: Sequence[Candidate]) -> float:
    """Return the bias of the step at least DOUBLE_STEP_RATIO as long, or of the longest; infinite if none is longer."""
    step_us = candidate.step_us or 0.0
    longer = sorted((other.step_us or 0.0, other.bias) for other in candidates if (other.step_us or 0.0) > step_us)
    biases = [bias for other_us, bias in longer if other_us >= DOUBLE_STEP_RATIO * step_us] or [
        bias for _, bias in longer[-1:]
    ]
    return biases[0] if biases else math.inf


def advise_budget(candidates: Sequence[Candidate], wanted: Tolerance, survey: Survey) -> str:
    """Return why no measured step meets an error, and the budget that would determine its bias."""
    reference = survey.measured[survey.steps[0]].speed
    accuracy = f"the most accurate setting has an error of {formatting.format_number(reference.half_width(), 2)} mm/s"
    least = min((max(one.bias, _double_step_bias(one, candidates)) for one in candidates), default=math.inf)
    if math.isinf(least):
        return "no longer step gives a speed"
    needed_s = survey.budget_s * max(least / (MAX_BIAS_SHARE * wanted.value), 1.0) ** 2
    if needed_s > MAX_BUDGET_S:
        return f"{accuracy}. A day of simulations would not be enough"
    return f"{accuracy}. Measure longer: ‹budget=›{formatting.format_budget(needed_s)}"


def draw_choice(title: str, candidates: Sequence[Candidate], rows: Sequence[Answer], floor: float) -> "Figure":
    """Draw candidates and the answers of the table, down to the reference's error `floor`."""
    from walkergen.commands.accuracy import figures

    shown = [row for row in rows if row.expected_s is not None and row.error.value >= floor]
    absent = [
        f"{row.error} ({'no setting is known' if row.expected_s is None else 'extrapolated'})"
        for row in rows
        if row not in shown
    ]
    points = [figures.Point(row.error.value, row.expected_s or 0.0, _describe_wait(row)) for row in shown]
    costs = [_describe_wait(row).replace(":", " takes") for row in dict.fromkeys((*shown[:1], *shown[-1:]))]
    message = f"Accuracy of {title}" + (f": {', '.join(costs)}" if costs else "")
    cores = os.cpu_count() or 1
    return figures.choice_figure(figures.FigureData(message, candidates, points, absent, floor, cores))


def _describe_wait(row: Answer) -> str:
    """Return an error with the time that it takes, as text."""
    return f"{row.error}: {formatting.format_duration(row.expected_s or 0.0)}"
