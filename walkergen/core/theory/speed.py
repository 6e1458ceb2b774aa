"""Stationary speed of a foot: the sliding speed at which an impact gives no horizontal impulse.

The foot arrives with normal speed w and slides at v_x0; the ratio v_x0 / w is called the factor (docs/physics.md
section 4; paper eq. 15). Everything broadcasts over arrays; one call serves a million draws when made in chunks.
"""

from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import TheoryError
from walkergen.core.theory.tensors import InverseMass, foot_tensors
from walkergen.core.walker.mass import MassProperties

Array = npt.NDArray[np.float64]
Mode = Literal["coulomb", "paper"]
MODES: tuple[Mode, ...] = get_args(Mode)


class Factors(NamedTuple):
    """Stationary speed over impact speed, of each foot alone."""

    feet: tuple[Array, ...]
    """Factors of the feet, in the order of the legs."""
    reverses: tuple[npt.NDArray[np.bool_], ...]
    """True where a foot slides back after its stop, as the paper assumes: mu < |H_xy|/H_xx."""

    @property
    def mean(self) -> Array:
        """Mean factor of the feet: the factor of a walker whose feet have equally many impacts."""
        return np.asarray(sum(self.feet) / len(self.feet))


def factor(H: InverseMass, restitution: float | Array, friction: float | Array, mode: Mode = "coulomb") -> Array:
    """Return the stationary speed v_x0 of one foot over its normal speed w, positive forward; shapes broadcast.

    `coulomb` lets the foot stick if friction can hold it. `paper` is eq. 15, which assumes that it slides back in any
    case. At friction 0 every speed is stationary; the result is the limit friction -> 0. Raises TheoryError for numbers
    out of range.
    """
    e, mu = np.asarray(restitution, dtype=float), np.asarray(friction, dtype=float)
    _check_numbers(e, mu, mode)
    magnitude = np.abs(H.xy)
    # Ratio |F_x|/F_y after the stop: as much as holds the foot, or all that friction gives.
    needed = magnitude / H.xx
    ratio = mu + 0.0 * needed if mode == "paper" else np.minimum(mu, needed)
    # Share of the impulse after the stop in the whole, ratio/(mu + ratio): 1/2 as mu -> 0.
    with np.errstate(invalid="ignore"):
        share = np.where(mu > 0, ratio / (mu + ratio), np.where(magnitude > 0, 0.5, 0.0))
    forward_slope = mu * H.xx + magnitude
    impulse = (1 + e) / (H.yy + e * ratio * magnitude)
    # Eq. 4.1
    result: Array = -np.sign(H.xy) * share * forward_slope * impulse
    return result


def _check_numbers(e: Array, mu: Array, mode: str) -> None:
    """Raise TheoryError unless restitution e, friction mu and mode are in their ranges."""
    if not (np.all(e >= 0) and np.all(e <= 1)):
        raise TheoryError(f"restitution = {e.min()}..{e.max()}: it must lie in 0..1.")
    if not (np.all(mu >= 0) and np.all(np.isfinite(mu))):
        raise TheoryError(f"friction = {mu.min()}..{mu.max()}: it must be a finite number >= 0.")
    if mode not in MODES:
        raise TheoryError(f"mode = {mode!r}: it must be one of {MODES}.")


def factors(
    mass: MassProperties, restitution: float | Array, friction: float | Array, mode: Mode = "coulomb"
) -> Factors:
    """Return the `factor` of each foot alone, for equal restitution and friction of all feet. Raises TheoryError."""
    tensors = foot_tensors(mass)
    return Factors(
        tuple(factor(H, restitution, friction, mode) for H in tensors),
        tuple(np.asarray(friction * H.xx < np.abs(H.xy)) for H in tensors),
    )
