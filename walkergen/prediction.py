"""Predicted speeds of walkers, with their uncertainty: design and scene in, table rows out.

Bounds hold what design and scene do not know exactly, the impact speed, and the theory's own error:
the truth is taken to lie at theory + t (model in space - theory), t normal with mean 1/2 and
standard deviation 1/2, so that theory and model in space stand one deviation to either side.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen import discrepancy, uncertain
from walkergen.discrepancy import UnknownError
from walkergen.scene import Scene
from walkergen.theory.speed import Mode
from walkergen.theory.stationary import Stationary, stationary
from walkergen.uncertain import QUANTILES, THEORY, Input, Share
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, scaled

Array = npt.NDArray[np.float64]

DRAWS, CURVE_DRAWS = 1024, 256
"""Numbers of draws behind the bounds of a row and of a curve: a 95 % bound is then known to about
a tenth and a fifth of a standard deviation by random numbers, and better by Sobol's."""

SEED = 2016

BETWEEN = Input("the theory itself", 0.5, 0.5, -np.inf)
"""Place of the truth between theory (0) and model in space (1)."""

PRINT = Input("which print it is", 0.0, 1.0, -np.inf)
"""Deviation of one print from the mean, and of the table's interpolation, over its standard one."""


class Prediction(NamedTuple):
    """Row of the family's table; the field names are the CSV's columns, with units."""

    tilt_deg: float
    legs: str
    M_g: float
    J_g_mm2: float
    m_g: float | None
    """Mass of the first free leg, g; None where all are braced and part of M."""
    j_g_mm2: float | None
    factor_back: float
    """Stationary speed of the back foot by itself, over the impact speed; of more, the last one."""
    factor_front: float
    factor_mean: float
    """That of the walker: the mean of two equal feet, of unlike ones what balances them."""
    speed_mm_s: float
    speed_sd_mm_s: float
    """Standard deviation by what design and scene do not know exactly, and by the impact speed."""
    speed_low_68_mm_s: float | None
    """Bounds that hold the speed with 68 and 95 %, the theory's own error included; None where that
    is unknown, as the note then says."""
    speed_high_68_mm_s: float | None
    speed_low_95_mm_s: float | None
    speed_high_95_mm_s: float | None
    mode: str
    law: str
    note: str


class Spread(NamedTuple):
    """Draws of a walker's speed, mm/s, each of shape (n,)."""

    theory: Array
    """Speeds by the theory, at drawn inputs and impact speeds."""
    all: Array | None
    """Speeds with the theory's own error; None where it is unknown."""
    unknown: str = ""
    """Reason why it is unknown; "" when it is known."""


def known_inputs(scene: Scene, design: Design) -> tuple[Input, ...]:
    """Inputs of the bounds: those that the theory or its own error reads, and that error."""
    return (*uncertain.inputs(scene, design, THEORY), BETWEEN, PRINT)


def spread(
    design: Design,
    mass: MassProperties,
    scene: Scene,
    mode: Mode,
    known: Sequence[Input],
    values: Array,
) -> Spread:
    """Speeds of a walker at values of `known_inputs`, shape (n, inputs)."""
    drawn = {one.name: values[:, place] for place, one in enumerate(known)}
    contact, nominal_thickness = scene.contact, design.limbs[0].thickness
    ones = np.ones(len(values))
    restitution = drawn.get("contact.restitution", contact.restitution * ones)
    friction = drawn.get("contact.friction", contact.friction * ones)
    thickness = drawn.get("legs.thickness_mm", nominal_thickness * ones) / nominal_thickness
    # A leg's mass goes with its thickness unless a balance told it.
    weight = thickness if design.weighed.leg_mass_g is None else ones
    leg = drawn.get("leg mass", ones) * weight
    body = drawn.get("body mass", ones)
    drawn_mass = scaled(mass, body, leg)
    known_as = contact.restitution, contact.friction
    each = stationary(design, drawn_mass, restitution, friction, mode, contact.law, known_as)
    nominal = scene.prediction.impact_speed_factor
    w = drawn.get("prediction.impact_speed_factor", nominal * ones) * scene.drive.peak_speed
    theory = np.asarray(each.factor) * w
    modulus = design.material.youngs_modulus_gpa
    stiffness = drawn.get("material.youngs_modulus_gpa", modulus * ones) / modulus
    unevenness = drawn.get("feet.unevenness_um", scene.feet.unevenness_um * ones)
    try:
        place = discrepancy.place_of(scene, design, mass)
        discrepancy.check(scene, place, design.braced)
    except UnknownError as error:
        return Spread(theory, None, str(error))
    places = place._replace(
        restitution=restitution,
        log_friction=np.log(np.maximum(friction, 1e-9)),
        log_hinge_ratio=place.log_hinge_ratio + np.log(thickness * np.sqrt(stiffness)),
        log_mass_ratio=place.log_mass_ratio + np.log(leg / body),
        unevenness_ratio=1e-3 * unevenness / scene.drive.amplitude,
    )
    found = discrepancy.speeds(places, design.tilt_deg, design.braced).at(drawn[PRINT.name])
    share = drawn[BETWEEN.name]
    return Spread(theory, (1.0 - share) * theory + share * scene.drive.peak_speed * found)


