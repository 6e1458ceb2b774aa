"""What `accuracy` answers from what is shipped: the law of the step, the advice, and whether both are true."""

import math
from itertools import product

import numpy as np
import pytest

from evidence.accuracy import measure
from walkergen.commands.accuracy import answers, cell_estimates, cells, choice, machine_speed, step_law
from walkergen.commands.accuracy.cells import REFERENCE_STEP_SHARE, Row
from walkergen.commands.accuracy.request import AccuracyRequest
from walkergen.core.scene import Scene
from walkergen.core.simulation import ensemble
from walkergen.core.tolerance import Tolerance
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import run_time, walkers

PEAK = step_law.CELLS_PEAK_SPEED_MM_S
SPACE = (REFERENCE_STEP_SHARE, 0.5, 1.0, 1.25, 1.6)


def made_up(slope, se, power, rng, cell=("lane-90hz", 10.0, 0.8), speed=50.0):
    """Rows of a cell whose speed errs by a share of itself, by a power of the step."""
    rows = []
    for share in SPACE:
        value = speed * (1.0 + slope * share**power) + rng.normal(0.0, se)
        rows.append(Row(*cell, share, share, value, se, 8, 5.0, 1.0 / share, "8 ok"))
    return rows


def estimate(design="koumakis2016", scene="lane-90hz", restitution=0.8, **changed):
    walker = templates.load(design, "walkers", Design).variant(**changed)
    ground = templates.load(scene, "scenes", Scene).variant(**{"contact.restitution": restitution})
    return cell_estimates.estimate(walker, ground)


def test_every_cell_has_every_setting_and_the_file_is_small():
    rows = cells.read_rows()
    found = [(*row.cell, row.share) for row in rows]
    assert sorted(found) == sorted(measure.list_settings())
    assert cells.CELLS_PATH.stat().st_size < 50_000
    assert cells.CELLS_PATH.read_text().startswith("# walkergen ")
    for row in rows:
        assert row.work > 0.0
        assert row.se_mm_s is not None, row


def test_what_is_written_is_what_is_read(tmp_path):
    rows = tuple(made_up(0.0, 0.1, 1, np.random.default_rng(1)))
    (tmp_path / "cells.csv").write_text(measure.format_rows(rows))
    for read, row in zip(cells.read_rows(tmp_path / "cells.csv"), rows, strict=True):
        assert read.speed_mm_s == pytest.approx(row.speed_mm_s, rel=1e-4)  # five digits
        assert (read.share, read.runs, read.outcomes) == (row.share, row.runs, row.outcomes)


@pytest.mark.parametrize("power", [1, 2])
def test_the_law_finds_the_bias_it_was_given_and_how_much_walkers_differ(power):
    rng = np.random.default_rng(3)
    rows = []
    for number in range(200):
        slope = rng.normal(-0.02, 0.01)
        rows += made_up(slope, 0.2, power, rng, ("lane-90hz", 10.0, 0.1 + number))
    law = step_law.fit_laws(PEAK, tuple(rows))[False]
    (own,) = (one for one in law.slopes if one.power == power)
    assert own.share.value == pytest.approx(-0.02, abs=4.0 * own.share.se)
    assert own.between == pytest.approx(0.01, rel=0.2)  # a standard deviation of 200 has 5 %
    assert own.misfit == pytest.approx(1.0, abs=0.2)
    assert law.bias_bound(0.5) >= own.bias_bound(0.5) >= 0.02 * 0.5**power
    assert law.floor == pytest.approx(2.0 * 0.2 / 50.0 / math.sqrt(200), rel=0.05)


def test_slow_walkers_have_a_law_of_their_own():
    rng = np.random.default_rng(4)
    rows = [*made_up(0.0, 0.1, 1, rng, ("lane-90hz", 1.0, 0.8), 0.5), *made_up(0.1, 0.1, 1, rng)]
    laws = step_law.fit_laws(PEAK, tuple(rows))
    assert laws[True].cells == laws[False].cells == 1
    assert laws[True].bias_bound(1.0) < laws[False].bias_bound(1.0)


