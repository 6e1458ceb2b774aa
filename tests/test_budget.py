"""The budget of a study: shared out, kept, and raised where it means nothing."""

import math

import numpy as np
import pytest

from walkergen.jobs.trust.accuracy import make, models, statistics
from walkergen.jobs.trust.accuracy.budget import KINDS, Budget, Runs, rounded_down, widened
from walkergen.jobs.trust.accuracy.setting import Measured
from walkergen.jobs.trust.accuracy.survey import Survey
from walkergen.numerics.quantity import Quantity
from walkergen.scene import Scene
from walkergen.simulation.observables import SPEED
from walkergen.simulation.run import RunResult
from walkergen.walker import solids
from walkergen.walker.design import Design


def silent(*told):
    """No progress."""


def survey_of(budget_s, **tables):
    return Survey(Scene.model_validate(tables), Design(), solids.mass_of(Design()), budget_s)


def measured(setting, value, se, runs, cost):
    """Made-up measurement of a mean speed."""
    speed = Quantity(SPEED, "", value, se)
    return Measured(setting, {SPEED: speed}, *runs, 1.0, cost, "ok")


def rated(survey, cpu_per_s=0.06):
    """Give every setting a made-up cost: 1/step."""
    for one in [*survey.steps, survey.own]:
        survey._rates[one] = cpu_per_s / one.step_us
    return survey


@pytest.mark.parametrize(("budget", "slowness"), [(15.0, 1.0), (60.0, 1.0), (40.0, 2.5), (120.0, 2.5)])
def test_a_study_spends_its_budget_on_an_idle_and_on_a_busy_machine(budget, slowness):
    """Made-up runs that take `slowness` times what their CPU time says; only the clock is false."""
    survey = rated(survey_of(budget))
    survey.budget.cores = 2
    survey.budget.pay_other(0.0, slowness * make.START_S)
    survey.budget.pay_turns(1.0, slowness)  # the pilots
    least = make._share_out(survey, ("models", "steps", "statistics", "shape"), silent)
    assert least is None
    others = survey.budget.kept_s
    for setting in survey.steps:
        kinds = KINDS
        rate = survey.rate(setting)
        runs = survey.budget.affords(survey.granted(setting), rate, 1.0, kinds)
        idle = math.ceil(runs.number / 2) * rate * (runs.seconds + 1.0)
        survey.budget.pay_runs(runs, rate, 1.0, slowness * idle)
        cost = runs.number * rate * (runs.seconds + 1.0)
        survey.measured[setting] = measured(setting, 1.0, 0.1, runs, cost)
    survey.budget.pay(survey.take("steps-short"))
    for name, kinds in (("frames", KINDS), ("statistics", statistics.KINDS)):
        rate = survey.rate(survey.own)
        parts = len(models.FRAMES) if name == "frames" else 1
        runs = survey.budget.affords(survey.take(name) / parts, rate, 1.0, kinds)
        idle = math.ceil(runs.number / 2) * rate * (runs.seconds + 1.0)
        survey.budget.pay_runs(runs, rate, 1.0, parts * slowness * idle)
    assert not survey.due
    assert not survey.others
    survey.budget.pay_other(others, slowness * others)
    assert survey.budget.kept_s == 0.0
    assert survey.budget.spent_s == pytest.approx(budget, rel=0.3)


def test_what_one_leaves_over_the_others_get():
    budget = Budget(10.0, 2)
    due = {"a": 1.0, "b": 3.0, "c": 1.0}
    assert budget.grant("a", due) == pytest.approx(2.0)
    budget.pay(1.0)
    assert budget.grant("b", {"b": 3.0, "c": 1.0}) == pytest.approx(9.0 * 0.75)
    budget.pay(20.0)
    assert budget.grant("c", {"c": 1.0}) == 0.0


def test_simulations_share_out_what_solids_and_pictures_leave():
    budget = Budget(10.0, 2)
    budget.keep(4.0)
    assert budget.grant("a", {"a": 1.0, "b": 1.0}) == pytest.approx(3.0)
    budget.pay_other(1.0, 3.0)  # a slow picture: simulations have the less
    assert budget.grant("a", {"a": 1.0}) == pytest.approx(4.0)
    budget.pay_turns(1.0, 1.3)  # everything is 1.3 times as slow, what is still to be drawn as well
    assert budget.grant("a", {"a": 1.0}) == pytest.approx(10.0 - 3.0 - 1.3 - 1.3 * 3.0)
    assert (budget.simulated_s, budget.others_s) == (1.3, 4.0)


