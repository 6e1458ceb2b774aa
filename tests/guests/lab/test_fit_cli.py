"""`fit --model` as a user meets it: print, film, fit, predict; and what it refuses."""

import json

import pytest
from command_checks import rows_of

from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab.fit import emulated_speeds, model_fit
from walkergen.points import experiments, walkers


@pytest.fixture
def run(run, home):
    return run


HEAD = "tilt_deg,speed_mm_s,speed_se_mm_s\n"


@pytest.fixture
def short(monkeypatch):
    """Fits by a third of the walkers, simulated for less long."""
    for name, count in (("FIRST", 32), ("SECOND", 12), ("AHEAD", 16)):
        monkeypatch.setattr(model_fit, name, count)
    monkeypatch.setattr(emulated_speeds, "RUN_SECONDS", 1.0)


def filmed(tilts, restitution, friction):
    """Speeds of simulated walkers, mm/s, as a file for `fit`."""
    scene = templates.load("lane-90hz", "scenes", Scene)
    changes = {"contact": {"restitution": restitution, "friction": friction}, "run": {"seconds": 6.0, "runs": 2}}
    scene = scene.model_copy(
        update={name: getattr(scene, name).model_copy(update=new) for name, new in changes.items()}
    )
    design = templates.load("koumakis2016", "walkers", Design)
    lines = []
    for tilt in tilts:
        member = design.variant(tilt_deg=tilt)
        asked = experiments.Walker(scene, member, solids.mass_of(member))
        speed = walkers.simulate(asked, lambda what, done, total: None).summary.speed.value
        lines.append(f"{tilt:g},{speed:.2f},2\n")
    return HEAD + "".join(lines)


@pytest.mark.nightly
def test_print_film_fit_predict_is_a_closed_loop(run, short, tmp_path):
    (tmp_path / "speeds.csv").write_text(filmed((8.0, 12.0, 20.0), 0.6, 0.2))
    words = ("fit", "speeds.csv", "--model", "space", "--predict", "15", "--json")
    result = run(*words)
    assert result.exception is None, result.exception
    found = json.loads(result.stdout)
    for name, hidden in (("restitution", 0.6), ("friction", 0.2)):
        row = found["parameters"][name]
        assert abs(row["mean"] - hidden) < 3.5 * row["sd"], name
        assert row["narrowed"] < 0.5, name
    assert any("not constrained" in note and "thickness_mm" in note for note in found["notes"])
    folder = tmp_path / "out" / "speeds" / "fit"
    bands = {float(row["tilt_deg"]): row for row in rows_of(folder / "bands.csv")}
    assert [one["measured"] for one in bands.values()] == ["1", "1", "0", "1"]
    order = ("low_95", "low_90", "low_68", "speed_mm_s", "high_68", "high_90", "high_95")
    for band in bands.values():
        ends = [float(band[name]) for name in order]
        assert ends == sorted(ends)
    truth = float(filmed((15.0,), 0.6, 0.2).splitlines()[1].split(",")[1])
    low, middle, high = (float(bands[15.0][name]) for name in order[::3])
    # One tilt is no test of coverage: it may lie out by half as much again as the 95 % ends.
    assert 1.5 * (low - middle) < truth - middle < 1.5 * (high - middle)

    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    run(*words)  # from what was kept: the same bytes
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before

    toml = [str(folder / name) for name in ("design.toml", "scene.toml")]
    family = run("family", toml[0], "--scene", toml[1], "--tilt", "15", "--legs", "flexible", "--json", "--no-pictures")
    (row,) = json.loads(family.stdout)["rows"]
    assert row["tilt_deg"] == 15
    scene = templates.load(toml[1], "scenes", Scene)
    learnt = found["parameters"]
    assert scene.contact.restitution_sd == pytest.approx(learnt["restitution"]["sd"])
    design = templates.load(toml[0], "walkers", Design)
    assert design.limbs[0].thickness_sd == pytest.approx(learnt["thickness_mm"]["sd"])


@pytest.mark.nightly
def test_one_measured_speed_in_space_names_what_it_cannot_tell_apart(run, short, tmp_path):
    (tmp_path / "speeds.csv").write_text("tilt_deg,speed_mm_s,speed_se_mm_s,legs\n15,42,1,flexible\n15,0.2,1,braced\n")
    result = run("fit", "speeds.csv", "--model", "space", "--predict", "15", "--no-pictures")
    assert result.exception is None, result.exception
    told = " ".join(result.stdout.split())
    assert "not constrained by these speeds" in told
    assert "1 rows of braced legs are left out: they do not constrain the contact" in told
    folder = tmp_path / "out" / "speeds" / "fit"
    (band,) = rows_of(folder / "bands.csv")
    assert float(band["low_95"]) < 42.0 < float(band["high_95"])
    assert float(band["print_scatter_mm_s"]) > 1.0  # prints differ by 5 % at 15 deg
