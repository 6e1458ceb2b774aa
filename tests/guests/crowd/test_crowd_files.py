"""Crowds as files of other programs, read back: CSV, extended XYZ, movies, stills."""

import io
import json
import re

import numpy as np
import pytest
from crowd_films import BOX, gas, make_film
from PIL import Image

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.core.errors import InputError
from walkergen.core.files.progress import silent
from walkergen.files import animation, extended_xyz
from walkergen.guests.crowd import figures as crowd_figures
from walkergen.guests.crowd import files as crowd_files
from walkergen.guests.crowd import movie as crowd_movie
from walkergen.guests.crowd import statistics as crowds
from walkergen.guests.crowd import tables as crowd_tables
from walkergen.guests.crowd.statistics import film as films


def running(dish="periodic:50", walkers=6, frames=12):
    """Walkers that run out of a periodic square; the last is not seen in the third frame."""
    rng = np.random.default_rng(1)
    start = rng.uniform(-20.0, 20.0, (walkers, 3))
    ways = rng.normal(0.0, 6.0, (walkers, 3))
    places = start + ways * np.arange(frames)[:, None, None]
    places[2, -1] = np.nan
    return make_film(places, dish)


def test_csv_is_read_back_to_the_same_film(tmp_path):
    film = running()
    path = tmp_path / "run.csv"
    path.write_bytes(crowd_files.to_csv(film))
    assert path.read_text().splitlines()[0] == "t_s,particle,x_mm,y_mm,theta_rad"
    back = films.from_tracks(track_files.read_tracks(path, Units()), film.dish, [BOX])
    for key in ("times", "x", "y", "areas", "radii"):
        np.testing.assert_allclose(getattr(back, key), getattr(film, key), atol=1e-9)
    turned = (back.theta - film.theta) / (2.0 * np.pi)
    assert np.nanmax(np.abs(turned - np.rint(turned))) < 1e-9


def test_extended_xyz_has_a_frame_for_each_time_and_who_was_seen():
    film = running()
    lines, at = crowd_files.to_xyz(film).decode().splitlines(), 0
    for frame in range(len(film.times)):
        count, keys = int(lines[at]), lines[at + 1]
        assert count == np.isfinite(film.x[frame]).sum()
        assert 'pbc="T T F"' in keys
        assert f"Properties={extended_xyz.PROPERTIES}" in keys
        assert float(re.search(r"Time=(\S+)", keys)[1]) == pytest.approx(film.times[frame])
        rows = [line.split() for line in lines[at + 2 : at + 2 + count]]
        values = np.array([row[1:] for row in rows], dtype=float)
        off = (values[:, 1] - film.x[frame][values[:, 0].astype(int)]) / 50.0
        assert off == pytest.approx(np.rint(off), abs=1e-8)
        assert values[:, 8:] == pytest.approx(np.tile([1.5, 0.5, 0.25], (count, 1)))
        at += 2 + count
    assert at == len(lines)


def test_a_file_of_no_known_kind_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"must end in one of \.mp4, \.gif, \.png"):
        crowd_movie.write(tmp_path / "run.avi", running(), "", 25, silent)


@pytest.mark.parametrize(
    ("dish", "high"), [("disc:60", 60.0), ("ring:60,20", 60.0), ("rectangle:60x30", 30.0), ("periodic:60", 60.0)]
)
def test_a_still_shows_each_walker_in_the_colour_of_its_heading(dish, high):
    places = np.array([[(0.0, 12.0, 0.0), (0.0, -12.0, 0.5 * np.pi), (-13.0, 0.0, np.pi)]] * 4)
    picture = crowd_movie.render_still(make_film(places, dish, BOX * 3.0), "three")
    assert picture == crowd_movie.render_still(make_film(places, dish, BOX * 3.0), "three")
    seen = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(float)
    scale = min(872 / 60.0, 860 / high) * (1 - 4 / 900)
    middle = np.array([seen.shape[0] - 40 - np.ceil(0.5 * scale * high), 450])
    wheel = 255.0 * crowd_movie.heading_colours()
    for (x, y, _), hue in zip(places[0], wheel[[0, 18, 36]], strict=True):
        row, column = (middle + scale * np.array([-y, x])).astype(int)
        assert seen[row, column] == pytest.approx(hue, abs=2.0)


