"""Motor: a rotor with an unbalanced mass, which shakes the walker from inside; the plate is still.

The rotor turns at Omega about an axis n of the body; its mass counts in the walker's, at its axis.
The unbalanced mass leads the walker's centre of mass C away from where it would be, by s =
(m_e r/M) (first cos(phase) + second sin(phase)), with second = n x first, in the body's axes. So
the body swings by -s about C, as if pushed by m_e r Omega^2 s/|s| at the rotor's place p; about C
the rotor has the angular momentum p x M s' + h n (docs/physics.md section 8). In space only.

What is left out is of the order of 2 m_e r |p|/J: the change of the inertia within a turn.
Limits: without a moment there is no motor; a free walker draws a circle of radius m_e r/M.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.drive import GRAVITY
from walkergen.errors import InputError
from walkergen.numerics.kernels import lean
from walkergen.simulation.effects.effect import Case, Effect, Rule, forced
from walkergen.walker.mass import from_centre

NAME = "motor"
GYROSCOPIC, SWITCH = "gyroscopic torque", "effects.gyroscopic_torque"

ROTOR_SHARE = 0.5
"""Share of a motor's mass that turns, as a disc of its diameter: of a coin motor about half."""

LEAST_SPIN = 1e-3
"""Inertia of the rotor over the walker's least from which its gyroscopic torque acts."""

LARGEST_THROW = 200.0
"""Largest push of a motor over the walker's weight: coin motors reach some 30."""

Vector = tuple[float, float, float]


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
    place: Vector
    """Middle of the motor from O at half depth, mm."""
    spin: Vector
    """Angular momentum of the rotor about its axis, g mm^2/s; 0 where it is left out."""


