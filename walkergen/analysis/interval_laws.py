"""Bounds of numbers over tracks: for walkers that differ, and for numbers that scatter as a variance.

A number whose error is that of a jackknife has Student's bounds, unless one of these laws holds.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from walkergen.core.numerics import statistics
from walkergen.core.numerics.distributions import fisher_tail, student_quantile
from walkergen.core.numerics.quantity import Quantity

DIFFERENCE_P_VALUE = 0.05
"""Probability, for walkers that are alike, that an error over walkers replaces that over pieces."""

RUN_QUANTITIES = ("ballistic_speed", "diffusivity", "crossover_time")
"""Numbers of the squared displacement. Fast walkers, and those that turn little, weigh more in them."""

SPREADING_QUANTITIES = ("diffusivity", "crossover_time")
"""Numbers that depend on the rate of losing direction if there is a run, else on squared displacements."""

TURN_POWERS = {
    "persistence_rate": 1,
    **dict.fromkeys(("persistence_time", "persistence_length", *SPREADING_QUANTITIES), -1),
}
"""Powers of numbers that, so raised, scatter as the mean square of turns: as a variance."""


def with_walker_error(number: Quantity, leave_one_out: Sequence[float], always: bool) -> Quantity:
    """Return a number with its error from the scatter between walkers if they differ, or if `always`; else unchanged.

    `leave_one_out`: the number's values, from all walkers, then with each walker left out.
    """
    freedom, values = len(leave_one_out) - 1, np.array(leave_one_out)[:, None]
    if freedom < 1 or not number.se or not np.isfinite(values).all():
        return number
    error = float(statistics.jackknife_error(values)[0])
    if not always and fisher_tail(freedom, number.freedom, (error / number.se) ** 2) > DIFFERENCE_P_VALUE:
        return number
    return number._replace(se=error, freedom=float(freedom), least=0.0)


def with_detection_limit(number: Quantity, share: float) -> Quantity:
    """Return a diffusivity or crossover time with wider bounds, because it is reported only if a run's rate is large.

    `share`: the smallest rate that is reported, divided by the estimated one; 0 without a limit. Chance can make the
    rate large and the number small: its upper bound allows for that. Other numbers are unchanged.
    """
    return number._replace(least=share / number.number) if share and number.key in SPREADING_QUANTITIES else number


def with_variance_laws(estimates: Mapping[str, Quantity], run: bool) -> dict[str, Quantity]:
    """Return the estimates; those that scatter like a variance have the bounds of one.

    `run`: whether the walkers run ahead. If not, diffusivity and crossover time scatter like the squared displacement.
    """
    laws = TURN_POWERS if run else TURN_POWERS | dict.fromkeys(SPREADING_QUANTITIES, 1)
    numbers = {**estimates, **_persistence_time_and_length(estimates)}
    return {
        name: _with_variance_bounds(number, laws[name]) if name in laws else number for name, number in numbers.items()
    }


def _with_variance_bounds(number: Quantity, power: int) -> Quantity:
    """Return a number with bounds as if its `power`-th power scattered as a variance.

    The degrees of freedom match its relative error; fewer if that is itself uncertain, but at least one. A rate that
    may be 0 or less keeps its own bounds. A diffusivity with a value is above 0, however few the walkers are.
    """
    bounds = number.interval()
    if (
        bounds is None
        or not number.se
        or not (bounds[0] > 0.0 or (number.key in SPREADING_QUANTITIES and number.number > 0.0))
    ):
        return number
    wider = student_quantile(math.inf, 0.975) / student_quantile(number.freedom, 0.975)
    freedom = max(2.0 * (wider * number.number / number.se) ** 2, 1.0)
    return number._replace(freedom=freedom, noise=0.0, power=power)


def turning_scatter_refusals(estimates: Mapping[str, Quantity], scatter: Quantity) -> dict[str, Quantity]:
    """Return diffusivity and crossover time as refused, if unequal turning rates may shift them beyond their bounds.

    `scatter`: standard deviation of the walkers' turning rates, rad/s. One fit to all uses only their mean rate: what a
    run adds, v^2 rate / (2 (rate^2 + turn^2)), is off by a share of (scatter / rate)^2 at most, to second order.
    """
    rate = estimates["persistence_rate"]
    if not (scatter.known and rate.known and rate.number > 0.0):
        return {}
    share = (scatter.number / rate.number) ** 2
    reason = f"walkers turn at rates of their own, {scatter.number:.2g} rad/s apart: analyse them one by one"
    numbers = (estimates[name] for name in SPREADING_QUANTITIES)
    return {
        number.key: number._replace(value=None, se=None, refused=reason)
        for number in numbers
        if number.known and number.half_width() < share * number.number
    }


def _persistence_time_and_length(estimates: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return persistence time and length with the relative error of the rate: 1 / rate may be huge in a sample."""
    rate, speed = estimates["persistence_rate"], estimates["speed"]
    times = {}
    for name, other in (("persistence_time", None), ("persistence_length", speed)):
        number = estimates[name]
        if number.known and rate.value and rate.se:
            shares = [factor.se / factor.value for factor in (rate, other) if factor and factor.se and factor.value]
            times[name] = number._replace(se=number.number * math.hypot(*shares), freedom=rate.freedom)
    return times
