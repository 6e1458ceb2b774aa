"""Lenses that bend: what a calibration undoes, what is told without one, and what is no lens."""

import json
import re
from pathlib import Path

import cv2
import marker_films as films
import numpy as np
import pytest
import rendered_films as walkers
from marker_films import Camera, Light, Shot

import walkergen as wg
from walkergen.core.errors import InputError
from walkergen.guests.track.film import lens, marker_warnings
from walkergen.guests.track.film.blobs import Blobs
from walkergen.guests.track.film.lens import Lens

NEAR = Camera()


def of(camera, k1, scale=1):
    """Calibration of a camera whose pictures are `scale` times as large, as OpenCV's in JSON."""
    wide, high = scale * camera.wide, scale * camera.high
    focal, x, y = scale * camera.focal, 0.5 * (wide - 1), 0.5 * (high - 1)
    return {
        "image_width": wide,
        "image_height": high,
        "camera_matrix": [[focal, 0, x], [0, focal, y], [0, 0, 1]],
        "distortion_coefficients": [[k1, 0.0, 0.0, 0.0, 0.0]],
    }


def write(path, data):
    path.write_text(json.dumps(data))
    return path


def bent_places(places, camera, k1):
    """Pixels at which a lens shows places of a picture without distortion."""
    middle = 0.5 * np.array([camera.wide, camera.high])
    rays = (places - middle) / camera.focal
    return rays * (1.0 + k1 * (rays**2).sum(axis=-1, keepdims=True)) * camera.focal + middle


@pytest.mark.parametrize("k1", [-0.25, -0.03, 0.1])
@pytest.mark.parametrize("scale", [1, 3])
def test_straight_places_bend_to_where_they_were_seen(tmp_path, k1, scale):
    """Against the polynomial itself; a calibration by larger pictures of the same lens."""
    own = lens.read_lens(write(tmp_path / "l.json", of(Camera(), k1, scale))).for_film(640, 480)
    true = np.random.default_rng(1).uniform((0, 0), (640, 480), (200, 3, 2))
    assert own.undistort(bent_places(true, Camera(), k1)) == pytest.approx(true, abs=0.02)
    corner = np.hypot(0.5 * 640, 0.5 * 480) / 700.0
    shown = own.undistort(np.array([[0.0, 0.0]])) - (320.0, 240.0)
    outer = np.linalg.norm(shown) / 700.0
    assert outer * (1.0 + k1 * outer**2) == pytest.approx(corner, rel=1e-4)


def test_directions_lengths_and_areas_are_those_of_straight_boxes():
    """A blob's numbers against corners of a small box that are straightened one by one."""
    own = Lens(640, 480, (700.0, 700.0), (319.5, 239.5), (-0.25, 0.0, 0.0, 0.0))
    x, y, axis = np.array([600.0, 30.0]), np.array([450.0, 200.0]), np.array([0.4, -1.2])
    long, wide = np.full(2, 2.0), np.full(2, 1.0)
    blobs = Blobs(x, y, long * wide, axis, long, wide, axis + np.pi, 0 * x, 0 * x)
    made = own.undistort_blobs(blobs, (0, 0))
    ahead = np.column_stack([np.cos(axis), -np.sin(axis)])
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    places = np.column_stack([x, y]) + 0.5
    ends = own.undistort(places + ahead), own.undistort(places - ahead)
    sides = own.undistort(places + 0.5 * aside), own.undistort(places - 0.5 * aside)
    way, across = ends[0] - ends[1], sides[0] - sides[1]
    assert made.length == pytest.approx(np.linalg.norm(way, axis=1), rel=1e-4)
    assert made.axis == pytest.approx(np.arctan2(-way[:, 1], way[:, 0]), abs=1e-4)
    assert made.mark == pytest.approx(made.axis + np.pi, abs=1e-6)
    spanned = np.abs(way[:, 0] * across[:, 1] - way[:, 1] * across[:, 0])
    assert made.area == pytest.approx(spanned, rel=1e-3)


def circling(path, k1, frames=40):
    """Film of five walkers with caps through a lens, and their ways."""
    ways = films.circles()
    drawn = films.draw(ways, frames, Shot(NEAR, Light(uneven=0.5)))
    return films.write(path, [films.distort_frame(one, NEAR, k1) for one in drawn]), ways


