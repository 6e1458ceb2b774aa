"""Predicted speeds of walkers, with their uncertainty: design and scene in, table rows out."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.scene import Scene
from walkergen.theory.speed import Factors, Mode, factors
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

DRAWS = 4096
"""Number of Monte-Carlo draws per speed band: its width is then known to 1.1 %."""

SEED = 2016


class Prediction(NamedTuple):
    """Row of the family's table; the field names are the CSV's columns, with units."""

    tilt_deg: float
    legs: str
    M_g: float
    J_g_mm2: float
    m_g: float | None
    """Mass of one leg, g; None for braced legs, which are part of M."""
    j_g_mm2: float | None
    factor_back: float
    factor_front: float
    factor_mean: float
    speed_mm_s: float
    speed_sd_mm_s: float
    """Standard deviation by those of restitution, friction, masses and impact speed."""
    mode: str
    law: str
    note: str


class Draws(NamedTuple):
    """Random samples of the uncertain quantities, each of shape (n,), shared by all members."""

    restitution: Array
    friction: Array
    body: Array
    """Mass of the body over its nominal value."""
    leg: Array
    """Mass of a leg over its nominal value."""
    impact_speed: Array
    """Speed at which feet meet the plate, mm/s."""


def draw(scene: Scene, mass_sd: float, count: int = DRAWS, seed: int = SEED) -> Draws:
    """Draw independent normal samples, drawing again where they leave the physical range."""
    contact, prediction = scene.contact, scene.prediction
    streams = iter(np.random.SeedSequence(seed).spawn(5))

    def normal(mean: float, sd: float, low: float, high: float = np.inf) -> Array:
        return _truncated_normal(np.random.default_rng(next(streams)), mean, sd, low, high, count)

    return Draws(
        normal(contact.restitution, contact.restitution_sd, 0.0, 1.0),
        normal(contact.friction, contact.friction_sd, 0.0),
        normal(1.0, mass_sd, 0.01),
        normal(1.0, mass_sd, 0.01),
        scene.drive.peak_speed
        * normal(prediction.impact_speed_factor, prediction.impact_speed_factor_sd, 0.0),
    )


def _truncated_normal(
    rng: np.random.Generator, mean: float, sd: float, low: float, high: float, count: int
) -> Array:
    values = rng.normal(mean, sd, count)
    # The mean lies within [low, high]: with sd <= 1 at least a sixth of the draws do so as well.
    while (outside := (values < low) | (values > high)).any():
        values[outside] = rng.normal(mean, sd, int(outside.sum()))
    return values


def speed_draws(mass: MassProperties, scene: Scene, draws: Draws, mode: Mode) -> Array:
    """Speeds of a walker (mm/s), one for every draw, shape (n,)."""
    varied = mass._replace(
        M=mass.M * draws.body, J=mass.J * draws.body, m=mass.m * draws.leg, j=mass.j * draws.leg
    )
    each = factors(varied, draws.restitution, draws.friction, mode, scene.contact.law)
    return each.mean * draws.impact_speed


def predict(
    design: Design,
    mass: MassProperties,
    scene: Scene,
    mode: Mode = "coulomb",
    draws: Draws | None = None,
) -> Prediction:
    """Predict the stationary speed of one walker (docs/physics.md section 4; paper eq. 15).

    speed = mean factor of both feet x impact speed; impact speed = impact_speed_factor x peak
    speed of the plate. `draws` can be shared between the members of a family. Raises TheoryError
    when mode and law do not go together.
    """
    if draws is None:
        draws = draw(scene, 0.01 * design.weighed.mass_sd_percent)
    contact = scene.contact
    each = factors(mass, contact.restitution, contact.friction, mode, contact.law)
    return Prediction(
        tilt_deg=design.legs.tilt_deg,
        legs=design.legs.kind,
        M_g=float(mass.M),
        J_g_mm2=float(mass.J),
        m_g=None if mass.rigid else float(mass.m),
        j_g_mm2=None if mass.rigid else float(mass.j),
        factor_back=float(each.back),
        factor_front=float(each.front),
        factor_mean=float(each.mean),
        speed_mm_s=float(each.mean) * scene.impact_speed,
        speed_sd_mm_s=float(np.std(speed_draws(mass, scene, draws, mode))),
        mode=mode,
        law=contact.law,
        note="; ".join(_notes(each, contact.friction, mode)),
    )


def _notes(each: Factors, friction: float, mode: Mode) -> Iterator[str]:
    if friction == 0.0:
        yield "friction 0: every speed is stationary; the limit friction -> 0 is given"
        return
    reverses = {"back": bool(each.reverses_back), "front": bool(each.reverses_front)}
    stuck = [foot for foot, slides in reverses.items() if not slides]
    if not stuck:
        return
    feet = "both feet" if len(stuck) == 2 else f"the {stuck[0]} foot"
    if mode == "paper":
        yield f"eq. 15 fails: {feet} would stick, not slide back"
    else:
        yield f"{feet} can stick, where the paper's eq. 15 fails"


class Curve(NamedTuple):
    """Predicted speed against tilt, for the figure; arrays of shape (181,)."""

    tilt_deg: Array
    speed: Array
    """Predicted speed, mm/s."""
    sd: Array
    """Standard deviation of the speed, mm/s."""
    can_stick: npt.NDArray[np.bool_]
    """True where a foot can stick, so that the paper's eq. 15 fails."""


def curve(design: Design, scene: Scene, mode: Mode, low_deg: float, high_deg: float) -> Curve:
    """Predict the speeds of a design's kind of legs over a fine range of tilts (181 points).

    The walkers bear no marks, because these number a family's tilts only, not those in between.
    """
    draws = draw(scene, 0.01 * design.weighed.mass_sd_percent)
    contact = scene.contact
    tilts = np.linspace(low_deg, high_deg, 181)
    speed, sd, sticks = [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        each = factors(mass, contact.restitution, contact.friction, mode, contact.law)
        speed.append(float(each.mean) * scene.impact_speed)
        sd.append(float(np.std(speed_draws(mass, scene, draws, mode))))
        sticks.append(not (each.reverses_back and each.reverses_front))
    return Curve(tilts, np.array(speed), np.array(sd), np.array(sticks))
