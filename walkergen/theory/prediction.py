"""Predicted speeds of walkers, with their bounds: design and scene in, table rows out.

A predicted speed is the median of a distribution: speeds of the model in space, from its stored
table, over what design and scene do not know exactly, from print to print, and with a structural
error of the model. Outside the table the theory stands in, within the error that it has there.
"""

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.files import words
from walkergen.scene import Scene
from walkergen.theory import standing, surrogate, uncertain
from walkergen.theory.speed import Mode
from walkergen.theory.stationary import Stationary, stationary
from walkergen.theory.surrogate import LINEAR_BELOW, UnknownError
from walkergen.theory.uncertain import PREDICTION, QUANTILES, Drawn, Input, Share
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, scaled

Array = npt.NDArray[np.float64]

DRAWS = 512
"""Number of draws behind a speed and its bounds: on a lattice the ends of 95 % err by 0.05 to 0.13
of a standard deviation, those of 68 % by 0.04 at most."""

SEED = 2016

PRINT = Input("which print it is", 0.0, 1.0, -np.inf)
"""Deviation of one print from the mean, and of the table's interpolation, over its standard one."""

MODEL = Input("the model itself", 0.0, 1.0, -np.inf)
"""Structural error of what predicts the speed, over its standard deviation."""

THEORY_SD = 0.75
"""Standard deviation of the theory where the table does not reach, over hypot(theory, a quarter of
the plate's speed): root mean square of what separates it from the table's flexible walkers, of
whom 1.96 of it hold 97 %. On average it runs 0.3 ahead of them, which is left in it."""

By = Literal["table", "theory", "statics", "runs"]
"""Source of a speed: the model in space by its table, the theory, statics where a walker stands, or runs
of the walker itself."""


class Speed(NamedTuple):
    """Speed with its error, all in mm/s; NaN where runs leave a number unknown."""

    value: float
    se: float
    """Standard error of a simulated mean; of a prediction its standard deviation."""
    low_95: float
    """Bounds that hold the speed with 95 %; that of another print, where runs share an orbit."""
    high_95: float
    orbit: str = ""
    """Name of what all runs end on, so that they tell no error: one periodic orbit, or at rest."""

    def __str__(self) -> str:
        if math.isnan(self.value):
            return "none"
        if self.orbit:
            return f"{self.value:.2f} mm/s, {self.orbit}{self._of_prints()}"
        if math.isnan(self.se):
            return f"{self.value:.2f} mm/s, standard error unknown"
        text = f"{words.with_error(self.value, self.se)} mm/s"
        if math.isnan(self.low_95) or math.isnan(self.high_95):
            return f"{text}, bounds unknown"
        return f"{text}, with 95 % {self.low_95:.1f} to {self.high_95:.1f}"

    def _of_prints(self) -> str:
        """Bounds of prints in words; "" where they are unknown."""
        if math.isnan(self.low_95):
            return ""
        return f"; 95 % of prints {self.low_95:.1f} to {self.high_95:.1f}"


def speed_of(
    value: float | None, se: float | None, low_95: float | None, high_95: float | None, orbit: str = ""
) -> Speed:
    """Speed of numbers of which None is unknown, all in mm/s."""
    four = [math.nan if number is None else float(number) for number in (value, se, low_95, high_95)]
    return Speed(four[0], four[1], four[2], four[3], orbit)


class Prediction(NamedTuple):
    """Row of the family's table; the field names are the CSV's columns, with units."""

    tilt_deg: float
    legs: str
    total_g: float
    """Mass of the whole walker, as a balance shows it, g."""
    M_g: float
    J_g_mm2: float
    m_g: float | None
    """Mass of the first free leg, g; None where all are braced and part of M."""
    j_g_mm2: float | None
    speed_mm_s: float
    """Median of the speed's distribution; of runs, their mean."""
    speed_sd_mm_s: float
    """Standard deviation of the distribution; of runs that of their mean, with their step's error.
    """
    speed_low_68_mm_s: float
    """Bounds that hold the speed with 68 and 95 %."""
    speed_high_68_mm_s: float
    speed_low_95_mm_s: float
    speed_high_95_mm_s: float
    speed_by: By
    theory_mm_s: float
    """Speed by the theory (the paper's eq. 15): factor_mean x impact speed."""
    factor_back: float
    """Stationary speed of the back foot by itself, over the impact speed; of more, the last one."""
    factor_front: float
    factor_mean: float
    """That of the walker: the mean of two equal feet, of unlike ones what balances them."""
    mode: str
    law: str
    note: str

    @property
    def speed(self) -> Speed:
        """Speed with its bounds; its `se` is the standard deviation of the distribution."""
        return Speed(self.speed_mm_s, self.speed_sd_mm_s, self.speed_low_95_mm_s, self.speed_high_95_mm_s)