@pytest.mark.nightly
def test_a_barrel_is_told_with_its_size_and_undone_by_its_calibration(tmp_path):
    """k1 = -0.1, which draws the picture's corners in by 3.6 %: 0.13 mm off, with it 0.01 mm."""
    path, ways = circling(tmp_path / "barrel.mp4", -0.1)
    bare = wg.track(path, markers="aruco", out=tmp_path / "bare")
    (told,) = (line for line in bare.warnings if "The lens distorts" in line)
    assert "smaller" in told
    bend, away_px = marker_warnings.edge_size_change(bare.found)
    share, away = bend.value, (away_px / NEAR.focal) ** 2
    assert share == pytest.approx(-2 * 0.1 * away, rel=0.4)  # (1 + k1 r2)(1 + 3 k1 r2), its root
    own = write(tmp_path / "lens.json", of(NEAR, -0.1, 3))
    made = wg.track(path, markers="aruco", lens=own, out=tmp_path / "made")
    assert made.warnings == []
    off, undone = (films.errors(one.tracked, ways) for one in (bare, made))
    print(off, undone)
    assert off.place_mm > 0.08
    assert undone.place_mm < 0.02
    assert abs(undone.scale) < 0.002 < off.scale
    assert made.facts["lens"]["distortion"][0] == -0.1
    assert made.picture.is_file()


@pytest.mark.nightly
def test_a_straight_lens_is_not_suspected(tmp_path):
    path, _ = circling(tmp_path / "straight.mp4", 0.0)
    made = wg.track(path, markers="aruco", out=tmp_path / "t")
    assert made.warnings == []
    bend, _ = marker_warnings.edge_size_change(made.found)
    assert abs(bend.value) < min(0.003, 3.0 * bend.se)


@pytest.mark.nightly
def test_walkers_without_caps_run_straight_through_a_lens_that_is_undone(tmp_path):
    """Along the upper edge and the middle: places, headings and lengths as without the lens."""
    camera, k1 = Camera(wide=320, high=240, focal=300.0), -0.3
    film = walkers.Filmed(noise=1.0)
    pictures = [walkers.picture([(60 + 6 * n, 25, 0.0), (260 - 6 * n, 120, np.pi)], film, seed=n) for n in range(30)]
    path = walkers.write(tmp_path / "film.mp4", [films.distort_frame(one, camera, k1) for one in pictures])
    own = write(tmp_path / "lens.json", of(camera, k1))
    bare, made = (
        wg.track(path, length=walkers.LONG, lens=one, out=tmp_path / name)
        for one, name in ((None, "bare"), (own, "made"))
    )
    assert made.tracked.mm_per_px.value == pytest.approx(1.0, abs=0.03)  # a pixel of 40: blurred edges

    def bow(report):
        """Largest way of a track beside a straight line, and largest turn of its heading."""
        low = min(report.tracked.walkers, key=lambda walker: walker.position[:, 1].mean())
        x, y = low.position.T
        rest = y - np.polyval(np.polyfit(x, y, 1), x)
        return np.abs(rest).max(), np.ptp(low.theta)

    print(bow(bare), bow(made))
    assert bow(bare)[0] > 1.0 > 0.2 > bow(made)[0]
    assert bow(bare)[1] > 0.1 > 0.06 > bow(made)[1]


GOOD = of(Camera(), -0.1)


@pytest.mark.parametrize(
    ("changes", "hint"),
    [
        ({"camera_matrix": None}, "camera_matrix is missing: must be 9 numbers"),
        ({"camera_matrix": [[0, 0, 1], [0, 1, 1], [0, 0, 1]]}, "with fx, fy > 0"),
        ({"distortion_coefficients": [0.1] * 3}, "must be 4 or 5 or 8 or 12 or 14 numbers"),
        ({"image_width": "wide"}, "image_width = wide: must be 1 number$"),
        ({"image_height": 640}, "calibrated with pictures of 640 x 640, the film has 640 x 480"),
        ({"distortion_coefficients": [-9.0, 0, 0, 0]}, "its distortion is off by"),
    ],
)
def test_what_is_no_lens_is_one_line(tmp_path, changes, hint):
    path = write(tmp_path / "l.json", GOOD | changes)
    with pytest.raises(InputError, match=hint) as caught:
        lens.read_lens(path).for_film(640, 480).undistort(np.array([[10.0, 10.0]]))
    assert len(str(caught.value).splitlines()) == 1


