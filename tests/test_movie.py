"""Movies: what is drawn is what was simulated and what is printed."""

import json
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import manifold3d
import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.errors import InputError, WalkergenError
from walkergen.files import animation, templates
from walkergen.jobs.run.movie import bounce, footage, impacts, race
from walkergen.jobs.run.movie import make as movie
from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import Outcome, RunResult
from walkergen.walker import solids
from walkergen.walker.design import Design

PAPER = templates.load("koumakis2016", "walkers", Design)
LANE = templates.load("lane-90hz", "scenes", Scene)
SCENE = LANE.model_copy(update={"legs": LANE.legs.model_copy(update={"model": "compliant"})})
WITHOUT_FFMPEG = shutil.which("ffmpeg") is None and os.environ.get("CI") != "true"


def silent(what, done, total):
    pass


def with_foot(foot, kind="flexible", tilt_deg=10.0):
    legs = PAPER.legs.model_copy(update={"foot": foot, "kind": kind, "tilt_deg": tilt_deg})
    return PAPER.model_copy(update={"legs": legs})


@cache
def filmed():
    """Two periods of the compliant walker, 40 frames a period."""
    job = movie.plan([PAPER], SCENE, periods=2, slow=180, fps=20)
    return job, movie.film(job, PAPER, movie.FINE)


def still(design, model, pitch):
    """Footage of one pose: at rest, the lower foot 0.1 mm over the plate."""
    legs = SCENE.legs.model_copy(update={"model": model})
    mass = solids.mass_of(design)
    plan = prepare(SCENE.model_copy(update={"legs": legs}), design, mass)
    state = plan.start(0.1, pitch, 1.0)
    tally = record.new(len(state), 0.0, 1.0, 1)
    tally.samples.rows[0, 1:], tally.samples.cursor[0] = state, 1
    run = RunResult(0, Outcome.OK, 0.0, 0.0, 0.0, np.zeros(0), 0.0, tally, 0.0, np.zeros((1, 3)))
    return movie.footage_of(design, mass, plan, run)


@pytest.mark.parametrize(
    ("kind", "model"), [("flexible", "compliant"), ("flexible", "relaxed"), ("flexible", "rigid"), ("braced", "rigid")]
)
@pytest.mark.parametrize("foot", ["flat", "square", "round"])
@pytest.mark.parametrize("pitch", [0.02, -0.02])
def test_poses_put_the_foot_where_each_model_has_it(kind, model, foot, pitch):
    shot = still(with_foot(foot, kind), model, pitch)
    gaps = footage.feet(shot)[0, :, 1] - shot.plate[0]
    assert gaps.min() == pytest.approx(0.1, abs=1e-12)
    assert np.argmin(gaps) == (footage.BACK if pitch > 0 else footage.FRONT)


@pytest.mark.parametrize("kind", ["flexible", "braced"])
@pytest.mark.parametrize("foot", ["flat", "square", "round"])
def test_the_outline_drawn_is_that_of_the_printed_mesh(kind, foot):
    design = with_foot(foot, kind, 20.0)
    shot = still(design, "rigid" if kind == "braced" else "compliant", 0.0)
    limbs, body = footage.polygons(shot, 0)
    middle = body.mean(axis=0)  # the design's origin
    drawn = manifold3d.CrossSection([shape - middle for shape in (*limbs, body)], manifold3d.FillRule.Positive)
    mesh = solids.build(design).walker
    corners = mesh.vertices[mesh.triangles]
    side = corners[(corners[:, :, 2] > 0.5 * design.size.depth).all(axis=1)][:, :, :2]
    printed = manifold3d.CrossSection(list(side), manifold3d.FillRule.Positive)
    # Booleans of cross-sections snap to a grid of 1e-8 mm; the outline is some 100 mm long.
    assert (drawn - printed).area() + (printed - drawn).area() < 1e-5
    assert drawn.area() == pytest.approx(printed.area(), rel=1e-6)


