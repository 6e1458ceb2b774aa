"""Simulated drops of a walker on a plate at rest: rebound of the whole structure, as filmed by a phone.

Heights are those of the body's middle above its height at rest. Released from h_1, the walker rises to h_2. The rebound
is sqrt(h_2 / h_1). For a ball it is the restitution of its contact. Drops by hand have a random pitch and roll.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Design, mass_of
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.scene import GRAVITY, Scene, still_plate_drive
from walkergen.core.simulation import batch, record
from walkergen.core.simulation.effects.resolve import without_plate_effects
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.space.state import HEIGHT
from walkergen.core.simulation.world import OK
from walkergen.guests.lab.inverse import Curve

RESTITUTIONS = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Restitutions of the feet at which the curve is simulated."""

POSES_PER_DROP = 300
"""Recorded poses of a drop: the highest one is 1e-5 of the height too low."""

STEP_RATIO = 0.25
"""Time step over the step of long runs. A rebound varies with the instant within a step at which a foot lands: by a
share of 0.02 with the step of long runs, by 0.004 with a quarter of it (10 deg, drops of 8 to 12 mm)."""


class Drop(NamedTuple):
    """Release of a walker: height of its lowest corner (mm), pitch and roll (rad)."""

    height: float
    pitch: float = 0.0
    roll: float = 0.0
    number: int = 0
    """Number of the print that drops, if the scene makes prints differ."""


class Rebound(NamedTuple):
    """Rebound of one drop."""

    ratio: float | None
    """sqrt(h_2 / h_1); None when the walker fell over or a leg folded before it rose."""
    fell: bool
    """Whether the walker fell over, or a leg folded, within the time of a perfect bounce."""


class Rebounds(NamedTuple):
    """Rebounds of one walker in one scene: released flat once, and several times from the hand."""

    flat: float | None
    mean: float | None
    """Mean over the drops from the hand that rebounded; None without any."""
    sd: float
    """Standard deviation of the rebound between drops from the hand."""
    tries: int
    """Number of drops in the mean."""
    fell: int
    """Number of drops from the hand after which the walker fell over."""


def still_scene(scene: Scene) -> Scene:
    """Return the scene on an endless, level plate at rest, with the same contact and feet."""
    return without_plate_effects(scene).model_copy(update={"drive": still_plate_drive(scene.drive.frequency)})


def make_plan(scene: Scene, design: Design) -> Plan:
    """Return the plan of drops on the scene's plate at rest, with a finer time step unless the scene sets the step."""
    plan = prepare(still_scene(scene), design, mass_of(design))
    return plan if scene.run.step_us is not None else plan.coarser(STEP_RATIO)


def with_contact(scene: Scene, **contact: float) -> Scene:
    """Return the scene with other values in its table [contact], such as `restitution=0.5`."""
    return scene.model_copy(update={"contact": scene.contact.model_copy(update=contact)})


def check_one_restitution(design: Design) -> None:
    """Raise InputError if a foot has its own restitution."""
    exceptions = [number for number, limb in enumerate(design.limbs, start=1) if limb.restitution is not None]
    if exceptions:
        raise InputError(
            f"{design.name}: legs[{exceptions[0]}].restitution belongs to one foot, but a drop determines one "
            "restitution for all feet. Drop a walker without this key"
        )


def simulate_drop(plan: Plan, drop: Drop) -> Rebound:
    """Simulate one drop and return its rebound. `drop.number` seeds the printed walker's random differences."""
    plan = plan.sample_print(np.random.default_rng([plan.scene.run.seed, drop.number]))
    rest_height = plan.initial_state(0.0, 0.0, 0.0)[HEIGHT]
    state = plan.initial_state(drop.height, drop.pitch, 0.0, drop.roll)
    drop_height = state[HEIGHT] - rest_height
    seconds = drop_seconds(drop_height)
    tally = record.new_tally(HEIGHT + 1, seconds, seconds / POSES_PER_DROP)
    fell = plan.advance(state, seconds, tally) != OK
    samples = tally.samples
    heights = samples.rows[: samples.cursor[0], 1 + HEIGHT] - rest_height
    rising = np.flatnonzero(np.diff(heights) > 0.0)
    if not len(rising):
        return Rebound(None if fell else 0.0, fell)
    rebound_height = float(heights[rising[0] :].max())
    return Rebound(math.sqrt(max(rebound_height, 0.0) / drop_height), fell)


def sample_hand_drops(height: float, sd_deg: float, count: int, seed: int) -> list[Drop]:
    """Draw `count` random drops by hand from `height` (mm), each of another print. `sd_deg`: sd of pitch and roll."""
    angles = np.random.default_rng([seed, 0]).normal(0.0, math.radians(sd_deg), (count, 2))
    return [Drop(height, float(pitch), float(roll), number) for number, (pitch, roll) in enumerate(angles)]


def drop_seconds(height: float) -> float:
    """Compute the time (s) to simulate: fall from `height` (mm), rebound to the same height, and a little more."""
    # Contacts take 0.1 ms
    return 2.1 * math.sqrt(2.0 * max(height, 0.0) / GRAVITY) + 2e-3


def simulate_drops(plan: Plan, hand: Sequence[Drop]) -> Rebounds:
    """Simulate the drops by hand in `hand`, and a flat drop from the same height. Return a summary of all rebounds."""
    flat = Drop(hand[0].height)
    drops = [flat, *hand]
    level, *others = batch.run_all(lambda index, stopped, tell: simulate_drop(plan, drops[index]), len(drops))
    ratios = np.array([bounce.ratio for bounce in others if bounce.ratio is not None])
    sd = float(ratios.std(ddof=1)) if len(ratios) > 1 else 0.0
    mean = float(ratios.mean()) if len(ratios) else None
    return Rebounds(level.ratio, mean, sd, len(ratios), sum(bounce.fell for bounce in others))


def rebounds_by_restitution(scene: Scene, design: Design, hand: Sequence[Drop], progress: Progress) -> list[Rebounds]:
    """Return the rebounds of the drops in `hand` and of a flat drop, for each of the feet's RESTITUTIONS."""
    rows = []
    for number, restitution in enumerate(RESTITUTIONS):
        progress(f"restitution {restitution:g}", number, len(RESTITUTIONS))
        plan = make_plan(with_contact(scene, restitution=restitution), design)
        rows.append(simulate_drops(plan, hand))
    return rows


def rebound_curve(rows: Sequence[Rebounds], flat: bool) -> Curve | None:
    """Return the curve of rebound against RESTITUTIONS, of flat drops if `flat`, else by hand. None below 2 points."""
    points = [  # fields of a Curve
        (e, row.flat, 0.0, 1) if flat else (e, row.mean, row.sd, row.tries)
        for e, row in zip(RESTITUTIONS, rows, strict=True)
        if (row.flat is not None if flat else row.tries > 1)
    ]
    columns = np.array(points, float)
    return Curve(*columns.T) if len(columns) > 1 else None
