"""Predicted speeds of walkers, with their bounds: design and scene in, table rows out.

Each walker has two speeds. *As designed* is the nominal run, as from `simulate`. *As you will get it* is the median
over prints, over the uncertain inputs of design and scene, and over the structural error of the model, with bounds.
Both come from the surrogate, or from statics if the walker rests. Other walkers are simulated
(`points.speed_prediction`).
"""

import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.files import formatting
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.theory import surrogate, uncertain_inputs
from walkergen.core.theory.networks import Speeds
from walkergen.core.theory.speed import Mode
from walkergen.core.theory.stationary import Stationary, standing_reason, stationary_speed
from walkergen.core.theory.surrogate import NORMAL_95, FallsError, SurrogateCase, UnknownError
from walkergen.core.theory.uncertain_inputs import PREDICTION_READER, QUANTILES, Drawn, Input, Share
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

DRAW_COUNT = 256
"""Number of draws for a speed and its bounds. On a lattice the errors of 95 % bounds are 0.07 to 0.19 of a standard
deviation, those of 68 % bounds 0.06 at most."""

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

Bounds = tuple[float, float, float, float]
"""Lower bounds of a speed of 95 and 68 %, then upper bounds of 68 and 95 %, mm/s, as `QUANTILES` orders them."""

BOUND_LEVELS = {"nominal": (95,), "speed": (68, 95)}
"""Bounds of each speed that tables show, %."""


class PredictedSpeed(NamedTuple):
    """Speed of a walker: as designed, and over prints and the other uncertain inputs."""

    nominal: Quantity
    """Speed as designed, with the surrogate's error or the scatter of runs."""
    speed: Quantity
    """Median over prints; its error is the standard deviation of the distribution."""
    by: By
    note: str = ""


def make_speed(key: str, value: float, sd: float, ends: Bounds) -> Quantity:
    """Return a speed as a quantity called `key`: value, standard deviation and bounds `ends`, all in mm/s."""
    return Quantity(key, "mm_s", value, sd, ends=ends)


class Prediction(NamedTuple):
    """Prediction for one walker; `columns` gives the row of the family's table."""

    tilt_deg: float
    legs: str
    total_g: float
    """Mass of the whole walker, as a balance shows it, g."""
    M_g: float
    J_g_mm2: float
    m_g: float | None
    """Mass of the first free leg, g; None where all are braced and part of M."""
    j_g_mm2: float | None
    nominal: Quantity
    """Speed as designed, of the nominal run, with the surrogate's error or the scatter of runs. Without a value, like
    the speed below, if the walker falls or if only theory was requested."""
    speed: Quantity
    """Expected speed of a print: median of the distribution over prints and the other uncertain inputs. Its error is
    the standard deviation of that distribution."""
    speed_by: By
    falls: float
    """Share of the runs that end with the walker fallen over."""
    theory_mm_s: float
    """Speed by the theory (the paper's eq. 15): factor_mean x impact speed."""
    factor_back: float
    """Stationary speed of the back foot alone, over the impact speed; of several stationary speeds, the last one."""
    factor_front: float
    factor_mean: float
    """Factor of the walker: the mean of two equal feet, or the balance of unlike feet."""
    mode: str
    theory_note: str
    """Reason why the theory's speed differs from the paper's eq. 15; "" if it agrees, or nearly."""
    note: str
    """Remark on the speed."""

    def columns(self) -> dict[str, Any]:
        """Return all numbers by the columns of a table, with units in their names.

        Returns
        -------
        dict
            Values by the columns of family.csv and of the JSON.
        """
        found: dict[str, Any] = {}
        for name, value in self._asdict().items():
            found |= value.row(*BOUND_LEVELS[name]) if isinstance(value, Quantity) else {name: value}
        del found["nominal_se_mm_s"]
        return {name.replace("speed_se", "speed_sd"): value for name, value in found.items()}

    @property
    def has_theory_alone(self) -> bool:
        """Whether only the theory's speed was requested."""
        return self.speed_by == "theory" and not self.note and self.falls == 0.0


STANDING_MM_S = 1.0
"""Speed below which a walker stands, where zero lies within the error of its speed as designed."""

REPORTED_DIFFERENCE = 0.1
"""Relative difference between a walker's speeds above which both are reported."""


