"""Films that are lit and taken badly: what they say is right, or they say what is wrong."""

import math

import numpy as np
import pytest
import rendered_films as films
from rendered_films import Filmed

from walkergen.analysis import tracks
from walkergen.files.progress import silent
from walkergen.jobs.track import find, look, make, tables
from walkergen.jobs.track.make import Options


def sigmoid(low, soft):
    """Light that falls to `low` in the right half."""
    return lambda x, y: low + (1.0 - low) / (1.0 + np.exp((x - 0.5) / soft))


def inside(x, y):
    """True on a plate that leaves a table around it."""
    return (np.abs(x - 0.5) < 0.42) & (np.abs(y - 0.5) < 0.42)


LIGHTS = {
    "even": Filmed(),
    "gradient": Filmed(light=lambda x, y: 1.0 - 0.75 * x),
    "soft half": Filmed(light=sigmoid(0.35, 0.05)),
    "sharp half": Filmed(light=sigmoid(0.35, 0.005)),
    "vignette": Filmed(light=lambda x, y: 1.0 - 1.3 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)),
    "two lamps": Filmed(light=lambda x, y: 0.4 + 2.4 * (x - 0.5) ** 2),
    "spot": Filmed(light=lambda x, y: 0.25 + np.exp(-((x - 0.3) ** 2 + (y - 0.6) ** 2) / 0.06)),
    "table": Filmed(light=lambda x, y: np.where(inside(x, y), 1.0, 0.15)),
    "light walkers": Filmed(ground=100, contrast=-100, light=sigmoid(0.35, 0.05)),
    "white table": Filmed(
        ground=22, contrast=-110, light=lambda x, y: np.where(inside(x, y), 1.0, 9.0)
    ),
    "screws": Filmed(screws=True, light=sigmoid(0.35, 0.05)),
    "noise": Filmed(contrast=30, noise=6),
    "more noise": Filmed(contrast=30, noise=9),
    "little contrast": Filmed(contrast=20, noise=6),
}


def ways(frames):
    """Places and headings of four walkers, one of them in the darker half."""
    return [
        [
            (80 + 1.5 * n, 70 + 0.5 * n, 0.3 + 0.01 * n), (150 - 0.5 * n, 170 - 0.8 * n, 2.0),
            (250 - 1.2 * n, 65 + 1.0 * n, 1.2), (240, 180 - 1.0 * n, -0.5 + 0.02 * n),
        ]
        for n in range(frames)
    ]  # fmt: skip


@pytest.mark.parametrize("name", LIGHTS)
def test_walkers_are_found_in_any_light(name):
    film = LIGHTS[name]
    truth = ways(20)
    frames = [films.picture(one, film, seed=n) for n, one in enumerate(truth)]
    seen = look.learn(frames[:8], None, None, None)
    assert seen.dark == (film.contrast > 0)
    assert seen.width == pytest.approx(films.ACROSS, abs=1.5)
    # Half of the walkers' contrast, whatever the noise: where their edge is.
    assert seen.threshold == pytest.approx(0.5 * seen.contrast)
    errors = []
    for one, frame in zip(truth[::3], frames[::3], strict=True):
        places = [
            (blob.x + 0.5, film.high - blob.y - 0.5) for blob in find.find(frame, seen, False)
        ]
        assert len(places) == 4
        errors += [min(math.dist(place, at[:2]) for place in places) for at in one]
    # A third of a pixel where light is steep; a pixel at the edge errs by noise over contrast.
    assert max(errors) < 0.3 + film.noise / abs(film.contrast)


TIMES = {
    "jitters": ("0.03*N+0.012*sin(N)", lambda n: 0.03 * n + 0.012 * np.sin(n)),
    "slows down": (
        "if(lt(N,30),0.02*N,0.6+0.05*(N-30))",
        lambda n: np.where(n < 30, 0.02 * n, 0.6 + 0.05 * (n - 30)),
    ),
}


@pytest.fixture
def undrawn(monkeypatch):
    """Pictures take longer than all the rest of a short film's tracking."""
    monkeypatch.setattr("walkergen.files.figures.png", lambda figure: b"")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", TIMES)
def test_a_film_of_variable_rate_keeps_its_times(tmp_path, name):
    words, times = TIMES[name]
    t = times(np.arange(60))

    def way(t):
        return np.stack([60.0 + 90.0 * t, 60.0 + 40.0 * t], axis=-1)

    pictures = [films.picture([(*way(one), 0.4)], seed=n) for n, one in enumerate(t)]
    path = films.write(tmp_path / "film.mp4", pictures, words)
    made = make.track(path, Options(mm_per_px=1.0), tmp_path / "out", silent)
    np.testing.assert_allclose(made.clock.times, t, atol=1e-4)
    assert not made.clock.regular
    assert tables.warnings(made) == []
    found = tracks.read(tmp_path / "out" / "tracks.csv", tracks.Units())
    assert "rate varies" in found.told
    (one,) = found.tracks
    regular = np.arange(len(one.position)) * found.interval
    np.testing.assert_allclose(one.position, way(regular), atol=0.3)  # of a pixel
    assert regular[-1] > t[-1] - 2 * found.interval
    # Filmed at a fifth of the time, as slow motion plays.
    slow = make.track(path, Options(mm_per_px=1.0, fps=5 * made.clock.fps), tmp_path / "o", silent)
    np.testing.assert_allclose(slow.clock.times, t / 5.0, atol=1e-4)


def test_places_between_frames_stop_at_gaps(tmp_path):
    """Against a walker that runs evenly: no place is made up where a frame is missing."""
    times = np.cumsum(np.where(np.arange(40) % 2, 0.021, 0.034))
    rows = [(n, 7, 10.0 * t, -5.0 * t, 3.0 * t) for n, t in enumerate(times) if n not in (20, 21)]
    lines = [f"{n},{k},{t},{x},{y},{a}" for (n, k, x, y, a), t in
             zip(rows, np.delete(times, [20, 21]), strict=True)]  # fmt: skip
    path = tmp_path / "t.csv"
    path.write_text("frame,particle,t_s,x_mm,y_mm,theta_rad\n" + "\n".join(lines) + "\n")
    found = tracks.read(path, tracks.Units())
    (one,) = found.tracks
    start = np.ceil(times[0] / found.interval) * found.interval
    t = start + np.arange(len(one.position)) * found.interval
    lost = np.isnan(one.position[:, 0])
    np.testing.assert_allclose(one.position[~lost], np.stack([10.0 * t, -5.0 * t], 1)[~lost])
    np.testing.assert_allclose(one.heading[~lost], 3.0 * t[~lost])
    # All grid points from frame 19 up to frame 22, and no others.
    np.testing.assert_array_equal(lost, (t >= times[19] - 1e-9) & (t < times[22] - 1e-9))
