"""A walker's speed from the surrogate, corrected by a few runs of the walker if the surrogate is too uncertain.

The networks of the surrogate give asinh(speed / (LINEAR_BELOW * plate's peak speed)): speeds on their scale. On it the
surrogate has nearly the same error for all prints of a walker. So runs of the walker as designed give this error, and
prints need no runs. Records have the keys of `short_simulation`.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.files.progress import Progress
from walkergen.core.measure import Measured, measure
from walkergen.core.scene import GRAVITY
from walkergen.core.simulation import ensemble
from walkergen.core.simulation.observables import SPEED
from walkergen.core.simulation.run import ENDED_WELL, Outcome, RunResult
from walkergen.core.theory import networks, prediction
from walkergen.core.theory.networks import LINEAR_BELOW, Speeds
from walkergen.core.theory.surrogate import NORMAL_95, SurrogateCase
from walkergen.core.theory.uncertain_inputs import QUANTILES
from walkergen.points import print_ensemble
from walkergen.points.experiments import Walker
from walkergen.points.point import Record

SECONDS, FIRST_RUNS, MAX_RUNS, RUN_GROWTH = 1.0, 4, 32, 1.5
"""Measured time of a run, s; first and maximum number of runs, and the factor between successive numbers."""

SETTLING_RATIO, SETTLING_RANGE_S = 12.0, (0.5, 4.0)
"""Time until a walker has its speed, over the time that friction takes to give it the plate's peak speed; its limits,
s. With frictions of 0.02 to 0.04 speeds still grew for a second after the drop."""

MAX_SURROGATE_ERROR = 0.3
"""Standard error of the surrogate, on the scale of its networks, beyond which it does not know a walker's prints."""

MIN_RUN_ERROR = 0.02
"""Least standard error of the runs, on the scale of the networks: runs on one orbit have no scatter."""

MAX_DEVIATIONS = 3.0
"""Standard deviations between surrogate and runs beyond which the surrogate's error is not what it states."""

DIFFERENCE_FACTOR = 2.5
"""Factor of the networks' difference between a walker and a print, so that bounds hold 68 and 95 % of prints."""

MAX_FALL_CHANCE = 0.25
"""Chance of a fall, by the networks, beyond which runs of a second are too short to show how often a walker falls."""


class UntilCertain(NamedTuple):
    """Rule that adds runs until the speed of a walker as designed, by surrogate and runs, is certain enough."""

    case: SurrogateCase
    first_runs: int = FIRST_RUNS

    def request_more(self, measured: Measured[Walker]) -> Measured[Walker] | None:
        """Return the measurement with more runs requested; None if the speed is certain or missing, or at MAX_RUNS."""
        nominal = combine(self.case, measured.records)
        if nominal is None or measured.runs >= MAX_RUNS:
            return None
        if self.case.is_certain(nominal):
            return None
        return measured.with_runs(min(MAX_RUNS, math.ceil(RUN_GROWTH * measured.runs)))


def correct_by_runs(walker: Walker, case: SurrogateCase | None, progress: Progress) -> Record | None:
    """Simulate a few runs of a walker. Return its speeds (mm/s) from the surrogate and these runs, by record key.

    Return None outside the surrogate's domain (`case` is None), or if runs cannot correct the surrogate.
    """
    if case is None or not can_correct(case):
        return None
    short_walker = walker.with_run_settings(seconds=SECONDS, discard_seconds=_settling_time(case))
    measured = measure(short_walker, UntilCertain(case), progress)
    if measured.partial:
        raise KeyboardInterrupt
    by_step, nominal = measured.quantities[SPEED].bias, combine(case, measured.records)
    if nominal is None or not math.isfinite(by_step):
        return None
    speed, se = case.to_mm_s(nominal)
    half_width = math.hypot(NORMAL_95 * se, by_step)
    falls = sum(record.outcome is Outcome.TOPPLED for record in measured.records) / measured.runs
    record: Record = {"by": "corrected", "falls": falls, "left_out": None, "nominal": speed}
    return record | {"low": speed - half_width, "high": speed + half_width} | _speed_over_prints(case, nominal, by_step)


def combine(case: SurrogateCase, records: Sequence[RunResult]) -> Speeds | None:
    """Return the speed as designed from surrogate and runs together, weighted by their errors, on the networks' scale.

    Return None if too few runs ended well, or if the two differ by more than MAX_DEVIATIONS standard deviations.
    """
    mean = ensemble.mean_speed([record for record in records if record.outcome in ENDED_WELL])
    bounds = mean.interval()
    if bounds is None:
        return None
    scale = LINEAR_BELOW * case.peak_speed
    low, high, measured = (math.asinh(speed / scale) for speed in (*bounds, mean.number))
    noise = math.hypot((high - low) / (2.0 * NORMAL_95), MIN_RUN_ERROR)
    prior = case.predicted
    if np.any(np.abs(measured - prior.centre) > MAX_DEVIATIONS * np.hypot(prior.error, noise)):
        return None
    part = prior.error**2 / (prior.error**2 + noise**2)
    return prior._replace(centre=prior.centre + part * (measured - prior.centre), error=np.sqrt(part) * noise)


def can_correct(case: SurrogateCase) -> bool:
    """Return whether runs can correct the surrogate: its error and chance of a fall are small, and the speed is steady.

    On a sloping plane a walker turns downhill. Below 1 g some prints stand and others bounce. If the scene accepts an
    error, runs leave out effects that the surrogate includes.
    """
    scene, predicted = case.scene, case.predicted
    unsteady = scene.drive.peak_gamma < 1.0 or (scene.arena.kind == "plane" and scene.plate.slope_deg != 0.0)
    sure = bool(predicted.error[0] <= MAX_SURROGATE_ERROR and predicted.falls[0] <= MAX_FALL_CHANCE)
    return sure and not unsteady and scene.run.accepted_error is None


def _settling_time(case: SurrogateCase) -> float:
    """Return the time that a walker takes from its drop to its steady speed, s."""
    gained_s = case.peak_speed / (max(case.scene.contact.friction, 1e-9) * GRAVITY)
    return min(max(SETTLING_RATIO * gained_s, SETTLING_RANGE_S[0]), SETTLING_RANGE_S[1])


def _speed_over_prints(case: SurrogateCase, nominal: Speeds, by_step: float) -> Record:
    """Return a record of the speed over prints, mm/s: "mean" (their median), "sd" and bounds.

    They are the surrogate's, shifted by the correction of the speed as designed.

    Parameters
    ----------
    case
        Walker within the surrogate's domain.
    nominal
        Corrected speed of the walker as designed, on the networks' scale.
    by_step
        Error of this speed by the time step (95 %), mm/s.
    """
    drawn, predicted = prediction.sample_prediction_inputs(case.scene, case.design), case.predicted
    speeds = case.speeds_at_draws(drawn)
    factor = DIFFERENCE_FACTOR * networks.load_arrays()[f"{case.design.kind}_error"][0]
    error = np.hypot(nominal.error, factor * (speeds.each - predicted.each).std(axis=0, ddof=1))
    shift = nominal.centre - predicted.centre
    prints = prediction.speeds_of_prints(case, speeds._replace(error=error), drawn, shift)
    middle = float(np.median(prints))
    first2, first1, last1, last2 = np.quantile(prints, QUANTILES).tolist()
    low2, low1, high1, high2 = print_ensemble.add_step_error((first2, first1, last1, last2), middle, by_step)
    spread: Record = {"mean": middle, "sd": float(np.std(prints))}
    return spread | {"low_95": low2, "low_68": low1, "high_68": high1, "high_95": high2}
