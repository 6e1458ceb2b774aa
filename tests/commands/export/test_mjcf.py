"""Walkers for MuJoCo: its masses, its mobilities, its feet and its plate are ours."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.commands.export import mjcf
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.walker import mobility
from walkergen.core.theory.hertz import contact_modulus
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

DOCS = Path(__file__).parents[3] / "docs"
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


def plan_of(design, scene):
    """Plan of a design without twist in a scene."""
    still = scene.effects.force("leg_twist", False)
    return prepare(scene.model_copy(update={"effects": still}), design, solids.mass_of(design))


def ours(design, scene):
    """Masses, walker without twist and drive of a design in a scene."""
    plan = plan_of(design, scene)
    return plan.case.mass, plan.world.walker, plan.world.drive


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
    for k, place in enumerate(walker.wall_distance):
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
    plan = plan_of(design, PLANE)
    walker, drive, springs = plan.world.walker, plan.world.drive, mjcf.linear_springs(plan)
    depth, fall = 2e-3, 5.0
    feet = np.flatnonzero(walker.wall_distance == 0.0)
    data.qpos[3] -= drive.amplitude + depth  # it begins an amplitude over the plate
    data.qvel[3] = -fall
    mujoco.mj_forward(model, data)
    pressed = np.zeros((data.ncon, 6))
    for number in range(data.ncon):
        mujoco.mj_contactForce(model, data, number, pressed[number])
    deep = -data.contact.dist  # a leg may be some 10 nm short
    assert deep == pytest.approx(depth, abs=5e-5)
    expected = springs[feet] * deep + walker.damper[feet] * np.sqrt(springs[feet]) * fall
    # 0.1 %: MuJoCo's impedance is not quite 0, so that feet have a little mass
    assert pressed[:, 0] == pytest.approx(expected, rel=1e-3)


def test_linear_springs_are_those_of_equal_contact_time():
    """The closed form of the paper's walker, and both contact times by integration of the two laws."""
    plan = plan_of(PAPER, PLANE)
    walker, speed = plan.world.walker, 2.0 * plan.equivalent_drive.peak_speed
    (spring,) = set(mjcf.linear_springs(plan))
    (leg,), (tip,), mass = set(walker.spring), set(walker.tip), 0.25 * walker.mass
    alone = 1.0 / (1.0 / spring - 1.0 / leg)
    modulus, radius = contact_modulus(PLANE, PAPER.material), 1e-3 * PLANE.feet.tip_radius_um
    energy = walker.mass * plan.equivalent_drive.peak_speed**2
    assert alone == pytest.approx(1.20 * (modulus**4 * radius**2 * energy) ** 0.2, rel=1e-3)
    hertz = contact_time(lambda depth: tip * depth**1.5, mass, speed)
    linear = contact_time(lambda depth: alone * depth, mass, speed)
    assert hertz == pytest.approx(linear, rel=1e-4)


def test_rigid_tips_leave_the_springs_of_the_legs():
    rigid = PLANE.model_copy(update={"feet": PLANE.feet.model_copy(update={"rigid_tips": True})})
    plan = plan_of(PAPER, rigid)
    assert mjcf.linear_springs(plan).tolist() == pytest.approx(plan.world.walker.spring.tolist(), rel=1e-15)


@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_a_corner_of_the_file_rebounds_with_the_restitution(restitution):
    """The file's spring and damper under a corner's own mass, by integration."""
    contact = PLANE.contact.model_copy(update={"restitution": restitution})
    plan = plan_of(PAPER, PLANE.model_copy(update={"contact": contact}))
    walker, spring, mass = plan.world.walker, mjcf.linear_springs(plan)[0], 1.0 / mobility(plan.world.walker)[0, 0]
    damping = walker.damper[0] * math.sqrt(spring)
    step, depth, speed = 1e-3 * math.sqrt(mass / spring), 0.0, 1.0
    while (force := spring * depth + damping * speed) > 0.0:
        middle = speed - 0.5 * step * force / mass
        force = spring * (depth + 0.5 * step * speed) + damping * middle
        depth, speed = depth + step * middle, speed - step * force / mass
    assert -speed == pytest.approx(restitution, rel=2e-3)


def contact_time(force, mass, speed):
    """Time (s) of an impact on a spring of a given force at a depth, by leapfrog."""
    step = 1e-7
    depth, speed, time = 0.5 * step * speed, speed, 0.5 * step
    while depth > 0.0:
        speed -= step * force(depth) / mass
        depth, time = depth + step * speed, time + step
    return time


def test_the_plate_swings_as_ours_and_throws_nothing_off_time(tmp_path):
    model, data = loaded(PAPER, LANE, tmp_path)
    drive = LANE.drive
    period = round(2.0 * math.pi / drive.omega / model.opt.timestep)
    assert period * model.opt.timestep == pytest.approx(2.0 * math.pi / drive.omega, rel=1e-12)
    for _ in range(3):
        mujoco.mj_step(model, data, period // 3)
        height = drive.amplitude + data.qpos[0]
        late = drive.omega * model.opt.timestep  # twice what its integrator, of first order, is off
        assert height == pytest.approx(drive.amplitude * math.cos(drive.omega * data.time), abs=late * drive.amplitude)
    assert (model.body_gravcomp[1], model.opt.gravity[2]) == (1.0, -9806.65)


def test_the_command_writes_the_same_bytes_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["export", "--tilt", "10", "--format", "mjcf", "--quiet", "--out"]
    for out in ("once", "again"):
        assert CliRunner().invoke(command_line, [*words, out]).exit_code == 0
    once = {path.name: path.read_bytes() for path in Path("once/mjcf").iterdir()}
    assert {path.suffix for path in Path("once/mjcf").iterdir()} == {".xml", ".stl"}
    assert once == {path.name: path.read_bytes() for path in Path("again/mjcf").iterdir()}


@pytest.mark.nightly
def test_the_page_runs_and_the_walker_as_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = "".join((DOCS / name).read_text("utf-8") for name in ("mujoco.md", "appendix/simulation.md"))
    command = re.search(r"^walkergen (export .*?) +#", page, re.MULTILINE)[1]
    assert CliRunner().invoke(command_line, command.split()).exit_code == 0
    capsys.readouterr()
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], {})
    speed = float(capsys.readouterr().out.split()[0])
    told = re.search(r"^\| 10 deg \|.*?\|.*?\| ([\d.]+) ± ([\d.]+) \|", page, re.MULTILINE)
    mean, error = map(float, told.groups())
    assert speed == pytest.approx(mean, abs=4.0 * error * math.sqrt(6))  # one run of six
