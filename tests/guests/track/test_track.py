"""Tracking of films: drawn walkers are found where they were drawn, and what fails says so."""

import csv
import json
import math

import numpy as np
import pytest
from PIL import Image
from rendered_films import write
from typer.testing import CliRunner

import walkergen as wg
from walkergen.analysis import motion, track_files, tracks
from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.progress import silent
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import figures, templates
from walkergen.guests.movie import film, top_view
from walkergen.guests.movie import make as movie
from walkergen.guests.movie.request import MovieRequest
from walkergen.guests.track.film import appearance, blob_tracking, blobs, films, heading, linking, make, report
from walkergen.guests.track.film import figures as film_figures
from walkergen.guests.track.film.blobs import Blob, Blobs
from walkergen.guests.track.film.linking import Track
from walkergen.guests.track.film.request import TrackRequest

HIGH, WIDE = 160, 240
FINE = 8
"""Points across a pixel at which a drawn walker's edge is sampled."""

LONG, ACROSS = 56.0, 16.0


def drawn(walkers, dark=True, spot=None, round_ones=False, noise=2.0, seed=0, size=(HIGH, WIDE)):
    """Grey frame with walkers (x, y from the lower left, heading), on an unevenly lit plate.

    `spot`: brightness of a mark at the front.
    """
    high, wide = size
    y, x = np.mgrid[:high, :wide] + 0.5
    ground, body = (190.0, 80.0) if dark else (60.0, 150.0)
    picture = ground * (1.0 - 0.25 * ((x - 0.6 * wide) ** 2 + (y - 0.3 * high) ** 2) / wide**2)
    reach = math.ceil(0.5 * math.hypot(LONG, ACROSS) + 2)
    for at_x, at_y, theta in walkers:
        left, top = math.floor(at_x) - reach, high - math.floor(at_y) - reach
        fine = (np.arange(2 * reach * FINE) + 0.5) / FINE
        u, v = left + fine - at_x, (high - (top + fine) - at_y)[:, None]
        along, side = u * np.cos(theta) + v * np.sin(theta), v * np.cos(theta) - u * np.sin(theta)
        if round_ones:
            inside, front = along**2 + side**2 < (0.5 * LONG) ** 2, 0.25 * LONG
        else:
            inside = (np.abs(along) < 0.5 * LONG) & (np.abs(side) < 0.5 * ACROSS)
            front = 0.32 * LONG
        seen = picture[top : top + 2 * reach, left : left + 2 * reach]
        spots = [] if spot is None else [((along - front) ** 2 + side**2 < 4.0**2, spot)]
        for where, bright in ((inside, body), *spots):
            rows = np.add.reduceat(where, np.arange(0, len(fine), FINE), axis=1, dtype=np.uint16)
            covered = rows.reshape(2 * reach, FINE, 2 * reach).sum(axis=1) / FINE**2
            seen += covered * (bright - seen)
    picture += np.random.default_rng(seed).normal(0, noise, picture.shape) if noise else 0.0
    return picture.clip(0, 255).round().astype(np.uint8)


def blobs_of(frame, marked=False, **known):
    seen = appearance.learn_appearance([frame], known.get("dark"), known.get("threshold"), known.get("width"))
    return blobs.find_blobs(frame, seen, marked), seen


def places(blobs):
    return np.array([(one.x + 0.5, HIGH - one.y - 0.5) for one in blobs])


@pytest.mark.parametrize("dark", [True, False], ids=["dark", "light"])
@pytest.mark.parametrize("theta", [0.0, 0.3, 1.1, 2.5])
def test_a_walker_is_found_where_it_was_drawn(dark, theta):
    truth = [(101.3, 93.7, theta), (181.9, 60.2, theta + 0.4)]
    blobs, seen = blobs_of(drawn(truth, dark))
    assert seen.dark == dark
    assert seen.width == pytest.approx(ACROSS, abs=1.5)
    found = places(blobs)
    order = np.argsort(found[:, 0])
    assert found[order] == pytest.approx(np.array(truth)[:, :2], abs=0.12)
    for at, (_, _, angle) in zip(order, truth, strict=True):
        turned = (blobs[at].axis - angle + 0.5 * math.pi) % math.pi - 0.5 * math.pi
        assert abs(turned) < math.radians(0.5)
        assert blobs[at].length == pytest.approx(LONG, abs=0.8)
        assert blobs[at].width == pytest.approx(ACROSS, abs=0.8)


