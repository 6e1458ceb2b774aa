"""Stationary speed of a whole walker: the paper's mean of two equal feet, or the feet's balance.

Two equal feet are taken to have as many impacts, as in the paper; unlike feet have as many as
balance the angular momentum (`walkergen.core.theory.balance`).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.theory.speed import Array, Factors, Mode, factor, factors
from walkergen.core.theory.tensors import foot_tensors
from walkergen.core.theory.uncertain_inputs import scale_proportionally
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties

Flags = npt.NDArray[np.bool_]


class Stationary(NamedTuple):
    """Stationary speed of a walker over its impact speed."""

    factor: Array
    """Speed of the walker over the impact speed, of the inputs' shape."""
    feet: tuple[Array, ...]
    """Speed of each foot of the plane alone, over the impact speed, back to front."""
    reverses: tuple[Flags, ...]
    """True where that foot slides back after its stop, as the paper assumes: mu < |H_xy|/H_xx."""
    note: str
    """Description of the balance; "" for the paper's mean."""


def stationary(
    design: Design,
    mass: MassProperties,
    restitution: float | Array,
    friction: float | Array,
    mode: Mode = "coulomb",
    nominal: tuple[float, float] | None = None,
) -> Stationary:
    """Return the stationary speed of a walker from its mass properties, which may carry batch axes.

    Restitution and friction are the scene's, or draws of them about the `nominal` ones: feet of
    another material keep theirs, changed in the proportion of draw to nominal. Raises TheoryError
    for numbers out of range, for a walker whose centre of mass is not between its feet, and for
    mode `paper` of unlike feet.
    """
    if design.pair:
        return _average_equal_feet(factors(mass, restitution, friction, mode))
    from walkergen.core.walker.planar import project_to_plane

    flat = project_to_plane(design, mass)
    if design.alike:
        return _average_equal_feet(factors(flat.mass, restitution, friction, mode))
    from walkergen.core.theory.balance import Foot, solve_balance  # compiles

    centre = flat.mass.centre
    by_foot = []
    for limb, leg, H in zip(flat.limbs, flat.mass.legs, foot_tensors(flat.mass), strict=True):
        e = _foot_value(limb.restitution, restitution, nominal[0] if nominal else None, 1.0)
        mu = _foot_value(limb.friction, friction, nominal[1] if nominal else None)
        lever = leg.foot - centre
        by_foot.append(Foot(H, (lever[..., 0], lever[..., 1]), e, mu))
    balance = solve_balance(by_foot, mode)
    own = tuple(factor(foot.H, foot.restitution, foot.friction, mode) for foot in by_foot)
    reverses = tuple(np.asarray(foot.friction * foot.H.xx < np.abs(foot.H.xy)) for foot in by_foot)
    return Stationary(balance.factor, own, reverses, _format_note(design, balance.note, balance.shares))


def _average_equal_feet(feet: Factors) -> Stationary:
    """Return the paper's mean of two equal feet."""
    return Stationary(feet.mean, feet.feet, feet.reverses, "")


def _foot_value(
    written: float | None, scenes: float | Array, nominal: float | None, most: float = math.inf
) -> float | Array:
    """Return a foot's friction or restitution: its own in the scene's proportion, or the scene's."""
    if written is None:
        return scenes
    return written if nominal is None else scale_proportionally(written, scenes, nominal, most)


def _format_note(design: Design, note: str, shares: Array) -> str:
    if shares.ndim == 1:
        percent = " : ".join(f"{100 * share:.0f}" for share in shares)
        note += f" (impacts from back to front {percent} %)"
    if not design.symmetric:
        note += "; legs are not alike left and right: it turns, which only the model in space knows"
    return note
