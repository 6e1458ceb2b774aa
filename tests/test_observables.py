"""What is printed beside the speed: its errors by the runs, and what the step leaves of it."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.errors import InputError
from walkergen.scene import Scene
from walkergen.simulation import ensemble, observables, record, resolution
from walkergen.simulation.compliant.lengths import swings_back
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import impacts_of
from walkergen.walker import solids
from walkergen.walker.design import Design

FRICTION = f"{observables.POWERS}.friction"


def silent(*told):
    """No progress."""


def plan_of(model="compliant", tilt=10.0, kind="flexible", label=0.8, design=None, **run):
    design = (design or Design()).variant(tilt_deg=tilt, kind=kind)
    run = {"seconds": 1.0, "runs": 8, "discard_seconds": 0.2} | run
    tables = {"run": run, "legs": {"model": model}, "contact": {"restitution": label}}
    return prepare(Scene.model_validate(tables), design, solids.mass_of(design))


def of_legs(thickness):
    return Design.model_validate({"legs": {"flexible_thickness_mm": thickness}})


def measured(plan):
    """Values, standard errors and verdicts of a plan, each by name."""
    found, _ = ensemble.measure(plan, silent)
    errors = {**found.errors, observables.SPEED: found.speed_se_mm_s}
    return resolution.values(found), errors, resolution.judge(plan, found)


def test_error_of_a_quotient_is_the_scatter_of_its_replicates():
    rng = np.random.default_rng(3)
    below = rng.uniform(1.0, 2.0, (2000, 16))
    above = 3.0 * below + rng.normal(0.0, 0.5, below.shape)
    found = [observables.quotient("x", a, b) for a, b in zip(above, below, strict=True)]
    scatter = np.std([one.value for one in found])
    stated = math.sqrt(np.mean([one.se**2 for one in found]))
    assert stated == pytest.approx(scatter, rel=0.05)  # 2000 replicates know it to 1.6 %
    assert np.mean([one.value for one in found]) == pytest.approx(3.0, abs=0.005)


def test_too_few_runs_have_a_value_but_no_error():
    few = np.array([1.0, 2.0, 3.0])
    assert observables.quotient("x", few, few)[2:4] == (1.0, None)
    assert observables.quotient("x", np.zeros(4), np.zeros(4))[2:4] == (0.0, 0.0)


@pytest.mark.parametrize("model", ["relaxed", "compliant", pytest.param("space", marks=pytest.mark.slow)])
def test_impulses_by_type_are_those_of_all_impacts_kept(model):
    plan = plan_of(model, seconds=0.2, runs=4)
    found, results = ensemble.measure(plan, silent, impacts=True)
    rows = np.concatenate([impacts_of(result) for result in results])
    rows = rows[rows[:, 1] < 4]  # without touches of the lane's walls
    for name, kind in record.KINDS.items():
        share = rows[rows[:, 6] == kind, 3].sum() / rows[:, 3].sum()
        assert found.type_fractions_by_impulse[name] == pytest.approx(share, abs=1e-12)
    assert sum(found.type_fractions_by_impulse.values()) == pytest.approx(1.0)
    assert set(resolution.values(found)) == set(observables.NAMES)
    assert set(found.errors) == set(observables.NAMES) - {observables.SPEED}


def test_errors_of_all_observables_cover_the_scatter_between_ensembles():
    """16 ensembles of 8 runs: the mean square of z over names and ensembles is about one."""
    all_of = [measured(plan_of(seconds=0.5, seed=seed, step_us=100.0))[:2] for seed in range(16)]
    squares = []
    for name in (observables.IMPACTS, observables.CONTACT, FRICTION):
        values = np.array([found[name] for found, _ in all_of])
        squares.append(np.mean([(values - values.mean()) ** 2 / [e[name] ** 2 for _, e in all_of]]))
    # 16 ensembles of 8 runs know each to 40 %, three together (not independent) to 30 %;
    # the mean of 1/chi^2 with 7 degrees of freedom is 7/5
    assert 0.5 < np.mean(squares) / (1.4 * 15 / 16) < 1.8


def test_steps_in_a_plane_agree_with_a_fifth_of_them_and_counts_have_no_limit():
    """All but counts of the own step, within its error; with absorbed rebounds of up to two steps
    friction and contact were twice as large (10 deg, e = 0.8).
    """
    own, finer = measured(plan_of(runs=8)), measured(plan_of(step_us=6.0))
    for _, _, verdicts in (own, finer):
        for name in observables.NAMES:
            counted = name == observables.IMPACTS or name.startswith(f"{observables.BY_NUMBER}.")
            assert (verdicts[name].error is None) == counted
            assert bool(verdicts[name].reason) == counted
    known = [name for name in observables.NAMES if own[2][name].error is not None]
    assert close(own, finer, known) == []
    coarse = measured(plan_of(step_us=60.0, seconds=0.1))[2]
    assert all(one.error is None for one in coarse.values())
    assert "--step 30 " in coarse[observables.SPEED].reason


def test_own_step_follows_the_legs():
    """Ten steps in a period of the legs' slower mode, at most 30 us where the plate's period is 1/90 s."""
    own = [1e6 * plan_of(design=of_legs(mm)).world.options.step for mm in (0.4, 1.0, 2.0)]
    assert own[0] == pytest.approx(30.0)
    assert own[1] == pytest.approx(26.2, rel=0.01)
    assert own[2] < 0.75 * own[1]
    assert plan_of(step_us=12.0).world.options.step == pytest.approx(12e-6)


def test_impacts_in_a_plane_grow_with_every_decade_of_their_cut_off():
    """No step resolves their number: it has no limit, while shares by impulse keep theirs."""
    rates, shares = [], []
    for step_us in (20.0, 2.0):
        found, _, _ = measured(plan_of(seconds=0.3, step_us=step_us))
        rates.append(found[observables.IMPACTS])
        shares.append(found[f"{observables.BY_IMPULSE}.III"])
    assert rates[1] - rates[0] > 300.0  # measured 500 to 900 a decade, each known to 60
    assert max(shares) - min(shares) < 0.02  # known to 0.004 each


def close(coarse, fine, names):
    """Names of observables that are further off than 2 errors of the runs and the step's."""
    far = []
    for name in names:
        error = coarse[2][name].error
        noise = math.hypot(coarse[1][name], fine[1][name])
        # 3: about 20 names, of which none shall miss by chance
        if abs(coarse[0][name] - fine[0][name]) > error + 3.0 * noise:
            far.append((name, coarse[0][name], fine[0][name], error, noise))
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
def test_in_space_a_step_five_times_finer_changes_nothing_by_more_than_its_error(tilt, label, kind):
    coarse = plan_of("space", tilt, kind, label, seconds=2.0)
    fine = coarse.world.options.step / 5.0
    told = plan_of("space", tilt, kind, label, seconds=1.0, step_us=1e6 * fine)
    assert close(measured(coarse), measured(told), observables.NAMES) == []


