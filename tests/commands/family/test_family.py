"""The main job's folder: what is in it, equal bytes, interruption, leftovers."""

import hashlib
import json

import numpy as np
import pytest
import trimesh
from command_checks import rows_of
from test_cli import COLUMNS

from walkergen.commands.family.request import FamilyRequest
from walkergen.core.errors import OutputError, PlateError
from walkergen.core.files import ledger, output
from walkergen.core.printing import export
from walkergen.core.walker import names
from walkergen.core.walker.design import Design


def silent(what, done, total):
    assert done <= total


def make_family(out, progress=silent, **values):
    """Make a family without warnings, and return its report."""
    start = {"scene": "lane-90hz", "tilt": [0.0, 10.0, 35.0], "pictures": False, "out": out}
    report = FamilyRequest.from_values(start | values).run(progress)
    assert not report.warnings
    return report


def files_of(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def test_the_folder_holds_what_the_readme_says(tmp_path):
    make_family(tmp_path, pictures=True)
    assert files_of(tmp_path) == sorted(
        [f"stl/walker_t{t}_{kind}.stl" for t in ("00.0", "10.0", "35.0") for kind in ("flexible_s0.40", "braced_s1.00")]
        + [f"plates/family_prusa-mk3s{end}" for end in ("_1.3mf", "_1.png", ".csv", ".md")]
        + [f"plates/family_prusa-mk3s{end}" for end in (".ini", "_print.ini", "_orca.json")]
        + ["family.csv", "family.md", "weights.csv", "manifest.json"]
        + ["speed.csv", "speed.png", "speed.pdf", "preview.png"]
    )
    for png in ("speed.png", "preview.png"):
        assert (tmp_path / png).read_bytes().startswith(b"\x89PNG")


def test_stl_files_are_closed_and_of_the_right_volume(tmp_path):
    made = make_family(tmp_path)
    for member in made.members:
        mesh = trimesh.load(tmp_path / "stl" / f"{member.name}.stl")
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        # Coordinates of 14 mm in single precision are good to 1e-6 mm; legs are 0.4 mm thick.
        density = 1e-3 * member.design.material.density_g_cm3
        legs = 0.0 if member.row.m_g is None else 2 * member.row.m_g
        assert mesh.volume * density == pytest.approx(member.row.M_g + legs, rel=1e-5)


def test_csv_rows_are_the_predictions(tmp_path):
    made = make_family(tmp_path).members
    rows = rows_of(tmp_path / "family.csv")
    assert len(rows) == len(made) == 6
    assert list(rows[0]) == COLUMNS
    for row, member in zip(rows, made, strict=True):
        assert float(row["speed_mm_s"]) == member.row.speed.value
        assert (row["m_g"] == "") == (member.row.m_g is None)


def test_manifest_lists_every_file_with_its_hash(tmp_path):
    make_family(tmp_path, pictures=True)
    manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
    ours = [name for name in files_of(tmp_path) if name not in ("manifest.json", "weights.csv")]
    assert sorted(manifest["files"]) == ours  # the form of masses is theirs to fill in
    for name, digest in manifest["files"].items():
        assert hashlib.sha256((tmp_path / name).read_bytes()).hexdigest() == digest
    assert manifest["design"]["legs"]["length_mm"] == 7.5
    assert manifest["scene"]["contact"]["friction"] == 0.25
    assert manifest["versions"]["walkergen"]
    assert manifest["time_taken_s"] > 0


@pytest.mark.slow
def test_equal_input_gives_equal_bytes(tmp_path):
    for folder in ("one", "two"):
        make_family(tmp_path / folder, pictures=True)
    one, two = (json.loads((tmp_path / f / "manifest.json").read_text()) for f in ("one", "two"))
    assert one["files"] == two["files"]


def test_interruption_keeps_finished_files_whole_and_a_second_run_completes(tmp_path, monkeypatch):
    written, stl_bytes = [], export.stl_bytes

    def interrupt(mesh, name):
        if len(written) == 3:
            raise KeyboardInterrupt
        written.append(name)
        return stl_bytes(mesh, name)

    monkeypatch.setattr(export, "stl_bytes", interrupt)
    with pytest.raises(KeyboardInterrupt):
        make_family(tmp_path)
    monkeypatch.setattr(export, "stl_bytes", stl_bytes)
    finished = [name for name in files_of(tmp_path) if not name.startswith(".")]
    assert len(finished) == 3
    for name in finished:
        assert trimesh.load(tmp_path / name).is_watertight
    make_family(tmp_path)
    assert len(files_of(tmp_path)) == 6 + 10


def test_output_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(OutputError, match="cannot be written") as caught:
        make_family(tmp_path / "file")
    assert len(str(caught.value).splitlines()) == 1


def test_leftovers_of_an_earlier_run_are_removed_unless_changed(tmp_path):
    make_family(tmp_path, tilt=(0.0, 5.0, 10.0), legs=["flexible"])
    edited = tmp_path / "stl" / "walker_t05.0_flexible_s0.40.stl"
    edited.write_bytes(b"mine now")
    (tmp_path / "notes.txt").write_text("the user's")
    make_family(tmp_path, tilt=(10.0,), legs=["flexible"])
    kept = files_of(tmp_path)
    assert "notes.txt" in kept
    assert "stl/walker_t05.0_flexible_s0.40.stl" in kept
    assert "stl/walker_t00.0_flexible_s0.40.stl" not in kept


def test_a_forged_manifest_removes_nothing_outside(tmp_path):
    victim = tmp_path / "victim.txt"
    victim.write_bytes(b"precious")
    digest = hashlib.sha256(b"precious").hexdigest()
    folder = tmp_path / "out"
    for forged in ({"../victim.txt": digest}, {str(victim): digest}):
        for data in (json.dumps({"files": forged}).encode(), ledger.encode_manifest({"files": forged})):
            output.write(folder / "manifest.json", data)
            with pytest.raises(OutputError, match="all files there are left alone"):
                make_family(folder, tilt=(10.0,), legs=["flexible"])
            assert victim.read_bytes() == b"precious"
            assert files_of(folder) == ["manifest.json"]


def test_names_are_unique_whatever_the_tilts():
    tilts = [0.0, 1e-12, 0.05, 0.1, 10.0, 10.05, -10.0, *np.linspace(20, 21, 50)]
    members = Design().members(tilts)
    assert len({names.part_name(member) for member in members}) == len(members)
    assert names.part_name(members[4]) == "walker_t10.0_flexible_s0.40"
    assert all("e" not in names.part_name(m).split("_")[1] for m in members)


def test_a_part_too_large_for_the_printer_is_refused_before_anything_is_written(tmp_path):
    large = Design.model_validate({"body": {"length_mm": 300.0}})
    with pytest.raises(PlateError, match="does not fit prusa-mk3s"):
        make_family(tmp_path / "out", design=large, tilt=0.0)
    assert not (tmp_path / "out").exists()


def test_walkers_that_stand_are_one_line_and_the_mass_is_a_balances(tmp_path):
    report = make_family(tmp_path)
    text = report.markdown()
    assert "braced legs, 0 to 35 deg: 3 walkers of 0.982 to 1.03 g stand still" in text
    assert text.index("0.8928") < text.index("0.8333")  # M + 2 m before M
    assert len(report.tables[0]) == 6


def test_no_walker_is_compared_with_another(tmp_path, monkeypatch):
    """Of n walkers that would be n^2 comparisons of designs and meshes."""

    def compared(*_):
        raise AssertionError("two designs are compared")

    monkeypatch.setattr(Design, "__eq__", compared)
    assert make_family(tmp_path).members
