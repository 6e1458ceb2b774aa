"""Drops of a walker on a plate at rest: rebound of the whole structure, as filmed by a phone.

The height counts from the body's middle at rest. Released from h_1, the walker rises to h_2 again. The rebound is
sqrt(h_2 / h_1); for a ball it is the restitution of its contact.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.files.progress import Progress
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation import batch, record
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.space.state import HEIGHT
from walkergen.core.simulation.world import OK
from walkergen.core.walker.design import Design
from walkergen.guests.lab import still_plate
from walkergen.guests.lab.inverse import Curve

RESTITUTIONS = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Restitutions of the feet at which the curve is simulated."""

POSES_PER_DROP = 300
"""Poses of a drop: their highest misses 1e-5 of the height."""


class Let(NamedTuple):
    """Way of letting a walker go: its lowest corner's height (mm), pitch and roll (rad)."""

    height: float
    pitch: float = 0.0
    roll: float = 0.0
    number: int = 0
    """Number of the print that drops, where the scene makes prints differ."""


class Rebound(NamedTuple):
    """Rebound of one drop."""

    ratio: float | None
    """sqrt(h_2 / h_1); None when the walker fell over or a leg folded before it rose."""
    fell: bool
    """Whether that happened at all, until a perfect bounce would be back."""


class Rebounds(NamedTuple):
    """Rebounds of one walker in one scene: released flat once, and from the hand some times."""

    flat: float | None
    mean: float | None
    """Mean of the drops from the hand that rebounded; None without any."""
    sd: float
    """Standard deviation of a drop from the hand."""
    tries: int
    """Number of drops that the mean is of."""
    fell: int
    """Drops from the hand after which it fell over."""


def simulate_drop(plan: Plan, let: Let) -> Rebound:
    """Simulate the rebound of a drop from the height of the body's middle."""
    plan = plan.sample_print(np.random.default_rng([plan.scene.run.seed, let.number]))
    standing = plan.initial_state(0.0, 0.0, 0.0)[HEIGHT]
    state = plan.initial_state(let.height, let.pitch, 0.0, let.roll)
    first = state[HEIGHT] - standing
    seconds = drop_seconds(first)
    tally = record.new_tally(HEIGHT + 1, seconds, seconds / POSES_PER_DROP)
    fell = plan.advance(state, seconds, tally) != OK
    samples = tally.samples
    heights = samples.rows[: samples.cursor[0], 1 + HEIGHT] - standing
    rising = np.flatnonzero(np.diff(heights) > 0.0)
    if not len(rising):
        return Rebound(None if fell else 0.0, fell)
    second = float(heights[rising[0] :].max())
    return Rebound(math.sqrt(max(second, 0.0) / first), fell)


def hand_drops(height: float, turn_deg: float, drops: int, seed: int) -> list[Let]:
    """Draw drops from the hand, each of another print: pitch and roll are normal with deviation `turn_deg`."""
    turns = np.random.default_rng([seed, 0]).normal(0.0, math.radians(turn_deg), (drops, 2))
    return [Let(height, float(pitch), float(roll), number) for number, (pitch, roll) in enumerate(turns)]


def drop_seconds(height: float) -> float:
    """Compute the time (s) of a perfect bounce from the release, and a little more."""
    # Contacts take 0.1 ms
    return 2.1 * still_plate.fall_time(height, GRAVITY) + 2e-3


def simulate_drops(plan: Plan, hand: Sequence[Let]) -> Rebounds:
    """Rebounds of a plan's walker from one height, flat and from the hand."""
    flat = Let(hand[0].height)
    lets = [flat, *hand]
    level, *others = batch.run_all(lambda number, stopped, tell: simulate_drop(plan, lets[number]), len(lets))
    ratios = np.array([bounce.ratio for bounce in others if bounce.ratio is not None])
    sd = float(ratios.std(ddof=1)) if len(ratios) > 1 else 0.0
    mean = float(ratios.mean()) if len(ratios) else None
    return Rebounds(level.ratio, mean, sd, len(ratios), sum(bounce.fell for bounce in others))


def rebounds_by_restitution(scene: Scene, design: Design, hand: Sequence[Let], progress: Progress) -> list[Rebounds]:
    """Rebounds of a walker at every one of RESTITUTIONS, flat and from the hand."""
    rows = []
    for number, restitution in enumerate(RESTITUTIONS):
        progress(f"restitution {restitution:g}", number, len(RESTITUTIONS))
        plan = still_plate.make_plan(still_plate.with_contact(scene, restitution=restitution), design)
        rows.append(simulate_drops(plan, hand))
    return rows


def rebound_curve(rows: Sequence[Rebounds], flat: bool) -> Curve | None:
    """Curve from RESTITUTIONS to the rebound, flat or from the hand; None with fewer than two points."""
    points = [
        (e, row.flat, 0.0, 1) if flat else (e, row.mean, row.sd, row.tries)
        for e, row in zip(RESTITUTIONS, rows, strict=True)
        if (row.flat is not None if flat else row.tries > 1)
    ]
    columns = np.array(points, float)
    return Curve(*columns.T) if len(columns) > 1 else None