def test_the_picture_and_the_shape_have_their_time_in_the_least_budget():
    one, all_of_them = rated(survey_of(0.1)), rated(survey_of(0.1))
    least = make._share_out(one, ("models",), silent)
    assert one.budget.kept_s == make.PICTURE_S < least
    more = make._share_out(all_of_them, ("models", "steps", "statistics", "shape"), silent)
    assert more > least + make.SHAPE_S


def test_a_budget_learns_how_much_slower_a_busy_machine_is():
    budget = Budget(10.0, 2)
    budget.pay_runs(Runs(4, 1.0), 0.1, 1.0, wall_s=1.2)
    assert budget.spent_s == pytest.approx(1.2)
    assert budget.slowness == pytest.approx(3.0)


def test_runs_are_fewer_before_they_are_too_short():
    budget = Budget(10.0, 1)
    afforded = [budget.affords(wall, 0.1, 1.0, KINDS) for wall in (100.0, 3.3, 2.0, 1.0, 0.0)]
    # 16 runs of 61.5 s; 16 of 1.06; 8 of 1.5; 4 of 1.5; and the least
    assert afforded == [Runs(16, 60.0), Runs(16, 1.0), Runs(8, 1.5), Runs(4, 1.5), Runs(4, 0.5)]
    crowd = Budget(10.0, 64)  # no run is split: 16 runs keep 16 of 64 cores busy
    assert crowd.affords(1.0, 0.1, 1.0, KINDS) == Runs(16, 8.0)
    assert crowd.cost(Runs(16, 8.0), 0.1, 1.0) == pytest.approx(0.9)


def test_lengths_are_round_and_lose_little():
    rng = np.random.default_rng(3)
    for value in 10.0 ** rng.uniform(-2.0, 3.0, 200):
        found = rounded_down(value)
        assert 0.74 * value <= found <= value * (1 + 1e-9)
    assert rounded_down(0.0) == rounded_down(-1.0) == 0.0
    assert rounded_down(0.5) == 0.5


def test_few_runs_have_bars_as_sure_as_many():
    """Twice the widened error holds the true mean as often for 4 runs as twice that of 16."""
    rng = np.random.default_rng(7)
    inside = {}
    for runs in (4, 8, 16):
        values = rng.normal(size=(40_000, runs))
        se = values.std(axis=1, ddof=1) / math.sqrt(runs) * widened(runs)
        inside[runs] = float(np.mean(np.abs(values.mean(axis=1)) < 2.131 * se))
    assert inside == pytest.approx(dict.fromkeys(inside, 0.95), abs=0.005)
    assert widened(16) == widened(32) == 1.0


def test_the_least_budget_is_named_and_taken():
    survey = rated(survey_of(1.0), cpu_per_s=1.0)
    least = make._share_out(survey, ("models", "steps", "statistics"), silent)
    assert least is not None
    assert survey.budget.budget_s == least
    alone = rated(survey_of(1.0), cpu_per_s=1.0)
    fewer = make._share_out(alone, ("statistics",), silent)
    assert fewer is not None
    assert fewer < 0.7 * least
    assert survey.least(survey.own) == pytest.approx(math.ceil(4 / survey.cores) * 1.5 * survey.rate(survey.own))
    assert make._share_out(rated(survey_of(3.0), 1.0), ("shape",), silent) is None


def test_one_ladder_alone_has_the_whole_budget():
    alone, all_of_them = rated(survey_of(60.0)), rated(survey_of(60.0))
    make._share_out(alone, ("steps",), silent)
    make._share_out(all_of_them, ("models", "steps", "statistics"), silent)
    own = alone.steps[0]
    assert alone.granted(own) > 1.2 * all_of_them.granted(own)
    assert all(one in alone.steps for one in alone.due)


def test_parts_of_eight_runs_still_give_a_rung(monkeypatch):
    survey = rated(survey_of(1.0))
    reference = survey.steps[0]
    for one in {reference, survey.own}:
        survey.measured[one] = measured(one, 10.0, 0.5, (4, 0.5), 1.0)
    survey.others["statistics"] = statistics.WEIGHT
    survey.budget.budget_s = 1e-6

    def made(setting, runs, progress):
        assert runs == Runs(8, 1.0)
        blocks = np.random.default_rng(1).normal(10.0, 2.0, (8, 20))
        return [RunResult(k, None, 1.0, b.mean(), 0.05, b, None, 0.0, None, 0.0) for k, b in enumerate(blocks)], 0.1

    monkeypatch.setattr(survey, "ensemble", made)
    (rung,) = statistics.ladder(survey, silent).rungs
    assert rung.details["parts"] == 4
    assert rung.error > 0
