"""The accuracy study: ladders against closed forms, honest error bars, the choice of a setting."""

import math
from pathlib import Path

import numpy as np
import pytest

from walkergen.errors import InputError
from walkergen.jobs.trust.accuracy import choose, models, report, shape, short_scenes, statistics
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung, order
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.survey import Survey
from walkergen.numerics.quantity import Quantity
from walkergen.points import tolerance
from walkergen.points.tolerance import Tolerance
from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.observables import SPEED
from walkergen.simulation.run import Outcome, RunResult
from walkergen.walker import solids
from walkergen.walker.design import Design


def silent(*told):
    """No progress."""


def survey_of(kind="flexible", **tables):
    """Survey of one second."""
    design = Design().variant(kind=kind)
    mass = solids.mass_of(design)
    return Survey(Scene.model_validate(tables), design, mass, budget_s=1.0)


def known(survey, speeds, se=0.1, cpu_per_s=None):
    """Fill a survey with made-up measurements: speed by setting."""
    cpu_per_s = cpu_per_s or {}
    for setting, speed in speeds.items():
        cost = cpu_per_s.get(setting, 0.01) * 16 * 11.0
        survey.measured[setting] = Measured(
            setting, {SPEED: Quantity(SPEED, "", speed, se)}, 16, 10.0, 1.0, cost, "16 ok"
        )
    return survey


def test_order_of_an_exact_power_is_its_exponent():
    values = np.array([1.0, 2.0, 5.0, 10.0])
    slope, se = order(values, 3.0 * values**2)
    assert slope == pytest.approx(2.0, abs=1e-12)  # rounding of logarithms
    assert se < 1e-12


@pytest.mark.slow
def test_shape_ladder_agrees_with_the_closed_form_of_a_half_disc():
    """The round foot taken for exact, against the closed-form mass of quad and half disc."""
    design = Design.model_validate({"legs": {"foot": "round"}})
    mass = solids.weigh(design, solids.build(design, shape.EXACT_SEGMENTS))
    limb = design.limbs[0]
    half = 0.5 * limb.thickness
    # The leg's centre line ends half a thickness early; its slanted top adds as much as it cuts.
    area = 2.0 * half * (limb.length - half) + 0.5 * math.pi * half**2
    exact = 1e-3 * design.material.density_g_cm3 * limb.width * area
    ladder = shape.ladder(survey_of(), silent)
    finest = next(rung for rung in ladder.rungs if rung.setting == "512 edges")
    assert mass.legs[0].m == pytest.approx(exact, rel=0.05 * finest.details["m"])
    far = {rung.setting: rung for rung in ladder.rungs if rung.series == "double precision"}
    # 1e6 mm away a coordinate has lost 1e6/0.4 of its 16 digits
    assert far["1e+06 mm away"].error < 1e-9
    files = {rung.setting: rung for rung in ladder.rungs if rung.series.startswith("through")}
    assert 1e-9 < files["0 mm away"].error < 1e-6  # float32: 6e-8 of a coordinate
    assert files["1e+06 mm away"].error > 1e-3


@pytest.mark.slow
def test_braced_shape_has_no_error_at_the_origin():
    ladder = shape.ladder(survey_of("braced"), silent)
    far = [rung for rung in ladder.rungs if rung.series == "double precision"]
    assert max(rung.error for rung in far) < 1e-9  # as above
    assert far[0].details["m"] is None


def made_runs(runs, blocks, rng):
    """Runs of independent block speeds with mean 10 and standard deviation 2."""
    speeds = rng.normal(10.0, 2.0, (runs, blocks))
    return [
        RunResult(k, Outcome.OK, 0.1 * blocks, row.mean(), 0.1, row, np.zeros((0, 3)), 0.0, record.new(3), 0.0)
        for k, row in enumerate(speeds)
    ]


def test_parts_of_an_ensemble_use_no_block_twice_and_err_as_theory_says():
    results = made_runs(32, 500, np.random.default_rng(5))
    for runs, length in ((4, 5.0), (8, 10.0), (16, 10.0)):
        parts = statistics._parts(results, runs, length)
        used = sum(len(result.block_speeds) for part in parts for result in part)
        assert used == 32 * 500
        rung = statistics._rung(parts, results, 1.0, 0.01, 1.0)
        expected = 2.0 / math.sqrt(runs * length / 0.1)
        # four standard errors of a standard deviation from that many parts
        assert rung.error == pytest.approx(expected, abs=4.0 * rung.error_sd)
        assert rung.details["stated_se_mm_s"] == pytest.approx(expected, rel=0.2)
        assert 0.8 < rung.details["inside_95"] <= 1.0  # of 80, 20 and 10 parts
        assert rung.cpu_s == pytest.approx(0.01 * runs * (length + 1.0))


