"""A plate's drive from an accelerometer: known of made recordings, and declined where the rate cannot tell it."""

import math

import numpy as np
import pytest

import walkergen as wg
from walkergen.core.errors import InputError
from walkergen.core.files import config
from walkergen.core.scene import GRAVITY, Scene
from walkergen.guests.lab.calibrate import accelerometer, plate_drive
from walkergen.guests.lab.calibrate.accelerometer import Recording

SCENE = Scene.model_validate({"drive": {"frequency_hz": 90.0, "gamma": 1.8}})
TRUTH = {
    "drive": 88.37,
    "amplitude": 52.0,
    "second harmonic": 0.06,
    "phase of second harmonic": 40.0,
    "motion along the phone's x": 0.05,
    "phase of motion along the phone's x": -70.0,
    "gradient": 0.2,
    "direction of gradient": 30.0,
    "rocking": 0.1,
    "direction of rocking": -120.0,
    "noise": 0.15,
}


def turned(rng, up, along, tilt, rates):
    """What a phone that lies tilted feels of a plate's accelerations, and of its rates of turning about x and y."""
    axis = rng.normal(size=2)
    axis = np.array([*axis / np.linalg.norm(axis), 0.0])
    across = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    rotation = np.eye(3) + math.sin(tilt) * across + (1.0 - math.cos(tilt)) * across @ across
    return np.column_stack([along, 0.0 * along, up]) @ rotation.T, np.column_stack([*rates, 0.0 * along]) @ rotation.T


def rumbled(rng, times, rate):
    """Acceleration over the root mean square velocity of noise between 20 and 200 Hz, at some times."""
    fine, count = 8.0 * rate, 16 * len(times)
    at = np.fft.rfftfreq(count, 1.0 / fine)
    waves = np.where((at >= 20.0) & (at <= 200.0), rng.normal(size=(2, len(at))), 0.0)
    velocity = waves[0] + 1j * waves[1]
    spread = np.fft.irfft(velocity, count).std()
    return np.interp(times, np.arange(count) / fine, np.fft.irfft(2j * math.pi * at * velocity, count) / spread)


def made(rng, rate=500.0, seconds=20.0, truth=TRUTH, tilt=0.0, jitter=0.02, linear=False, phone=10.0, gyroscope=True):
    """Recording (mm/s^2) of a plate that is known: even noise of velocity between 20 and 200 Hz, and a phone's own."""
    count = round(rate * seconds)
    times = (np.arange(count) + jitter * rng.uniform(-0.5, 0.5, count)) / rate
    omega, size = 2.0 * math.pi * truth["drive"], 1e-3 * truth["amplitude"]
    phi = omega * times + rng.uniform(0.0, 2.0 * math.pi)
    shift, way = (math.radians(truth[f"phase of {name}"]) for name in ("second harmonic", "motion along the phone's x"))
    up = -size * omega**2 * (np.sin(phi) + 4.0 * truth["second harmonic"] * np.sin(2.0 * phi + shift))
    along = -size * omega**2 * truth["motion along the phone's x"] * np.sin(phi + way)
    up += truth["noise"] * size * omega * rumbled(rng, times, rate)
    # heights A (1 + g . r) sin(phi) + A k . r cos(phi); where they rise to the left the plate turns about x, where
    # along x about -y
    slopes = 0.0
    for name, wave in (("gradient", np.cos(phi)), ("rocking", -np.sin(phi))):
        way = math.radians(truth[f"direction of {name}"])
        slopes += 0.01 * truth[name] * size * omega * np.array([math.cos(way), math.sin(way)])[:, None] * wave
    felt, rates = turned(rng, up + (0.0 if linear else GRAVITY), along, tilt, (slopes[1], -slopes[0]))
    felt, rates = felt + rng.normal(0.0, phone, (count, 3)), rates + rng.normal(0.0, 0.005, (count, 3))
    return Recording(times, felt, linear, rates if gyroscope else None)


def rows_of(recording, scene=SCENE):
    rows, notes = plate_drive.measure(recording, scene, "plate.csv")
    return {row.name: row.number for row in rows}, notes


def test_numbers_of_made_plates_lie_within_their_bounds():
    rng = np.random.default_rng(8)
    inside = dict.fromkeys(TRUTH, 0)
    for _ in range(20):
        found, _ = rows_of(made(rng, seconds=12.0))
        for name, true in TRUTH.items():
            low, high = found[name].interval(0.95)
            inside[name] += low <= true <= high
    # of 20 at 95 %, fewer than 16 happen once in 400
    assert min(inside.values()) >= 16, inside


def test_a_tilted_phone_sees_the_same_plate():
    found, notes = rows_of(made(np.random.default_rng(3), tilt=0.2))
    assert found["amplitude"].value == pytest.approx(TRUTH["amplitude"], rel=0.01)
    assert found["second harmonic"].value == pytest.approx(TRUTH["second harmonic"], abs=0.01)
    assert found["rocking"].value == pytest.approx(TRUTH["rocking"], rel=0.05)
    assert not any("gravity" in note for note in notes)


def test_without_a_gyroscope_rocking_is_declined():
    found, _ = rows_of(made(np.random.default_rng(2), gyroscope=False))
    for name in ("gradient", "rocking"):
        assert "needs the gyroscope" in found[name].refused