def test_finer_steps_have_smaller_errors_and_coarser_none():
    own = plan_of("space").world.options.step
    whole = plan_of("space", step_us=1e6 * own, runs=4, seconds=0.1)
    found, _ = ensemble.measure(whole, silent)
    errors = []
    for part in (1.0, 0.9, 0.5, 0.499, 0.1):
        judged = resolution.judge(plan_of("space", step_us=1e6 * part * own), found)
        errors.append(judged[observables.IMPACTS].error)
    assert errors == sorted(errors, reverse=True)
    assert errors[2] == pytest.approx(errors[3], rel=0.01)
    coarser = resolution.judge(plan_of("space", step_us=1.2e6 * own), found)
    assert all(one.error is None for one in coarser.values())


def test_longest_step_of_legs_is_where_they_swing_back():
    plan = plan_of()
    longest = resolution.longest_step(plan)
    assert longest == pytest.approx(164e-6, rel=0.01)  # a quarter of the slower mode's 656 us
    assert swings_back(plan.world.walker, 2.0 * 1.001 * longest)
    assert not swings_back(plan.world.walker, 2.0 * 0.999 * longest)
    stiff = Design.model_validate({"material": {"youngs_modulus_gpa": 12.0}})
    soft = Design.model_validate({"material": {"youngs_modulus_gpa": 3.0}})
    ratio = resolution.longest_step(plan_of(design=soft)) / resolution.longest_step(plan_of(design=stiff))
    assert ratio == pytest.approx(2.0)
    assert resolution.longest_step(plan_of("relaxed")) == math.inf
    assert resolution.longest_step(plan_of("space")) == math.inf


def test_a_step_beyond_the_swing_loses_the_speed_and_warns():
    right = measured(plan_of())[0]
    for step, warned in ((160.0, False), (170.0, True), (200.0, True)):
        plan = plan_of(step_us=step)
        found = measured(plan)[0]
        assert bool(resolution.warnings(plan)) == warned
        # 17.8 in place of 130 mm/s beyond; inside within 5 %
        lost = found[observables.SPEED] < 0.3 * right[observables.SPEED]
        assert lost == warned, step
    with pytest.raises(InputError, match="steps over the contacts"):
        plan_of("space", step_us=100.0)


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(command_line, ["simulate", *words], catch_exceptions=False)


SHORT = ("--model", "compliant", "--tilt", "10", "--seconds", "0.3", "--runs", "4")


def test_summary_marks_what_the_step_does_not_resolve(run):
    told = run(*SHORT, "--step", "60", "--all").stdout
    rows = {line[2:].partition("  ")[0]: line for line in told.splitlines()}
    assert "not resolved by this step: --step 30 or less is" in told
    for name in ("impacts", "in contact", "power friction"):
        assert any(f"({letter})" in rows[name] for letter in "abc"), name
    assert "not resolved by this step" in run(*SHORT, "--step", "60").stdout  # the speed's own
    # Shares by impulse come first: those by number are a property of the step.
    assert told.index("by impulse") < told.index("by number")


def test_json_has_errors_reasons_and_warnings(run):
    result = run(*SHORT, "--step", "200", "--json")
    found = json.loads(result.stdout)
    assert "legs swing back" in result.stderr
    assert found["step"]["warnings"] == [result.stderr.removeprefix("warning: ").strip()]
    named = {name for row in found["step"]["not_resolved"] for name in row["names"]}
    assert named == set(observables.NAMES)
    assert found["errors"]["contact_fraction"] > 0.0


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
