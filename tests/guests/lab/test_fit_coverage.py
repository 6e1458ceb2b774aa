"""Bands of `fit` hold what they promise: speeds of model space at hidden parameters."""

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.theory import uncertain_inputs
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab.fit import emulated_speeds, importance_sampling, parameters, posterior
from walkergen.guests.lab.fit.posterior import Observed
from walkergen.points import experiments, walkers

TILTS = (5.0, 8.0, 10.0, 12.0, 15.0, 20.0)
REPETITIONS = 30
FILM_NOISE = 1.5
"""Standard error of a measured speed, mm/s."""
TRUE_SECONDS = 8.0
"""Long enough for an error of a print's speed of 1 mm/s, below that of the film."""


def silent(what, done, total):
    pass


def hidden(ground, rng):
    """Parameters from their priors, and how uneven this printer's prints are."""
    shares = rng.uniform(size=(1, len(ground.unknown.simulated)))
    x = parameters.prior_values(ground.unknown.simulated, shares)[0]
    names = [one.prior.name for one in ground.unknown.simulated]
    found = dict(zip(names, x, strict=True))
    (uneven,) = (one for one in ground.unknown.printed if one.name == "feet.unevenness_um")
    return found | {uneven.name: float(uncertain_inputs.input_quantiles(uneven, rng.uniform(size=1))[0])}


def true_speeds(ground, settings, rng):
    """Speeds of one print in every setting, for each of REPETITIONS printers and plates."""
    asked = []
    for _ in range(REPETITIONS):
        values = hidden(ground, rng)
        for setting in settings:
            run = {"seconds": TRUE_SECONDS, "discard_seconds": 0.5, "runs": 1, "seed": int(rng.integers(2**62))}
            scene = ground.scene.model_copy(update={"run": ground.scene.run.model_copy(update=run)})
            asked.append(experiments.Walker(*uncertain_inputs.apply_inputs(scene, setting.design, values)))
    found = [one.summary.speed.value for one in walkers.simulate_parallel(asked).values()]
    return np.array(found, dtype=float).reshape(REPETITIONS, len(settings))


@pytest.fixture(scope="module")
def world():
    """Emulators of six tilts over the whole prior, and speeds of hidden walkers at all of them."""
    scene = templates.load("plane-90hz", "scenes", Scene)
    design = templates.load("koumakis2016", "walkers", Design)
    unknown = parameters.list_unknowns(scene, design, "space", "flat", {})
    ground = emulated_speeds.FitInputs(scene, "space", unknown)
    settings = [emulated_speeds.Setting(design.variant(tilt_deg=tilt), scene.drive.peak_speed) for tilt in TILTS]
    x = emulated_speeds.sample_parameters(ground, 128)
    y = emulated_speeds.simulate_settings(ground, settings, x, silent, 0)
    responses = [
        emulated_speeds.fit_response(x, speeds, setting, True) for speeds, setting in zip(y, settings, strict=True)
    ]
    truth = true_speeds(ground, settings, np.random.default_rng(7))
    return unknown, responses, truth


@pytest.mark.nightly
@pytest.mark.parametrize("measured", [(5.0, 10.0, 15.0, 20.0), (8.0, 15.0)], ids=["four", "two"])
def test_ninety_percent_of_unmeasured_tilts_lie_in_the_ninety_percent_band(world, measured):
    unknown, responses, truth = world
    rng = np.random.default_rng(len(measured))
    seen = [place for place, tilt in enumerate(TILTS) if tilt in measured]
    ahead = [place for place in range(len(TILTS)) if place not in seen]
    inside, width = [], []
    for speeds in truth:
        filmed = speeds + FILM_NOISE * rng.normal(size=len(speeds))
        observed = [Observed(filmed[[one]], np.array([FILM_NOISE])) for one in seen]
        mine = [responses[place] for place in seen]
        found = importance_sampling.sample(unknown.parameters, observed, mine, 1, silent)
        for place in ahead:
            drawn = posterior.speed_draws(found.draws, responses[place], rng)
            low, high = np.quantile(drawn, (0.05, 0.95))
            inside.append(low <= speeds[place] <= high)
            width.append(high - low)
    share, count = np.mean(inside), len(inside)
    print(f"{share:.3f} of {count} inside; mean width {np.mean(width):.1f} mm/s")
    # Three standard deviations of a binomial share.
    assert abs(share - 0.9) < 3 * np.sqrt(0.9 * 0.1 / count), (share, count)
