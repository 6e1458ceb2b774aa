"""What the figure shows of what is shipped, and of a survey."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from walkergen.files import words
from walkergen.jobs.trust.accuracy import advice, pace, step_law
from walkergen.jobs.trust.accuracy.advice import STEPS, Advice, Place
from walkergen.jobs.trust.accuracy.figures import Curve, Mark, Point, Shown
from walkergen.jobs.trust.accuracy.ladder import Rung
from walkergen.jobs.trust.accuracy.report import Answer
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.survey import Survey

Advised = Sequence[tuple[Answer, Advice | str]]
"""Answers, each with the advice that it tells, or why there is none."""

BARS = "%"
"""Unit of errors that are shares."""


def of_place(place: Place, advised: Advised, title: str) -> Shown:
    """What is shipped: curves of steps, answers on this machine."""
    size, loop_s = step_law.unit(place.speed, place.peak), pace.pace()
    runs = advice.RUNS[0]
    curves = [
        Curve(
            f"{step:g}",
            place.law.bound(step),
            place.variance_time / size**2,
            place.work(step) * loop_s,
            runs * place.discard_s,
        )
        for step in STEPS
    ]
    points = list(_points(place, advised, loop_s))
    return Shown(f"{title} ({place.known})", BARS, curves, [], points, place.law.floor)


def _points(place: Place, advised: Advised, loop_s: float) -> Iterator[Point]:
    """Answers by their settings: errors that one setting meets have one point, at the error that it will have."""
    size = step_law.unit(place.speed, place.peak)
    given = [(answer, found) for answer, found in advised if isinstance(found, Advice)]
    for _, group in groupby(given, key=lambda pair: (pair[1].setting, pair[1].runs, pair[1].seconds)):
        same = list(group)
        _, found = same[-1]
        if found.error < place.law.floor * size:
            continue
        errors = ", ".join(str(answer.error).removesuffix(" %") for answer, _ in same)
        told = f"{errors} %: {words.duration(same[0][0].expected_s or 0.0)}"
        yield Point(found.error / size, found.work * loop_s, told)


def of_survey(
    survey: Survey,
    measurements: Sequence[Measured],
    reference: Measured,
    answers: Sequence[Answer],
    formulas: Iterable[Rung],
    title: str,
) -> Shown:
    """What a survey has measured: curves of all steps, their biases, answers by this budget."""
    unit = survey.unit(reference)
    curves, marks = [], []
    for measured in measurements:
        bias, bound = survey.bias(measured, reference), survey.bound(measured, reference)
        if bias is None or bound is None:
            continue
        starts = measured.runs * measured.discard_seconds
        variance = measured.variance_time() / unit.size**2
        curves.append(Curve(measured.setting.label, bound / unit.size, variance, measured.cpu_per_s, starts))
        if measured.setting != reference.setting:
            sizes = abs(bias.size) / unit.size, bias.se / unit.size
            marks.append(Mark(measured.setting.label, measured.cpu_s, *sizes))
    points = [
        Point(
            answer.error.value / (1.0 if answer.error.relative else unit.size),
            answer.expected_s * survey.cores,
            f"{answer.error}: {answer.setting}",
        )
        for answer in answers
        if answer.known == "now" and answer.expected_s is not None
    ]
    note = "; ".join(f"{rung.series}: off by {words.number(100 * (rung.error or 0.0), 2)} %" for rung in formulas)
    floor = 2.0 * (reference.speed.se or 0.0) / unit.size
    return Shown(title, BARS if unit.relative else unit.name, curves, marks, points, floor, note)
