"""`python -m evidence example-data`: the same archive twice, with its licence; its commands find what it says."""

import io
import json
import re
import shlex
import zipfile

import numpy as np
import pytest
from typer.testing import CliRunner

import walkergen as wg
from evidence.commands import commands
from evidence.example_data import make
from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.cli import command_line
from walkergen.core.scene import Scene
from walkergen.files import templates

FILES = {
    *("README.md", "LICENSE", "walker.toml", "scene.toml", "card.json", "expected.json"),
    *("film/tracks.csv", "film/tracks.nc", "plate/acceleration.csv"),
}


def test_the_true_motion_of_the_plate_is_found(tmp_path):
    scene = templates.load(make.SCENE, "scenes", Scene)
    (tmp_path / "acceleration.csv").write_text(make.plate_table(scene, 10.0))
    plate = wg.calibrate(plate=tmp_path / "acceleration.csv", pictures=False)
    found = {row["quantity"]: (row["value"], row["se"]) for row in plate.facts["measured"]}
    truth = make.true_numbers(scene)
    for name, key in (("drive", "drive_hz"), ("amplitude", "amplitude_um"), ("second harmonic", "second_harmonic")):
        value, error = found[name]
        assert abs(value - truth[key]) < 4.0 * error + 1e-6 * truth[key]  # the truth has six digits


def test_an_archive_is_the_same_bytes_for_the_same_files():
    files = {"a.txt": b"one", "b/c.txt": b"two"}
    assert make.zip_files(files) == make.zip_files(dict(files))
    with zipfile.ZipFile(io.BytesIO(make.zip_files(files))) as archive:
        assert archive.namelist() == [f"{make.NAME}/a.txt", f"{make.NAME}/b/c.txt"]


@pytest.mark.slow
def test_two_archives_are_equal_and_hold_the_listed_files(tmp_path, monkeypatch):
    written = []
    for name in ("one", "two"):
        run = CliRunner().invoke(commands, ["example-data", "--quick", "--quiet", "--out", str(tmp_path / name)])
        assert run.exit_code == 0, run.output
        written.append((tmp_path / name / f"{make.NAME}.zip").read_bytes())
    assert written[0] == written[1]
    with zipfile.ZipFile(io.BytesIO(written[0])) as archive:
        archive.extractall(tmp_path)
    folder = tmp_path / make.NAME
    assert {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()} == FILES
    assert "CC0 1.0 Universal" in (folder / "LICENSE").read_text()
    expected = json.loads((folder / "expected.json").read_text())
    assert expected == make.find_numbers(folder) | {"put in": expected["put in"]}
    camera = Units(fps=make.FPS, mm_per_px=make.MM_PER_PX, y_down=True)
    films = [
        track_files.read_tracks(folder / "film" / name, units)
        for name, units in (("tracks.csv", camera), ("tracks.nc", Units()))
    ]
    for seen, true in zip(films[0].tracks, films[1].tracks, strict=True):
        middle = make.MIDDLE_PX * make.MM_PER_PX * np.array([1.0, -1.0])
        off = (seen.position - middle - true.position) / make.MM_PER_PX
        assert np.std(off) == pytest.approx(make.NOISE_PX, rel=0.2)
        np.testing.assert_allclose(seen.heading, true.heading, atol=1e-4)
    monkeypatch.chdir(folder)
    asked = re.search(r"```sh\n(.*?)```", (folder / "README.md").read_text(), re.DOTALL)[1]
    for line in asked.splitlines():
        run = CliRunner().invoke(command_line, [*shlex.split(line)[1:], "--quiet"])
        assert run.exit_code == 0, (line, run.output)
