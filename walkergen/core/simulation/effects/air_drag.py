"""Air drag: quadratic, on the faces of the body, which is a box (docs/physics.md section 5).

Each face of area A feels its own normal speed v: C rho A v |v| / 2 against it. S. F. Hoerner,
Fluid-Dynamic Drag (1965): C = 1.2 for a plate broadside above a Reynolds number of 1000.
Limits: no air, no force; a falling plate's speed is v_t tanh(g t / v_t), v_t^2 = 2 M g / (C rho A).
"""

import math
from typing import NamedTuple

from walkergen.core.numerics.kernels import kernel
from walkergen.core.scene import GRAVITY, forced_effect_line
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, apply_switch

NAME, SWITCH = "air drag", "air_drag"

DENSITY = 1.2e-6
"""Density of air at 20 deg C, g/mm^3."""

COEFFICIENT = 1.2
"""Drag coefficient C of a face."""

SMALL_DRAG_RATIO = 0.1
"""Drag over friction below which it is small."""

FAST_SPEED_RATIO = 3.0
"""Speed of a fast walker over the plate's peak speed."""


class Air(NamedTuple):
    """Drag of the body over the square of its speed, C rho A / 2, g/mm."""

    ends: float
    """Drag along the body: on its back or front face."""
    sides: float
    """Drag across the body: on its upper or lower face."""
    flanks: float
    """Drag across the run, in space: on its left or right face."""


OFF = Air(0.0, 0.0, 0.0)
"""No drag."""


def parameters(case: Case) -> Air:
    """Return the drag parameters of the design's body."""
    size, scale = case.design.size, 0.5 * COEFFICIENT * DENSITY
    faces = size.depth * size.thickness, size.depth * size.length
    return Air(*(scale * face for face in (*faces, size.length * size.thickness)))


def decide(case: Case) -> Effect:
    """Return the effect "air drag": on only if forced. Its number is drag over friction, for a fast walker."""
    scene, air = case.scene, parameters(case)
    forced, speed = scene.effects.forced_state(SWITCH), case.equivalent_drive.peak_speed
    friction = max(scene.contact.friction, 1e-3) * float(case.mass.M) * GRAVITY
    number = math.hypot(air.ends * (FAST_SPEED_RATIO * speed) ** 2, air.sides * speed**2) / friction
    reason = "small" if number < SMALL_DRAG_RATIO else f"NOT small: force it with {forced_effect_line(SWITCH, True)}"
    on, reason = apply_switch(forced, False, reason)
    return Effect(NAME, on, number, "drag over friction, for a fast walker", reason, SWITCH)


RULE = Rule(decide, SWITCH, typical_values={f"effects.{SWITCH}": True})


@kernel
def force_in_space(air, velocity):
    """Return the drag, three numbers in g mm/s^2, on a body moving at `velocity` (mm/s), both in body axes."""
    if air.ends == 0.0:
        return 0.0, 0.0, 0.0
    u, v, w = velocity[0], velocity[1], velocity[2]
    return -air.ends * u * abs(u), -air.sides * v * abs(v), -air.flanks * w * abs(w)
