"""Air drag: quadratic, on the faces of the body, which is a box.

Each face of area A feels its own normal speed v: C rho A v |v| / 2 against it, along the body's
axes. S. F. Hoerner, Fluid-Dynamic Drag (1965): C = 1.2 for a plate broadside at Reynolds numbers
above 1000. A walker's are some tens, where C is about twice that; turning and the legs add no drag.
Limits: no air, no force; a falling plate's speed is v_t tanh(g t / v_t), v_t^2 = 2 M g / (C rho A).
"""

import math
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.numerics.kernels import kernel
from walkergen.scene import GRAVITY
from walkergen.simulation.effects.effect import Case, Effect, forced

NAME, SWITCH = "air drag", "effects.air_drag"

DENSITY = 1.2e-6
"""Density of air at 20 deg C, g/mm^3."""

COEFFICIENT = 1.2
"""Drag coefficient of a face."""

FASTEST = 3.0
"""Speed of a fast walker, over the plate's peak speed."""


class Air(NamedTuple):
    """Drag over the square of the speed, g/mm."""

    ends: float
    """Of the faces at the body's back and front."""
    sides: float
    """Of the faces above and below the body."""


def parameters(case: Case) -> Air:
    """Drag of the design's body."""
    body, scale = case.design.body, 0.5 * COEFFICIENT * DENSITY
    return Air(scale * body.depth_mm * body.thickness_mm, scale * body.depth_mm * body.length_mm)


def verdict(case: Case) -> Effect:
    """Off unless forced: the number says how small it is.

    Raises InputError for the relaxed model, whose flights are exact only without drag.
    """
    scene, air = case.scene, parameters(case)
    wanted, speed = scene.effects.air_drag, scene.drive.peak_speed
    if wanted and case.model == "relaxed":
        raise InputError(
            f"{SWITCH} = true: the relaxed model's flights are exact only without drag; "
            "use legs.model 'compliant' or 'rigid'"
        )
    friction = max(scene.contact.friction, 1e-3) * float(case.mass.M) * GRAVITY
    number = math.hypot(air.ends * (FASTEST * speed) ** 2, air.sides * speed**2) / friction
    small = number < scene.run.accepted_error
    reason = "small" if small else f"NOT small: force it with {SWITCH} = true"
    on, reason = forced(wanted, False, reason)
    return Effect(NAME, on, number, "drag over friction, for a fast walker", reason, SWITCH)


@kernel
def force(air, pitch, v_x, v_y):
    """Force (x, y) on a body that moves at (v_x, v_y) mm/s, g mm/s^2."""
    if air is None:
        return 0.0, 0.0
    cos, sin = math.cos(pitch), math.sin(pitch)
    u, w = cos * v_x + sin * v_y, cos * v_y - sin * v_x
    f, n = -air.ends * u * abs(u), -air.sides * w * abs(w)
    return cos * f - sin * n, sin * f + cos * n
