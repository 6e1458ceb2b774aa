"""What a time step resolves: how far each observable may be off by it, or that this is not known.

Measured with `walkergen accuracy --only steps` and by hand, see docs/physics.md section 7.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from walkergen.core.numerics.quantity import Quantity
from walkergen.core.simulation import observables
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.run import ENDED_WELL, Outcome

LANDING_RATE, GROUP_RATE, MOTION = "landings", "groups", "motion"
"""Names of what else a step moves: rates of landings of single corners and of groups of
corners, and all that tracks tell."""

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
"""Largest errors (95 %) at the step that feet take by themselves, as shares of the value.

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
    "at one setting of 14 twice as large"
)
COARSE_STEP_REASON = "not resolved by this step: ‹step=›{own:.2g} or less is"


class StepError(NamedTuple):
    """How far a step leaves an observable off, as far as that is known."""

    error: float | None
    """Largest error by the step (95 %), in the observable's unit; None where it is not known."""
    reason: str = ""
    """Reason why it is not known, and what would resolve the observable; "" where it is."""


def judge(plan: Plan, summary: Summary) -> dict[str, StepError]:
    """Errors by the step of all observables of a summary, by the names of `observables.NAMES`.

    Also on landings of corners and of groups of corners per second, as shares of a rate, and on motion.
    """
    values_of = observable_values(summary)
    own = resolving_step(plan)
    part = plan.world.options.step / own
    if part > 1.0 + 1e-9:
        names = [*values_of, LANDING_RATE, GROUP_RATE, MOTION]
        return dict.fromkeys(names, StepError(None, COARSE_STEP_REASON.format(own=_round_down(1e6 * own))))
    values_of |= {LANDING_RATE: 1.0, GROUP_RATE: 1.0}
    step_errors = {name: _step_error(plan, part, name, value) for name, value in values_of.items()}
    return step_errors | {MOTION: StepError(None, TURNING_REASON)}


def observable_values(summary: Summary) -> dict[str, float]:
    """Values of all observables of a summary, by the names of `observables.NAMES`."""
    numbers = {
        observables.SPEED: summary.speed_mm_s or 0.0,
        observables.IMPACTS: summary.impacts_per_s,
        observables.CONTACT: summary.contact_fraction,
    }
    tables = {
        observables.POWERS: summary.energies_per_s,
        observables.BY_IMPULSE: summary.type_fractions_by_impulse,
        observables.BY_NUMBER: summary.type_fractions,
    }
    for table, entries in tables.items():
        numbers |= {f"{table}.{name}": value for name, value in entries.items()}
    return numbers


def _step_error(plan: Plan, part: float, name: str, value: float) -> StepError:
    """Error by a step that is `part` (at most 1) of the walker's own."""
    if name == observables.SPEED:
        floor = SPEED_ERROR_FLOOR * plan.shaken.peak_speed
        return StepError(part**2 * (SPEED_ERROR_SHARE * abs(value) + floor))
    if name in MAX_STEP_ERRORS:
        return StepError(part**2 * MAX_STEP_ERRORS[name] * abs(value))
    return StepError(part**2 * MAX_SHARE_ERRORS[name.partition(".")[2]] if value > 0.0 else 0.0)


def resolving_step(plan: Plan) -> float:
    """Step (s) that resolves the walker's feet, whatever the scene's own is."""
    run = plan.scene.run.model_copy(update={"step_us": None})
    scene = plan.scene.model_copy(update={"run": run})
    return float(prepare(scene, plan.case.design, plan.case.mass).world.options.step)


def _round_down(value: float) -> float:
    """Round down to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / digit + 1e-9) * digit


def with_step_error(step_errors: Mapping[str, StepError], summary: Summary) -> Summary:
    """Add the step's error to the bounds of the speed in a summary; None if it is unknown.

    Half-widths add in squares: the step's is a largest error, which leaves 95 % and more inside.
    """
    speed, error = summary.speed_mm_s, step_errors[observables.SPEED].error
    changed: dict[str, Any] = {}
    for level, part in (("68", 0.5), ("95", 1.0)):
        names = [f"speed_{end}_{level}_mm_s" for end in ("low", "high")]
        low, high = (getattr(summary, name) for name in names)
        changed |= dict.fromkeys(names)
        if speed is not None and error is not None and low is not None and high is not None:
            half = math.hypot(0.5 * (high - low), part * error)
            changed |= {names[0]: speed - half, names[1]: speed + half}
    return summary._replace(**changed)


def combined_errors(step_errors: Mapping[str, StepError], summary: Summary) -> dict[str, float | None]:
    """Combine the standard errors of the runs' scatter and of the step; None if either is unknown.

    Half of a largest error of 95 % counts as one standard deviation.
    """
    scatter = {**summary.errors, observables.SPEED: summary.speed_se_mm_s}
    both = {}
    for name, se in scatter.items():
        error = step_errors[name].error
        both[name] = None if se is None or error is None else math.hypot(se, 0.5 * error)
    return both


def quantities(step_errors: Mapping[str, StepError], summary: Summary) -> list[Quantity]:
    """Observables with errors by the runs' scatter, and what the step leaves of them as a bias.

    Runs that share an orbit have no freedom: no number of them would tell an error.
    """
    scatter = {**summary.errors, observables.SPEED: summary.speed_se_mm_s}
    well = sum(summary.outcomes.get(outcome.value, 0) for outcome in ENDED_WELL)
    locked = Outcome.ORBIT.value in summary.outcomes
    every = []
    for name, value in observable_values(summary).items():
        error, reason = step_errors[name]
        speed = name == observables.SPEED
        key, unit = name.removesuffix("_mm_s"), "mm_s" if speed else ""
        runs = well if speed else summary.runs
        refused = Outcome.ORBIT.value if locked else reason
        if speed and not well:
            every.append(Quantity(key, unit, None, refused="no run ended well"))
        else:
            freedom, bias = 0.0 if locked else runs - 1.0, math.inf if error is None else error
            every.append(Quantity(key, unit, value, scatter[name], freedom, refused, bias=bias))
    return every
