"""Runs of a family's members: simulated speeds to compare with the predicted ones."""

from collections.abc import Sequence

from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.theory.prediction import Prediction
from walkergen.points.members import Member, Simulated

AGREEMENT_MM_S = 0.5
"""Difference of speeds, mm/s, below which speeds in whole mm/s count as equal."""


def simulate_members(scene: Scene, members: Sequence[Member], progress: Progress) -> list[Member]:
    """Simulate an ensemble of each member, as the scene's [run] sets, and return the members with these speeds."""
    from walkergen.core.simulation.ensemble import format_outcomes
    from walkergen.points import walkers
    from walkergen.points.experiments import Walker

    wanted = [Walker(scene, member.design, member.mass) for member in members]
    titles = [f"simulating {len(members)} walkers"] * len(members)
    with_speeds = []
    for member, point in zip(members, walkers.simulate_each(wanted, titles, progress), strict=True):
        summary = point.summary
        runs = Simulated(summary.speed, format_outcomes(summary.outcomes), verdict(member.row, summary.speed))
        with_speeds.append(member._replace(simulated=runs))
    return with_speeds


def verdict(row: Prediction, speed: Quantity) -> str:
    """Describe whether the bounds of 95 % of the runs meet those of 68 % of the prediction.

    Speeds within AGREEMENT_MM_S agree.
    """
    simulated, predicted = speed.interval(), row.speed.interval(0.68)
    if simulated is None or predicted is None:
        return "unknown"
    off = row.speed.number - speed.number
    meet = simulated[0] <= predicted[1] and predicted[0] <= simulated[1]
    return "agree" if meet or abs(off) <= AGREEMENT_MM_S else f"off by {off:+.0f}"
