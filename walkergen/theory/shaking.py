"""Shaking: the plate that would move under a walker as its own motor moves it.

A rotor of moment S swings the body of a walker of mass M about its centre of mass by S/M, across
the rotor's axis. In the body's frame that is a plate that swings the other way (G. Cicconofri,
F. Becker, G. Noselli, A. DeSimone and K. Zimmermann, arXiv 1702.00343, for a vertical swing without
torque). Limits: an axis along the run, through the centre of mass. Across the run the plate would
also swing along it, as far, which no table and no theory here has (docs/physics.md section 8).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import Drive
from walkergen.errors import InputError
from walkergen.scene import Scene
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, from_centre
from walkergen.walker.payload import Motor

Array = npt.NDArray[np.float64]

FREQUENCY, MOMENT = "drive.frequency_hz", "drive.eccentric_g_mm"
"""Names of what is uncertain of a motor."""

ALONG_SD, ACROSS_SD = 0.25, 1.5
"""Standard errors, on the scale of `Prediction.model_sd`, of a plate in place of a motor whose axis
lies along the run, and of the swing along the run of any other: root mean squares found are 0.19
and 1.25 (tilts of 10 and 20 deg, pushes of 1.3, 1.8 and 3 weights, both senses)."""

LEVER_SD = 1.0
"""The same of a motor off the centre of mass, at as far as the walker's radius of gyration."""


class Shaken(NamedTuple):
    """Plate that stands for a drive."""

    drive: Drive
    """The plate's vertical vibration."""
    swing: float
    """Peak speed of the whole swing, mm/s: the plate's own, unless the axis leans."""
    error_sd: float
    """Standard error of the stand-in, on the scale of `Prediction.model_sd`; 0 of a plate."""
    note: str = ""
    """What the stand-in leaves out, in words."""


def motor_of(design: Design) -> Motor:
    """Motor that a walker carries. Raises InputError where there is none."""
    if design.motor is None:
        raise InputError(
            f"drive.kind = 'motor': {design.name} carries none; give its design a table [motor] "
            "with diameter_mm, height_mm and mass_g, or take the template coinbot"
        )
    return design.motor


def of(scene: Scene, design: Design, mass: MassProperties) -> Shaken:
    """Plate that stands for the drive of a walker. Raises InputError for one without a motor."""
    if scene.drive.kind == "plate":
        return Shaken(scene.drive, scene.drive.peak_speed, 0.0)
    motor, total = motor_of(design), float(mass.total)
    along, _, up = scene.drive.direction(motor.axis)
    whole = scene.drive.beneath(total)
    upright = max(math.sqrt(max(1.0 - up * up, 0.0)), 1e-6)
    drive = whole.model_copy(update={"amplitude_um": upright * (whole.amplitude_um or 0.0)})
    forward = math.sqrt(max(1.0 - along * along, 0.0))
    place = from_centre(design, mass, np.array([motor.along_mm, motor.up_mm])) - mass.centre
    lever = math.hypot(*place, motor.across_mm) / math.sqrt(float(mass.J) / float(mass.M))
    error = math.sqrt(ALONG_SD**2 + (ACROSS_SD * forward) ** 2 + (LEVER_SD * min(lever, 3.0)) ** 2)
    note = "by a plate that shakes as its motor does"
    if forward > 0.1:
        note += ", which leaves out that the motor pushes along the run too: bounds are wide"
    return Shaken(drive, whole.peak_speed, error, note)
