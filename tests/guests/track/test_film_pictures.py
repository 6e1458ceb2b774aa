"""Films as folders of pictures, and films whose pixels are not square."""

import json

import numpy as np
import pytest
import rendered_films as films
from PIL import Image
from rendered_films import Filmed
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.progress import silent
from walkergen.guests.track.film import make
from walkergen.guests.track.film import pictures as folders
from walkergen.guests.track.film.request import TrackRequest

SPEED, FPS, HALF = 50.0, 25.0, 0.5
"""Of a walker to the right, pixels a second, of the film, and its scale."""


pytestmark = pytest.mark.usefixtures("undrawn")


def frames(film=Filmed(), number=24):  # noqa: B008
    return [films.picture([(60.0 + SPEED * n / FPS, 80.0, 0.0)], film, seed=n) for n in range(number)]


def saved(folder, pictures, ending=".png"):
    """Folder of pictures, named as cameras do: 1, 2, ... 10."""
    folder.mkdir()
    for number, picture in enumerate(pictures, 1):
        Image.fromarray(picture).save(folder / f"it's {number}{ending}")
    return folder


def speeds(made):
    """Mean speeds of the walkers, mm/s."""
    times = made.tracked.clock.times
    return [
        (walker.position[-1, 0] - walker.position[0, 0]) / (times[walker.frames[-1]] - times[walker.frames[0]])
        for walker in made.tracked.walkers
    ]


@pytest.mark.parametrize("ending", [".png", ".tif", ".bmp"])
def test_a_folder_of_pictures_is_a_film(tmp_path, ending):
    folder = saved(tmp_path / "pictures", frames(), ending)
    made = make.track(TrackRequest(film=folder, mm_per_px=HALF, fps=FPS), tmp_path / "out", silent)
    assert speeds(made) == [pytest.approx(0.5 * SPEED, rel=5e-3)]
    np.testing.assert_allclose(made.tracked.clock.times, np.arange(24) / FPS)
    assert f"24 pictures, from it's 1{ending} to it's 24{ending}" in made.lines[0]
    assert made.warnings == []


def test_pictures_of_sixteen_bits_keep_their_shades(tmp_path):
    deep = [picture.astype(np.uint16) * 257 for picture in frames()]
    made = make.track(
        TrackRequest(film=saved(tmp_path / "deep", deep), mm_per_px=HALF, fps=FPS), tmp_path / "out", silent
    )
    assert speeds(made) == [pytest.approx(0.5 * SPEED, rel=5e-3)]


def test_what_is_no_folder_of_frames_is_one_line(tmp_path):
    folder = saved(tmp_path / "pictures", frames(number=3))
    with pytest.raises(InputError, match="Give their rate, fps"):
        make.track(TrackRequest(film=folder, mm_per_px=HALF), tmp_path / "out", silent)
    (folder / "notes.txt").write_text("not a picture")
    assert len(folders.list_pictures(folder)) == 3
    Image.fromarray(frames(number=1)[0][:50]).save(folder / "cut.png")
    with pytest.raises(InputError, match="sizes differ: 3 of 320 x 240 pixels, 1 of 320 x 50 pixels"):
        folders.list_pictures(folder)
    (folder / "cut.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"cut\.png: cannot be read as a picture"):
        folders.list_pictures(folder)
    (folder / "cut.png").rename(folder / "thumb.jpg")
    with pytest.raises(InputError, match=r"kinds of pictures differ: 3 of \.png, 1 of \.jpg"):
        folders.list_pictures(folder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="a folder without pictures"):
        folders.list_pictures(tmp_path / "empty")


@pytest.mark.parametrize("aspect", [(4, 3), (3, 4)])
def test_pixels_that_are_not_square_are_made_so(tmp_path, aspect):
    """A walker that runs to the right and one that runs up, at the same speed in millimetres."""
    stretch = aspect[0] / aspect[1]
    square = Filmed(wide=400, high=304)
    whole = [films.picture([(60 + 2 * n, 60, 0.0), (300, 60 + 2 * n, np.pi / 2)], square, seed=n) for n in range(24)]
    size = (round(400 / stretch), 304) if stretch > 1 else (400, round(304 * stretch))
    squeezed = [np.asarray(Image.fromarray(picture).resize(size)) for picture in whole]
    path = films.write(tmp_path / "film.mp4", squeezed, aspect=aspect)
    made = make.track(TrackRequest(film=path, mm_per_px=HALF), tmp_path / "out", silent)
    assert (made.tracked.film.width, made.tracked.film.height) == (400, 304)
    assert f"Pixels of {aspect[0]}:{aspect[1]} were made square: frames of 400 x 304" in made.lines[0]
    for walker in made.tracked.walkers:
        assert walker.net_mm == pytest.approx(23.0, rel=0.01)  # 2 pixels of 0.5 mm a frame


@pytest.mark.slow
def test_a_film_of_4_to_3_gives_the_right_speed_by_the_commands(tmp_path):
    """Two walkers at 30 mm/s, one along the squeezed side: 24 mm/s where their pixels are taken for square."""
    step = 30.0 / 0.5 / FPS  # pixels a frame
    ways = [[(60 + step * n, 80, 0.0), (380, 40 + step * n, np.pi / 2)] for n in range(75)]
    whole = [films.picture(walkers, Filmed(wide=480, high=304), seed=n) for n, walkers in enumerate(ways)]
    squeezed = [np.asarray(Image.fromarray(picture).resize((360, 304))) for picture in whole]
    film = films.write(tmp_path / "film.mp4", squeezed, aspect=(4, 3))
    run, out = CliRunner().invoke, ["--out", str(tmp_path)]
    tracked = run(command_line, ["track", str(film), "--mm-per-px", "0.5", *out])
    assert (tracked.exit_code, "Pixels of 4:3 were made square" in tracked.output) == (0, True)
    analysed = run(command_line, ["analyse", str(tmp_path / "track" / "tracks.csv"), "--json", *out])
    told = json.loads(analysed.stdout)
    assert told["speed_low_95_mm_s"] <= 30.0 <= told["speed_high_95_mm_s"]
    assert told["speed_mm_s"] == pytest.approx(30.0, rel=0.003)
