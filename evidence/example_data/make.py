"""Archive of example data: a film, a recording of the plate and a card of a known walker, and what is found in them."""

import io
import json
import math
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import walkergen as wg
from walkergen import __version__
from walkergen.core.files import formatting
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.scene import GRAVITY, Scene
from walkergen.files import report, templates
from walkergen.files.report import Report, Table

HERE = Path(__file__).parent
NAME = "walkergen-example-data"
"""Name of the archive, and of the folder in it."""

WALKER, SCENE = "koumakis2016", "plane-90hz"

FPS, MM_PER_PX, MIDDLE_PX, NOISE_PX = 25.0, 0.25, 500.0, 0.1
"""The camera: frames a second, its scale, its middle, and the error of a place, pixels."""

RATE_HZ, HARMONIC, HARMONIC_DEG, PHONE_NOISE_MM_S2 = 500.0, 0.02, 40.0, 20.0
"""The phone: samples a second; the plate's second harmonic with its phase; noise of the phone, mm/s^2."""

FILM_NUMBERS = {"speed": "mm_s", "turning_bias": "rad_s", "rotational_diffusion": "rad2_s"}
"""Numbers expected from the film, with their units; short films leave some out."""

DATE = (1980, 1, 1, 0, 0, 0)
"""Date of everything in the archive: the earliest that one can have."""


class Size(NamedTuple):
    """How much is simulated."""

    runs: int
    seconds: float
    """Length of a run, s."""
    record_s: float
    """Length of the phone's recording, s."""


FULL, QUICK = Size(4, 24.0, 20.0), Size(4, 3.0, 5.0)


class Row(NamedTuple):
    """File of the archive."""

    file: str
    bytes: int


def make_archive(size: Size, folder: Path, progress: Progress) -> Report:
    """Write the archive of example data into a folder."""
    with tempfile.TemporaryDirectory() as place:
        files = dict(sorted(_make_files(size, Path(place), progress).items()))
    rows = [Row(name, len(data)) for name, data in files.items()]
    columns = [report.text_column("file", "file"), report.number_column("bytes", "bytes", 9)]
    table = report.table_from_rows("files", rows, columns, f"{NAME}.zip")
    with Folder(folder, "") as target:
        target.write(f"{NAME}.zip", zip_files(files))
        made = [str(folder / f"{NAME}.zip")]
    return Report(name="example-data", title="Example data", tables=[table], facts={"files": made}, folder=folder)


def zip_files(files: Mapping[str, bytes]) -> bytes:
    """Archive of files, the same bytes for the same files."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as held:
        for name, data in files.items():
            entry = zipfile.ZipInfo(f"{NAME}/{name}", DATE)
            entry.compress_type, entry.external_attr, entry.create_system = zipfile.ZIP_DEFLATED, 0o644 << 16, 3
            held.writestr(entry, data)
    return stream.getvalue()


def _make_files(size: Size, place: Path, progress: Progress) -> dict[str, bytes]:
    """Contents of the archive, by the names of its files; what commands read and write is in `place`."""
    scene = templates.load(SCENE, "scenes", Scene)
    sources = {
        "walker.toml": templates.resolve_path(WALKER, "walkers"),
        "scene.toml": templates.resolve_path(SCENE, "scenes"),
    }
    held = {name: path.read_bytes() for name, path in sources.items()}
    progress("runs", 1, 4)
    nc = place / "tracks.nc"
    runs = wg.simulate(WALKER, SCENE, seconds=size.seconds, runs=size.runs, trajectory=nc, rate_hz=FPS)
    held["film/tracks.nc"] = nc.read_bytes()
    held["film/tracks.csv"] = film_table(runs.trajectory(rate_hz=FPS)).encode()
    held["plate/acceleration.csv"] = plate_table(scene, size.record_s).encode()
    progress("card", 2, 4)
    wg.crowd(WALKER, SCENE, card=True, seconds=size.seconds, runs=size.runs, pictures=False, out=place / "card")
    held["card.json"] = (place / "card" / "card.json").read_bytes()
    progress("what is found", 3, 4)
    for name, data in held.items():
        (place / name).parent.mkdir(exist_ok=True)
        (place / name).write_bytes(data)
    expected = find_numbers(place)
    held["expected.json"] = (json.dumps(expected | {"put in": true_numbers(scene)}, indent=1) + "\n").encode()
    held["LICENSE"] = (HERE / "LICENSE").read_bytes()
    held["README.md"] = _readme_text(size, expected).encode()
    progress("archive", 4, 4)
    return held


def film_table(runs: Table) -> str:
    """Table of a tracker: places and headings of runs in a picture, whose rows go down, each with its error."""
    rng = np.random.default_rng(1)
    x, y = (MIDDLE_PX + way * runs[name] / MM_PER_PX for name, way in (("x", 1.0), ("y", -1.0)))
    places = np.stack([x, y], axis=1) + rng.normal(0.0, NOISE_PX, (len(x), 2))
    columns = zip(runs["frame"], runs["particle"], *places.T, -runs["theta"], strict=True)
    rows = (f"{int(frame)},{int(who)},{x:.3f},{y:.3f},{theta:.4f}\n" for frame, who, x, y, theta in columns)
    return "frame,particle,x,y,theta\n" + "".join(rows)


def plate_table(scene: Scene, seconds: float) -> str:
    """Table of a phone on its back on the plate: the drive with its second harmonic, gravity, and the phone's noise."""
    times = np.arange(round(RATE_HZ * seconds)) / RATE_HZ
    angle = 2.0 * math.pi * true_numbers(scene)["drive_hz"] * times
    harmonic = 4.0 * HARMONIC * np.sin(2.0 * angle + math.radians(HARMONIC_DEG))
    up = GRAVITY - _peak_acceleration(scene) * (np.sin(angle) + harmonic)
    noise = np.random.default_rng(2).normal(0.0, PHONE_NOISE_MM_S2, (len(times), 3))
    felt = 1e-3 * (np.stack([0.0 * up, 0.0 * up, up], axis=1) + noise)
    rows = (f"{time:.3f},{x:.3f},{y:.3f},{z:.3f}\n" for time, (x, y, z) in zip(times, felt, strict=True))
    return ",".join(["Time (s)", *(f"Acceleration {axis} (m/s^2)" for axis in "xyz")]) + "\n" + "".join(rows)


