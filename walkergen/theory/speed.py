"""Stationary speed of a foot: the sliding speed at which an impact gives no horizontal impulse.

The foot arrives with normal speed w and slides at v_x0; the ratio v_x0 / w is called the factor
(docs/physics.md section 4; paper eq. 15). Everything broadcasts over arrays; one call serves a
million draws when made in chunks.
"""

from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from walkergen.errors import TheoryError
from walkergen.theory.tensors import InverseMass, feet
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]
Mode = Literal["coulomb", "paper"]
LawName = Literal["poisson", "newton", "stronge"]
MODES: tuple[Mode, ...] = get_args(Mode)
LAWS: tuple[LawName, ...] = get_args(LawName)


class Factors(NamedTuple):
    """Stationary speed over impact speed, of each foot by itself."""

    feet: tuple[Array, ...]
    """Factors of the feet, in the order of the legs."""
    reverses: tuple[npt.NDArray[np.bool_], ...]
    """True where a foot slides back after its stop, as the paper assumes: mu < |H_xy|/H_xx."""

    @property
    def mean(self) -> Array:
        """Mean factor of the feet: that of a walker whose feet have as many impacts."""
        return np.asarray(sum(self.feet) / len(self.feet))


def factor(
    H: InverseMass,
    restitution: float | Array,
    friction: float | Array,
    mode: Mode = "coulomb",
    law: LawName = "poisson",
) -> Array:
    """Factor v_x0 / w of one foot, positive forward; shapes broadcast.

    `coulomb` lets the foot stick when friction can hold it; `paper` is eq. 15, which assumes that
    it slides back in any case (Poisson's law only). At friction 0, where every speed is
    stationary, the result is the limit friction -> 0. Raises TheoryError for numbers out of range.
    """
    e, mu = np.asarray(restitution, dtype=float), np.asarray(friction, dtype=float)
    _check(e, mu, mode, law)
    magnitude = np.abs(H.xy)
    # Ratio |F_x|/F_y after the stop: as much as holds the foot, or all that friction gives.
    needed = magnitude / H.xx
    ratio = mu + 0.0 * needed if mode == "paper" else np.minimum(mu, needed)
    # Share of the impulse after the stop in the whole, ratio/(mu + ratio): 1/2 as mu -> 0.
    with np.errstate(invalid="ignore"):
        share = np.where(mu > 0, ratio / (mu + ratio), np.where(magnitude > 0, 0.5, 0.0))
    forward_slope = mu * H.xx + magnitude
    if law == "poisson":
        impulse = (1 + e) / (H.yy + e * ratio * magnitude)
    elif law == "newton":
        impulse = (1 + e) / (H.yy + 0.0 * ratio)
    else:
        impulse = _stronge_impulse(H, e, mu, ratio, share)
    # Eq. 4.1
    result: Array = -np.sign(H.xy) * share * forward_slope * impulse
    return result


def _stronge_impulse(H: InverseMass, e: Array, mu: Array, ratio: Array, share: Array) -> Array:
    """Total normal impulse per unit of w under energetic restitution, at the stationary speed.

    v_y changes by k1 per unit of impulse until p1 = share * p, then by k2; the end of compression
    lies after the stop (type III) or before it (type II). In both cases the balance of works
    W_restitution = -e^2 W_compression is a quadratic equation in p.
    """
    magnitude = np.abs(H.xy)
    k1, k2 = H.yy + mu * magnitude, H.yy - ratio * magnitude
    # With v_end = k1 p1 + k2 (p - p1) - 1 = H_yy p - 1 and v_stop = k1 p1 - 1:
    # Type III: v_end^2 / (2 k2) = e^2 [(1 - v_stop^2)/(2 k1) + v_stop^2/(2 k2)], v_stop <= 0.
    # Type II:  (v_end^2 - v_stop^2)/(2 k2) + v_stop^2/(2 k1) = e^2/(2 k1),     v_stop >= 0.
    # Solved with H_yy = k2 + t: every term is then positive and nothing cancels.
    t = share * (k1 - k2)
    lost = 1 - e**2
    root = e * np.sqrt(k2 * (k2 + share * lost * t))
    third = (k2 + lost * t + root) / (lost * t * t + k2 * (k2 + (2 - e**2 * share) * t))
    a = k2 + (2 - share) * t
    second = (1 + np.sqrt(np.maximum(1 - a * lost / k1, 0.0))) / a
    return np.where(k1 * share * third <= 1.0, third, second)


def _check(e: Array, mu: Array, mode: str, law: str) -> None:
    if not (np.all(e >= 0) and np.all(e <= 1)):
        raise TheoryError(f"restitution must lie in 0..1; seen {e.min()}..{e.max()}")
    if not (np.all(mu >= 0) and np.all(np.isfinite(mu))):
        raise TheoryError(f"friction must be a finite number >= 0; seen {mu.min()}..{mu.max()}")
    if mode not in MODES or law not in LAWS:
        raise TheoryError(f"mode {mode!r} must be one of {MODES} and law {law!r} one of {LAWS}")
    if mode == "paper" and law != "poisson":
        raise TheoryError(f"mode paper (eq. 15) is derived for law poisson only, not {law}")


def factors(
    mass: MassProperties,
    restitution: float | Array,
    friction: float | Array,
    mode: Mode = "coulomb",
    law: LawName = "poisson",
) -> Factors:
    """Stationary factors of feet of one material from mass properties. Raises TheoryError."""
    tensors = feet(mass)
    return Factors(
        tuple(factor(H, restitution, friction, mode, law) for H in tensors),
        tuple(np.asarray(friction * H.xx < np.abs(H.xy)) for H in tensors),
    )
