"""Effective radius of the tips of the paper's feet, from all that the paper states.

`python -m evidence.tables.contact` prints it, for `feet.tip_radius_um` and `scene.PAPER_CONTACT`. By Bayes' rule over
draws of a prediction: the radius is drawn evenly in its logarithm, or nearly so; restitution and friction as measured;
thickness, modulus and feet as a print may have them, new prints for each tilt. The model's own error is left out: the
radius takes up what it is for the paper's walkers, and predictions of others add it.
"""

import math
from typing import NamedTuple

import numpy as np

from evidence.published import FACTS
from walkergen.core.numerics import Array
from walkergen.core.scene import Feet, Prediction, Scene
from walkergen.core.theory import dimensionless, prediction, uncertain_inputs
from walkergen.core.theory.prediction import PRINT_INPUT
from walkergen.core.theory.surrogate import SurrogateCase
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

SD_TO_MARGIN = 2.0
"""Standard deviations from a stated value to the ends of its margin: 95 % lie between."""

DRAWS, SEED = 2**15, 60

PRIOR_FACTOR = 6.0
"""Factor of a standard deviation of the radius beforehand: little is known."""

TILTS_DEG = (2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 20.0, 35.0)
"""Tilts between which the fastest is looked for."""


class Posterior(NamedTuple):
    """What the paper's speeds say of the radius."""

    radius_um: float
    """Median."""
    factor: float
    """Factor of one standard deviation of its logarithm."""
    effective: float
    """Number of draws that the weighted ones are worth."""
    speed: Array
    """Median speeds at TILTS_DEG by the draws so weighted, mm/s."""


def sample_speeds() -> tuple[Array, Array]:
    """Return radii (um), shape (n,), and speeds (mm/s) of the paper's walkers at TILTS_DEG, shape (n, 8)."""
    scene = Scene(feet=Feet(tip_radius_sd_factor=PRIOR_FACTOR), prediction=Prediction(model_sd=0.0))
    rows = []
    for number, tilt in enumerate(TILTS_DEG):
        design = Design().variant(tilt_deg=tilt)
        inputs = prediction.prediction_inputs(scene, design)
        drawn = uncertain_inputs.label_columns(inputs, uncertain_inputs.sample_inputs(inputs, DRAWS, SEED))
        unevenness = np.random.default_rng([SEED, number]).standard_normal(DRAWS)
        prints = drawn._replace(columns={**drawn.columns, PRINT_INPUT.name: unevenness})
        known = SurrogateCase(design, scene, dimensionless.compute_numbers(scene, design, solids.mass_of(design)))
        rows.append(prediction.speeds_with_errors(known, prints))
    return drawn.columns["feet.tip_radius_um"], np.array(rows).T


def likelihood(speed: Array) -> Array:
    """Weights of draws by the paper's statements, shape (n,); `speed` is as `sample_speeds` returns it."""
    tilts = np.array(TILTS_DEG)
    fastest = tilts[np.argmax(speed, axis=1)]
    weights = np.ones(len(speed))
    for ours, key in ((speed.max(axis=1), "peak speed"), (fastest, "peak tilt")):
        fact = FACTS[key]
        sd = (fact.high - fact.value) / SD_TO_MARGIN
        weights *= np.exp(-0.5 * ((ours - fact.value) / sd) ** 2)
    at = {tilt: speed[:, place] for place, tilt in enumerate(TILTS_DEG)}
    # "10°, 15°, 35° corresponding to high, medium and low propulsion efficiency"
    return weights * ((at[10.0] > at[15.0]) & (at[15.0] > at[35.0]))


def compute_posterior() -> Posterior:
    """Return the radius and its factor, given the paper's statements."""
    radii, speed = sample_speeds()
    weights = likelihood(speed)
    weights /= weights.sum()
    logs = np.log(radii)
    mean = float(weights @ logs)
    sd = float(np.sqrt(weights @ (logs - mean) ** 2))
    order = np.argsort(speed, axis=0)
    middle = [float(speed[rows, k][np.searchsorted(np.cumsum(weights[rows]), 0.5)]) for k, rows in enumerate(order.T)]
    return Posterior(math.exp(mean), math.exp(sd), float(1.0 / (weights @ weights)), np.array(middle))


def main() -> None:
    """Print the radius, and the speeds that go with it."""
    found = compute_posterior()
    print(f"radius {found.radius_um:.2f} um, factor {found.factor:.2f}, from draws worth {found.effective:.0f} ones")
    for tilt, speed in zip(TILTS_DEG, found.speed, strict=True):
        print(f"{tilt:5.1f} deg {speed:6.1f} mm/s")


if __name__ == "__main__":
    main()