OFF = Rotor(0.0, 1.0, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""No motor."""


def judge(case: Case) -> Effect:
    """Effect of the scene's motor. The number is its push over the weight.

    Raises InputError for planar models, walkers that carry no motor, and moments beyond reason.
    """
    drive, meaning = case.scene.drive, "push of the motor over the weight"
    if drive.kind == "plate":
        return Effect(NAME, False, 0.0, meaning, "drive.kind = 'plate'", "")
    design, total = case.design, float(case.mass.total)
    if case.model != "space":
        raise InputError(
            f"drive.kind = 'motor': only the model 'space' knows a motor, not {case.model!r}: "
            "use legs.model = 'space' or 'auto'"
        )
    design.driving_motor()
    reach, length = drive.eccentric / total, design.size.length
    if reach >= length:
        raise InputError(
            f"drive.eccentric_g_mm = {drive.eccentric:.3g}: must lie below the walker's mass times "
            f"its length, {total * length:.3g}; coin motors have about 1"
        )
    number = drive.eccentric * drive.omega**2 / (total * GRAVITY)
    if number > LARGEST_THROW:
        raise InputError(
            f"drive.eccentric_g_mm = {drive.eccentric:.3g} at {drive.frequency:g} Hz: pushes with "
            f"{number:.3g} times the walker's weight; at most {LARGEST_THROW:g}: lower either"
        )
    return Effect(NAME, True, number, meaning, "drive.kind = 'motor'", "")


def gyroscopic(case: Case) -> Effect:
    """Effect of the rotor's angular momentum. The number is its inertia over the walker's least."""
    wanted, meaning = case.scene.effects.gyroscopic_torque, "inertia of the rotor over the walker's"
    if case.scene.drive.kind == "plate" or case.design.motor is None:
        return Effect(GYROSCOPIC, False, 0.0, meaning, "no motor", SWITCH)
    number = _inertia(case) / _least_inertia(case)
    reason = f"{'at least' if number >= LEAST_SPIN else 'below'} {LEAST_SPIN:g}"
    on, reason = forced(wanted, number >= LEAST_SPIN, reason)
    return Effect(GYROSCOPIC, on, number, meaning, reason, SWITCH)


RULE = Rule(judge, planar=False)
SPIN_RULE = Rule(gyroscopic, SWITCH)


def _inertia(case: Case) -> float:
    """Inertia of the rotor about its axis as the walker feels it, g mm^2.

    A part of its unbalanced mass's turns the walker's centre about, not about the axis.
    """
    motor = case.design.driving_motor()
    disc = ROTOR_SHARE * motor.mass_g * motor.diameter_mm**2 / 8.0
    return float(max(disc - case.scene.drive.eccentric**2 / case.mass.total, 0.0))


def _least_inertia(case: Case) -> float:
    """Least principal inertia of the body, g mm^2."""
    if case.mass.spatial is None:
        return float(case.mass.J)
    return float(np.linalg.eigvalsh(case.mass.spatial.body)[0])


def place(case: Case) -> Vector:
    """Middle of the motor from O at half depth, body axes, mm."""
    motor = case.design.driving_motor()
    x, y = from_centre(case.design, case.mass, np.array([motor.along_mm, motor.up_mm]))
    return float(x), float(y), motor.across_mm


def parameters(case: Case, spins: bool) -> Rotor:
    """Rotor of a case; `spins`: with its gyroscopic torque."""
    drive, motor = case.scene.drive, case.design.driving_motor()
    along, across, up = drive.direction(motor.axis)
    n = along, up, across
    first = _across(n)
    h = _inertia(case) * drive.omega if spins else 0.0
    return Rotor(drive.eccentric, drive.omega, first, cross(n, first), place(case), (h * n[0], h * n[1], h * n[2]))


def held(rotor: Rotor) -> Rotor:
    """Rotor as a walker that is held in its plane feels it: what would move it across is gone."""
    first, second, place, spin = rotor.first, rotor.second, rotor.place, rotor.spin
    return rotor._replace(
        first=(first[0], first[1], 0.0),
        second=(second[0], second[1], 0.0),
        place=(place[0], place[1], 0.0),
        spin=(0.0, 0.0, spin[2]),
    )


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _across(n: Vector) -> Vector:
    """Unit vector across a unit vector: upright if it can be, else forward."""
    up = (-n[1] * n[0], 1.0 - n[1] * n[1], -n[1] * n[2])
    ahead = (1.0 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2])
    chosen = up if 1.0 - n[1] * n[1] > 0.25 else ahead
    size = math.hypot(*chosen)
    return chosen[0] / size, chosen[1] / size, chosen[2] / size


@lean
def acts(rotor):
    """True where there is a motor."""
    return rotor.moment > 0.0


@lean
def swing(rotor, mass, phase, swung):
    """Fill s (mm), its rate and its second derivative, body axes, as rows of `swung`."""
    c, s, radius, omega = math.cos(phase), math.sin(phase), rotor.moment / mass, rotor.omega
    for i in range(3):
        ahead = radius * (rotor.first[i] * c + rotor.second[i] * s)
        swung[0, i] = ahead
        swung[1, i] = radius * omega * (rotor.second[i] * c - rotor.first[i] * s)
        swung[2, i] = -omega * omega * ahead


@lean
def moment_of(rotor, centre, mass, x, y, z):
    """Moment about C of a momentum (or force) `mass` (x, y, z) at the rotor's place."""
    p_x, p_y, p_z = (rotor.place[0] + centre[0], rotor.place[1] + centre[1], rotor.place[2] + centre[2])
    return (mass * (p_y * z - p_z * y), mass * (p_z * x - p_x * z), mass * (p_x * y - p_y * x))


@lean
def spin(rotor, centre, mass, swung):
    """Angular momentum about C that the rotor has against the body, body axes, g mm^2/s.

    `centre`: C -> O, mm.
    """
    x, y, z = moment_of(rotor, centre, mass, swung[1, 0], swung[1, 1], swung[1, 2])
    return x + rotor.spin[0], y + rotor.spin[1], z + rotor.spin[2]


@lean
def torque(rotor, centre, mass, swung):
    """Torque of the rotor on the body about C, body axes, g mm^2/s^2."""
    return moment_of(rotor, centre, mass, -swung[2, 0], -swung[2, 1], -swung[2, 2])


@lean
def push(rotor, mass):
    """Largest acceleration of C without its unbalanced mass, mm/s^2; 0 without a motor."""
    return rotor.moment * rotor.omega * rotor.omega / mass


@lean
def _at(rotor, way, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z):
    """Acceleration along d of a point r of a rigid body, from C, by the rotor's push along `way`.

    Over that of C; `inverse` is the inverse inertia of the body.
    """
    t_x, t_y, t_z = moment_of(rotor, centre, mass, way[0], way[1], way[2])
    q_x = inverse[0, 0] * t_x + inverse[0, 1] * t_y + inverse[0, 2] * t_z
    q_y = inverse[1, 0] * t_x + inverse[1, 1] * t_y + inverse[1, 2] * t_z
    q_z = inverse[2, 0] * t_x + inverse[2, 1] * t_y + inverse[2, 2] * t_z
    return (
        (way[0] + q_y * r_z - q_z * r_y) * d_x
        + (way[1] + q_z * r_x - q_x * r_z) * d_y
        + (way[2] + q_x * r_y - q_y * r_x) * d_z
    )


@lean
def strongest(rotor, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z):
    """Largest acceleration (mm/s^2) along the unit vector d of a point r of a body that its rotor
    shakes, body axes from C, mm.
    """
    c = _at(rotor, rotor.first, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z)
    s = _at(rotor, rotor.second, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z)
    return push(rotor, mass) * math.sqrt(c * c + s * s)