def _peak_acceleration(scene: Scene) -> float:
    """Peak acceleration of the plate, mm/s^2, of its first harmonic."""
    assert scene.drive.gamma is not None
    return scene.drive.gamma * GRAVITY


def true_numbers(scene: Scene) -> dict[str, float]:
    """Truth of the plate's recording."""
    frequency = scene.drive.frequency_hz
    assert frequency is not None
    amplitude = 1e3 * _peak_acceleration(scene) / (2.0 * math.pi * frequency) ** 2
    truth = {"drive_hz": frequency, "amplitude_um": amplitude, "second_harmonic": HARMONIC}
    return {name: round_number(value) for name, value in truth.items()}


def find_numbers(place: Path) -> dict[str, Any]:
    """Return the main numbers that the README's commands find in the files of a folder."""
    speed = wg.predict(str(place / "walker.toml"), str(place / "scene.toml")).speed
    bounds = speed.interval() or ()
    film = wg.analyse(place / "film/tracks.csv", fps=FPS, mm_per_px=MM_PER_PX, y_down=True, pictures=False)
    plate = wg.calibrate(plate=place / "plate/acceleration.csv", pictures=False)
    return {
        "predict": {
            f"{name}_mm_s": round_number(value)
            for name, value in zip(("speed", "low_95", "high_95"), (speed.number, *bounds), strict=True)
        },
        "analyse": {
            f"{name}_{unit}": [
                round_number(film.facts[f"{name}_{unit}"]),
                round_number(film.facts[f"{name}_se_{unit}"]),
            ]
            for name, unit in FILM_NUMBERS.items()
            if film.facts[f"{name}_{unit}"] is not None  # short films leave some open
        },
        "calibrate": {
            row["quantity"]: [round_number(row["value"]), round_number(row["se"])]
            for row in plate.facts["measured"]
            if row["value"] is not None
        },
    }


def round_number(value: float) -> float:
    """Round a number to six digits, so that another machine finds the same."""
    return float(f"{value:.6g}")


def _readme_text(size: Size, expected: Mapping[str, Any]) -> str:
    """README of the archive."""
    text = (HERE / "README.md").read_text(encoding="utf-8")
    lines = (f"- `{command}`: {_describe_numbers(numbers)}" for command, numbers in expected.items())
    return text.format(
        version=__version__,
        runs=size.runs,
        seconds=formatting.format_number(size.seconds),
        record_s=formatting.format_number(size.record_s),
        fps=formatting.format_number(FPS),
        rate_hz=formatting.format_number(RATE_HZ),
        mm_per_px=MM_PER_PX,
        noise_px=NOISE_PX,
        found="\n".join(lines),
    )


def _describe_numbers(numbers: Mapping[str, Any]) -> str:
    def format_number(name: str, number: Any) -> str:
        value, error = number if isinstance(number, list) else (number, None)
        shown = formatting.format_number(value, 4)
        return f"{name} {shown}" + (f" ± {formatting.format_number(error, 2)}" if error else "")

    return ", ".join(format_number(name, number) for name, number in numbers.items())
