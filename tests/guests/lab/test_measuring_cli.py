"""`analyse` and `fit` as a user meets them: from files to tables, figures and a scene."""

import json

import numpy as np
import pytest
from command_checks import rows_of
from synthetic_tracks import Walker, film

from walkergen.core.scene import Scene
from walkergen.files import templates

WALKER = Walker()


def as_trackpy_writes(path, filmed, mm_per_px):
    """The DataFrame that trackpy.link returns, with headings, in an image whose y grows down."""
    import pandas as pd

    parts = []
    for one in filmed.tracks:
        x, y = one.position.T / mm_per_px
        parts.append(
            pd.DataFrame(
                {
                    "y": 500 - y,
                    "x": 500 + x,
                    "mass": 1e6,
                    "size": 3.0,
                    "ecc": 0.1,
                    "frame": np.arange(len(x)),
                    "particle": one.particle,
                    "theta": -one.heading,
                }
            )
        )
    pd.concat(parts).dropna().sort_values(["frame", "particle"]).to_csv(path)


FILM = ("--fps", "100", "--mm-per-px", "0.05", "--y-down")


@pytest.mark.slow
def test_known_speed_and_persistence_come_out_of_a_trackpy_file(run, tmp_path):
    as_trackpy_writes(tmp_path / "film.csv", film(11, 10, 20.0, WALKER), 0.05)
    found = json.loads(run("analyse", "film.csv", *FILM, "--json").stdout)
    for name, expected in (
        ("speed_{}mm_s", WALKER.speed),
        ("persistence_time_{}s", 1 / WALKER.rate),
        ("turning_bias_{}rad_s", WALKER.turn),
        ("diffusivity_{}mm2_s", WALKER.diffusivity),
    ):
        value, error = found[name.format("")], found[name.format("se_")]
        assert abs(value - expected) < 4 * error, name
        assert 0 < error < expected, name
    assert found["particles"] == 10
    assert found["lag_s"] == pytest.approx(0.04)
    folder = tmp_path / "out" / "film" / "analysis"
    rows = {row["quantity"]: row for row in rows_of(folder / "analysis.csv")}
    assert float(rows["speed_mm_s"]["value"]) == found["speed_mm_s"]
    assert rows["motion_speed_mm_s"]["refused"]


def test_table_names_bad_rows_and_what_the_errors_rest_on(run, tmp_path):
    rows = "".join(f"{n},0,{0.1 * n},{0.01 * n * n}\n" for n in range(400))
    (tmp_path / "a [red] b.csv").write_text(f"frame,particle,x,y\n{rows}400,0,x,1\n")
    result = run("analyse", "a [red] b.csv", "--fps", "50", "--mm-per-px", "1", "--no-pictures")
    assert result.exit_code == 0, result.exception
    for words in ("1 bad row", "line 402", "pieces", "a [red] b.csv"):
        assert words in result.stdout.replace("\n", " ")
    assert (tmp_path / "out" / "a-red-b" / "analysis" / "analysis.md").is_file()


@pytest.mark.parametrize("particles", [1, 9])
@pytest.mark.parametrize("frames", [3, 200])
@pytest.mark.parametrize("lane", [(), ("--lane",)])
@pytest.mark.parametrize("path", ["resting", "straight", "circling", "far"])
def test_films_without_any_noise_end_in_a_table(run, tmp_path, path, frames, particles, lane):
    step = np.arange(frames)
    x, y = {
        "resting": (0.0 * step, 0.0 * step),
        "straight": (1.0 * step, 0.0 * step),
        "circling": (10 * np.cos(0.05 * step), 10 * np.sin(0.05 * step)),
        "far": (1e8 + step, 1e-8 * step**2),
    }[path]
    rows = [f"{n},{p},{x[n]:.17g},{y[n]:.17g},{0.05 * n:.17g}\n" for p in range(particles) for n in range(frames)]
    (tmp_path / "film.csv").write_text("frame,particle,x,y,theta\n" + "".join(rows))
    result = run("analyse", "film.csv", "--fps", "50", "--mm-per-px", "1", "--no-pictures", "--lag-ms", "20", *lane)
    assert result.exit_code == 0, result.exception
    assert "value ± standard error" in " ".join(result.stdout.split())
    table = tmp_path / "out" / "film" / "analysis" / "analysis.csv"
    rows = rows_of(table)
    assert len(rows) > 10
    for row in rows:
        assert bool(row["refused"]) != bool(row["value"]), row
        assert np.isfinite(float(row["value"] or 0.0)), row


def test_a_file_name_never_becomes_a_path(run, tmp_path):
    (tmp_path / "...csv").write_text("frame,particle,x,y\n" + "".join(f"{n},0,{n},0\n" for n in range(50)))
    run("analyse", "...csv", "--fps", "50", "--mm-per-px", "1", "--no-pictures")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["results"]