def is_standing(row: Prediction) -> bool:
    """Return whether a walker rests: by statics, or slower than STANDING_MM_S with zero within its speed's bounds."""
    ends = row.nominal.interval()
    if ends is None:
        return False
    slow = abs(row.nominal.number) < STANDING_MM_S and abs(row.speed.value or 0.0) < STANDING_MM_S
    return row.speed_by == "statics" or (slow and ends[0] <= 0.0 <= ends[1])


def describe_briefly(row: Prediction) -> str:
    """Describe in a few words what a walker does: its speed, or that it stands, falls over or has no speed yet."""
    speed = row.speed.value
    if row.has_theory_alone:
        return f"{formatting.format_fixed(row.theory_mm_s, 1)} mm/s (theory)"
    if speed is None:
        return "falls over" if row.falls > 0.0 else "no speed yet"
    if is_standing(row):
        return "stands"
    return f"{formatting.format_with_error(abs(speed), row.speed.se or 0.0)} mm/s{' back' if speed < 0.0 else ''}"


def describe_speed(row: Prediction) -> str:
    """Describe a walker's predicted speed in a line: of a printed copy, with bounds, and of the walker as designed."""
    speed, nominal = row.speed.value, row.nominal.value
    if row.falls > 0.0:
        falls = f"falls over in {100.0 * row.falls:.0f} % of its runs"
    if row.has_theory_alone:
        return f"{formatting.format_fixed(row.theory_mm_s, 1)} mm/s in the paper's theory (eq. 15)"
    if speed is None or nominal is None:
        return falls if row.falls > 0.0 else f"no speed: {row.note}"
    if is_standing(row):
        return "stands" if row.speed_by == "statics" else f"stands: {_format_nominal(row)}"
    way = "runs backward, " if speed < 0.0 else ""
    text = f"{way}{formatting.format_with_error(abs(speed), row.speed.se or 0.0)} mm/s"
    text += f"; your print: {row.speed.low_95:.1f} to {row.speed.high_95:.1f} (95 %)"
    if abs(nominal - speed) > REPORTED_DIFFERENCE * abs(speed):
        text += f"; as designed {_format_nominal(row)}"
    return f"{text}; {falls}" if row.falls > 0.0 else text


def _format_nominal(row: Prediction) -> str:
    """Format the speed as designed with half the width of its 95 % bounds."""
    return f"{formatting.format_with_error(row.nominal.number, row.nominal.half_width())} mm/s"


def prediction_inputs(scene: Scene, design: Design) -> tuple[Input, ...]:
    """Return the random inputs of a prediction: uncertain keys, scatter of prints, errors of surrogate and model."""
    return (*uncertain_inputs.inputs(scene, design, PREDICTION_READER), PRINT_INPUT, SURROGATE_INPUT, MODEL_INPUT)


def speeds_with_errors(case: SurrogateCase, drawn: Drawn) -> Array:
    """Return the walker's speed (mm/s), with all errors, for each of n draws of `prediction_inputs`, shape (n,)."""
    speeds = speeds_of_prints(case, case.speeds_at_draws(drawn), drawn)
    return np.asarray(speeds + case.sign * model_error_sd(speeds, case.scene) * drawn.columns[MODEL_INPUT.name])


def speeds_of_prints(case: SurrogateCase, speeds: Speeds, drawn: Drawn, shift: Array | float = 0.0) -> Array:
    """Return the speeds of n printed walkers at `drawn` inputs, without the model's error, mm/s, shape (n,).

    `speeds` are the outputs of the surrogate's networks at the drawn inputs. `shift` is added to them on the networks'
    scale. The mirror image of a walker has mirrored errors.
    """
    columns = drawn.columns
    deviation = speeds.between_prints * columns[PRINT_INPUT.name] + speeds.error * columns[SURROGATE_INPUT.name]
    return case.peak_speed * speeds.speed_ratios(shift + case.sign * deviation)


def model_error_sd(speed: Array | float, scene: Scene) -> Array:
    """Return the standard deviation of the model's structural error at `speed`, both in mm/s and of one shape."""
    return np.asarray(scene.prediction.model_sd * np.abs(speed))


