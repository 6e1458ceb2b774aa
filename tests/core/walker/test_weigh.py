"""`walkergen check FILE --weigh`: closed forms, a tensor of fifty digits, trimesh; refusals as for a body."""

import json
import re

import hostile_meshes as hostile
import mpmath
import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.commands.check import weighing as make
from walkergen.core.errors import InputError
from walkergen.core.printing import export
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

DUCK = hostile.duck()
STL_ROUNDING = 1e-6  # relative: STL keeps 24 bits of a coordinate


def prism(sides, radius, height):
    """Prism over a regular polygon, about z, exact in 64 bits."""
    import manifold3d

    angles = 2.0 * np.pi * np.arange(sides) / sides
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    section = manifold3d.CrossSection([outline])
    return modeller.to_mesh(manifold3d.Manifold.extrude(section, height))


def test_a_box_against_its_closed_form(tmp_path):
    mesh = hostile.box(20.0, 6.0, 8.0, middle=(3.0, -2.0, 7.0))
    found = make.weigh(hostile.to_stl(tmp_path / "box.stl", mesh), 2.0, 1.0).total
    m = 960.0 * 2e-3
    assert (found.volume_mm3, found.mass_g) == pytest.approx((960.0, m), rel=1e-12)
    np.testing.assert_allclose(found.centre_mm, (3.0, -2.0, 7.0), atol=1e-12)
    squares = np.array([6.0**2 + 8.0**2, 20.0**2 + 8.0**2, 20.0**2 + 6.0**2])
    np.testing.assert_allclose(found.tensor_g_mm2, np.diag(m * squares / 12.0), atol=1e-10)
    np.testing.assert_allclose(found.moments_g_mm2, np.sort(m * squares / 12.0), rtol=1e-12)
    np.testing.assert_allclose(found.axes, np.eye(3)[[0, 2, 1]] * [[1], [1], [-1]], atol=1e-12)


@pytest.mark.parametrize("sides", [3, 6, 64])
def test_a_prism_against_its_closed_form(tmp_path, sides):
    """Regular polygon of n corners at R: area n R^2 sin(2a) / 2, J = m R^2 (2 + cos(2a)) / 6."""
    radius, height = 5.0, 4.0
    mesh = prism(sides, radius, height)
    found = make.weigh(hostile.to_stl(tmp_path / "prism.stl", mesh), 1.0, 1.0).total
    angle = 2.0 * np.pi / sides
    m = 0.5 * sides * radius**2 * np.sin(angle) * height * 1e-3
    polar = m * radius**2 * (2.0 + np.cos(angle)) / 6.0
    assert found.mass_g == pytest.approx(m, rel=STL_ROUNDING)
    expected = [polar / 2 + m * height**2 / 12] * 2 + [polar]
    np.testing.assert_allclose(np.diag(found.tensor_g_mm2), expected, rtol=STL_ROUNDING)


def test_fifty_digits_of_a_skew_prism(tmp_path):
    """Rival: the same corners, as the file keeps them, by exact moments in 50 digits."""
    mesh = prism(7, 3.0, 5.0)
    rng = np.random.default_rng(3)
    skew = rng.normal(size=(3, 3))
    skew *= np.sign(np.linalg.det(skew))
    mesh = Mesh((mesh.vertices @ skew.T + (30.0, -40.0, 55.0)).astype("<f4") + 0.0, mesh.triangles)
    found = make.weigh(hostile.to_stl(tmp_path / "skew.stl", mesh), 1.24, 1.0).total
    mass_g, centre, tensor = exact_moments(mesh, 1.24e-3)
    assert found.mass_g == pytest.approx(mass_g, rel=1e-13)
    np.testing.assert_allclose(found.centre_mm, centre, rtol=1e-13)
    np.testing.assert_allclose(found.tensor_g_mm2, tensor, atol=1e-12 * np.abs(tensor).max())
    turned = found.axes @ found.tensor_g_mm2 @ found.axes.T
    np.testing.assert_allclose(turned, np.diag(found.moments_g_mm2), atol=1e-11 * turned.max())
    assert np.linalg.det(found.axes) == pytest.approx(1.0, rel=1e-12)


