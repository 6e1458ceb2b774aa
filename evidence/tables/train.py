"""Training of the surrogate on the rows: `python -m evidence.tables.train` writes walkergen/core/theory/surrogate.npz.

Ten networks, each without two tenths of the rows; a few smaller ones say where walkers fall. What the ten
differ by, times a factor, and a least error are fitted to held-out rows, which no network has seen.
"""

import io
import json
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import settings, simulate
from evidence.tables.scatter import fit_scatter
from walkergen.core.files import output
from walkergen.core.theory import dimensionless as places
from walkergen.core.theory import networks
from walkergen.core.theory.dimensionless import Place
from walkergen.core.theory.networks import LINEAR_BELOW, Layer
from walkergen.core.theory.surrogate import MAX_ERROR_MM_S, MAX_ERROR_SHARE, MAX_FALL_CHANCE, NORMAL_95
from walkergen.core.walker import solids
from walkergen.core.walker.limbs import Kind
from walkergen.points import worker_pool

Array = npt.NDArray[Any]

NETWORKS, TENTHS_LEFT_OUT = 10, 2
"""Number of networks, and of the tenths of the rows that each is trained without."""

HIDDEN_LAYERS: Mapping[Kind, tuple[int, ...]] = {"flexible": (64, 64, 64), "braced": (12, 12)}
FALL_LAYERS = (24, 24)
"""Widths of the networks' layers; of those that know where walkers fall."""

EPOCHS, BATCH, RATE, DECAY, WARM_UP_STEPS = 600, 256, 0.003, 0.12, 300
"""Passes through the rows, rows of a step, its first length, share of it that weights shrink by, and steps while
it grows: Adam (Kingma and Ba, arXiv 1412.6980) with decay apart (Loshchilov and Hutter, arXiv 1711.05101)."""

NETWORK_ERROR = 0.08
"""Error (after asinh) of every row in addition to its own noise: so much the networks err, and a row of less noise
counts for no more."""

CALIBRATED_SHARE = 0.5
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
    """What a network shall give."""

    inputs: Array
    factors: Array
    """Factors of the outputs, whose weighted sum is the value; shape (n, outputs)."""
    values: Array
    weights: Array
    """What an error counts, shape (n,)."""
    hidden: tuple[int, ...]
    chance: bool
    """Whether values are chances, learnt by their cross entropy, not by squared errors."""
    seed: int


class Unseen(NamedTuple):
    """Rows that no network has seen."""

    inputs: Array
    factors: Array
    values: Array
    se: Array
    scatter: Array
    """Standard deviation of a run, by the smooth function."""


def load_rows(kind: Kind) -> Rows:
    """Rows of a kind of legs."""
    parts = []
    for row in simulate.read_rows():
        if row["braced"] != (kind == "braced"):
            continue
        case = settings.make_case(row)
        place = places.compute_place(case.scene, case.design, solids.mass_of(case.design))
        numbers = [row[name] for name in ("speed_mm_s", "se_mm_s", "runs", "toppled", "held_out")]
        speed, se, runs, toppled, held_out = (math.nan if value is None else value for value in numbers)
        parts.append((place, case.scene.drive.peak_speed, speed, se, runs, toppled / max(runs, 1.0), held_out))
    return Rows(*(np.array(column, float) for column in zip(*parts, strict=True)))


