"""Predicted speeds of walkers, with their bounds: design and scene in, table rows out.

A speed has two faces. *As designed* is the nominal run, what `simulate` gives. *As you will get it* is the median,
with bounds, over what design and scene do not know exactly, from print to print, and with a structural error of
the model. Here both come from the surrogate, or from statics where a walker stands; a walker that neither knows is
simulated (`points.speed_prediction`).
"""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.files import formatting
from walkergen.core.scene import Scene
from walkergen.core.theory import standing, surrogate, uncertain_inputs
from walkergen.core.theory.networks import Speeds
from walkergen.core.theory.speed import Mode
from walkergen.core.theory.stationary import Stationary, stationary
from walkergen.core.theory.surrogate import NORMAL_95, FallsError, Known, UnknownError
from walkergen.core.theory.uncertain_inputs import PREDICTION_READER, QUANTILES, Drawn, Input, Share
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

DRAW_COUNT = 256
"""Number of draws behind a speed and its bounds: on a lattice the ends of 95 % err by 0.07 to 0.19
of a standard deviation, those of 68 % by 0.06 at most."""

SEED = 2016

PRINT_INPUT = Input("which print it is", 0.0, 1.0, -np.inf)
"""Deviation of one print from the mean over its standard one."""

SURROGATE_INPUT = Input("the surrogate's error", 0.0, 1.0, -np.inf)
"""Error of the surrogate over its standard one."""

MODEL_INPUT = Input("the model itself", 0.0, 1.0, -np.inf)
"""Structural error of the model in space, over its standard deviation."""

By = Literal["surrogate", "corrected", "runs", "statics", "theory"]
"""Source of a speed: the surrogate of the model in space, the surrogate corrected by a few runs, or runs of the walker
and its prints; statics if it rests; "theory" if only theory was requested, and there is no speed."""


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
            return f"{self.value:.2f} mm/s, {self.orbit}{self._format_print_bounds()}"
        if math.isnan(self.se):
            return f"{self.value:.2f} mm/s, standard error unknown"
        text = f"{formatting.format_with_error(self.value, self.se)} mm/s"
        if math.isnan(self.low_95) or math.isnan(self.high_95):
            return f"{text}, bounds unknown"
        return f"{text}, with 95 % {self.low_95:.1f} to {self.high_95:.1f}"

    def _format_print_bounds(self) -> str:
        """Describe the bounds of prints; "" if they are unknown."""
        if math.isnan(self.low_95):
            return ""
        return f"; 95 % of prints {self.low_95:.1f} to {self.high_95:.1f}"


def make_speed(
    value: float | None, se: float | None, low_95: float | None, high_95: float | None, orbit: str = ""
) -> Speed:
    """Return the speed from numbers in mm/s; None is unknown."""
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
    nominal_mm_s: float | None
    """Speed as designed, of the nominal run. None, like the speeds below, if walkers fall or if only theory was
    requested."""
    nominal_low_95_mm_s: float | None
    """Bounds of the nominal speed, by the surrogate's error or the scatter of runs."""
    nominal_high_95_mm_s: float | None
    speed_mm_s: float | None
    """Expected speed of a print: median of the distribution over prints and the other uncertain inputs."""
    speed_sd_mm_s: float | None
    """Standard deviation of the distribution."""
    speed_low_68_mm_s: float | None
    """Bounds that hold the speed of a print with 68 and 95 %."""
    speed_high_68_mm_s: float | None
    speed_low_95_mm_s: float | None
    speed_high_95_mm_s: float | None
    speed_by: By
    falls: float
    """Share of the runs that end with the walker fallen over."""
    theory_mm_s: float
    """Speed by the theory (the paper's eq. 15): factor_mean x impact speed."""
    factor_back: float
    """Stationary speed of the back foot alone, over the impact speed; of several stationary speeds, the last one."""
    factor_front: float
    factor_mean: float
    """That of the walker: the mean of two equal feet, of unlike ones what balances them."""
    mode: str
    theory_note: str
    """Reason why the theory's speed differs from the paper's eq. 15; "" if it agrees, or nearly."""
    note: str
    """Remark on the speed."""

    @property
    def speed(self) -> Speed:
        """Speed with its bounds; its `se` is the standard deviation of the distribution."""
        return make_speed(self.speed_mm_s, self.speed_sd_mm_s, self.speed_low_95_mm_s, self.speed_high_95_mm_s)

    @property
    def has_theory_alone(self) -> bool:
        """Whether only the theory's speed was requested."""
        return self.speed_by == "theory" and not self.note and self.falls == 0.0


