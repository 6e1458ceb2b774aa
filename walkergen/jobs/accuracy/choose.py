"""Choice of the cheapest setting that meets an error, from measured speeds."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files import words
from walkergen.files.progress import Progress
from walkergen.jobs.accuracy import elastic, kept, observed
from walkergen.jobs.accuracy.purse import RUNS, SHORTEST, Purse
from walkergen.jobs.accuracy.setting import Measured, Setting
from walkergen.jobs.accuracy.speeds import Survey, complete
from walkergen.numerics.statistics import Mean
from walkergen.points.wanted import Chosen, Wanted
from walkergen.scene import Scene
from walkergen.simulation import observables, points, resolution
from walkergen.simulation.observables import SPEED
from walkergen.simulation.points import Point
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

SLACK = 1.2
"""Factor by which more time is bought than the estimated error needs, since it fluctuates."""

PILOTS_S = (8.0, 30.0)
"""Wall times in which the ladders are measured when nothing on record will do, s: the longer one
only where the shorter leaves the biases too uncertain, or the runs to come dearer than itself."""

MARGIN = 1.9
"""Ratio of steps on a ladder that counts as two."""

LONGEST_BUDGET = 86_400.0
"""Longest time, s, that is advised for measuring the ladders."""

ATTEMPTS = 3
"""Number of ensembles tried, each longer than the last, until the error is met."""


class Choice(NamedTuple):
    """Setting that meets the error, and the runs that it needs."""

    setting: Setting
    bias_bound: float
    """Upper limit of the setting's systematic error with 95 % confidence, as all errors here in the
    unit of the observable."""
    se: float
    """Standard error that the runs may have."""
    runs: int
    seconds: float
    """Measured time of each run."""
    cpu_s: float
    """Expected CPU time of all runs, s."""


class Met(NamedTuple):
    """Result of an ensemble simulated for an error."""

    choice: Choice
    scene: Scene
    """Scene with the chosen setting."""
    point: Point
    error: float
    """Error obtained with 95 % confidence: the bias's bound and twice the standard error."""
    allowed: float
    on_record: bool
    """True when the ladders had been measured in an earlier survey."""
    se: float | None
    """Standard error of the observable in the ensemble."""
    of: str
    """Name of the observable."""

    def chosen(self) -> Chosen:
        """What was chosen, why, and the error obtained."""
        choice, unit = self.choice, "mm/s" if self.of == SPEED else f"of {self.of}"
        source = "on record" if self.on_record else "measured just now"
        verdict = "within" if self.error <= self.allowed else "NOT within"
        se = math.nan if self.se is None else self.se
        lines = [
            ("chosen", f"{choice.setting.label}, {choice.runs} x {choice.seconds:g} s"),
            ("because", f"cheapest of the ladders {source} with a margin of two in the step; its "
                        f"bias is at most {words.number(choice.bias_bound, 2)} {unit} (95 %)"),
            ("error, 95 %", f"{words.number(self.error, 2)} {unit}, {verdict} the "
                            f"{words.number(self.allowed, 2)} asked (bias, and by Student's t the "
                            f"{words.number(se, 2)} of the runs)"),
        ]  # fmt: skip
        facts = choice._asdict() | {
            "setting": choice.setting.flags,
            "of": self.of,
            "error": None if math.isinf(self.error) else self.error,
            "allowed": self.allowed,
        }
        return Chosen(lines, facts)


class UncertainError(InputError):
    """Error that cannot be promised with what is known, but perhaps with longer measurements."""


def allowed(wanted: Wanted, survey: Survey, reference: Measured) -> float:
    """Allowed error in the observable's unit. Raises InputError for a share of what may be zero."""
    if not wanted.relative:
        return wanted.value
    unit = survey.unit(reference)
    if unit.relative:
        return wanted.value * unit.size
    assert reference.value is not None
    assert reference.se is not None
    known = f"{words.number(reference.value, 2)} ± {words.number(reference.se, 2)}"
    told = f"--error {wanted}: {survey.title}, {known}"
    if survey.of == SPEED:
        raise UncertainError(f"{told} mm/s, may be zero; give the error in mm/s: --error 1mm/s")
    raise UncertainError(f"{told}, is not known well enough: walkergen accuracy ... --budget 5min")


def check(wanted: Wanted, of: str, scene: Scene, design: Design, mass: MassProperties) -> None:
    """Refuse errors of observables that no setting gives. Raises InputError."""
    observed.check(of)
    if of != SPEED and not wanted.relative:
        raise InputError(f"--error {wanted}: only a mean speed is in mm/s; write a share: 5%")
    counted = of == observables.IMPACTS or of.startswith(f"{observables.BY_NUMBER}.")
    if counted and complete(scene) != "space":
        raise InputError(f"--of {of}: {resolution.ENDLESS}")


def candidates(survey: Survey, progress: Progress) -> list[Measured]:
    """Measure all settings that may be chosen: those of the complete model.

    Where a simpler model has the same mean speed, errors of opposite signs happen to cancel.
    """
    return survey.measure(survey.steps, progress)


def choose(survey: Survey, wanted: Wanted, progress: Progress) -> Choice:
    """Choose the setting that meets the error in the least CPU time.

    The 95 % bound of the bias and twice the standard error together stay within the error. A step
    counts only if one twice as long (or the longest that is measured in space, where longer steps
    are refused) has a bias within the error as well: beyond the next step there may be a cliff.
    Raises InputError when the measured biases are not known well enough for that.
    """
    found = candidates(survey, progress)
    reference = survey.reference(progress)
    error = allowed(wanted, survey, reference)
    offers = (
        _offer(survey, one, reference, error)
        for one in found
        if all(_within(survey, other, reference, error) for other in margin(survey, one, found))
    )
    choices = [offer for offer in offers if offer is not None]
    if not choices:
        raise UncertainError(_too_fine(wanted, error, survey, reference))
    return min(choices, key=lambda choice: choice.cpu_s)


