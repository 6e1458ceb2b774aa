"""A plate's drive from a phone that rides on it: frequency, amplitude, harmonic, motion along, rocking, noise.

The recording is cut into equal pieces. In each, sines at the drive's frequency and its multiples are fitted to the
acceleration along gravity and across it. Errors come from the differences between pieces, due to noise and drifts
(Student's t). Phases are those of `drive`: the plate is at A [sin(phi) + r sin(2 phi + s)], and along it at q A sin(phi
+ p). A gyroscope measures slopes: heights away from the phone are A (g . r sin(phi) + k . r cos(phi)), with the
gradient g of the amplitude and the rocking k. x and y of the scene are the phone's: on its back, y is to the left of x.
The remaining motion is integrated to a velocity in the band of the scene's noise; it includes the phone's own noise.
"""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.numerics import Array, Complex
from walkergen.core.scene import GRAVITY, Scene
from walkergen.files.report import Column, Table
from walkergen.guests.lab.calibrate import accelerometer
from walkergen.guests.lab.calibrate.accelerometer import Recording
from walkergen.guests.lab.report import LabReport, Setup, name_after

PIECES = 16
"""Pieces of a recording."""

MIN_PERIODS = 8
"""Fewest periods of the drive in a piece."""

HARMONICS = 4
"""Number of fitted multiples of the drive's frequency. Those beyond half the rate only keep power out of the noise."""

MIN_PEAK_RATIO = 30.0
"""Smallest power of the drive's line over the median of the spectrum."""

MIN_SIGNIFICANCE = 3.0
"""Significance threshold of an amplitude, in standard errors."""

NYQUIST = 0.5
USED_BANDWIDTH = 0.8
"""Used share of half the sampling rate: phones damp frequencies close to it."""

MIN_SETTINGS = {
    "plate.noise_ratio": 0.01,
    "plate.horizontal_ratio[1]": 0.005,
    "plate.horizontal_ratio[2]": 0.005,
    "plate.gradient_percent_per_mm": 0.005,
    "plate.rocking_percent_per_mm": 0.005,
}
"""Smallest values that are set in a scene, by key: a phone alone makes as much noise, and less moves no walker."""

SIDEWAYS_THRESHOLD = 0.8
"""Upward component of the phone's x axis above which y replaces it, because the phone lies on its side."""

FILTERED_FREQUENCY_RATIO = 0.25
"""Frequency over the sampling rate above which a phone's own filter may lower an amplitude."""

COLUMNS = ("quantity", "value", "se", "unit", "key", "refused")
"""Columns of calibration.csv."""


class Row(NamedTuple):
    """Measured number of the plate, with its displayed name, and the key of a scene that it sets ("" for none)."""

    name: str
    number: Quantity
    key: str = ""


class Sines(NamedTuple):
    """Sines fitted to each piece of a recording. Amplitudes are complex: z means Re[z exp(i omega t)]."""

    upward: Complex
    """Amplitudes (mm/s^2) of upward accelerations, shape (pieces, HARMONICS)."""
    sideways: Complex
    """Amplitudes at the drive's frequency: of accelerations (mm/s^2) along x and y of the plate and, if known, of
    turning rates (rad/s) about x and y: shape (pieces, 2) or (pieces, 4)."""
    rest: Array
    """Upward acceleration minus the fitted sines, shape (n,), mm/s^2."""


def calibrate(path: Path, setup: Setup, folder: Path | None) -> LabReport:
    """Return the report of the plate's motion in the recording `path`, with the updated scene. Raises InputError."""
    scene = setup.scene
    if scene.drive.kind == "motor":
        raise InputError(f"‹plate=›{path}: this scene has a motor. Give a scene with a shaken plate.")
    recording = accelerometer.read_recording(path)
    rows, notes = measure(recording, scene, str(path))
    settings, used = _scene_settings(rows, notes)
    if "plate.noise_ratio" in settings:
        low, high = scene.plate.noise_band_hz
        settings |= {"plate.noise_band_hz": [low, min(high, math.floor(_max_frequency(recording.rate)))]}
    description = f"As {scene.name}, measured: {path.name[:200]}"
    measured = scene.variant(**settings, name=name_after(scene.name, path), description=description)
    cells = [(row.name, row.number.value, row.number.se, row.number.unit, row.key, row.number.refused) for row in rows]
    columns = (
        Column("measured", lambda cell: cell[0]),
        Column("value ± error", _format_value),
        Column("sets", lambda cell: cell[4] if cell[4] in used else ""),
    )
    keyed = {f"scene.{key}": value for key, value in settings.items()}
    return LabReport(
        name="calibration",
        title=path.name,
        tables=[Table("calibration", cells, COLUMNS, columns, "Plate")],
        facts={
            "measured": [dict(zip(COLUMNS, cell, strict=True)) for cell in cells],
            "settings": keyed,
            "notes": notes,
        },
        lines=notes,
        folder=folder,
        design=setup.design,
        scene=measured,
        settings=keyed,
        notes=notes,
    )


