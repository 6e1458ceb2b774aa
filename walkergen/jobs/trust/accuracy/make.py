"""The study of accuracy: its cost in time, as ladders in a folder."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.files import words
from walkergen.files.output import Folder
from walkergen.files.progress import Progress, part
from walkergen.files.report import Report
from walkergen.jobs.trust.accuracy import biases, choose, models, report, shape, space_steps, statistics, steps
from walkergen.jobs.trust.accuracy.ladder import Ladder
from walkergen.jobs.trust.accuracy.report import Answer
from walkergen.jobs.trust.accuracy.speeds import Survey
from walkergen.points import tolerance
from walkergen.scene import Scene
from walkergen.walker import solids
from walkergen.walker.design import Design

ERRORS = ("20%", "10%", "5%", "2%", "1%")
SPEED_ERRORS = ("5mm/s", "2mm/s", "1mm/s", "0.5mm/s")
"""Errors for which the page answers what to run; the latter where the mean speed may be zero."""


class Job(NamedTuple):
    """Walker, scene, ladders and time of a study."""

    design: Design
    scene: Scene
    only: Sequence[str]
    """Names of the LADDERS to measure, in this order."""
    budget_s: float
    """Wall time for all of it, s; only compilation comes on top."""


LADDERS: dict[str, Sequence[Callable[[Survey, Progress], Ladder]]] = {
    "models": (models.ladder,),
    "steps": (steps.short, steps.long, biases.ladder, space_steps.frames),
    "statistics": (statistics.ladder,),
    "shape": (shape.ladder,),
}

LEAST: dict[str, Callable[[Survey], float]] = {
    "steps-short": space_steps.least_of_short,
    "frames": space_steps.least_of_frames,
    "statistics": statistics.least,
}
"""Least wall time of what is simulated besides the settings, s."""

ANSWERING = {"models", "steps"}
"""Ladders whose measurements answer what to run for which error."""

START_S, FIRST_PICTURE_S, PICTURE_S, SHAPE_S = 1.2, 0.5, 0.4, 1.5
"""Wall times on an idle core (s) of what is not simulated: imports and kernels read from the cache;
the library of pictures; a ladder's picture and tables; the ladder of shape. Within a third."""


def make(job: Job, folder: Path, progress: Progress, told: Callable[[float], None]) -> Report:
    """Measure ladders and write NAME.csv, .md, .png, .pdf for each as soon as it is measured.

    With the ladders of models or steps also accuracy.md, choice.png and .pdf: what to run for which
    error. Ctrl-C keeps the ladders already done. Where the budget is too short the least is taken,
    which `told` is called with, s, before anything is simulated for the ladders.
    Raises InputError when there is no mean speed to study.
    """
    parts = solids.build(job.design)
    mass = solids.weigh(job.design, parts)
    survey = Survey(job.scene, job.design, mass, job.budget_s)
    survey.budget.pay_other(0.0, START_S)
    least = _share_out(survey, job.only, progress)
    if least is not None:
        told(least)
    title = f"{job.design.name}, tilt {job.design.tilt_deg:g}°, on {job.scene.name}"
    ladders: list[Ladder] = []
    answers = None
    with Folder(folder, "") as target:
        for place, name in enumerate(job.only):
            for measure in LADDERS[name]:
                if measure is space_steps.frames and survey.complete != "space":
                    continue
                with _other(survey, SHAPE_S if measure is shape.ladder else 0.0):
                    ladders.append(measure(survey, part(progress, place, len(job.only))))
                with _other(survey, PICTURE_S):
                    report.of_ladder(ladders[-1], title).write(target, pictures=True)
        if {*job.only} & ANSWERING:
            answers = _answers(survey, title, progress)
            with _other(survey, PICTURE_S):
                answers.write_figures(target)
            page = f"{answers.markdown()}\n![choice](choice.png)\n"
            target.write("accuracy.md", page.encode())
    return report.of(ladders, answers, survey.budget.simulated_s, least, title, folder)