def shares(design: Design, mass: MassProperties, scene: Scene, mode: Mode) -> tuple[Share, ...]:
    """Shares of the inputs in the variance behind a walker's bounds, largest total first.

    Without the theory's own error where that is unknown.
    """
    known = known_inputs(scene, design)

    def speeds(values: Array) -> Array:
        found = spread(design, mass, scene, mode, known, values)
        return found.theory if found.all is None else found.all

    return uncertain.shares(known, speeds, SEED)


def predict(
    design: Design, mass: MassProperties, scene: Scene, mode: Mode = "coulomb"
) -> Prediction:
    """Predict the stationary speed of one walker (docs/physics.md section 4; paper eq. 15).

    speed = mean factor of both feet x impact speed; impact speed = impact_speed_factor x peak
    speed of the plate. Members of a family share their random numbers. Raises TheoryError
    when mode and law do not go together.
    """
    contact = scene.contact
    each = stationary(design, mass, contact.restitution, contact.friction, mode, contact.law)
    known = known_inputs(scene, design)
    found = spread(design, mass, scene, mode, known, uncertain.draws(known, DRAWS, SEED))
    bounds = [None] * 4 if found.all is None else np.quantile(found.all, QUANTILES).tolist()
    free = next((leg for leg in mass.legs if leg.m > 0.0), None)
    notes = [each.note, *_notes(each, contact.friction, mode), found.unknown]
    return Prediction(
        tilt_deg=design.tilt_deg,
        legs=design.kind,
        M_g=float(mass.M),
        J_g_mm2=float(mass.J),
        m_g=None if free is None else float(free.m),
        j_g_mm2=None if free is None else float(free.j),
        factor_back=float(each.feet[0]),
        factor_front=float(each.feet[-1]),
        factor_mean=float(each.factor),
        speed_mm_s=float(each.factor) * scene.impact_speed,
        speed_sd_mm_s=float(np.std(found.theory)),
        speed_low_68_mm_s=bounds[1],
        speed_high_68_mm_s=bounds[2],
        speed_low_95_mm_s=bounds[0],
        speed_high_95_mm_s=bounds[3],
        mode=mode,
        law=contact.law,
        note="; ".join(filter(None, notes)),
    )


def _notes(each: Stationary, friction: float, mode: Mode) -> Iterator[str]:
    if friction == 0.0:
        yield "friction 0: every speed is stationary; the limit friction -> 0 is given"
        return
    stuck = [place for place, slides in enumerate(each.reverses) if not slides]
    count = len(each.reverses)
    if not stuck:
        return
    if len(stuck) == count:
        feet = "both feet" if count == 2 else "all feet"
    else:
        feet = f"the {('back', 'front')[stuck[0]]} foot" if count == 2 else f"{len(stuck)} feet"
    if mode == "paper":
        yield f"eq. 15 fails: {feet} would stick, not slide back"
    else:
        yield f"{feet} can stick, where the paper's eq. 15 fails"


class Curve(NamedTuple):
    """Predicted speed against tilt, for the figure; arrays of shape (91,)."""

    tilt_deg: Array
    speed: Array
    """Predicted speed, mm/s."""
    sd: Array
    """Standard deviation of the speed by its inputs, mm/s."""
    bounds: Array
    """Bounds at `QUANTILES`, shape (4, 91), mm/s; NaN where the theory's own error is unknown."""
    can_stick: npt.NDArray[np.bool_]
    """True where a foot can stick, so that the paper's eq. 15 fails."""


def curve(design: Design, scene: Scene, mode: Mode, low_deg: float, high_deg: float) -> Curve:
    """Predict the speeds of a design's kind of legs over a fine range of tilts (91 points).

    The walkers bear no marks, because these number a family's tilts only, not those in between.
    """
    known = known_inputs(scene, design)
    values = uncertain.draws(known, CURVE_DRAWS, SEED)
    contact = scene.contact
    tilts = np.linspace(low_deg, high_deg, 91)
    speed, sd, bounds, sticks = [], [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        each = stationary(variant, mass, contact.restitution, contact.friction, mode, contact.law)
        found = spread(variant, mass, scene, mode, known, values)
        speed.append(float(each.factor) * scene.impact_speed)
        sd.append(float(np.std(found.theory)))
        unknown = np.full(len(QUANTILES), np.nan)
        bounds.append(unknown if found.all is None else np.quantile(found.all, QUANTILES))
        sticks.append(not all(each.reverses))
    return Curve(tilts, np.array(speed), np.array(sd), np.array(bounds).T, np.array(sticks))
