"""Speeds of films in place of numbers: `fit` sees what `analyse` says of the same tracks."""

import math

import numpy as np
import pytest
from command_checks import rows_of
from synthetic_tracks import Walker, film
from typer.testing import CliRunner

import walkergen as wg
from walkergen.analysis import speeds
from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.tables import csv_text
from walkergen.guests.track.film import report

SCALE, SHARE = 0.2, 0.01
PLATE = 95.0
"""Peak speed of the plate where neither file says, mm/s."""


def write(path, seed, particles, walker=Walker(speed=60.0), share=SHARE, seconds=8.0):  # noqa: B008
    """Tracks as `track` writes them, of walkers numbered from 0 on."""
    filmed = film(seed, walker=walker, particles=particles, seconds=seconds, interval=0.02)
    scale = (SCALE, SHARE * SCALE if share else "")
    rows = [
        (frame, one.particle, *place, heading, frame * filmed.interval, *place, heading, *scale)
        for one in filmed.tracks
        for frame, (place, heading) in enumerate(zip(one.position, one.heading, strict=True))
        if not np.isnan(heading)
    ]
    path.write_text(csv_text(report.COLUMNS, rows))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("films")
    write(folder / "five.csv", 5, 3)
    write(folder / "ten.csv", 6, 4, Walker(speed=90.0))
    return folder


def read(folder, text):
    (folder / "speeds.csv").write_text(text)
    return speeds.read_speeds(folder / "speeds.csv", "flexible", PLATE)


def of_analyse(path):
    """Speeds and errors of each walker as the command `analyse` writes them."""
    CliRunner().invoke(command_line, ["analyse", str(path), "--no-pictures", "--out", str(path.parent / "a")])
    rows = rows_of(path.parent / "a" / "analysis" / "walkers.csv")
    return np.array([(float(row["speed_mm_s"]), float(row["speed_se_mm_s"])) for row in rows]).T


def test_speeds_are_those_of_analyse_with_the_scale_s_error_once_in_their_mean(folder):
    seen = read(folder, "tilt_deg,tracks\n10,ten.csv\n")
    value, se = of_analyse(folder / "ten.csv")
    assert seen.speed == pytest.approx(value, rel=1e-12)
    assert seen.tilt.tolist() == [10.0] * 4
    assert seen.plate_speed.tolist() == [PLATE] * 4
    of_scale = np.sqrt(seen.se**2 - se**2) / value
    assert of_scale == pytest.approx(np.full(4, math.sqrt(4) * SHARE), rel=1e-9)
    # their mean: 1 % of the scale, beside what their own errors leave
    error = math.sqrt((seen.se**2).sum()) / 4
    own = math.sqrt((se**2).sum()) / 4
    rms = math.sqrt(np.mean(value**2))
    assert math.sqrt(error**2 - own**2) == pytest.approx(SHARE * rms, rel=1e-9)


def test_a_row_may_name_one_walker_and_others_have_numbers(folder):
    """Two tilts in one film, by the numbers of their markers, beside a speed that was timed."""
    seen = read(
        folder,
        "tilt_deg,speed_mm_s,speed_se_mm_s,tracks,particle,legs,plate_speed_mm_s\n"
        "5,,,five.csv,0,,80\n10,77,2,,,flexible,\n0,,,five.csv,2,braced,\n",
    )
    value, _ = of_analyse(folder / "five.csv")
    assert seen.tilt.tolist() == [10.0, 5.0, 0.0]
    assert seen.speed == pytest.approx([77.0, value[0], value[2]], rel=1e-12)
    assert seen.legs == ["flexible", "flexible", "braced"]
    assert seen.plate_speed.tolist() == [PLATE, 80.0, PLATE]
    assert seen.se[0] == 2.0
    assert "five.csv: speeds of 2 walkers" in seen.notes[0]
    assert any("the scale is off by 1 %" in note for note in seen.notes)


def test_a_film_of_unknown_scale_and_one_too_short_say_so(folder):
    write(folder / "vague.csv", 7, 2, share=None)
    write(folder / "brief.csv", 8, 2, seconds=0.1)
    seen = read(folder, "tilt_deg,tracks\n5,vague.csv\n10,brief.csv\n")
    assert len(seen.speed) == 2
    assert any("the scale's error is unknown" in note for note in seen.notes)
    assert "line 3: brief.csv: no walker has a speed" in seen.bad


def test_walkers_seen_too_briefly_for_errors_of_their_own_count_by_their_mean(folder):
    """As `analyse` prints it, with the error of the scale once; one walker of them is left out."""
    path = write(folder / "short.csv", 11, 4, seconds=1.0)
    whole = wg.analyse(path)
    assert whole.motion.walkers[0].mean("speed").se is None
    seen = read(folder, "tilt_deg,tracks\n10,short.csv\n")
    assert seen.speed == pytest.approx([whole.speed.value], rel=1e-12)
    error = math.hypot(whole.speed.se, SHARE * whole.speed.value)
    assert seen.se == pytest.approx([error], rel=1e-12)
    assert "short.csv: the mean speed of 4 walkers, one row" in seen.notes[0]
    seen = read(folder, "tilt_deg,tracks,particle\n10,ten.csv,\n5,short.csv,0\n")
    assert "short.csv: no walker has a speed" in seen.bad
    with pytest.raises(InputError, match=r"walker 2 of short.csv is in two rows"):
        read(folder, "tilt_deg,tracks,particle\n10,short.csv,\n5,short.csv,2\n")


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("tilt_deg,tracks,speed_mm_s\n5,five.csv,60\n", r":2: both speed_mm_s and tracks"),
        ("tilt_deg,tracks,particle\n5,five.csv,7\n", r":2: particle = 7: .* five.csv: 0, 1, 2"),
        ("tilt_deg,tracks\n5,five.csv\n10,five.csv\n", r"walker 0 of five.csv is in two rows"),
        ("tilt_deg,tracks\n5,\n", r"neither speed_mm_s nor tracks"),
    ],
)
def test_rows_that_make_no_sense_are_one_line(folder, text, hint):
    with pytest.raises(InputError, match=f"(?i){hint}") as caught:
        read(folder, text)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.slow
def test_fit_learns_from_films_as_from_the_numbers_they_give(folder, tmp_path):
    """The same speeds and errors, by tracks and by numbers: the same posterior."""
    seen = read(folder, "tilt_deg,tracks\n5,five.csv\n10,ten.csv\n")
    rows = zip(seen.tilt, seen.speed, seen.se, strict=True)
    numbers = folder / "numbers.csv"
    numbers.write_text(csv_text(("tilt_deg", "speed_mm_s", "speed_se_mm_s"), rows))
    scene = "plane-90hz"
    films, typed = (
        wg.fit(path, scene=scene, out=tmp_path / path.stem, pictures=False, predict=[8])
        for path in (folder / "speeds.csv", numbers)
    )
    assert films.bands.rows == typed.bands.rows
    assert "five.csv: speeds of 3 walkers, a row each" in films.notes
    measured = (tmp_path / "speeds" / "fit" / "speeds.csv").read_text().splitlines()
    assert len(measured) == 1 + 7