def exact_moments(mesh, density):
    """Mass, centre and tensor by Simplex moments in 50 digits, from the coordinates' origin."""
    with mpmath.workdps(50):
        zero = mpmath.mpf(0)
        volume, first = zero, [zero] * 3
        second = [[zero] * 3 for _ in range(3)]
        for triangle in mesh.triangles:
            p = [[mpmath.mpf(float(value)) for value in mesh.vertices[i]] for i in triangle]
            six = mpmath.det(mpmath.matrix(p))
            volume += six / 6
            for i in range(3):
                first[i] += six * (p[0][i] + p[1][i] + p[2][i]) / 24
                for j in range(3):
                    both = sum(p[k][i] * p[n][j] for k in range(3) for n in range(3))
                    same = sum(p[k][i] * p[k][j] for k in range(3))
                    second[i][j] += six * (both + same) / 120
        centre = [value / volume for value in first]
        tensor = np.zeros((3, 3))
        moved = [[second[i][j] - volume * centre[i] * centre[j] for j in range(3)] for i in range(3)]
        trace = moved[0][0] + moved[1][1] + moved[2][2]
        for i in range(3):
            for j in range(3):
                tensor[i, j] = float(density * ((trace if i == j else 0) - moved[i][j]))
        return float(density * volume), [float(value) for value in centre], tensor


def test_trimesh_agrees(tmp_path):
    """Rival: another library's reading and weighing of the same file."""
    path = hostile.to_stl(tmp_path / "duck.stl", DUCK)
    found, other = make.weigh(path, 1.0, 1.0).total, trimesh.load_mesh(path)
    other.density = 1e-3
    assert found.volume_mm3 == pytest.approx(other.volume, rel=1e-12)
    np.testing.assert_allclose(found.centre_mm, other.center_mass, atol=1e-11)
    np.testing.assert_allclose(found.tensor_g_mm2, other.moment_inertia, atol=1e-10)
    np.testing.assert_allclose(found.moments_g_mm2, other.principal_inertia_components, rtol=1e-10)