def test_what_is_thin_is_no_walker_and_does_not_pull():
    frame = drawn([(101.3, 93.7, 0.3)], noise=0)
    plain, seen = blobs_of(frame)
    with_lines = frame.copy()
    with_lines[20:22, 10:200] = 30  # a wall
    with_lines[10:120, 10:12] = 30
    with_lines[65:67, 15:105] = 30  # a trail that ends in the walker
    with_lines[130:141, 30:230:20] = with_lines[130:141, 40:230:20] = 30  # letters
    for left in range(30, 220, 20):
        with_lines[[130, 140], left : left + 10] = 30
    (one,) = blobs.find_blobs(with_lines, seen, marked=False)
    assert (one.x, one.y) == pytest.approx((plain[0].x, plain[0].y), abs=0.25)
    assert one.axis == pytest.approx(plain[0].axis, abs=0.01)


def test_a_dark_table_around_the_plate_is_no_walker():
    frame = drawn([(120.0, 80.0, 1.0)])
    frame[:, :30] = frame[:, -30:] = frame[:25] = frame[-25:] = 20
    (one,), seen = blobs_of(frame)
    assert seen.dark
    assert (one.x + 0.5, HIGH - one.y - 0.5) == pytest.approx((120.0, 80.0), abs=0.2)


@pytest.mark.parametrize("spot", [20.0, 190.0], ids=["darker", "as bright as the ground"])
@pytest.mark.parametrize("round_ones", [True, False], ids=["round", "long"])
@pytest.mark.parametrize("theta", [0.2, 2.0, -1.3])
def test_a_mark_shows_the_front(spot, round_ones, theta):
    blobs, _ = blobs_of(drawn([(120.0, 80.0, theta)], True, spot, round_ones), marked=True)
    (one,) = blobs
    assert (one.x + 0.5, HIGH - one.y - 0.5) == pytest.approx((120.0, 80.0), abs=0.3)
    assert abs(np.angle(np.exp(1j * (one.mark - theta)))) < math.radians(3.0)


def test_without_a_mark_there_is_none():
    blobs, _ = blobs_of(drawn([(120.0, 80.0, 0.5)], noise=4.0), marked=True)
    assert math.isnan(blobs[0].mark)


def seen_of(x, y, axis, mark=None, frames=None, ratio=3.0):
    """A walker in frames, y up."""
    none = np.full(len(x), np.nan)
    blobs = Blobs(
        np.asarray(x),
        -np.asarray(y),
        np.full(len(x), 900.0),
        (np.asarray(axis) + 0.5 * np.pi) % np.pi - 0.5 * np.pi,
        np.full(len(x), 56.0),
        np.full(len(x), 56.0 / ratio),
        none if mark is None else np.angle(np.exp(1j * np.asarray(mark))),
        none,
        none,
    )
    return Track(np.arange(len(x)) if frames is None else np.asarray(frames), blobs)


TURN = np.linspace(0.0, 15.0, 120)


@pytest.mark.parametrize("by", heading.HEADING_SOURCES)
@pytest.mark.parametrize("ratio", [3.0, 1.0])
def test_headings_follow_a_walker_through_whole_turns(by, ratio):
    x, y = 40 * np.sin(TURN), -40 * np.cos(TURN)
    found = heading.find_headings(seen_of(x, y, TURN, TURN, ratio=ratio), by)
    if by == "motion" and ratio == 1.0:
        assert np.isnan(found.theta).all()
        assert "1.00 times as long as wide: mark the front" in found.how
    else:
        np.testing.assert_allclose(found.theta, TURN, atol=0.15)


