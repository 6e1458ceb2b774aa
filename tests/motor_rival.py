"""A walker with a real mass on a hinge in MuJoCo, a rival of `simulation.effects.motor`.

The rotor of the rival is a point mass, which its walker's masses count at the motor's place.
"""

import math

import mujoco
import numpy as np
from space_rival import cross

from evidence.validate import mujoco_walker
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.pose import update_pose
from walkergen.core.simulation.space.state import HEIGHT, SHOWN_X, SHOWN_Y, work_for
from walkergen.core.simulation.world import OK
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import Motor

SPEED, TINY = 1e4, 1e-4
"""Gain of the servo that keeps a rotor's rate, g mm^2/s per rad/s; inertia of its point, g mm^2."""


def carrying(drive, motor=None, tilt=10.0, kind="flexible", **tables):
    """Plan of the paper's walker on a still plate, with a motor anywhere in its body.

    No pocket is cut, and the motor's mass counts as a part of the body's.
    """
    bare = Design().variant(tilt_deg=float(tilt), kind=kind)
    design = bare.model_copy(update={"motor": Motor.model_validate(motor or {})})
    data = {"arena": {"kind": "plane"}} | tables
    data["drive"] = {"kind": "motor", "frequency_hz": 90.0} | drive
    return prepare(Scene.model_validate(data), design, solids.mass_of(bare))


def throwing(share, frequency=90.0, **keys):
    """Drive whose motor pushes with so many times the weight of `carrying`'s walker."""
    whole = float(carrying({"eccentric_g_mm": 1e-3}).case.mass.total)
    omega = 2.0 * math.pi * frequency
    return {"eccentric_g_mm": share * whole * GRAVITY / omega**2, "frequency_hz": frequency} | keys


def concentrate_rotor(plan, radius):
    """Plan whose rotor is a point mass at so many mm from its axis, and that mass in g."""
    rotor = plan.world.acting.motor
    mass, whole = rotor.moment / radius, plan.world.walker.mass
    inertia = mass * radius**2 + TINY - rotor.moment**2 / whole
    spin = inertia * rotor.omega * np.cross(rotor.first, rotor.second)
    acting = plan.world.acting._replace(motor=rotor._replace(spin=tuple(map(float, spin))))
    return plan._replace(world=plan.world._replace(acting=acting)), mass


def rival(plan, radius, friction=0.0, step=4e-6):
    """MuJoCo's model of the walker, its legs without twist, with the rotor at phase 0."""
    walker, mass = plan.world.walker, plan.case.mass
    plan, m = concentrate_rotor(plan, radius)
    rotor = plan.world.acting.motor
    at, axis = np.array(rotor.position), np.cross(rotor.first, rotor.second)
    spring = (float(walker.stiffness[0]), float(walker.damping[0]))
    text = mujoco_walker.walker_mjcf(plan.case.design, mass, spring, friction, step)
    # The body without the mass at its place: O is its centre with it
    whole = mass.spatial.body + float(mass.M) * cross([0, 0, mass.spatial.z]).T @ cross([0, 0, mass.spatial.z])
    rest = float(mass.M) - m
    centre = (float(mass.M) * np.array([0.0, 0.0, mass.spatial.z]) - m * at) / rest
    tensor = whole - m * cross(at).T @ cross(at) - rest * cross(centre).T @ cross(centre)
    tensor -= TINY * np.eye(3)
    write = mujoco_walker._format_numbers
    old = text[text.index("<freejoint/>") : text.index("/>", text.index("<inertial")) + 2]
    new = f"""<freejoint/>
      <inertial pos="{write(*centre)}" mass="{write(rest)}"
        fullinertia="{mujoco_walker._format_inertia(tensor)}"/>
      <body name="rotor" pos="{write(*at)}">
        <joint name="turn" type="hinge" axis="{write(*axis)}"/>
        <inertial pos="{write(*(radius * np.array(rotor.first)))}" mass="{write(m)}"
          diaginertia="{write(TINY, TINY, TINY)}"/>
      </body>"""
    assert text.count(old) == 1
    text = text.replace(old, new).replace(
        "</mujoco>", f'<actuator><velocity joint="turn" kv="{SPEED!r}"/></actuator></mujoco>'
    )
    return mujoco.MjModel.from_xml_string(text)


def fly(plan, seconds, phase):
    """State of a weightless walker that was let go high over the plate, so many seconds later."""
    state = plan.initial_state(500.0, 0.0, phase)
    assert plan.advance(state, seconds, record.new_tally()) == OK
    return state


def fly_there(plan, radius, seconds, phase, step=2e-6):
    """The same by the rival: place of O and quaternion (7 numbers), and the angles of its legs."""
    start = plan.initial_state(500.0, 0.0, phase)
    work = work_for(plan.world.walker, start)
    update_pose(plan.world, start, work)
    model = rival(plan, radius, step=step)
    data, turn = mujoco.MjData(model), model.joint("turn")
    data.qpos[:3] = start[SHOWN_X], start[HEIGHT], -start[SHOWN_Y]
    arm = plan.world.walker.centre - work.thrown[0]
    data.qvel[:3] = work.R @ (work.now[:3] + np.cross(work.now[3:], arm))
    data.qvel[3:6] = work.now[3:]
    data.qpos[turn.qposadr[0]] = phase
    data.qvel[turn.dofadr[0]] = data.ctrl[0] = plan.world.acting.motor.omega
    count = round(seconds / step)
    model.opt.timestep = seconds / count
    for _ in range(count):
        mujoco.mj_step(model, data)
    return data.qpos[:7].copy(), data.qpos[8:].copy()


def speeds_there(plan, radius, seconds, seeds, step=4e-6):
    """Mean speeds (mm/s) of the rival along its heading on the plate, after half a second.

    Its contacts are plastic, as stiff as steps allow.
    """
    rotor = plan.world.acting.motor
    model = rival(plan, radius, plan.scene.contact.friction, step)
    model.opt.gravity[1] = -GRAVITY
    data, turn = mujoco.MjData(model), model.joint("turn")
    period = 2.0 * math.pi / rotor.omega
    count = round(period / step)
    model.opt.timestep = period / count
    means = []
    for seed in seeds:
        pitch, roll, phase = np.random.default_rng(seed).uniform((-1e-3, -1e-3, 0.0), (1e-3, 1e-3, 6.28))
        mujoco.mj_resetData(model, data)
        data.qpos[3:7] = 1.0, 0.5 * roll, 0.0, 0.5 * pitch
        data.qpos[turn.qposadr[0]] = phase
        data.qvel[turn.dofadr[0]] = data.ctrl[0] = rotor.omega
        mujoco.mj_forward(model, data)
        data.qpos[1] = plan.equivalent_drive.amplitude - data.site_xpos[:, 1].min()
        places = []
        for _ in range(round((seconds + 0.5) / (4 * period))):
            mujoco.mj_step(model, data, 4 * count)
            w, x, y, z = data.qpos[3:7]
            heading = np.array([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * z - w * y)])
            places.append([*data.qpos[[0, 2]], *heading / np.linalg.norm(heading)])
        settled = np.array(places[round(0.5 / (4 * period)) :])
        along = 0.5 * (settled[1:, 2:] + settled[:-1, 2:])
        means.append(np.sum(np.diff(settled[:, :2], axis=0) * along) / ((len(settled) - 1) * 4 * period))
    return np.array(means)
