"""Training of the surrogate on the rows: `python -m evidence.tables.train` writes walkergen/core/theory/surrogate.npz.

Ten networks give speeds, each trained without two tenths of the rows. Smaller networks learn how far these are off at
the rows that they were trained without, and others where walkers fall. Two factors, of the ten networks' standard
deviation and of the learnt error, are fitted to held-out rows, which no network was trained on.
"""

import io
import json
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import settings, simulate
from evidence.tables.scatter import fit_scatter
from walkergen.core.files import output
from walkergen.core.theory import dimensionless as places
from walkergen.core.theory import networks
from walkergen.core.theory.dimensionless import DimensionlessNumbers
from walkergen.core.theory.networks import LINEAR_BELOW, Layer
from walkergen.core.theory.surrogate import MAX_FALL_CHANCE, NORMAL_95, allowed_error
from walkergen.core.walker import solids
from walkergen.core.walker.limbs import Kind
from walkergen.points import worker_pool

Array = npt.NDArray[Any]

NETWORKS, TENTHS_LEFT_OUT = 10, 2
"""Number of networks, and of the tenths of the rows that each is trained without."""

HIDDEN_LAYERS: Mapping[Kind, tuple[int, ...]] = {"flexible": (96, 96, 96), "braced": (12, 12)}
ERROR_LAYERS, ERROR_NETWORKS = (32, 32), 2
FALL_LAYERS, FALL_NETWORKS = (48, 48), 4
"""Widths of the hidden layers of networks of the speed, of its error and of the chance of a fall; numbers of the last
two."""

EPOCHS: Mapping[Kind, int] = {"flexible": 300, "braced": 600}
ERROR_EPOCHS_SHARE = 0.2
"""Passes through the rows, and the share of them that networks of the error make."""

BATCH, RATE, WARM_UP_STEPS, DECAY, ERROR_DECAY = 256, 0.003, 300, 0.12, 0.5
"""Rows of a step, its largest length, steps while it grows, and the share of it that weights shrink by: Adam (Kingma
and Ba, arXiv 1412.6980) with decoupled decay (Loshchilov and Hutter, arXiv 1711.05101)."""

NETWORK_ERROR = 0.05
"""Error (after asinh) of every row in addition to its own noise. Rows with less noise have no more weight."""

LINEAR_LOSS_ABOVE = 0.05
"""Error (after asinh) above which the loss grows in proportion to it (pseudo-Huber): a few walkers have two stable
motions, and their squared errors would outweigh all other rows."""

MIN_LEVEL = 0.05
"""Smallest factor of a row's speed, which vanishes without tilt, whose error is learnt."""

ERROR_FREEDOM = 3.0
"""Degrees of freedom of Student's t, which errors at unseen rows follow over their learnt scale."""

CALIBRATED_SHARE = 0.65
"""Share of the unseen rows, those of least error, that the 95 % bounds are calibrated on."""

MAX_ROW_SE = 0.5
"""Largest standard error (after asinh) of a row that is used."""

MAX_RANGE_RATIO = 6.0
"""Largest ratio of an input's range to its scale."""


class Rows(NamedTuple):
    """Rows of one kind of legs."""

    places: Array
    """Shape (n, numbers)."""
    peak: Array
    """Peak speeds of the plate, mm/s."""
    speed: Array
    """Speeds, mm/s, NaN where no run ended well."""
    se: Array
    runs: Array
    falls: Array
    """Share of the runs that toppled, NaN where it was not kept."""
    held_out: Array

    def select(self, chosen: Array) -> "Rows":
        """Select some of the rows."""
        return Rows(*(column[chosen] for column in self))

    @property
    def transformed(self) -> tuple[Array, Array]:
        """Speeds over the peak speed and their standard errors, after asinh."""
        share = self.speed / self.peak
        return np.arcsinh(share / LINEAR_BELOW), self.se / self.peak / np.hypot(share, LINEAR_BELOW)