def _share_out(survey: Survey, only: Sequence[str], progress: Progress) -> float | None:
    """Promise each ladder its share of the budget; the least budget where that is too small, s.

    What is not simulated keeps its time.
    The least is what the fewest and shortest runs take that mean something, and it is then spent:
    shorter ones would give numbers without error bars.
    """
    settings = [*survey.steps, survey.own] if {*only} & ANSWERING else []
    settings += survey.simpler if "models" in only else []
    least = 0.0
    if "statistics" in only:
        settings += [survey.steps[0], survey.own]
        survey.others["statistics"] = statistics.WEIGHT
    if "steps" in only and survey.complete == "space":
        survey.others |= space_steps.WEIGHTS
    survey.scheduled = list(dict.fromkeys(settings))
    for place, setting in enumerate(survey.scheduled):
        progress(f"{setting.label}: compiling", place, len(survey.scheduled))
        least += survey.least(setting)
    for name in survey.others:
        least += LEAST[name](survey)
    survey.budget.keep(_others_s(survey, only))
    least += survey.budget.spent_s + survey.budget.kept_s * survey.budget.slowness
    if least <= survey.budget.budget_s:
        return None
    survey.budget.budget_s = least
    return least


def _others_s(survey: Survey, only: Sequence[str]) -> float:
    """Wall time of all that is not simulated after the start, on an idle machine, s."""
    measures = [measure for name in only for measure in LADDERS[name]]
    if survey.complete != "space":
        measures = [measure for measure in measures if measure is not space_steps.frames]
    pictures = len(measures) + bool({*only} & ANSWERING)
    return FIRST_PICTURE_S + PICTURE_S * pictures + SHAPE_S * (shape.ladder in measures)


@contextmanager
def _other(survey: Survey, expected_s: float) -> Iterator[None]:
    """Guard of what time was kept for: the wall time that no simulation took is paid."""
    budget = survey.budget
    started, simulated_s = time.perf_counter(), budget.simulated_s
    yield
    wall_s = time.perf_counter() - started - (budget.simulated_s - simulated_s)
    budget.pay_other(expected_s, max(wall_s, 0.0))


def check(names: str) -> list[str]:
    """Parse a comma-separated list of ladders. Raises InputError."""
    ladders = [word.strip() for word in names.split(",")]
    for word in ladders:
        if word not in LADDERS:
            raise InputError(f"--only {word[:30]!r}: must be one of {', '.join(LADDERS)}")
    return list(dict.fromkeys(ladders))


def _answers(survey: Survey, title: str, progress: Progress) -> Report:
    """Answer what to run for which error."""
    measurements = choose.candidates(survey, progress)
    reference = survey.reference(progress)
    errors = ERRORS if survey.unit(reference).relative else SPEED_ERRORS
    answers = [_answer(survey, error, progress) for error in errors]
    formulas = list(models.formulas(survey, reference))
    others = [survey.measured[setting] for setting in survey.simpler if setting in survey.measured]

    def draw() -> Any:
        from walkergen.jobs.trust.accuracy.choice_figure import choice_figure

        return choice_figure(survey, [*measurements, *others], reference, formulas, title)

    return report.of_answers(answers, models.certificate(survey, progress), title, draw)


def _answer(survey: Survey, error: str, progress: Progress) -> Answer:
    wanted = tolerance.parse(error)
    try:
        choice = choose.choose(survey, wanted, progress)
    except InputError as refused:
        return Answer(str(wanted), "-", None, None, None, str(refused).partition(": ")[2])
    bias = choice.bias_bound
    why = f"bias at most {words.number(bias, 2)} mm/s, ± {words.number(choice.se, 2)} for the runs"
    expected = choice.cpu_s / survey.cores
    return Answer(str(wanted), choice.setting.flags, choice.runs, choice.seconds, expected, why)
