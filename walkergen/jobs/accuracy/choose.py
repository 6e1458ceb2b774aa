"""Choice of the cheapest setting that meets an error, from measured speeds."""

import math
import re
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.accuracy import kept
from walkergen.jobs.accuracy.speeds import FINEST_SHARE, STEP_RUNS, Measured, Setting, Survey
from walkergen.scene import Scene
from walkergen.simulation import points
from walkergen.simulation.points import Point
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

SLACK = 1.2
"""Factor by which more time is bought than the estimated error needs, since it fluctuates."""

SHORTEST = 0.5
"""Shortest run, s: a still shorter run is mostly its discarded start."""

PILOT_S = 30.0
"""Wall time in which the ladders are measured when nothing is on record, s."""

ATTEMPTS = 3
"""Number of ensembles tried, each longer than the last, until the error is met."""


class Wanted(NamedTuple):
    """Error that a person can bear, with 95 % confidence."""

    value: float
    relative: bool
    """True when the value is a share of the mean speed, False when it is in mm/s."""

    def __str__(self) -> str:
        return f"{100 * self.value:g} %" if self.relative else f"{self.value:g} mm/s"


class Choice(NamedTuple):
    """Setting that meets the error, and the runs that it needs."""

    setting: Setting
    bias_bound_mm_s: float
    """Upper limit of the setting's systematic error with 95 % confidence."""
    se_mm_s: float
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
    error_mm_s: float
    """Error obtained with 95 % confidence: the bias's bound and twice the standard error."""
    allowed_mm_s: float
    on_record: bool
    """True when the ladders had been measured in an earlier survey."""


def parse(text: str) -> Wanted:
    """Parse "5%" or "3mm/s". Raises InputError."""
    found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(%|mm/s)\s*", text)
    try:
        value = float(found[1]) if found else math.nan
    except ValueError:
        value = math.nan
    if found is None or not 0 < value < math.inf:
        raise InputError(f"--error {text[:30]!r}: write a positive share or speed, 5% or 3mm/s")
    relative = found[2] == "%"
    if relative and not value <= 100:
        raise InputError(f"--error {text[:30]!r}: at most 100 %")
    return Wanted(0.01 * value if relative else value, relative)


def allowed(wanted: Wanted, survey: Survey, reference: Measured) -> float:
    """Allowed error in mm/s. Raises InputError for a share of a speed that may be zero."""
    if not wanted.relative:
        return wanted.value
    unit = survey.unit(reference)
    if not unit.relative:
        raise InputError(
            f"--error {wanted}: the mean speed, {reference.speed_mm_s:.2g} ± "
            f"{reference.se_mm_s:.2g} mm/s, may be zero; give the error in mm/s: --error 1mm/s"
        )
    return wanted.value * unit.mm_s


def candidates(survey: Survey, progress: Progress) -> list[Measured]:
    """Measure all settings that may be chosen: those of the complete model.

    Where a simpler model has the same mean speed, errors of opposite signs happen to cancel.
    """
    return survey.measure([*survey.events, *survey.steps], progress)


def choose(survey: Survey, wanted: Wanted, progress: Progress) -> Choice:
    """Choose the setting that meets the error in the least CPU time.

    The 95 % bound of the bias and twice the standard error together stay within the error. Raises
    InputError when the measured biases are not known well enough for that.
    """
    found = candidates(survey, progress)
    reference = survey.reference(progress)
    error = allowed(wanted, survey, reference)
    offers = (_offer(survey, one, reference, error) for one in found)
    choices = [offer for offer in offers if offer is not None]
    if not choices:
        raise InputError(_too_fine(wanted, error, survey, reference))
    return min(choices, key=lambda choice: choice.cpu_s)


def _too_fine(wanted: Wanted, error: float, survey: Survey, reference: Measured) -> str:
    """Advice on the budget that would give the reference's mean speed to a third of the error."""
    assert reference.se_mm_s is not None
    known = 2.0 * reference.se_mm_s
    spent = reference.cpu_s / FINEST_SHARE / survey.cores
    budget = _up(spent * max(3.0 * known / error, 1.0) ** 2)
    return (
        f"--error {wanted}: the most accurate setting is itself known to {known:.2g} mm/s only; "
        f"measure longer: walkergen accuracy ... --only steps --budget {budget:g}s"
    )


def _offer(survey: Survey, one: Measured, reference: Measured, error: float) -> Choice | None:
    bound = survey.bound(one, reference)
    if bound is None or bound >= 0.9 * error:
        return None
    se = 0.5 * (error - bound)
    time = max(SLACK * one.variance_time / se**2, STEP_RUNS * SHORTEST)
    seconds = _up(time / STEP_RUNS)
    cpu = one.cpu_per_s * STEP_RUNS * (seconds + one.discard_seconds)
    return Choice(one.setting, bound, se, STEP_RUNS, seconds, cpu)


def _up(seconds: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return float(f"{math.ceil(seconds / digit - 1e-9) * digit:.2g}")


def meet(
    scene: Scene, design: Design, mass: MassProperties, wanted: Wanted, progress: Progress
) -> Met:
    """Simulate with the cheapest setting that meets the error, according to the measured ladders.

    Ladders not on record are measured first, and kept. Raises InputError when no setting can do.
    """
    survey = Survey(scene, design, mass, PILOT_S)
    on_record = kept.recall(survey) > 0
    choice = choose(survey, wanted, progress)
    kept.remember(survey)
    error = allowed(wanted, survey, survey.reference(progress))
    for _ in range(ATTEMPTS):
        chosen = survey.scene_of(choice.setting, seconds=choice.seconds, runs=choice.runs)
        point = points.measure(points.Asked(chosen, design, mass), progress)
        se = point.summary.speed_se_mm_s
        if se is None or point.summary.runs < choice.runs:  # interrupted: shown as it is
            return Met(choice, chosen, point, math.inf, error, on_record)
        obtained = choice.bias_bound_mm_s + 2.0 * se
        if obtained <= error:
            break
        longer = _up(choice.seconds * SLACK * (se / choice.se_mm_s) ** 2)
        choice = choice._replace(seconds=longer)
    return Met(choice, chosen, point, obtained, error, on_record)