def test_a_smaller_error_costs_more_and_its_parts_are_within_it():
    at, before = estimate(tilt=5), 0.0
    assert at.known == "measured"
    for error in (0.5, 0.2, 0.1, 0.05):
        found = choice.choose(at.candidates(0.05), error)
        assert found.cpu_s >= before
        assert math.hypot(found.candidate.bias, 2.0 * found.se) <= found.error <= error
        assert found.wall_time_s(1) > found.wall_time_s(8) > choice.STARTUP_S
        before = found.cpu_s


def test_what_the_cells_do_not_know_is_said_in_a_line():
    at = estimate(tilt=5)
    candidates = at.candidates(0.05)
    below, _ = answers.find_in_cells(at, candidates, Tolerance(0.5 * at.law.floor, True))
    assert below.known in ("law", "measured")
    told, _ = answers.find_in_cells(at, candidates, Tolerance(1e-4, True))
    assert (told.setting, told.runs) == ("-", None)
    assert "simulate ‹error=›0.01 %" in told.why
    assert "\n" not in told.why


@pytest.mark.parametrize(
    ("accepted", "row"), [(None, None), (0.005, None), (0.05, "5 %"), (0.15, "10 %"), (3.0, "20 %")]
)
def test_the_row_that_an_accepted_error_allows_is_marked(accepted, row, monkeypatch, tmp_path):
    monkeypatch.setattr(machine_speed, "cpu_per_s", lambda: 0.05)
    values = {} if accepted is None else {"set": {"scene.run.accepted_error": accepted}}
    told = AccuracyRequest.from_values(values | {"out": tmp_path / "out"}).run(lambda *_: None)
    assert [one["error"] for one in told.facts["answers"] if one["accepted"]] == ([] if row is None else [row])
    assert (f"{row}, accepted" in told.markdown()) == (row is not None)
    assert ("every error of the table is larger. Run simulate error=0.5%" in told.markdown()) == (accepted == 0.005)


@pytest.mark.parametrize(
    ("design", "scene", "known"),
    [
        ("koumakis2016", "lane-90hz", "measured"),  # at 10 deg, a cell
        ("koumakis2016", "plane-90hz", "measured"),
        ("bristle", "plane-90hz", "scaled"),
        ("coinbot", "table-motor", "scaled"),
    ],
)
def test_the_papers_walker_on_its_plates_was_measured_and_others_are_scaled(design, scene, known, monkeypatch):
    monkeypatch.setattr(run_time, "rate_from_steps", lambda plan: math.inf)  # none is simulated
    walker = templates.load(design, "walkers", Design)
    at = cell_estimates.estimate(walker, templates.load(scene, "scenes", Scene))
    assert at.known == known
    assert at.peak > 0.0
    assert choice.choose(at.candidates(0.05), 0.2) is not None


def test_what_is_scaled_is_known_to_the_factor_that_is_told(monkeypatch):
    """Each tilt of the lane between two others is left out in turn, and read between those."""
    monkeypatch.setattr(machine_speed, "cpu_per_s", lambda: 0.05)
    monkeypatch.setattr(run_time, "rate_from_steps", lambda plan: math.inf)  # none is simulated
    every = cells.read_rows()
    tilts = sorted({row.tilt_deg for row in every if row.scene == cell_estimates.LANE_SCENE})
    ratios = []
    for tilt, restitution in product(tilts[1:-1], (0.5, 0.8, 0.9)):
        others = tuple(row for row in every if row.cell[:2] != (cell_estimates.LANE_SCENE, tilt))
        shares = []
        for rows in (every, others):
            monkeypatch.setattr(cells, "read_rows", lambda rows=rows: rows)
            at = estimate(tilt=tilt, restitution=restitution)
            shares.append(math.sqrt(at.variance_time) / at.unit)
        ratios.append(math.log(shares[0] / shares[1]))
    assert math.exp(math.sqrt(np.mean(np.square(ratios)))) == pytest.approx(
        cell_estimates.SCALED_SCATTER_FACTOR, abs=0.1
    )
    monkeypatch.setattr(cells, "read_rows", lambda: every)
    scaled, measured = (
        answers.answer_from_cells(estimate(tilt=tilt), "walker", None).rows[0].why for tilt in (12.0, 10.0)
    )
    assert "to a factor of 1.3" in scaled
    assert "to a factor" not in measured


