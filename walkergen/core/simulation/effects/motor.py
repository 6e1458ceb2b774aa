"""Motor: a rotor with an unbalanced mass, which shakes the walker from inside; the plate is still.

The rotor turns at Omega about an axis n of the body; its mass counts in the walker's, at its axis. The unbalanced mass
leads the walker's centre of mass C away from where it would be, by s = (m_e r/M) (first cos(phase) + second
sin(phase)), with second = n x first, in the body's axes. So the body swings by -s about C, as if pushed by m_e r
Omega^2 s/|s| at the rotor's place p; about C the rotor has the angular momentum p x M s' + h n (docs/physics.md section
8).

What is left out is of the order of 2 m_e r |p|/J: the change of the inertia within a turn. Limits: without a moment
there is no motor; a free walker draws a circle of radius m_e r/M. O is the body's centre of mass, at half depth.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, absence_reason, apply_switch
from walkergen.core.walker.mass import to_centre_frame

NAME, GYROSCOPIC, SWITCH = "motor", "gyroscopic torque", "gyroscopic_torque"

Vector = tuple[float, float, float]

ROTOR_MASS_SHARE = 0.5
"""Share of a motor's mass that turns, as a disc of its diameter: of a coin motor about half."""

MIN_SPIN_RATIO = 1e-3
"""Rotor inertia over the walker's smallest above which its gyroscopic torque acts."""

MAX_PUSH_RATIO = 200.0
"""Largest push of a motor over the walker's weight: coin motors reach some 30."""


class Rotor(NamedTuple):
    """An unbalanced rotor; vectors in the axes of `space.state` (x forward, y up, z right)."""

    moment: float
    """Eccentric moment m_e r, g mm; 0: no motor."""
    omega: float
    """Rate of its turning, rad/s, > 0."""
    first: Vector
    """Unit vector to the unbalanced mass at phase 0, body axes."""
    second: Vector
    """The same a quarter turn later."""
    position: Vector
    """Middle of the motor from O at half depth, mm."""
    spin: Vector
    """Angular momentum of the rotor about its axis, g mm^2/s; 0 if it is left out."""


OFF = Rotor(0.0, 1.0, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""No motor."""


def decide(case: Case) -> Effect:
    """Return the effect "motor": on if a motor drives the walker. Its number is the push over the walker's weight.

    Raises InputError for a walker without a motor, and for an eccentric moment that is too large.
    """
    drive, meaning = case.scene.drive, "push of the motor over the weight"
    if drive.kind == "plate":
        return Effect(NAME, False, 0.0, meaning, "drive.kind = 'plate'", "")
    design, total = case.design, float(case.mass.total)
    design.driving_motor()
    swing_radius, length = drive.eccentric_moment / total, design.size.length
    if swing_radius >= length:
        raise InputError(
            f"drive.eccentric_g_mm = {drive.eccentric_moment:.3g}: must lie below the walker's mass times "
            f"its length, {total * length:.3g}; coin motors have about 1"
        )
    number = drive.push_ratio(total)
    if number > MAX_PUSH_RATIO:
        raise InputError(
            f"drive.eccentric_g_mm = {drive.eccentric_moment:.3g} at {drive.frequency:g} Hz: pushes with "
            f"{number:.3g} times the walker's weight. At most {MAX_PUSH_RATIO:g} is allowed. Lower one of them"
        )
    return Effect(NAME, True, number, meaning, "drive.kind = 'motor'", "")


def decide_gyroscopic(case: Case) -> Effect:
    """Return the effect "gyroscopic torque" of a motor. Its number is the rotor's inertia over the body's smallest."""
    forced, meaning = case.scene.effects.forced_state(SWITCH), "inertia of the rotor over the walker's"
    if case.scene.drive.kind == "plate" or case.design.motor is None:
        why = absence_reason(case, SWITCH, "there is no motor: set drive.kind = 'motor' and give the design one")
        return Effect(GYROSCOPIC, False, 0.0, meaning, why.partition(":")[0], "")
    number = _rotor_inertia(case) / _least_inertia(case)
    reason = f"{'at least' if number >= MIN_SPIN_RATIO else 'below'} {MIN_SPIN_RATIO:g}"
    on, reason = apply_switch(forced, number >= MIN_SPIN_RATIO, reason)
    return Effect(GYROSCOPIC, on, number, meaning, reason, SWITCH)


RULES = (Rule(decide), Rule(decide_gyroscopic, SWITCH, typical_values={f"effects.{SWITCH}": True}))


def _rotor_inertia(case: Case) -> float:
    """Return the effective inertia of the rotor about its axis, g mm^2: that of a disc, less (m r)^2 over the mass.

    The moment m r of the unbalanced mass moves the centre of mass of the whole walker, which has its own equation.
    """
    motor = case.design.driving_motor()
    disc = ROTOR_MASS_SHARE * motor.mass_g * motor.diameter_mm**2 / 8.0
    return float(max(disc - case.scene.drive.eccentric_moment**2 / case.mass.total, 0.0))


def _least_inertia(case: Case) -> float:
    """Return the smallest principal inertia of the body, g mm^2; its planar J without mass properties in space."""
    if case.mass.spatial is None:
        return float(case.mass.J)
    return float(np.linalg.eigvalsh(case.mass.spatial.body)[0])


def motor_position(case: Case) -> Vector:
    """Return the middle of the motor (along, up, across) from O, the body's centre of mass, mm."""
    motor = case.design.driving_motor()
    x, y = to_centre_frame(case.design.limbs, case.mass, np.array([motor.along_mm, motor.up_mm]))
    return float(x), float(y), motor.across_mm


def parameters(case: Case, with_gyroscopic_torque: bool, can_turn: bool) -> Rotor:
    """Return the rotor of the walker's motor. `can_turn` is False for a walker that is held in its plane."""
    drive, motor = case.scene.drive, case.design.driving_motor()
    along, across, up = drive.axis_vector(motor.axis)
    n = along, up, across
    first = _perpendicular(n)
    x, y, z = np.cross(n, first).tolist()
    h = _rotor_inertia(case) * drive.omega if with_gyroscopic_torque else 0.0
    spin = (h * n[0], h * n[1], h * n[2])
    rotor = Rotor(drive.eccentric_moment, drive.omega, first, (x, y, z), motor_position(case), spin)
    return rotor if can_turn else _restrict_to_plane(rotor)


def _restrict_to_plane(rotor: Rotor) -> Rotor:
    """Return the rotor of a walker that is held in its plane: without vectors' components across the plane."""
    (f_x, f_y, _), (s_x, s_y, _), (x, y, _) = rotor.first, rotor.second, rotor.position
    return rotor._replace(
        first=(f_x, f_y, 0.0), second=(s_x, s_y, 0.0), position=(x, y, 0.0), spin=(0.0, 0.0, rotor.spin[2])
    )


def _perpendicular(n: Vector) -> Vector:
    """Return a unit vector perpendicular to the unit vector n: upright if possible, otherwise forward."""
    up = (-n[1] * n[0], 1.0 - n[1] * n[1], -n[1] * n[2])
    ahead = (1.0 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2])
    chosen = up if 1.0 - n[1] * n[1] > 0.25 else ahead  # n more than 30 deg from upright
    size = math.hypot(*chosen)
    return chosen[0] / size, chosen[1] / size, chosen[2] / size