def test_a_mark_is_believed_against_the_motion_and_outvotes_its_own_errors():
    x, mark = np.linspace(0, 100, 60), np.full(60, math.pi)  # it runs backward
    mark[[3, 17]] = 0.0
    mark[30:40] = np.nan
    walker = seen_of(x, 0 * x, 0 * x, mark)
    np.testing.assert_allclose(np.abs(heading.find_headings(walker, "mark").theta), math.pi)
    np.testing.assert_allclose(heading.find_headings(walker, "motion").theta, 0.0)


def test_a_walker_that_stays_has_no_front_and_says_so():
    x = 2.0 * np.random.default_rng(1).random(50)
    found = heading.find_headings(seen_of(x, 0 * x, 0 * x), "motion")
    assert np.isnan(found.theta).all()
    assert "ran less than 0.1 of its length" in found.how
    assert heading.find_headings(seen_of(x, 0 * x, 0 * x), "mark").how == "no mark was seen"


def test_a_lost_walker_is_judged_anew():
    # It runs to the right, is lost, and comes back to the left: an axis alone cannot follow.
    x = np.concatenate([np.linspace(0, 60, 20), np.linspace(60, 0, 20)])
    frames = np.concatenate([np.arange(20), np.arange(40, 60)])
    theta = heading.find_headings(seen_of(x, 0 * x, 0 * x, frames=frames), "motion").theta
    np.testing.assert_allclose(np.cos(theta), [1.0] * 20 + [-1.0] * 20, atol=1e-9)


def blob(x, y, area=900.0):
    return Blob(x, y, area, 0.0, 56.0, 16.0, math.nan)


def test_walkers_that_touch_are_left_out_counted_and_known_again():
    apart = [[blob(50 + 2 * n, 40), blob(150 - 2 * n, 80)] for n in range(20)]
    merged = [[blob(100, 60, 1800.0)] for _ in range(4)]
    after = [[blob(98 + 2 * n, 40), blob(102 - 2 * n, 80)] for n in range(20)]
    noise = [[blob(10, 10, 100.0)], []]
    found = linking.link([*apart, *merged, *after, *noise], 7, 50.0)
    assert (found.merged, found.empty, found.short) == (4, 1, 0)
    assert found.area == 900.0
    assert [list(one.frames[[0, -1]]) for one in found.walkers] == [[7, 50], [7, 50]]
    for one in found.walkers:
        assert len(set(one.blobs.y)) == 1  # each has kept its way
        assert 27 not in one.frames


def test_a_walker_that_jumps_is_refused_with_numbers():
    with pytest.raises(InputError, match="jump by more than 28 pixels a frame"):
        linking.link([[blob(60.0 * n, 40)] for n in range(30)], 0, 50.0)


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(command_line, ["track", *map(str, words)])


RIGHT = [(40.0 + 3.0 * n, 60.0 + 0.5 * n, 0.2 + 0.01 * n) for n in range(30)]
LEFT = [(200.0 - 2.5 * n, 120.0, math.pi - 0.02 * n) for n in range(30)]


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Film of two walkers that run toward each other's sides."""
    path = tmp_path_factory.mktemp("films") / "two.mp4"
    write(path, [drawn(pair, spot=20.0, seed=n) for n, pair in enumerate(zip(RIGHT, LEFT))])  # noqa: B905
    return path


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("by", heading.HEADING_SOURCES)
def test_a_film_becomes_tracks_that_analyse_reads(run, tmp_path, two, by):
    result = run(two, "--mm-per-px", "0.5", "--heading", by, "--fps", "50", "--json")
    told = json.loads(result.stdout)
    assert told["warnings"] == []
    assert [one["headings"] for one in told["tracks"]] == [30, 30]
    assert told["jitter_mm"] < 0.1
    folder = tmp_path / told["folder"]
    assert folder == tmp_path / "out" / "two" / "track"
    found = track_files.read_tracks(folder / "tracks.csv", track_files.Units())
    assert found.interval == pytest.approx(0.02)
    for one, truth in zip(found.tracks, map(np.array, (LEFT, RIGHT)), strict=True):
        np.testing.assert_allclose(one.position, 0.5 * truth[:, :2], atol=0.1)
        apart = one.heading - truth[:, 2]
        whole = 2.0 * np.pi * np.rint(apart[0] / (2.0 * np.pi))  # at 180 deg either sign is right
        np.testing.assert_allclose(apart, whole, atol=math.radians(2.0))


