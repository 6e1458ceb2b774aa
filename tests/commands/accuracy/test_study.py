"""The accuracy study: bounds of biases, the choice of a step, the budget."""

import math
from pathlib import Path

import numpy as np
import pytest

from walkergen.commands.accuracy import answers, report
from walkergen.commands.accuracy.report import Answer, Ladder, Rung, convergence_order
from walkergen.commands.accuracy.survey import StepMeasurement, Survey
from walkergen.core import measure, tolerance
from walkergen.core.errors import InputError
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.simulation.observables import SPEED
from walkergen.core.tolerance import Tolerance
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design


def silent(*told):
    """No progress."""


def survey_of(budget_s=1.0):
    return Survey(Scene(), Design(), solids.mass_of(Design()), budget_s)


def known(survey, speeds, se=0.1, costs=(0.01,) * 5):
    """Fill a survey with made-up measurements: speeds of all steps, the finest first."""
    for step_us, speed, cost in zip(survey.steps, speeds, costs, strict=True):
        quantities = {SPEED: Quantity(SPEED, "", speed, se)}
        survey.measured[step_us] = StepMeasurement(step_us, quantities, 16, 10.0, 1.0, cost * 16 * 11.0, 1.0, "16 ok")
    return survey


def chosen(survey, share):
    candidates = [survey.to_candidate(one) for one in survey.measured.values()]
    return answers.choose_measured(candidates, share)


def test_order_of_an_exact_power_is_its_exponent():
    values = np.array([1.0, 2.0, 5.0, 10.0])
    slope, se = convergence_order(values, 3.0 * values**2)
    assert slope == pytest.approx(2.0, abs=1e-12)  # rounding of logarithms
    assert se < 1e-12


@pytest.mark.parametrize(("text", "expected"), [("5%", Tolerance(0.05, True)), (" 0.5 mm/s", Tolerance(0.5, False))])
def test_errors_are_read(text, expected):
    assert tolerance.parse_tolerance(text) == expected


def test_the_cheapest_step_within_the_error_is_chosen():
    survey = known(survey_of(), (100.0, 99.0, 99.0, 97.0, 92.0), costs=(0.2, 0.1, 0.07, 0.05, 0.04))
    assert len(survey.steps) == 5
    assert float(f"{1e6 * survey.plan.world.options.step:.2g}") in survey.steps  # the scene's own
    # The longest step has no margin; the third has that of the longest, which is 8 % off.
    assert chosen(survey, 0.2).candidate.step_us == survey.steps[3]
    fine = chosen(survey, 0.05)
    assert fine.candidate.step_us == survey.steps[1]
    # 99 mm/s: 1 off, and 1.96 times the errors of both
    assert fine.candidate.bias == pytest.approx(0.01 + 0.0196 * math.hypot(0.1, 0.1), rel=1e-3)
    assert math.hypot(fine.candidate.bias, 2.0 * fine.se) <= fine.error <= 0.05


def test_the_last_step_before_a_cliff_is_never_chosen():
    """The longest step that is not refused is the margin of those next to it."""
    survey = known(survey_of(), (100.0, 100.0, 100.0, 100.0, 60.0))
    assert chosen(survey, 0.2).candidate.step_us in survey.steps[:2]


def test_a_coarse_step_that_is_right_by_luck_is_not_chosen():
    survey = known(survey_of(), (100.0, 100.0, 90.0, 100.0, 100.0), costs=(0.02, 0.01, 0.007, 0.005, 0.004))
    # The longer ones are right, but a finer one is 10 % off; the second's margin is that one
    assert chosen(survey, 0.05).candidate.step_us == survey.steps[0]


def test_no_step_is_chosen_beyond_one_that_fails():
    survey = known(survey_of(), (100.0,) * 5)
    failed = survey.steps[2]
    survey.measured[failed] = survey.measured[failed]._replace(quantities={}, outcomes="16 toppled")
    bounds = [survey.bias_bound(one) for one in survey.measured.values()]
    assert [math.isinf(bound) for bound in bounds] == [False, False, True, True, True]
    assert chosen(survey, 0.2).candidate.step_us == survey.steps[0]
    survey = known(survey_of(), (100.0,) * 5, costs=(0.2, 0.1, 0.07, 0.05, 0.04))
    longest = survey.steps[-1]
    survey.measured[longest] = survey.measured[longest]._replace(quantities={}, outcomes="16 toppled")
    assert chosen(survey, 0.2).candidate.step_us == survey.steps[1]  # the margin of the others is the one that fails


def test_what_cannot_be_promised_says_what_would_help():
    survey = known(survey_of(60.0), (100.0,) * 5)
    candidates = [survey.to_candidate(one) for one in survey.measured.values()]
    assert chosen(survey, 1e-3) is None
    told = answers.advise_budget(candidates, Tolerance(1e-3, True), survey)
    assert "has an error of 0.2 mm/s. Measure longer: ‹budget=›" in told
    assert "A day of simulations would not be enough" in answers.advise_budget(
        candidates, Tolerance(1e-5, True), survey
    )
    dead = survey_of()
    dead.measured[dead.steps[0]] = StepMeasurement(dead.steps[0], {}, 16, 1.0, 1.0, 1.0, 1.0, "16 toppled")
    with pytest.raises(InputError, match="16 toppled"):
        dead.measure_reference(silent)


