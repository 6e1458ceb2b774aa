"""From simulated rows to a table: networks for the middle, smooth functions for what scatters.

Every network is trained without two tenths of the rows, other tenths each, so that every row is
left out by two of them: their mean there says how well the table interpolates. The table itself is
the mean of all ten.
"""

import io
import json
import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import networks as nets
from evidence.tables.networks import Values
from walkergen.files.output import versions
from walkergen.points import worker_pool
from walkergen.theory import discrepancy, surrogate
from walkergen.theory.discrepancy import Layer
from walkergen.theory.surrogate import LINEAR_BELOW, Place, transformed

Array = npt.NDArray[Any]

TENTHS, OUT = 10, 2
"""Parts of the rows, and number of those that a network leaves out; as many networks as parts."""

HIDDEN = {"flexible": (40, 40, 40), "braced": (8,)}
"""Widths of the networks' layers by kind of legs."""

DECAY, STEPS = 0.1, 1000

ROUGH = 0.1
"""Error (after asinh) that every row has beside its own noise: the fit errs by as much, so that a
row of less noise counts for no more."""

PRIOR = 2.0
"""Precision about zero of the weights of smooth features."""

WIDEST = 6.0
"""Largest ratio of an input's range to its scale."""

PRIOR_RUNS = 3
"""Degrees of freedom by which the smooth scatter of runs counts beside a row's own."""

PEAK_MM_S = 31.2
"""Peak speed of the paper's plate, at which errors are told in mm/s."""

GOAL_SHARE, GOAL_MM_S = 0.04, 0.5
"""Error that half of the rows shall not exceed: of the two the larger."""

SLOW = 0.1
"""Speed over the plate's peak speed below which errors in per cent say nothing."""

NORMAL_MEDIAN = 0.6745
"""Median of the magnitude of a normal number."""

PAPERS_SHAPE, SAME = (7.5 / 13.0, -0.47, math.log(8.0 / 13.0)), 0.01
"""Length ratio, logarithms of gyration and width ratio of the paper's flexible walker."""


class Rows(NamedTuple):
    """Rows of one kind of legs, after asinh."""

    places: Array
    speed: Array
    """Speeds over the plate's peak speed."""
    y: Array
    spread: Array
    """Standard deviation of a row's runs."""
    runs: Array


def rows_of(table: Array, braced: bool) -> Rows:
    """Rows of one kind of legs, of a table in the order of `make.COLUMNS`."""
    kinds, *_ = table.T
    _, *place, speed, se, runs = table[kinds == braced].T
    y, se = transformed(speed, se)
    return Rows(np.stack(place, axis=1), speed, y, se * np.sqrt(runs), runs)


def table(simulated: Array, cores: int, steps: int = STEPS) -> dict[str, Array]:
    """Arrays of the table, with `facts` in JSON: ranges of places and errors by kind of legs."""
    arrays: dict[str, Array] = {}
    ranges, errors = {}, {}
    for kind in ("flexible", "braced"):
        rows = rows_of(simulated, kind == "braced")
        low, high = Place(*rows.places.min(axis=0)), Place(*rows.places.max(axis=0))
        # Mirror images, and upright walkers between them, are in the table too
        steepest = max(high.slope_ratio, -low.slope_ratio)
        low = low._replace(root_tilt=0.0, slope_ratio=-steepest)
        high = high._replace(slope_ratio=steepest)
        ranges[kind] = {name: [float(getattr(low, name)), float(getattr(high, name))] for name in Place._fields}
        of_kind, errors[kind] = _of_kind(kind, rows, cores, steps)
        arrays |= of_kind
    facts = {"ranges": ranges, "errors": errors, "versions": versions()}
    return arrays | {"facts": np.array(json.dumps(facts))}


