"""The study of accuracy: its cost in time, as one page, one picture and one table in a folder."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from walkergen.commands.accuracy import answers, cell_estimates, shape_ladder, statistics_ladder, step_ladder
from walkergen.commands.accuracy.report import Answers, Ladder, make_report
from walkergen.commands.accuracy.survey import Survey
from walkergen.core.files.output import Folder, versions
from walkergen.core.files.progress import Progress, part_progress
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files.report import Report

STARTUP_S, PICTURE_S, SHAPE_S = 1.2, 0.9, 1.5
"""Wall times on an idle core in addition to the simulation, s: start-up (imports, and cached kernels),
the picture, and the ladder of shape. Uncertain by a third."""


def _measure_shape(survey: Survey, progress: Progress) -> Ladder:
    return shape_ladder.measure_shapes(survey.design, survey.scene, progress)


LADDERS: dict[str, Sequence[Callable[[Survey, Progress], Ladder]]] = {
    "steps": (step_ladder.measure_speed, step_ladder.measure_observables),
    "statistics": (statistics_ladder.compare_parts,),
    "shape": (_measure_shape,),
}


def study(
    design: Design, scene: Scene, only: Sequence[str], budget_s: float, folder: Path, progress: Progress
) -> Report:
    """Recommend what to run for each error, and measure the ladders `only` within a budget.

    Without ladders the answers come from the shipped cells and this machine's speed. With the ladder of steps they come
    from its measurements. accuracy.csv and accuracy.md are updated after each ladder, so Ctrl-C keeps finished ladders.
    If the budget is too short, the smallest possible budget is used, and the report states it.
    Raises InputError if the scene contradicts itself or the walker, or if there is no mean speed to study.
    """
    title = f"{design.name}, tilt {design.tilt_deg:g}°, on {scene.name}"
    others_s = STARTUP_S + PICTURE_S * ("steps" in only) + SHAPE_S * ("shape" in only)
    survey = Survey(scene, design, solids.mass_of(design), max(budget_s - others_s, 0.0))
    found = None
    if only:
        survey.allot_budget(only)
    else:
        found = answers.answer_from_cells(cell_estimates.estimate(design, scene), title, scene.run.accepted_error)
    ladders: list[Ladder] = []

    def write(given: Answers | None) -> Report:
        """Write the report of everything measured so far."""
        spent_s = survey.simulated_s + others_s
        least_s = spent_s if survey.too_short and spent_s > budget_s else None
        made = make_report(ladders, given, survey.simulated_s, least_s, title, folder)
        made.write(target, pictures=False)
        return made

    with Folder(folder) as target:
        target.claim()
        for ladder in _measure_ladders(survey, only, progress):
            ladders.append(ladder)
            made = write(None)
        if "steps" in only:
            found = answers.answer_from_survey(survey, title, progress)
        if found is not None:
            from walkergen.files import figures

            made = write(found)
            target.write("accuracy.png", figures.png(made.plot()))
        inputs = {"design": design.model_dump(mode="json"), "scene": scene.model_dump(mode="json")}
        target.finish({**inputs, "versions": versions()})
    return made


def _measure_ladders(survey: Survey, only: Sequence[str], progress: Progress) -> Iterator[Ladder]:
    """Yield the ladders of some names, each when it is measured."""
    for place, name in enumerate(only):
        for measure in LADDERS[name]:
            yield measure(survey, part_progress(progress, place, len(only)))
