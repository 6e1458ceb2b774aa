"""Films that are lit and taken badly: what they say is right, or they say what is wrong."""

import math

import numpy as np
import pytest
import rendered_films as films
from nightly_cases import mostly_nightly
from rendered_films import Filmed

from walkergen.analysis import track_files
from walkergen.core.files.progress import silent
from walkergen.guests.track.film import appearance, blobs, make, quality
from walkergen.guests.track.film.request import TrackRequest


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
    "white table": Filmed(ground=22, contrast=-110, light=lambda x, y: np.where(inside(x, y), 1.0, 9.0)),
    "screws": Filmed(screws=True, light=sigmoid(0.35, 0.05)),
    "noise": Filmed(contrast=30, noise=6),
    "more noise": Filmed(contrast=30, noise=9),
    "low contrast": Filmed(contrast=20, noise=6),
}


def ways(frames):
    """Places and headings of four walkers, one of them in the darker half."""
    return [
        [
            (80 + 1.5 * n, 70 + 0.5 * n, 0.3 + 0.01 * n),
            (150 - 0.5 * n, 170 - 0.8 * n, 2.0),
            (250 - 1.2 * n, 65 + 1.0 * n, 1.2),
            (240, 180 - 1.0 * n, -0.5 + 0.02 * n),
        ]
        for n in range(frames)
    ]


@pytest.mark.parametrize("name", mostly_nightly(LIGHTS, *list(LIGHTS)[::2]))
def test_walkers_are_found_in_any_light(name):
    film = LIGHTS[name]
    truth = ways(20)
    frames = [films.picture(one, film, seed=n) for n, one in enumerate(truth)]
    seen = appearance.learn_appearance(frames[:8], None, None, None)
    assert seen.dark == (film.contrast > 0)
    assert seen.width == pytest.approx(films.ACROSS, abs=1.5)
    # Half of the walkers' contrast, whatever the noise: where their edge is.
    assert seen.threshold == pytest.approx(0.5 * seen.contrast)
    errors = []
    for one, frame in zip(truth[::3], frames[::3], strict=True):
        places = [(blob.x + 0.5, film.high - blob.y - 0.5) for blob in blobs.find_blobs(frame, seen, False)]
        assert len(places) == 4
        errors += [min(math.dist(place, at[:2]) for place in places) for at in one]
    # A third of a pixel where light is steep; a pixel at the edge errs by noise over contrast.
    assert max(errors) < 0.3 + film.noise / abs(film.contrast)


TIMES = {
    "jitters": ("0.03*N+0.012*sin(N)", lambda n: 0.03 * n + 0.012 * np.sin(n)),
    "slows down": ("if(lt(N,30),0.02*N,0.6+0.05*(N-30))", lambda n: np.where(n < 30, 0.02 * n, 0.6 + 0.05 * (n - 30))),
}


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", TIMES)
def test_a_film_of_variable_rate_keeps_its_times(tmp_path, name):
    words, times = TIMES[name]
    t = times(np.arange(60))

    def way(t):
        return np.stack([60.0 + 90.0 * t, 60.0 + 40.0 * t], axis=-1)

    pictures = [films.picture([(*way(one), 0.4)], seed=n) for n, one in enumerate(t)]
    path = films.write(tmp_path / "film.mp4", pictures, words)
    made = make.track(TrackRequest(film=path, mm_per_px=1.0), tmp_path / "out", silent)
    clock = made.tracked.clock
    np.testing.assert_allclose(clock.times, t, atol=1e-4)
    assert not clock.regular
    assert made.warnings == []
    found = track_files.read_tracks(tmp_path / "out" / "tracks.csv", track_files.Units())
    assert "rate varies" in found.note
    (one,) = found.tracks
    regular = np.arange(len(one.position)) * found.interval
    np.testing.assert_allclose(one.position, way(regular), atol=0.3)  # of a pixel
    assert regular[-1] > t[-1] - 2 * found.interval
    # Filmed at a fifth of the time, as slow motion plays.
    request = TrackRequest(film=path, mm_per_px=1.0, fps=5 * clock.fps)
    slow = make.track(request, tmp_path / "o", silent)
    np.testing.assert_allclose(slow.tracked.clock.times, t / 5.0, atol=1e-4)


def test_places_between_frames_stop_at_gaps(tmp_path):
    """Against a walker that runs evenly: no place is made up where a frame is missing."""
    times = np.cumsum(np.where(np.arange(40) % 2, 0.021, 0.034))
    rows = [(n, 7, 10.0 * t, -5.0 * t, 3.0 * t) for n, t in enumerate(times) if n not in (20, 21)]
    lines = [f"{n},{k},{t},{x},{y},{a}" for (n, k, x, y, a), t in zip(rows, np.delete(times, [20, 21]), strict=True)]
    path = tmp_path / "t.csv"
    path.write_text("frame,particle,t_s,x_mm,y_mm,theta_rad\n" + "\n".join(lines) + "\n")
    found = track_files.read_tracks(path, track_files.Units())
    (one,) = found.tracks
    start = np.ceil(times[0] / found.interval) * found.interval
    t = start + np.arange(len(one.position)) * found.interval
    lost = np.isnan(one.position[:, 0])
    np.testing.assert_allclose(one.position[~lost], np.stack([10.0 * t, -5.0 * t], 1)[~lost])
    np.testing.assert_allclose(one.heading[~lost], 3.0 * t[~lost])
    # All grid points from frame 19 up to frame 22, and no others.
    np.testing.assert_array_equal(lost, (t >= times[19] - 1e-9) & (t < times[22] - 1e-9))