class Task(NamedTuple):
    """Training of one network."""

    output: Literal["speed", "error", "chance"]
    """Output: a speed after asinh, the logarithm of its error, or the log-odds of a fall."""
    inputs: Array
    factors: Array
    """Factors of the outputs, whose weighted sum is the value; shape (n, outputs)."""
    values: Array
    """Values to learn, shape (n,): speeds, errors that were made, or whether a run fell."""
    weights: Array
    """Weights of the rows, shape (n,); for errors the variance of their noise."""
    hidden: tuple[int, ...]
    epochs: int
    seed: int


class Unseen(NamedTuple):
    """Rows that no network has seen."""

    inputs: Array
    factors: Array
    values: Array
    se: Array


def load_rows(kind: Kind) -> Rows:
    """Rows of a kind of legs."""
    parts = []
    for row in simulate.read_rows():
        if row["braced"] != (kind == "braced"):
            continue
        case = settings.make_case(row)
        place = places.compute_numbers(case.scene, case.design, solids.mass_of(case.design))
        numbers = [row[name] for name in ("speed_mm_s", "se_mm_s", "runs", "toppled", "held_out")]
        speed, se, runs, toppled, held_out = (math.nan if value is None else value for value in numbers)
        parts.append((place, case.scene.drive.peak_speed, speed, se, runs, toppled / max(runs, 1.0), held_out))
    return Rows(*(np.array(column, float) for column in zip(*parts, strict=True)))


def train_network(task: Task) -> list[Layer]:
    """Train one network on one thread: several are trained at a time."""
    from threadpoolctl import threadpool_limits

    rng = np.random.default_rng(task.seed)
    sizes = [task.inputs.shape[1], *task.hidden, task.factors.shape[1]]
    numbers = []
    for wide, high in pairwise(sizes):
        numbers += [rng.normal(0.0, wide**-0.5, (wide, high)).astype(np.float32), np.zeros((1, high), np.float32)]
    first, second = ([np.zeros_like(number) for number in numbers] for _ in range(2))
    if task.output == "error":
        numbers[-1] += np.float32(math.log(np.median(np.abs(task.values))))
    inputs, factors, values, weights_of = (np.asarray(part, np.float32) for part in task[1:5])
    single = task._replace(inputs=inputs, factors=factors, values=values, weights=weights_of)
    batches, decay = len(task.values) // min(BATCH, len(task.values)), ERROR_DECAY if task.output == "error" else DECAY
    steps, step = task.epochs * batches, 0
    with threadpool_limits(1):
        for _ in range(task.epochs):
            for chosen in np.array_split(rng.permutation(len(task.values)), batches):
                step += 1
                rate = RATE * 0.5 * (1.0 + math.cos(math.pi * step / steps)) * min(1.0, step / WARM_UP_STEPS)
                for k, slope in enumerate(_loss_gradient(numbers, single, chosen)):
                    first[k] += 0.1 * (slope - first[k])
                    second[k] += 0.001 * (slope**2 - second[k])
                    mean, square = first[k] / (1.0 - 0.9**step), second[k] / (1.0 - 0.999**step)
                    shrink = decay * numbers[k] if k % 2 == 0 else 0.0
                    numbers[k] -= np.float32(rate) * (mean / (np.sqrt(square) + 1e-8) + shrink).astype(np.float32)
    return [Layer(weights, bias) for weights, bias in zip(numbers[::2], numbers[1::2], strict=True)]