def _too_fine(wanted: Wanted, error: float, survey: Survey, reference: Measured) -> str:
    """Advice on the budget that would give the reference's mean speed to a third of the error."""
    assert reference.se is not None
    known = 2.0 * reference.se
    weights = [*map(survey.share, survey.steps), *elastic.WEIGHTS.values()]
    share = survey.share(reference.setting) / sum(weights)
    spent = reference.cpu_s / share / survey.cores
    needed = spent * max(3.0 * known / error, 1.0) ** 2
    told = (
        f"--error {wanted}: the most accurate setting is itself known to "
        f"{words.number(known, 2)} mm/s only; "
    )
    if needed > LONGEST_BUDGET:
        least = _up(3.0 * known * math.sqrt(spent / LONGEST_BUDGET))
        return f"{told}a day of simulations would not do: ask for {words.number(least, 2)}mm/s"
    budget = words.budget(needed)
    return f"{told}measure longer: walkergen accuracy ... --only steps --budget {budget}"


def margin(survey: Survey, one: Measured, found: Sequence[Measured]) -> list[Measured | None]:
    """What must be within the error for `one` to count: a step twice as long; [None] without any.

    Steps on a ladder are rounded: 1.9 times as long is twice.
    """
    step = one.setting.step_us or 0.0
    steps = {other.setting.step_us or 0.0: other for other in found}
    longer = sorted(other for other in steps if other > step)
    twice = [other for other in longer if other >= MARGIN * step]
    if survey.complete == "space":
        twice = twice or longer[-1:]
    return [steps[twice[0]] if twice else None]


def _within(survey: Survey, one: Measured | None, reference: Measured, error: float) -> bool:
    bound = None if one is None else survey.bound(one, reference)
    return bound is not None and bound < 0.9 * error


def _offer(survey: Survey, one: Measured, reference: Measured, error: float) -> Choice | None:
    bound = survey.bound(one, reference)
    if bound is None or not _within(survey, one, reference, error):
        return None
    se = 0.5 * (error - bound)
    time = max(SLACK * one.variance_time / se**2, RUNS * SHORTEST)
    seconds = _up(time / RUNS)
    cpu = one.cpu_per_s * RUNS * (seconds + one.discard_seconds)
    return Choice(one.setting, bound, se, RUNS, seconds, cpu)


def _up(seconds: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return float(f"{math.ceil(seconds / digit - 1e-9) * digit:.2g}")


def _informed(survey: Survey, wanted: Wanted, progress: Progress) -> tuple[Choice, bool]:
    """Choice by the ladders on record, or by those measured for it and kept; True: all on record.

    Ladders are measured anew, for longer and longer, where they do not tell enough, or where so
    little is known that the runs to come would be dearer than to know more.
    Raises InputError when not even the longest tell enough.
    """
    survey.asked = survey.steps
    survey.purse = Purse(PILOTS_S[0], survey.cores, patient=True)
    kept.recall(survey)
    on_record = not survey.due
    found = _tried(survey, wanted, progress)
    for pilot_s in PILOTS_S:
        dear = isinstance(found, Choice) and found.cpu_s > 2.0 * pilot_s * survey.cores
        if _thin(survey, pilot_s) and (dear or not isinstance(found, Choice)):
            on_record = False
            survey.known.clear()
            survey.purse = Purse(pilot_s, survey.cores, patient=True)
            found = _tried(survey, wanted, progress)
    if isinstance(found, UncertainError):
        raise found
    return found, on_record


def _tried(survey: Survey, wanted: Wanted, progress: Progress) -> Choice | UncertainError:
    """Choice by what the survey knows or measures, which is kept; or why there is none."""
    try:
        return choose(survey, wanted, progress)
    except UncertainError as refused:
        return refused
    finally:
        kept.remember(survey)


def _thin(survey: Survey, pilot_s: float) -> bool:
    """Whether the known ladders took much less than a survey of `pilot_s` s would."""
    spent = sum(survey.known[one].cpu_s for one in survey.steps if one in survey.known)
    return spent < 0.5 * pilot_s * survey.cores


def meet(
    scene: Scene,
    design: Design,
    mass: MassProperties,
    wanted: Wanted,
    progress: Progress,
    of: str = SPEED,
) -> Met:
    """Simulate with the cheapest setting that meets the error of the observable `of`.

    Ladders not on record are measured first, and kept. Raises InputError when no setting can do.
    """
    check(wanted, of, scene, design, mass)
    survey = Survey(scene, design, mass, PILOTS_S[0], of)
    choice, on_record = _informed(survey, wanted, progress)
    error = allowed(wanted, survey, survey.reference(progress))
    for _ in range(ATTEMPTS):
        chosen = survey.scene_of(choice.setting, seconds=choice.seconds, runs=choice.runs)
        point = points.measure(points.Asked(chosen, design, mass), progress)
        se = observed.values(point, chosen)[of][1]
        if se is None or point.summary.runs < choice.runs:  # interrupted: shown as it is
            return Met(choice, chosen, point, math.inf, error, on_record, se, of)
        known = Mean(0.0, se, choice.runs - 1.0).interval(0.95)[1]
        obtained = choice.bias_bound + known
        if obtained <= error:
            break
        longer = _up(choice.seconds * SLACK * (se / choice.se) ** 2)
        choice = choice._replace(seconds=longer)
    return Met(choice, chosen, point, obtained, error, on_record, se, of)
