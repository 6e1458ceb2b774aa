"""Surrogate of the model in space: a simulation's result in a millisecond, inside its tested domain.

Small networks on dimensionless numbers of a walker with two equal legs on a shaken plate or in a lane
(evidence/tables trains them on simulated walkers). The surrogate gives no answer if its error is above MAX_ERROR_SHARE
and MAX_ERROR_MM_S, if walkers may fall over, or outside the sampled numbers.
Such a walker is simulated (`points.speed_prediction`).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import WalkergenError
from walkergen.core.scene import DEPENDENT_KEYS, Scene
from walkergen.core.theory import dimensionless, networks
from walkergen.core.theory.dimensionless import DimensionlessNumbers
from walkergen.core.theory.networks import LINEAR_BELOW, Speeds
from walkergen.core.theory.uncertain_inputs import Drawn
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Kind
from walkergen.core.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

NORMAL_95 = NormalDist().inv_cdf(0.975)
"""Standard deviations on either side of the middle that hold 95 % of a normal distribution."""

MAX_ERROR_SHARE, MAX_ERROR_MM_S = 0.15, 1.5
"""Largest stated error (95 %) of an answer: a share of the speed, or a speed if that is more. Most answers have smaller
ones, so that 95 % of all are within 10 % or 1 mm/s."""

MAX_FALL_CHANCE, SURE_FALL_CHANCE = 0.04, 0.9
"""Largest chance of a fall, from the networks, that allows a speed as the answer, and smallest chance that gives a fall
as the answer. Walkers between these are simulated."""

RANGE_MARGIN = 0.02
"""Margin beyond the sampled range of a number, as a share of the range: samples do not reach its ends."""


class UnknownError(WalkergenError):
    """A walker is outside the surrogate's domain; the text gives the reason, which a table states once."""

    def __init__(self, text: str, near: "SurrogateCase | None" = None) -> None:
        super().__init__(text)
        self.near = near
        """Walker within the surrogate's ranges, but without a certain speed; None outside them."""


class FallsError(UnknownError):
    """The surrogate gives no speed of a walker, because it falls over."""

    def __init__(self, chance: float) -> None:
        super().__init__(f"falls over in {100.0 * chance:.0f} % of its runs")
        self.chance = chance


@dataclass(frozen=True)
class SurrogateCase:
    """Walker in a scene within the surrogate's domain."""

    design: Design
    scene: Scene
    numbers: DimensionlessNumbers

    @property
    def sign(self) -> float:
        """Sign of the tilt. The dimensionless numbers contain only its magnitude."""
        return math.copysign(1.0, self.design.tilt_deg)

    @property
    def peak_speed(self) -> float:
        """Peak speed of the plate, mm/s. The surrogate's speeds are ratios to it."""
        return self.scene.drive.peak_speed

    def speeds_at(self, numbers: DimensionlessNumbers) -> Speeds:
        """Return the speeds of walkers with these `numbers`, which are limited to the sampled ranges."""
        kind = self.design.kind
        speeds = networks.speeds_at(kind, np.clip(dimensionless.to_matrix(numbers), *_input_bounds(kind)))
        return speeds._replace(centre=self.sign * speeds.centre)

    @cached_property
    def predicted(self) -> Speeds:
        """Speed of the walker as designed, on the networks' scale."""
        return self.speeds_at(self.numbers)

    @property
    def nominal(self) -> tuple[float, float]:
        """Speed of the walker as designed and its standard error, mm/s."""
        return self.to_mm_s(self.predicted)

    def to_mm_s(self, speeds: Speeds) -> tuple[float, float]:
        """Return the first of `speeds` and its standard error, converted from the networks' scale to mm/s."""
        slope = LINEAR_BELOW * math.cosh(speeds.centre[0])
        return self.peak_speed * float(speeds.speed_ratios(0.0)[0]), self.peak_speed * slope * float(speeds.error[0])

    def is_certain(self, speeds: Speeds) -> bool:
        """Return whether the first of `speeds` has an error (95 %) of at most `allowed_error`."""
        speed, se = self.to_mm_s(speeds)
        return bool(NORMAL_95 * se <= allowed_error(speed))

    def speeds_at_draws(self, drawn: Drawn) -> Speeds:
        """Return the walker's speed for each random draw of the uncertain inputs, on the networks' scale."""
        return self.speeds_at(self.numbers.with_inputs(self.design, self.scene, drawn))


def allowed_error(speed: Array | float) -> Array:
    """Return the largest error (95 %) with which the surrogate may state a `speed`, both in mm/s and of one shape."""
    return np.maximum(MAX_ERROR_SHARE * np.abs(speed), MAX_ERROR_MM_S)


