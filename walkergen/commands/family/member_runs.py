"""Runs of a family's members: their speeds beside the predicted ones."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from walkergen.core.files.progress import Progress
from walkergen.core.scene import Scene
from walkergen.core.theory.prediction import Prediction
from walkergen.points.members import Member, Simulated

if TYPE_CHECKING:
    from walkergen.core.simulation.ensemble import Summary

AGREEMENT_MM_S = 0.5
"""Difference of speeds, mm/s, that verdicts in whole mm/s do not see."""


def simulate_members(scene: Scene, members: Sequence[Member], progress: Progress) -> list[Member]:
    """Simulate an ensemble of each member, as the scene's [run] sets, and return the members with these speeds."""
    from walkergen.core.simulation.ensemble import format_outcomes
    from walkergen.points import walkers
    from walkergen.points.experiments import Walker

    wanted = [Walker(scene, member.design, member.mass) for member in members]
    titles = [f"simulating {member.name}" for member in members]
    with_speeds = []
    for member, point in zip(members, walkers.simulate_each(wanted, titles, progress), strict=True):
        summary = point.summary
        runs = Simulated(
            summary.speed_mm_s,
            summary.speed_se_mm_s,
            summary.speed_low_95_mm_s,
            summary.speed_high_95_mm_s,
            format_outcomes(summary.outcomes),
            verdict(member.row, summary),
        )
        with_speeds.append(member._replace(simulated=runs))
    return with_speeds


def verdict(row: Prediction, summary: "Summary") -> str:
    """Say whether the bounds of 95 % of the runs meet those of 68 % of the prediction.

    Speeds within SMALL agree.
    """
    numbers = (
        *(summary.speed_mm_s, summary.speed_low_95_mm_s, summary.speed_high_95_mm_s),
        *(row.speed_mm_s, row.speed_low_68_mm_s, row.speed_high_68_mm_s),
    )
    speed, low, high, predicted, below, above = (math.nan if number is None else number for number in numbers)
    if math.isnan(speed + low + high + predicted):
        return "unknown"
    off = predicted - speed
    meet = low <= above and below <= high
    return "agree" if meet or abs(off) <= AGREEMENT_MM_S else f"off by {off:+.0f}"
