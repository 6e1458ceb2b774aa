"""Simulation of many printed walkers in one short run each. A draw is one of them, with random uncertain inputs."""

import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress, part_progress
from walkergen.core.numerics import Array, Mask, statistics
from walkergen.core.numerics.quantity import Quantity, exact
from walkergen.core.scene import Scene
from walkergen.core.simulation import observables
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import ENDED_WELL
from walkergen.core.theory import uncertain_inputs
from walkergen.core.theory.uncertain_inputs import Input, Share
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import emulator, step_errors, walkers
from walkergen.points.experiments import Results, Walker

Bounds = tuple[float, float, float, float]
"""Speeds, mm/s: lower ends of 95 % and 68 %, upper ends of 68 % and 95 %."""

MIN_DRAWS, MAX_DRAWS = 16, 4096

MAX_VARIANCE_SHARE = 0.5
"""Largest part of the draws' variance that is taken out of the bounds as the error of short runs.
A smaller error is taken out completely, and bounds hold what they state. With a larger one so few draws cannot
show what remains: with an error of four fifths taken out completely, 95 % bounds held 80 to 87 %."""

JACKKNIFE_GROUPS = 8
"""Number of groups of draws that are left out in turn, for the errors of the shares."""


class PrintScatter(NamedTuple):
    """Speed of a walker with uncertain inputs of design and scene, from many prints."""

    draws: int
    """Draws whose runs ended well."""
    outcomes: dict[str, int]
    speed: Quantity
    """Mean over the draws, with the step's error as its bias; its bounds are those of prints, that error included."""
    between_prints_mm_s: float
    """Standard deviation of the speed from print to print, statistics of short runs taken out."""
    statistical_mm_s: float
    """Standard error of one draw's speed by the shortness of its run."""
    shares: tuple[Share, ...]
    """Parts of the variance between prints, by input; none where runs so short resolve none."""
    unexplained: Quantity
    """Part of that variance that no input explains: heights of a print's corners, and the emulator's
    error."""
    inputs: tuple[Input, ...]
    values: Array
    """Values of the inputs, shape (draws, inputs)."""
    speeds: Array
    """Speeds of the draws, mm/s."""


def measure(scene: Scene, design: Design, draws: int, progress: Progress) -> PrintScatter:
    """Simulate `draws` random prints, one run each, and attribute the scatter of their speeds to the uncertain inputs.

    Raises InputError if `draws` is out of range, nothing is uncertain, or too few runs end well.
    """
    if not MIN_DRAWS <= draws <= MAX_DRAWS:
        raise InputError(f"‹draws=›{draws}: must lie in {MIN_DRAWS}..{MAX_DRAWS}")
    drawn = simulate_prints(scene, design, draws, progress)
    result = analyse(drawn.inputs, drawn.values, drawn.halves, drawn.outcomes, scene.run.seed)
    step, speed = drawn.by_step_mm_s, result.speed
    ends = add_step_error(speed_bounds(result.speeds, result.statistical_mm_s), speed.number, step)
    return result._replace(speed=speed._replace(ends=ends, bias=math.inf if step is None else step))


class PrintRuns(NamedTuple):
    """Random prints whose runs ended well: their uncertain inputs and their speeds."""

    inputs: tuple[Input, ...]
    values: Array
    """Values of the inputs, shape (draws, inputs)."""
    halves: Array
    """Mean speeds of the two halves of each run, shape (draws, 2), mm/s."""
    outcomes: dict[str, int]
    by_step_mm_s: float | None
    """Largest error of the mean speed by the time step (95 %); None if unknown."""


def simulate_prints(scene: Scene, design: Design, draws: int, progress: Progress) -> PrintRuns:
    """Simulate `draws` prints with random values of the uncertain inputs, one run each.

    Raises InputError if nothing is uncertain, or fewer than MIN_DRAWS runs end well.
    """
    plan = prepare(scene, design, solids.mass_of(design))
    inputs = uncertain_inputs.inputs(scene, design, uncertain_inputs.SPACE_READER)
    if not inputs:
        raise InputError(
            "‹uncertain›: design and scene have no standard deviation above 0 that a simulation "
            "reads. Set one, for instance contact.restitution_sd"
        )
    values = uncertain_inputs.sample_inputs(inputs, draws, scene.run.seed)
    experiments_of = [_build_draw(scene, design, inputs, row, number) for number, row in enumerate(values)]
    points = _simulate_draws(experiments_of, progress)
    good = np.array([point.results[0].outcome in ENDED_WELL for point in points])
    if good.sum() < MIN_DRAWS:
        raise InputError(
            f"‹uncertain›: {good.sum()} of {draws} runs ended well, {MIN_DRAWS} are needed. "
            "Run `simulate` without it to see how they end"
        )
    halves = np.array([_half_speeds(point) for point, well in zip(points, good, strict=True) if well])
    outcomes = dict(Counter(point.results[0].outcome.value for point in points))
    mean = Quantity("speed", "mm_s", float(halves.mean()))
    step = step_errors.step_bias(step_errors.add_step_bias(plan, {observables.SPEED: mean})[observables.SPEED])
    return PrintRuns(inputs, values[good], halves, outcomes, step)


def add_step_error(ends: Bounds, mean: float, error: float | None) -> Bounds:
    """Return the bounds `ends` of a `mean` speed, widened by the time step's `error`, all in mm/s.

    `error` (95 %) is added in quadrature; None, for an unknown error, leaves the bounds unchanged.
    """
    by_step = error or 0.0
    return add_error(ends, mean, (by_step, 0.5 * by_step, 0.5 * by_step, by_step))