def _scene_settings(rows: list[Row], notes: list[str]) -> tuple[dict[str, Any], set[str]]:
    """Return the values of the scene's keys that rows set, and the keys of the rows used. Adds to `notes`.

    The key of a row for one entry of a pair has its number, as in "plate.horizontal_ratio[2]". The row after a number
    may hold its direction.
    """
    measured = {row.key: _round_to_six_digits(row.number) for row in rows if row.key and row.number.known}
    for key, least in MIN_SETTINGS.items():
        if measured.get(key, least) < least:
            measured = {
                name: measured[name] for name in measured if name not in (key, key.replace("ratio", "phase_deg"))
            }
            notes.append(f"{key} below {least:g} may be the phone's own, or moves no walker. It is not set")
    directions = {size.key: turn.number for size, turn in pairwise(rows) if turn.name.startswith("direction of")}
    settings: dict[str, Any] = {}
    for key, value in measured.items():
        name, _, number = key.rstrip("]").partition("[")
        if number:
            settings.setdefault(name, [0.0, 0.0])[int(number) - 1] = value
        elif key in directions:
            angle = math.radians(directions[key].number)
            settings[key] = [float(f"{value * part:.6g}") for part in (math.cos(angle), math.sin(angle))]
        else:
            settings[key] = value
    return settings, {*measured}


def _format_value(row: tuple[Any, ...]) -> str:
    """Format the value of a row of COLUMNS with its error and unit, or the reason for its absence."""
    _, value, se, unit, _, refused = row
    return str(refused) if refused else f"{formatting.format_with_error(value, se)} {unit}".strip()


def _round_to_six_digits(number: Quantity) -> float:
    return float(f"{number.pair[0]:.6g}")


def measure(recording: Recording, scene: Scene, source: str) -> tuple[list[Row], list[str]]:
    """Return rows with the quantities of the plate's motion, and notes. `source`: file name for InputError."""
    rate, expected = recording.rate, scene.drive.frequency
    if expected >= NYQUIST * rate:
        raise InputError(
            f"{source}: {rate:.0f} samples a second: the scene's drive of {expected:g} Hz is at least half of them, so "
            "another frequency would appear. Record faster, or set the drive: ‹set› scene.drive.frequency_hz=HZ"
        )
    upward, sideways, gravity = _resolve_axes(recording)
    frequency, error = _find_frequency(recording, upward, source)
    sines = _fit_sines(recording.times, upward, sideways, frequency)
    omega, size = 2.0 * math.pi * frequency, np.abs(sines.upward[:, 0])
    phase = sines.upward[:, 0] / size
    gravity_error = 0.0 if gravity is None else abs(gravity / GRAVITY - 1.0)
    amplitude = _mean_quantity("amplitude", "um", 1e3 * size / omega**2)
    if amplitude.value is not None and amplitude.se is not None:
        amplitude = amplitude._replace(se=math.hypot(amplitude.se, gravity_error * amplitude.value))
    rows = [
        Row("drive", Quantity("frequency", "hz", frequency, error, PIECES - 2.0), "drive.frequency_hz"),
        Row("amplitude", amplitude, "drive.amplitude_um"),
        Row("peak acceleration", _mean_quantity("gamma", "g", size / GRAVITY)),
    ]
    # upward is Re[Z exp(i omega t)] with Z = A omega^2 i exp(i phi), plus -4 r A omega^2 sin(2 phi + s)
    second = sines.upward[:, 1] * np.conj(-1j * phase) ** 2 / (4j * size)
    beyond = f"not measurable at {rate:.0f} samples a second: {2 * frequency:.4g} Hz would appear as another frequency"
    refused = "" if 2.0 * frequency < _max_frequency(rate) else beyond
    rows += _sine_rows(
        "second harmonic", second, "drive.second_harmonic_ratio", "drive.second_harmonic_phase_deg", refused
    )
    for number, (axis, waves) in enumerate(zip("xy", sines.sideways.T[:2], strict=True), start=1):
        keys = f"plate.horizontal_ratio[{number}]", f"plate.horizontal_phase_deg[{number}]"
        rows += _sine_rows(f"motion along the phone's {axis}", waves * np.conj(phase) / size, *keys, "")
    rows += _gradient_rows(sines.sideways[:, 2:], phase, size / omega)
    rows.append(
        Row("noise", _noise_ratio(sines.rest, recording, scene, omega, float(size.mean())), "plate.noise_ratio")
    )
    return rows, _notes(recording, frequency, gravity, scene)


