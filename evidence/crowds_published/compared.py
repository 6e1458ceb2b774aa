"""Published statements compared with our crowds: whether the signs agree."""

import math
import sys
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from evidence.crowds_published.published import FINDINGS, Claim, Finding
from evidence.quantities import ratio
from walkergen.core.numerics.quantity import Quantity, Verdict

Numbers = Mapping[tuple[str, float], Mapping[str, Quantity]]
"""Quantities by their keys, of every crowd and every walker alone, by its series and setting."""

AXES = {"frequency": "speed", "lean": "spin"}
"""Series whose places are numbers of the same walker alone."""


class Compared(NamedTuple):
    """A statement, our numbers by what was varied, and whether their sign is the stated one."""

    finding: Finding
    quantity: str = ""
    """What our numbers are; nothing where none were made."""
    setting: str = ""
    """What was varied, with its unit."""
    points: tuple[tuple[float, Quantity], ...] = ()
    verdict: Verdict = Verdict.MISSING
    note: str = ""
    """How ours are other than the source's, or why nothing is compared."""


def compare_findings(numbers: Numbers) -> Iterator[Compared]:
    """All statements with our numbers."""
    for finding in FINDINGS:
        if finding.key == "one rod":
            yield _compare_single(finding, numbers)
        if finding.not_compared:
            yield Compared(finding, note=finding.not_compared)
        yield from (_compare_claim(finding, claim, numbers) for claim in finding.claims)


def judge_sign(change: Quantity, rises: bool) -> Verdict:
    """Verdict on a change whose sign is stated: no change at all is not one."""
    least = sys.float_info.min
    return change.compare_with_range(least, math.inf) if rises else change.compare_with_range(-math.inf, -least)


def series_points(numbers: Numbers, series: str, key: str) -> tuple[tuple[float, Quantity], ...]:
    """One quantity along a series, by its setting or the same walker's number alone, in order."""
    points = []
    for (of, setting), crowd in numbers.items():
        if of != series:
            continue
        alone = numbers.get((f"{series} alone", setting), {})
        place = alone[AXES[series]].value if series in AXES and AXES[series] in alone else setting
        assert place is not None
        if key == "speed over alone" and "speed" in alone:
            points.append((place, ratio(crowd["speed"], alone["speed"])))
        elif key in crowd:
            points.append((place, crowd[key]))
    return tuple(sorted(points, key=lambda point: point[0]))


def _compare_claim(finding: Finding, claim: Claim, numbers: Numbers) -> Compared:
    points = series_points(numbers, claim.series, claim.number)
    if len(points) < 2:
        return Compared(finding, claim.quantity, claim.setting, points, note="too few runs ended")
    verdict = judge_sign(points[-1][1].minus(points[0][1]), claim.rises)
    return Compared(finding, claim.quantity, claim.setting, points, verdict, claim.differs)


def _compare_single(finding: Finding, numbers: Numbers) -> Compared:
    """Compare the paper's walker alone with one rod, by speed and by scatter between prints."""
    own = numbers["frequency alone", 90.0]
    forward, spread, stated = own["forward"], own["between prints"], finding.values
    speed, scatter = forward.value or math.nan, spread.value or math.nan
    note = (
        f"runs {speed / stated[0]:.0f} times as fast on elastic legs as rods that bounce on their ends, and its prints "
        f"differ by {100.0 * scatter / speed:.0f} % where those differ by {100.0 * stated[1] / stated[0]:.0f} %"
    )
    return Compared(
        finding,
        "speed along the heading, and its standard deviation between prints, mm/s",
        "1: speed; 2: deviation",
        ((1.0, forward), (2.0, spread)),
        judge_sign(forward, rises=True),
        note,
    )
