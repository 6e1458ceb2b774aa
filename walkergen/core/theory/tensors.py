"""Inverse-mass tensors at a foot: dv_foot = H F (docs/physics.md section 2; paper eqs 4 and 12).

I is the unit matrix, perp(x, y) = (-y, x), and P(d) = perp(d) perp(d)^T. Symmetric 2x2 tensors are kept as their three
entries, each an array of any common shape, so that a call serves one foot or a million draws.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.walker.mass import MassProperties, Values

Array = npt.NDArray[np.float64]


class InverseMass(NamedTuple):
    """Entries of a symmetric inverse-mass tensor in 1/g; x along the plate, y up."""

    xx: Values
    xy: Values
    yy: Values


def _effective_mass(mass: Values, inertia: Values, lever: Array) -> InverseMass:
    """Return the effective-mass tensor at a point of a free rigid body: (I/mass + P(lever)/inertia)^-1, in g.

    Mass in g, inertia about the centre in g mm^2, shape (...); `lever`: centre -> point, mm, shape (..., 2).
    """
    x, y = lever[..., 0], lever[..., 1]  # eq. 2.4
    scale = mass / (inertia + mass * (x * x + y * y))
    return InverseMass(scale * (inertia + mass * x * x), scale * mass * x * y, scale * (inertia + mass * y * y))


def rigid_tensor(M: Values, J: Values, d: Array) -> InverseMass:
    """Return the tensor at a foot of a rigid walker: I/M + P(d)/J, in 1/g (paper eq. 4).

    M (g) and J (g mm^2) of the whole walker, shape (...); d = centre of mass -> foot (mm), shape (..., 2).
    """
    x, y = d[..., 0], d[..., 1]
    return InverseMass(1.0 / M + y * y / J, -x * y / J, 1.0 / M + x * x / J)


def flexible_tensor(M: Values, J: Values, m: Values, j: Values, a: Array, c_A: Array, c_T: Array) -> InverseMass:
    """Return the tensor at the tip of a leg whose joint carries force but no torque, in 1/g (paper eqs 8-12).

    The body has M, J and anchor a; the leg has m, j (about its own centre), c_A = anchor -> centre and c_T = centre ->
    tip. Masses (g, g mm^2) shape (...), vectors (mm) (..., 2); all masses > 0.

    The published form I/m + P(c_T)/j - R^T K^-1 R subtracts numbers of order 1/m to leave 1/M: it loses the digits of
    M/m for a light leg. Woodbury's identity makes it a sum of positive terms, accurate for every m/M: with I_A = j + m
    |c_A|^2 (leg about its anchor), c = c_A + c_T and G = I - (m/I_A) perp(c_A) perp(c)^T,

        H = perp(c) perp(c)^T / I_A  +  G^T (mass of body at A + mass of leg at A)^-1 G.
    """
    body = _effective_mass(M, J, a)
    leg = _effective_mass(m, j, c_A)
    xx, xy, yy = body.xx + leg.xx, body.xy + leg.xy, body.yy + leg.yy
    det = xx * yy - xy * xy
    S_xx, S_xy, S_yy = yy / det, -xy / det, xx / det

    # Eq. 2.5, with r = perp(c)
    p_x, p_y = -c_A[..., 1], c_A[..., 0]
    about_anchor = j + m * (p_x * p_x + p_y * p_y)
    r_x, r_y = p_x - c_T[..., 1], p_y + c_T[..., 0]
    k = m / about_anchor
    G_xx, G_xy = 1.0 - k * p_x * r_x, -k * p_x * r_y
    G_yx, G_yy = -k * p_y * r_x, 1.0 - k * p_y * r_y
    SG_xx, SG_xy = S_xx * G_xx + S_xy * G_yx, S_xx * G_xy + S_xy * G_yy
    SG_yx, SG_yy = S_xy * G_xx + S_yy * G_yx, S_xy * G_xy + S_yy * G_yy
    return InverseMass(
        r_x * r_x / about_anchor + G_xx * SG_xx + G_yx * SG_yx,
        r_x * r_y / about_anchor + G_xx * SG_xy + G_yx * SG_yy,
        r_y * r_y / about_anchor + G_xy * SG_xy + G_yy * SG_yy,
    )


def foot_tensors(mass: MassProperties) -> tuple[InverseMass, ...]:
    """Return the inverse-mass tensor at each foot, without the masses of the other legs, as in the paper.

    This changes them by a share of the order of m/M (tests compare them with the chain of hinged legs).
    """
    return tuple(
        rigid_tensor(mass.M, mass.J, leg.foot)
        if np.all(np.asarray(leg.m) == 0.0)
        else flexible_tensor(mass.M, mass.J, leg.m, leg.j, leg.anchor, leg.c_A, leg.c_T)
        for leg in mass.legs
    )