def test_a_recording_without_gravity_takes_the_axis_that_shakes_most():
    found, notes = rows_of(made(np.random.default_rng(4), linear=True))
    assert found["amplitude"].value == pytest.approx(TRUTH["amplitude"], rel=0.01)
    assert any("the app removed gravity" in note for note in notes)


def test_a_harmonic_beyond_half_the_rate_is_declined_and_no_noise():
    truth = TRUTH | {"drive": 70.0, "noise": 1e-4}
    found, notes = rows_of(made(np.random.default_rng(5), rate=200.0, truth=truth, jitter=0.0))
    assert "another frequency" in found["second harmonic"].refused
    assert found["drive"].value == pytest.approx(70.0, abs=0.01)
    assert found["noise"].value < 0.01
    assert any("filter" in note for note in notes)


def test_a_drive_beyond_half_the_rate_is_refused():
    with pytest.raises(InputError, match="another frequency"):
        rows_of(made(np.random.default_rng(6), rate=100.0))


def test_a_plate_at_rest_has_no_drive():
    still = TRUTH | {"amplitude": 1e-9}
    with pytest.raises(InputError, match="no drive frequency"):
        rows_of(made(np.random.default_rng(7), truth=still))


@pytest.mark.parametrize(
    ("names", "scale", "linear"),
    [
        (
            ("Time (s)", *(f"Acceleration {axis} (m/s^2)" for axis in "xyz"), "Absolute acceleration (m/s^2)"),
            1e-3,
            False,
        ),
        (("Time (s)", *(f"Linear Acceleration {axis} (m/s^2)" for axis in "xyz")), 1e-3, True),
        (("time", "gFx", "gFy", "gFz", "TgF"), 1.0 / GRAVITY, False),
        (("time", "seconds_elapsed", "z", "y", "x"), 1e-3, False),
        (("t_ms", "ax", "ay", "az"), 1e-3, False),
    ],
)
def test_files_of_apps_are_read_by_their_columns(tmp_path, names, scale, linear):
    count = accelerometer.MIN_SAMPLES
    own = {"x": 1.0, "y": 2.0, "z": GRAVITY}
    rows = []
    for number in range(count):
        seconds = 0.002 * number
        cells = {"t_ms": 1e3 * seconds, "seconds_elapsed": seconds, "Time (s)": seconds}
        cells |= {"time": seconds + 1.7e9 if "seconds_elapsed" in names else seconds}
        cells |= {"TgF": 1.0, "Absolute acceleration (m/s^2)": 9.8}
        for name in names:
            axis = next((axis for axis in "xyz" if name in (f"gF{axis}", axis, f"a{axis}") or f" {axis} " in name), "")
            cells[name] = scale * own[axis] if axis else cells[name]
        rows.append(",".join(repr(cells[name]) for name in names))
    path = tmp_path / "plate.csv"
    path.write_text("\n".join([",".join(names), *rows]))
    recording = accelerometer.read_recording(path)
    assert recording.rate == pytest.approx(500.0)
    assert recording.felt[0] == pytest.approx([1.0, 2.0, GRAVITY])
    assert recording.linear is linear


def test_the_command_writes_the_scene_of_the_plate(tmp_path):
    recording = made(np.random.default_rng(9), seconds=10.0)
    path, out = tmp_path / "plate.csv", tmp_path / "out"
    names = ["Time (s)", *(f"Acceleration {axis} (m/s^2)" for axis in "xyz")]
    names += [f"Gyroscope {axis} (deg/s)" for axis in "xyz"]
    rows = np.column_stack([recording.times, 1e-3 * recording.felt, np.degrees(recording.turned)])
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="")
    report = wg.calibrate(plate=path, out=out)
    scene = config.read_section(report.folder / "scene.toml", Scene)
    assert scene == report.scene
    assert scene.drive.frequency == pytest.approx(88.37, abs=0.01)
    assert 1e3 * scene.drive.amplitude == pytest.approx(52.0, rel=0.01)
    assert scene.drive.second_harmonic_ratio == pytest.approx(0.06, abs=0.01)
    assert scene.plate.noise_ratio == pytest.approx(0.15, abs=0.02)
    along, left = scene.plate.horizontal_ratio
    assert along == pytest.approx(0.05, abs=0.005)
    assert scene.plate.horizontal_phase_deg == [pytest.approx(-70.0, abs=5.0), 0.0]
    assert left == 0.0  # not told from 0
    assert math.hypot(*scene.plate.gradient_percent_per_mm) == pytest.approx(0.2, rel=0.05)
    along, left = scene.plate.rocking_percent_per_mm
    assert math.degrees(math.atan2(left, along)) == pytest.approx(-120.0, abs=3.0)
    assert not (report.folder / "design.toml").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n", "no column of times"),
        ("time,ax,ay\n1,2,3\n", "no three axes"),
        ("time,ax,ay,az\n1,2,3,4\n", "samples: must be at least"),
        ("time,ax,ay,az\n" + "".join(f"{number},2,3,4\n" for number in range(500)), "must be seconds"),
    ],
)
def test_other_files_are_refused_in_a_line(tmp_path, text, words):
    path = tmp_path / "other.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        accelerometer.read_recording(path)
