"""Speeds of settings by the stored table over the parameters: what `predict` and `family` print.

Beside the parameters a row holds how uneven the printer's feet are and the errors of its masses,
which all prints of a file share.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.lab.fit.emulated import STILL, Ground, Setting, on_plate
from walkergen.lab.fit.parameters import SCATTER
from walkergen.theory import surrogate
from walkergen.theory.surrogate import LINEAR_BELOW, UnknownError
from walkergen.theory.uncertain import Drawn
from walkergen.walker import solids

Array = npt.NDArray[np.float64]


class Tabled(NamedTuple):
    """Speed of a setting over the parameters, by the table."""

    setting: Setting
    table: surrogate.Tabled
    inputs: tuple[str, ...]
    """Inputs in the order of the columns."""

    def __call__(self, x: Array) -> tuple[Array, Array, Array]:
        """Mean speed, its error that prints share, and the scatter between prints, (k,), mm/s.

        Shared are the errors of the interpolation and of the model itself, `prediction.model_sd`.
        """
        drawn = Drawn(dict(zip(self.inputs, x.T, strict=True)), len(x))
        pace, moment = surrogate.of_motor(self.table.scene, drawn)
        plate = self.setting.plate_speed * pace * moment
        speeds = self.table.speeds(drawn)
        slope = plate * LINEAR_BELOW * np.cosh(speeds.centre)
        interpolated = np.sqrt(np.maximum(speeds.sd**2 - speeds.between_prints**2, 0.0))
        model_sd = np.hypot(self.table.scene.prediction.model_sd, self.table.error_sd)
        mean = plate * speeds.at(np.zeros(len(x)))
        learnt = drawn.of(SCATTER, 0.0) * np.hypot(mean, STILL * plate)
        return (mean, slope * np.hypot(interpolated, model_sd), np.hypot(slope * speeds.between_prints, learnt))


def responses(ground: Ground, settings: Sequence[Setting]) -> list[Tabled]:
    """Speeds of every setting by the table. Raises InputError for those that it does not hold."""
    names = tuple(parameter.prior.name for parameter in ground.unknown.sampled)
    by_setting = []
    for setting in settings:
        scene, design = on_plate(ground.scene, setting), setting.design
        try:
            table = surrogate.of(scene, design, solids.mass_of(design))
        except UnknownError as error:
            raise InputError(
                f"{design.name}, tilt {setting.tilt:g} deg: {error}: learn from simulated speeds, "
                "--model space, or leave that tilt out"
            ) from None
        by_setting.append(Tabled(setting, table, names))
    return by_setting
