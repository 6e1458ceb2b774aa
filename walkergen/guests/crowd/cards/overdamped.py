"""Test whether a model without inertia is enough: a walker's numbers and published criteria.

While its velocity relaxes, a walker turns by an angle and coasts over a part of its length. If both are small, a model
without velocity lag gives the same positions. Walkers that meet then stop as if they had no mass.
"""

import math

from walkergen.core import Quantity, Verdict, format_with_error
from walkergen.guests.crowd.cards.card import Overdamped
from walkergen.guests.crowd.cards.relaxation import Relaxation

NEGLIGIBLE_SHARE = 0.1
"""Turn (rad) and coasting distance (body lengths) below which inertia is neglected: our choice, about their errors."""

SOURCES = (
    "Scholz, Jahanshahi, Ldov, Loewen (Nat. Commun. 9, 5156, 2018) saw velocities of printed "
    "vibrobots lag behind their headings, which a Langevin model with inertia explains; Caprini, "
    "Breoni, Ldov, Scholz, Loewen (arXiv 2406.01038) saw inertia let them bounce back and hinder "
    "their clusters"
)
"""Published results for printed walkers."""


def assess_inertia(
    speed: Quantity, turning_rate: Quantity, rotational_diffusion: Quantity, velocity: Relaxation, length_mm: float
) -> Overdamped:
    """Return whether a model without inertia is enough for a walker, from its turn and coasting distance."""
    distances = turn_and_coasting(speed, turning_rate, rotational_diffusion, velocity, length_mm)
    reason = "; ".join(map(_format_with_limit, distances))
    verdicts = {distance.compare_with_range(-math.inf, NEGLIGIBLE_SHARE) for distance in distances}
    if Verdict.DISAGREE in verdicts:
        return Overdamped(enough=False, reason=reason)
    if verdicts == {Verdict.AGREE}:
        return Overdamped(enough=True, reason=reason)
    return Overdamped(enough=None, reason=f"{reason}: too close to the limit to decide")


def turn_and_coasting(
    speed: Quantity, turning_rate: Quantity, rotational_diffusion: Quantity, velocity: Relaxation, length_mm: float
) -> tuple[Quantity, Quantity]:
    """Compute the angle (rad) by which a walker turns, and its path (in its lengths), while its velocity relaxes."""
    time, time_se = velocity.time.number, velocity.time.se or 0.0
    rate = rotational_diffusion.number + abs(turning_rate.number)
    rate_se = math.hypot(rotational_diffusion.se or 0.0, turning_rate.se or 0.0)
    pace = math.hypot(speed.number, math.sqrt(2.0) * velocity.deviation)
    pace_se = abs(speed.number) / pace * (speed.se or 0.0) if pace else 0.0
    turned_se = math.hypot(rate_se * time, rate * time_se)
    coasted_se = math.hypot(pace_se * time, pace * time_se) / length_mm
    freedom = velocity.time.freedom
    return (
        Quantity("turned while its velocity relaxes, rad", "", rate * time, turned_se, freedom),
        Quantity("coasted meanwhile, in lengths of its body", "", pace * time / length_mm, coasted_se, freedom),
    )


def _format_with_limit(distance: Quantity) -> str:
    """Format the turn or the coasting distance with its error, and whether it is above or below the limit."""
    side = "above" if distance.number > NEGLIGIBLE_SHARE else "below"
    return f"{distance.key}: {format_with_error(distance.number, distance.se or 0.0)}, {side} {NEGLIGIBLE_SHARE:g}"


def format_verdict(verdict: Overdamped) -> str:
    """Describe in a sentence whether a model without inertia is enough, and why."""
    answer = {
        True: "is enough for this walker",
        False: "is not enough for this walker",
        None: "may or may not be enough for this walker",
    }[verdict.enough]
    return f"a model without inertia {answer}: {verdict.reason}"