class Spread(NamedTuple):
    """Draws of a walker's speed."""

    speed: Array
    """Speeds, mm/s, shape (n,)."""
    by: By
    stand_in: str = ""
    """What a plate in place of a motor leaves out, in words; "" where there is none."""
    outside: str = ""
    """Reason why no table holds this walker; "" where one does."""
    stands: str = ""
    """Reason why it stands; "" where it runs."""


def known_inputs(scene: Scene, design: Design) -> tuple[Input, ...]:
    """Inputs of a prediction: what is not known exactly, the print, and the model's own error."""
    return (*uncertain.inputs(scene, design, PREDICTION), PRINT, MODEL)


def spread(design: Design, mass: MassProperties, scene: Scene, mode: Mode, drawn: Drawn) -> Spread:
    """Speeds of a walker at values of `known_inputs`."""
    if stands := standing.reason(scene, design, mass):
        return Spread(np.zeros(drawn.number), "statics", stands=stands)
    pace, moment = surrogate.of_motor(scene, drawn)
    model = drawn.columns[MODEL.name]
    try:
        tabled = surrogate.of(scene, design, mass)
    except UnknownError as error:
        shaken = surrogate.shaken(scene, design, mass)
        plate = _paced(scene, shaken.swing, pace, moment)
        theory = theory_speeds(design, mass, scene, mode, drawn)
        unknown = math.hypot(THEORY_SD, shaken.error_sd)
        error_sd = unknown * np.hypot(theory, LINEAR_BELOW * plate)
        return Spread(theory + error_sd * model, "theory", shaken.note, str(error))
    speeds, sense = tabled.speeds(drawn), tabled.sense  # a mirror image has mirrored errors
    model_sd = math.hypot(scene.prediction.model_sd, tabled.error_sd)
    shifted = speeds._replace(centre=speeds.centre + sense * model_sd * model)
    plate = _paced(scene, tabled.swing, pace, moment)
    return Spread(plate * shifted.at(sense * drawn.columns[PRINT.name]), "table", tabled.note)


def _paced(scene: Scene, swing: float, pace: Array, moment: Array) -> float | Array:
    """Peak speeds of the swing (mm/s) at the draws of a motor; that of a plate."""
    return swing if scene.drive.kind == "plate" else swing * pace * moment


def theory_speeds(design: Design, mass: MassProperties, scene: Scene, mode: Mode, drawn: Drawn) -> Array:
    """Speeds by the theory at values of the inputs, mm/s, shape (count,)."""
    contact = scene.contact
    masses = scaled(mass, drawn.of("body mass", 1.0), surrogate.leg_masses(design, drawn))
    by_foot = stationary(
        design,
        masses,
        drawn.of("contact.restitution", contact.restitution),
        drawn.of("contact.friction", contact.friction),
        mode,
        contact.law,
        (contact.restitution, contact.friction),
    )
    pace, moment = surrogate.of_motor(scene, drawn)
    return np.asarray(by_foot.factor) * _impact_speed(scene, design, mass) * pace * moment


def _impact_speed(scene: Scene, design: Design, mass: MassProperties) -> float:
    """Normal speed w at which the theory's feet are assumed to meet the plate, mm/s."""
    shaken = surrogate.shaken(scene, design, mass).drive
    return scene.prediction.impact_speed_factor * shaken.peak_speed


def shares(design: Design, mass: MassProperties, scene: Scene, mode: Mode) -> tuple[Share, ...]:
    """Shares of the inputs in the variance behind a walker's bounds, largest total first."""
    inputs = known_inputs(scene, design)

    def speeds(values: Array) -> Array:
        return spread(design, mass, scene, mode, uncertain.named(inputs, values)).speed

    return uncertain.shares(inputs, speeds, SEED)


def drawn_inputs(scene: Scene, design: Design) -> Drawn:
    """Draws of `known_inputs` behind a speed and its bounds."""
    inputs = known_inputs(scene, design)
    return uncertain.named(inputs, uncertain.draws(inputs, DRAWS, SEED))