def case_in_domain(scene: Scene, design: Design, mass: MassProperties, only_certain: bool = True) -> SurrogateCase:
    """Return the case of a walker within the surrogate's domain. Its methods compute the walker's speeds.

    Raises FallsError for a walker that almost surely falls over. Raises UnknownError, with the reason, for a walker
    that may fall, is outside the domain, or has too large an error. `only_certain=False` accepts any error.
    """
    for reason in domain_violations(scene, design):
        raise UnknownError(reason)
    known = SurrogateCase(design, scene, dimensionless.compute_numbers(scene, design, mass))
    _check_ranges(design.kind, known.numbers)
    fall_chance = float(known.predicted.falls[0])
    if fall_chance >= SURE_FALL_CHANCE:
        raise FallsError(fall_chance)
    if fall_chance > MAX_FALL_CHANCE:
        raise UnknownError("such walkers may fall over", known)
    if only_certain and not known.is_certain(known.predicted):
        raise UnknownError(
            f"the surrogate's error is more than {100 * MAX_ERROR_SHARE:g} % and {MAX_ERROR_MM_S:g} mm/s", known
        )
    return known


def domain_violations(scene: Scene, design: Design) -> Iterator[str]:
    """Yield the reasons why a walker or its scene lies outside the surrogate's training set."""
    if scene.drive.kind == "motor":
        yield "walkers with a motor are simulated"
    if not design.is_symmetric_pair:
        yield "walkers without two equal legs are simulated"
    if design.kind not in ("flexible", "braced"):
        yield f"walkers with {design.kind} legs are simulated"
    limb = design.limbs[0]
    if limb.foot != "flat" or limb.friction is not None or limb.restitution is not None:
        yield "walkers with feet of another shape or material are simulated"
    if scene.plate.slope_deg and scene.run.heading_deg != type(scene.run).model_fields["heading_deg"].default:
        yield "walkers that start across a slope are simulated"
    yield from scene_violations(scene)


COVERED_TABLES = frozenset({"name", "description", "prediction", "run", "crowd", "contact", "drive"})
"""Tables of a scene that the surrogate reads, or that change no mean speed."""

COVERED_KEYS = {
    "arena": {"kind", "length_mm", "width_mm", "gap_mm", "wall_friction", "wall_restitution"},
    "plate": {"slope_deg", "noise_ratio", "material", "youngs_modulus_gpa"},
    "feet": {"unevenness_um", "unevenness_sd_um", "tip_radius_um", "tip_radius_sd_factor"},
    "legs": {"damping_ratio", "damping_ratio_sd"},
}
"""Keys of other tables that the surrogate reads, or that it draws."""

GOVERNING_KEY = {key: number for number, keys in DEPENDENT_KEYS.items() for key in (number, *keys)}
"""For each key, the key whose number must differ from 0 for it to have an effect."""


def scene_violations(scene: Scene) -> list[str]:
    """Return a text for each key of a scene with a value outside the surrogate's training set.

    A key that depends on another key (GOVERNING_KEY) counts only if the other one is not 0.
    """
    reasons = []
    for name in type(scene).model_fields:
        if name in COVERED_TABLES:
            continue
        table = getattr(scene, name)
        for key, field in type(table).model_fields.items():
            number = GOVERNING_KEY.get(f"{name}.{key}")
            idle = number is not None and not scene.value(number)
            value = getattr(table, key)
            if key not in COVERED_KEYS.get(name, ()) and not idle and value != field.default:
                reasons.append(f"{name}.{key} = {value} is simulated")
    return reasons


def _input_bounds(kind: Kind) -> Array:
    """Return the smallest and largest sampled dimensionless numbers for a kind of legs, shape (2, fields)."""
    ranges = networks.training_facts()["ranges"][kind]
    return np.array([ranges[name] for name in DimensionlessNumbers._fields]).T


def _check_ranges(kind: Kind, numbers: DimensionlessNumbers) -> None:
    """Raise UnknownError if one of a walker's numbers lies outside its sampled range."""
    for name, value, low, high in zip(DimensionlessNumbers._fields, numbers, *_input_bounds(kind), strict=True):
        margin = RANGE_MARGIN * (high - low) + 1e-9
        if not low - margin <= float(value) <= high + margin:
            words, ends = dimensionless.describe_number(name, low, high)
            side = "less" if float(value) < low else "more"
            raise UnknownError(f"the surrogate is trained for a {words} of {ends}, and here it is {side}")
