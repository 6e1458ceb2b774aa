"""Movies: what is drawn is what was simulated and what is printed."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import animation, templates
from walkergen.guests.movie import film, impacts
from walkergen.guests.movie import make as movie
from walkergen.guests.movie.request import MovieRequest

PAPER = templates.load("koumakis2016", "walkers", Design)
LANE = templates.load("lane-90hz", "scenes", Scene)
WITHOUT_FFMPEG = shutil.which("ffmpeg") is None and os.environ.get("CI") != "true"


def silent(what, done, total):
    pass


def film_of(members, scene, **choices):
    return film.plan_film(MovieRequest(**choices), members, scene)


@pytest.fixture
def short():
    return film_of([PAPER], LANE, periods=0.5, slow=180, fps=10)


@pytest.mark.slow
def test_a_gif_has_its_frames_size_and_time_and_equal_bytes(short, tmp_path):
    one = movie.make_movie(short, tmp_path / "a.gif", silent)
    two = movie.make_movie(short, tmp_path / "b.gif", silent)
    assert one.gif.read_bytes() == two.gif.read_bytes()
    assert one.frames == short.frames == 11
    with Image.open(one.gif) as image:
        assert image.size == (impacts.WIDTH_PX, impacts.HEIGHT_PX)
        assert image.n_frames == 11
        shown = []
        for at in range(image.n_frames):
            image.seek(at)
            shown.append(image.info["duration"])
    assert shown == [100] * 10 + [100 + 1000 * movie.HOLD_S]
    if one.mp4 is not None:
        assert two.mp4 is not None
        assert one.mp4.read_bytes() == two.mp4.read_bytes()


@pytest.mark.programs
@pytest.mark.skipif(WITHOUT_FFMPEG, reason="ffmpeg is not installed")
def test_an_mp4_has_the_frames_of_the_gif(short, tmp_path):
    made = movie.make_movie(short, tmp_path / "a.gif", silent)
    assert made.mp4 is not None, made.without_mp4
    words = ["ffmpeg", "-loglevel", "error", "-i", str(made.mp4), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(words, capture_output=True, check=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, impacts.HEIGHT_PX, impacts.WIDTH_PX, 3)
    assert len(frames) == 11  # none stands still at the end, as in the GIF
    with Image.open(made.gif) as image:
        first = np.asarray(image.convert("RGB")).astype(int)
    # Chroma at half resolution and a palette of 128: alike, not equal; 4.0 measured, by thin lines and letters.
    assert np.abs(frames[0].astype(int) - first).mean() < 6.0


def test_interrupted_nothing_is_left(monkeypatch, short, tmp_path):
    started = []
    popen = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", lambda *args, **more: started.append(popen(*args, **more)) or started[0])

    def stop(what, done, total):
        if what == "frames" and done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        movie.make_movie(short, tmp_path / "out" / "a.gif", stop)
    assert not (tmp_path / "out").exists()
    assert all(process.poll() is not None for process in started)


def leaving(length_mm, discard_seconds):
    arena = LANE.arena.model_copy(update={"length_mm": length_mm})
    run = LANE.run.model_copy(update={"discard_seconds": discard_seconds})
    return LANE.model_copy(update={"arena": arena, "run": run})


@pytest.mark.slow
def test_a_run_that_ends_early_is_shown_to_its_end(tmp_path):
    job = film_of([PAPER], leaving(4.0, 0.0), periods=16, slow=10, fps=20)
    made = movie.make_movie(job, tmp_path / "a.gif", silent)
    (shot,) = made.shots
    assert shot.end_reason == "left the ground"
    assert 2 <= made.frames < job.frames


def test_a_run_that_ends_at_once_is_refused():
    job = film_of([PAPER], leaving(1e-3, 0.1), fps=10)
    with pytest.raises(InputError, match=r"10°, flexible: the run ended before .*left the ground"):
        movie.simulate_shot(job, PAPER, movie.SLOW_POSES_PER_FRAME)


COMMAND = ("movie",)


FEW = ("--periods", "0.2", "--slow", "100", "--fps", "20")


def test_the_command_says_what_it_filmed_and_wrote(run, tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "find_ffmpeg", lambda: None)
    words = ("--scene", "lane-90hz", "--tilt", "10", *FEW)
    result = run("koumakis2016", *words)
    assert result.exit_code == 0, result.output
    name = "out/koumakis2016/walker_t10.0_flexible_s0.40_lane-90hz_perspective.gif"
    assert "koumakis2016, 10°, flexible: " in result.stdout
    assert "\n5 frames, 20 a second, 100 times slower\n" in result.stdout
    assert f"no MP4: {animation.NO_FFMPEG_REASON}\n{name}\n" in result.stdout
    found = (tmp_path / name).parent.glob("[!.]*")
    assert [path.name for path in found] == [Path(name).name]


def test_json_names_the_files_and_the_runs(run):
    words = ("--tilt", "5,10", "--seconds", "0.1", "--slow", "0.5")
    found = json.loads(run(*words, "--fps", "50", "--json").stdout)
    assert found["gif"] == "out/koumakis2016/race_t05.0-t10.0_flexible_lane-90hz.gif"
    assert (found["frames"], found["slow"]) == (3, 0.5)
    assert len(found["walkers"]) == 2
    assert (found["mp4"] is None) == bool(found["without_mp4"])
    assert all(Path(found[form]).is_file() for form in ("gif", "mp4") if found[form])
