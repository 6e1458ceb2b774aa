"""Speeds by the paper's theory over tilts, with what contact and masses leave open."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.scene import Scene
from walkergen.theory import prediction, uncertain
from walkergen.theory.prediction import SEED
from walkergen.theory.speed import Mode
from walkergen.theory.stationary import stationary
from walkergen.walker import solids
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

DRAWS = 256
"""Number of draws behind a standard deviation, known to some per cent."""


class Curve(NamedTuple):
    """Speed by the theory against tilt; arrays of shape (91,)."""

    tilt_deg: Array
    speed: Array
    """Speed at the scene's impact speed, mm/s."""
    sd: Array
    """Standard deviation by contact, masses and print, mm/s."""
    can_stick: npt.NDArray[np.bool_]
    """True where a foot can stick, so that eq. 15 fails."""


def curve(design: Design, scene: Scene, mode: Mode, low_deg: float, high_deg: float) -> Curve:
    """Speeds of a design's kind of legs over a fine range of tilts (91 points)."""
    inputs = uncertain.inputs(scene, design, uncertain.PREDICTION)
    drawn = uncertain.named(inputs, uncertain.draws(inputs, DRAWS, SEED))
    contact = scene.contact
    tilts = np.linspace(low_deg, high_deg, 91)
    speed, sd, sticks = [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        stationary_speeds = stationary(variant, mass, contact.restitution, contact.friction, mode, contact.law)
        speed.append(float(stationary_speeds.factor) * scene.impact_speed)
        sd.append(float(prediction.theory_speeds(variant, mass, scene, mode, drawn).std()))
        sticks.append(not all(stationary_speeds.reverses))
    return Curve(tilts, np.array(speed), np.array(sd), np.array(sticks))