def _of_kind(kind: str, rows: Rows, cores: int, steps: int) -> tuple[dict[str, Array], dict[str, Any]]:
    """Arrays of one kind of legs, and its errors by groups of rows."""
    inputs, factors = discrepancy.coordinates(rows.places)
    middle = inputs.mean(axis=0)
    scale = np.maximum(inputs.std(axis=0), np.ptp(inputs, axis=0) / WIDEST)  # most have no extras
    scale = np.where(scale > 0.0, scale, 1.0)
    inputs = (inputs - middle) / scale
    features = surrogate.features(inputs)
    uneven = np.asarray(Place(*rows.places.T).unevenness_ratio)
    between, noise, weights = scatter(features, uneven, rows)
    training = Values(inputs, factors, rows.y, weights)
    tenth = tenths(len(rows.y))
    trained, left_out = networks(training, tenth, HIDDEN[kind], cores, steps)
    error = log_sd(features, left_out - rows.y, noise)
    arrays = {
        **nets.arrays_of(trained, kind),
        f"{kind}_middle": middle,
        f"{kind}_scale": scale,
        f"{kind}_error": error,
        f"{kind}_prints": between,
    }
    errors = _errors(rows, left_out, np.sqrt(noise), surrogate.smooth(features, error))
    prints = uneven * surrogate.smooth(features, between)
    errors["all"]["prints_sd_median_percent"] = 100.0 * _median(prints[uneven > 0.0])
    return arrays, errors


def tenths(count: int) -> Array:
    """Number of the tenth that each of so many rows belongs to, shape (count,)."""
    return np.random.default_rng(TENTHS).permutation(count) % TENTHS


def networks(
    training: Values, tenth: Array, hidden: tuple[int, ...], cores: int, steps: int
) -> tuple[list[list[Layer]], Array]:
    """The networks, and values at every row by those that have not seen it."""
    trained_on = [((tenth - k) % TENTHS) >= OUT for k in range(TENTHS)]
    parts = [Values(*(column[rows] for column in training)) for rows in trained_on]
    with worker_pool.local(cores) as pool:
        trained = list(pool.executor.map(_trained, parts, [hidden] * TENTHS, [steps] * TENTHS, range(TENTHS)))
    total = np.zeros(len(training.values))
    for layers, rows in zip(trained, trained_on, strict=True):
        outputs = discrepancy.evaluated(layers, training.inputs[~rows])
        total[~rows] += (outputs * training.factors[~rows]).sum(axis=1) / OUT
    return trained, total


