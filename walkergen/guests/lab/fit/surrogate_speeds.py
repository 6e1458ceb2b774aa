"""Speeds in each setting as functions of the parameters, from the surrogate behind `predict` and `family`.

A row of inputs has the parameters, the unevenness of the printer's feet and the errors of its masses. All prints of a
file share the latter two.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import mass_of
from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.theory import prediction, surrogate
from walkergen.core.theory.networks import LINEAR_BELOW
from walkergen.core.theory.surrogate import UnknownError
from walkergen.core.theory.uncertain_inputs import Drawn
from walkergen.guests.lab.fit.emulated_speeds import STILL_SPEED_RATIO, FitInputs, Setting, plate_scene
from walkergen.guests.lab.fit.parameters import SCATTER_NAME


class SurrogateSpeed(NamedTuple):
    """Function that predicts the speed in a setting. `known`: scene and design of the setting for the surrogate."""

    setting: Setting
    known: surrogate.SurrogateCase
    inputs: tuple[str, ...]
    """Names of the inputs, in the order of the columns of `x`."""

    def __call__(self, x: Array) -> tuple[Array, Array, Array]:
        """Return the mean speed, its error common to all prints, and the scatter between prints, each (k,), mm/s.

        `x`: values of `inputs`, shape (k, inputs). The common error is that of the surrogate and of the model itself.
        """
        drawn = Drawn(dict(zip(self.inputs, x.T, strict=True)), len(x))
        plate, speeds = self.setting.plate_speed, self.known.speeds_at_draws(drawn)
        slope = plate * LINEAR_BELOW * np.cosh(speeds.centre)
        mean = plate * speeds.speed_ratios(0.0)
        print_scatter = drawn.input_values(SCATTER_NAME, 0.0) * np.hypot(mean, STILL_SPEED_RATIO * plate)
        shared = np.hypot(slope * speeds.error, prediction.model_error_sd(mean, self.known.scene))
        return mean, shared, np.hypot(slope * speeds.between_prints, print_scatter)


def speed_models(inputs: FitInputs, settings: Sequence[Setting]) -> list[SurrogateSpeed]:
    """Return functions that predict the speed in each setting. Raises InputError outside the surrogate's domain."""
    names = tuple(parameter.prior.name for parameter in inputs.unknown.sampled)
    by_setting = []
    for setting in settings:
        scene, design = plate_scene(inputs.scene, setting), setting.design
        try:
            known = surrogate.case_in_domain(scene, design, mass_of(design), only_certain=False)
        except UnknownError as error:
            raise InputError(
                f"{design.name}, tilt {setting.tilt:g} deg: cannot be fitted without simulation ({error.text}). "
                "Add ‹model=›space, or leave this tilt out."
            ) from None
        by_setting.append(SurrogateSpeed(setting, known, names))
    return by_setting
