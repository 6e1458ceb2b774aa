"""Contact of a foot's tip: a Hertzian tip in series with the corner of its leg (docs/physics.md section 7).

At the depth d of the whole contact the tip is pressed by delta, and F = K delta^(3/2) = k (d - delta). With
x = sqrt(delta): x^2 (1 + K x / k) = d. A rigid tip (K infinite) leaves the leg's spring alone, F = k d.

The damper is c = 2 zeta F sqrt(m / (2 U)), U the elastic energy. For any spring the impact of a mass m is then that
of a linear oscillator of damping ratio zeta: with q = sqrt(2 U) and p = sqrt(m) u, d tau = F / (q sqrt(m)) dt turns
m u' = F - c u into q'' + 2 zeta q' + q = 0. So the restitution is the same at every speed. For the Hertzian tip alone
this is Tsuji's damper (Tsuji, Tanaka and Ishida, Powder Technology 71, 1992, 239).
"""

import math

from walkergen.core.numerics.kernels import lean

ROOT_TOLERANCE = 1e-7
"""Relative change of the root of the tip's depth after which Newton's method, of second order, is exact to rounding."""


@lean
def _root_of_tip_depth(spring, tip, depth):
    """Return the root of the depth of the tip, mm^0.5, for a depth of the whole contact (mm)."""
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
    """Force (g mm/s^2), tangent stiffness dF/dd and damping stiffness F^2 / (2 U) (g/s^2) at a depth > 0 (mm)."""
    if tip == math.inf:
        return spring * depth, spring, spring
    x = _root_of_tip_depth(spring, tip, depth)
    soft, leg = 1.0 / (tip * x), 1.0 / spring  # delta / F, and the leg's share
    # F = K delta^(3/2); eq. 7.9; 2 U / F^2 of tip and leg in series
    return tip * x * x * x, 1.0 / (leg + soft * (2.0 / 3.0)), 1.0 / (leg + 0.8 * soft)


@lean
def elastic_energy(spring, tip, depth):
    """Compute the elastic energy of a contact at a depth, g mm^2/s^2; 0 for an open one."""
    if not depth > 0.0:
        return 0.0
    if tip == math.inf:
        return 0.5 * spring * depth * depth
    x = _root_of_tip_depth(spring, tip, depth)
    force = tip * x * x * x
    # U = F^2 / (2 k) + 2/5 F delta
    return 0.5 * force * force / spring + 0.4 * force * x * x
