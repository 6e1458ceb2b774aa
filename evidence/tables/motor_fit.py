"""From simulated rows of walkers with a motor to their table: a process, and how prints scatter.

Rows are a third of those of plates and depend on half as many numbers more: there a process errs by
less than networks, which learn nothing of them from what plates have (docs/physics.md section 8).
"""

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import fit, process
from evidence.tables.fit import TENTHS, Rows
from evidence.tables.process import Values
from walkergen.files.output import versions
from walkergen.numerics.odd_process import Process
from walkergen.points import worker_pool
from walkergen.theory import motors, surrogate
from walkergen.theory.surrogate import LINEAR_BELOW, transformed

Array = npt.NDArray[Any]

SUPPORTS = 300
"""Rows on which the process rests: of twice as many it errs by no less."""


class Left(NamedTuple):
    """What processes that have not seen it say of each row, after asinh; shape (n,)."""

    centre: Array
    sd: Array
    """Their standard deviation, the row's own noise within."""


def table(simulated: Array, cores: int, supports: int = SUPPORTS) -> dict[str, Array]:
    """Arrays of the table, with `facts` in JSON, of rows in the order of `make.MOTORS.columns`."""
    rows = rows_of(simulated)
    coordinates = motors.coordinates(rows.places)
    middle = np.r_[np.zeros(motors.ODD), coordinates[:, motors.ODD :].mean(axis=0)]
    scale = np.sqrt(((coordinates - middle) ** 2).mean(axis=0))
    scale = np.maximum(scale, np.ptp(coordinates, axis=0) / fit.WIDEST)
    arrays = {"middle": middle, "scale": np.where(scale > 0.0, scale, 1.0)}
    inputs = motors.scaled(arrays, rows.places)
    features, uneven = surrogate.features(motors.even(inputs)), motors.uneven(rows.places)
    arrays["prints"], noise, _ = fit.scatter(features, uneven, rows)
    given = Values(inputs, rows.y, noise)
    left = left_out(given, cores, supports)
    # Honest where lengths, learnt from the rows, promise too much of those left out
    widened = float(np.sqrt(np.mean(((left.centre - rows.y) / left.sd) ** 2)))
    arrays |= process.arrays_of(process.fitted(given, motors.ODD, supports, TENTHS)) | {
        "widened": np.array(max(widened, 1.0))
    }
    wider = left._replace(sd=np.hypot(max(widened, 1.0) * np.sqrt(left.sd**2 - noise), noise**0.5))
    facts = {
        "ranges": {name: ends(name, column) for name, column in zip(motors.NAMES, rows.places.T, strict=True)},
        "errors": errors(rows, wider),
        "versions": versions(),
    }
    return arrays | {"facts": np.array(json.dumps(facts))}


def ends(name: str, column: Array) -> list[float]:
    """Ends of the range of a number, with mirror images and upright walkers between them."""
    low, high = float(column.min()), float(column.max())
    if name in motors.SIGNED:
        return [-max(high, -low), max(high, -low)]
    return [0.0 if name == "root_tilt" else low, high]


def rows_of(simulated: Array) -> Rows:
    """Rows after asinh."""
    *place, speed, se, runs = simulated.T
    y, se = transformed(speed, se)
    return Rows(np.stack(place, axis=1), speed, y, se * np.sqrt(runs), runs)


def left_out(given: Values, cores: int, supports: int) -> Left:
    """What is said of the rows of each tenth by a process of the others."""
    tenth = fit.tenths(len(given.values))
    parts = [Values(*(column[tenth != k] for column in given)) for k in range(TENTHS)]
    centre, variance = np.empty(len(tenth)), np.empty(len(tenth))
    with worker_pool.local(cores) as pool:
        processes = list(pool.executor.map(_fitted, parts, [supports] * TENTHS, range(TENTHS)))
    for k, other in enumerate(processes):
        out = tenth == k
        centre[out], variance[out] = other(given.inputs[out])
    return Left(centre, np.sqrt(variance + given.noise))


def _fitted(given: Values, supports: int, seed: int) -> Process:
    """Process of values, on one thread: several are fitted at a time."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        return process.fitted(given, motors.ODD, supports, seed)


def errors(rows: Rows, left: Left) -> dict[str, dict[str, float]]:
    """Errors at rows left out by tenths, by groups of rows; over the speed of the swing."""
    of = dict(zip(motors.NAMES, rows.places.T, strict=True))
    pairs = of["log_count"] < 1.0
    groups: Mapping[str, Array] = {
        "all": np.ones(len(rows.y), bool),
        "two legs": pairs,
        "three to twelve legs": ~pairs,
        "axis across": np.abs(of["axis_across"]) > 0.5,
        "axis along": np.abs(of["axis_along"]) > 0.5,
        "axis up": np.abs(of["axis_up"]) > 0.5,
        "push below 1.8 weights": of["gamma"] < 1.8,
        "push above 3 weights": of["gamma"] > 3.0,
    }
    speed = LINEAR_BELOW * np.sinh(left.centre)
    off, size = np.abs(speed - rows.speed), np.abs(rows.speed)
    z = (left.centre - rows.y) / left.sd
    return {
        name: {
            "rows": int(chosen.sum()),
            "rms": float(np.sqrt(np.mean((left.centre - rows.y)[chosen] ** 2))),
            "explained": float(1.0 - np.mean((left.centre - rows.y)[chosen] ** 2) / np.mean(rows.y[chosen] ** 2)),
            "median_of_swing": float(np.median(off[chosen])),
            "median_percent": 100.0 * float(np.median((off / size)[chosen & (size > fit.SLOW)])),
            "z_rms": float(np.sqrt(np.mean(z[chosen] ** 2))),
            "z_within_68": float(np.mean(np.abs(z[chosen]) < 1.0)),
            "z_within_95": float(np.mean(np.abs(z[chosen]) < 1.96)),
        }
        for name, chosen in groups.items()
        if chosen.any()
    }


def report(arrays: Mapping[str, Array]) -> str:
    """Errors of a table, as text."""
    lines = [
        "error at rows of motors left out by tenths, their own noise within (speeds over the swing's, after asinh)"
    ]
    for group, numbers_of in json.loads(str(arrays["facts"]))["errors"].items():
        numbers = ", ".join(f"{name} {value:.3g}" for name, value in numbers_of.items())
        lines.append(f"motors, {group}: {numbers}")
    return "\n".join(lines)
