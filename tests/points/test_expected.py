"""How long a job says that it will take: before it runs, by a moment of it."""

from contextlib import nullcontext

import pytest

from walkergen import inputs
from walkergen.command_table import load_request
from walkergen.core import tolerance
from walkergen.core.files.progress import silent
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects.resolve import replace_without_validation
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab.fit import model_fit
from walkergen.guests.sweep import cost
from walkergen.guests.sweep.axes import Space, make_axis
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points import run_time, walkers
from walkergen.points.experiments import Walker
from walkergen.points.store import Store

TIMES = {"run.seconds": 6.0, "run.runs": 2, "run.discard_seconds": 0.1}


def walker(**keys):
    design = templates.load("koumakis2016", "walkers", Design)
    scene = replace_without_validation(templates.load("lane-90hz", "scenes", Scene), keys)
    return Walker(scene, design, solids.mass_of(design))


@pytest.mark.parametrize(
    ("wanted", "cheaper"), [("1%", "2%"), ("2%", "5%"), ("3%", "5%"), ("5%", "10%"), ("0.5mm/s", "1mm/s")]
)
def test_the_next_cheaper_error_is_in_the_series_1_2_5_10(wanted, cheaper):
    assert run_time.next_larger_error(tolerance.parse_tolerance(wanted)) == tolerance.parse_tolerance(cheaper)


def test_a_short_run_measures_the_cost_of_runs():
    asked = walker(**TIMES)
    said = 2 * run_time.run_cpu_s(asked)
    assert 0.5 < said / walkers.simulate(asked, threads=1).summary.cpu_s < 2.0  # 0.8 to 1.3 on a machine of its own
    assert run_time.total_time([asked]).seconds >= 0.4 * said
    assert run_time.total_time([walker(**TIMES | {"run.seconds": 1.0})]) is None


def test_after_its_first_runs_an_error_reports_the_time_left_and_that_of_a_cheaper_error():
    heard = []
    met = walkers.simulate_to_error(
        walker(**{"run.seconds": 1.0}), tolerance.parse_tolerance("2%"), expect=lambda find: heard.append(find())
    )
    assert heard[0].seconds > 0.0
    assert heard[0].note.startswith("2 % ")
    assert " in all, 5 % " in heard[0].note
    assert met.error <= met.allowed


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("simulate", {"seconds": 0.05, "runs": 1}),
        ("simulate", {"seconds": 0.05, "runs": 1, "tilt": "5,10"}),
        ("sweep", {"set": ["legs.tilt_deg=5,10"]}),
        ("movie", {"seconds": 0.01, "slow": 8.0}),
    ],
)
def test_commands_forecast_their_run_time(name, values, tmp_path):
    heard = []
    out = {"out": str(tmp_path / "film.gif")} if name == "movie" else {}
    asked = load_request(name).from_values(values | out)
    asked.register_time_callback(heard.append)
    asked.run(silent)
    assert len(heard) == 1


class HeardError(Exception):
    """Return the expected run time that a job reports before it runs."""


def test_the_forecast_counts_the_work_of_a_job_beyond_its_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(run_time, "run_cpu_s", lambda walker: 0.0)
    monkeypatch.setattr(inputs, "open_pool", lambda *_: nullcontext())
    speeds = tmp_path / "speeds.csv"
    speeds.write_text("tilt_deg,plate_speed_mm_s,speed_mm_s,speed_se_mm_s\n10,31.2,60,1\n20,31.2,90,1\n")

    def hear(find):
        raise HeardError(find().seconds)

    asked = load_request("fit").from_values({"model": "space", "speeds": speeds, "out": tmp_path / "out"})
    asked.register_time_callback(hear)
    with pytest.raises(HeardError) as told:
        asked.run(silent)
    assert told.value.args == (model_fit.LEARNING_S,)


def test_a_sweep_costs_the_sum_of_its_points_and_a_short_one_is_not_timed(monkeypatch):
    monkeypatch.setattr(run_time, "MOMENT_S", 0.02)
    scene = replace_without_validation(
        templates.load("lane-90hz", "scenes", Scene), {"run.seconds": 1.0, "run.runs": 2}
    )
    space = Space((make_axis("legs.tilt_deg", [float(tilt) for tilt in range(1, 61)], "test"),))
    request = SweepPoints(templates.load("koumakis2016", "walkers", Design), scene, space, "space")
    store = Store()
    try:
        one, two = (cost.estimate(request, store, workers) for workers in (1, 2))
        assert one.points == 60
        assert 0.1 < two.seconds / one.seconds < 2.0
        assert cost.estimate(request._replace(space=Space(space.axes[:0])), store, 1) is None
    finally:
        store.close()
