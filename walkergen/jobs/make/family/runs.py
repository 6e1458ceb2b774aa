"""Runs of a family's members: their speeds beside the predicted ones, or in their place."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from walkergen.files.progress import Progress
from walkergen.points.members import Member, Simulated
from walkergen.scene import Scene
from walkergen.theory.prediction import Prediction

if TYPE_CHECKING:
    from walkergen.simulation.ensemble import Summary

NOTE = (
    "mean of the runs in place of the theory's speed; its bounds hold their scatter and step, not "
    "what is not known of contact and print: simulate --uncertain"
)
"""Note on a speed that runs gave."""

SURE = 1.96
"""Standard deviations on either side that hold a normal number with 95 %."""

SMALL = 0.5
"""Difference of speeds, mm/s, that verdicts in whole mm/s do not see."""


def simulated(scene: Scene, members: Sequence[Member], progress: Progress) -> list[Member]:
    """The members with their simulated speeds, each an ensemble as the scene's [run] says."""
    from walkergen.points import walkers
    from walkergen.simulation.ensemble import listed
    from walkergen.simulation.experiments import Walker

    wanted = [Walker(scene, member.design, member.mass) for member in members]
    titles = [f"simulating {member.name}" for member in members]
    with_speeds = []
    for member, point in zip(members, walkers.each(wanted, titles, progress), strict=True):
        summary = point.summary
        runs = Simulated(
            summary.speed_mm_s,
            summary.speed_se_mm_s,
            summary.speed_low_95_mm_s,
            summary.speed_high_95_mm_s,
            point.model,
            point.method,
            listed(summary.outcomes),
            verdict(member.row, summary),
        )
        with_speeds.append(member._replace(row=with_runs(member.row, runs), simulated=runs))
    return with_speeds


def verdict(row: Prediction, summary: "Summary") -> str:
    """Say whether the bounds of 95 % of the runs meet those of 68 % of the prediction.

    Speeds within SMALL agree. A prediction by the theory alone gives way to the runs.
    """
    speed, low, high = summary.speed_mm_s, summary.speed_low_95_mm_s, summary.speed_high_95_mm_s
    if speed is None or low is None or high is None:
        return "unknown"
    if row.speed_by == "theory":
        return "the runs stand"
    off = row.speed_mm_s - speed
    meet = low <= row.speed_high_68_mm_s and row.speed_low_68_mm_s <= high
    return "agree" if meet or abs(off) <= SMALL else f"off by {off:+.0f}"


def with_runs(row: Prediction, runs: Simulated) -> Prediction:
    """Row in which the speed of the runs stands for the theory's, where they tell one."""
    speed, low, high = runs.sim_speed_mm_s, runs.sim_low_95_mm_s, runs.sim_high_95_mm_s
    if row.speed_by != "theory" or speed is None or low is None or high is None:
        return row
    return row._replace(
        speed_mm_s=speed,
        speed_sd_mm_s=0.5 * (high - low) / SURE,
        speed_by="runs",
        speed_low_68_mm_s=speed + (low - speed) / SURE,
        speed_high_68_mm_s=speed + (high - speed) / SURE,
        speed_low_95_mm_s=low,
        speed_high_95_mm_s=high,
        note=NOTE,
    )
