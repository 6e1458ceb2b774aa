"""Stationary speed of a whole walker: zero at rest, the paper's mean of two equal feet, or the feet's balance.

A body stays on its feet while the plate's largest downward acceleration, times what the legs add to it, is less than
gravity. The feet keep to the plate by friction unless it is too steep. Without friction no foot pushes along a level
plate. Two equal feet have equally many impacts, as in the paper. Those of unlike feet balance the angular momentum
(`walkergen.core.theory.balance`). The theory knows the run and the height only: a pair of legs side by side is one leg
of the plane, with their masses, widths and stiffnesses added. In space one of them lands first where the walker rolls.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.theory.hertz import tip_stiffness
from walkergen.core.theory.speed import Array, Factors, Mode, factor, factors
from walkergen.core.theory.tensors import foot_tensors
from walkergen.core.theory.uncertain_inputs import scale_proportionally
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import LegMass, MassProperties
from walkergen.core.walker.sections import section_of

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


def stationary_speed(
    design: Design,
    mass: MassProperties,
    restitution: float | Array,
    friction: float | Array,
    mode: Mode = "coulomb",
    nominal: tuple[float, float] | None = None,
) -> Stationary:
    """Return the stationary speed of a walker over its impact speed. Mass properties may carry batch axes.

    Restitution and friction are the scene's, or draws of them about the `nominal` (restitution, friction). Feet of
    another material keep their own values, scaled by draw over nominal. Raises TheoryError for numbers out of range,
    for a centre of mass that is not between the feet, and for mode `paper` of unlike feet.
    """
    if design.has_legs_table:
        return _average_equal_feet(factors(mass, restitution, friction, mode))
    flat = project_to_plane(design, mass)
    if design.is_symmetric_pair:
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
    foot_factors = tuple(factor(foot.H, foot.restitution, foot.friction, mode) for foot in by_foot)
    reverses = tuple(np.asarray(foot.friction * foot.H.xx < np.abs(foot.H.xy)) for foot in by_foot)
    return Stationary(balance.factor, foot_factors, reverses, _format_note(design, balance.note, balance.shares))


def _average_equal_feet(feet: Factors) -> Stationary:
    """Return the stationary speed of a walker with two equal feet: the mean of both, as in the paper."""
    return Stationary(feet.mean, feet.feet, feet.reverses, "")


def _foot_value(
    own_value: float | None, scene_value: float | Array, nominal: float | None, upper_limit: float = math.inf
) -> float | Array:
    """Return a foot's friction or restitution: `own_value` times scene_value / nominal; if None `scene_value`."""
    if own_value is None:
        return scene_value
    return own_value if nominal is None else scale_proportionally(own_value, scene_value, nominal, upper_limit)


def _format_note(design: Design, note: str, shares: Array) -> str:
    """Return the `note` of a balance with shares of impacts added, if of shape (feet,), and a remark on turning."""
    if shares.ndim == 1:
        percent = " : ".join(f"{100 * share:.0f}" for share in shares)
        note += f" (impacts from back to front {percent} %)"
    if not design.is_mirror_symmetric:
        note += "; its legs differ left and right, so it turns, which only the model in space includes"
    return note


class Planar(NamedTuple):
    """Walker in the plane; its legs from back to front."""

    mass: MassProperties
    limbs: tuple[Limb, ...]
    """Legs of the plane, as wide as the legs that they represent together."""


def project_to_plane(design: Design, mass: MassProperties) -> Planar:
    """Project a walker to its side view: legs side by side become one. Two equal legs stay unchanged."""
    if design.has_legs_table:
        return Planar(mass, design.limbs)
    groups: dict[tuple[object, ...], list[tuple[Limb, LegMass]]] = {}
    for limb, leg in zip(design.limbs, mass.legs, strict=True):
        key = limb._replace(width=0.0, across=0.0, thickness_sd=0.0)
        groups.setdefault(key, []).append((limb, leg))
    merged = sorted((_merge_legs(group) for group in groups.values()), key=lambda pair: pair[0].along)
    return Planar(mass._replace(legs=tuple(leg for _, leg in merged)), tuple(limb for limb, _ in merged))


def _merge_legs(group: list[tuple[Limb, LegMass]]) -> tuple[Limb, LegMass]:
    """Return one leg, with its masses, that represents a group of equal legs side by side."""
    (limb, leg), legs = group[0], [leg for _, leg in group]
    return (
        limb._replace(width=sum(limb.width for limb, _ in group)),
        leg._replace(m=sum(leg.m for leg in legs), j=sum(leg.j for leg in legs)),
    )


def standing_reason(scene: Scene, design: Design, mass: MassProperties) -> str:
    """Return the reason why a walker rests; "" if it may run.

    This is statics, with the amplification of an undamped mass on a spring. tests/core/theory/test_standing.py compares
    it with runs.
    """
    drive, plate, contact = scene.drive, scene.plate, scene.contact
    if plate.sways:
        return ""
    frictions = [contact.friction if limb.friction is None else limb.friction for limb in design.limbs]
    if max(frictions) == 0.0 and plate.slope_deg == 0.0:
        return "without friction no foot pushes, so the walker bounces in place"
    if drive.kind != "plate" or plate.noise_ratio > 0.0:
        return ""
    slope = math.radians(abs(plate.slope_deg))
    if math.tan(slope) >= min(frictions):
        return ""
    peak_acceleration = _largest_acceleration(scene) * _amplification(scene, design, mass)
    if peak_acceleration >= GRAVITY * math.cos(slope):
        return ""
    return f"the peak acceleration of the plate, {drive.peak_gamma:.3g} g, is too small: the walker stands"


def _largest_acceleration(scene: Scene) -> float:
    """Return an upper bound of the plate's acceleration, mm/s^2, with its second harmonic."""
    return scene.drive.peak_gamma * GRAVITY * (1.0 + 4.0 * scene.drive.second_harmonic_ratio)  # (2 omega)^2


def _amplification(scene: Scene, design: Design, mass: MassProperties) -> float:
    """Return the peak acceleration of a body on elastic legs over the plate's; infinite at and above resonance."""
    modulus = 1e9 * design.material.youngs_modulus_gpa
    load = float(mass.total) * GRAVITY / (2 * len(design.limbs))
    tip = tip_stiffness(scene, design.material)
    tips_compliance = 0.5 / (1.5 * tip ** (2.0 / 3.0) * load ** (1.0 / 3.0))  # of both tips of a foot at rest
    stiffness = sum(1.0 / (_vertical_compliance(limb, modulus) + tips_compliance) for limb in design.limbs)
    max_omega = scene.drive.omega * (2.0 if scene.drive.second_harmonic_ratio else 1.0)
    ratio = max_omega**2 * float(mass.total) / stiffness
    return 1.0 / (1.0 - ratio) if ratio < 1.0 else math.inf


def _vertical_compliance(limb: Limb, modulus: float) -> float:
    """Return the vertical compliance of a leg on a sliding foot, bent and compressed, s^2/g. `modulus`: Young's, Pa."""
    compliance = math.cos(limb.tilt) ** 2 / (modulus * limb.width * section_of(limb).axial(limb))
    if not limb.rigid:
        compliance += math.sin(limb.tilt) ** 2 * limb.length**3 / (3.0 * modulus * section_of(limb).second_moment(limb))
    return compliance
