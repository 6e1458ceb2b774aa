"""Effects on a walker: the parameters of those that act, and their total force.

A new effect is a file of its own, its line in `rules`, and three here: field, parameters, `+`.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from walkergen.core.numerics.kernels import kernel, lean
from walkergen.core.simulation.effects import air_drag, noise, rotor, roughness, slope, sway, turning
from walkergen.core.simulation.effects.air_drag import Air
from walkergen.core.simulation.effects.effect import ALONG, GRADIENT, GYROSCOPIC, MOTOR, ROCKING, Case
from walkergen.core.simulation.effects.noise import Noise
from walkergen.core.simulation.effects.rotor import Rotor
from walkergen.core.simulation.effects.roughness import Roughness
from walkergen.core.simulation.effects.slope import Gravity
from walkergen.core.simulation.effects.sway import Sway

_drag = air_drag.force_in_space


class Acting(NamedTuple):
    """Parameters of the effects that act on a walker in motion.

    Those of an effect that is off are neutral: a comparison skips its branch, so that no switch of
    an effect needs machine code of its own.
    """

    gravity: Gravity
    air: Air = air_drag.OFF
    noise: Noise = noise.OFF
    """Noise of one run, which draws it."""
    roughness: Roughness = roughness.OFF
    """Surface of one run, which draws it."""
    sway: Sway = sway.OFF
    """Motion of the plate along itself, and what makes its height differ from place to place."""
    motor: Rotor = rotor.OFF


def acting_parameters(case: Case, on: Callable[[str], bool]) -> Acting:
    """Return the parameters of those effects of a case whose names are `on`."""
    descent = math.radians(case.scene.plate.slope_deg) if on(slope.NAME) else 0.0
    air = air_drag.parameters(case) if on(air_drag.NAME) else air_drag.OFF
    return Acting(
        slope.gravity_of(descent),
        air,
        sway=_sway_parameters(case, on),
        motor=_rotor_parameters(case, on) if on(MOTOR) else rotor.OFF,
    )


def _sway_parameters(case: Case, on: Callable[[str], bool]) -> Sway:
    """Return the sway of a case's plate."""
    if not (on(ALONG) or on(GRADIENT) or on(ROCKING)):
        return sway.OFF
    from walkergen.core.simulation.effects import swaying_plate

    return swaying_plate.parameters(case, on(ALONG), on(GRADIENT), on(ROCKING))


def _rotor_parameters(case: Case, on: Callable[[str], bool]) -> Rotor:
    """Return the rotor of a case with a motor."""
    from walkergen.core.simulation.effects import motor

    turned = motor.parameters(case, on(GYROSCOPIC))
    return turned if on(turning.NAME) else motor.restrict_to_plane(turned)


@kernel
def gravity_along(acting: Acting) -> float:
    """Return the gravity along the plate, toward +x, mm/s^2."""
    return acting.gravity.along


@kernel
def gravity_into(acting: Acting) -> float:
    """Return the gravity into the plate, mm/s^2, positive."""
    return acting.gravity.into


@lean
def force_in_space(acting, velocity):
    """Force of effects on a body moving at `velocity` (body axes, mm/s), in the same axes."""
    return _drag(acting.air, velocity)