def _notes(recording: Recording, frequency: float, gravity: float | None, scene: Scene) -> list[str]:
    """Return notes on the limits of the numbers. `gravity`: as recorded, mm/s^2. It is None if the app removed it."""
    rate, notes = (recording.rate, ["x of the scene, along the lane, is the x axis of the phone lying on its back"])
    if recording.linear:
        notes.append(
            "the app removed gravity: up is the axis that shakes most, and the harmonic's phase may be off by 180 deg"
        )
    if frequency > FILTERED_FREQUENCY_RATIO * rate:
        notes.append(f"{frequency:.4g} Hz at {rate:.0f} samples a second: the sensor's filter may lower amplitudes")
    if gravity is not None and abs(gravity / GRAVITY - 1.0) > 0.01:
        notes.append(f"gravity reads {1e-3 * gravity:.4g} m/s². The amplitude's error includes this difference")
    if abs(frequency / scene.drive.frequency - 1.0) > 0.05:
        notes.append(f"the scene had a drive of {scene.drive.frequency:g} Hz")
    return notes


def _gradient_rows(rates: Complex, unit: Complex, speed: Array) -> list[Row]:
    """Return gradient and rocking of the amplitude, from complex turning rates (rad/s) about x and y, (pieces, 2).

    `rates` is empty without a gyroscope. `unit`: the drive's phase factors, exp(i phase), (pieces,). `speed`: its peak
    speeds (mm/s). A plate turning at W rises at W_x y - W_y x.
    """
    refused = "" if rates.size else "it needs the gyroscope, because an accelerometer measures in one place"
    x, y = np.stack([-rates[:, 1], rates[:, 0]]) * 100j * np.conj(unit) / speed if rates.size else np.zeros((2, PIECES))
    rows = []
    for name, part in (("gradient", np.real), ("rocking", np.imag)):
        key = f"plate.{name}_percent_per_mm"
        rows += _sine_rows(name, part(x) + 1j * part(y), key, "", refused, "%/mm", "direction")
    return rows


def _resolve_axes(recording: Recording) -> tuple[Array, Array, float | None]:
    """Return accelerations (mm/s^2) upward, shape (n,), and along the plate, shape (n, 2) or (n, 4), and gravity.

    With four columns the last two are turning rates (rad/s) about these axes. Gravity is None if the app removed it.
    """
    mean = recording.felt.mean(axis=0)
    moved = recording.felt - mean
    if recording.linear:
        up, gravity = np.eye(3)[int(moved.var(axis=0).argmax())], None
    else:
        gravity = float(np.linalg.norm(mean))
        up = mean / gravity
    first = np.eye(3)[int(abs(up[0]) > SIDEWAYS_THRESHOLD)]
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    axes = np.column_stack([first, np.cross(up, first)])
    sideways = [moved @ axes] if recording.turned is None else [moved @ axes, recording.turned @ axes]
    return moved @ up, np.hstack(sideways), gravity


def _find_frequency(recording: Recording, upward: Array, source: str) -> tuple[float, float]:
    """Find the drive's frequency (Hz) and its error in accelerations `upward`, shape (n,). `source`: for messages."""
    times, rate = recording.times, recording.rate
    even = np.arange(0.0, times[-1], 1.0 / rate)
    power = np.abs(np.fft.rfft(np.interp(even, times, upward) * np.hanning(len(even)))) ** 2
    frequencies = np.fft.rfftfreq(len(even), 1.0 / rate)
    power[frequencies < PIECES * MIN_PERIODS / times[-1]] = 0.0
    peak = int(power.argmax())
    if not power[peak] > MIN_PEAK_RATIO * np.median(power[power > 0.0]):
        raise InputError(f"{source}: no drive frequency stands out. Record for half a minute while the plate shakes")
    half = int(np.abs(frequencies - 0.5 * frequencies[peak]).argmin())
    near = int(power[max(half - 2, 0) : half + 3].argmax()) + max(half - 2, 0)
    if power[near] > power[peak] / 16.0:  # a harmonic of a quarter of the amplitude shakes as much as the drive
        peak = near
    frequency, error = float(frequencies[peak]), math.inf
    for _ in range(4):
        amplitudes = _fit_sines(times, upward, np.zeros((len(times), 0)), frequency).upward[:, 0]
        middles = np.array([piece.mean() for piece in np.array_split(times, PIECES)])
        phases = np.unwrap(np.angle(amplitudes))
        (slope, _), covariance = np.polyfit(middles, phases, 1, cov=True)
        frequency += float(slope) / (2.0 * math.pi)
        error = math.sqrt(covariance[0, 0]) / (2.0 * math.pi)
    return frequency, error


