"""Laws of any plan that a scene makes, and the effects that it calls for."""

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble, record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import Outcome, simulate
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design


def plan_of(*, design=None, **tables):
    design = design or Design()
    return prepare(Scene.model_validate(tables), design, solids.mass_of(design))


def test_energy_balances_and_the_outcome_is_ok():
    plan = plan_of(run={"seconds": 1.0, "discard_seconds": 0.1})
    result = simulate(plan, 0)
    assert result.outcome is Outcome.OK
    assert result.energy_error < 0.02
    assert result.tally.sums[record.ELAPSED] == pytest.approx(1.0, rel=1e-9)
    assert result.tally.counts[0] > 50


def test_threads_change_no_bit_and_few_runs_are_the_first_of_many():
    few = plan_of(run={"seconds": 0.2, "discard_seconds": 0.0, "runs": 2})
    many = plan_of(run={"seconds": 0.2, "discard_seconds": 0.0, "runs": 5})
    one = batch.run_all(ensemble.runner(few), few.scene.run.runs, threads=1)
    four = batch.run_all(ensemble.runner(many), many.scene.run.runs, threads=4)
    for a, b in zip(one, four, strict=False):
        np.testing.assert_array_equal(a.block_speeds, b.block_speeds)
        np.testing.assert_array_equal(a.tally.counts, b.tally.counts)


def test_a_second_harmonic_is_driven_and_paid_for():
    drive = {"frequency_hz": 90.0, "gamma": 1.8, "second_harmonic_ratio": 0.3}
    run = {"seconds": 0.3, "discard_seconds": 0.05}
    plan = plan_of(drive=drive, run=run)
    result = simulate(plan, 0)
    assert plan.world.drive.harmonic.ratio == 0.3
    assert result.outcome is Outcome.OK
    assert result.energy_error < 0.02


def test_descent_helps_and_ascent_hinders():
    speeds = {}
    for slope in (-20.0, 0.0, 20.0):
        plan = plan_of(
            design=Design().variant(kind="braced"),
            plate={"slope_deg": slope},
            run={"seconds": 2.0, "discard_seconds": 0.2},
        )
        speeds[slope] = simulate(plan, 0).speed
    assert speeds[-20.0] < speeds[0.0] < speeds[20.0]


def verdicts(plan):
    return {effect.name: effect.on for effect in plan.resolved.effects}


def test_the_scene_decides_which_effects_are_simulated():
    plan = plan_of()
    assert verdicts(plan)["leg compliance"]
    assert verdicts(plan)["yaw and roll"]
    assert verdicts(plan)["sticking in impacts"]
    assert not verdicts(plan)["plate slope"]
    assert not verdicts(plan)["air drag"]
    steep = plan_of(plate={"slope_deg": 3.0}, design=Design().variant(tilt_deg=30.0))
    assert verdicts(steep)["plate slope"]
    assert not verdicts(steep)["sticking in impacts"]


def test_effects_can_be_forced_on_and_off():
    level = plan_of(plate={"slope_deg": 3.0}, effects={"off": ["plate_slope"]})
    assert not verdicts(level)["plate slope"]
    assert level.world.acting.gravity.along == 0.0
    assert any("forced off" in effect.reason for effect in level.resolved.effects)
    drag = plan_of(effects={"on": ["air_drag"]})
    assert verdicts(drag)["air drag"]


def test_an_effect_that_does_not_exist_is_no_verdict():
    with pytest.raises(KeyError, match="plate_slope"):
        plan_of().resolved.is_on("plate_slope")


def test_the_frequency_of_a_leg_is_that_of_the_spring_simulated():
    plan = plan_of()
    (compliance,) = [e for e in plan.resolved.effects if e.name == "leg compliance"]
    stiffness, leg = plan.world.walker.stiffness[0], plan.case.mass.legs[0]
    frequency = np.sqrt(stiffness / leg.inertia) / (2.0 * np.pi)
    assert compliance.number == pytest.approx(frequency / 90.0, rel=1e-12)
