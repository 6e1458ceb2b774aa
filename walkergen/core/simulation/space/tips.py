"""Contact of a foot's tip: a Hertzian tip in series with the corner of its leg (docs/physics.md section 7).

At the depth d of the whole contact the tip is pressed by delta, and F = K delta^(3/2) = k (d - delta). With
x = sqrt(delta): x^2 (1 + K x / k) = d. A rigid tip (K infinite) leaves the leg's spring alone, F = k d. In the code
`spring` is k, the axial stiffness of the leg's corner (g/s^2), and `tip` is K (g/(mm^0.5 s^2)).

The damper is c = 2 zeta F sqrt(m / (2 U)), U the elastic energy. For any spring the impact of a mass m is then that
of a linear oscillator of damping ratio zeta: with q = sqrt(2 U) and p = sqrt(m) u, d tau = F / (q sqrt(m)) dt turns
m u' = F - c u into q'' + 2 zeta q' + q = 0. So the restitution is the same at every speed. For the Hertzian tip alone
this is Tsuji's damper (Tsuji, Tanaka and Ishida, Powder Technology 71, 1992, 239).

Along the surface a spring has a Coulomb slider: its stretch e follows the slip u while |e| < R = mu f_n / k_t. On that
circle it is dragged along, and its direction n = e / R obeys n' = (u - (u.n) n) / R. Where u and R are constant, the
tangent of half the angle between n and u then falls as exp(-|u| t / R).
"""

import math

from walkergen.core.numerics.kernels import lean

ROOT_TOLERANCE = 1e-7
"""Relative change of the root of the tip's depth after which Newton's method, of second order, is exact to rounding."""

MAX_WAY_RADII = 20.0
"""Way, in radii of the circle, after which a stretch points along the slip: to 1e-8, across the circle first."""


@lean
def _root_of_tip_depth(spring, tip, depth):
    """Return the square root of the tip's own depth, mm^0.5, for a depth of the whole contact (mm)."""
    ratio, x = tip / spring, math.sqrt(depth)
    x *= 2.0 / (2.0 + ratio * x)  # for a leg much stiffer than its tip
    while True:  # eq. 7.7, convex and increasing: after its first step Newton's method descends to the root
        stretched = ratio * x
        change = (x * x * (1.0 + stretched) - depth) / (x * (2.0 + 3.0 * stretched))
        x -= change
        if not abs(change) > ROOT_TOLERANCE * x:
            return x


@lean
def response(spring, tip, depth):
    """Return force F (g mm/s^2), stiffness dF/dd, and F^2 / (2 U), for the damping (g/s^2), at a depth d > 0 (mm)."""
    if tip == math.inf:
        return spring * depth, spring, spring
    x = _root_of_tip_depth(spring, tip, depth)
    soft, leg = 1.0 / (tip * x), 1.0 / spring  # delta / F, and the leg's share
    # F = K delta^(3/2); eq. 7.9; 2 U / F^2 of tip and leg in series
    return tip * x * x * x, 1.0 / (leg + soft * (2.0 / 3.0)), 1.0 / (leg + 0.8 * soft)


@lean
def elastic_energy(spring, tip, depth):
    """Compute the elastic energy of a contact at a depth (mm), g mm^2/s^2; 0 for an open contact."""
    if not depth > 0.0:
        return 0.0
    if tip == math.inf:
        return 0.5 * spring * depth * depth
    x = _root_of_tip_depth(spring, tip, depth)
    force = tip * x * x * x
    # U = F^2 / (2 k) + 2/5 F delta
    return 0.5 * force * force / spring + 0.4 * force * x * x


