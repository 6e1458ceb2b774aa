"""The study of accuracy: its cost in time, as one page, one picture and one table in a folder."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.files import words
from walkergen.files.output import Folder, versions
from walkergen.files.progress import Progress, part
from walkergen.files.report import Report
from walkergen.jobs.trust.accuracy import biases, choose, models, report, shape, shipped, short_scenes, statistics
from walkergen.jobs.trust.accuracy.choose import Choice
from walkergen.jobs.trust.accuracy.ladder import Ladder
from walkergen.jobs.trust.accuracy.report import Answer, Answers
from walkergen.jobs.trust.accuracy.shipped import ERRORS, SPEED_ERRORS
from walkergen.jobs.trust.accuracy.survey import Survey
from walkergen.scene import Scene
from walkergen.walker import solids
from walkergen.walker.design import Design

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOW = "now"
"""Word for answers that this budget has measured."""


class Job(NamedTuple):
    """Walker, scene, ladders and time of a study."""

    design: Design
    scene: Scene
    only: Sequence[str]
    """Names of the LADDERS to measure, in this order."""
    budget_s: float
    """Wall time for all of it, s; only compilation comes on top."""


LADDERS: dict[str, Sequence[Callable[[Survey, Progress], Ladder]]] = {
    "models": (models.models,),
    "steps": (short_scenes.ladder, models.steps, biases.ladder, models.frames),
    "statistics": (statistics.ladder,),
    "shape": (shape.ladder,),
}

OTHERS: dict[str, tuple[float, Callable[[Survey], float]]] = {
    "steps-short": (short_scenes.WEIGHT, short_scenes.least),
    "frames": (models.FRAMES_WEIGHT, models.least_of_frames),
    "statistics": (statistics.WEIGHT, statistics.least),
}
"""What is simulated besides the settings: weight in the budget, and least wall time, s."""

ANSWERING = {"models", "steps"}
"""Ladders whose measurements answer what to run for which error."""

START_S, PICTURE_S, SHAPE_S = 1.2, 0.9, 1.5
"""Wall times on an idle core (s) of what is not simulated: imports and kernels read from the cache;
the picture; the ladder of shape. Within a third."""


def make(job: Job, folder: Path, progress: Progress, told: Callable[[float], None]) -> Report:
    """Measure ladders; accuracy.csv and accuracy.md are renewed as soon as one is measured.

    With the ladders of models or steps they say what to run for which error, and accuracy.png shows
    it. Ctrl-C keeps the ladders already done. Where the budget is too short the least is taken,
    which `told` is called with, s, before anything is simulated for the ladders.
    Raises InputError when there is no mean speed to study.
    """
    mass = solids.weigh(job.design, solids.build(job.design))
    survey = Survey(job.scene, job.design, mass, job.budget_s)
    survey.budget.pay_other(0.0, START_S)
    least = _share_out(survey, job.only, progress)
    if least is not None:
        told(least)
    title = f"{job.design.name}, tilt {job.design.tilt_deg:g}°, on {job.scene.name}"
    ladders: list[Ladder] = []

    def written(answers: Answers | None = None) -> Report:
        """Report of what is measured so far, written."""
        made = report.of(ladders, answers, survey.budget.simulated_s, least, title, folder)
        made.write(target, pictures=False)
        return made

    with Folder(folder) as target:
        target.claim()
        for place, name in enumerate(job.only):
            for measure in LADDERS[name]:
                ladders.append(_measured(measure, survey, part(progress, place, len(job.only))))
                made = written()
        if {*job.only} & ANSWERING:
            from walkergen.files import figures

            made = written(_answers(survey, title, progress))
            target.write("accuracy.png", figures.png(made.plot()))
        target.finish(_facts(job.design, job.scene))
    return made


def _facts(design: Design, scene: Scene) -> dict[str, Any]:
    """What the manifest says of the inputs."""
    return {"design": design.model_dump(mode="json"), "scene": scene.model_dump(mode="json"), "versions": versions()}


def _measured(measure: Callable[[Survey, Progress], Ladder], survey: Survey, progress: Progress) -> Ladder:
    """Ladder; of the one that is not simulated the time is paid that was kept for it."""
    started = time.perf_counter()
    ladder = measure(survey, progress)
    if measure is shape.ladder:
        survey.budget.pay_other(SHAPE_S, time.perf_counter() - started)
    return ladder


def _share_out(survey: Survey, only: Sequence[str], progress: Progress) -> float | None:
    """Promise each ladder its share of the budget; the least budget where that is too small, s.

    What is not simulated keeps its time.
    The least is what the fewest and shortest runs take that mean something, and it is then spent:
    shorter ones would give numbers without error bars.
    """
    answering = bool({*only} & ANSWERING)
    settings = [*survey.steps, survey.own] if answering else []
    others: list[str] = []
    if "statistics" in only:
        settings += [survey.steps[0], survey.own]
        others += ["statistics"]
    if "steps" in only:
        others += ["steps-short", "frames"]
    survey.others = {name: OTHERS[name][0] for name in others}
    survey.scheduled = list(dict.fromkeys(settings))
    least = 0.0
    for place, setting in enumerate(survey.scheduled):
        progress(f"{setting.label}: compiling", place, len(survey.scheduled))
        least += survey.least(setting)
    least += sum(OTHERS[name][1](survey) for name in others)
    budget = survey.budget
    budget.keep(PICTURE_S * answering + SHAPE_S * ("shape" in only))
    least += budget.spent_s + budget.kept_s * budget.slowness
    if least <= budget.budget_s:
        return None
    budget.budget_s = least
    return least


def at_once(design: Design, scene: Scene, folder: Path) -> Report:
    """Answer from what is shipped and the pace of this machine; nothing but that is simulated.

    Raises InputError where the scene contradicts itself or the walker.
    """
    title = f"{design.name}, tilt {design.tilt_deg:g}°, on {scene.name}"
    answers = shipped.answers(shipped.place_of(design, scene), title)
    rows, unmet = report.marked(answers.rows, scene.run.accepted_error)
    answers = answers._replace(rows=rows, lines=[*answers.lines, *unmet])
    with Folder(folder) as target:
        made = report.of([], answers, 0.0, None, title, folder)
        made.write(target, pictures=False)
        from walkergen.files import figures

        target.write("accuracy.png", figures.png(made.plot()))
        target.finish(_facts(design, scene))
    return made


def _answers(survey: Survey, title: str, progress: Progress) -> Answers:
    """Answer what to run for which error: rows that the budget does not reach keep what is shipped."""
    measurements = survey.measure(survey.steps, progress)
    reference = survey.reference(progress)
    errors = ERRORS if survey.unit(reference).relative else SPEED_ERRORS
    place = shipped.place_of(survey.design, survey.scene)
    before = [shipped.answer(place, error) for error in errors]
    rows, unmet = report.marked([_answer(survey, old, progress) for old in before], survey.scene.run.accepted_error)
    rungs = list(models.formulas(survey, reference))
    refined = [str(row.error) for row in rows if row.known == NOW]
    lines = [
        f"truth: {models.certificate(survey, progress)}",
        f"refined by this budget: {', '.join(refined) or 'no row'}; the others are as shipped",
        *shipped.lines(place),
        *unmet,
    ]

    def draw() -> "Figure":
        from walkergen.jobs.trust.accuracy import drawn
        from walkergen.jobs.trust.accuracy.figures import choice_figure

        return choice_figure(drawn.of_survey(survey, measurements, reference, rows, rungs, title))

    return Answers(rows, lines, draw)


def _answer(survey: Survey, before: Answer, progress: Progress) -> Answer:
    """Answer by the budget; the one `before` with the reason, where the budget was too short for it."""
    wanted = before.error
    choice = choose.choose(survey, wanted, progress)
    if not isinstance(choice, Choice):
        return before._replace(why=f"{before.why}; this budget: {choice}")
    bias = choice.bias_bound
    why = f"bias at most {words.number(bias, 2)} mm/s, ± {words.number(choice.se, 2)} for the runs"
    flags, takes_s = choice.setting.flags, choice.cpu_s / survey.cores
    return Answer(wanted, flags, choice.runs, choice.seconds, takes_s, NOW, why)
