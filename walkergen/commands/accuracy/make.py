"""The study of accuracy: its cost in time, as one page, one picture and one table in a folder."""

from collections.abc import Callable, Sequence
from pathlib import Path

from walkergen.commands.accuracy import answers, cell_estimates, step_ladder
from walkergen.commands.accuracy.report import Answers, Ladder, make_report
from walkergen.commands.accuracy.survey import Survey
from walkergen.core.files.output import Folder, versions
from walkergen.core.files.progress import Progress, part_progress
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import figures
from walkergen.files.report import Report

STARTUP_S, PICTURE_S = 1.2, 0.9
"""Wall times on an idle core in addition to the simulation, s: start-up (imports, and cached kernels), and the
picture. Uncertain by a third."""

LADDERS: Sequence[Callable[[Survey, Progress], Ladder]] = (step_ladder.measure_speed, step_ladder.measure_observables)


def study(design: Design, scene: Scene, budget_s: float | None, folder: Path, progress: Progress) -> Report:
    """Recommend what to run for each error, and measure the ladders of steps within a budget, if any.

    Without a budget the answers come from the stored cells and this machine's speed, otherwise from the ladders.
    accuracy.csv and accuracy.md are updated after each ladder, so Ctrl-C keeps finished ladders.
    If the budget is too short, the smallest possible budget is used, and the report states it.
    Raises InputError if the scene contradicts itself or the walker, or if there is no mean speed to study.
    """
    title = f"{design.name}, tilt {design.tilt_deg:g}°, on {scene.name}"
    ladders: list[Ladder] = []

    def write(given: Answers | None, survey: Survey | None) -> Report:
        """Write the report of everything measured so far, with the given answers, if any."""
        simulated_s = 0.0 if survey is None else survey.simulated_s
        spent_s = simulated_s + STARTUP_S + PICTURE_S
        least_s = spent_s if survey is not None and survey.too_short and spent_s > (budget_s or 0.0) else None
        made = make_report(ladders, given, simulated_s, least_s, title, folder)
        made.write(target, pictures=False)
        return made

    if budget_s is None:
        survey = None
        found = answers.answer_from_cells(cell_estimates.estimate(design, scene), title, scene.run.accepted_error)
    else:
        survey = Survey(scene, design, solids.mass_of(design), max(budget_s - STARTUP_S - PICTURE_S, 0.0))
        survey.allot_budget()
    with Folder(folder) as target:
        target.claim()
        if survey is not None:
            for index, measure in enumerate(LADDERS):
                ladders.append(measure(survey, part_progress(progress, index, len(LADDERS))))
                write(None, survey)
            found = answers.answer_from_survey(survey, title, progress)
        made = write(found, survey)
        target.write("accuracy.png", figures.png(made.plot()))
        inputs = {"design": design.model_dump(mode="json"), "scene": scene.model_dump(mode="json")}
        target.finish({**inputs, "versions": versions()})
    return made