@lean
def stretch_directions(e_1, e_2, u_1, u_2, t, radius):
    """Return the unit directions of a tangential spring's stretch after t and after 2 t seconds: four components.

    The stretch is (e_1, e_2), mm, at the start, and the slip (u_1, u_2), mm/s, both along the two tangents of the
    surface. `radius` (mm) is that of the friction circle, mu f_n / k_t. Inside the circle the stretch follows the
    slip. On the circle the slider drags the stretch along. The result is exact for constant slip and radius, and
    (0, 0) if neither slip nor stretch has a direction.
    """
    speed = math.sqrt(u_1 * u_1 + u_2 * u_2)
    way = t * speed
    if way > MAX_WAY_RADII * radius:
        inverse = 1.0 / speed
        return u_1 * inverse, u_2 * inverse, u_1 * inverse, u_2 * inverse
    size = math.sqrt(e_1 * e_1 + e_2 * e_2)
    if not way > 0.0:
        inverse = 1.0 / size if size > 0.0 else 0.0
        return e_1 * inverse, e_2 * inverse, e_1 * inverse, e_2 * inverse
    a_1, a_2 = u_1 / speed, u_2 / speed
    along = e_1 * a_1 + e_2 * a_2
    side_1, side_2 = e_1 - along * a_1, e_2 - along * a_2
    room = radius * radius - (side_1 * side_1 + side_2 * side_2)
    exit = math.sqrt(room) if room > 0.0 else -math.inf
    if exit > along:  # through the circle, to its edge
        n_1, n_2 = _direction_after_slip(a_1, a_2, side_1, side_2, along, exit, way, radius)
        m_1, m_2 = _direction_after_slip(a_1, a_2, side_1, side_2, along, exit, 2.0 * way, radius)
        return n_1, n_2, m_1, m_2
    if not size > 0.0:
        return a_1, a_2, a_1, a_2
    # Eq. 7.10, integrated: the tangent of half the angle to the slip falls as exp(-|u| t / R)
    shrunk = math.exp(-way / radius) if radius > 0.0 else 0.0
    n_1, n_2 = _direction_toward_slip(a_1, a_2, side_1, side_2, size + along, size - along, shrunk)
    m_1, m_2 = _direction_toward_slip(a_1, a_2, side_1, side_2, size + along, size - along, shrunk * shrunk)
    return n_1, n_2, m_1, m_2


@lean
def _direction_after_slip(a_1, a_2, side_1, side_2, along, exit, way, radius):
    """Return the unit direction of a tangential spring's stretch after a slip that starts inside the friction circle.

    The stretch (mm) follows the slip up to the edge of the friction circle. From there the slider drags the stretch
    along the circle (eq. 7.10).

    Arguments: (a_1, a_2), unit direction of the slip along the two tangents; (side_1, side_2), part of the initial
    stretch across the slip, mm, which the slip does not change; `along`, part of the initial stretch along the slip,
    mm; `exit`, value of `along` at which the stretch reaches the circle, mm; `way`, length of the slip, mm; `radius`
    of the friction circle, mu f_n / k_t, mm.
    """
    if along + way < exit:
        x_1, x_2 = side_1 + (along + way) * a_1, side_2 + (along + way) * a_2
        size = math.sqrt(x_1 * x_1 + x_2 * x_2)
        inverse = 1.0 / size if size > 0.0 else 0.0
        return x_1 * inverse, x_2 * inverse
    shrunk = math.exp((exit - along - way) / radius)
    return _direction_toward_slip(a_1, a_2, side_1, side_2, radius + exit, radius - exit, shrunk)


@lean
def _direction_toward_slip(a_1, a_2, side_1, side_2, ahead, behind, tangent_ratio):
    """Return the unit direction of a stretch that the slider has dragged along the friction circle (eq. 7.10).

    Arguments: (a_1, a_2), unit direction of the slip; (side_1, side_2), part of the initial stretch across the slip,
    mm; `ahead` and `behind`, length of the initial stretch plus and minus its part along the slip, mm; `tangent_ratio`,
    factor by which the tangent of half the angle between stretch and slip has fallen.
    """
    behind *= tangent_ratio * tangent_ratio
    total = ahead + behind
    if not total > 0.0:
        return -a_1, -a_2
    inverse = 1.0 / total
    across, forward = 2.0 * tangent_ratio * inverse, (ahead - behind) * inverse
    return forward * a_1 + across * side_1, forward * a_2 + across * side_2