def test_a_plate_weighs_each_item_and_the_total(tmp_path):
    """Items of one solid with one part number, which trimesh's reader would take for one."""
    built = [solids.build(Design().variant(tilt_deg=tilt)).walker for tilt in (10.0, 30.0)]
    items = [export.Item(0, "a", 5.0, 5.0), export.Item(0, "a", 50.0, 5.0), export.Item(1, "b", 5.0, 60.0)]
    shapes = [export.Solid("ten", built[0]), export.Solid("thirty", built[1])]
    path = tmp_path / "plate.3mf"
    path.write_bytes(export.threemf_bytes(shapes, items, "plate"))
    found = make.weigh(path, 1.24, 1.0)
    assert [part.name for part in found.parts] == ["a", "a", "b"]
    single = 1.24e-3 * (28 * 8 * 3 + 2 * 7.5 * 0.4 * 8)
    assert [part.mass_g for part in found.parts] == pytest.approx([single] * 3, rel=STL_ROUNDING)
    assert found.total.mass_g == pytest.approx(3 * single, rel=STL_ROUNDING)
    np.testing.assert_allclose(found.parts[1].centre_mm - found.parts[0].centre_mm, (45.0, 0, 0), atol=1e-4)
    # Rival for Steiner's theorem: all the surfaces weighed as one mesh about one origin
    from walkergen.core.walker import mass
    from walkergen.readers.meshes import meshes

    parts = meshes.read_mesh(path, "plate").parts
    whole = mass.weigh(hostile.together(*(Mesh(p.vertices, p.triangles) for p in parts)), 1.24e-3)
    np.testing.assert_allclose(found.total.tensor_g_mm2, whole.tensor, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(found.total.centre_mm, whole.centre, rtol=1e-12)


UNITS = {"MicroMeter": 1e-3, "MilliMeter": 1.0, "CentiMeter": 10.0, "Inch": 25.4, "Foot": 304.8, "Meter": 1000.0}


@pytest.mark.parametrize("unit", UNITS)
def test_a_3mf_names_its_unit(tmp_path, unit):
    import lib3mf

    model = lib3mf.get_wrapper().CreateModel()
    model.SetUnit(getattr(lib3mf.ModelUnit, unit))
    wrapper = lib3mf.get_wrapper()
    given = hostile.box(2.0, 2.0, 2.0)
    added = model.AddMeshObject()
    added.SetGeometry(
        [lib3mf.Position(tuple(map(float, row))) for row in given.vertices],
        [lib3mf.Triangle(tuple(map(int, row))) for row in given.triangles],
    )
    pair = model.AddComponentsObject()  # a component, mirrored and moved, is still outward
    mirror = wrapper.GetTranslationTransform(5.0, 0.0, 0.0)
    mirror.Fields[0][0] = -1.0
    pair.AddComponent(added, mirror)
    model.AddBuildItem(pair, wrapper.GetIdentityTransform())
    path = tmp_path / "unit.3mf"
    path.write_bytes(bytes(model.QueryWriter("3mf").WriteToBuffer()))
    found = make.weigh(path, 1.0, 1.0).total
    assert found.volume_mm3 == pytest.approx(8.0 * UNITS[unit] ** 3, rel=1e-6)
    np.testing.assert_allclose(found.centre_mm, (5.0 * UNITS[unit], 0.0, 0.0), atol=1e-6)


def test_scale_and_density_enter_as_powers(tmp_path):
    path = hostile.to_stl(tmp_path / "duck.stl", DUCK)
    one, other = make.weigh(path, 1.0, 1.0).total, make.weigh(path, 3.0, 25.4).total
    assert other.mass_g == pytest.approx(3.0 * 25.4**3 * one.mass_g, rel=1e-12)
    np.testing.assert_allclose(other.tensor_g_mm2, 3.0 * 25.4**5 * one.tensor_g_mm2, rtol=1e-10, atol=1e-2)


def test_the_command_prints_what_the_job_finds(tmp_path):
    path = hostile.to_stl(tmp_path / "box.stl", hostile.box())
    shown = CliRunner().invoke(command_line, ["check", str(path), "--weigh"], catch_exceptions=False)
    assert shown.exit_code == 0
    assert re.search(r"^ *mass +1\.1904 +g *$", shown.stdout, re.MULTILINE)
    words = ["check", str(path), "--weigh", "--density", "2", "--scale", "2", "--json"]
    told = json.loads(CliRunner().invoke(command_line, words, catch_exceptions=False).stdout)
    assert told["total"]["mass_g"] == pytest.approx(960.0 * 8.0 * 2e-3)
    assert told["parts"][0]["axes"] == [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    assert len(told["sha256"]) == 64


def test_unsound_meshes_and_senseless_numbers_are_refused(tmp_path):
    """What used to weigh -1.67 g and ran at 233 mm/s."""
    path = hostile.to_stl(tmp_path / "in.stl", hostile.invert_mesh(hostile.box()))
    with pytest.raises(InputError, match="inside out: its volume is -960"):
        make.weigh(path, 1.24, 1.0)
    with pytest.raises(InputError, match="no such file"):
        make.weigh(tmp_path / "none.stl", 1.24, 1.0)
    for flag, value in (("--density", "0"), ("--density", "nan"), ("--scale", "-1")):
        with pytest.raises(InputError, match=f"{flag} .*: must be a (finite )?number"):
            CliRunner().invoke(command_line, ["check", str(path), "--weigh", flag, value], catch_exceptions=False)
