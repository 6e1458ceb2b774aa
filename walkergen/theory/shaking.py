"""Shaking: the plate that would move under a walker as its own motor moves it.

A rotor of moment S swings the body of a walker of mass M about its centre of mass by S/M, across
the rotor's axis. In the body's frame that is a plate that swings the other way (G. Cicconofri,
F. Becker, G. Noselli, A. DeSimone and K. Zimmermann, arXiv 1702.00343, for a vertical swing without
torque). Limits: an axis along the run, through the centre of mass. Across the run the plate would
also swing along it, as far, which no table and no theory here has (docs/physics.md section 8).
"""

import math

import numpy as np

from walkergen.scene import Scene
from walkergen.theory.surrogate import Shaken
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, from_centre

ALONG_SD = 0.25
"""Standard error, on the scale of `Prediction.model_sd`, of a plate in place of a motor whose axis
lies along the run, in the centre of mass; this and the next are root mean squares of the model in
space (tilts of 5 to 20 deg, 90 Hz, both senses; docs/physics.md section 8)."""

PUSHES = (1.3, 1.8, 2.4)
"""Pushes over the weight at which the next were found, of ends that hold beyond."""

ACROSS_SDS = (1.8, 1.0, 0.1)
"""The same of the swing along the run of a motor whose axis lies across it, besides."""

UPRIGHT_SD, UPRIGHT_DEG = 1.8, 5.0
"""The same without tilt, where that swing alone makes a walker run; it ends at this tilt."""

LEVER_SDS = (4.0, 1.5, 1.5)
"""The same of a motor as far off the centre of mass as the body's radius of gyration, besides."""

MOST_SD = 5.0
"""Largest standard error: bounds of a hundred times the plate's speed say that nothing is known."""

WIDE = 0.5
"""Standard error beyond which a prediction says what the plate leaves out."""


def of(scene: Scene, design: Design, mass: MassProperties) -> Shaken:
    """Plate that stands for the motor of a walker. Raises InputError for one without a motor."""
    motor, total = design.driving_motor(), float(mass.total)
    along, _, up = scene.drive.direction(motor.axis)
    whole = scene.drive.beneath(total)
    lift = max(math.sqrt(max(1.0 - up * up, 0.0)), 1e-6)
    drive = whole.model_copy(update={"amplitude_um": lift * (whole.amplitude_um or 0.0)})
    forward = math.sqrt(max(1.0 - along * along, 0.0))
    place = from_centre(design, mass, np.array([motor.along_mm, motor.up_mm])) - mass.centre
    lever = math.hypot(*place, motor.across_mm) / math.sqrt(float(mass.J) / float(mass.M))
    across, off = (float(np.interp(whole.peak_gamma, PUSHES, sds)) for sds in (ACROSS_SDS, LEVER_SDS))
    upright = max(1.0 - abs(design.tilt_deg) / UPRIGHT_DEG, 0.0)
    across, off = forward * max(across, UPRIGHT_SD * upright), lever * off
    left_out = [
        words for words, error in (("its push along the run", across), ("that it turns the body", off)) if error > WIDE
    ]
    note = "by a plate that shakes as its motor does"
    if left_out:
        note += f", which leaves out {' and '.join(left_out)}: bounds are wide"
    error_sd = math.sqrt(ALONG_SD**2 + across**2 + off**2)
    return Shaken(drive, whole.peak_speed, min(error_sd, MOST_SD), note)
