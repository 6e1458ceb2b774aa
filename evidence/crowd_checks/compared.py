"""Numbers of space and plane side by side, how far they are apart, and why."""

import math
from typing import Literal, NamedTuple

from walkergen.analysis.values import Value
from walkergen.jobs.trust.published import TIMES

Word = Literal["agrees", "disagrees"]


class Row(NamedTuple):
    """A number in space and in the plane; the field names are the columns of crowd_checks.csv."""

    check: str
    """single, binary or collective."""
    case: str
    quantity: str
    unit: str
    space: float
    space_se: float
    plane: float
    plane_se: float
    errors_apart: float
    """Plane less space, in standard errors of the difference."""
    verdict: Word
    why: str
    """Reason where they disagree, as far as we know it."""


def row(check: str, case: str, quantity: str, unit: str, space: Value, plane: Value) -> Row:
    """Row of a number. The single check's plane has the numbers of space for its input, so that the
    plane's own error is all that may part the two.
    """
    se = plane.se if check == "single" else math.hypot(space.se, plane.se)
    gap = plane.mean - space.mean
    apart = gap / se if se > 0.0 else 0.0 if gap == 0.0 else math.copysign(math.inf, gap)
    word: Word = "agrees" if abs(apart) <= TIMES else "disagrees"
    why = "" if word == "agrees" else _reason(check, case, quantity)
    return Row(check, case, quantity, unit, *space, *plane, apart, word, why)


SIDEWAYS = (
    "feet resist more across the run than along it: alone in space a push is forgotten within "
    "49 ms across and 80 ms along, while a card has one time for both, so that walkers in the "
    "plane slip past each other too easily"
)

REASONS: dict[tuple[str, str, str], str] = {
    ("single", "", "delay"): "pushes that turn this walker in space also move its centre to the same side, so that its "
    "velocity leads its heading; the plane knows inertia alone",
    ("binary", "head on", "aside in 0.3 s"): SIDEWAYS,
    (
        "binary",
        "head on",
        "",
    ): "less of an approach comes back than the restitution of the contact says, maybe since feet "
    "rub on the plate during the blow: a plane with 0.1 to 0.3 in place of 0.5 is nearer",
    ("binary", "corner on face", ""): SIDEWAYS,
    ("binary", "glancing", ""): SIDEWAYS,
    ("binary", "edge on edge", ""): SIDEWAYS,
    ("collective", "", ""): SIDEWAYS,
}
"""What we take for the reason, by check, case and quantity: the most special that is given."""


def _reason(check: str, case: str, quantity: str) -> str:
    keys = (check, case, quantity), (check, case, ""), (check, "", quantity), (check, "", "")
    return next((REASONS[key] for key in keys if key in REASONS), "we know no reason")