def compute_speed(design: Design, mass: MassProperties, scene: Scene, drawn: Drawn | None = None) -> PredictedSpeed:
    """Compute a speed: 0 by statics, else by the surrogate at `drawn` inputs. Raises UnknownError outside both."""
    if reason := standing_reason(scene, design, mass):
        rest = make_speed("nominal", 0.0, 0.0, (0.0, 0.0, 0.0, 0.0))
        return PredictedSpeed(rest, rest._replace(key="speed"), "statics", reason)
    case = surrogate.case_in_domain(scene, design, mass)
    speed, se = case.nominal
    draws = speeds_with_errors(case, drawn or sample_prediction_inputs(scene, design))
    low2, low1, high1, high2 = np.quantile(draws, QUANTILES).tolist()
    nominal = make_speed("nominal", speed, se, (speed - NORMAL_95 * se, speed - se, speed + se, speed + NORMAL_95 * se))
    prints = make_speed("speed", float(np.median(draws)), float(np.std(draws)), (low2, low1, high1, high2))
    return PredictedSpeed(nominal, prints, "surrogate")


def impact_speed(scene: Scene, mass: MassProperties) -> float:
    """Compute the normal speed w at which the theory's feet meet the plate, mm/s; a motor counts as a moving plate."""
    return scene.prediction.impact_speed_factor * scene.drive.equivalent_plate_drive(float(mass.total)).peak_speed


def variance_shares(design: Design, mass: MassProperties, scene: Scene) -> tuple[Share, ...]:
    """Return the shares of the inputs in the variance of a walker's speed, largest total first.

    Raises UnknownError for a walker outside the surrogate's domain.
    """
    inputs, case = prediction_inputs(scene, design), surrogate.case_in_domain(scene, design, mass)
    return uncertain_inputs.variance_shares(
        inputs, lambda values: speeds_with_errors(case, uncertain_inputs.label_columns(inputs, values)), SEED
    )


def sample_prediction_inputs(scene: Scene, design: Design) -> Drawn:
    """Draw DRAW_COUNT values of each of the `prediction_inputs`, with a fixed seed: the same in every call."""
    inputs = prediction_inputs(scene, design)
    return uncertain_inputs.label_columns(inputs, uncertain_inputs.sample_inputs(inputs, DRAW_COUNT, SEED))


def predict(design: Design, mass: MassProperties, scene: Scene, mode: Mode = "coulomb") -> Prediction:
    """Predict the speed of one walker with the surrogate or statics, and with the paper's theory.

    Parameters
    ----------
    design : Design
        Design of the walker.
    mass : MassProperties
        Its masses, from `mass_of`.
    scene : Scene
        Drive, plate and contact.
    mode : {"coulomb", "paper"}, default: "coulomb"
        Theory: feet may stick, or always slip as in the paper's eq. 15.

    Returns
    -------
    Prediction
        Speeds with bounds, mm/s, masses, g, and the factors of the theory.

    Raises
    ------
    UnknownError
        If the surrogate's error is too large for this walker. Simulate it instead.
    TheoryError
        If the mode is unknown.

    Notes
    -----
    The surrogate is used where its error is at most 10 % or 1 mm/s, inside the ranges of its training set. Members of
    a family share their random numbers.

    References
    ----------
    docs/physics.md section 4; N. Koumakis et al., New Journal of Physics 18 (2016) 113046, eq. 15.

    Examples
    --------
    >>> from walkergen.core import Design, Scene, mass_of, predict
    >>> design = Design()
    >>> print(predict(design, mass_of(design), Scene()).speed)
    51 ± 11 mm/s, with 95 % 33.6 to 73.8
    """
    try:
        return make_row(design, mass, scene, mode, compute_speed(design, mass, scene))
    except FallsError as falling:
        return make_row(design, mass, scene, mode, None, falls=falling.chance)


