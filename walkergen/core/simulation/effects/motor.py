"""Motor: a rotor with an unbalanced mass, which shakes the walker from inside; the plate is still.

The rotor turns at Omega about an axis n of the body; its mass counts in the walker's, at its axis.
The unbalanced mass leads the walker's centre of mass C away from where it would be, by s =
(m_e r/M) (first cos(phase) + second sin(phase)), with second = n x first, in the body's axes. So
the body swings by -s about C, as if pushed by m_e r Omega^2 s/|s| at the rotor's place p; about C
the rotor has the angular momentum p x M s' + h n (docs/physics.md section 8).

What is left out is of the order of 2 m_e r |p|/J: the change of the inertia within a turn.
Limits: without a moment there is no motor; a free walker draws a circle of radius m_e r/M.
"""

import math

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.simulation.effects.effect import GYROSCOPIC, MOTOR, Case, Effect, Rule, absence_reason, apply_switch
from walkergen.core.simulation.effects.rotor import Rotor, Vector
from walkergen.core.walker.mass import to_centre_frame

NAME, SWITCH = MOTOR, "gyroscopic_torque"

ROTOR_MASS_SHARE = 0.5
"""Share of a motor's mass that turns, as a disc of its diameter: of a coin motor about half."""

MIN_SPIN_RATIO = 1e-3
"""Rotor inertia over the walker's smallest above which its gyroscopic torque acts."""

MAX_PUSH_RATIO = 200.0
"""Largest push of a motor over the walker's weight: coin motors reach some 30."""


def judge(case: Case) -> Effect:
    """Judge the scene's motor. The number is its push over the weight.

    Raises InputError for walkers that carry no motor, and moments beyond reason.
    """
    drive, meaning = case.scene.drive, "push of the motor over the weight"
    if drive.kind == "plate":
        return Effect(NAME, False, 0.0, meaning, "drive.kind = 'plate'", "")
    design, total = case.design, float(case.mass.total)
    design.driving_motor()
    reach, length = drive.eccentric / total, design.size.length
    if reach >= length:
        raise InputError(
            f"drive.eccentric_g_mm = {drive.eccentric:.3g}: must lie below the walker's mass times "
            f"its length, {total * length:.3g}; coin motors have about 1"
        )
    number = drive.push_ratio(total)
    if number > MAX_PUSH_RATIO:
        raise InputError(
            f"drive.eccentric_g_mm = {drive.eccentric:.3g} at {drive.frequency:g} Hz: pushes with "
            f"{number:.3g} times the walker's weight; at most {MAX_PUSH_RATIO:g}: lower either"
        )
    return Effect(NAME, True, number, meaning, "drive.kind = 'motor'", "")


def judge_gyroscopic(case: Case) -> Effect:
    """Judge the rotor's angular momentum. The number is its inertia over the walker's smallest."""
    wanted, meaning = case.scene.effects.forced_state(SWITCH), "inertia of the rotor over the walker's"
    if case.scene.drive.kind == "plate" or case.design.motor is None:
        why = absence_reason(case, SWITCH, "there is no motor: set drive.kind = 'motor' and give the design one")
        return Effect(GYROSCOPIC, False, 0.0, meaning, why.partition(":")[0], "")
    number = _rotor_inertia(case) / _least_inertia(case)
    reason = f"{'at least' if number >= MIN_SPIN_RATIO else 'below'} {MIN_SPIN_RATIO:g}"
    on, reason = apply_switch(wanted, number >= MIN_SPIN_RATIO, reason)
    return Effect(GYROSCOPIC, on, number, meaning, reason, SWITCH)


RULE = Rule(judge)
SPIN_RULE = Rule(judge_gyroscopic, SWITCH, usual={f"effects.{SWITCH}": True})


def _rotor_inertia(case: Case) -> float:
    """Return the effective inertia of the rotor about its axis, g mm^2.

    A part of its unbalanced mass's turns the walker's centre about, not about the axis.
    """
    motor = case.design.driving_motor()
    disc = ROTOR_MASS_SHARE * motor.mass_g * motor.diameter_mm**2 / 8.0
    return float(max(disc - case.scene.drive.eccentric**2 / case.mass.total, 0.0))


def _least_inertia(case: Case) -> float:
    """Return the smallest principal inertia of the body, g mm^2."""
    if case.mass.spatial is None:
        return float(case.mass.J)
    return float(np.linalg.eigvalsh(case.mass.spatial.body)[0])


def motor_position(case: Case) -> Vector:
    """Return the middle of the motor from O at half depth, body axes, mm."""
    motor = case.design.driving_motor()
    x, y = to_centre_frame(case.design.limbs, case.mass, np.array([motor.along_mm, motor.up_mm]))
    return float(x), float(y), motor.across_mm


def parameters(case: Case, spins: bool) -> Rotor:
    """Return the rotor of a case; `spins`: with its gyroscopic torque."""
    drive, motor = case.scene.drive, case.design.driving_motor()
    along, across, up = drive.axis_vector(motor.axis)
    n = along, up, across
    first = _perpendicular(n)
    h = _rotor_inertia(case) * drive.omega if spins else 0.0
    return Rotor(
        drive.eccentric,
        drive.omega,
        first,
        cross_product(n, first),
        motor_position(case),
        (h * n[0], h * n[1], h * n[2]),
    )


def restrict_to_plane(rotor: Rotor) -> Rotor:
    """Return the rotor of a walker held in its plane, without components across the plane."""
    first, second, place, spin = rotor.first, rotor.second, rotor.place, rotor.spin
    return rotor._replace(
        first=(first[0], first[1], 0.0),
        second=(second[0], second[1], 0.0),
        place=(place[0], place[1], 0.0),
        spin=(0.0, 0.0, spin[2]),
    )


def cross_product(a: Vector, b: Vector) -> Vector:
    """Compute the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _perpendicular(n: Vector) -> Vector:
    """Return a unit vector across a unit vector: upright if possible, otherwise forward."""
    up = (-n[1] * n[0], 1.0 - n[1] * n[1], -n[1] * n[2])
    ahead = (1.0 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2])
    chosen = up if 1.0 - n[1] * n[1] > 0.25 else ahead
    size = math.hypot(*chosen)
    return chosen[0] / size, chosen[1] / size, chosen[2] / size