STANDING_MM_S = 1.0
"""Speed below which a walker stands, where zero lies within the error of its speed as designed."""

REPORTED_DIFFERENCE = 0.1
"""Relative difference between a walker's speeds above which both are reported."""


def is_standing(row: Prediction) -> bool:
    """Return whether a walker rests: by statics, or within the error of its speed."""
    nominal, low, high = row.nominal_mm_s, row.nominal_low_95_mm_s, row.nominal_high_95_mm_s
    if nominal is None or low is None or high is None:
        return False
    slow = abs(nominal) < STANDING_MM_S and abs(row.speed_mm_s or 0.0) < STANDING_MM_S
    return row.speed_by == "statics" or (slow and low <= 0.0 <= high)


def describe_briefly(row: Prediction) -> str:
    """Describe in a few words what a walker does: its speed, or that it stands, falls over or has no speed yet."""
    speed = row.speed_mm_s
    if row.has_theory_alone:
        return f"{formatting.format_fixed(row.theory_mm_s, 1)} mm/s (theory)"
    if speed is None:
        return "falls over" if row.falls > 0.0 else "no speed yet"
    if is_standing(row):
        return "stands"
    return f"{formatting.format_with_error(abs(speed), row.speed_sd_mm_s or 0.0)} mm/s{' back' if speed < 0.0 else ''}"


def describe_speed(row: Prediction) -> str:
    """Describe a walker's predicted speed for the person who prints it."""
    speed, nominal = row.speed_mm_s, row.nominal_mm_s
    if row.falls > 0.0:
        falls = f"falls over in {100.0 * row.falls:.0f} % of its runs"
    if row.has_theory_alone:
        return f"{formatting.format_fixed(row.theory_mm_s, 1)} mm/s in the paper's theory (eq. 15)"
    if speed is None or nominal is None:
        return falls if row.falls > 0.0 else f"no speed: {row.note}"
    if is_standing(row):
        return "stands" if row.speed_by == "statics" else f"stands: {_format_nominal(row)}"
    way = "runs backward, " if speed < 0.0 else ""
    text = f"{way}{formatting.format_with_error(abs(speed), row.speed_sd_mm_s or 0.0)} mm/s"
    text += f"; your print: {row.speed_low_95_mm_s:.1f} to {row.speed_high_95_mm_s:.1f} (95 %)"
    if abs(nominal - speed) > REPORTED_DIFFERENCE * abs(speed):
        text += f"; as designed {_format_nominal(row)}"
    return f"{text}; {falls}" if row.falls > 0.0 else text


def _format_nominal(row: Prediction) -> str:
    """Format the speed as designed with its 95 % bounds."""
    half = 0.5 * ((row.nominal_high_95_mm_s or 0.0) - (row.nominal_low_95_mm_s or 0.0))
    return f"{formatting.format_with_error(row.nominal_mm_s or 0.0, half)} mm/s"


class Spread(NamedTuple):
    """Speeds of a walker: as designed, and over draws of the uncertain inputs."""

    nominal_mm_s: float
    nominal_bounds: tuple[float, float]
    """Bounds of 95 % of it, mm/s."""
    median: float
    sd: float
    bounds: tuple[float, float, float, float]
    """Bounds at `QUANTILES`, mm/s."""
    by: By
    note: str = ""


def prediction_inputs(scene: Scene, design: Design) -> tuple[Input, ...]:
    """Return the inputs of a surrogate prediction: uncertain values, the print, and both models' errors."""
    return (*uncertain_inputs.inputs(scene, design, PREDICTION_READER), PRINT_INPUT, SURROGATE_INPUT, MODEL_INPUT)


def sample_speeds(known: Known, drawn: Drawn) -> Array:
    """Return the surrogate's speeds of a walker at values of `prediction_inputs`, mm/s, shape (n,)."""
    share = print_speeds(known, known.sample_speeds(drawn), drawn)
    return np.asarray(share + known.sign * model_error_sd(share, known.scene) * drawn.columns[MODEL_INPUT.name])


def print_speeds(known: Known, speeds: Speeds, drawn: Drawn, shift: Array | float = 0.0) -> Array:
    """Return speeds of prints without the model's error, mm/s, shape (n,); a mirror image has mirrored errors.

    `speeds` are those of the networks at the drawn inputs; `shift` moves all of them on the networks' scale.
    """
    columns = drawn.columns
    off = speeds.between_prints * columns[PRINT_INPUT.name] + speeds.error * columns[SURROGATE_INPUT.name]
    return known.peak_speed * speeds.speed_ratios(shift + known.sign * off)