TURN = 2.0 * np.pi * np.arange(50) / 50
CIRCLES = [
    np.stack([x + r * np.cos(TURN + at), y + r * np.sin(TURN + at), TURN + at + 0.5 * np.pi], 1)
    for x, y, r, at in ((90.0, 120.0, 45.0, 0.0), (230.0, 120.0, 50.0, 2.0))
]
SHIFTS = np.random.default_rng(3).normal(0.0, 1.0, (50, 2))


def tracked(folder, film, shifts=None):
    """What was tracked of two walkers on circles, and its errors, mm, with 1 mm a pixel."""
    shifts = np.zeros((50, 2)) if shifts is None else shifts
    pictures = [films.picture([way[n] for way in CIRCLES], film, shifts[n], seed=n) for n in range(50)]
    path = films.write(folder / "film.mp4", pictures)
    made = make.track(TrackRequest(film=path, mm_per_px=1.0), folder / "out", silent)
    errors = []
    for one in made.tracked.walkers:
        ways = [way[one.frames, :2] - one.position for way in CIRCLES]
        errors.append(min(ways, key=lambda way: float(np.hypot(*way[0]))))
    return made, np.concatenate(errors)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_good_film_warns_of_nothing_and_tells_path_from_net_way(tmp_path):
    made, errors = tracked(tmp_path, Filmed(screws=True))
    assert made.warnings == []
    assert np.abs(errors).max() < 0.3
    assert made.found.shake.largest < 0.1
    ways = {round(made.tracked.path_mm(one)): one.net_mm for one in made.tracked.walkers}
    for radius in (45.0, 50.0):
        # All but the last fiftieth of the circle; chords are shorter by 0.1 %.
        path = 2.0 * np.pi * radius * 49 / 50
        (nearest,) = [one for one in ways if abs(one - path) < 0.02 * path]
        assert ways[nearest] == pytest.approx(path / 49, abs=0.6)


@pytest.mark.usefixtures("undrawn")
def test_a_shaking_camera_is_measured_by_what_stands_still(tmp_path):
    made, errors = tracked(tmp_path, Filmed(screws=True), SHIFTS)
    assert any("camera shakes" in line for line in made.warnings)
    assert made.found.shake.rms == pytest.approx(SHIFTS.std(), rel=0.05)
    assert made.found.shake.rms == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.1)
    largest = np.hypot(*(SHIFTS - SHIFTS.mean(axis=0)).T).max()
    assert made.found.shake.largest == pytest.approx(largest, rel=0.05)
    assert made.facts["shake_px"] == made.found.shake.rms


@pytest.mark.usefixtures("undrawn")
def test_what_cannot_be_known_of_a_bare_plates_shake_is_said(tmp_path):
    made, _ = tracked(tmp_path, Filmed(), SHIFTS)
    assert math.isnan(made.found.shake.rms)
    assert made.facts["shake_px"] is None
    assert any("Shake of the camera is unknown" in line for line in made.lines)


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("share", [0.3, 0.4])
def test_a_shadow_is_measured(tmp_path, share):
    """Against the true mean error, which a shadow in one direction makes."""
    made, errors = tracked(tmp_path, Filmed(shadow=(5.0, -4.0, share)))
    assert any("shadows" in line for line in made.warnings)
    pull = np.hypot(*errors.mean(axis=0))
    assert pull > 1.5
    assert made.facts["shadow_px"] == pytest.approx(pull, rel=0.2)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("film", "word"),
    [
        (Filmed(shadow=(8.0, -6.0, 0.5)), "change their size"),
        (Filmed(shadow=(8.0, -6.0, 0.5)), "at most 2 walkers in a frame"),
        (Filmed(contrast=30, noise=9), "low contrast"),
        (Filmed(tilt=0.25), "larger in one place"),
    ],
    ids=["dark shadow", "broken tracks", "noise", "perspective"],
)
def test_bad_light_and_a_tilted_camera_are_warned_of(tmp_path, film, word):
    made, errors = tracked(tmp_path, film)
    assert any(word in line for line in made.warnings)
    if film.noise > 2:  # half of the contrast as the threshold: fractions of a pixel all the same
        assert np.abs(errors).max() < 0.6
    if film.tilt:
        near, far = 1.0 + film.tilt * (np.array([280.0, 45.0]) / film.wide - 0.5)
        grown = (near / far) ** 1.5 - 1.0  # along the tilt by the square, across it by itself
        assert made.facts["size_change_share"] == pytest.approx(grown, rel=0.15)


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.3])
def test_a_path_does_not_grow_with_the_noise(noise):
    """A full circle, and a walker that stands, in many frames."""
    turn = np.linspace(0.0, 2.0 * np.pi, 2001)
    off = np.random.default_rng(4).normal(0.0, noise or 1e-12, (2001, 2))
    circle = 20.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1) + off
    assert quality.path_length(circle, noise) == pytest.approx(40.0 * np.pi, rel=0.03)
    assert quality.path_length(off, noise) == pytest.approx(0.0, abs=1e-7)
    assert quality.jitter([(np.arange(2001.0), circle)]) == pytest.approx(noise, abs=0.01)


def test_jitter_is_right_at_irregular_times():
    """An even run at uneven times has none but its noise."""
    rng = np.random.default_rng(5)
    times = np.cumsum(rng.uniform(0.01, 0.05, 4000))
    places = np.stack([90.0 * times, -40.0 * times], 1) + rng.normal(0.0, 0.2, (4000, 2))
    assert quality.jitter([(times, places)]) == pytest.approx(0.2, rel=0.05)