@lean
def acts(rotor):
    """Return whether there is a motor."""
    return rotor.moment > 0.0


@lean
def fill_swing(rotor, mass, phase, swung):
    """Fill the rows of `swung`, (3, 3), with the body's swing s (mm) by a motor, s' and s''. `mass`: walker's, g."""
    c, s, radius, omega = math.cos(phase), math.sin(phase), rotor.moment / mass, rotor.omega
    # Eq. 8.1: s = (S/M) e
    for i in range(3):
        ahead = radius * (rotor.first[i] * c + rotor.second[i] * s)
        swung[0, i] = ahead
        swung[1, i] = radius * omega * (rotor.second[i] * c - rotor.first[i] * s)
        swung[2, i] = -omega * omega * ahead


@lean
def moment_of(rotor, centre, mass, x, y, z):
    """Return the moment, about the walker's centre of mass, of a force or momentum `mass` (x, y, z) at the rotor."""
    p_x, p_y, p_z = (rotor.position[0] + centre[0], rotor.position[1] + centre[1], rotor.position[2] + centre[2])
    return (mass * (p_y * z - p_z * y), mass * (p_z * x - p_x * z), mass * (p_x * y - p_y * x))


@lean
def spin(rotor, centre, mass, swung):
    """Return the rotor's angular momentum relative to the body, about C, body axes, g mm^2/s.

    C is the walker's centre of mass, `centre` the vector from C to that of the body, mm. `swung`: from `fill_swing`.
    """
    # p x M s' + h n of eq. 8.2
    x, y, z = moment_of(rotor, centre, mass, swung[1, 0], swung[1, 1], swung[1, 2])
    return x + rotor.spin[0], y + rotor.spin[1], z + rotor.spin[2]


@lean
def torque(rotor, centre, mass, swung):
    """Return the rotor's torque on the body about the walker's centre of mass, body axes, g mm^2/s^2. See `spin`."""
    # p x S Omega^2 e of eq. 8.2, for s'' = -Omega^2 s
    return moment_of(rotor, centre, mass, -swung[2, 0], -swung[2, 1], -swung[2, 2])


@lean
def centrifugal_acceleration(rotor, mass):
    """Return the centrifugal force of the rotor over the `mass` (g) of the walker, mm/s^2; 0 without a motor."""
    return rotor.moment * rotor.omega * rotor.omega / mass


@lean
def _push_acceleration(rotor, direction, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z):
    """Return the acceleration along d of the body's point r that the rotor's push along `direction` causes.

    It is relative to the acceleration of C, the walker's centre of mass. Arguments: see `largest_acceleration`.
    """
    t_x, t_y, t_z = moment_of(rotor, centre, mass, direction[0], direction[1], direction[2])
    q_x = inverse[0, 0] * t_x + inverse[0, 1] * t_y + inverse[0, 2] * t_z
    q_y = inverse[1, 0] * t_x + inverse[1, 1] * t_y + inverse[1, 2] * t_z
    q_z = inverse[2, 0] * t_x + inverse[2, 1] * t_y + inverse[2, 2] * t_z
    return (
        (direction[0] + q_y * r_z - q_z * r_y) * d_x
        + (direction[1] + q_z * r_x - q_x * r_z) * d_y
        + (direction[2] + q_x * r_y - q_y * r_x) * d_z
    )


@lean
def largest_acceleration(rotor, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z):
    """Compute the largest acceleration (mm/s^2) along a unit vector d of the body's point r that the rotor causes.

    Arguments, in body axes: `centre`, vector from the walker's centre of mass C to that of the body, mm; `mass`, g, and
    `inverse` inertia of the walker; r from C, mm; d.
    """
    c = _push_acceleration(rotor, rotor.first, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z)
    s = _push_acceleration(rotor, rotor.second, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z)
    return centrifugal_acceleration(rotor, mass) * math.sqrt(c * c + s * s)