def _loss_gradient(numbers: Sequence[Array], task: Task, chosen: Array) -> list[Array]:
    """Compute the derivatives of the mean loss of some rows by a network's weights and biases, in their order."""
    layer_inputs, activation_slopes = [task.inputs[chosen]], []
    for weights, bias in zip(numbers[:-2:2], numbers[1:-2:2], strict=True):
        raw = layer_inputs[-1] @ weights + bias
        gate = 0.5 + 0.5 * np.tanh(0.5 * raw)
        layer_inputs.append(raw * gate)
        activation_slopes.append(gate * (1.0 + raw * (1.0 - gate)))
    factors = task.factors[chosen]
    value = ((layer_inputs[-1] @ numbers[-2] + numbers[-1]) * factors).sum(axis=1)
    back = _loss_slope(task, value, chosen)[:, None] * factors / len(chosen)
    slopes: list[Array] = []
    for layer in range(len(layer_inputs) - 1, -1, -1):
        slopes = [layer_inputs[layer].T @ back, back.sum(axis=0, keepdims=True), *slopes]
        if layer:
            back = (back @ numbers[2 * layer].T) * activation_slopes[layer - 1]
    return slopes


def _loss_slope(task: Task, value: Array, chosen: Array) -> Array:
    """Compute the derivative of each chosen row's loss by the network's value there, shape (n,)."""
    target, weights = task.values[chosen], task.weights[chosen]
    if task.output == "chance":  # cross entropy
        return np.asarray(0.5 + 0.5 * np.tanh(0.5 * value) - target)
    if task.output == "speed":  # pseudo-Huber
        return np.asarray(weights * (value - target) / np.hypot(1.0, (value - target) / LINEAR_LOSS_ABOVE))
    own = np.exp(2.0 * value)  # likelihood of Student's t, whose scale is the error and the row's noise
    square = target**2 / (ERROR_FREEDOM * (own + weights))
    return np.asarray(own / (own + weights) * (1.0 - (ERROR_FREEDOM + 1.0) * square / (1.0 + square)))


def train_kind(
    kind: Kind, every: Rows, pool: worker_pool.WorkerPool
) -> tuple[dict[str, Array], dict[str, Any], Unseen]:
    """Return the arrays of one kind of legs, the ranges of its numbers, and its unseen rows."""
    plain, factors = networks.network_inputs(every.places)
    learnt = every.held_out == 0.0
    middle = plain[learnt].mean(axis=0)
    scale = np.maximum(plain[learnt].std(axis=0), np.ptp(plain[learnt], axis=0) / MAX_RANGE_RATIO)
    scale = np.where(scale > 0.0, scale, 1.0)
    inputs = (plain - middle) / scale
    values, se = every.transformed
    good = np.isfinite(values) & (se < MAX_ROW_SE) & ~(every.falls > 0.0)
    chosen = np.flatnonzero(learnt & good)
    terms, uneven = networks.features(inputs), every.places[:, DimensionlessNumbers._fields.index("unevenness_ratio")]
    scatter = fit_scatter(terms[chosen], uneven[chosen], se[chosen], every.runs[chosen])
    weights = 1.0 / (scatter.run_sd(terms, uneven)[chosen] ** 2 / every.runs[chosen] + NETWORK_ERROR**2)
    tenth = np.random.default_rng(NETWORKS).permutation(len(chosen)) % NETWORKS
    left_out = [(tenth - number) % NETWORKS < TENTHS_LEFT_OUT for number in range(NETWORKS)]
    tasks = []
    for number, out in enumerate(left_out):
        part, weight = chosen[~out], weights[~out] / weights[~out].mean()
        learn = inputs[part], factors[part], values[part], weight
        tasks.append(Task("speed", *learn, HIDDEN_LAYERS[kind], EPOCHS[kind], number))
    told = np.flatnonzero(learnt & (np.isfinite(every.falls) | ~good))
    ones, fallen = np.ones((len(told), 1)), ~(every.falls[told] <= 0.0)
    falls = Task("chance", inputs[told], ones, fallen, ones[:, 0], FALL_LAYERS, EPOCHS[kind], 0)
    tasks += [falls._replace(seed=seed) for seed in range(FALL_NETWORKS)]
    trained = list(pool.executor.map(train_network, tasks))
    arrays = {
        **_stack_layers(trained[:NETWORKS], kind),
        **_stack_layers(trained[NETWORKS:], f"{kind}_falls"),
        f"{kind}_middle": middle,
        f"{kind}_scale": scale,
        f"{kind}_prints": scatter.between_prints,
    }
    off = _speeds_left_out(arrays, kind, inputs[chosen], factors[chosen], left_out) - values[chosen]
    arrays |= _train_errors(kind, inputs[chosen], factors[chosen], off, se[chosen], pool)
    low, high = every.places[learnt].min(axis=0), every.places[learnt].max(axis=0)
    ranges = {name: [float(a), float(b)] for name, a, b in zip(DimensionlessNumbers._fields, low, high, strict=True)}
    steepest = max(-ranges["slope_ratio"][0], ranges["slope_ratio"][1])  # mirror images, and upright ones between
    ranges |= {"slope_ratio": [-steepest, steepest], "root_tilt": [0.0, ranges["root_tilt"][1]]}
    # Upright walkers on a level plate have no speed by symmetry: nothing to test
    rest = np.flatnonzero(~learnt & np.isfinite(values) & np.isfinite(se) & (np.abs(factors).sum(axis=1) > 0.0))
    return arrays, ranges, Unseen(inputs[rest], factors[rest], values[rest], se[rest])


