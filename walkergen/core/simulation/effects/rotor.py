"""Rotor of a motor as kernels know it: how its unbalanced mass swings the walker's centre of mass.

Equations: `motor`, which decides whether a scene has one; a scene without imports this alone.
"""

import math
from typing import NamedTuple

from walkergen.core.numerics.kernels import lean

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
    """Angular momentum of the rotor about its axis, g mm^2/s; 0 if it is left out."""


OFF = Rotor(0.0, 1.0, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""No motor."""


@lean
def acts(rotor):
    """Return whether there is a motor."""
    return rotor.moment > 0.0


@lean
def swing(rotor, mass, phase, swung):
    """Fill s (mm), its rate and its second derivative, body axes, as rows of `swung`."""
    c, s, radius, omega = math.cos(phase), math.sin(phase), rotor.moment / mass, rotor.omega
    # Eq. 8.1: s = (S/M) e
    for i in range(3):
        ahead = radius * (rotor.first[i] * c + rotor.second[i] * s)
        swung[0, i] = ahead
        swung[1, i] = radius * omega * (rotor.second[i] * c - rotor.first[i] * s)
        swung[2, i] = -omega * omega * ahead


@lean
def moment_of(rotor, centre, mass, x, y, z):
    """Return the moment about C of a momentum (or force) `mass` (x, y, z) at the rotor's place."""
    p_x, p_y, p_z = (rotor.place[0] + centre[0], rotor.place[1] + centre[1], rotor.place[2] + centre[2])
    return (mass * (p_y * z - p_z * y), mass * (p_z * x - p_x * z), mass * (p_x * y - p_y * x))


@lean
def spin(rotor, centre, mass, swung):
    """Return the rotor's angular momentum about C relative to the body, body axes, g mm^2/s.

    `centre`: C -> O, mm.
    """
    # p x M s' + h n of eq. 8.2
    x, y, z = moment_of(rotor, centre, mass, swung[1, 0], swung[1, 1], swung[1, 2])
    return x + rotor.spin[0], y + rotor.spin[1], z + rotor.spin[2]


@lean
def torque(rotor, centre, mass, swung):
    """Return the torque of the rotor on the body about C, body axes, g mm^2/s^2."""
    # p x S Omega^2 e of eq. 8.2, for s'' = -Omega^2 s
    return moment_of(rotor, centre, mass, -swung[2, 0], -swung[2, 1], -swung[2, 2])


@lean
def push(rotor, mass):
    """Return the largest acceleration of C without the rotor's unbalanced mass, mm/s^2; 0 without a motor."""
    return rotor.moment * rotor.omega * rotor.omega / mass


@lean
def _push_acceleration(rotor, way, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z):
    """Return the acceleration along d of a rigid body's point r, from C, caused by the rotor's push along `way`.

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
    """Compute the largest acceleration (mm/s^2) along unit vector d of point r of a body that its rotor shakes.

    Both are in body axes, from C, mm.
    """
    c = _push_acceleration(rotor, rotor.first, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z)
    s = _push_acceleration(rotor, rotor.second, centre, mass, inverse, r_x, r_y, r_z, d_x, d_y, d_z)
    return push(rotor, mass) * math.sqrt(c * c + s * s)
