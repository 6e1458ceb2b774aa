"""Parameters that measured speeds can determine: their ranges and priors."""

import math
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from walkergen.core import Design
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.core.scene import MIN_RESTITUTION, Scene
from walkergen.core.theory import uncertain_inputs
from walkergen.core.theory.uncertain_inputs import Input

PriorName = Literal["flat", "scene"]
DEFAULT_PRIOR: PriorName = "scene"
"""Prior of restitution and friction by default: the scene's values, as measured."""

ModelName = Literal["prediction", "space"]
"""Models to fit to speeds: the surrogate behind speed predictions, and simulated runs."""

PARAMETER_KEYS = {
    "restitution": "contact.restitution",
    "friction": "contact.friction",
    "tip_radius_um": "feet.tip_radius_um",
    "thickness_mm": "legs.thickness_mm",
    "youngs_modulus_gpa": "material.youngs_modulus_gpa",
    "damping_ratio": "legs.damping_ratio",
    "frequency_hz": uncertain_inputs.FREQUENCY_KEY,
    "eccentric_g_mm": uncertain_inputs.MOMENT_KEY,
}
"""Names of the parameters that all prints share, and their keys in `uncertain_inputs.inputs`. The last two belong to a
motor."""

SCENE_PARAMETERS = ("restitution", "friction", "tip_radius_um", "damping_ratio", "frequency_hz", "eccentric_g_mm")
"""Names of the parameters that a scene contains; a design contains the others."""

STATED_DEVIATIONS = {
    "restitution": ("contact", "restitution_sd"),
    "friction": ("contact", "friction_sd"),
    "tip_radius_um": ("feet", "tip_radius_sd_factor"),
    "damping_ratio": ("legs", "damping_ratio_sd"),
    "frequency_hz": ("drive", "frequency_sd_hz"),
    "eccentric_g_mm": ("drive", "eccentric_sd_g_mm"),
}
"""Table and key of a scene with a parameter's standard deviation. Where a file gives it, the value was measured."""

PRINT_INPUTS = ("body mass", "leg mass", "feet.unevenness_um")
"""Inputs that differ from print to print: drawn again for every simulated walker."""

FLAT_RANGES = {"restitution": (0.0, 1.0), "friction": (0.02, 0.6)}
"""Ranges of the flat priors. Dry friction of plastics on plates lies within (0.1 to 0.5)."""

MIN_TABLE_FRICTION = 0.05
"""Smallest friction in the table behind speed predictions."""

SCATTER_NAME = "print_scatter"
PRIOR_SCATTER_SD = 0.15
"""Name and prior standard deviation of the scatter of speeds between prints, over their speed, where speeds have no
errors: an unevenness of 5 um brings 25 % at 10 deg, 5 % from 15 deg on."""


class Parameter(NamedTuple):
    """Parameter to fit. Its prior is truncated normal or, if `flat`, uniform from `prior.low` to `prior.high`."""

    name: str
    prior: Input
    flat: bool

    def quantiles(self, probabilities: Array) -> Array:
        """Return the quantiles of the prior at these probabilities, as an array of the same shape."""
        if self.flat:
            return self.prior.low + probabilities * (self.prior.high - self.prior.low)
        return uncertain_inputs.input_quantiles(self.prior, probabilities)

    @property
    def statement(self) -> str:
        """The prior as text, such as 0.3 ± 0.05."""
        prior = self.prior
        if prior.factor:
            return f"{formatting.format_number(prior.mean, 4)}, factor {math.exp(prior.sd):.3g}"
        if prior.mean == 0.0:
            return f"half normal, {prior.sd:g}"
        if self.flat:
            return f"flat, {prior.low:g} to {prior.high:g}"
        return f"{formatting.format_number(prior.mean, 4)} ± {formatting.format_number(prior.sd, 2)}"


