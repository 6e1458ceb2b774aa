"""Errors of a simulation's numbers by its time step: the largest error of each, or the reason why it is unknown.

Measured with `walkergen accuracy --only steps` and by hand, see docs/physics.md section 7.
"""

import math
from collections.abc import Mapping

from walkergen.core.numerics.quantity import Quantity, exact
from walkergen.core.simulation import observables
from walkergen.core.simulation.plan import Plan, prepare

LANDING_RATE, GROUP_RATE, MOTION = "landings", "groups", "motion"
"""Names of other numbers with an error by the time step: rates at which single corners of the feet and groups of
corners land, and one name for all numbers from tracks (turning, diffusion)."""

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
"""Largest errors (95 %) of numbers by name at the default time step, over the number's value.

They fall with the square of the step. They bound the differences from runs with a quarter of the step, in 19 settings:
tilts of 0 to 35 deg, restitution 0.1 to 0.9, friction 0.05 to 0.5, 60 and 90 Hz, 1.4 to 2.6 g, tips of 1 to 50 um,
rigid tips, braced legs. The powers of friction and damping reach theirs at restitution 0.1, elsewhere 0.03."""

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
"""Largest errors (95 %) of the shares of impact types at the default time step, as differences of shares (0 to 1)."""

SPEED_ERROR_SHARE, SPEED_ERROR_FLOOR = 0.03, 0.01
"""Largest error (95 %) of the speed at the default time step: the first times the speed plus the second times the
plate's peak speed. Measured were 2 % at a tilt of 10 deg, and at most 1.4 ± 0.8 mm/s."""

TURNING_REASON = (
    "turning and spread: ± is the error of the runs alone. With a tenth of this step they were the same within "
    "30 %, but differed by a factor of two in one of 14 settings"
)
COARSE_STEP_REASON = "not resolved by this step: ‹step=›{step_us:.2g} or less resolves it"


def add_step_bias(plan: Plan, numbers: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return the numbers of runs by name, each with the largest error by the time step (95 %) as its `bias`.

    An unknown error is infinite, with the reason in `refused`. Added entries: LANDING_RATE and GROUP_RATE with relative
    errors, and MOTION, whose error is never known.
    """
    named = {
        **numbers,
        **{name: exact(name, "", 1.0) for name in (LANDING_RATE, GROUP_RATE)},
        MOTION: exact(MOTION, "", 0.0),
    }
    resolving = resolving_step(plan)
    step_ratio = plan.world.options.step / resolving
    coarse = COARSE_STEP_REASON.format(step_us=_round_down(1e6 * resolving)) if step_ratio > 1.0 + 1e-9 else ""
    for name, number in named.items():
        if reason := coarse or (TURNING_REASON if name == MOTION else ""):
            named[name] = number._replace(bias=math.inf, refused=reason)
        else:
            named[name] = number._replace(bias=_max_error(plan, step_ratio, name, number.value or 0.0))
    return named


def _max_error(plan: Plan, step_ratio: float, name: str, value: float) -> float:
    """Return the largest error (95 %) of a number by the time step. `step_ratio`: step / `resolving_step`, <= 1."""
    if name == observables.SPEED:
        return step_ratio**2 * (SPEED_ERROR_SHARE * abs(value) + SPEED_ERROR_FLOOR * plan.equivalent_drive.peak_speed)
    if name in MAX_STEP_ERRORS:
        return step_ratio**2 * MAX_STEP_ERRORS[name] * abs(value)
    return step_ratio**2 * MAX_SHARE_ERRORS[name.partition(".")[2]] if value > 0.0 else 0.0  # share of an impact type


def step_bias(number: Quantity) -> float | None:
    """Return the largest error of a number by the time step (95 %), in its unit; None if unknown."""
    return None if math.isinf(number.bias) else number.bias


def reason(number: Quantity) -> str:
    """Return the reason why a number's error by the time step is unknown, as text for users; "" if it is known."""
    return number.refused if math.isinf(number.bias) else ""


def total_error(number: Quantity) -> float | None:
    """Return a number's standard error by the scatter of runs and by the time step together; None if one is unknown.

    Half of the step's largest error (95 %) counts as one standard deviation.
    """
    if number.se is None or math.isinf(number.bias):
        return None
    return math.hypot(number.se, 0.5 * number.bias)


def resolving_step(plan: Plan) -> float:
    """Return the default time step (s), which resolves contacts of the walker's feet. `run.step_us` is ignored."""
    if plan.scene.run.step_us is None:
        return float(plan.world.options.step)
    run = plan.scene.run.model_copy(update={"step_us": None})
    scene = plan.scene.model_copy(update={"run": run})
    return float(prepare(scene, plan.case.design, plan.case.mass).world.options.step)


def _round_down(value: float) -> float:
    """Return a value > 0 rounded down to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / digit + 1e-9) * digit
