"""Whether a model without inertia is enough: what a walker's numbers say, and what others saw.

While a velocity relaxes a walker turns by a share of its direction, and coasts over a share of its
length. Where both are small, a model in which the velocity follows the heading at once has the same
places, and walkers that meet stop as if they had no mass.
"""

import math
from typing import NamedTuple

from walkergen.analysis.relaxation import Relaxation
from walkergen.crowd.card import Known, Overdamped
from walkergen.files import words
from walkergen.numerics.quantity import Quantity

LIMIT = 0.1
"""Share of a direction or a length below which it is neglected: our choice, about the error of the
numbers themselves."""

ERRORS = 2.0
"""Standard errors by which a share must be off the limit to decide."""

SOURCES = (
    "Scholz, Jahanshahi, Ldov, Loewen (Nat. Commun. 9, 5156, 2018) saw velocities of printed "
    "vibrobots lag behind their headings, which a Langevin model with inertia explains; Caprini, "
    "Breoni, Ldov, Scholz, Loewen (arXiv 2406.01038) saw inertia let them bounce back and hinder "
    "their clusters"
)
"""What was found of printed walkers, by those who filmed them."""


class Share(NamedTuple):
    """Share of a direction, or of a length, that passes while a velocity relaxes."""

    words: str
    value: float
    se: float


def judge(speed: Known, turning: Known, rotation: Known, velocity: Relaxation, length_mm: float) -> Overdamped:
    """Judge by what a walker turns and coasts while its velocity relaxes."""
    shares = shares_of(speed, turning, rotation, velocity, length_mm)
    told = "; ".join(
        f"{share.words} {words.with_error(share.value, share.se)}, "
        f"{'above' if share.value > LIMIT else 'below'} {LIMIT:g}"
        for share in shares
    )
    if any(share.value - ERRORS * share.se > LIMIT for share in shares):
        return Overdamped(enough=False, reason=told)
    if all(share.value + ERRORS * share.se < LIMIT for share in shares):
        return Overdamped(enough=True, reason=told)
    return Overdamped(enough=None, reason=f"{told}: too near to tell")


def shares_of(
    speed: Known, turning: Known, rotation: Known, velocity: Relaxation, length_mm: float
) -> tuple[Share, Share]:
    """Share of its direction by which a walker turns, and of its length over which it coasts."""
    time, time_se = _value(velocity.time), velocity.time.se or 0.0
    rate = rotation.value + abs(turning.value)
    rate_se = math.hypot(rotation.se or 0.0, turning.se or 0.0)
    pace = math.hypot(speed.value, math.sqrt(2.0) * velocity.deviation)
    pace_se = abs(speed.value) / pace * (speed.se or 0.0) if pace else 0.0
    turned = Share("turned while its velocity relaxes, rad:", rate * time, math.hypot(rate_se * time, rate * time_se))
    coasted = Share(
        "coasted meanwhile, in lengths of its body:",
        pace * time / length_mm,
        math.hypot(pace_se * time, pace * time_se) / length_mm,
    )
    return turned, coasted


def in_words(verdict: Overdamped) -> str:
    """Verdict as a sentence."""
    answer = {
        True: "is enough for this walker",
        False: "is not enough for this walker",
        None: "may or may not be enough for this walker",
    }[verdict.enough]
    return f"a model without inertia {answer}: {verdict.reason}"


def _value(estimate: Quantity) -> float:
    assert estimate.value is not None
    return estimate.value