def test_headings_are_equally_bright():
    """Relative luminance by sRGB's weights differs little, while hues go all round."""
    hues = crowd_movie.heading_colours()
    linear = np.where(hues <= 0.04045, hues / 12.92, ((hues + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    assert luminance.std() / luminance.mean() < 0.1
    assert len(np.unique(np.rint(255 * hues), axis=0)) == len(hues)
    assert 0.0 < hues.min()
    assert hues.max() < 1.0


def test_a_walker_over_the_edge_of_a_periodic_square_is_seen_on_both_sides():
    places = np.array([[(30.0, 0.0, 0.0), (0.0, 20.0, 0.0)]] * 4)
    picture = crowd_movie.render_still(make_film(places, "periodic:60", BOX * 4.0), "")
    seen = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"))
    ahead = np.isclose(seen, 255.0 * crowd_movie.heading_colours()[0], atol=2.0).all(axis=2)
    row = seen.shape[0] - 40 - 430
    assert ahead[row, 25:60].any()
    assert ahead[row, -60:-25].any()


def test_a_movie_is_a_gif_or_an_mp4_with_a_frame_for_each_time(tmp_path, monkeypatch):
    film = gas("disc:60", 20, 5, 1)
    assert crowd_movie.write(tmp_path / "a.gif", film, "crowd", 25, silent) == 5
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames == 5
    crowd_movie.write(tmp_path / "b.gif", film, "crowd", 30, silent)
    with Image.open(tmp_path / "b.gif") as gif:  # has the nearest rate that it can
        assert gif.info["duration"] == 40
    monkeypatch.setattr(animation, "find_ffmpeg", lambda: None)
    with pytest.raises(InputError, match=r"ffmpeg is not installed .*; name a \.gif"):
        crowd_movie.write(tmp_path / "a.mp4", film, "crowd", 25, silent)


@pytest.mark.programs
def test_an_mp4_of_a_crowd_has_its_frames(tmp_path):
    film = gas("disc:60", 20, 5, 1)
    assert crowd_movie.write(tmp_path / "a.mp4", film, "crowd", 25, silent) == 5
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize("dish", ["disc:60", "periodic:60"])
def test_tables_and_figures_hold_what_was_measured(dish):
    found = crowds.measure([gas(dish, 30, 10, seed) for seed in range(3)])
    tables = {table.name: table for table in crowd_tables.make_tables(found)}
    numbers = {row["quantity"]: row for row in tables["crowd"]}
    assert numbers["speed_mm_s"]["value"] == found.numbers["speed"].value
    assert numbers["polar_order"]["by_chance"] == found.by_chance["polar_order"]
    assert list(tables["crowd_runs"]["speed_mm_s"]) == list(found.by_run["speed"])
    np.testing.assert_array_equal(tables["crowd_pairs"]["g_se"], found.curves["g"].se)
    assert list(tables["crowd_msd"].keys) == ["lag_s", "msd_mm2", "msd_se_mm2"]
    assert ("crowd_walls" in tables) == (dish == "disc:60")
    shown = [row[0] for row in tables["crowd"].read]
    assert ("wall_speed_mm_s" in shown) == (dish == "disc:60")
    facts = crowd_tables.facts(found)
    assert facts["numbers"]["packing"]["se"] == 0.0
    figures = crowd_figures.figure_functions(found, "crowd")
    assert ("crowd_walls" in figures) == (dish == "disc:60")
    assert all(draw().axes for draw in figures.values())


def odd(name):
    """Films in which a number or a curve is missing."""
    if name == "thin ring":  # no box lies inside it
        return make_film(np.repeat(on_ring()[None], 6, axis=0), "ring:60,56")
    film = gas("disc:60", 2 if name == "two walkers" else 20, 6, 1)
    places = np.stack([film.x, film.y, film.theta], axis=2)
    if name == "still":
        places[:] = places[0]
    if name == "one never seen":
        places[:, 3] = np.nan
    if name == "an empty frame":
        places[2] = np.nan
    return make_film(places, "disc:60", None if name == "no outline" else BOX)


def on_ring():
    angle = np.linspace(0.0, 6.0, 20)
    return np.column_stack([29.0 * np.cos(angle), 29.0 * np.sin(angle), angle])


@pytest.mark.parametrize(
    "name", ["thin ring", "two walkers", "still", "one never seen", "an empty frame", "no outline"]
)
def test_odd_crowds_have_a_page_figures_and_files(name):
    film = odd(name)
    found = crowds.measure([film])
    tables = crowd_tables.make_tables(found)
    json.dumps(crowd_tables.facts(found), allow_nan=False)
    assert all("nan" not in table.csv() for table in tables)
    for draw in crowd_figures.figure_functions(found, name).values():
        assert draw().axes
    assert crowd_movie.render_still(film, name).startswith(b"\x89PNG")
    for write in crowd_files.FORMATS.values():
        assert write(film)