def test_bent_legs_stay_hinged_at_the_body():
    _, shot = filmed()
    assert np.abs(shot.angles).max() > 1e-4
    bent = shot._replace(angles=shot.angles + 0.3)
    for side in (footage.BACK, footage.FRONT):
        anchor = complex(*shot.shape.anchors[side]) * np.exp(1j * shot.pitch[0])
        hinge = shot.places[0] + (anchor.real, anchor.imag)
        one, other = (footage.polygons(run, 0)[0][side] for run in (shot, bent))
        distances = [np.hypot(*(leg - hinge).T) for leg in (one, other)]
        assert distances[0] == pytest.approx(distances[1], abs=1e-12)
        assert np.abs(one - other).max() > 1.0


def test_feet_touch_the_plate_at_their_impacts_and_never_enter_it():
    job, shot = filmed()
    gaps = footage.feet(shot)[:, :, 1] - shot.plate[:, None]
    assert gaps.min() > -1e-9  # an open foot has landed below a gap of 1e-9 mm
    interval = 1.0 / (job.fps * job.slow * movie.FINE)
    assert len(shot.impacts) > 5
    for hit in shot.impacts:
        nearest = round(hit.time / interval)
        # Feet and plate close at less than 200 mm/s, for half an interval at most.
        assert gaps[nearest, hit.foot] < 200.0 * 0.5 * interval


def test_a_frame_flashes_the_impacts_of_its_afterglow_and_no_others():
    _, shot = filmed()
    glow = 1e-3
    for at in range(0, len(shot.times), movie.FINE):
        time = shot.times[at]
        for side in (footage.BACK, footage.FRONT):
            recent = [hit for hit in shot.impacts if hit.foot == side and 0 <= time - hit.time < glow]
            shown = footage.strongest(shot, time, glow, side)
            assert (shown is not None) == bool(recent)
            if shown is not None:
                assert shown[0] in recent
                assert 0.0 < shown[1] <= 1.0


def coloured(frame, colour):
    """Pixels of the main view that are close to a colour."""
    left, bottom, width, height = (int(value) for value in bounce.MAIN)
    top = impacts.HEIGHT - bottom - height
    view = frame[top : top + height, left : left + width].astype(int)
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(view - wanted).max(axis=-1) < 8).sum())


def test_the_flash_is_in_the_picture_from_the_impact_on():
    job, shot = filmed()
    draw = bounce.draw_bounce(shot, movie.FINE, job.slow, "settings")
    first = shot.impacts[0]
    colour = impacts.style_of(first.kind).colour
    frame = int(np.ceil(first.time * job.fps * job.slow))
    assert coloured(draw(frame - 1), colour) == 0
    assert coloured(draw(frame), colour) > 100


def test_the_main_view_magnifies_the_bending_of_legs_and_says_so():
    job, shot = filmed()
    bend = bounce._bend(shot)
    largest = np.abs(shot.angles).max()
    assert bend in bounce.BENDS
    assert 0.3 * bounce.MOST_BENT < bend * largest <= bounce.MOST_BENT
    at = int(np.abs(shot.angles[:, 1]).argmax())
    (plain, body), (bent, same) = footage.polygons(shot, at), footage.polygons(shot, at, bend)
    assert np.array_equal(body, same)
    hinge = shot.places[at] + footage._turned(shot.shape.anchors[1], shot.pitch[at])
    turned = [complex(*(leg.mean(axis=0) - hinge)) for leg in (plain[1], bent[1])]
    wanted = (bend - 1) * shot.angles[at, 1]
    assert np.angle(turned[1] / turned[0]) == pytest.approx(wanted, rel=1e-9)
    told = f"legs' bending × {bend:g} (outlined: as it is), all else to scale"
    assert any(told in words for words in written(shot, job))
    stiff = shot._replace(angles=0.0 * shot.angles)
    assert bounce._bend(stiff) == 1
    assert not any("bending" in words for words in written(stiff, job))