def _stack_layers(alike: Sequence[Sequence[Layer]], name: str) -> dict[str, Array]:
    """Arrays, in single precision, of networks of one form."""
    arrays = {}
    for place, layers in enumerate(zip(*alike, strict=True)):
        arrays[f"{name}_weights{place}"] = np.stack([layer.weights for layer in layers]).astype(np.float32)
        arrays[f"{name}_bias{place}"] = np.stack([layer.bias for layer in layers]).astype(np.float32)
    return arrays


def _speeds_left_out(
    arrays: Mapping[str, Array], kind: Kind, inputs: Array, factors: Array, left_out: Sequence[Array]
) -> Array:
    """Compute each row's mean speed, after asinh, from the networks that were trained without it, shape (n,)."""
    speeds = (networks.evaluate(networks.select_layers(arrays, kind), inputs) * factors).sum(axis=-1)
    without = np.array(left_out)
    return np.asarray((speeds * without).sum(axis=0) / without.sum(axis=0))


def _train_errors(
    kind: Kind, inputs: Array, factors: Array, off: Array, se: Array, pool: worker_pool.WorkerPool
) -> dict[str, Array]:
    """Train the networks of the error on `off`, each row's error by networks without it; return their arrays."""
    every_level = networks.error_factor(factors)
    tilted = np.flatnonzero(every_level > MIN_LEVEL)
    level, ones = every_level[tilted], np.ones((len(tilted), 1))
    epochs = round(ERROR_EPOCHS_SHARE * EPOCHS[kind])
    learn = inputs[tilted], ones, off[tilted] / level, (se[tilted] / level) ** 2
    tasks = [Task("error", *learn, ERROR_LAYERS, epochs, seed) for seed in range(ERROR_NETWORKS)]
    return _stack_layers(list(pool.executor.map(train_network, tasks)), f"{kind}_log_error")


