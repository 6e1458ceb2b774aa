"""Sweeps of crowds: a row a crowd, its statistics with errors; kept, taken up again, refused.

Random walks stand for the simulator; one slow test runs it, beside the command `crowd`.
"""

import json
from pathlib import Path

import pytest
from command_checks import rows_of
from scipy import stats
from test_crowd_job import walk

from walkergen.core.files.progress import silent
from walkergen.guests.crowd import in_space as crowd_space
from walkergen.guests.crowd.make import simulate
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.space import run as crowds
from walkergen.guests.sweep import axes, make, sweep_setup
from walkergen.guests.sweep.request import SweepRequest
from walkergen.points.store import Store

PACKINGS = "scene.crowd.packing=0.1,0.2"
SHORT = ("scene.run.seconds=2", "scene.run.runs=4")


@pytest.fixture
def calls(monkeypatch):
    """Walkers and number of every run, by random walks; moments that compile left out."""
    made = []

    def counted(plan, number, *rest):
        if plan.scene.run.seconds > 0.1:
            made.append((len(plan.kinds), number))
        return walk(plan, number, *rest)

    monkeypatch.setattr(crowds, "simulate", counted)
    return made


@pytest.fixture
def store(tmp_path):
    kept = Store(tmp_path / "points.sqlite")
    yield kept
    kept.close()


def points_of(*texts, keep=None, design="polar-disc", model=None, error=None):
    space, constants = sweep_setup.make_space([axes.parse(text) for text in texts], None, 1)
    names = design, None, None
    return sweep_setup.make_points(names, Path(), space, constants, model, error, keep, "--set")


def swept(store, *texts, folder=None, pictures=False, **choices):
    request, points = SweepRequest(pictures=pictures), points_of(*texts, **choices)
    if folder is None:
        return make.evaluate_all(request, points, store, None, silent)
    return make.make_sweep(request, points, folder, store, None, silent)


def test_each_row_is_what_the_command_crowd_says_of_the_same_crowd(calls, store):
    keep = ["polar_order", "speed", "largest_cluster"]
    report = swept(store, PACKINGS, *SHORT, keep=keep)
    points = points_of(PACKINGS, *SHORT)
    assert [row[0] for row in report.table.rows] == [0.1, 0.2]
    for row in report.table.rows:
        cells = dict(zip(report.table.keys, row, strict=True))
        point = points.point({"scene.crowd.packing": cells["scene.crowd.packing"]})
        own = CrowdRequest(threads=2)
        crowd = crowd_space.make_population(own, point.scene, [point.design])
        numbers = simulate(own, crowd, silent).statistics.numbers
        assert cells["walkers"] == len(crowd.kind_indices)
        assert cells["runs"] == 4
        for name in keep:
            unit = "_mm_s" if name == "speed" else ""
            assert cells[f"{name}{unit}"] == numbers[name].value
            assert cells[f"{name}_se{unit}"] == numbers[name].se > 0.0
        assert cells["status"] == "ok"


def test_bounds_follow_student_of_the_runs(calls, store):
    (row,) = swept(store, "scene.crowd.count=4", *SHORT, keep=["speed"]).table.rows
    assert len(row) == 3 + 4 + 1
    value, se, low, high = row[3:7]
    width = stats.t.ppf(0.975, 3) * se
    assert (low, high) == pytest.approx((value - width, value + width), rel=1e-9)


def test_a_crowd_is_simulated_once_whatever_is_kept_of_it(calls, store):
    swept(store, PACKINGS, *SHORT, keep=["polar_order"])
    first = len(calls)
    assert first == 2 * 4
    wider = swept(store, "scene.crowd.packing=0.1,0.2,0.3", *SHORT, keep=["milling", "packing"])
    assert len(calls) == first + 4
    assert "2 of the points were stored before" in wider.lines
    assert all(value is not None for value in wider.table["milling"])