def model_error_sd(speed: Array | float, scene: Scene) -> Array:
    """Return the structural error of the model in space at speeds, one standard deviation, mm/s."""
    return np.asarray(scene.prediction.model_sd * np.abs(speed))


def compute_spread(design: Design, mass: MassProperties, scene: Scene, drawn: Drawn | None = None) -> Spread:
    """Compute a walker's speeds by statics or the surrogate. Raises UnknownError if neither applies."""
    if stands := standing.standing_reason(scene, design, mass):
        return Spread(0.0, (0.0, 0.0), 0.0, 0.0, (0.0, 0.0, 0.0, 0.0), "statics", stands)
    known = surrogate.case_in_domain(scene, design, mass)
    speed, se = known.nominal
    draws = sample_speeds(known, drawn or sample_prediction_inputs(scene, design))
    low2, low1, high1, high2 = np.quantile(draws, QUANTILES).tolist()
    ends = speed - NORMAL_95 * se, speed + NORMAL_95 * se
    return Spread(speed, ends, float(np.median(draws)), float(np.std(draws)), (low2, low1, high1, high2), "surrogate")


def impact_speed(scene: Scene, mass: MassProperties) -> float:
    """Compute the normal speed w at which the theory's feet meet the plate, mm/s; a motor counts as a moving plate."""
    return scene.prediction.impact_speed_factor * scene.drive.equivalent_plate_drive(float(mass.total)).peak_speed


def variance_shares(design: Design, mass: MassProperties, scene: Scene) -> tuple[Share, ...]:
    """Return the shares of the inputs in the variance behind a walker's bounds, largest total first.

    Raises UnknownError for a walker that the surrogate does not know.
    """
    inputs, known = prediction_inputs(scene, design), surrogate.case_in_domain(scene, design, mass)
    return uncertain_inputs.variance_shares(
        inputs, lambda values: sample_speeds(known, uncertain_inputs.label_columns(inputs, values)), SEED
    )


def sample_prediction_inputs(scene: Scene, design: Design) -> Drawn:
    """Return the draws of `prediction_inputs` behind a speed and its bounds."""
    inputs = prediction_inputs(scene, design)
    return uncertain_inputs.label_columns(inputs, uncertain_inputs.sample_inputs(inputs, DRAW_COUNT, SEED))


def predict(design: Design, mass: MassProperties, scene: Scene, mode: Mode = "coulomb") -> Prediction:
    """Predict the speed of one walker, and what the theory has for it (docs/physics.md section 4).

    `mode` is the theory's. Members of a family share their random numbers. Raises UnknownError for a walker that
    is to be simulated, TheoryError for an unknown mode.
    """
    try:
        return make_row(design, mass, scene, mode, compute_spread(design, mass, scene))
    except FallsError as falling:
        return make_row(design, mass, scene, mode, None, falls=falling.chance)


def make_row(
    design: Design,
    mass: MassProperties,
    scene: Scene,
    mode: Mode,
    speeds: Spread | None,
    note: str = "",
    falls: float = 0.0,
) -> Prediction:
    """Make the row of a walker with these speeds, or none, and the results of the theory."""
    contact = scene.contact
    by_foot = stationary(design, mass, contact.restitution, contact.friction, mode)
    free = next((leg for leg in mass.legs if leg.m > 0.0), None)
    bounds = (None,) * 4 if speeds is None else speeds.bounds
    return Prediction(
        tilt_deg=design.tilt_deg,
        legs=design.kind,
        total_g=float(mass.total),
        M_g=float(mass.M),
        J_g_mm2=float(mass.J),
        m_g=None if free is None else float(free.m),
        j_g_mm2=None if free is None else float(free.j),
        nominal_mm_s=None if speeds is None else speeds.nominal_mm_s,
        nominal_low_95_mm_s=None if speeds is None else speeds.nominal_bounds[0],
        nominal_high_95_mm_s=None if speeds is None else speeds.nominal_bounds[1],
        speed_mm_s=None if speeds is None else speeds.median,
        speed_sd_mm_s=None if speeds is None else speeds.sd,
        speed_low_68_mm_s=bounds[1],
        speed_high_68_mm_s=bounds[2],
        speed_low_95_mm_s=bounds[0],
        speed_high_95_mm_s=bounds[3],
        speed_by="theory" if speeds is None else speeds.by,
        falls=falls,
        theory_mm_s=float(by_foot.factor) * impact_speed(scene, mass),
        factor_back=float(by_foot.feet[0]),
        factor_front=float(by_foot.feet[-1]),
        factor_mean=float(by_foot.factor),
        mode=mode,
        theory_note=by_foot.note or _theory_note(design, mass, scene, mode, by_foot),
        note=note or ("" if speeds is None else speeds.note),
    )