@pytest.mark.usefixtures("undrawn")
def test_a_part_of_a_film_keeps_its_frames_and_places(tmp_path, two):
    request = TrackRequest(film=two, mm_per_px=0.5, frames=(5, 20), region=(0, 70, 240, 80))
    part = make.track(request, tmp_path, silent).tracked
    (one,) = part.walkers
    assert one.frames.tolist() == list(range(5, 20))
    np.testing.assert_allclose(one.position, 0.5 * np.array(RIGHT)[5:20, :2], atol=0.1)
    with (tmp_path / "tracks.csv").open() as stream:
        first = next(csv.DictReader(stream))
    assert (first["frame"], first["x"], first["t_s"]) == ("5", first["x_mm"], "0.2")


@pytest.mark.usefixtures("undrawn")
def test_touching_lost_and_held_walkers_are_warned_of(tmp_path):
    n = np.arange(40)
    ways = [[(60 + 1.5 * k, 80, 0.0), (180 - 1.5 * k, 97.0, 0.0)] for k in n]
    frames = [drawn(pair, noise=0) for pair in ways]
    frames[12:15] = [drawn([], noise=0)] * 3
    frames += [frames[-1]] * 20
    write(tmp_path / "bad.mp4", frames)
    made = make.track(TrackRequest(film=tmp_path / "bad.mp4", mm_per_px=1.0), tmp_path / "o", silent)
    told, still = " ".join(made.warnings), made.found.still
    assert "nothing was found in 3 of 60 frames" in told
    assert f"nothing moves in {still} of 60 frames. If the film repeats" in told
    assert 15 <= still <= 20