def written(shot, job):
    """Words that the slow film writes."""
    canvases = []
    make = impacts.Canvas

    def kept(*size):
        canvases.append(make(*size))
        return canvases[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(impacts, "Canvas", kept)
        bounce.draw_bounce(shot, movie.FINE, job.slow, "settings")
    return [text.get_text() for text in canvases[0].figure.texts]


def test_a_run_of_many_body_lengths_is_followed():
    job, shot = filmed()
    far = shot._replace(places=shot.places + np.outer(np.linspace(0, 1e4, len(shot.times)), (1, 0)))
    draw = bounce.draw_bounce(far, movie.FINE, job.slow, "settings")
    first, last = (coloured(draw(frame), "#A9C7E4") for frame in (0, job.frames - 1))
    assert first > 10_000
    assert last == pytest.approx(first, rel=0.05)  # the body is as large and as much in the picture


def test_drawing_a_frame_does_not_depend_on_those_before():
    job, shot = filmed()
    draw = bounce.draw_bounce(shot, movie.FINE, job.slow, "settings")
    frame = draw(30).copy()
    draw(3)
    assert np.array_equal(draw(30), frame)


@pytest.fixture
def short():
    return movie.plan([PAPER], SCENE, periods=0.5, slow=180, fps=10)


@pytest.mark.slow
def test_a_gif_has_its_frames_size_and_time_and_equal_bytes(short, tmp_path):
    one = movie.make(short, tmp_path / "a.gif", silent)
    two = movie.make(short, tmp_path / "b.gif", silent)
    assert one.gif.read_bytes() == two.gif.read_bytes()
    assert one.frames == short.frames == 11
    with Image.open(one.gif) as image:
        assert image.size == (impacts.WIDTH, impacts.HEIGHT)
        assert image.n_frames == 11
        shown = []
        for at in range(image.n_frames):
            image.seek(at)
            shown.append(image.info["duration"])
    assert shown == [100] * 10 + [100 + 1000 * movie.HOLD_S]
    if one.mp4 is not None:
        assert two.mp4 is not None
        assert one.mp4.read_bytes() == two.mp4.read_bytes()


def test_a_race_shows_every_walker_in_its_lane(tmp_path):
    members = PAPER.members([5.0, 20.0], ["flexible"])
    lively = SCENE.variant(**{"contact.restitution": 0.8})
    job = movie.plan(members, lively, seconds=0.3, fps=10)
    made = movie.make(job, tmp_path / "race.gif", silent)
    assert (made.frames, job.slow) == (4, 1.0)
    runs = [shot.places[-1, 0] for shot in made.footage]
    assert runs[0] > runs[1] + 5.0  # 5 degrees run at 180 mm/s, 20 degrees at 20
    with Image.open(made.gif) as image:
        image.seek(3)
        frame = np.asarray(image.convert("RGB")).astype(int)
    body = np.abs(frame - (0xA9, 0xC7, 0xE4)).max(axis=-1) < 8
    lanes = np.split(body[64 : 64 + 2 * 66], 2)
    right = [int(np.nonzero(lane)[1].max()) for lane in lanes]
    scale = (right[0] - right[1]) / (runs[0] - runs[1])
    wide = [np.ptp(np.nonzero(lane)[1]) for lane in lanes]
    assert wide[0] == pytest.approx(28.0 * scale, abs=3)  # to scale: bodies are 28 mm long
    assert wide[0] == pytest.approx(wide[1], abs=2)
    # Words stand beside the lanes, walkers and plate in them.
    assert not body[:, : race.BESIDE].any()
    ink = (frame.sum(axis=-1) < 200)[64 : 64 + 2 * 66]
    assert ink[:, : race.BESIDE].sum() > 300


@pytest.mark.programs
@pytest.mark.skipif(WITHOUT_FFMPEG, reason="ffmpeg is not installed")
def test_an_mp4_has_the_frames_of_the_gif(short, tmp_path):
    made = movie.make(short, tmp_path / "a.gif", silent)
    assert made.mp4 is not None, made.without_mp4
    words = ["ffmpeg", "-loglevel", "error", "-i", str(made.mp4), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(words, capture_output=True, check=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, impacts.HEIGHT, impacts.WIDTH, 3)
    assert len(frames) == 11  # none stands still at the end, as in the GIF
    with Image.open(made.gif) as image:
        first = np.asarray(image.convert("RGB")).astype(int)
    # Chroma at half resolution and a palette of 128: alike, not equal.
    assert np.abs(frames[0].astype(int) - first).mean() < 4.0


def test_interrupted_nothing_is_left(monkeypatch, short, tmp_path):
    started = []
    popen = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", lambda *args, **more: started.append(popen(*args, **more)) or started[0])

    def stop(what, done, total):
        if what == "frames" and done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        movie.make(short, tmp_path / "out" / "a.gif", stop)
    assert not (tmp_path / "out").exists()
    assert all(process.poll() is not None for process in started)


@pytest.mark.parametrize(
    ("choice", "words"),
    [({"seconds": float("nan")}, "--seconds nan: must lie in"), ({"slow": float("inf")}, "--slow inf: must lie in")],
)
def test_what_cannot_be_filmed_is_refused(choice, words):
    with pytest.raises(InputError, match=words):
        movie.plan([PAPER], SCENE, **choice)


def test_too_many_lanes_are_refused():
    with pytest.raises(InputError, match="9 walkers in one movie; at most 8"):
        movie.plan([PAPER] * 9, SCENE)


def leaving(length_mm, discard_seconds):
    arena = SCENE.arena.model_copy(update={"length_mm": length_mm})
    run = SCENE.run.model_copy(update={"discard_seconds": discard_seconds})
    return SCENE.model_copy(update={"arena": arena, "run": run})


@pytest.mark.slow
def test_a_run_that_ends_early_is_shown_to_its_end(tmp_path):
    job = movie.plan([PAPER], leaving(4.0, 0.0), periods=16, slow=10, fps=20)
    made = movie.make(job, tmp_path / "a.gif", silent)
    (shot,) = made.footage
    assert shot.ended == "left the ground"
    assert 2 <= made.frames < job.frames


def test_a_run_that_ends_at_once_is_refused():
    job = movie.plan([PAPER], leaving(1e-3, 0.1), fps=10)
    with pytest.raises(InputError, match=r"10°, flexible: the run ended before .*left the ground"):
        movie.film(job, PAPER, movie.FINE)


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(command_line, ["movie", *words])


FEW = ("--periods", "0.2", "--slow", "100", "--fps", "20")


def test_the_command_says_what_it_filmed_and_wrote(run, tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "program", lambda: None)
    words = ("--scene", "lane-90hz", "--tilt", "10", "--model", "compliant", *FEW)
    result = run("koumakis2016", *words)
    assert result.exit_code == 0, result.output
    name = "out/koumakis2016/walker_t10.0_flexible_s0.40_lane-90hz_model-compliant.gif"
    assert "koumakis2016, 10°, flexible: " in result.stdout
    assert "\n5 frames, 20 a second, 100 times slower\n" in result.stdout
    assert f"no MP4: {animation.WITHOUT}\n{name}\n" in result.stdout
    found = (tmp_path / name).parent.glob("[!.]*")
    assert [path.name for path in found] == [Path(name).name]


def test_json_names_the_files_and_the_runs(run):
    words = ("--tilt", "5,10", "--model", "compliant", "--seconds", "0.1", "--slow", "0.5")
    found = json.loads(run(*words, "--fps", "50", "--json").stdout)
    assert found["gif"] == "out/koumakis2016/race_t05.0-t10.0_flexible_lane-90hz_model-compliant.gif"
    assert (found["frames"], found["slow"]) == (3, 0.5)
    assert [walker["model"] for walker in found["walkers"]] == ["compliant", "compliant"]
    assert (found["mp4"] is None) == bool(found["without_mp4"])
    assert all(Path(found[form]).is_file() for form in ("gif", "mp4") if found[form])


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--out", "walker.mp4"), "must end in .gif"),
        (("--tilt", "95"), "95 must lie in"),
        (("--legs", "braced", "--model", "compliant"), "braced legs are rigid"),
        (("--out", "/dev/null/a.gif", *FEW), "cannot be written"),
    ],
)
def test_bad_requests_are_one_line(run, words, told):
    result = run(*words)
    assert isinstance(result.exception, WalkergenError)
    assert told in str(result.exception)
    assert "\n" not in str(result.exception)
