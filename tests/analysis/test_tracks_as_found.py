"""Tracks as spreadsheets and cameras leave them: code pages, times of day, lost and repeated frames."""

import numpy as np
import pytest

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units

STEP_MM, INTERVAL_S = 2.4, 0.04


def read(tmp_path, text, units=Units(), encoding="utf-8"):  # noqa: B008
    path = tmp_path / "tracks.csv"
    path.write_bytes(text.encode(encoding))
    return track_files.read_tracks(path, units)


def test_units_may_be_in_code_page_1252(tmp_path):
    rows = "".join(f"{frame},{1e3 * STEP_MM * frame},0,0\n" for frame in range(9))
    found = read(tmp_path, "frame,x [µm],y [µm],particle\n" + rows, Units(fps=25.0), "cp1252")
    np.testing.assert_allclose(found.tracks[0].position[:, 0], STEP_MM * np.arange(9))


@pytest.mark.parametrize(
    ("name", "mark", "format_time"),
    [
        ("t", ",", lambda s: f"00:00:{s:06.3f}"),
        ("time", ",", lambda s: f'"0:{s:05.2f}"'),
        ("Time (h:m:s)", ";", lambda s: f"23:59:{s:06.3f}"),
        ("time_ms", "\t", lambda s: f"2024-02-29 12:00:{s:06.3f}"),
    ],
)
def test_times_of_day_are_seconds(tmp_path, name, mark, format_time):
    """A unit in the name cannot be that of a time of day."""
    rows = [(format_time(INTERVAL_S * frame), f"{STEP_MM * frame}", "1.5") for frame in range(9)]
    found = read(tmp_path, "\n".join(mark.join(row) for row in [(name, "x_mm", "y_mm"), *rows]))
    assert found.interval == pytest.approx(INTERVAL_S)
    np.testing.assert_allclose(found.tracks[0].position[:, 0], STEP_MM * np.arange(9))
