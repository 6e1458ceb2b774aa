"""Runs of a walker against the wall of a dish, at angles from head on to along it."""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core import ENDED_WELL, Design, Dish, InputError, MassProperties, Progress, Quantity, Scene
from walkergen.guests.crowd.cards import walls
from walkergen.guests.crowd.cards.walls import ByWall
from walkergen.guests.crowd.space import run as crowd
from walkergen.points.experiments import Walker
from walkergen.readers.walkers import top_outline

MAX_START_ANGLE = math.radians(85.0)
"""Largest angle from the outward direction at a walker's release."""

SETTLING_S = 0.2
"""Time (s) before the record begins: a walker is released at rest, and drops."""

MAX_RUN_S = 4.0
"""Measured time of a run, at most: by then walkers stand to the wall as they go on to do."""

START_GAP_MM = 2.0
"""Extra distance from the wall at a walker's release, mm, added to the path before recording starts."""


class Walled(NamedTuple):
    """Motion by a wall, and the dish."""

    by_wall: ByWall
    dish: Dish
    runs: int


def check_dish(dish: Dish) -> None:
    """Raise InputError for a dish without walls."""
    if dish.kind == "periodic":
        raise InputError(f"‹arena=›{dish.words}: has no walls; give disc:120 or ring:160,60")


def simulate_wall_runs(
    scene: Scene, design: Design, mass: MassProperties, speed: Quantity, progress: Progress
) -> Walled:
    """Simulate a single walker of this mean speed against the wall of the scene's dish.

    Raises InputError for a dish too small for it.
    """
    dish = scene.crowd.dish
    outline = np.concatenate(top_outline.outline_of(design, mass))
    reach = float(np.hypot(*outline.T).max())
    place = 0.5 * dish.sizes[0] - reach - START_GAP_MM - max(speed.number, 0.0) * SETTLING_S
    within = 0.5 * dish.sizes[1] if dish.kind == "ring" else -0.5 * dish.sizes[0]
    if place - reach < within or min(dish.box) < 2.0 * (reach + START_GAP_MM):
        raise InputError(f"‹arena=›{dish.words}: too small for a walker that reaches {reach:.3g} mm: give a larger one")
    seconds = min(scene.run.seconds, MAX_RUN_S)
    kept = scene.run.model_copy(update={"discard_seconds": SETTLING_S, "seconds": seconds})
    scene = scene.model_copy(update={"run": kept})
    interval = 1.0 / Walker(scene, design, mass).shaken.frequency
    runs = []
    for number, angle in enumerate(np.linspace(-MAX_START_ANGLE, MAX_START_ANGLE, scene.run.runs)):
        progress("walls", number, scene.run.runs)
        plan = crowd.prepare(scene, [(design, mass)], [0], np.array([[place, 0.0, angle]]))
        result = crowd.simulate(plan, number, 1.0 / interval)
        if result.outcomes[0] in [outcome.value for outcome in ENDED_WELL]:
            runs.append(result.poses[:, 0, :3])
    return Walled(walls.measure(runs, interval, outline, dish), dish, len(runs))


def wall_torque(turning: Quantity, relaxed: Quantity, inertia_g_mm2: float) -> Quantity:
    """Compute the torque (g mm^2/s^2) that turns a walker at a rate, from its relaxation time."""
    if turning.value is None or turning.se is None or not relaxed.value or relaxed.se is None:
        return Quantity("wall_torque", "g_mm2_s2", None, refused=turning.refused or relaxed.refused)
    value = inertia_g_mm2 * turning.value / relaxed.value
    shares = turning.se / turning.value if turning.value else 0.0, relaxed.se / relaxed.value
    return Quantity("wall_torque", "g_mm2_s2", value, abs(value) * math.hypot(*shares))