SPEEDS = """tilt_deg,speed_mm_s,speed_se_mm_s,legs
2.5,67.9,0.5,flexible
5,78.4,0.5,flexible
10,58.6,0.5,flexible
15,44.0,0.5,flexible
20,34.6,0.5,flexible
30,22.2,0.5,
10,0.3,0.5,braced
15,-,0.5,flexible
20,0.3,0.5,brased
"""


THEORY = ("fit", "speeds.csv", "--model", "theory")


def test_fit_writes_a_scene_in_which_the_theory_has_the_speeds(run, tmp_path):
    (tmp_path / "speeds.csv").write_text(SPEEDS)
    found = json.loads(run(*THEORY, "--fix", "restitution=0.8", "--json").stdout)
    assert found["fitted"] == ["friction", "impact_speed_factor"]
    assert found["dof"] == 5
    told = " ".join(found["notes"])
    assert "2 bad rows" in told
    assert "legs is 'brased', not one of flexible, braced" in told
    folder = tmp_path / "out" / "speeds" / "fit"
    words = ("predict", "--scene", str(folder / "scene.toml"), "--tilt", "10", "--json")
    (row,) = json.loads(run(*words).stdout)["rows"]
    assert row["theory_mm_s"] == pytest.approx(found["predicted_mm_s"][2], rel=1e-6)
    assert "theory_mm_s match the speeds" in told
    name = templates.load(str(folder / "scene.toml"), "scenes", Scene).name
    assert name == "lane-90hz-fit-speeds" not in templates.names("scenes")
    rows = rows_of(folder / "speeds.csv")
    assert [row["legs"] for row in rows] == ["flexible"] * 6 + ["braced"]


def frames_of(filmed, mm_per_px, size):
    """Pictures of bright spots on a dark plate, with the camera's noise."""
    rng = np.random.default_rng(0)
    rows, columns = np.mgrid[:size, :size]
    pictures = []
    for moment in zip(*(one.position for one in filmed.tracks), strict=True):
        picture = rng.normal(10.0, 3.0, (size, size))
        for number, place in enumerate(np.array(moment) / mm_per_px):
            # Far enough from one another never to be taken for each other.
            x, y = place + size * (0.25 + 0.5 * np.array([number % 2, number // 2]))
            low, high = int(y) - 12, int(y) + 13
            near = np.s_[low:high, int(x) - 12 : int(x) + 13]
            square = (rows[near] - y) ** 2 + (columns[near] - x) ** 2
            picture[near] += 200 * np.exp(-square / (2 * 2.5**2))
        pictures.append(picture.clip(0, 255).astype(np.uint8))
    return pictures


@pytest.mark.nightly
def test_known_motion_comes_out_of_a_film_that_trackpy_tracked(run, tmp_path):
    import warnings

    import trackpy

    walker = Walker(speed=20.0, rate=8.0, turn=0.0, noise=0.0, lost=0.0)
    filmed = film(21, 4, 5.0, walker, interval=0.02)
    with warnings.catch_warnings(action="ignore"):  # trackpy calls pandas in ways it deprecates
        trackpy.quiet()
        spots = trackpy.batch(frames_of(filmed, 0.5, 400), 13, minmass=1000, processes=1)
        linked = trackpy.link(spots, search_range=6, memory=2)
    linked.to_csv(tmp_path / "film.csv")
    assert linked.particle.nunique() == 4
    found = json.loads(run("analyse", "film.csv", "--fps", "50", "--mm-per-px", "0.5", "--json").stdout)
    for name, expected in (
        ("speed_{}mm_s", 20.0),
        ("persistence_time_{}s", 1 / 8),
        ("diffusivity_{}mm2_s", 25.0),
        ("ballistic_speed_{}mm_s", 20.0),
    ):
        value, error = found[name.format("")], found[name.format("se_")]
        assert abs(value - expected) < 3.5 * error, name
        assert 0 < error < 0.4 * expected, name


@pytest.mark.slow
def test_the_film_of_a_simulation_has_the_simulations_speed(run, tmp_path):
    words = ("--tilt", "10", "--seconds", "6", "--runs", "4", "--json")
    simulated = json.loads(run("simulate", *words, "--trajectory", "run.csv").stdout)
    found = json.loads(run("analyse", "run.csv", "--json", "--no-pictures").stdout)
    errors = np.hypot(found["speed_se_mm_s"], simulated["speed_se_mm_s"])
    # Sampled flights end at other times, and motion is chaotic: another run of the same ensemble.
    assert abs(found["speed_mm_s"] - simulated["speed_mm_s"]) < 4 * errors
    assert errors < 0.05 * simulated["speed_mm_s"]
