"""Answers of what is shipped: for each error a setting, its runs, and its time on this machine."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from walkergen.files import words
from walkergen.jobs.trust.accuracy import advice, pace, step_law
from walkergen.jobs.trust.accuracy.advice import Advice, Place
from walkergen.jobs.trust.accuracy.report import Answer, Answers
from walkergen.points import expected, tolerance
from walkergen.points.tolerance import Tolerance
from walkergen.scene import Scene
from walkergen.simulation.plan import Plan, prepare
from walkergen.simulation.run import ENDED_WELL, compile_kernels, simulate
from walkergen.walker import solids
from walkergen.walker.design import Design

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ERRORS = ("20%", "10%", "5%", "2%", "1%")
SPEED_ERRORS = ("5mm/s", "2mm/s", "1mm/s", "0.5mm/s")
"""Errors for which the page answers what to run; the latter where the mean speed may be zero."""


DISCARD_S = 0.4
"""Start of the second of what is scaled that is not measured, s."""

LAW = "law"
"""Word for answers below what the reference is known to: they rest on the law by which the step's bias falls."""


def place_of(design: Design, scene: Scene) -> Place:
    """What is shipped of a walker in a scene; of what is scaled a second is simulated.

    Raises InputError where the scene contradicts itself or the walker.
    """
    run = scene.run.model_copy(update={"step_us": None})
    plan = prepare(scene.model_copy(update={"run": run}), design, solids.mass_of(design))
    place = advice.place(plan)
    return place if place.cell else _with_a_second(place, plan)


def _with_a_second(place: Place, plan: Plan) -> Place:
    """Place of a walker that is scaled, with its own speed and cost, as a second of it tells, its scatter a share of
    the speed as before; as it is where a second takes long or does not end well.
    """
    if expected.counted(plan) > expected.LONGEST_START_S:
        return place
    compile_kernels(plan)
    run = simulate(plan.lasting(seconds=pace.LOOP_S, discard_seconds=DISCARD_S), 0)
    if run.outcome not in ENDED_WELL:
        return place
    dearer = run.cpu_s / (pace.LOOP_S + DISCARD_S) / (pace.pace() * place.work(1.0))
    larger = step_law.unit(run.speed, place.peak) / step_law.unit(place.speed, place.peak)
    return place._replace(
        speed=abs(run.speed), variance_time=larger**2 * place.variance_time, work=lambda step: dearer * place.work(step)
    )


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
    known_to = "" if place.cell else f", to a factor of {advice.SCALED_WITHIN:g}"
    why = f"bias at most {words.number(bias, 2)} %, ± {words.number(se, 2)} % for the runs{known_to}"
    return Answer(wanted, found.setting.flags, found.runs, found.seconds, takes_s, known, why)


def lines(place: Place) -> Sequence[str]:
    """Where the numbers come from, and what an error is."""
    law, size = place.law, step_law.unit(place.speed, place.peak)
    own = law.slopes[-1]
    of = "the speed" if size == place.speed else f"{words.number(size, 3)} mm/s, a fifth of the plate's speed"
    known = {
        "measured": "this walker on this plate was measured: speed, scatter and cost are its own",
        "scaled": "scaled from the paper's walker on its plate at tilts of 1 to 30 deg and restitutions of 0.5 to 0.9, "
        "by the plate and what a second of this one gives: its scatter is known to a factor of "
        f"{advice.SCALED_WITHIN:g}, as cells are from neighbours; --budget measures it, simulate --error meets it",
    }[place.known]
    return [
        known,
        f"an error is a half-width of 95 %, a share of {of}: bias and scatter in squares",
        f"bias of the step that feet take by themselves: {100 * own.share:+.1f} ± {100 * own.se:.1g} % on average of "
        f"{law.cells} cells beside a reference by a twentieth of it, known to {100 * law.floor:.2g} %; "
        "below that answers rest on the law by which it falls",
    ]
