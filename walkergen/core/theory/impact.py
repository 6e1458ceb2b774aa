"""One planar impact with Coulomb friction (Routh's construction; docs/physics.md section 3).

The foot touches the plate with velocity (v_x, v_y < 0) and inverse-mass tensor H. Velocities are piecewise linear in
the normal impulse p = F_y. In the first segment the foot slides with the sign of v_x. Once v_x has reached zero, it
sticks or slides on in a second segment. Compression ends when v_y = 0. Poisson's law of restitution ends the impact:
F_y = (1 + e) times that of compression, as in the paper.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from walkergen.core.errors import TheoryError
from walkergen.core.numerics.kernels import kernel

# The values as kernels read them; `Kind` says what they mean.
NONE, TYPE_I, TYPE_II, TYPE_III, TYPE_IV, FROM_REST = range(6)
II_MIRRORED, III_MIRRORED = -TYPE_II, -TYPE_III

# Speed (mm/s) below which, and above whose inverse, an impact is scaled, so that it loses no digits.
MIN_SAFE_SPEED = 1e-100


class Kind(IntEnum):
    """Type of an impact by the sign of the sliding velocity v_x (paper, figure 3)."""

    NONE = NONE
    """Not approaching: no impulse."""
    I = TYPE_I  # noqa: E741  (the paper's own name)
    """v_x > 0 throughout."""
    II = TYPE_II
    """v_x > 0 stops during restitution."""
    III = TYPE_III
    """v_x > 0 stops during compression."""
    IV = TYPE_IV
    """v_x < 0 throughout."""
    FROM_REST = FROM_REST
    """v_x = 0 before the impact."""
    II_MIRRORED = II_MIRRORED
    """v_x < 0 stops during restitution."""
    III_MIRRORED = III_MIRRORED
    """v_x < 0 stops during compression."""

    @property
    def label(self) -> str:
        """The type as people read it: "II", "from rest", "II mirrored"."""
        words = self.name.split("_")
        return " ".join(word if set(word) <= set("IV") else word.lower() for word in words)


class Impact(NamedTuple):
    """Outcome of one impact: impulse (g mm/s), velocity of the foot after it (mm/s), and type."""

    F_x: float
    F_y: float
    v_x: float
    v_y: float
    kind: int
    """Type of the impact, a value of `Kind`."""
    sticks: bool
    """True when the foot stops and sticks until it leaves: |H_xy| <= mu H_xx."""


@kernel
def determinant(H_xx: float, H_xy: float, H_yy: float) -> float:
    """Compute the determinant H_xx H_yy - H_xy^2 to nearly full precision, even if H is almost singular.

    The rounding errors of both products are recovered exactly (Dekker 1971, Veltkamp splitting), valid while entries
    stay below about 1e150.
    """
    splitter = 134217729.0  # 2^27 + 1
    t = splitter * H_xx
    xx_high = t - (t - H_xx)
    xx_low = H_xx - xx_high
    t = splitter * H_yy
    yy_high = t - (t - H_yy)
    yy_low = H_yy - yy_high
    t = splitter * H_xy
    xy_high = t - (t - H_xy)
    xy_low = H_xy - xy_high
    first = H_xx * H_yy
    error_1 = ((xx_high * yy_high - first) + xx_high * yy_low + xx_low * yy_high) + xx_low * yy_low
    second = H_xy * H_xy
    error_2 = ((xy_high * xy_high - second) + 2.0 * xy_high * xy_low) + xy_low * xy_low
    return (first - second) + (error_1 - error_2)


@kernel
def impact(
    H_xx: float, H_xy: float, H_yy: float, v_x: float, v_y: float, restitution: float, friction: float
) -> Impact:
    """Compute the impulse and outcome of one impact of a foot, for the theory. The simulation in 3D has elastic feet.

    H (1/g) must be positive definite, velocity in mm/s, 0 <= restitution <= 1, friction >= 0. `resolve` checks this,
    the kernel does not. The result is homogeneous of degree 1 in the velocity. For v_y >= 0 there is no impulse and the
    type is `Kind.NONE`.
    """
    if v_y >= 0.0:
        return Impact(0.0, 0.0, v_x, v_y, NONE, False)
    size = max(abs(v_x), -v_y)
    if MIN_SAFE_SPEED < size < 1.0 / MIN_SAFE_SPEED:
        return _compute_impact(H_xx, H_xy, H_yy, v_x, v_y, restitution, friction)
    _, n = math.frexp(size)  # a power of two: scaling by it loses no digit
    v_x, v_y = math.ldexp(v_x, -n), math.ldexp(v_y, -n)
    hit = _compute_impact(H_xx, H_xy, H_yy, v_x, v_y, restitution, friction)
    F_x, F_y = math.ldexp(hit.F_x, n), math.ldexp(hit.F_y, n)
    return Impact(F_x, F_y, math.ldexp(hit.v_x, n), math.ldexp(hit.v_y, n), hit.kind, hit.sticks)


@kernel
def _compute_impact(
    H_xx: float, H_xy: float, H_yy: float, v_x: float, v_y: float, restitution: float, friction: float
) -> Impact:
    """Compute an impact as `impact` does, for a speed whose square neither under- nor overflows."""
    # After a stop: stick if friction can hold the foot, else slide on along H_xy. Ratio = F_x/F_y.
    sticks = abs(H_xy) <= friction * H_xx
    if sticks:
        ratio_2 = -H_xy / H_xx  # eq. 3.2
        slope_x2 = 0.0
        slope_y2 = determinant(H_xx, H_xy, H_yy) / H_xx
    else:
        ratio_2 = -math.copysign(friction, H_xy)
        slope_x2 = H_xy + ratio_2 * H_xx
        slope_y2 = H_yy + ratio_2 * H_xy

    # Before the stop (eq. 3.1): slide against friction up to the normal impulse `stop` (perhaps infinite).
    ratio_1 = ratio_2
    slope_x1 = slope_x2
    slope_y1 = slope_y2
    stop = 0.0
    if v_x != 0.0:
        ratio_1 = -math.copysign(friction, v_x)
        slope_x1 = H_xy + ratio_1 * H_xx
        slope_y1 = H_yy + ratio_1 * H_xy
        stop = -v_x / slope_x1 if slope_x1 * v_x < 0.0 else math.inf

    # Compression. With slope_y1 <= 0 (jamming) it cannot end before the stop.
    stops_early = slope_y1 * stop < -v_y
    if stops_early:
        v_stop = v_y + slope_y1 * stop
        compression = stop - v_stop / slope_y2
    else:
        compression = -v_y / slope_y1

    total = compression + restitution * compression  # eq. 3.3
    if total <= stop and v_x != 0.0:
        return Impact(
            ratio_1 * total,
            total,
            v_x + slope_x1 * total,
            v_y + slope_y1 * total,
            TYPE_I if v_x > 0.0 else TYPE_IV,
            False,
        )
    after = total - stop
    if v_x == 0.0:
        kind = FROM_REST
    else:
        kind = TYPE_III if stops_early else TYPE_II
        if v_x < 0.0:
            kind = -kind
    return Impact(
        ratio_1 * stop + ratio_2 * after,
        total,
        slope_x2 * after,
        (v_y + slope_y1 * stop) + slope_y2 * after,
        kind,
        sticks,
    )


def resolve(
    H: tuple[float, float, float], velocity: tuple[float, float], restitution: float, friction: float
) -> Impact:
    """Compute one impact as `impact` does, after checking its input. H = (H_xx, H_xy, H_yy) in 1/g, velocity in mm/s.

    Raises TheoryError when H is not positive definite or a number lies outside its range.
    """
    H_xx, H_xy, H_yy = (float(entry) for entry in H)
    v_x, v_y = (float(component) for component in velocity)
    if not all(math.isfinite(value) for value in (H_xx, H_xy, H_yy, v_x, v_y)):
        raise TheoryError(f"impact: tensor {H} and velocity {velocity} must be finite numbers")
    if not (H_xx > 0.0 and H_yy > 0.0 and determinant(H_xx, H_xy, H_yy) > 0.0):
        raise TheoryError(f"impact: the inverse-mass tensor {H} must be positive definite")
    if not 0.0 <= restitution <= 1.0:
        raise TheoryError(f"impact: restitution {restitution} must lie in 0..1")
    if not (friction >= 0.0 and math.isfinite(friction)):
        raise TheoryError(f"impact: friction {friction} must be a finite number >= 0")
    return Impact(*impact(H_xx, H_xy, H_yy, v_x, v_y, float(restitution), float(friction)))


def energy_change(velocity: tuple[float, float], outcome: Impact) -> float:
    """Compute the kinetic energy gained in an impact, F . (v_before + v_after) / 2, in g mm^2/s^2 (1e-9 J).

    `velocity` is that before the impact. The result is negative if energy is lost.
    """
    # Eq. 3.4
    return 0.5 * (outcome.F_x * (velocity[0] + outcome.v_x) + outcome.F_y * (velocity[1] + outcome.v_y))
