"""Answers of what is shipped: for each error a setting, its runs, and its time on this machine."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from walkergen.files import words
from walkergen.jobs.trust.accuracy import advice, pace, step_law
from walkergen.jobs.trust.accuracy.advice import Advice, Place
from walkergen.jobs.trust.accuracy.report import Answer, Answers
from walkergen.points import tolerance
from walkergen.points.tolerance import Tolerance
from walkergen.scene import Scene
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ERRORS = ("20%", "10%", "5%", "2%", "1%")
SPEED_ERRORS = ("5mm/s", "2mm/s", "1mm/s", "0.5mm/s")
"""Errors for which the page answers what to run; the latter where the mean speed may be zero."""


LAW = "law"
"""Word for answers below what the reference is known to: they rest on the law by which the step's bias falls."""


def place_of(design: Design, scene: Scene) -> Place:
    """What is shipped of a walker in a scene, by the model in space. Raises InputError where that does not know it."""
    legs, run = (scene.legs.model_copy(update={"model": "space"}), scene.run.model_copy(update={"step_us": None}))
    in_space = scene.model_copy(update={"legs": legs, "run": run})
    return advice.place(prepare(in_space, design, solids.mass_of(design)))


def answers(place: Place, title: str) -> Answers:
    """Answers for every error of ERRORS."""
    given = advised(place)

    def draw() -> "Figure":
        from walkergen.jobs.trust.accuracy import drawn
        from walkergen.jobs.trust.accuracy.figures import choice_figure

        return choice_figure(drawn.of_place(place, given, title))

    return Answers([row for row, _ in given], lines(place), draw)


def advised(place: Place) -> list[tuple[Answer, Advice | str]]:
    """Answers for every error of ERRORS, each with the advice that it tells, or why there is none."""
    wishes = [tolerance.parse(error) for error in ERRORS]
    advices = [advice.advise(place, wanted) for wanted in wishes]
    return [(_told(place, *pair), pair[1]) for pair in zip(wishes, advices, strict=True)]


def answer(place: Place, error: str) -> Answer:
    """Answer for one error."""
    wanted = tolerance.parse(error)
    return _told(place, wanted, advice.advise(place, wanted))


def _told(place: Place, wanted: Tolerance, found: Advice | str) -> Answer:
    """Answer that tells an advice."""
    if not isinstance(found, Advice):
        return Answer(wanted, "-", None, None, None, place.known, found)
    known = LAW if found.error < place.law.floor * step_law.unit(place.speed, place.peak) else place.known
    takes_s = found.takes_s(pace.pace(), os.cpu_count() or 1)
    bias, se = (100.0 * part / step_law.unit(place.speed, place.peak) for part in (found.bias, found.se))
    why = f"bias at most {words.number(bias, 2)} %, ± {words.number(se, 2)} % for the runs"
    return Answer(wanted, found.setting.flags, found.runs, found.seconds, takes_s, known, why)


def lines(place: Place) -> Sequence[str]:
    """Where the numbers come from, and what an error is."""
    law, size = place.law, step_law.unit(place.speed, place.peak)
    own = law.slopes[-1]
    of = "the speed" if size == place.speed else f"{words.number(size, 3)} mm/s, a fifth of the plate's speed"
    known = {
        "measured": "this walker on this plate was measured: speed, scatter and cost are its own",
        "scaled": "scaled from the paper's walker on its plate at tilts of 1 to 30 deg and labels of 0.1 to 0.5, by "
        "the plate's speed and frequency, the step and the legs: --budget measures this one",
    }[place.known]
    return [
        known,
        f"an error is a half-width of 95 %, a share of {of}: bias and scatter in squares",
        f"bias of the step that feet take by themselves: {100 * own.share:+.1f} ± {100 * own.se:.1g} % on average of "
        f"{law.cells} cells beside a reference by a twentieth of it, known to {100 * law.floor:.2g} %; "
        "below that answers rest on the law by which it falls",
    ]
