"""Drop of a walker on a plate at rest: its rebound by the feet's restitution and all else."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.core.errors import GeometryError
from walkergen.core.files.progress import Progress
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import Plan
from walkergen.core.walker.design import Design
from walkergen.guests.lab import drops, still_plate
from walkergen.guests.lab.drops import Let, Rebounds, simulate_drop, simulate_drops
from walkergen.guests.lab.inverse import Curve

TILTS = (0.0, 5.0, 10.0, 12.0, 15.0, 20.0, 25.0, 35.0)
FRICTIONS = (0.0, 0.1, 0.2, 0.25, 0.3, 0.5)
HEIGHTS = (1.0, 3.0, 10.0, 30.0)
TURNS = (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""Tilts (deg), frictions, heights (mm) and first turns (deg) of the tables on what else counts."""

TABLE_DROPS = 8
"""Drops from the hand in those tables."""

NOTICEABLE_CHANGE = 0.05
"""Change of a rebound that a person would notice."""


class Dropped(NamedTuple):
    """Rebounds of a walker by the restitution of its feet, and by all else that counts."""

    by_label: Sequence[Rebounds]
    """Rebounds at drops.RESTITUTIONS."""
    by: dict[str, list[tuple[float, Rebounds]]]
    """Rebounds at the scene's contact by tilt, friction and height."""
    by_turn: Sequence[tuple[float, float | None, float | None]]
    """First turn (deg), rebound when that is a roll, and when it is a pitch."""

    def curve(self, flat: bool) -> Curve | None:
        """Curve from label to rebound, flat or from the hand; None with fewer than two points."""
        return drops.rebound_curve(self.by_label, flat)

    @property
    def flat_within(self) -> float | None:
        """Largest roll (deg) of the table with the same result as a flat drop."""
        rolls = [(turn, roll) for turn, roll, _ in self.by_turn if roll is not None]
        alike = None
        for turn, roll in rolls:
            if abs(roll - rolls[0][1]) > NOTICEABLE_CHANGE:
                break
            alike = turn
        return alike


def simulate_drop_test(
    scene: Scene, design: Design, height: float, turn_deg: float, tries: int, progress: Progress
) -> Dropped:
    """Drop a walker at every label, then at the scene's own with other tilts, frictions, heights.

    Lengths in mm. `tries` drops from the hand differ by pitch and roll, the same in every row.
    Raises InputError for feet of more than one material.
    """
    still_plate.check_one_material(design)
    own = still_plate.make_plan(scene, design)
    hand = drops.hand_drops(height, turn_deg, tries, scene.run.seed)
    by_label = drops.rebounds_by_restitution(scene, design, hand, progress)
    few = hand[:TABLE_DROPS]
    rows = [("tilt", tilt, still_plate.make_plan(scene, variant), few) for tilt, variant in _tilt_variants(design)]
    for friction in FRICTIONS:
        plan = still_plate.make_plan(still_plate.with_contact(scene, friction=friction), design)
        rows.append(("friction", friction, plan, few))
    rows += [("height", other, own, [let._replace(height=other) for let in few]) for other in HEIGHTS]
    by_condition: dict[str, list[tuple[float, Rebounds]]] = {}
    for number, (what, at, plan, chosen) in enumerate(rows):
        progress(f"{what} {at:g}", number, len(rows) + 1)
        by_condition.setdefault(what, []).append((at, simulate_drops(plan, chosen)))
    progress("first turn", len(rows), len(rows) + 1)
    return Dropped(by_label, by_condition, _rebounds_by_turn(own, height))


def _tilt_variants(design: Design) -> list[tuple[float, Design]]:
    """Return the design at those of TILTS that can be built, and at its own."""
    variants = []
    for tilt in sorted({*TILTS, design.tilt_deg}):
        try:
            variants.append((tilt, design.variant(tilt_deg=tilt)))
        except GeometryError:
            continue  # no room for so steep a leg, or no leg that follows: the table ends there
    return variants


def _rebounds_by_turn(plan: Plan, height: float) -> list[tuple[float, float | None, float | None]]:
    """Rebounds by the size of the first roll, and of the first pitch."""
    angles = [math.radians(turn) for turn in TURNS]
    rolls = [simulate_drop(plan, Let(height, roll=angle)).ratio for angle in angles]
    pitches = [simulate_drop(plan, Let(height, pitch=angle)).ratio for angle in angles]
    return list(zip(TURNS, rolls, pitches, strict=True))