def add_error(ends: Bounds, mean: float, parts: Bounds) -> Bounds:
    """Return the bounds `ends` of a `mean` speed, each widened in quadrature by its error in `parts`, all in mm/s."""
    low2, low1, high1, high2 = (
        mean + math.copysign(math.hypot(end - mean, part), end - mean) for end, part in zip(ends, parts, strict=True)
    )
    return low2, low1, high1, high2


def _build_draw(scene: Scene, design: Design, inputs: Sequence[Input], row: Array, number: int) -> Walker:
    """Return the walker of draw `number`, with a single run: `inputs` are set to the values `row`, shape (inputs,)."""
    names = [quantity.name for quantity in inputs]
    changed, printed, mass = uncertain_inputs.apply_inputs(scene, design, dict(zip(names, row, strict=True)))
    run = changed.run.model_copy(update={"runs": 1, "seed": (scene.run.seed + number) % 2**63})
    return Walker(changed.model_copy(update={"run": run}), printed, mass)


def _simulate_draws(draws: Sequence[Walker], progress: Progress) -> list[Results]:
    """Simulate the walkers of all draws in parallel, after the first, which compiles the kernels for all."""
    progress("kernels", 0, len(draws))
    first = walkers.simulate(draws[0])
    others = walkers.simulate_parallel(draws[1:], part_progress(progress, 0, 1, f"{len(draws)} prints"))
    if first.partial or len(others) < len(draws) - 1:
        raise KeyboardInterrupt
    return [first, *others.values()]


def _half_speeds(results: Results) -> tuple[float, float]:
    """Return the mean speeds of the first and second half of a single run, mm/s."""
    blocks = results.results[0].block_speeds
    middle = len(blocks) // 2
    return float(blocks[:middle].mean()), float(blocks[middle:].mean())


def analyse(
    inputs: tuple[Input, ...], values: Array, halves: Array, outcomes: dict[str, int], seed: int
) -> PrintScatter:
    """Compute the scatter of speeds between prints, less the statistical errors of short runs, and each input's share.

    `values`: inputs of n draws, shape (n, inputs). `halves`: mean speeds of the two halves of each run, shape (n, 2),
    mm/s. The difference of the halves gives the statistical error, if correlations are shorter than half a run.
    """
    speeds, statistical = halves.mean(axis=1), statistical_error(halves)
    mean, total = float(speeds.mean()), float(speeds.std(ddof=1))
    between = math.sqrt(max(total**2 - statistical**2, 0.0))
    shares: tuple[Share, ...] = ()
    rest = exact("unexplained", "", 0.0)
    if between > 0.0:
        explained, errors = _variance_shares(inputs, values, speeds, between, seed)
        shares = uncertain_inputs.sort_shares(inputs, explained[:2], errors[:2])  # first-order and total
        rest = rest._replace(value=1.0 - float(explained[2, 0]), se=float(errors[2, 0]))  # of all together
    return PrintScatter(
        len(speeds),
        outcomes,
        Quantity("speed", "mm_s", mean, total / math.sqrt(len(speeds)), ends=speed_bounds(speeds, statistical)),
        between,
        statistical,
        shares,
        rest,
        inputs,
        values,
        speeds,
    )


def statistical_error(halves: Array) -> float:
    """Estimate the standard error of one run's mean speed, mm/s. `halves`: speeds of the halves of n runs, (n, 2)."""
    return 0.5 * float(np.sqrt(np.mean((halves[:, 1] - halves[:, 0]) ** 2)))


def speed_bounds(speeds: Array, statistical: float) -> Bounds:
    """Return the speeds (mm/s) below which 2.5, 16, 84 and 97.5 % of prints run, from the `speeds` of n draws.

    The `statistical` error of a draw is removed: deviations from the mean are scaled down accordingly. At most
    MAX_VARIANCE_SHARE of the variance is removed.
    """
    mean, variance = speeds.mean(), float(speeds.var(ddof=1))
    share = min(statistical**2 / variance, MAX_VARIANCE_SHARE) if variance else 0.0
    scaled = mean + (speeds - mean) * math.sqrt(1.0 - share)
    ends = statistics.prediction_quantiles(scaled, uncertain_inputs.QUANTILES)
    low2, low1, high1, high2 = ends.tolist()
    return low2, low1, high1, high2


def _variance_shares(
    inputs: Sequence[Input], values: Array, speeds: Array, between: float, seed: int
) -> tuple[Array, Array]:
    """Return the shares of the variance between prints by input, and their jackknife errors, both of shape (3, inputs).

    Rows: first-order share, total share, and in every column the share of all inputs together. `between`: standard
    deviation between prints, mm/s.
    """
    fit_of_all = emulator.fit(values, speeds, seed=seed % 2**32)

    def shares_from(kept: Mask) -> Array:
        """Return the shares, shape (3, inputs), from the draws for which `kept` is True."""
        fitted = emulator.fit(values[kept], speeds[kept], fit_of_all.noise[kept], like=fit_of_all)

        def mean_speed(x: Array) -> Array:
            return fitted(x)[0]

        parts = uncertain_inputs.sobol_indices(inputs, mean_speed, np.random.default_rng(seed))
        sample = uncertain_inputs.sample_inputs(inputs, uncertain_inputs.SHARE_POINTS, seed)
        explained = float(mean_speed(sample).var())
        part = min(explained / between**2, 1.0)
        return np.vstack([part * parts, np.full(len(inputs), part)])

    group = np.arange(len(speeds)) % JACKKNIFE_GROUPS
    replicates = np.array([shares_from(group != left_out).ravel() for left_out in range(JACKKNIFE_GROUPS)])
    whole = shares_from(group >= 0)
    return whole, statistics.jackknife_error(replicates).reshape(whole.shape)
