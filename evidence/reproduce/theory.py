"""Speeds by the paper's theory over tilts, with what contact and masses leave open."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from evidence.reproduce.runs import Assumption
from walkergen.core.numerics import Array, Mask
from walkergen.core.scene import Scene
from walkergen.core.theory import dimensionless, prediction, uncertain_inputs
from walkergen.core.theory.impact import Kind, resolve
from walkergen.core.theory.prediction import SEED
from walkergen.core.theory.speed import Mode, factor
from walkergen.core.theory.stationary import stationary_speed
from walkergen.core.theory.tensors import foot_tensors
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, scale_masses

DRAWS = 256
"""Number of draws behind a standard deviation, known to some per cent."""


class Curve(NamedTuple):
    """Speed by the theory against tilt; arrays of shape (91,)."""

    tilt_deg: Array
    speed: Array
    """Speed at the scene's impact speed, mm/s."""
    sd: Array
    """Standard deviation by contact, masses and print, mm/s."""
    can_stick: Mask
    """True where a foot can stick, so that eq. 15 fails."""


class Theory(NamedTuple):
    """Predicted curve of speed against tilt."""

    assumption: str
    mode: Mode
    curve: Curve
    impact_speed_factor: float
    """Impact speed over the plate's peak speed that the curve assumes."""
    type_three: float | None
    """Share of type III among impacts at the stationary speed, over tilts above 0 and both feet;
    None in mode paper, which assumes it."""

    @property
    def label(self) -> str:
        """Name of the curve in tables and legends."""
        return f"theory, {'eq. 15' if self.mode == 'paper' else 'feet may stick'}"


def predict_curve(design: Design, assumption: Assumption, mode: Mode, tilts_deg: Sequence[float]) -> Theory:
    """Theory of a design's flexible legs, between the first and the last of some tilts."""
    flexible, scene = design.variant(kind="flexible"), assumption.scene
    drawn = compute_curve(flexible, scene, mode, tilts_deg[0], tilts_deg[-1])
    third = None if mode == "paper" else share_of_type_three(flexible, scene, tilts_deg, mode)
    return Theory(assumption.name, mode, drawn, scene.prediction.impact_speed_factor, third)


def compute_curve(design: Design, scene: Scene, mode: Mode, low_deg: float, high_deg: float) -> Curve:
    """Speeds of a design's kind of legs over a fine range of tilts (91 points)."""
    inputs = uncertain_inputs.inputs(scene, design, uncertain_inputs.PREDICTION_READER)
    drawn = uncertain_inputs.label_columns(inputs, uncertain_inputs.sample_inputs(inputs, DRAWS, SEED))
    contact = scene.contact
    tilts = np.linspace(low_deg, high_deg, 91)
    speed, sd, sticks = [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        stationary_speeds = stationary_speed(variant, mass, contact.restitution, contact.friction, mode)
        speed.append(float(stationary_speeds.factor) * prediction.impact_speed(scene, mass))
        sd.append(float(theory_speeds(variant, mass, scene, mode, drawn).std()))
        sticks.append(not all(stationary_speeds.reverses))
    return Curve(tilts, np.array(speed), np.array(sd), np.array(sticks))


def theory_speeds(
    design: Design, mass: MassProperties, scene: Scene, mode: Mode, drawn: uncertain_inputs.Drawn
) -> Array:
    """Speeds by the theory at values of the inputs, mm/s, shape (count,)."""
    contact = scene.contact
    masses = scale_masses(mass, drawn.input_values("body mass", 1.0), dimensionless.leg_mass_ratios(design, drawn))
    by_foot = stationary_speed(
        design,
        masses,
        drawn.input_values("contact.restitution", contact.restitution),
        drawn.input_values("contact.friction", contact.friction),
        mode,
        (contact.restitution, contact.friction),
    )
    return np.asarray(by_foot.factor) * prediction.impact_speed(scene, mass)


def share_of_type_three(design: Design, scene: Scene, tilts_deg: Sequence[float], mode: Mode) -> float:
    """Share of type III among impacts at the stationary speed (see `Theory`)."""
    e, mu = scene.contact.restitution, scene.contact.friction
    kinds = []
    for tilt in tilts_deg:
        if tilt > 0.0:
            for H in foot_tensors(solids.mass_of(design.variant(tilt_deg=tilt))):
                v_x = float(factor(H, e, mu, mode))
                kinds.append(resolve((float(H.xx), float(H.xy), float(H.yy)), (v_x, -1.0), e, mu).kind)
    return kinds.count(Kind.III) / len(kinds)
