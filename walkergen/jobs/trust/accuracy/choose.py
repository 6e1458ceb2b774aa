"""Choice of the cheapest setting that meets an error, from measured speeds."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files import words
from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy import space_steps
from walkergen.jobs.trust.accuracy.budget import RUNS, SHORTEST
from walkergen.jobs.trust.accuracy.setting import Measured, Setting
from walkergen.jobs.trust.accuracy.speeds import Survey
from walkergen.points.measure import allowed
from walkergen.points.tolerance import Tolerance

SLACK = 1.2
"""Factor by which more time is bought than the estimated error needs, since it fluctuates."""

MARGIN = 1.9
"""Ratio of steps on a ladder that counts as two."""

LONGEST_BUDGET = 86_400.0
"""Longest time, s, that is advised for measuring the ladders."""


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


def candidates(survey: Survey, progress: Progress) -> list[Measured]:
    """Measure all settings that may be chosen: those of the complete model.

    Where a simpler model has the same mean speed, errors of opposite signs happen to cancel.
    """
    return survey.measure(survey.steps, progress)


def choose(survey: Survey, wanted: Tolerance, progress: Progress) -> Choice:
    """Choose the setting that meets the error in the least CPU time.

    The 95 % bound of the bias and twice the standard error together stay within the error. A step
    counts only if one twice as long (or the longest that is measured in space, where longer steps
    are refused) has a bias within the error as well: beyond the next step there may be a cliff.
    Raises InputError when the measured biases are not known well enough for that.
    """
    measurements = candidates(survey, progress)
    reference = survey.reference(progress)
    error = allowed(wanted, reference.value, survey.scene.drive)
    offers = (
        _offer(survey, candidate, reference, error)
        for candidate in measurements
        if all(_within(survey, other, reference, error) for other in margin(survey, candidate, measurements))
    )
    choices = [offer for offer in offers if offer is not None]
    if not choices:
        raise InputError(_too_fine(wanted, error, survey, reference))
    return min(choices, key=lambda choice: choice.cpu_s)


def _too_fine(wanted: Tolerance, error: float, survey: Survey, reference: Measured) -> str:
    """Advice on the budget that would give the reference's mean speed to a third of the error."""
    assert reference.se is not None
    certainty = 2.0 * reference.se
    weights = [*map(survey.share, survey.steps), *space_steps.WEIGHTS.values()]
    share = survey.share(reference.setting) / sum(weights)
    spent = reference.cpu_s / share / survey.cores
    needed = spent * max(3.0 * certainty / error, 1.0) ** 2
    problem = f"--error {wanted}: the most accurate setting is itself known to {words.number(certainty, 2)} mm/s only; "
    if needed > LONGEST_BUDGET:
        least = _up(3.0 * certainty * math.sqrt(spent / LONGEST_BUDGET))
        return f"{problem}a day of simulations would not do: ask for {words.number(least, 2)}mm/s"
    budget = words.budget(needed + survey.budget.others_s)
    return f"{problem}measure longer: walkergen accuracy ... --only steps --budget {budget}"


def margin(survey: Survey, candidate: Measured, measurements: Sequence[Measured]) -> list[Measured | None]:
    """Measurements that must be within the error for `candidate` to count: a step twice as long.

    [None] where there is none. Steps on a ladder are rounded: 1.9 times as long is twice.
    """
    step = candidate.setting.step_us or 0.0
    steps = {other.setting.step_us or 0.0: other for other in measurements}
    longer = sorted(other for other in steps if other > step)
    twice = [other for other in longer if other >= MARGIN * step]
    if survey.complete == "space":
        twice = twice or longer[-1:]
    return [steps[twice[0]] if twice else None]


def _within(survey: Survey, measured: Measured | None, reference: Measured, error: float) -> bool:
    bound = None if measured is None else survey.bound(measured, reference)
    return bound is not None and bound < 0.9 * error


def _offer(survey: Survey, measured: Measured, reference: Measured, error: float) -> Choice | None:
    bound = survey.bound(measured, reference)
    if bound is None or not _within(survey, measured, reference, error):
        return None
    se = 0.5 * (error - bound)
    time = max(SLACK * measured.variance_time / se**2, RUNS * SHORTEST)
    seconds = _up(time / RUNS)
    cpu = measured.cpu_per_s * RUNS * (seconds + measured.discard_seconds)
    return Choice(measured.setting, bound, se, RUNS, seconds, cpu)


def _up(seconds: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return float(f"{math.ceil(seconds / digit - 1e-9) * digit:.2g}")