def _fit_sines(times: Array, upward: Array, sideways: Array, frequency: float) -> Sines:
    """Fit sines at multiples of a frequency (Hz) in each piece. Shapes: `upward` (n,), `sideways` (n, columns)."""
    amplitudes, across, rest = [], [], []
    for piece in np.array_split(np.arange(len(times)), PIECES):
        phase = 2.0 * math.pi * frequency * times[piece][:, None] * np.arange(1, HARMONICS + 1)
        basis = np.column_stack([np.ones(len(piece)), np.cos(phase), -np.sin(phase)])
        found, *_ = np.linalg.lstsq(basis, np.column_stack([upward[piece], sideways[piece]]), rcond=None)
        waves = found[1 : HARMONICS + 1] + 1j * found[HARMONICS + 1 :]
        amplitudes.append(waves[:, 0])
        across.append(waves[0, 1:])
        rest.append(upward[piece] - basis @ found[:, 0])
    return Sines(np.array(amplitudes), np.array(across), np.concatenate(rest))


def _mean_quantity(key: str, unit: str, values: Array) -> Quantity:
    """Return a quantity named `key`: the mean of `values`, one for each piece, with its standard error."""
    return Quantity(
        key, unit, float(values.mean()), float(values.std(ddof=1)) / math.sqrt(len(values)), len(values) - 1.0
    )


def _sine_rows(
    name: str, waves: Complex, ratio_key: str, phase_key: str, refused: str, unit: str = "", angle_name: str = "phase"
) -> list[Row]:
    """Return two rows of a motion called `name` at the drive's frequency or a multiple: amplitude (`unit`) and angle.

    `waves`: complex amplitudes over the drive's, shape (pieces,). Both are refused for the reason `refused`, if any, or
    for an insignificant amplitude. `angle_name`: "phase" or "direction".
    """
    mean, root = complex(waves.mean()), math.sqrt(len(waves))
    rotated = waves * np.exp(-1j * np.angle(mean))
    along, across = (float(part.std(ddof=1)) / root for part in (rotated.real, rotated.imag))
    size, freedom = abs(mean), len(waves) - 1.0
    if not refused and size < MIN_SIGNIFICANCE * max(along, across):
        unit_name = unit or "of the drive's amplitude"
        refused = f"not distinguishable from 0: below {size + 2.0 * along:.2g} {unit_name} (95 %)"
    if refused:
        sizes = Quantity("ratio", unit, None, refused=refused)
        angles = Quantity(angle_name, "deg", None, refused=refused)
    else:
        sizes = Quantity("ratio", unit, size, along, freedom)
        angles = Quantity(angle_name, "deg", math.degrees(np.angle(mean)), math.degrees(across / size), freedom)
    return [Row(name, sizes, ratio_key), Row(f"{angle_name} of {name}", angles, phase_key)]


def _max_frequency(rate: float) -> float:
    """Return the highest frequency (Hz) of measurable noise, for a sampling rate (Hz)."""
    return USED_BANDWIDTH * NYQUIST * rate


def _noise_ratio(noise: Array, recording: Recording, scene: Scene, omega: float, acceleration: float) -> Quantity:
    """Return the r.m.s. velocity of `noise` (mm/s^2, shape (n,)) in the scene's band, over the drive's peak velocity.

    The drive's peak `acceleration` is in mm/s^2, and its angular frequency `omega` in rad/s.
    """
    low, high = scene.plate.noise_band_hz[0], min(scene.plate.noise_band_hz[1], _max_frequency(recording.rate))
    if not low < high:
        return Quantity("noise", "", None, refused=f"its band begins at {low:g} Hz, above all measurable frequencies")
    squares = []
    for piece, times in zip(np.array_split(noise, PIECES), np.array_split(recording.times, PIECES), strict=True):
        window = np.hanning(len(piece))
        frequencies = np.fft.rfftfreq(len(piece), float(np.diff(times).mean()))
        power = np.abs(np.fft.rfft(piece * window)) ** 2 * 2.0 / (len(piece) * (window**2).sum())
        band = (frequencies >= low) & (frequencies <= high)
        kept = 1.0 - HARMONICS / max(int(band.sum()), 2 * HARMONICS)  # of the band, once the sines are taken out
        squares.append(float((power[band] / (2.0 * math.pi * frequencies[band]) ** 2).sum()) / kept)
    square = _mean_quantity("noise", "", np.array(squares) * (omega / acceleration) ** 2)
    assert square.value is not None
    assert square.se is not None
    ratio = math.sqrt(square.value)
    return square._replace(value=ratio, se=0.5 * square.se / max(ratio, 1e-300))
