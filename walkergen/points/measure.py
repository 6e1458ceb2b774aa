"""One simulated number: by the runs that a scene asks for, or by as many as an error needs.

An error means the same wherever it is asked for: 95 % of the speed's bounds, by runs and step. A
share counts of the speed, or of FEWEST_AT_ALL of the plate's peak speed where the walker is slower
than that: no number of runs gives a walker that stands to a share of its speed.
"""

import math
from typing import NamedTuple

from walkergen.drive import Drive
from walkergen.errors import InputError
from walkergen.files import words
from walkergen.files.progress import Progress
from walkergen.numerics.statistics import Mean
from walkergen.points.tolerance import Chosen, Tolerance
from walkergen.scene import Scene
from walkergen.simulation import experiments, observables, resolution
from walkergen.simulation.experiments import Experiment, Results
from walkergen.simulation.observables import SPEED
from walkergen.simulation.run import Outcome

FIRST_RUNS, MOST_RUNS = 8, 512
"""Numbers of runs with which a walker that shall meet an error begins, and ends."""

LONGEST_S = 4.0
"""Measured time of a run for an error, at most: more runs tell more than longer ones."""

SLACK = 1.2
"""Factor by which more runs are made than the estimated error needs, since it fluctuates."""

STEPS_PART, FINEST_US = 0.8, 0.05
"""Part of the error that a step in space may take up, else it is halved, and step (us) at which
that ends."""

FEWEST_AT_ALL = 0.2
"""Speed over the plate's peak speed below which a share of error counts of this one."""


class Measured(NamedTuple):
    """Walker that was simulated until its error was met, or no more runs could help."""

    results: Results
    scene: Scene
    """Scene with the runs and the step that were taken."""
    error: float
    """Half-width of the bounds of 95 % by runs and step, in the observable's unit; infinite where
    it is not known."""
    allowed: float
    """Error that was asked for, in the same unit; infinite for none."""
    of: str = SPEED
    """Name of the observable."""

    def chosen(self) -> Chosen:
        """What was taken to meet the error, and the error obtained."""
        summary, verdict = self.results.summary, self.results.verdicts[self.of]
        step = self.results.step_us
        unit = "mm/s" if self.of == SPEED else f"of {self.of}"
        within = "within" if self.error <= self.allowed else "NOT within"
        stepping = "" if step is None else f", step {words.number(step, 3)} us"
        seconds = self.scene.run.seconds
        by_step = words.number(verdict.error or 0.0, 2)
        lines = [
            ("chosen", f"{summary.runs} x {seconds:g} s{stepping}"),
            (
                "error, 95 %",
                f"{words.number(self.error, 2)} {unit}, {within} the "
                f"{words.number(self.allowed, 2)} asked ({by_step} by the step)",
            ),
        ]
        facts = {
            "runs": summary.runs,
            "seconds": seconds,
            "step_us": step,
            "step_error": verdict.error,
            "of": self.of,
            "error": None if math.isinf(self.error) else self.error,
            "allowed": self.allowed,
        }
        return Chosen(lines, facts)


def check(tolerance: Tolerance, of: str) -> None:
    """Refuse errors of observables that no run gives. Raises InputError."""
    if of not in observables.NAMES:
        names = ", ".join(observables.NAMES)
        raise InputError(f"--of {of[:60]!r}: must be one of {names}")
    if of != SPEED and not tolerance.relative:
        raise InputError(f"--error {tolerance}: only a mean speed is in mm/s; write a share: 5%")


def measure(
    experiment: Experiment,
    progress: Progress,
    tolerance: Tolerance | None = None,
    of: str = SPEED,
    threads: int | None = None,
) -> Measured:
    """Simulate a walker by its scene's runs, or by more and more of them until an error is met.

    With an error the step is halved where it takes up more of it than runs could make good, and
    runs are short. After Ctrl-C the runs that are done. Raises InputError where the scene
    contradicts itself or the design, and for an observable that the step does not resolve.
    """
    if tolerance is not None:
        check(tolerance, of)
        seconds = min(experiment.scene.run.seconds, LONGEST_S)
        experiment = experiment._replace(scene=with_runs(experiment.scene, runs=FIRST_RUNS, seconds=seconds))
    while True:
        scene = experiment.scene
        results = experiments.measure(experiment, progress, threads)
        verdict = results.verdicts[of]
        if tolerance is None:
            return Measured(results, scene, half_width(results, of), math.inf, of)
        if verdict.error is None:
            raise InputError(f"--error {tolerance}: {of} is {verdict.reason}")
        most = _allowed(tolerance, results, experiment.shaken, of)
        measured = Measured(results, scene, half_width(results, of), most, of)
        if measured.error <= most or _more_is_no_help(results, scene):
            return measured
        finer = refined(scene, measured.error, most, verdict.error, results.step_us)
        if finer is None:
            return measured
        experiment = experiment._replace(scene=finer)


def half_width(results: Results, of: str = SPEED) -> float:
    """Half of the bounds of 95 % of an observable, by runs and step; infinite where not known."""
    summary = results.summary
    if of == SPEED:
        low, high = summary.speed_low_95_mm_s, summary.speed_high_95_mm_s
        return math.inf if low is None or high is None else 0.5 * (high - low)
    se, step = summary.errors[of], results.verdicts[of].error
    if se is None or step is None:
        return math.inf
    return math.hypot(Mean(0.0, se, summary.runs - 1.0).interval(0.95)[1], step)


def allowed(tolerance: Tolerance, speed: float | None, shaken: Drive) -> float:
    """Error that a speed may have, mm/s: a share counts of it, or FEWEST_AT_ALL of the drive's."""
    if not tolerance.relative:
        return tolerance.value
    return tolerance.value * max(abs(speed or 0.0), FEWEST_AT_ALL * shaken.peak_speed)


def _allowed(tolerance: Tolerance, results: Results, shaken: Drive, of: str) -> float:
    """Error that an observable may have, in its unit."""
    if of == SPEED:
        return allowed(tolerance, results.summary.speed_mm_s, shaken)
    return tolerance.value * abs(resolution.values(results.summary)[of])


def _more_is_no_help(results: Results, scene: Scene) -> bool:
    """Whether runs were left out after Ctrl-C, or more of them would end as these did."""
    summary = results.summary
    return summary.runs < scene.run.runs or summary.speed_mm_s is None or Outcome.ORBIT.value in summary.outcomes


def refined(scene: Scene, error: float, most: float, step_error: float, step_us: float | None) -> Scene | None:
    """Scene with more runs, or half the step, for errors that exceed `most`.

    `step_error` is the step's own part, `step_us` a step that may be halved. None where neither
    would help.
    """
    if step_error > STEPS_PART * most:
        finest = step_us is None or step_us < 2.0 * FINEST_US
        return None if finest or step_us is None else with_runs(scene, step_us=0.5 * step_us)
    runs = scene.run.runs
    if runs >= MOST_RUNS:
        return None
    # Variances fall as runs are added; the scatter of few runs is itself known badly.
    finite = math.isfinite(error)
    short = (error**2 - step_error**2) / (most**2 - step_error**2) if finite else 2.0
    more = math.ceil(runs * min(max(SLACK * short, 1.5), 8.0))
    return with_runs(scene, runs=min(MOST_RUNS, more))


def with_runs(scene: Scene, **run: float) -> Scene:
    """Scene with other settings of its runs."""
    return scene.model_copy(update={"run": scene.run.model_copy(update=run)})