def make_row(
    design: Design,
    mass: MassProperties,
    scene: Scene,
    mode: Mode,
    speed: PredictedSpeed | None,
    note: str = "",
    falls: float = 0.0,
) -> Prediction:
    """Return a walker's prediction from its speed (or None), a remark on it, and the share of runs that fall over."""
    contact = scene.contact
    by_foot = stationary_speed(design, mass, contact.restitution, contact.friction, mode)
    free_leg = next((leg for leg in mass.legs if leg.m > 0.0), None)
    missing = Quantity("nominal", "mm_s", None)
    nominal, prints = (missing, missing._replace(key="speed")) if speed is None else (speed.nominal, speed.speed)
    return Prediction(
        tilt_deg=design.tilt_deg,
        legs=design.kind,
        total_g=float(mass.total),
        M_g=float(mass.M),
        J_g_mm2=float(mass.J),
        m_g=None if free_leg is None else float(free_leg.m),
        j_g_mm2=None if free_leg is None else float(free_leg.j),
        nominal=nominal,
        speed=prints,
        speed_by="theory" if speed is None else speed.by,
        falls=falls,
        theory_mm_s=float(by_foot.factor) * impact_speed(scene, mass),
        factor_back=float(by_foot.feet[0]),
        factor_front=float(by_foot.feet[-1]),
        factor_mean=float(by_foot.factor),
        mode=mode,
        theory_note=by_foot.note or _theory_note(design, mass, scene, mode, by_foot),
        note=note or ("" if speed is None else speed.note),
    )


def _theory_note(design: Design, mass: MassProperties, scene: Scene, mode: Mode, by_foot: Stationary) -> str:
    """Return a remark: on zero friction, or on the other mode's speed if it differs by REPORTED_DIFFERENCE; else ""."""
    contact = scene.contact
    if contact.friction == 0.0:
        return "friction 0: every speed is stationary; this is the limit friction -> 0"
    if all(by_foot.reverses):
        return ""
    other_mode: Mode = "coulomb" if mode == "paper" else "paper"
    other = stationary_speed(design, mass, contact.restitution, contact.friction, other_mode)
    own_factor, other_factor = float(by_foot.factor), float(other.factor)
    if abs(own_factor - other_factor) <= REPORTED_DIFFERENCE * abs(own_factor):
        return ""
    which = "sticking feet (mode coulomb) give" if mode == "paper" else "eq. 15 with its sliding feet gives"
    other_speed = formatting.format_fixed(other_factor * impact_speed(scene, mass), 1)
    return f"friction can hold the feet: {which} {other_speed} mm/s"


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
    """Predict the speeds of a design with `count` evenly spaced tilts from `low_deg` to `high_deg`.

    The walkers have no engraved marks: marks number only the tilts of a family.
    """
    drawn, contact = sample_prediction_inputs(scene, design), scene.contact
    tilts = np.linspace(low_deg, high_deg, count)
    speeds, theory, sticks = [], [], []
    for tilt in tilts:
        variant = design.unmarked.variant(tilt_deg=float(tilt))
        mass = solids.mass_of(variant)
        by_foot = stationary_speed(variant, mass, contact.restitution, contact.friction, mode)
        try:
            nominal, speed, *_ = compute_speed(variant, mass, scene, drawn)
            speeds.append((nominal.number, speed.number, *(speed.ends or ())))
        except UnknownError:
            speeds.append((math.nan,) * 6)  # nominal, median and four bounds
        theory.append(float(by_foot.factor) * impact_speed(scene, mass))
        sticks.append(not all(by_foot.reverses))
    nominals, middle, *bounds = np.array(speeds).T
    return Curve(tilts, middle, np.array(bounds), nominals, np.array(theory), np.array(sticks))


def curve_from_rows(walkers: Sequence[tuple[Design, MassProperties, Prediction]], scene: Scene, mode: Mode) -> Curve:
    """Return the curve through walkers of different tilts, from their own predictions, in the order of tilts."""
    speeds, sticks, contact = [], [], scene.contact
    for design, mass, row in sorted(walkers, key=lambda walker: walker[2].tilt_deg):
        by_foot = stationary_speed(design, mass, contact.restitution, contact.friction, mode)
        has_speed = row.speed_by in ("statics", "surrogate")
        own_speeds = (row.nominal.number, row.speed.number, *(row.speed.ends or ())) if has_speed else (math.nan,) * 6
        speeds.append((row.tilt_deg, row.theory_mm_s, *own_speeds))
        sticks.append(not all(by_foot.reverses))
    tilts, theory, nominal, middle, *bounds = np.array(speeds, dtype=float).T
    return Curve(tilts, middle, np.array(bounds), nominal, theory, np.array(sticks))