def predict(design: Design, mass: MassProperties, scene: Scene, mode: Mode = "coulomb") -> Prediction:
    """Predict the speed of one walker, and what the theory has for it (docs/physics.md section 4).

    `mode` is the theory's. Members of a family share their random numbers. Raises TheoryError when
    mode and law do not go together.
    """
    contact = scene.contact
    by_foot = stationary(design, mass, contact.restitution, contact.friction, mode, contact.law)
    speeds = spread(design, mass, scene, mode, drawn_inputs(scene, design))
    low95, low68, high68, high95 = np.quantile(speeds.speed, QUANTILES).tolist()
    free = next((leg for leg in mass.legs if leg.m > 0.0), None)
    theory = float(by_foot.factor) * _impact_speed(scene, design, mass)
    notes = [
        _outside(speeds),
        speeds.stand_in,
        by_foot.note,
        *_notes(by_foot, contact.friction, mode),
        "" if low95 <= theory <= high95 else LEAVES,
    ]
    notes = [speeds.stands] if speeds.stands else notes
    return Prediction(
        tilt_deg=design.tilt_deg,
        legs=design.kind,
        total_g=float(mass.total),
        M_g=float(mass.M),
        J_g_mm2=float(mass.J),
        m_g=None if free is None else float(free.m),
        j_g_mm2=None if free is None else float(free.j),
        speed_mm_s=float(np.median(speeds.speed)),
        speed_sd_mm_s=float(np.std(speeds.speed)),
        speed_low_68_mm_s=low68,
        speed_high_68_mm_s=high68,
        speed_low_95_mm_s=low95,
        speed_high_95_mm_s=high95,
        speed_by=speeds.by,
        theory_mm_s=theory,
        factor_back=float(by_foot.feet[0]),
        factor_front=float(by_foot.feet[-1]),
        factor_mean=float(by_foot.factor),
        mode=mode,
        law=contact.law,
        note="; ".join(filter(None, notes)),
    )


LEAVES = "the theory leaves the 95 % bounds of the model in space"
"""Note on a walker for which the theory of the paper does not do."""


def _outside(speeds: Spread) -> str:
    """Note on a speed that the table does not give."""
    if not speeds.outside:
        return ""
    return (
        f"by the theory alone, whose bounds are wide ({speeds.outside}); "
        "family --simulate puts the speed of runs in its place"
    )


def _notes(by_foot: Stationary, friction: float, mode: Mode) -> Iterator[str]:
    if friction == 0.0:
        yield "friction 0: every speed is stationary; the limit friction -> 0 is given"
        return
    stuck = [place for place, slides in enumerate(by_foot.reverses) if not slides]
    count = len(by_foot.reverses)
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


POINTS = 91
"""Points of a curve against tilt: of one from 0 to 45 deg, every half of a degree."""


class Curve(NamedTuple):
    """Predicted speed against tilt, for the figure; arrays of shape (k,)."""

    tilt_deg: Array
    speed: Array
    """Predicted speed, mm/s."""
    bounds: Array
    """Bounds at `QUANTILES`, shape (4, k), mm/s."""
    theory: Array
    """Speed by the theory, mm/s."""
    can_stick: npt.NDArray[np.bool_]
    """True where a foot can stick, so that the paper's eq. 15 fails."""


def curve(design: Design, scene: Scene, mode: Mode, low_deg: float, high_deg: float, count: int = POINTS) -> Curve:
    """Predict the speeds of a design's kind of legs over a fine range of `count` tilts.

    The walkers bear no marks, because these number a family's tilts only, not those in between.
    """
    drawn, contact = drawn_inputs(scene, design), scene.contact
    tilts = np.linspace(low_deg, high_deg, count)
    levels = (*QUANTILES, 0.5)
    quantiles, theory, sticks = [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        by_foot = stationary(variant, mass, contact.restitution, contact.friction, mode, contact.law)
        speeds = spread(variant, mass, scene, mode, drawn)
        quantiles.append(np.quantile(speeds.speed, levels))
        theory.append(float(by_foot.factor) * _impact_speed(scene, variant, mass))
        sticks.append(not all(by_foot.reverses))
    *bounds, middle = np.array(quantiles).T
    return Curve(tilts, middle, np.array(bounds), np.array(theory), np.array(sticks))
