"""No switch of an effect waits for a compiler: effects that are off are data of the same types."""

import numba
import numpy as np
import pytest

from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

DESIGN = Design()
HARMONIC = {"drive": {"frequency_hz": 90.0, "gamma": 1.8, "second_harmonic_ratio": 0.2}}
AIR = {"effects": {"on": ["air_drag"]}}
SLOPE = {"plate": {"slope_deg": 2.0}}
IN_SPACE = {
    "plate": {
        "slope_deg": 2.0,
        "noise_ratio": 0.1,
        "roughness_um": 1.0,
        "along_ratio": 0.1,
        "rocking_percent_per_mm": 0.01,
    },
    "arena": {"kind": "plane"},
}


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
@pytest.mark.parametrize(
    ("model", "effects"),
    [("space", IN_SPACE | HARMONIC | AIR), ("relaxed", HARMONIC | SLOPE), ("compliant", HARMONIC | SLOPE | AIR)],
)
def test_switching_effects_compiles_nothing(model, effects):
    kernels = set()
    for tables in ({}, effects):
        scene = Scene.model_validate({"legs": {"model": model}} | tables)
        plan = prepare(scene, DESIGN, solids.mass_of(DESIGN)).drawn(np.random.default_rng(0))
        state = plan.start(0.05, 0.0, 0.0)
        plan.advance(state, 1e-4, record.new(len(state)))
        kernels.add((plan.model.advance, len(plan.model.advance.outer.signatures)))
    assert len(kernels) == 1
