"""Card of a walker from its measured motion, its design and its scene."""

import numpy as np

from walkergen.crowd.card import Card, Known
from walkergen.crowd.cards import overdamped, walker_motion
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.errors import InputError
from walkergen.numerics.quantity import Quantity
from walkergen.scene import Scene
from walkergen.walker import seen_above
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties


def of(scene: Scene, design: Design, mass: MassProperties, numbers: Measured) -> Card:
    """Card of a walker whose motion was measured.

    Raises InputError where one of the numbers that every card has is not known.
    """
    found = numbers.motion.estimates
    speed = _needed("speed", found["speed"], numbers.runs)
    turning = _needed("mean turning", found["turning_bias"], numbers.runs)
    rotation = _needed("rotational diffusion", found["rotational_diffusion"], numbers.runs)
    away = walker_motion.centre(mass)
    outline = [contour - away for contour in seen_above.outline_of(design, mass)]
    length = float(np.ptp(np.concatenate(outline)[:, 0]))
    return Card(
        name=design.name,
        scene=scene.name,
        mass_g=float(mass.total),
        inertia_g_mm2=walker_motion.inertia(mass),
        outline_mm=[[[float(x), float(y)] for x, y in contour] for contour in outline],
        speed_mm_s=speed,
        velocity_relaxation_s=_needed("relaxation", numbers.velocity.time, numbers.runs),
        turning_rad_s=turning,
        turning_sd_rad_s=known(found["turning_scatter"], numbers.runs),
        turning_relaxation_s=known(numbers.turning.time, numbers.runs),
        rotational_diffusion_rad2_s=rotation,
        translational_diffusion_mm2_s=_needed("translational diffusion", numbers.translation, numbers.runs),
        delay_s=known(numbers.delay.mean, numbers.runs),
        sideways_mm_s=known(found["sideways_speed"], numbers.runs),
        restitution=scene.crowd.restitution,
        friction=scene.crowd.friction,
        wall_restitution=scene.arena.wall_restitution,
        wall_friction=scene.arena.wall_friction,
        overdamped=overdamped.judge(speed, turning, rotation, numbers.velocity, length),
    )


def _needed(what: str, estimate: Quantity, runs: int) -> Known:
    """Number of a card. Raises InputError where it is not known, with the reason."""
    if (number := known(estimate, runs)) is None:
        raise InputError(f"the {what} is not known: {estimate.refused}; --runs 16, or more tracks")
    return number


def known(estimate: Quantity, runs: int) -> Known | None:
    """Number of a card; None where it is not known."""
    if estimate.value is None:
        return None
    se = None if estimate.se is None else float(estimate.se)
    return Known(value=float(estimate.value), se=se, runs=runs)