def _trained(training: Values, hidden: tuple[int, ...], steps: int, seed: int) -> list[Layer]:
    """A network, on one thread: several are trained at a time."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        return nets.trained(training, hidden, DECAY, steps, seed)


def scatter(features: Array, uneven: Array, rows: Rows) -> tuple[Array, Array, Array]:
    """Weights of the scatter of prints over `uneven`, as a smooth function of the features;
    variances of the rows' means; and what an error of each row counts, 1 on average.
    """
    in_time, between = _scatter(features, uneven, rows)
    variance = surrogate.smooth(features, in_time) ** 2
    variance += (uneven * surrogate.smooth(features, between)) ** 2
    freedom = rows.runs - 1.0
    noise = (freedom * rows.spread**2 + PRIOR_RUNS * variance) / (freedom + PRIOR_RUNS) / rows.runs
    weights = 1.0 / (noise + ROUGH**2)
    return between, noise, weights / weights.mean()


def _scatter(features: Array, uneven: Array, rows: Rows) -> tuple[Array, Array]:
    """Logarithms of the scatter of runs in time, and of that of prints over `uneven`.

    As weights of smooth features: the likeliest of variances of `rows.runs` normal numbers each.
    """
    half, observed = 0.5 * (rows.runs - 1.0), np.maximum(rows.spread**2, 1e-6)

    def loss(values: Array) -> tuple[float, Array]:
        in_time, between = values.reshape(2, -1)
        first = surrogate.smooth(features, in_time) ** 2
        second = (uneven * surrogate.smooth(features, between)) ** 2
        variance = first + second
        total = float(half @ (np.log(variance) + observed / variance))
        slope = 2.0 * half * (1.0 - observed / variance) / variance
        slopes = np.concatenate([features.T @ (slope * first), features.T @ (slope * second)])
        return total + PRIOR * float(values @ values), slopes + 2.0 * PRIOR * values

    start = np.zeros(2 * features.shape[1])
    start[0], start[features.shape[1]] = -3.0, -1.0
    in_time, between = _least(loss, start).reshape(2, -1)
    return in_time, between


def log_sd(features: Array, residual: Array, noise: Array) -> Array:
    """Logarithm of the standard deviation of residuals beyond their noise's variance, as weights
    of smooth features: the likeliest of normal residuals.
    """

    def loss(weights: Array) -> tuple[float, Array]:
        excess = surrogate.smooth(features, weights) ** 2
        variance = excess + noise
        total = 0.5 * float(np.sum(np.log(variance) + residual**2 / variance))
        slope = (1.0 - residual**2 / variance) / variance * excess
        return total + PRIOR * float(weights @ weights), features.T @ slope + 2.0 * PRIOR * weights

    return _least(loss, np.r_[-2.0, np.zeros(features.shape[1] - 1)])


def _least(loss: Any, start: Array) -> Array:
    from scipy.optimize import minimize

    bounds = [(-6.0, 6.0)] * len(start)
    first = float(np.linalg.norm(loss(start)[1]))  # so that the first step is a short one

    def scaled(values: Array) -> tuple[float, Array]:
        total, slopes = loss(values)
        return total / first, slopes / first

    solution = minimize(scaled, start, jac=True, method="L-BFGS-B", bounds=bounds)
    return np.asarray(solution.x)


def _errors(rows: Rows, left_out: Array, noise: Array, sd: Array) -> dict[str, Any]:
    """Errors at rows left out by tens, which hold the noise of the rows themselves as well.

    That noise is a tenth of the error's size where it is a tenth of its square; what the table
    says of the error, "interpolation", is without it.
    """
    speed = LINEAR_BELOW * np.sinh(left_out)
    slope = np.hypot(rows.speed, LINEAR_BELOW)
    peak = PEAK_MM_S
    by_group = {}
    for group, chosen in _groups(rows.places).items():
        if not chosen.any():
            continue
        off, size = np.abs(speed - rows.speed)[chosen], np.abs(rows.speed)[chosen]
        share = 100.0 * off[size > SLOW] / size[size > SLOW]
        z = ((left_out - rows.y) / np.hypot(noise, sd))[chosen]
        allowed = np.maximum(GOAL_SHARE * size, GOAL_MM_S / peak)
        by_group[group] = {
            "rows": int(chosen.sum()),
            "median_mm_s": peak * _median(off),
            "ninety_percent_mm_s": peak * _quantile(off, 0.9),
            "median_percent": _median(share),
            "ninety_percent_percent": _quantile(share, 0.9),
            "median_over_goal": _median(off / allowed),
            "noise_over_goal": NORMAL_MEDIAN * _median((noise * slope)[chosen] / allowed),
            "interpolation_sd_median_percent": 100.0 * _median(sd[chosen]),
            "z_rms": float(np.sqrt(np.mean(z**2))),
            "z_within_68": float(np.mean(np.abs(z) < 1.0)),
            "z_within_95": float(np.mean(np.abs(z) < 1.96)),
        }
    return by_group


def _groups(places: Array) -> dict[str, npt.NDArray[np.bool_]]:
    """Rows of which errors are told: all, by what they have beside the usual, and the paper's."""
    place = Place(*places.T)
    slope, noise = place.slope_ratio != 0.0, place.noise_ratio != 0.0
    harmonic = np.hypot(place.harmonic_cos, place.harmonic_sin) != 0.0
    plain = ~(slope | noise | harmonic)
    shapes = np.column_stack([place.length_ratio, place.log_gyration_ratio, place.log_width_ratio])
    shape = np.abs(shapes - PAPERS_SHAPE).max(axis=1) < SAME
    return {
        "all": np.ones(len(places), bool),
        "paper's walker": plain & shape,
        "other walkers": plain & ~shape,
        "second harmonic": harmonic,
        "slope": slope,
        "noise": noise,
    }


def _median(values: Array) -> float:
    return _quantile(values, 0.5)


def _quantile(values: Array, share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else 0.0


def report(arrays: dict[str, Array]) -> str:
    """Errors of a table, as text."""
    errors = json.loads(str(arrays["facts"]))["errors"]
    lines = ["error at rows left out by tens, their own noise within (mm/s of a plate at 31 mm/s)"]
    for kind, groups in errors.items():
        for group, numbers_of in groups.items():
            numbers = ", ".join(f"{name} {value:.3g}" for name, value in numbers_of.items())
            lines.append(f"{kind}, {group}: {numbers}")
    return "\n".join(lines)


def as_bytes(arrays: dict[str, Array]) -> bytes:
    """File of the table, for `numpy.load`; equal arrays give equal bytes."""
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    return stream.getvalue()
