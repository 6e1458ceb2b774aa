"""Drop of a walker on a plate at rest: rebound of the whole structure, as a phone's film shows it.

Seen is the height of the body's middle over where it stands: let go from h_1, it comes up to h_2
again; the rebound is sqrt(h_2 / h_1), for a ball the restitution of its contact.
"""

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.files.progress import Progress
from walkergen.jobs.bench import still
from walkergen.jobs.bench.inverse import Curve
from walkergen.scene import GRAVITY, Scene
from walkergen.simulation import record
from walkergen.simulation.model import Plan
from walkergen.simulation.space.state import HEIGHT
from walkergen.simulation.world import OK, State, World
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

LABELS = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Restitution labels of the feet at which the curve is simulated."""

TILTS = (0.0, 5.0, 10.0, 12.0, 15.0, 20.0, 25.0, 35.0)
FRICTIONS = (0.0, 0.1, 0.2, 0.25, 0.3, 0.5)
HEIGHTS = (1.0, 3.0, 10.0, 30.0)
TURNS = (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""Tilts (deg), frictions, heights (mm) and first turns (deg) of the tables on what else counts."""

FEW = 8
"""Drops from the hand in those tables."""

SAMPLES = 300
"""Poses of a drop: their highest misses 1e-5 of the height."""

NOTICED = 0.05
"""Change of a rebound that a person would notice."""


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
    """Rebounds of one walker in one scene: let go flat once, and from the hand some times."""

    flat: float | None
    mean: float | None
    """Mean of the drops from the hand that rebounded; None without any."""
    sd: float
    """Standard deviation of a drop from the hand."""
    tries: int
    """Number of drops that the mean is of."""
    fell: int
    """Drops from the hand after which it fell over."""


def rebound(plan: Plan, let: Let) -> Rebound:
    """Rebound of a drop, from the height of the body's middle."""
    plan = plan.drawn(np.random.default_rng([plan.scene.run.seed, let.number]))
    standing = plan.start(0.0, 0.0, 0.0)[HEIGHT]
    state = plan.start(let.height, let.pitch, 0.0, let.roll)
    first = state[HEIGHT] - standing
    seconds = seconds_of(first)
    tally = record.new(HEIGHT + 1, seconds, seconds / SAMPLES)
    fell = plan.advance(state, seconds, tally) != OK
    samples = tally.samples
    heights = samples.rows[: samples.cursor[0], 1 + HEIGHT] - standing
    rising = np.flatnonzero(np.diff(heights) > 0.0)
    if not len(rising):
        return Rebound(None if fell else 0.0, fell)
    second = float(heights[rising[0] :].max())
    return Rebound(math.sqrt(max(second, 0.0) / first), fell)


def let_go(plan: Plan, let: Let) -> Plan:
    """Plan whose runs start so, whatever height, turns and phase a run draws for itself."""
    start = plan.model.start

    def started(world: World, clearance: float, pitch: float, phase: float, roll: float) -> State:
        return start(world, let.height, let.pitch, 0.0, let.roll)

    return plan._replace(model=plan.model._replace(start=started))


def from_hand(height: float, turn_deg: float, drops: int, seed: int) -> list[Let]:
    """Drops from the hand: pitch and roll are normal with this deviation, prints are others."""
    turns = np.random.default_rng([seed, 0]).normal(0.0, math.radians(turn_deg), (drops, 2))
    return [
        Let(height, float(pitch), float(roll), number) for number, (pitch, roll) in enumerate(turns)
    ]


def seconds_of(height: float) -> float:
    """Time (s) from the release until a perfect bounce would be back, and a little more."""
    # Contacts take 0.1 ms
    return 2.1 * still.free_fall(height, GRAVITY) + 2e-3


def rebounds(plan: Plan, hand: Sequence[Let]) -> Rebounds:
    """Rebounds of a plan's walker from one height, flat and from the hand."""
    flat = Let(hand[0].height)
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        level, *others = pool.map(lambda let: rebound(plan, let), [flat, *hand])
    kept = np.array([one.ratio for one in others if one.ratio is not None])
    sd = float(kept.std(ddof=1)) if len(kept) > 1 else 0.0
    mean = float(kept.mean()) if len(kept) else None
    return Rebounds(level.ratio, mean, sd, len(kept), sum(one.fell for one in others))


