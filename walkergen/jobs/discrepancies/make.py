"""Table of speeds of the model in space over the range in which people build walkers.

`python -m walkergen.jobs.discrepancies.make` writes walkergen/discrepancy.json anew; the theory's
own error is interpolated in it (walkergen/discrepancy.py).
"""

import json
import sys
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen import discrepancy, uncertain
from walkergen.discrepancy import LINEAR_BELOW, Place
from walkergen.errors import GeometryError
from walkergen.files import output
from walkergen.scene import Arena, Contact, Drive, Feet, Run, Scene
from walkergen.simulation import points
from walkergen.simulation.points import Asked
from walkergen.simulation.run import ENDED_WELL
from walkergen.walker import solids
from walkergen.walker.body import Body
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind, Legs

Array = npt.NDArray[np.float64]

FAR, NEAR, BRACED, SEED = 1024, 512, 64, 12
RUNS, SECONDS, DISCARD_S = 6, 2.0, 0.5

RANGES = {
    "tilt_share": (0.0, 1.0),
    "restitution": (0.02, 1.0),
    "log_friction": (np.log(0.05), np.log(0.6)),
    "gamma": (1.1, 3.0),
    "log_frequency_hz": (np.log(50.0), np.log(150.0)),
    "thickness_mm": (0.25, 0.8),
    "length_mm": (5.0, 10.0),
    "spacing_mm": (9.0, 17.0),
    "unevenness": (-0.1, 0.25),
    "body_length_mm": (22.0, 36.0),
    "body_thickness_mm": (2.0, 5.0),
    "depth_mm": (5.0, 12.0),
}
"""Ranges that are sampled evenly: tilts from 0 to 45 degrees, half of them below 20, where speeds
change most; negative unevenness (over the plate's amplitude) means none."""

USUAL = RANGES | {
    "tilt_share": (0.07, 0.6),
    "restitution": (0.1, 0.95),
    "log_friction": (np.log(0.1), np.log(0.5)),
    "gamma": (1.3, 2.6),
    "log_frequency_hz": (np.log(70.0), np.log(120.0)),
    "thickness_mm": (0.3, 0.6),
    "length_mm": (6.0, 9.0),
    "spacing_mm": (11.0, 15.0),
}
"""Ranges in which most walkers are made, sampled once more."""


class Case(NamedTuple):
    """Walker and scene of one row of the table."""

    scene: Scene
    design: Design


def cases(
    kind: Kind, ranges: dict[str, tuple[float, float]], count: int, seed: int = SEED
) -> Iterator[Case]:
    """Walkers and scenes, by a scrambled Sobol sequence; what cannot be built is left out."""
    low, high = np.array(list(ranges.values())).T
    for values in low + (high - low) * uncertain.even(len(ranges), count, seed):
        one = dict(zip(ranges, values.tolist(), strict=True))
        body = Body(length_mm=one["body_length_mm"], thickness_mm=one["body_thickness_mm"],
                    depth_mm=one["depth_mm"])  # fmt: skip
        legs = Legs(
            kind=kind,
            tilt_deg=45.0 * one["tilt_share"] ** np.emath.logn(0.5, 20.0 / 45.0),
            length_mm=one["length_mm"],
            flexible_thickness_mm=one["thickness_mm"],
            contact_spacing_mm=one["spacing_mm"],
        )
        drive = Drive(frequency_hz=float(np.exp(one["log_frequency_hz"])), gamma=one["gamma"])
        scene = Scene(
            drive=drive,
            contact=Contact(restitution=one["restitution"],
                            friction=float(np.exp(one["log_friction"]))),
            arena=Arena(kind="plane"),
            feet=Feet(unevenness_um=1e3 * drive.amplitude * max(one["unevenness"], 0.0)),
            run=Run(seconds=SECONDS, discard_seconds=DISCARD_S, runs=RUNS),
        )  # fmt: skip
        try:
            yield Case(scene, Design(body=body, legs=legs))
        except GeometryError:
            continue


