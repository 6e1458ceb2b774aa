"""Tracks as spreadsheets and cameras leave them: code pages, times of day, lost and repeated frames."""

import numpy as np
import pytest

import walkergen as wg
from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.core.errors import InputError

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


SPEED, SECONDS, FPS = 60.0, 20.0, 30


def film_rows(seed=2, walkers=3, speeds=(SPEED,) * 4):
    """Rows of time (s), x, y (mm) and walker, by frame, of walkers that turn at random, filmed with noise."""
    rng, rows = np.random.default_rng(seed), []
    for walker in range(walkers):
        heading = rng.uniform(-np.pi, np.pi) + np.cumsum(0.1 * rng.normal(size=round(SECONDS * FPS)))
        steps = speeds[walker] / FPS * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        places = 100.0 * (walker + 1) + np.cumsum(steps, axis=0) + 0.05 * rng.normal(size=steps.shape)
        rows.append(np.column_stack([np.arange(len(places)) / FPS, places, np.full(len(places), walker)]))
    return np.stack(rows, axis=1)


def measure(tmp_path, rows):
    lines = (f"{t:.6f},{x:.5f},{y:.5f},{walker:.0f}\n" for t, x, y, walker in rows.reshape(-1, 4) if not np.isnan(t))
    (tmp_path / "tracks.csv").write_text("t_s,x_mm,y_mm,particle\n" + "".join(lines))
    return wg.analyse(tmp_path / "tracks.csv")


def speed_holds(report):
    low, high = report.speed.interval()
    return low - 0.05 < SPEED < high + 0.05 and high - low < 1.0


@pytest.mark.parametrize("place", [(0.0, 0.0), (-1.0, -1.0)])
def test_lost_walkers_stored_at_one_place_are_counted_and_left_out(tmp_path, place):
    rows = film_rows()
    lost = np.random.default_rng(1).random(rows.shape[:2]) < 0.05
    rows[lost, 1:3] = place
    report = measure(tmp_path, rows)
    assert any(f"{lost.sum()} places at" in note for note in report.notes)
    assert speed_holds(report)


def test_a_walker_that_passes_the_origin_is_not_lost_there(tmp_path):
    rows = film_rows(walkers=1)
    rows[..., 1:3] -= rows[300, :, 1:3]
    assert not any("lost frames" in note for note in measure(tmp_path, rows).notes)


def test_frames_that_repeat_the_one_before_are_counted(tmp_path):
    """Left out if the camera went on meanwhile: walkers then catch up. Else only named: the time is unknown."""
    rows = film_rows()
    at = np.arange(7, len(rows), 20)
    rows[at, :, 1:3] = rows[at - 1, :, 1:3]
    report = measure(tmp_path, rows)
    assert f"{len(at)} of {len(rows)} frames repeat the one before, and walkers catch up" in "\n".join(report.notes)
    assert speed_holds(report)
    held = np.repeat(film_rows(), np.where(np.arange(len(rows)) % 20 == 7, 2, 1), axis=0)
    held[..., 0] = np.arange(len(held))[:, None] / FPS
    report = measure(tmp_path, held)
    assert "repeat the one before: if the film holds these twice, speeds are 4.8 %" in "\n".join(report.notes)


def test_irregular_times_are_counted_and_used(tmp_path):
    rows = film_rows()
    late = np.random.default_rng(3).uniform(-0.3, 0.3, len(rows))[:, None] / FPS
    ahead = np.diff(rows[..., 1:3], axis=0, append=rows[-1:, :, 1:3]) * FPS
    rows[..., 0] += late
    rows[..., 1:3] += ahead * late[..., None]
    report = measure(tmp_path, rows)
    (note,) = [note for note in report.notes if "times are irregular" in note]
    assert f"of {rows.shape[0] * rows.shape[1]} times" in note
    assert report.speed.value == pytest.approx(SPEED, abs=0.5)  # between frames noise is less


def test_a_walker_at_rest_is_named_and_counts_in_no_mean(tmp_path):
    report = measure(tmp_path, film_rows(walkers=4, speeds=(SPEED, SPEED, 0.0, SPEED)))
    assert speed_holds(report)
    assert any("1 of 4 walkers rest and are left out of all numbers: 2" in note for note in report.notes)
    assert report.facts["speed_walkers"] == "3 of 4 walkers"
    assert str(report.speed).endswith("; 3 of 4 walkers")
    assert "(3 of 4 walkers)" in report.markdown()
    (cell,) = [row[-1] for row in report.tables[0].rows if row[0] == "speed_mm_s"]
    assert cell == "3 of 4 walkers"
    assert "rests" in report.motion.walkers[2].mean("speed").refused


def test_a_mean_over_fewer_walkers_has_their_number_beside_it(tmp_path):
    rows = film_rows()
    rows[90:, 1] = np.nan
    report = measure(tmp_path, rows)
    assert report.facts["speed_walkers"] == "2 of 3 walkers"
    assert str(report.speed).endswith("; 2 of 3 walkers")
    assert "(2 of 3 walkers)" in report.markdown()
    rows[90:, 2] = np.nan
    assert "speed_walkers" not in measure(tmp_path, rows).facts  # without headings it is that of all steps
    assert "speed_walkers" not in measure(tmp_path, film_rows()).facts


@pytest.fixture
def animals(tmp_path):
    """A file of columns for each walker, as TRex writes them; the second is first seen 40 frames later."""
    rows = film_rows(seed=4)
    for walker, first in ((0, 0), (1, 40), (2, 0)):
        frames = np.arange(first, len(rows))
        x, y = rows[first:, walker, 1:3].T
        np.savez(tmp_path / f"film_fish{walker}.npz", frame=frames, x_mm=x, y_mm=y)
    return rows


def test_files_of_single_walkers_are_one_recording(run, tmp_path, animals):
    """As one table of all walkers: the same numbers. The shell may not expand a pattern."""
    whole = animals.copy()
    whole[:40, 1] = np.nan
    together = measure(tmp_path, whole)
    apart = wg.analyse(tmp_path / "film_fish*.npz", fps=FPS)
    assert apart.speed.pair == pytest.approx(together.speed.pair, rel=1e-4)
    assert [track.start for track in track_files.read_recording(sorted(tmp_path.glob("*.npz")), Units(FPS)).tracks] == [
        *(0, 40, 0)
    ]
    assert "3 files are taken as one recording with the same clock" in apart.notes[-1]
    assert [walker["name"] for walker in apart.facts["walkers"]] == [f"film_fish{n}" for n in range(3)]
    names = [str(tmp_path / f"film_fish{n}.npz") for n in range(3)]
    shown = run("analyse", *names, "--fps", "30", "--no-pictures", "--out", str(tmp_path / "out"))
    assert shown.exit_code == 0
    assert "film_fish2" in shown.stdout
    listed = wg.analyse(names, fps=FPS)
    assert listed.speed == apart.speed
    crowd = wg.analyse(names, fps=FPS, dish="disc:90000")
    assert crowd.facts["walkers"] == 3
    for name, step in (("slow", 0.05), ("fast", 0.03)):
        rows = "".join(f"{step * frame:g},{frame},1\n" for frame in range(9))
        (tmp_path / f"{name}.csv").write_text("t_s,x_mm,y_mm\n" + rows)
    with pytest.raises(InputError, match="files of one recording need one frame rate"):
        wg.analyse([tmp_path / "slow.csv", tmp_path / "fast.csv"])