def test_a_sweep_that_is_stopped_goes_on_at_the_crowd_that_it_was_in(calls, store, monkeypatch):
    counted = crowds.simulate

    def stopping(plan, number, *rest):
        if calls and len(plan.kinds) > calls[0][0]:
            raise KeyboardInterrupt
        return counted(plan, number, *rest)

    monkeypatch.setattr(crowds, "simulate", stopping)
    with pytest.raises(KeyboardInterrupt):
        swept(store, PACKINGS, *SHORT)
    assert len(calls) == 4
    monkeypatch.setattr(crowds, "simulate", counted)
    assert "1 of the points were stored before" in swept(store, PACKINGS, *SHORT).lines
    assert len(calls) == 8


def test_the_folder_has_a_table_and_a_picture_of_each_statistic(calls, store, tmp_path):
    folder = tmp_path / "map"
    report = swept(
        store,
        PACKINGS,
        "legs.tilt_deg=0,10",
        *SHORT,
        design="koumakis2016",
        keep=["polar_order", "wall_density"],
        folder=folder,
        pictures=True,
    )
    names = {path.name for path in folder.iterdir()}
    assert {"table.csv", "polar_order.png", "wall_density.pdf", "manifest.json"} <= names
    assert "sweep.png" not in names
    rows = rows_of(folder / "table.csv")
    assert [(row["scene.crowd.packing"], row["legs.tilt_deg"]) for row in rows] == [
        ("0.1", "0"),
        ("0.1", "10"),
        ("0.2", "0"),
        ("0.2", "10"),
    ]
    assert float(rows[0]["polar_order"]) == report.table["polar_order"][0]
    assert json.loads((folder / "manifest.json").read_text())["model"] == "crowd"


def test_dishes_are_values_too_and_without_walls_there_is_no_number_of_them(calls, store):
    dishes = 'scene.crowd.arena_mm=disc:150,"ring:200,60",periodic:150'
    report = swept(store, dishes, "scene.crowd.count=4", *SHORT, keep=["wall_density"])
    assert [row[0] for row in report.table.rows] == ["disc:150", "ring:200,60", "periodic:150"]
    last = dict(zip(report.table.keys, report.table.rows[2], strict=True))
    assert (last["wall_density"], last["wall_density_se"]) == (None, None)
    assert last["status"] == "ok"


def test_a_crowd_without_room_is_a_row_that_says_so(calls, store):
    report = swept(store, "scene.crowd.packing=0.2,0.9", *SHORT, keep=["speed"])
    good, bad = report.table.rows
    assert good[-1] == "ok"
    assert bad[-1].startswith("refused: ")
    assert "do not fit" in bad[-1]


def test_crowds_have_four_runs_unless_the_runs_are_set(calls, store):
    report = swept(store, "scene.crowd.count=3", "scene.run.seconds=2")
    assert report.table["runs"][0] == 4
    other = swept(
        store, "legs.tilt_deg=5,10", "scene.run.seconds=2", "scene.run.runs=2", model="crowd", design="koumakis2016"
    )
    assert list(other.table["runs"]) == [2, 2]
    assert list(other.table["walkers"]) == [10, 10]


def test_walkers_that_fell_and_lost_energy_are_told_in_the_status(store, monkeypatch):
    def falling(plan, number, *rest):
        run = walk(plan, number, *rest)
        return run._replace(outcomes=("fell", *run.outcomes[1:]))

    def losing(plan, number, *rest):
        return walk(plan, number, *rest)._replace(energy_error=0.4)

    one = ("scene.crowd.count=4", *SHORT)
    monkeypatch.setattr(crowds, "simulate", falling)
    assert "4 fell, of 16" in swept(store, *one).table.rows[0][-1]
    monkeypatch.setattr(crowds, "simulate", losing)
    assert "40 %" in swept(store, *one, "scene.run.seed=2").table.rows[0][-1]


def test_a_file_asks_for_crowds_as_the_command_line_does(tmp_path):
    file = tmp_path / "sweep.toml"
    file.write_text(
        'design = "polar-disc"\nkeep = ["milling"]\n[set]\n"scene.run.seconds" = 2\n'
        '[grid]\n"scene.crowd.packing" = [0.1, 0.2]\n'
    )
    line = points_of(PACKINGS, "scene.run.seconds=2", keep=["milling"])
    assert sweep_setup.from_file(file) == line._replace(file=file)
