"""Machines without lib3mf, such as Linux on ARM: plates are STL files, and writing 3MF is refused in a line."""

import subprocess
import sys

import numpy as np
import pytest

import walkergen as wg
from walkergen.core.errors import InputError
from walkergen.core.printing import packing, plates
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import threemf
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.readers.meshes import meshes

PAPER = templates.load("koumakis2016", "walkers", Design)
PRINTER = templates.load("prusa-mk3s", "printers", Printer)


@pytest.fixture
def missing(monkeypatch):
    monkeypatch.setattr(threemf, "is_available", lambda: False)


def arrange_plates(copies):
    members = [PAPER.variant(tilt_deg=tilt) for tilt in (5.0, 20.0)]
    built = [solids.build(member) for member in members]
    return plates.arrange(members, built, copies, PRINTER)


def volume(mesh):
    """Volume of a closed mesh, mm^3, by the divergence theorem."""
    corners = mesh.vertices[mesh.triangles]
    return float(np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6.0)


@pytest.mark.usefixtures("missing")
def test_plates_are_stl_files_with_every_copy_at_its_place(tmp_path):
    found = arrange_plates([2, 1])
    files = dict(plates.layout_files(found, "plate", draw=None))
    assert not [name for name in files if name.endswith(".3mf")]
    (name,) = [name for name in files if name.endswith(".stl")]
    assert f"`{name}`" in files[name.replace("_1.stl", ".md")].decode()
    path = tmp_path / name
    path.write_bytes(files[name])
    (part,) = meshes.read_mesh(path, name).parts
    parts = found.plates[0].placements
    assert len(parts) == 3
    volumes = [volume(found.built[one.part].walker) for one in parts]
    assert volume(part) == pytest.approx(sum(volumes), rel=1e-5)  # 32-bit floats
    left, front = PRINTER.bed_corner
    low = part.vertices.min(axis=0)
    assert low == pytest.approx(
        (left + min(one.x for one in parts), front + min(one.y for one in parts), 0.0), abs=2e-5
    )


def test_the_stl_has_the_parts_of_the_3mf():
    found = arrange_plates([1, 2])
    view = found.plates[0], found.meshes, PRINTER
    read = threemf.read_parts(packing.plate_3mf(view[0], found.parts, *view[1:], "one"), "one")
    ours = packing.plate_mesh(*view)
    theirs = np.concatenate([part.vertices for part in read])
    assert np.sort(ours.vertices, axis=0) == pytest.approx(np.sort(theirs, axis=0), abs=2e-5)
    assert len(ours.triangles) == sum(len(part.triangles) for part in read)


def test_3mf_is_read_without_it(monkeypatch):
    found = arrange_plates([1, 1])
    data = packing.plate_3mf(found.plates[0], found.parts, found.meshes, PRINTER, "one")
    monkeypatch.setattr(threemf, "is_available", lambda: False)
    assert len(threemf.read_parts(data, "one")) == 2


@pytest.mark.usefixtures("missing")
def test_commands_that_need_3mf_are_refused_in_a_line(tmp_path):
    for ask in (
        lambda: wg.export(PAPER, tmp_path / "one.3mf"),
        lambda: dict(plates.layout_files(arrange_plates([1, 1]), "plate", None, prusaslicer=True)),
    ):
        with pytest.raises(InputError, match=r"^3MF: lib3mf is not installed .* use STL") as told:
            ask()
        assert "\n" not in str(told.value)
    assert not list(tmp_path.iterdir())


def test_a_family_is_made_without_it(tmp_path):
    """In a process that cannot find the module."""
    script = (
        "import sys; sys.modules['lib3mf'] = None\n"
        "import importlib.util as u; found = u.find_spec\n"
        "u.find_spec = lambda name, *more: None if name == 'lib3mf' else found(name, *more)\n"
        "sys.argv = 'walkergen family koumakis2016 --tilt 10 --no-pictures'.split()\n"
        "from walkergen.cli import main; main()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    names = {path.suffix for path in (tmp_path / "out" / "koumakis2016" / "plates").iterdir()}
    assert names == {".stl", ".csv", ".md", ".ini", ".json"}
