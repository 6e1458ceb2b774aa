"""No switch of an effect waits for a compiler: effects that are off are data of the same types."""

import numba
import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.steps import advance
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

DESIGN = Design()
EFFECTS = {
    "drive": {"frequency_hz": 90.0, "gamma": 1.8, "second_harmonic_ratio": 0.2},
    "effects": {"on": ["air_drag"]},
    "plate": {
        "slope_deg": 2.0,
        "noise_ratio": 0.1,
        "roughness_um": 1.0,
        "horizontal_ratio": [0.1, 0.0],
        "rocking_percent_per_mm": [0.01, 0.0],
    },
    "arena": {"kind": "plane"},
}


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_switching_effects_compiles_nothing():
    kernels = set()
    for tables in ({}, EFFECTS):
        plan = prepare(Scene.model_validate(tables), DESIGN, solids.mass_of(DESIGN)).sample_print(
            np.random.default_rng(0)
        )
        state = plan.initial_state(0.05, 0.0, 0.0)
        plan.advance(state, 1e-4, record.new_tally(len(state)))
        kernels.add(len(advance.outer.signatures))
    assert len(kernels) == 1
