"""Published statements on crowds beside ours: the sign of each, and why where it is another."""

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

from evidence.crowds_published.published import FINDINGS, Finding
from walkergen.analysis.values import Value, ratio
from walkergen.jobs.trust.published import TIMES

Word = Literal["agrees", "disagrees", "undecided", "not compared"]

Numbers = Mapping[str, Value]
"""Numbers of a crowd by name, means over its runs."""

Found = Mapping[tuple[str, float], Numbers]
"""Numbers of every crowd by its series and setting."""


class Compared(NamedTuple):
    """A statement, our numbers by what was varied, and whether their sign is the stated one."""

    finding: Finding
    quantity: str
    """What our numbers are; nothing where none were made."""
    setting: str
    """What was varied, with its unit."""
    points: tuple[tuple[float, Value], ...]
    word: Word
    why: str
    """Cause of another sign, what leaves it open, or why nothing was compared."""


class Claim(NamedTuple):
    """How one statement is compared: the series that shows it, and the sign that is stated."""

    key: str
    """Of `FINDINGS`."""
    series: str
    number: str
    quantity: str
    setting: str
    stated: float
    """Sign of the change from the first setting to the last: 1 rises, -1 falls."""
    otherwise: str
    """Why ours may go another way."""


CLAIMS = (
    Claim(
        "tapered rods",
        "packing",
        "order",
        "polar order of the paper's walkers",
        "packing",
        1.0,
        "our rods are straight, for which no source here has flocking without a medium, and a "
        "periodic square of five lengths turns a flock back on itself",
    ),
    Claim(
        "tapered rods",
        "tapered",
        "order",
        "polar order of walkers whose front narrows in two steps",
        "packing",
        1.0,
        "our taper is short, for the legs need the body's width, and lasts ahead of them only",
    ),
    Claim(
        "brownian vibrators",
        "packing",
        "agreement",
        "mean cosine between velocities of neighbours",
        "packing",
        1.0,
        "the source's discs have no heading and move by chance between contacts; ours are driven "
        "along a heading that a contact hardly turns: neighbours push on against each other",
    ),
    Claim(
        "frequency",
        "frequency",
        "clustered",
        "share of walkers that touch others",
        "speed alone as the frequency falls, mm/s",
        -1.0,
        "at one peak acceleration frequencies of 150 to 60 Hz make our walkers' speed, and their "
        "inertia, half as large again at most; what we read does not say what the source held",
    ),
    Claim(
        "walls",
        "frequency",
        "at wall",
        "density at the wall over that of the dish",
        "speed alone as the frequency falls, mm/s",
        -1.0,
        "our dish is five bodies wide, and a rod that runs into its wall pushes on until something "
        "turns it: what inertia carries away is small beside that",
    ),
    Claim(
        "swirl or stasis",
        "lean",
        "circulation",
        "circulation about the middle of the dish",
        "spin alone: turning rate x half length / speed",
        1.0,
        "a dish of few bodies leaves no room to swirl in, and hard walls hold those that walk",
    ),
    Claim(
        "swirl or stasis",
        "lean",
        "speed over alone",
        "speed in the crowd over that alone",
        "spin alone: turning rate x half length / speed",
        1.0,
        "walkers that spin are slower and meet more often on their way",
    ),
    Claim(
        "polar discs",
        "gamma",
        "order",
        "polar order",
        "peak acceleration, g",
        1.0,
        "the source's discs are nearly round and their alignment comes of their push; ours are "
        "rods, which meet as hard at any speed",
    ),
)

NOT_COMPARED = {
    "flock by medium": "it needs beads, bodies without legs, which our crowds have none of",
    "two discs": "one contact at a time is compared with MuJoCo (tests/test_crowd_mujoco.py)",
    "long range": "it needs thousands of walkers: --model flat",
    "delay": "it is of walkers alone: `walkergen card` measures it",
    "rotors": "parting takes minutes of the plate's time; ours lasts seconds",
}
"""Statements without a number of ours, and why."""

AXES = {"frequency": "speed", "lean": "spin"}
"""Series whose places are numbers of the same walker alone."""


def compared(found: Found) -> list[Compared]:
    """All statements with our numbers."""
    rows = [alone(found), *(_of(claim, found) for claim in CLAIMS)]
    rows += [Compared(FINDINGS[key], "", "", (), "not compared", why) for key, why in NOT_COMPARED.items()]
    order = list(FINDINGS)
    return sorted(rows, key=lambda row: order.index(row.finding.key))


def alone(found: Found) -> Compared:
    """The paper's walker alone beside one rod: it runs ahead, and prints differ."""
    numbers = found["frequency alone", 90.0]
    forward, spread = numbers["forward"], numbers["between prints"]
    stated = FINDINGS["one rod"].values
    why = (
        f"runs {forward.mean / stated[0]:.0f} times as fast on elastic legs as rods that bounce on "
        f"their ends, and its prints differ by {100.0 * spread.mean / forward.mean:.0f} % where "
        f"those differ by {100.0 * stated[1] / stated[0]:.0f} %"
    )
    return Compared(
        FINDINGS["one rod"],
        "speed along the heading, and its standard deviation between prints, mm/s",
        "1: speed; 2: deviation",
        ((1.0, forward), (2.0, spread)),
        sign_of(forward, 1.0),
        why,
    )


def sign_of(change: Value, stated: float) -> Word:
    """Verdict on a change whose sign is stated, beyond TIMES standard errors."""
    if abs(change.mean) <= TIMES * change.se or change.mean == 0.0:
        return "undecided"
    return "agrees" if change.mean * stated > 0.0 else "disagrees"


def _of(claim: Claim, found: Found) -> Compared:
    finding, points = FINDINGS[claim.key], points_of(found, claim.series, claim.number)
    if len(points) < 2:
        return Compared(finding, claim.quantity, claim.setting, points, "not compared", "too few runs ended")
    first, last = points[0][1], points[-1][1]
    change = Value(last.mean - first.mean, math.hypot(last.se, first.se))
    word = sign_of(change, claim.stated)
    why = "" if word == "agrees" else claim.otherwise
    return Compared(finding, claim.quantity, claim.setting, points, word, why)


def points_of(found: Found, series: str, number: str) -> tuple[tuple[float, Value], ...]:
    """One number along a series, by its setting or the same walker's number alone, in order."""
    points = []
    for (of, setting), numbers in found.items():
        if of != series:
            continue
        own = found.get((f"{series} alone", setting), {})
        place = own[AXES[series]].mean if series in AXES and AXES[series] in own else setting
        if number == "speed over alone" and "speed" in own:
            points.append((place, ratio(numbers["speed"], own["speed"])))
        elif number in numbers:
            points.append((place, numbers[number]))
    return tuple(sorted(points, key=lambda point: point[0]))