def train_network(task: Task) -> list[Layer]:
    """Network of least weighted error, on one thread: several are trained at a time."""
    from threadpoolctl import threadpool_limits

    rng = np.random.default_rng(task.seed)
    sizes = [task.inputs.shape[1], *task.hidden, task.factors.shape[1]]
    numbers = []
    for wide, high in pairwise(sizes):
        numbers += [rng.normal(0.0, wide**-0.5, (wide, high)).astype(np.float32), np.zeros((1, high), np.float32)]
    first, second = ([np.zeros_like(number) for number in numbers] for _ in range(2))
    inputs, factors, values, weights_of = (np.asarray(part, np.float32) for part in task[:4])
    single = task._replace(inputs=inputs, factors=factors, values=values, weights=weights_of)
    batches = len(task.values) // min(BATCH, len(task.values))
    steps, step = EPOCHS * batches, 0
    with threadpool_limits(1):
        for _ in range(EPOCHS):
            for chosen in np.array_split(rng.permutation(len(task.values)), batches):
                step += 1
                rate = RATE * 0.5 * (1.0 + math.cos(math.pi * step / steps)) * min(1.0, step / WARM_UP_STEPS)
                for k, slope in enumerate(_loss_gradient(numbers, single, chosen)):
                    first[k] += 0.1 * (slope - first[k])
                    second[k] += 0.001 * (slope**2 - second[k])
                    mean, square = first[k] / (1.0 - 0.9**step), second[k] / (1.0 - 0.999**step)
                    shrink = DECAY * numbers[k] if k % 2 == 0 else 0.0
                    numbers[k] -= np.float32(rate) * (mean / (np.sqrt(square) + 1e-8) + shrink).astype(np.float32)
    return [Layer(weights, bias) for weights, bias in zip(numbers[::2], numbers[1::2], strict=True)]


def _loss_gradient(numbers: Sequence[Array], task: Task, chosen: Array) -> list[Array]:
    """Compute the derivatives of the mean loss of some rows by a network's numbers, in their order."""
    passed = [task.inputs[chosen]]
    for weights, bias in zip(numbers[:-2:2], numbers[1:-2:2], strict=True):
        passed.append(np.tanh(passed[-1] @ weights + bias))
    factors = task.factors[chosen]
    value = ((passed[-1] @ numbers[-2] + numbers[-1]) * factors).sum(axis=1)
    value = 1.0 / (1.0 + np.exp(-value)) if task.chance else value
    back = (task.weights[chosen] * (value - task.values[chosen]))[:, None] * factors / len(chosen)
    slopes: list[Array] = []
    for place in range(len(passed) - 1, -1, -1):
        slopes = [passed[place].T @ back, back.sum(axis=0, keepdims=True), *slopes]
        back = (back @ numbers[2 * place].T) * (1.0 - passed[place] ** 2)
    return slopes


def train_kind(kind: Kind, every: Rows, pool: worker_pool.WorkerPool) -> tuple[dict[str, Array], dict[str, Any]]:
    """Arrays of one kind of legs, and its ranges and errors."""
    plain, factors = networks.network_inputs(every.places)
    learnt = every.held_out == 0.0
    middle = plain[learnt].mean(axis=0)
    scale = np.maximum(plain[learnt].std(axis=0), np.ptp(plain[learnt], axis=0) / MAX_RANGE_RATIO)
    scale = np.where(scale > 0.0, scale, 1.0)
    inputs = (plain - middle) / scale
    values, se = every.transformed
    good = np.isfinite(values) & (se < MAX_ROW_SE) & ~(every.falls > 0.0)
    chosen = np.flatnonzero(learnt & good)
    terms, uneven = networks.features(inputs), every.places[:, Place._fields.index("unevenness_ratio")]
    found = fit_scatter(terms[chosen], uneven[chosen], se[chosen], every.runs[chosen])
    weights = 1.0 / (found.run_sd(terms, uneven)[chosen] ** 2 / every.runs[chosen] + NETWORK_ERROR**2)
    tenth = np.random.default_rng(NETWORKS).permutation(len(chosen)) % NETWORKS
    tasks = []
    for number in range(NETWORKS):
        part = chosen[(tenth - number) % NETWORKS >= TENTHS_LEFT_OUT]
        weight = weights[(tenth - number) % NETWORKS >= TENTHS_LEFT_OUT]
        tasks.append(
            Task(inputs[part], factors[part], values[part], weight / weight.mean(), HIDDEN_LAYERS[kind], False, number)
        )
    told = np.flatnonzero(learnt & (np.isfinite(every.falls) | ~good))
    fallen = ~(every.falls[told] <= 0.0)
    ones = np.ones((len(told), 1))
    tasks += [Task(inputs[told], ones, fallen, ones[:, 0], FALL_LAYERS, True, seed) for seed in range(TENTHS_LEFT_OUT)]
    ten = list(pool.executor.map(train_network, tasks))
    arrays = {
        **_stack_layers(ten[:NETWORKS], kind),
        **_stack_layers(ten[NETWORKS:], f"{kind}_falls"),
        f"{kind}_middle": middle,
        f"{kind}_scale": scale,
        f"{kind}_in_time": found.in_time,
        f"{kind}_prints": found.between_prints,
    }
    low, high = every.places[learnt].min(axis=0), every.places[learnt].max(axis=0)
    ranges = {name: [float(a), float(b)] for name, a, b in zip(Place._fields, low, high, strict=True)}
    steepest = max(-ranges["slope_ratio"][0], ranges["slope_ratio"][1])  # mirror images, and upright ones between
    ranges |= {"slope_ratio": [-steepest, steepest], "root_tilt": [0.0, ranges["root_tilt"][1]]}
    # Upright walkers on a level plate have no speed by symmetry: nothing to test
    rest = np.flatnonzero(~learnt & np.isfinite(values) & np.isfinite(se) & (np.abs(factors).sum(axis=1) > 0.0))
    run_sd = found.run_sd(terms, uneven)
    unseen = Unseen(inputs[rest], factors[rest], values[rest], se[rest], run_sd[rest])
    arrays[f"{kind}_error"] = _fit_error_factors(arrays, kind, unseen)
    return arrays, ranges