def test_the_scatter_of_a_plate_goes_with_its_speed_squared(monkeypatch):
    scene = templates.load("lane-90hz", "scenes", Scene)
    faster = scene.model_copy(update={"drive": scene.drive.model_copy(update={"gamma": 3.6})})
    walker = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=5.0)
    monkeypatch.setattr(run_time, "rate_from_steps", lambda plan: math.inf)  # none is simulated
    one, two = (cell_estimates.estimate(walker, ground) for ground in (scene, faster))
    assert two.peak == pytest.approx(2.0 * one.peak)
    assert two.speed == pytest.approx(2.0 * one.speed)
    assert two.variance_time == pytest.approx(4.0 * one.variance_time)


def test_what_is_scaled_has_its_own_speed_and_its_own_cost(monkeypatch):
    """Near the threshold, at 200 Hz and 1.05 g, it is far slower than its plate's speed alone says."""
    monkeypatch.setattr(machine_speed, "cpu_per_s", lambda: 0.05)
    scene = templates.load("lane-90hz", "scenes", Scene).variant(**{"drive.frequency_hz": 200.0, "drive.gamma": 1.05})
    at = cell_estimates.estimate(templates.load("koumakis2016", "walkers", Design), scene)
    assert at.known == "scaled"
    assert at.speed < 6.0
    seconds = at.work(1.0) * 0.05  # of this walker, at its own step, by today's machine
    assert 0.01 < seconds < 1.0


def test_nothing_is_drawn_below_what_the_truth_is_known_to(monkeypatch):
    monkeypatch.setattr(machine_speed, "cpu_per_s", lambda: 0.05)
    at = estimate(tilt=5)
    made = answers.answer_from_cells(at, "walker", None)
    (axes,) = made.draw().axes
    for line in axes.get_lines():
        heights = np.asarray(line.get_ydata(), dtype=float)
        assert not np.any(heights < at.law.floor * (1 - 1e-9))
    labels = {line.get_label() for line in axes.get_lines()}
    assert "least error for the time" in labels
    told = "\n".join(text.get_text() for text in axes.texts)
    assert all(str(row.error).removesuffix(" %") in told for row in made.rows if row.known == "measured")


def test_the_pace_is_measured_once_and_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    calls = []
    monkeypatch.setattr(machine_speed, "measure_cpu_per_s", lambda: calls.append(1) or 0.25)
    assert machine_speed.cpu_per_s() == machine_speed.cpu_per_s() == 0.25
    assert len(calls) == 1
    (kept,) = (tmp_path / "walkergen" / "pace").iterdir()
    kept.write_text("{")
    assert machine_speed.cpu_per_s() == 0.25
    assert len(calls) == 2


@pytest.mark.slow
def test_a_cell_measured_anew_is_the_one_that_is_shipped():
    """Its own rival: other random numbers, four standard errors; costs within a factor of two of a busy machine."""
    setting = measure.Setting("lane-90hz", 5.0, 0.8, 1.25)
    row = measure.measure_row(setting, seed=1001)
    (kept,) = (one for one in cells.read_rows() if (*one.cell, one.share) == setting)
    error = math.hypot(row.se_mm_s or 0.0, kept.se_mm_s or 0.0, ensemble.MAX_SPEED_DIFFERENCE * PEAK)
    assert row.speed_mm_s == pytest.approx(kept.speed_mm_s, abs=4.0 * error)
    assert 0.5 < row.work / kept.work < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("error", [0.1, pytest.param(0.05, marks=pytest.mark.nightly)])
def test_advice_reaches_its_error_in_fresh_runs(error):
    """Against the reference of the cell, whose own error comes on top; six times, of which 95 % hold."""
    at = estimate(tilt=5)
    found = choice.choose(at.candidates(0.05), error)
    (true,) = (row for row in at.cell if row.share == REFERENCE_STEP_SHARE)
    room = math.hypot(error * at.unit, 2.0 * true.se_mm_s)
    inside = 0
    for seed in range(2001, 2007):
        one = measure.build_walker(measure.Setting("lane-90hz", 5.0, 0.8, 1.0), seed)
        one = one.with_run_settings(runs=found.runs, seconds=found.seconds, step_us=found.candidate.step_us)
        speed = walkers.simulate(one, threads=1).summary.speed.value
        inside += abs(speed - true.speed_mm_s) <= room
    assert inside >= 5