def measure(case: Case) -> list[float] | None:
    """Simulate one row: place, speed over plate speed, its standard error, runs.

    None when fewer than two runs ended well.
    """
    mass = solids.mass_of(case.design)
    point = points.measure(Asked(case.scene, case.design, mass), lambda what, done, total: None)
    good = [result.speed for result in point.results if result.outcome in ENDED_WELL]
    if len(good) < 2:
        return None
    speeds = np.array(good) / case.scene.drive.peak_speed
    error = float(speeds.std(ddof=1) / np.sqrt(len(good)))
    place = discrepancy.place_of(case.scene, case.design, mass)
    return [float(f"{value:.6g}") for value in (*place, speeds.mean(), error, len(good))]


def fitted(flexible: Array, braced: Array) -> dict[str, Any]:
    """Table with the lengths and the noise of the process that is most likely to have made it.

    Rows as `measure` makes them. What varies from print to print is in the noise of six prints'
    mean and in `sd` that of one.
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    errors = discrepancy.transformed(flexible[:, -3], flexible[:, -2])[1]
    prints = float(np.median(np.sqrt(flexible[:, -1]) * errors))
    flexible = np.vstack([flexible, upright(flexible)])
    places = flexible[:, :-3]
    x = discrepancy.coordinates(places)
    y, se = discrepancy.transformed(flexible[:, -3], flexible[:, -2])
    scale = x.std(axis=0)
    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern(np.full(x.shape[1], 3.0), (0.2, 200.0),
                                                       nu=1.5)  # fmt: skip
    process = GaussianProcessRegressor(kernel + WhiteKernel(0.02, (4e-4, 1.0)), alpha=se**2)
    with warnings.catch_warnings():
        # A length at its bound says that a number does not matter: that is an answer.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(x / scale, y)
    found = process.kernel_
    noise = float(np.sqrt(found.k2.noise_level))
    low, high = places.min(axis=0), places.max(axis=0)
    return {
        "ranges": {name: [low[k], high[k]] for k, name in enumerate(Place._fields)},
        "lengths": (scale * found.k1.k2.length_scale).tolist(),
        "amplitude": float(found.k1.k1.constant_value),
        "noise": noise,
        "sd": float(np.hypot(noise, prints)),
        "braced_sd": float(np.sqrt(np.mean(np.arcsinh(braced[:, -3] / LINEAR_BELOW) ** 2))),
        "columns": [*Place._fields, "speed", "se", "runs"],
        "rows": flexible.tolist(),
    }


def upright(rows: Array) -> Array:
    """Every eighth walker with its legs upright, which does not run: by symmetry, not simulated."""
    found = rows[::8].copy()
    found[:, 0], found[:, -3:] = 0.0, (0.0, 0.01, 1)
    return found


def main() -> None:
    """Write the table, with its progress on the error stream."""
    made: dict[Kind, list[list[float]]] = {"flexible": [], "braced": []}
    every = [
        *cases("flexible", RANGES, FAR),
        *cases("flexible", USUAL, NEAR),
        *cases("braced", RANGES, BRACED),
    ]
    for number, case in enumerate(every, start=1):
        row = measure(case)
        if row is not None:
            made[case.design.kind].append(row)
        if number % 16 == 0 or number == len(every):
            print(f"{number} of {len(every)}", file=sys.stderr, flush=True)
    write(np.array(made["flexible"]), np.array(made["braced"]))


def write(flexible: Array, braced: Array) -> None:
    """Write the table, a row a line."""
    table = fitted(flexible, braced)
    rows = ",\n".join(json.dumps(row) for row in table.pop("rows"))
    text = json.dumps(table, indent=1)[:-2] + f',\n "rows": [\n{rows}\n ]\n}}\n'
    output.write(discrepancy.TABLE, text.encode())


if __name__ == "__main__":
    main()