def _stack_layers(alike: Sequence[Sequence[Layer]], name: str) -> dict[str, Array]:
    """Arrays, in single precision, of networks of one form."""
    arrays = {}
    for place, layers in enumerate(zip(*alike, strict=True)):
        arrays[f"{name}_weights{place}"] = np.stack([layer.weights for layer in layers]).astype(np.float32)
        arrays[f"{name}_bias{place}"] = np.stack([layer.bias for layer in layers]).astype(np.float32)
    return arrays


def _fit_error_factors(arrays: Mapping[str, Array], kind: Kind, unseen: Unseen) -> Array:
    """Factors of what the networks differ by and of the runs' scatter, and least error: three numbers.

    In the proportion that makes the unseen rows likeliest (as Student's t with four degrees of freedom: a few lie
    far off), and so large that bounds of 95 % hold as many of those that the surrogate may answer.
    """
    from scipy.optimize import minimize
    from scipy.stats import t

    count = len(HIDDEN_LAYERS[kind]) + 1
    layers = [Layer(arrays[f"{kind}_weights{k}"], arrays[f"{kind}_bias{k}"]) for k in range(count)]
    said = (networks.evaluate(layers, unseen.inputs) * unseen.factors).sum(axis=-1)
    off, odd = said.mean(axis=0) - unseen.values, np.minimum(np.abs(unseen.factors).sum(axis=1), 1.0)
    parts = np.stack([said.std(axis=0, ddof=1), unseen.scatter * odd, odd])

    def loss(logs: Array) -> float:
        sd = np.sqrt((np.exp(2.0 * logs)[:, None] * parts**2).sum(axis=0) + unseen.se**2)
        return -float(np.sum(t.logpdf(off / sd, 4.0) - np.log(sd)))

    shares = np.exp(minimize(loss, np.log([1.5, 0.1, 0.03]), method="Nelder-Mead", options={"maxiter": 2000}).x)
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
    goal = np.maximum(MAX_ERROR_SHARE * np.abs(speed), MAX_ERROR_MM_S)
    sure = speeds.falls <= MAX_FALL_CHANCE
    answered = sure & (NORMAL_95 * error <= goal)
    fell = ~(unseen.falls <= 0.0)
    good = answered & np.isfinite(unseen.se)
    off = np.abs(speed - unseen.speed)[good]
    within = np.maximum(MAX_ERROR_SHARE * np.abs(unseen.speed[good]), MAX_ERROR_MM_S)
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
            of_this, facts["ranges"][kind] = train_kind(kind, every, pool)
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
    for remembered in (networks.load_arrays, networks.digest, networks.training_facts, networks.load_layers):
        remembered.cache_clear()


if __name__ == "__main__":
    main()
