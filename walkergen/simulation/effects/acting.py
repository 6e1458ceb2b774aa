"""Effects on a walker: their verdicts, the parameters of those that act, their total force.

A new effect is a file of its own and four lines here: verdict, field, parameters, `+`.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.simulation.effects import (
    air_drag,
    compliance,
    harmonic,
    local_contact,
    noise,
    parts,
    roughness,
    slope,
    tensor,
    turning,
    twist,
    unevenness,
    walls,
)
from walkergen.simulation.effects.air_drag import Air
from walkergen.simulation.effects.effect import Case, Effect
from walkergen.simulation.effects.noise import Noise
from walkergen.simulation.effects.roughness import Roughness
from walkergen.simulation.effects.slope import Gravity

VERDICTS: tuple[Callable[[Case], Effect], ...] = (
    tensor.verdict,
    compliance.verdict,
    parts.sticking,
    parts.sustained,
    parts.pitch,
    harmonic.verdict,
    slope.verdict,
    turning.verdict,
    twist.verdict,
    walls.verdict,
    local_contact.verdict,
    unevenness.verdict,
    noise.verdict,
    roughness.verdict,
    parts.neighbours,
    air_drag.verdict,
)
"""Functions that judge each effect, in the order in which `explain` shows them."""

_along, _drag, _drag_in_space = slope.along, air_drag.force, air_drag.force_in_space


class Acting(NamedTuple):
    """Parameters of the effects that act on a walker in motion; None: the effect is off."""

    gravity: Gravity
    air: Air | None = None
    noise: Noise | None = None
    """Noise of one run, which draws it."""
    roughness: Roughness | None = None
    """Surface of one run, which draws it."""


def acting(case: Case, on: Callable[[str], bool]) -> Acting:
    """Parameters of those effects of a case whose names are `on`."""
    descent = math.radians(case.scene.plate.slope_deg) if on(slope.NAME) else None
    return Acting(
        slope.gravity_of(descent), air_drag.parameters(case) if on(air_drag.NAME) else None
    )


@kernel
def along(acting: Acting) -> float:
    """Gravity along the plate, toward +x, mm/s^2."""
    return _along(acting.gravity.along)


@kernel
def across(acting: Acting) -> float:
    """Gravity into the plate, mm/s^2, positive."""
    return acting.gravity.into


@kernel
def body_force(acting, pitch, v_x, v_y):
    """Force (x, y) of effects on a body at (v_x, v_y) mm/s, without its weight, g mm/s^2."""
    return _drag(acting.air, pitch, v_x, v_y)


@kernel
def force_in_space(acting, velocity):
    """Force of effects on a body moving at `velocity` (body axes, mm/s), in the same axes."""
    return _drag_in_space(acting.air, velocity)