def test_few_runs_have_wider_bounds_of_a_bias():
    survey = known(survey_of(), (100.0, 99.0, 99.0, 97.0, 92.0))
    many = survey.bias_bound(survey.measured[survey.steps[1]])
    for step_us, one in survey.measured.items():
        survey.measured[step_us] = one._replace(quantities={SPEED: one.speed._replace(freedom=3.0)})
    # Student's t of 6 degrees of freedom for the normal's
    few = survey.bias_bound(survey.measured[survey.steps[1]])
    assert (few - 1.0) / (many - 1.0) == pytest.approx(2.447 / 1.960, rel=1e-3)


@pytest.mark.parametrize(("budget_s", "run_s"), [(15.0, 0.05), (60.0, 0.05), (60.0, 0.4)])
def test_a_study_spends_its_budget(budget_s, run_s, monkeypatch):
    """Made-up runs that take `run_s` by the clock each; what one leaves over the others get."""
    survey = survey_of(budget_s)
    survey.allot_budget()
    for step in survey.steps:
        granted_s, runs = survey.claim_budget(step), 4
        made = measure.Measured(None, [], runs, runs * run_s)
        while (more := measure.Budget(granted_s, 4).request_more(made)) is not None:
            made = more._replace(wall_s=more.runs * run_s)
        survey.simulated_s += made.wall_s
    assert not survey.due
    assert survey.simulated_s == pytest.approx(budget_s, rel=0.15)


def test_the_finest_step_has_three_tenths_of_the_budget():
    survey = survey_of(60.0)
    survey.allot_budget()
    assert survey.claim_budget(survey.steps[0]) == pytest.approx(60.0 * 0.3)


@pytest.mark.parametrize(("rungs", "shown"), [(2, True), (61, False)])
def test_people_read_no_rows_of_a_long_ladder_and_the_table_has_all(rungs, shown):
    settings = [Rung("a", f"{n} us", 0.5, None, 2e-3, {"ended": "ok", "n": n}) for n in range(rungs)]
    ladder = Ladder("steps", "Bias", "bias", "CPU time, s", "the finest", settings, ("Chaos.",))
    other = ladder._replace(name="shape", rungs=[Rung("b", "1 mm", 0.1, 0.2, 1e-3, {"M": 0.1})])
    made = report.make_report([ladder, other], None, 1.0, None, "walker", Path("here"))
    assert [len(table.columns) for table in made.visible_tables()] == [5] * (1 + shown)
    assert (f"Bias: {rungs} rows in accuracy.csv" in made.lines) != shown
    assert "reference: the finest" in (made.table.notes if shown else made.lines)
    assert len(made.facts["ladders"]["steps"]) == rungs
    rows = list(made["accuracy"])
    assert len(rows) == rungs + 1
    assert (rows[0]["ladder"], rows[0]["n"], rows[0]["M"], rows[-1]["M"]) == ("steps", 0, None, 0.1)


def test_an_answer_that_the_budget_does_not_reach_stays_as_shipped():
    survey = known(survey_of(60.0), (100.0,) * 5, se=5.0)
    candidates = [survey.to_candidate(one) for one in survey.measured.values()]
    before = Answer(Tolerance(0.01, True), "own step", 8, 10.0, 2.0, "scaled", "as shipped")
    answer, choice = answers._refine(before, candidates, survey)
    assert choice is None
    assert answer == before._replace(why=answer.why)
    assert answer.why.startswith("as shipped. This budget: the most accurate setting has an error of")
    wide, choice = answers._refine(before._replace(error=Tolerance(0.5, True)), candidates, survey)
    assert (wide.known, wide.runs) == ("now", choice.runs)


def test_errors_that_save_no_time_are_said_and_none_is_drawn_below_the_floor():
    survey = known(survey_of(60.0), (100.0,) * 5, se=0.5, costs=(0.2, 0.1, 0.07, 0.05, 0.04))
    candidates = [survey.to_candidate(one) for one in survey.measured.values()]
    blank = Answer(Tolerance(0.2, True), "-", None, None, None, "scaled", "")
    every = [answers._refine(blank._replace(error=wanted), candidates, survey) for wanted in answers.ERROR_LEVELS]
    found, (line,) = answers.drop_free(every)
    rows = [answer for answer, _ in found]
    assert [str(row.error) for row in rows] == ["5 %", "2 %", "1 %"]
    assert line.startswith("Errors above 5 % save no time: 5 % takes ")
    waits = [row.expected_s for row in rows if row.expected_s]
    assert waits[1] > answers.FREE_RATIO * waits[0]
    assert answers.drop_free(found) == (found, [])
    (axes,) = answers.draw_choice("walker", candidates, rows, 0.03).axes
    told = [text.get_text() for text in axes.texts]
    assert [text.partition(":")[0] for text in told[:-1]] == ["5 %"]
    assert "no dot for 2 % (extrapolated) and 1 % (" in told[-1]
    (floored,) = answers.draw_choice("walker", candidates, rows, 0.5).axes
    assert not [line for line in floored.get_lines() if line.get_marker() == "o"]