class Dropped(NamedTuple):
    """Rebounds of a walker by the restitution of its feet, and by all else that counts."""

    labels: Array
    by_label: Sequence[Rebounds]
    by: dict[str, list[tuple[float, Rebounds]]]
    """Rebounds at the scene's contact by tilt, friction and height."""
    by_turn: Sequence[tuple[float, float | None, float | None]]
    """First turn (deg), rebound when that is a roll, and when it is a pitch."""

    def curve(self, flat: bool) -> Curve | None:
        """Curve from label to rebound, flat or from the hand; None with fewer than two points."""
        known = [
            (label, one.flat, 0.0, 1) if flat else (label, one.mean, one.sd, one.tries)
            for label, one in zip(self.labels, self.by_label, strict=True)
            if (one.flat is not None if flat else one.tries > 1)
        ]
        columns = np.array(known, float)
        return Curve(*columns.T) if len(columns) > 1 else None

    @property
    def flat_within(self) -> float | None:
        """Largest roll (deg) of the table up to which a drop shows what a flat one does."""
        rolls = [(turn, roll) for turn, roll, _ in self.by_turn if roll is not None]
        alike = None
        for turn, roll in rolls:
            if abs(roll - rolls[0][1]) > NOTICED:
                break
            alike = turn
        return alike


def drop(
    scene: Scene, design: Design, height: float, turn_deg: float, drops: int, progress: Progress
) -> Dropped:
    """Drop a walker at every label, then at the scene's own with other tilts, frictions, heights.

    Lengths in mm. Drops from the hand differ by pitch and roll, the same in every row. Raises
    InputError for feet of more than one material.
    """
    still.one_material(design, "restitution")
    own = still.plan_of(scene, design)
    hand = from_hand(height, turn_deg, drops, scene.run.seed)
    few = hand[:FEW]
    rows: list[tuple[str, float, Scene, Design, Sequence[Let]]] = []
    for label in LABELS:
        rows.append(
            ("restitution", label, still.with_contact(scene, restitution=label), design, hand)
        )
    rows += [("tilt", tilt, scene, one, few) for tilt, one in _tilted(design)]
    for friction in FRICTIONS:
        rows.append(
            ("friction", friction, still.with_contact(scene, friction=friction), design, few)
        )
    for other in HEIGHTS:
        rows.append(("height", other, scene, design, [let._replace(height=other) for let in few]))
    found: dict[str, list[tuple[float, Rebounds]]] = {}
    for number, (what, at, surroundings, walker, chosen) in enumerate(rows):
        progress(f"{what} {at:g}", number, len(rows) + 1)
        plan = still.plan_of(surroundings, walker)
        found.setdefault(what, []).append((at, rebounds(plan, chosen)))
    progress("first turn", len(rows), len(rows) + 1)
    by_label = [one for _, one in found.pop("restitution")]
    turned = _by_turn(own, height)
    return Dropped(np.array(LABELS), by_label, found, turned)


def _tilted(design: Design) -> list[tuple[float, Design]]:
    """The design at those of TILTS that can be built, and at its own."""
    from walkergen.errors import GeometryError

    tilts = sorted({*TILTS, design.tilt_deg})
    found = []
    for tilt in tilts:
        try:
            found.append((tilt, design.variant(tilt_deg=tilt)))
        except GeometryError:
            continue  # no room for so steep a leg, or no leg that follows: the table ends there
    return found


def _by_turn(plan: Plan, height: float) -> list[tuple[float, float | None, float | None]]:
    """Rebounds by the size of the first roll, and of the first pitch."""
    angles = [math.radians(turn) for turn in TURNS]
    rolls = [rebound(plan, Let(height, roll=angle)).ratio for angle in angles]
    pitches = [rebound(plan, Let(height, pitch=angle)).ratio for angle in angles]
    return list(zip(TURNS, rolls, pitches, strict=True))