@pytest.mark.parametrize(("text", "expected"), [("5%", Tolerance(0.05, True)), (" 0.5 mm/s", Tolerance(0.5, False))])
def test_errors_are_read(text, expected):
    assert tolerance.parse(text) == expected


def speeds_of(survey, steps):
    return dict(zip(survey.steps, steps, strict=True))


def test_the_cheapest_setting_within_the_error_is_chosen():
    survey = survey_of()
    assert len(survey.steps) == 5
    assert survey.own in survey.steps
    speeds = speeds_of(survey, (100.0, 99.0, 99.0, 97.0, 92.0))
    costs = {setting: 0.2 / place for place, setting in enumerate(survey.steps, start=1)}
    known(survey, speeds, cpu_per_s=costs)
    # The longest step has no margin; the third has that of the longest, which is 8 % off.
    assert choose.choose(survey, Tolerance(0.2, True), silent).setting == survey.steps[3]
    fine = choose.choose(survey, Tolerance(0.05, True), silent)
    assert fine.setting == survey.steps[1]
    assert fine.bias_bound + 2.0 * fine.se == pytest.approx(5.0)
    # 99 mm/s: 1 off, and twice the errors of both
    assert fine.bias_bound == pytest.approx(1.0 + 2.0 * math.hypot(0.1, 0.1))


def test_the_last_step_before_a_cliff_is_never_chosen():
    """The longest step that is not refused is the margin of those beside it."""
    survey = survey_of()
    known(survey, speeds_of(survey, (100.0, 100.0, 100.0, 100.0, 60.0)))
    offered = choose.choose(survey, Tolerance(0.2, True), silent).setting
    assert offered in survey.steps[:2]


def test_a_coarse_step_that_is_right_by_luck_is_not_chosen():
    survey = survey_of()
    speeds = speeds_of(survey, (100.0, 100.0, 90.0, 100.0, 100.0))
    costs = {setting: 0.02 / place for place, setting in enumerate(survey.steps, start=1)}
    known(survey, speeds, cpu_per_s=costs)
    # The longer ones are right, but a finer one is 10 % off; the second's margin is that one
    assert choose.choose(survey, Tolerance(0.05, True), silent).setting == survey.steps[0]


def test_what_cannot_be_promised_is_refused():
    survey = known(survey_of(), speeds_of(survey_of(), (100.0,) * 5))
    assert "known to 0.2 mm/s only; measure longer" in choose.choose(survey, Tolerance(1e-4, True), silent)
    dead = survey_of()
    finest = dead.steps[0]
    dead.measured[finest] = Measured(finest, {}, 16, 1.0, 1.0, 1.0, "16 toppled")
    with pytest.raises(InputError, match="16 toppled"):
        dead.reference(silent)


@pytest.mark.slow
@pytest.mark.nightly
def test_orders_in_space_are_those_claimed():
    """Smooth sliding errs by second order; landings by first, in the mean over drops."""
    survey = survey_of()
    survey.budget.budget_s = 60.0
    survey.others = {"steps-short": short_scenes.WEIGHT, "frames": models.FRAMES_WEIGHT}
    ladder = short_scenes.ladder(survey, silent)
    for series, claimed, allowance in (("sliding", 2.0, 0.6), ("landings", 1.0, 0.4)):
        # Tolerances: frames end at other instants for other steps; 32 drops leave 20 % of an error
        rungs = [rung for rung in ladder.rungs if rung.series == series]
        slope, _ = order([r.details["step_us"] for r in rungs], [r.error for r in rungs])
        assert slope == pytest.approx(claimed, abs=allowance), series


@pytest.mark.parametrize(("rungs", "shown"), [(2, True), (61, False)])
def test_people_read_no_rows_of_a_long_ladder_and_the_table_has_all(rungs, shown):
    settings = [Rung("a", f"{n} us", 0.5, None, 2e-3, {"ended": "ok", "n": n}) for n in range(rungs)]
    ladder = Ladder("steps", "Bias", "bias", "CPU time, s", "the finest", settings, ("Chaos.",))
    other = ladder._replace(name="shape", rungs=[Rung("b", "1 mm", 0.1, 0.2, 1e-3, {"M": 0.1})])
    made = report.of([ladder, other], None, 1.0, None, "walker", Path("here"))
    assert [len(table.columns) for table in made.shown()] == [5] * (1 + shown)
    assert (f"Bias: {rungs} rows in accuracy.csv" in made.lines) != shown
    assert "reference: the finest" in (made.table.notes if shown else made.lines)
    assert len(made.facts["ladders"]["steps"]) == rungs
    rows = list(made["accuracy"])
    assert len(rows) == rungs + 1
    assert (rows[0]["ladder"], rows[0]["n"], rows[0]["M"], rows[-1]["M"]) == ("steps", 0, None, 0.1)
