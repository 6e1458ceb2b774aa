"""Choice of the cheapest setting that meets an error, from measured speeds."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.files import words
from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy import models, short_scenes
from walkergen.jobs.trust.accuracy.budget import RUNS, SHORTEST
from walkergen.jobs.trust.accuracy.setting import Measured, Setting
from walkergen.jobs.trust.accuracy.survey import Survey
from walkergen.points.tolerance import Tolerance
from walkergen.points.walkers import error_of_speed

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


def choose(survey: Survey, wanted: Tolerance, progress: Progress) -> Choice | str:
    """Choose the setting that meets the error in the least CPU time; the reason where none does.

    The 95 % bound of the bias and twice the standard error together stay within the error. A step
    counts only if one twice as long (or the longest that is measured, beyond which steps
    are refused) has a bias within the error as well: beyond the next step there may be a cliff.
    """
    measurements = survey.measure(survey.steps, progress)
    reference = survey.reference(progress)
    error = error_of_speed(wanted, survey.scene.drive).allowed(reference.speed.value)
    offers = (
        _offer(survey, candidate, reference, error)
        for candidate in measurements
        if _within(survey, _margin(candidate, measurements), reference, error)
    )
    choices = [offer for offer in offers if offer is not None]
    return (
        min(choices, key=lambda choice: choice.cpu_s) if choices else _too_fine(error, survey, reference, measurements)
    )


def _too_fine(error: float, survey: Survey, reference: Measured, measurements: Sequence[Measured]) -> str:
    """Advice on the budget that would give the least certain bias of one offer to a third of the error.

    A bias has the errors of both rungs, its own and the reference's, and an offer that of its margin too.
    """
    assert reference.speed.se is not None
    certainty = 2.0 * reference.speed.se
    pairs = [(one, _margin(one, measurements)) for one in measurements]
    errors = [
        max(bias.se for bias in biases if bias is not None)
        for one, margin in pairs
        if margin is not None and None not in (biases := [survey.bias(at, reference) for at in (one, margin)])
    ]
    of_bias = 2.0 * min(errors, default=reference.speed.se * math.sqrt(2.0))
    weights = [*map(survey.share, survey.steps), short_scenes.WEIGHT, models.FRAMES_WEIGHT]
    spent = reference.cpu_s / (survey.share(reference.setting) / sum(weights)) / survey.cores
    needed = spent * max(3.0 * of_bias / error, 1.0) ** 2
    problem = f"the most accurate setting is itself known to {words.number(certainty, 2)} mm/s only; "
    if needed > LONGEST_BUDGET:
        least = _up(3.0 * of_bias * math.sqrt(spent / LONGEST_BUDGET))
        return f"{problem}a day of simulations would not do: ask for {words.number(least, 2)}mm/s"
    budget = words.budget(needed + survey.budget.others_s)
    return f"{problem}measure longer: walkergen accuracy ... --only steps --budget {budget}"


def _margin(candidate: Measured, measurements: Sequence[Measured]) -> Measured | None:
    """Measurement that must be within the error for `candidate` to count: of a step twice as long.

    None where there is none. Steps on a ladder are rounded: 1.9 times as long is twice.
    """
    step = candidate.setting.step_us or 0.0
    steps = {other.setting.step_us or 0.0: other for other in measurements}
    longer = sorted(other for other in steps if other > step)
    twice = [other for other in longer if other >= MARGIN * step]
    twice = twice or longer[-1:]
    return steps[twice[0]] if twice else None


def _within(survey: Survey, measured: Measured | None, reference: Measured, error: float) -> bool:
    bound = None if measured is None else survey.bound(measured, reference)
    return bound is not None and bound < 0.9 * error


def _offer(survey: Survey, measured: Measured, reference: Measured, error: float) -> Choice | None:
    bound = survey.bound(measured, reference)
    if bound is None or not _within(survey, measured, reference, error):
        return None
    se = 0.5 * (error - bound)
    time = max(SLACK * measured.variance_time() / se**2, RUNS * SHORTEST)
    seconds = _up(time / RUNS)
    cpu = measured.cpu_per_s * RUNS * (seconds + measured.discard_seconds)
    return Choice(measured.setting, bound, se, RUNS, seconds, cpu)


def _up(seconds: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return float(f"{math.ceil(seconds / digit - 1e-9) * digit:.2g}")
