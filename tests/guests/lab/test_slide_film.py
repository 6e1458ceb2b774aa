"""Friction from films of slides: what was hidden is found again, what is no slide is refused."""

import json
import math

import marker_films as films
import numpy as np
import pytest
from typer.testing import CliRunner

import walkergen as wg
from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.tables import csv_text
from walkergen.core.scene import GRAVITY
from walkergen.guests.lab.calibrate import form, slide_film
from walkergen.guests.track.film import report

HEADER = (*form.HEADER, form.TRACKS_COLUMN)
ANGLE = 25.0


def gain(friction, angle_deg=ANGLE):
    """Acceleration of a part that slides straight down, mm/s2 (Coulomb)."""
    angle = math.radians(angle_deg)
    return GRAVITY * (math.sin(angle) - friction * math.cos(angle))


def write(path, way, frames=60, fps=120.0, noise=0.02, share=0.0, parts=1, seed=1):
    """Tracks of parts that have gone `way`(t) mm along a line askew, as `track` writes them."""
    rng = np.random.default_rng(seed)
    rows = []
    for frame in range(frames):
        for part in range(parts):
            place = way(frame / fps) * np.array([0.8, -0.6]) + rng.normal(0.0, noise, 2) + 10 * part
            rows.append((frame, part, *place, 0.0, frame / fps, *place, 0.0, 0.2, 0.2 * share))
    path.write_text(csv_text(report.COLUMNS, rows))
    return path


@pytest.mark.parametrize("friction", [0.15, 0.3, 0.6])  # 0.6 > tan(25 deg): pushed, it slows down
def test_hidden_frictions_are_found_within_their_errors(tmp_path, friction):
    """200 films with noise: their mean is not off, and their scatter is the error that is told."""
    found = []
    for seed in range(200):
        path = write(tmp_path / "t.csv", lambda t: 900.0 * t + 0.5 * gain(friction) * t**2, frames=30, seed=seed)
        found.append(slide_film.friction(path, ANGLE, 1e-6))
    values, errors = np.array([one.pair for one in found]).T
    assert values.mean() == pytest.approx(friction, abs=4.0 * values.std() / math.sqrt(200))
    # noise here is independent from frame to frame, of which ten are taken to err alike
    ratio = errors.mean() / values.std() / math.sqrt(slide_film.CORRELATED_FRAMES)
    assert 0.8 < ratio < 1.2


def test_angle_and_scale_have_their_part_of_the_error(tmp_path):
    """Against the friction at an angle, and of a scale, that is off by its standard error."""
    sliding = gain(0.3)
    exact = write(tmp_path / "a.csv", lambda t: 0.5 * sliding * t**2, noise=0.0)
    longer = write(tmp_path / "b.csv", lambda t: 1.01 * 0.5 * sliding * t**2, noise=0.0)
    scaled = write(tmp_path / "c.csv", lambda t: 0.5 * sliding * t**2, noise=0.0, share=0.01)
    plain = slide_film.friction(exact, ANGLE, 1e-9)
    assert plain.value == pytest.approx(0.3, abs=1e-9)
    steeper = slide_film.friction(exact, ANGLE + 0.1, 1e-9).value - plain.value
    assert slide_film.friction(exact, ANGLE, 0.1).se == pytest.approx(steeper, rel=0.01)
    off = plain.value - slide_film.friction(longer, ANGLE, 1e-9).value
    assert slide_film.friction(scaled, ANGLE, 1e-9).se == pytest.approx(off, rel=0.01)


def resting(t):
    return 0.5 * gain(0.3) * max(t - 0.25, 0.0) ** 2


@pytest.mark.parametrize(
    ("made", "angle", "hint"),
    [
        ({"way": resting}, ANGLE, "the friction seems to change by .*Cut it with track frames"),
        ({"way": lambda t: 3000 * t**2}, ANGLE, "Without friction it would gain 4.14e[+]03"),
        ({"way": lambda t: 300 * t**2, "parts": 2}, ANGLE, "2 tracks move, but only one part may slide"),
        ({"way": lambda t: 300 * t**2, "frames": 6}, ANGLE, "6 frames: must be at least 10"),
    ],
)
def test_what_is_no_slide_is_refused(tmp_path, made, angle, hint):
    path = write(tmp_path / "t.csv", **made)
    with pytest.raises(InputError, match=hint):
        slide_film.friction(path, angle, 0.5)


def test_calibrate_joins_films_with_angles(tmp_path):
    for number in range(2):
        write(tmp_path / f"{number}.csv", lambda t: 0.5 * gain(0.3) * t**2, seed=number)
    rows = [("block", "filmed_deg", ANGLE, 0.3, "", "", "", f"{n}.csv") for n in range(2)]
    rows += [("block", "slides_deg", math.degrees(math.atan(0.3)), 0.5, "", "", "", "")] * 3
    path = tmp_path / "m.csv"
    path.write_text(csv_text(HEADER, rows))
    words = ["calibrate", str(path), "--out", str(tmp_path), "--no-pictures", "--json", "--quiet"]
    told = CliRunner().invoke(command_line, words)
    assert told.exit_code == 0, told.output
    (row,) = (one for one in json.loads(told.stdout)["measured"] if one["quantity"] == "friction")
    assert row["value"] == pytest.approx(0.3, abs=2.0 * row["se"])
    assert (row["readings"], row["dof"]) == (5, 2)
    path.write_text(csv_text(HEADER, [("block", "slides_deg", 20, 1, "", "", "", "0.csv")]))
    with pytest.raises(InputError, match="slides_deg does not use the column tracks"):
        wg.calibrate(path, out=tmp_path / "o")


@pytest.mark.slow
def test_a_filmed_block_with_a_cap_tells_its_friction(tmp_path):
    """Film, tracks, friction; four caps that lie on the incline tell the camera's tilt.

    Without them one marker that blurs tells too little of it: 0.315 in place of 0.320.
    """
    hidden = 0.32
    corners = [(x, y, 0.1) for x in (-60.0, 60.0) for y in (-40.0, 40.0)]

    def ways(time):
        return np.array([(-60.0 + 0.5 * gain(hidden) * time**2, 5.0, 0.3), *corners])

    camera = films.Camera(tilt=0.1, roll=0.4)
    shot = films.Shot(camera, films.Light(exposures=3), fps=120.0)
    path = films.film(tmp_path / "slide.mp4", ways, 45, shot)
    wg.track(path, markers="aruco", marker_mm="7.2+-0.05", fps=120.0, out=tmp_path / "t")
    found = slide_film.friction(tmp_path / "t" / "track" / "tracks.csv", ANGLE, 0.1)
    assert found.value == pytest.approx(hidden, abs=0.002)
    assert 0.001 < found.se < 0.004