def test_a_lens_is_scaled_to_the_film_and_refused_for_another_shape(tmp_path):
    path = walkers.write(tmp_path / "film.mp4", [walkers.picture([(60, 25, 0.0)], walkers.Filmed(), seed=0)] * 3)
    own = write(tmp_path / "lens.json", of(Camera(wide=400, high=100), -0.1))
    with pytest.raises(InputError, match="calibrated with pictures of 400 x 100"):
        wg.track(path, length=walkers.LONG, lens=own, out=tmp_path / "t")


def test_opencv_s_own_objects_are_read(tmp_path):
    nested = GOOD | {
        "camera_matrix": {"rows": 3, "cols": 3, "data": np.ravel(GOOD["camera_matrix"]).tolist()},
        "distortion_coefficients": {"rows": 1, "cols": 5, "data": [-0.1, 0, 0, 0, 0]},
    }
    write(tmp_path / "own.json", nested)
    assert lens.read_lens(tmp_path / "own.json") == lens.read_lens(write(tmp_path / "b.json", GOOD))


def boards(camera, count=15):
    """Pictures of a checkerboard of 9 x 6 inner corners, 10 mm apart, in poses up to the edges."""
    rng = np.random.default_rng(2)
    squares = np.indices((7, 10)).sum(axis=0) % 2 == 0
    texels = np.kron(np.pad(~squares, 1, constant_values=True), np.full((40, 40), 215)) + 20
    source = np.array([(-20, -20), (100, -20), (100, 70), (-20, 70)], float)
    ends = np.array([(0, 0), (480, 0), (480, 360), (0, 360)], np.float32) - 0.5
    matrix = np.array(
        [(camera.focal, 0, 0.5 * (camera.wide - 1)), (0, camera.focal, 0.5 * (camera.high - 1)), (0, 0, 1.0)]
    )
    pictures = []
    while len(pictures) < count:
        turn, middle = rng.uniform(-0.5, 0.5, 3), rng.uniform((-50, -35, 0), (50, 35, 40))
        solid, _ = cv2.Rodrigues(turn)
        shift = middle + np.array([0.0, 0.0, 190.0]) - solid @ (40.0, 25.0, 0.0)
        places = np.column_stack([source, np.zeros(4)]) @ solid.T + shift
        corners = (places[:, :2] / places[:, 2:] * camera.focal + matrix[:2, 2]).astype(np.float32)
        fine = cv2.getPerspectiveTransform(ends, 2.0 * corners + 0.5)
        size = 2 * camera.wide, 2 * camera.high
        view = cv2.warpPerspective(texels.astype(np.uint8), fine, size, borderValue=128)
        small = cv2.resize(view, (camera.wide, camera.high), interpolation=cv2.INTER_AREA)
        pictures.append(small)
    return pictures


@pytest.mark.nightly
@pytest.mark.programs
def test_the_calibration_of_the_docs_finds_a_hidden_lens(tmp_path, monkeypatch, capsys):
    """Its lines, run on a drawn film of a checkerboard, give the lens that drew it."""
    monkeypatch.chdir(tmp_path)
    shown = [films.distort_frame(one, NEAR, -0.1) for one in boards(NEAR) for _ in range(10)]
    films.write(tmp_path / "board.mp4", shown)
    text = (Path(__file__).parents[3] / "docs" / "track-files.md").read_text(encoding="utf-8")
    (lines,) = re.findall(r"```python\n(import cv2.*?)```", text, re.DOTALL)
    exec(lines, {})
    print(capsys.readouterr().out)
    found, true = (lens.read_lens(tmp_path / "lens.json"), lens.read_lens(write(tmp_path / "l", of(NEAR, -0.1))))
    grid = np.stack(np.meshgrid([5.0, 160.0, 320.0, 480.0, 635.0], [5.0, 240.0, 475.0]), axis=-1)
    ways = [own.undistort(grid) for own in (found, true)]
    # a calibration may shift, turn and scale all of a picture: compare what is no affine map
    flat = np.column_stack([ways[0].reshape(-1, 2), np.ones(grid[..., 0].size)])
    fitted, _, _, _ = np.linalg.lstsq(flat, ways[1].reshape(-1, 2))
    off = np.abs(flat @ fitted - ways[1].reshape(-1, 2)).max()
    assert off < 0.5  # pixels, of 14 that the lens shifts the corners by