def movies_film(path, seconds):
    """Film of a walker from above, as `movie` draws it; its shot, and its mm per pixel."""
    paper = templates.load("koumakis2016", "walkers", Design)
    scene = templates.load("plane-90hz", "scenes", Scene)
    job = film.plan_film(MovieRequest(seconds=seconds, fps=25), [paper], scene)
    shot = movie.simulate_shot(job, paper, movie.ABOVE_POSES_PER_FRAME)
    draw = top_view.make_draw_function([shot], movie.ABOVE_POSES_PER_FRAME, job.slow, "settings", 1.0 / 90.0, None)
    grey = [np.asarray(Image.fromarray(draw(n)).convert("L")) for n in range(job.frames)]
    high, wide = (16 * (side // 16) for side in grey[0].shape)
    write(path, [one[-high:, :wide] for one in grey])
    left, right, low, top = top_view._window(shot, None)
    across = (right - left) / (top_view.WIDTH_PX - 2 * top_view.MARGIN_PX)
    return shot, max(across, (top - low) / top_view.MAX_ARENAS_PX)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_movies_own_film_says_where_the_walker_was(tmp_path):
    """Simulated, drawn from above, filmed, tracked: places, headings and way of the simulation."""
    shot, scale = movies_film(tmp_path / "film.mp4", 0.48)
    request = TrackRequest(film=tmp_path / "film.mp4", mm_per_px=scale)
    made = make.track(request, tmp_path / "out", silent)
    by_length = blob_tracking.find_scale(TrackRequest(film=request.film, length=28.0), made.found.linked.length)
    assert by_length.value == pytest.approx(scale, abs=by_length.se)
    (one,) = made.tracked.walkers
    assert one.frames.tolist() == list(range(13))
    theta = shot.poses.heading[:: movie.ABOVE_POSES_PER_FRAME]
    truth = shot.track[:: movie.ABOVE_POSES_PER_FRAME] + shot.base[0] * np.column_stack([np.cos(theta), np.sin(theta)])
    apart = (one.position - one.position.mean(axis=0)) - (truth - truth.mean(axis=0))
    assert np.abs(apart).max() < 0.3 * scale  # a fraction of a pixel
    assert np.degrees(np.abs(one.theta - theta)).max() < 1.5
    # The same functions measure the same motion of both.
    rows = [np.column_stack([place, turn]) for place, turn in ((one.position, one.theta), (truth, theta))]
    filmed, run = (motion.analyse(tracks.from_positions([row], 0.04, lane=False)) for row in rows)
    steps = [found.estimates["parallel_mean"] for found in (filmed, run)]
    assert steps[0].value == pytest.approx(steps[1].value, rel=0.01)
    assert steps[0].value / 0.04 == pytest.approx(shot.distance / 0.48, rel=0.05)


@pytest.mark.nightly
def test_a_long_film_of_a_small_walker_has_the_simulations_speed(tmp_path):
    shot, scale = movies_film(tmp_path / "film.mp4", 12.0)  # 14 pixels wide
    make.track(TrackRequest(film=tmp_path / "film.mp4", mm_per_px=scale), tmp_path / "out", silent)
    found = motion.analyse(track_files.read_tracks(tmp_path / "out" / "tracks.csv", track_files.Units()))
    speed = found.estimates["speed"]
    assert speed.value == pytest.approx(shot.distance / 12.0, abs=speed.se)
    assert speed.se < 0.02 * speed.value


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ((), "give either --mm-per-px"),
        (("--mm-per-px", "1", "--length", "28"), "give either --mm-per-px"),
        (("--length", "inf"), "--length 'inf': must be"),
        (("--threshold", "300", "--length", "28"), "--threshold 300: must be"),
        (("--walkers", "green", "--length", "28"), "must be one of dark, light"),
        (("--frames", "20:10", "--length", "28"), "--frames 20:10: must count from 0"),
        (("--frames", "1e9", "--length", "28"), "must be FIRST:LAST"),
        (("--frames", "29:", "--length", "28"), "1 frame from 29 on: at least 2"),
        (("--region", "0,0,9999,10", "--length", "28"), "must lie within the 240 x 160"),
        (("--region", "0,0,40,40", "--length", "28"), "no walker found"),
        (("--width", "90", "--length", "28"), "no walker found in 30 frames"),
    ],
)
def test_bad_wishes_are_one_clear_line_and_write_nothing(run, tmp_path, two, words, hint):
    result = run(two, *words)
    assert isinstance(result.exception, InputError), (result.output, result.exception)
    assert hint in str(result.exception)
    assert len(str(result.exception).splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_film_is_one_clear_line(tmp_path):
    files = {
        "text.mp4": (b"I am no film\n", "cannot be read as a film"),
        "list.mp4": (b"#EXTM3U\n#EXTINF:9,\nhttp://127.0.0.1:9/x.ts\n", "cannot be read as a film"),
    }
    for name, (data, hint) in files.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=hint) as caught:
            films.probe_film(tmp_path / name)
        assert len(str(caught.value).splitlines()) == 1


def test_too_large_a_film_says_what_to_do(monkeypatch, two):
    monkeypatch.setattr(films, "MAX_PIXELS", 1000)
    with pytest.raises(InputError, match=r"240 x 160 pixels a frame: at most .* Make it smaller"):
        films.probe_film(two)


def test_from_python_a_film_is_tracked_and_analysed(tmp_path, monkeypatch, two):
    monkeypatch.setattr(film_figures, "WIDTH_INCHES", 3.0)  # drawn in less time
    found = wg.track(two, length=28.0, heading="mark", out=tmp_path / "here")
    assert found.picture == tmp_path / "here" / "track" / "check.png"
    table = found.table
    assert table.keys == report.COLUMNS
    assert len(table.to_dataframe()) == 60
    assert found["walkers"]["heading_by"][0] == "the long axis and the mark, in 30 of 30 frames"
    moved = wg.analyse(found)
    assert moved.motion.particles == 2
    with pytest.raises(InputError, match="give either mm_per_px"):
        wg.track(two, out=tmp_path / "none")
    assert not (tmp_path / "none").exists()
    request = TrackRequest(film=two, length=28.0, heading="mark")
    again = make.track(request, tmp_path / "again", silent).tracked
    with Image.open(found.picture) as picture:
        assert picture.size[0] == 3 * figures.DPI
    assert again.mm_per_px.value == pytest.approx(0.5, abs=again.mm_per_px.se)
    for name in ("tracks.csv", "check.png", "manifest.json"):  # the same film, the same bytes
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "here" / "track" / name).read_bytes()
