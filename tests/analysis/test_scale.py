"""The error of a film's scale goes with the tracks into every number that has a length."""

import json

import numpy as np
import pytest
from command_checks import rows_of
from synthetic_tracks import film
from typer.testing import CliRunner

import walkergen as wg
from walkergen.analysis.estimates import UNITS
from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.tables import csv_text
from walkergen.film_fields import parse_measured
from walkergen.guests.track.film import report

SCALE, ERROR = 0.2, 0.01


@pytest.fixture(scope="module")
def rows():
    """Rows of frame, particle, x, y (mm), heading and time of walkers of which all is known."""
    filmed = film(5, particles=12, seconds=6.0, interval=0.02)
    return [
        (frame, one.particle, *place, heading, frame * filmed.interval)
        for one in filmed.tracks
        for frame, (place, heading) in enumerate(zip(one.position, one.heading, strict=True))
        if not np.isnan(heading)
    ]


def ours(rows, *scale):
    """Columns of tracks.csv with a scale and its error."""
    return csv_text(report.COLUMNS, [(*row, *row[2:5], *scale) for row in rows])


def trackpys(rows, _scale):
    """Columns of trackpy, in pixels."""
    lines = [(frame, name, x / SCALE, y / SCALE, theta) for frame, name, x, y, theta, _ in rows]
    return csv_text(("frame", "particle", "x", "y", "theta"), lines)


WAYS = [
    (lambda rows: ours(rows, SCALE, ERROR), ()),
    (lambda rows: trackpys(rows, SCALE), ("--fps", "50", "--mm-per-px", f"{SCALE}±{ERROR}")),
    (lambda rows: trackpys(rows, SCALE), ("--fps", "50", "--mm-per-px", f"{SCALE}+-{ERROR}")),
]


@pytest.mark.parametrize(("text", "words"), WAYS, ids=["columns", "sign", "ascii"])
def test_every_number_with_a_length_bears_the_scales_error(tmp_path, rows, text, words):
    """Against the analysis of the same tracks, whose scale is larger by its error."""
    path, larger = tmp_path / "tracks.csv", tmp_path / "larger.csv"
    path.write_text(text(rows))
    words = ("analyse", str(path), *words, "--no-pictures", "--out", str(tmp_path))
    told = CliRunner().invoke(command_line, words)
    assert "(scale)" in told.stdout
    data = json.loads(CliRunner().invoke(command_line, [*words, "--json"]).stdout)
    grown = 1.0 + ERROR / SCALE
    larger.write_text(ours([(*row[:2], row[2] * grown, row[3] * grown, *row[4:]) for row in rows]))
    found = wg.analyse(larger)
    assert data["scale_se_share"] == pytest.approx(ERROR / SCALE)
    moved = 0
    for name, unit in UNITS.items():
        value, scale = data[f"{name}_{unit}"], data[f"{name}_scale_se_{unit}"]
        if value is not None:
            # To first order: a square grows by twice the share, and the square of it.
            apart = abs(found.estimates[name].value - value)
            assert scale == pytest.approx(apart, rel=0.06, abs=1e-9 + 1e-3 * abs(value)), name
            moved += scale > 0
    assert moved >= 8
    speed = rows_of(tmp_path / "analysis" / "analysis.csv")[0]
    assert float(speed["scale_se"]) == pytest.approx(float(speed["value"]) * ERROR / SCALE)


def test_a_scale_without_an_error_says_so_and_a_simulation_needs_none(tmp_path, rows):
    path = tmp_path / "tracks.csv"
    path.write_text(ours(rows, SCALE, ""))
    unknown = wg.analyse(path)
    assert unknown.motion.scale_se is None
    assert "scale's error is unknown" in " ".join(unknown.notes)
    path.write_text(csv_text(report.COLUMNS[:9], [(*row, *row[2:5]) for row in rows]))
    exact = wg.analyse(path)
    assert exact.motion.scale_se == 0.0
    assert "scale" not in " ".join(exact.notes)


def test_the_speed_over_the_plates_bears_it_too(tmp_path):
    names = ("particle", "t_s", "x_mm", "plate_speed_mm_s", *report.COLUMNS[-2:])
    rng = np.random.default_rng(1)
    lines = [
        (8 * plate + n, 0.02 * k, 0.02 * k * plate + rng.normal(0, 0.1), plate, SCALE, ERROR)
        for plate in (10, 20, 30)
        for n in range(8)
        for k in range(200)
    ]
    (tmp_path / "t.csv").write_text(csv_text(names, lines))
    words = ("analyse", str(tmp_path / "t.csv"), "--no-pictures", "--out", str(tmp_path))
    told = CliRunner().invoke(command_line, words).stdout
    assert "± 0.05 by the scale" in told
    assert told.count("(scale)") == 3


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (0.05, (0.05, None)),
        ("0.05±0.001", (0.05, 0.001)),
        ("28 +- 0.1", (28.0, 0.1)),
        ("28+/-.1", (28.0, 0.1)),
        ("5e-2±1e-3", (0.05, 0.001)),
        (None, None),
    ],
)
def test_measured_numbers_are_read(text, expected):
    assert parse_measured(text) == expected


@pytest.mark.parametrize("text", ["", "0", "-1", "nan", "1±2", "1±-0.1", "1±x", "1±.1±.1", "±1"])
def test_what_is_no_measured_number_is_refused(text):
    with pytest.raises(ValueError, match="must be a number above 0"):
        parse_measured(text)


def test_a_scale_that_cannot_be_is_refused(tmp_path, rows):
    (tmp_path / "t.csv").write_text(ours(rows, -0.2, 0.01))
    with pytest.raises(InputError, match="mm_per_px must be > 0"):
        wg.analyse(tmp_path / "t.csv")