class Unknown(NamedTuple):
    """All uncertain inputs of walkers and contact in a fit."""

    simulated: tuple[Parameter, ...]
    """Parameters that simulated speeds depend on."""
    printed: tuple[Input, ...]
    """Inputs that differ from print to print."""
    scatter: tuple[Parameter, ...]
    """Scatter between prints as a parameter, if speeds have no errors; else empty."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All fitted parameters, in the order of the columns of a posterior's draws."""
        return self.simulated + self.scatter

    @property
    def sampled(self) -> tuple[Parameter, ...]:
        """Parameters for the surrogate: the fitted ones, then inputs that all prints of a printer share."""
        return (*self.parameters, *(Parameter(varying.name, varying, False) for varying in self.printed))

    @property
    def prints_differ(self) -> bool:
        """True when feet differ from print to print; masses alone change speeds too little."""
        return any(varying.name == "feet.unevenness_um" for varying in self.printed)


def is_measured(name: str, scene: Scene, design: Design) -> bool:
    """Return whether scene or design give the standard deviation of a parameter. Otherwise its value is assumed."""
    if name in STATED_DEVIATIONS:
        table, key = STATED_DEVIATIONS[name]
        return key in getattr(scene, table).model_fields_set
    keys = {
        "thickness_mm": (design.legs, "thickness_sd_mm"),
        "youngs_modulus_gpa": (design.material, f"{name[:-3]}sd_gpa"),
    }
    holder, key = keys.get(name, (None, ""))
    return key in getattr(holder, "model_fields_set", ())


def list_unknowns(
    scene: Scene, design: Design, model: ModelName, prior: PriorName, fixed: Mapping[str, float], has_se: bool = True
) -> Unknown:
    """Return the parameters to fit and the inputs that differ from print to print.

    Thickness, Young's modulus and damping have the standard deviations of design and scene as priors. Without one, or
    if in `fixed`, they are not fitted. If not `has_se`, the measured speeds have no standard errors, and their scatter
    between prints is fitted too. Raises InputError when nothing is left to fit.
    """
    inputs = {entry.name: entry for entry in uncertain_inputs.inputs(scene, design, model)}
    parameters: list[Parameter] = []
    for name, key in PARAMETER_KEYS.items():
        if name in fixed:
            continue
        if prior == "flat" and name in FLAT_RANGES:
            low, high = FLAT_RANGES[name]
            if name == "restitution":
                low = MIN_RESTITUTION
            if name == "friction" and model == "prediction":
                low = MIN_TABLE_FRICTION
            middle, sd = 0.5 * (low + high), (high - low) / 12**0.5
            parameters.append(Parameter(name, Input(key, middle, sd, low, high), True))
        elif key in inputs:
            parameters.append(Parameter(name, inputs[key], False))
    if not parameters:
        raise InputError(
            "‹fix›: no parameter is left to fit. Leave one of them free, or use ‹prior=›flat if the scene's standard "
            "deviations are 0"
        )
    printed = tuple(inputs[name] for name in PRINT_INPUTS if name in inputs)
    scatter = Parameter(SCATTER_NAME, Input(SCATTER_NAME, 0.0, PRIOR_SCATTER_SD), False)
    return Unknown(tuple(parameters), printed, () if has_se else (scatter,))


def apply_fixed(scene: Scene, design: Design, fixed: Mapping[str, float]) -> tuple[Scene, Design]:
    """Return scene and design with the fixed values, by name. Raises GeometryError for legs that are too thick."""
    values = {PARAMETER_KEYS[name]: value for name, value in fixed.items()}
    if scene.drive.kind == "plate" and (
        wrong := {uncertain_inputs.FREQUENCY_KEY, uncertain_inputs.MOMENT_KEY} & set(values)
    ):
        raise InputError(f"‹fix›: {sorted(wrong)[0]} belongs to a motor, but the scene has a plate")
    scene, design, _ = uncertain_inputs.apply_inputs(scene, design, values)
    return scene, design


def prior_values(parameters: Sequence[Parameter], probabilities: Array) -> Array:
    """Return the quantiles of the parameters' priors at these probabilities, both of shape (n, parameters)."""
    columns = [parameter.quantiles(probabilities[:, number]) for number, parameter in enumerate(parameters)]
    return np.column_stack(columns)