def _fit_error_factors(arrays: Mapping[str, Array], kind: Kind, unseen: Unseen) -> Array:
    """Fit the factors of the networks' standard deviation and of the learnt error to unseen rows: two numbers.

    Their ratio makes the unseen rows likeliest, as Student's t with four degrees of freedom, since a few lie far off.
    Their size is such that 95 % of those rows that the surrogate may answer are within bounds of 95 %.
    """
    from scipy.optimize import minimize
    from scipy.stats import t

    speed_layers, log_error = (networks.select_layers(arrays, name) for name in (kind, f"{kind}_log_error"))
    speeds = (networks.evaluate(speed_layers, unseen.inputs) * unseen.factors).sum(axis=-1)
    off = speeds.mean(axis=0) - unseen.values
    parts = networks.error_parts(speeds, log_error, unseen.inputs, unseen.factors)

    def loss(logs: Array) -> float:
        sd = np.sqrt((np.exp(2.0 * logs)[:, None] * parts**2).sum(axis=0) + unseen.se**2)
        return -float(np.sum(t.logpdf(off / sd, 4.0) - np.log(sd)))

    shares = np.exp(minimize(loss, np.log([1.0, 0.5]), method="Nelder-Mead", options={"maxiter": 2000}).x)
    error = np.sqrt((shares[:, None] ** 2 * parts**2).sum(axis=0))
    told = error < np.quantile(error, CALIBRATED_SHARE)
    reach = float(np.quantile(np.abs(off[told]) / np.hypot(error, unseen.se)[told], 0.95))
    return np.asarray(shares * reach / NORMAL_95)


def measure_errors(kind: Kind, every: Rows) -> dict[str, float]:
    """How the surrogate does at held-out rows: what it answers, and how far that is from the runs."""
    unseen = every.select(every.held_out == 1.0)
    speeds = networks.speeds_at(kind, unseen.places)
    speed = unseen.peak * LINEAR_BELOW * np.sinh(speeds.centre)
    error = unseen.peak * LINEAR_BELOW * np.cosh(speeds.centre) * speeds.error
    sure = speeds.falls <= MAX_FALL_CHANCE
    answered = sure & (NORMAL_95 * error <= allowed_error(speed))
    fell = ~(unseen.falls <= 0.0)
    good = answered & np.isfinite(unseen.se)
    off = np.abs(speed - unseen.speed)[good]
    within = settings.goal_error(unseen.speed[good])
    noise = NORMAL_95 * unseen.se[good]
    return {
        "rows": float(len(speed)),
        "answered": float(answered.mean()),
        "median_mm_s": float(np.median(off)),
        "within_goal": float(np.mean(off <= np.hypot(within, noise))),
        "within_goal_noise_not_taken_off": float(np.mean(off <= within)),
        "within_95": float(np.mean(off <= np.hypot(NORMAL_95 * error[good], noise))),
        "fell_where_sure": float(np.mean(fell[sure])),
        "sure_of_those_that_walk": float(np.mean(sure[~fell])),
    }


def main() -> None:
    """Train, write the surrogate, and print its errors at rows that it has not seen."""
    arrays: dict[str, Array] = {}
    facts: dict[str, Any] = {"ranges": {}, "versions": output.versions()}
    by_kind = {kind: load_rows(kind) for kind in HIDDEN_LAYERS}
    with worker_pool.local_pool() as pool:
        for kind, every in by_kind.items():
            of_this, facts["ranges"][kind], unseen = train_kind(kind, every, pool)
            if "flexible_error" not in arrays:  # 28 unseen walkers on braced legs are too few
                factors = _fit_error_factors(of_this, kind, unseen)
                arrays |= {f"{each}_error": factors for each in by_kind}
            arrays |= of_this
    _write_surrogate(arrays, facts)
    facts["errors"] = {kind: measure_errors(kind, every) for kind, every in by_kind.items()}
    _write_surrogate(arrays, facts)
    for kind, numbers in facts["errors"].items():
        print(f"{kind}: " + ", ".join(f"{name} {value:.3g}" for name, value in numbers.items()))


def _write_surrogate(arrays: Mapping[str, Array], facts: Mapping[str, Any]) -> None:
    """Write the file; equal arrays give equal bytes."""
    kept = {**arrays, "facts": np.array(json.dumps(facts))}
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **kept, digest=np.array(networks.hash_arrays(kept)))
    output.write(networks.NETWORK_FILE, stream.getvalue())
    for remembered in (networks.load_arrays, networks.digest, networks.training_facts):
        remembered.cache_clear()


if __name__ == "__main__":
    main()
