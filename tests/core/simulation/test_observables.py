"""Numbers printed with the speed: their errors from the runs and from the time step."""

import json
import math

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble, observables, record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import recorded_impacts
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import step_errors

FRICTION = f"{observables.POWERS}.friction"


def plan_of(tilt=10.0, kind="flexible", label=0.8, **run):
    design = Design().variant(tilt_deg=tilt, kind=kind)
    run = {"seconds": 1.0, "runs": 8, "discard_seconds": 0.2} | run
    tables = {"run": run, "contact": {"restitution": label}}
    return prepare(Scene.model_validate(tables), design, solids.mass_of(design))


def measure_numbers(plan):
    """Numbers of a plan with their errors and biases, by name."""
    results = batch.run_all(ensemble.runner(plan), plan.scene.run.runs)
    found = ensemble.summarise(results, plan.equivalent_drive.peak_speed, 0.0)
    return step_errors.add_step_bias(plan, found.numbers)


def test_error_of_a_quotient_is_the_scatter_of_its_replicates():
    rng = np.random.default_rng(3)
    below = rng.uniform(1.0, 2.0, (2000, 16))
    above = 3.0 * below + rng.normal(0.0, 0.5, below.shape)
    found = [observables.ratio_of_sums("x", a, b) for a, b in zip(above, below, strict=True)]
    scatter = np.std([one.value for one in found])
    stated = math.sqrt(np.mean([one.se**2 for one in found]))
    assert stated == pytest.approx(scatter, rel=0.05)  # 2000 replicates know it to 1.6 %
    assert np.mean([one.value for one in found]) == pytest.approx(3.0, abs=0.005)


def test_too_few_runs_have_a_value_but_no_error():
    few = np.array([1.0, 2.0, 3.0])
    assert observables.ratio_of_sums("x", few, few)[2:4] == (1.0, None)
    assert observables.ratio_of_sums("x", np.zeros(4), np.zeros(4))[2:4] == (0.0, 0.0)


def test_impulses_by_type_are_those_of_all_impacts_kept():
    plan = plan_of(seconds=0.2, runs=4)
    results = batch.run_all(ensemble.runner(plan, impacts=True), plan.scene.run.runs)
    found = ensemble.summarise(results, plan.equivalent_drive.peak_speed, 0.0)
    rows = np.concatenate([recorded_impacts(result) for result in results])
    rows = rows[rows[:, 1] < 4]  # without touches of the lane's walls
    for name, kind in record.KINDS.items():
        share = rows[rows[:, 6] == kind, 3].sum() / rows[:, 3].sum()
        assert found.facts["type_fractions_by_impulse"][name] == pytest.approx(share, abs=1e-12)
    assert sum(found.facts["type_fractions_by_impulse"].values()) == pytest.approx(1.0)
    assert set(found.numbers) == set(observables.OBSERVABLE_NAMES)
    assert set(found.facts["errors"]) == set(observables.OBSERVABLE_NAMES) - {observables.SPEED}


def test_errors_of_all_observables_cover_the_scatter_between_ensembles():
    """16 ensembles of 8 runs: the mean square of z over names and ensembles is about one."""
    all_of = [measure_numbers(plan_of(seconds=0.5, seed=seed)) for seed in range(16)]
    squares = []
    for name in (observables.IMPACTS, observables.CONTACT, FRICTION):
        values, errors = np.array([found[name].pair for found in all_of]).T
        squares.append(np.mean((values - values.mean()) ** 2 / errors**2))
    # 16 ensembles of 8 runs know each to 40 %, three together (not independent) to 30 %;
    # the mean of 1/chi^2 with 7 degrees of freedom is 7/5
    assert 0.5 < np.mean(squares) / (1.4 * 15 / 16) < 1.8


def close(coarse, fine, names):
    """Names of observables that are further off than 2 errors of the runs and the step's."""
    far = []
    for name in names:
        gap = coarse[name].minus(fine[name])
        # 3: about 20 names; none may miss by chance
        if abs(gap.number) > coarse[name].bias + 3.0 * gap.pair[1]:
            far.append(gap)
    return far


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tilt", "label", "kind"),
    [
        (10.0, 0.5, "flexible"),
        (20.0, 0.8, "flexible"),
        (12.0, 0.25, "flexible"),
        (10.0, 0.6, "braced"),
        pytest.param(10.0, 0.05, "flexible", marks=pytest.mark.nightly),
    ],
)
def test_a_step_five_times_finer_changes_nothing_by_more_than_its_error(tilt, label, kind):
    coarse = plan_of(tilt, kind, label, seconds=2.0)
    fine = coarse.world.options.step / 5.0
    told = plan_of(tilt, kind, label, seconds=1.0, step_us=1e6 * fine)
    assert close(measure_numbers(coarse), measure_numbers(told), observables.OBSERVABLE_NAMES) == []


def test_finer_steps_have_smaller_errors_and_coarser_none():
    own = plan_of().world.options.step
    whole = plan_of(step_us=1e6 * own, runs=4, seconds=0.1)
    results = batch.run_all(ensemble.runner(whole), whole.scene.run.runs)
    found = ensemble.summarise(results, whole.equivalent_drive.peak_speed, 0.0)
    errors = []
    for part in (1.0, 0.9, 0.5, 0.499, 0.1):
        judged = step_errors.add_step_bias(plan_of(step_us=1e6 * part * own), found.numbers)
        errors.append(judged[observables.IMPACTS].bias)
    assert errors == sorted(errors, reverse=True)
    assert errors[2] == pytest.approx(errors[3], rel=0.01)
    coarser = step_errors.add_step_bias(plan_of(step_us=1.2e6 * own), found.numbers)
    assert all(step_errors.step_bias(one) is None for one in coarser.values())


COMMAND = ("simulate",)
SHORT = ("--tilt", "10", "--seconds", "0.3", "--runs", "4")


def test_summary_marks_numbers_that_the_step_does_not_resolve(run):
    told = run(*SHORT, "--step", "30", "--all").stdout
    rows = {line[2:].partition("  ")[0]: line for line in told.splitlines()}
    assert "not resolved by this step: --step 2" in told
    for name in ("impacts", "in contact", "power friction"):
        assert any(f"({letter})" in rows[name] for letter in "abc"), name
    assert "not resolved by this step" in " ".join(run(*SHORT, "--step", "30").stdout.split())  # the speed's own
    # Shares by impulse come first: those by number are a property of the step.
    assert told.index("impulse of type") < told.index("impacts of type")


def test_bounds_of_the_speed_hold_runs_and_step(run):
    space = json.loads(run("--scene", "plane-90hz", "--seconds", "0.3", "--runs", "4", "--json").stdout)
    half = 0.5 * (space["speed_high_95_mm_s"] - space["speed_low_95_mm_s"])
    by_step = 0.03 * space["speed_mm_s"] + 0.01 * 31.215  # the limit at the own step
    by_runs = 3.182 * space["speed_se_mm_s"]  # Student's t of three freedoms
    assert half == pytest.approx(math.hypot(by_step, by_runs), rel=1e-3)
    plane = json.loads(run(*SHORT, "--json").stdout)
    half = 0.5 * (plane["speed_high_95_mm_s"] - plane["speed_low_95_mm_s"])
    assert half > 0.01 * plane["speed_mm_s"] + 0.015 * 31.2  # the limit alone; 31.2: peak speed
    unknown = json.loads(run(*SHORT, "--step", "60", "--json").stdout)
    assert unknown["speed_low_95_mm_s"] is None  # a step beyond the walker's own
