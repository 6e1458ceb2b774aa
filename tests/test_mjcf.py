"""Walkers for MuJoCo: its masses, its mobilities, its feet and its plate are ours."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.jobs.make.export import mjcf
from walkergen.scene import Scene
from walkergen.simulation.plan import prepare
from walkergen.simulation.space.walker import mobility
from walkergen.walker import solids
from walkergen.walker.design import Design

PAGE = Path(__file__).parent.parent / "docs" / "mujoco.md"
PAPER = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=10.0)
LANE, PLANE = (templates.load(name, "scenes", Scene) for name in ("lane-90hz", "plane-90hz"))
TEMPLATES = ("koumakis2016", "two-materials", "polar-disc", "unequal-legs", "bristle")
WALKERS = {name: templates.load(name, "walkers", Design) for name in TEMPLATES}
WALKERS["braced"] = PAPER.variant(kind="braced")


def loaded(design, scene, folder):
    """Model and data of MuJoCo, from the files of a walker."""
    for name, data in mjcf.files(design, scene):
        (folder / name).write_bytes(data)
    model = mujoco.MjModel.from_xml_path(str(next(folder.glob("*.xml"))))
    return model, mujoco.MjData(model)


def ours(design, scene):
    """Masses, walker without twist and drive of a design in a scene."""
    still = scene.effects.model_copy(update={"leg_twist": False})
    mass = solids.mass_of(design)
    plan = prepare(scene.model_copy(update={"effects": still}), design, mass)
    return mass, plan.world.walker, plan.world.drive


@pytest.mark.parametrize("name", WALKERS)
def test_masses_and_mobilities_are_ours(name, tmp_path):
    design = WALKERS[name]
    model, data = loaded(design, LANE, tmp_path)
    mass, walker, _ = ours(design, LANE)
    told = [float(mass.M), *(float(leg.m) for leg in mass.legs if leg.m > 0.0)]
    assert model.body_mass[2:].tolist() == pytest.approx(told, rel=1e-12)
    mujoco.mj_forward(model, data)
    assert data.subtree_com[2] == pytest.approx(data.xpos[2], abs=1e-12)  # C, of the whole
    rows = np.zeros((len(walker.leg), 3, model.nv))
    for k, place in enumerate(walker.place):
        geom = model.geom(f"corner{k}").id
        mujoco.mj_jacGeom(model, data, rows[k], None, geom)
        up, along, left = rows[k][[2, 0, 1]]
        rows[k] = (-left, along, up) if place > 0.0 else (up, along, -left)
    rows = rows.reshape(-1, model.nv)
    moved = np.zeros_like(rows)
    mujoco.mj_solveM(model, data, moved, rows)
    H = mobility(walker)
    # The spheres' middles are a micrometre off the corners
    np.testing.assert_allclose(rows @ moved.T, H, rtol=0, atol=1e-3 * abs(H).max())


@pytest.mark.parametrize("name", WALKERS)
def test_feet_are_springs_and_dampers_in_physical_units(name, tmp_path):
    design = WALKERS[name]
    model, data = loaded(design, PLANE, tmp_path)
    _, walker, drive = ours(design, PLANE)
    depth, fall = 2e-4, 5.0
    feet = np.flatnonzero(walker.place == 0.0)
    data.qpos[3] -= drive.amplitude + depth  # it begins an amplitude over the plate
    data.qvel[3] = -fall
    mujoco.mj_forward(model, data)
    pressed = np.zeros((data.ncon, 6))
    for number in range(data.ncon):
        mujoco.mj_contactForce(model, data, number, pressed[number])
    deep = -data.contact.dist  # a leg may be some 10 nm short
    assert deep == pytest.approx(depth, abs=5e-5)
    expected = walker.spring[feet, 0] * deep + walker.damper[feet] * fall
    # 0.1 %: MuJoCo's impedance is not quite 0, so that feet have a little mass
    assert pressed[:, 0] == pytest.approx(expected, rel=1e-3)


def test_the_plate_swings_as_ours_and_throws_nothing_off_time(tmp_path):
    model, data = loaded(PAPER, LANE, tmp_path)
    drive = LANE.drive
    period = round(2.0 * math.pi / drive.omega / model.opt.timestep)
    assert period * model.opt.timestep == pytest.approx(2.0 * math.pi / drive.omega, rel=1e-12)
    for _ in range(3):
        mujoco.mj_step(model, data, period // 3)
        height = drive.amplitude + data.qpos[0]
        assert height == pytest.approx(drive.amplitude * math.cos(drive.omega * data.time), abs=1e-3 * drive.amplitude)
    assert (model.body_gravcomp[1], model.opt.gravity[2]) == (1.0, -9806.65)


@pytest.mark.parametrize(
    ("key", "told"),
    [
        ("plate.slope_deg=2", "plate slope .*scene.effects.plate_slope=false"),
        ("drive.second_harmonic_ratio=0.1", "second harmonic"),
        ("feet.damping=hysteretic", "viscous feet only"),
        ("effects.roll_and_yaw=false", "free to turn"),
        ("legs.model=compliant", "the model 'space'"),
    ],
)
def test_what_the_file_cannot_hold_is_refused_and_nothing_is_written(key, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    error = CliRunner().invoke(command_line, ["export", "--format", "mjcf", "--set", f"scene.{key}"])
    assert isinstance(error.exception, InputError)
    assert re.search(told, str(error.exception))
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_the_same_bytes_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["export", "--tilt", "10", "--format", "mjcf", "--quiet", "--out"]
    for out in ("once", "again"):
        assert CliRunner().invoke(command_line, [*words, out]).exit_code == 0
    once = {path.name: path.read_bytes() for path in Path("once/mjcf").iterdir()}
    assert {path.suffix for path in Path("once/mjcf").iterdir()} == {".xml", ".stl"}
    assert once == {path.name: path.read_bytes() for path in Path("again/mjcf").iterdir()}
    lone = CliRunner().invoke(command_line, ["export", "--scene", "lane-90hz"]).exception
    assert str(lone) == "--scene lane-90hz: only --format mjcf has a scene"


@pytest.mark.nightly
def test_the_page_runs_and_the_walker_as_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = PAGE.read_text(encoding="utf-8")
    command = re.search(r"^walkergen (export .*?) +#", page, re.MULTILINE)[1]
    assert CliRunner().invoke(command_line, command.split()).exit_code == 0
    capsys.readouterr()
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], {})
    speed = float(capsys.readouterr().out.split()[0])
    told = re.search(r"^\| 10 deg \|.*?\|.*?\| ([\d.]+) ± ([\d.]+) \|", page, re.MULTILINE)
    mean, error = map(float, told.groups())
    assert speed == pytest.approx(mean, abs=4.0 * error * math.sqrt(4))  # one run of four