def _theory_note(design: Design, mass: MassProperties, scene: Scene, mode: Mode, by_foot: Stationary) -> str:
    """Return why the theory's speed is not that of eq. 15; "" where it is, within `REPORTED_DIFFERENCE`."""
    contact = scene.contact
    if contact.friction == 0.0:
        return "friction 0: every speed is stationary; the limit friction -> 0 is given"
    if all(by_foot.reverses):
        return ""
    other = stationary(design, mass, contact.restitution, contact.friction, "coulomb" if mode == "paper" else "paper")
    own, others = float(by_foot.factor), float(other.factor)
    if abs(own - others) <= REPORTED_DIFFERENCE * abs(own):
        return ""
    which = "sticking feet (mode coulomb) give" if mode == "paper" else "eq. 15, in which feet always slide, gives"
    return f"friction can hold the feet: {which} {formatting.format_fixed(others * impact_speed(scene, mass), 1)} mm/s"


CURVE_POINTS = 91
"""Points of a curve against tilt: of one from 0 to 45 deg, every half of a degree."""


class Curve(NamedTuple):
    """Predicted speed against tilt, for the figure; arrays of shape (k,)."""

    tilt_deg: Array
    speed: Array
    """Median speed, mm/s; NaN, as its bounds, where a walker is to be simulated."""
    bounds: Array
    """Bounds at `QUANTILES`, shape (4, k), mm/s."""
    nominal: Array
    """Speed as designed, mm/s."""
    theory: Array
    """Speed by the theory, mm/s."""
    can_stick: npt.NDArray[np.bool_]
    """True where a foot can stick, so that the paper's eq. 15 fails."""


def predict_curve(
    design: Design, scene: Scene, mode: Mode, low_deg: float, high_deg: float, count: int = CURVE_POINTS
) -> Curve:
    """Predict the speeds of a design's kind of legs over a fine range of `count` tilts.

    The walkers bear no marks, because these number a family's tilts only, not those in between.
    """
    drawn, contact = sample_prediction_inputs(scene, design), scene.contact
    tilts = np.linspace(low_deg, high_deg, count)
    speeds, theory, sticks = [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        by_foot = stationary(variant, mass, contact.restitution, contact.friction, mode)
        try:
            of_tilt = compute_spread(variant, mass, scene, drawn)
            speeds.append((of_tilt.nominal_mm_s, of_tilt.median, *of_tilt.bounds))
        except UnknownError:
            speeds.append((math.nan,) * 6)
        theory.append(float(by_foot.factor) * impact_speed(scene, mass))
        sticks.append(not all(by_foot.reverses))
    nominal, middle, *bounds = np.array(speeds).T
    return Curve(tilts, middle, np.array(bounds), nominal, np.array(theory), np.array(sticks))


def curve_from_rows(walkers: Sequence[tuple[Design, MassProperties, Prediction]], scene: Scene, mode: Mode) -> Curve:
    """Return the curve through walkers of similar tilts, from their own rows, in the order of their tilts."""
    speeds, sticks, contact = [], [], scene.contact
    for design, mass, row in sorted(walkers, key=lambda walker: walker[2].tilt_deg):
        by_foot = stationary(design, mass, contact.restitution, contact.friction, mode)
        own = row.nominal_mm_s, row.speed_mm_s, row.speed_low_95_mm_s, row.speed_low_68_mm_s
        ends = row.speed_high_68_mm_s, row.speed_high_95_mm_s
        known = row.speed_by in ("statics", "surrogate")
        speeds.append((row.tilt_deg, row.theory_mm_s, *((*own, *ends) if known else (math.nan,) * 6)))
        sticks.append(not all(by_foot.reverses))
    tilts, theory, nominal, middle, *bounds = np.array(speeds, dtype=float).T
    return Curve(tilts, middle, np.array(bounds), nominal, theory, np.array(sticks))
