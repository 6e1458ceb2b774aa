"""Resolution of a time step: how far each observable may be off by it, or that this is unknown.

Measured with `walkergen accuracy --only steps` and by hand, see docs/physics.md section 7.
"""

import math
from collections.abc import Mapping

from walkergen.core.numerics.quantity import Quantity, exact
from walkergen.core.simulation import observables
from walkergen.core.simulation.plan import Plan, prepare

LANDING_RATE, GROUP_RATE, MOTION = "landings", "groups", "motion"
"""Names of other numbers with an error by the step: rates of landings of single corners and of groups of
corners, and all numbers from tracks."""

MAX_STEP_ERRORS = {
    observables.IMPACTS: 0.06,
    observables.CONTACT: 0.035,
    f"{observables.POWERS}.from_plate": 0.035,
    f"{observables.POWERS}.impacts": 0.07,
    f"{observables.POWERS}.friction": 0.12,
    f"{observables.POWERS}.damping": 0.14,
    LANDING_RATE: 0.08,
    GROUP_RATE: 0.15,
}
"""Largest errors (95 %) at the default step of the feet, as shares of the value.

They fall with the square of the step. They bound what 19 settings differ by from a quarter of the step (tilts of 0 to
35 deg, restitution 0.1 to 0.9, friction 0.05 to 0.5, 60 and 90 Hz, 1.4 to 2.6 g, tips of 1 to 50 um, rigid tips, braced
legs). Those of friction and damping are of restitution 0.1; elsewhere both stay below 0.03."""

MAX_SHARE_ERRORS = {
    "I": 0.03,
    "II": 0.05,
    "III": 0.06,
    "IV": 0.015,
    "from rest": 0.01,
    "II mirrored": 0.1,
    "III mirrored": 0.06,
    "sticking": 0.13,
}
"""The same for shares of types, by impulse and by number, as differences of shares."""

SPEED_ERROR_SHARE, SPEED_ERROR_FLOOR = 0.03, 0.01
"""The same for the speed, as shares of itself and of the plate's peak speed, which add: found are 2 % at 10 deg, and at
most 1.4 ± 0.8 mm/s."""

TURNING_REASON = (
    "turning and spread: ± is of the runs; by a tenth of this step they were the same within 30 %, "
    "at one setting of 14 they differed by a factor of two"
)
COARSE_STEP_REASON = "not resolved by this step: ‹step=›{step_us:.2g} or less resolves it"


def add_step_bias(plan: Plan, numbers: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return the numbers of runs by name, each with the largest error by the time step (95 %) as its `bias`.

    An unknown error is infinite, with the reason in `refused`. LANDING_RATE and GROUP_RATE are added with relative
    errors, and MOTION.
    """
    named = {
        **numbers,
        **{name: exact(name, "", 1.0) for name in (LANDING_RATE, GROUP_RATE)},
        MOTION: exact(MOTION, "", 0.0),
    }
    resolving = resolving_step(plan)
    part = plan.world.options.step / resolving
    coarse = COARSE_STEP_REASON.format(step_us=_round_down(1e6 * resolving)) if part > 1.0 + 1e-9 else ""
    for name, number in named.items():
        if reason := coarse or (TURNING_REASON if name == MOTION else ""):
            named[name] = number._replace(bias=math.inf, refused=reason)
        else:
            named[name] = number._replace(bias=_bias(plan, part, name, number.value or 0.0))
    return named


def _bias(plan: Plan, part: float, name: str, value: float) -> float:
    """Return the largest error (95 %) of the number `name`. `part`: step over `resolving_step`, at most 1."""
    if name == observables.SPEED:
        return part**2 * (SPEED_ERROR_SHARE * abs(value) + SPEED_ERROR_FLOOR * plan.equivalent_drive.peak_speed)
    if name in MAX_STEP_ERRORS:
        return part**2 * MAX_STEP_ERRORS[name] * abs(value)
    return part**2 * MAX_SHARE_ERRORS[name.partition(".")[2]] if value > 0.0 else 0.0  # share of an impact type


def step_bias(number: Quantity) -> float | None:
    """Return the largest error of a number by the step (95 %); None if unknown."""
    return None if math.isinf(number.bias) else number.bias


def reason(number: Quantity) -> str:
    """Return the text why a number's error by the time step is unknown; "" if it is known."""
    return number.refused if math.isinf(number.bias) else ""


def total_error(number: Quantity) -> float | None:
    """Return the standard error from the scatter of runs and the time step together; None if either is unknown.

    Half of the step's largest error (95 %) counts as one standard deviation.
    """
    if number.se is None or math.isinf(number.bias):
        return None
    return math.hypot(number.se, 0.5 * number.bias)


def resolving_step(plan: Plan) -> float:
    """Return the default time step (s), which resolves the contact of the walker's feet. The scene's own is ignored."""
    if plan.scene.run.step_us is None:
        return float(plan.world.options.step)
    run = plan.scene.run.model_copy(update={"step_us": None})
    scene = plan.scene.model_copy(update={"run": run})
    return float(prepare(scene, plan.case.design, plan.case.mass).world.options.step)


def _round_down(value: float) -> float:
    """Round down to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / digit + 1e-9) * digit
