"""The walker in space without twist, as a model of MuJoCo: a free body and two legs on hinges.

Sites are the corners of the feet, in the order of `space_rival`. Lengths in mm, masses in g. The
plate rests: gravity is g plus its acceleration. Needs the extra `rivals`.
"""

import math
from collections.abc import Iterable

import mujoco
import numpy as np
from mujoco import rollout

from evidence.work_precision.case import PERIODS_PER_POSE, count_poses, draw_start, speed_along_heading
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY
from walkergen.core.simulation.world import Drive
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import LegMass, MassProperties

FOOT_RADIUS_MM = 1e-3
"""Radius (mm) of the spheres that represent corners; their lowest points are the corners."""

CONTACT_DAMPING = 4.0
"""Damping ratio of a contact without restitution; 16 and 64 give the same speeds."""


def _format_numbers(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)


def _format_inertia(tensor: Array) -> str:
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return _format_numbers(*(tensor[i, j] for i, j in pairs))


def _leg_mjcf(name: str, leg: LegMass, design: Design, spring: tuple[float, float]) -> str:
    assert leg.tensor is not None
    foot, corners = leg.c_A + leg.c_T, ""
    for side in (-0.5 * design.size.depth, 0.5 * design.size.depth):
        corners += f"""
        <site pos="{_format_numbers(*foot, side)}"/>
        <geom name="{name}{side:+g}" type="sphere" size="{FOOT_RADIUS_MM}" mass="0"
          pos="{_format_numbers(foot[0], foot[1] + FOOT_RADIUS_MM, side)}" contype="0" conaffinity="0"/>"""
    return f"""
      <body name="{name}" pos="{_format_numbers(*leg.anchor, 0.0)}">
        <joint type="hinge" axis="0 0 1" stiffness="{spring[0]!r}" damping="{spring[1]!r}"/>
        <inertial pos="{_format_numbers(*leg.c_A, 0.0)}" mass="{_format_numbers(float(leg.m))}"
          fullinertia="{_format_inertia(leg.tensor)}"/>{corners}
      </body>"""


def walker_mjcf(
    design: Design,
    mass: MassProperties,
    spring: tuple[float, float] = (0.0, 0.0),
    friction: float = 0.0,
    step: float = 4e-6,
) -> str:
    """MJCF of a flexible walker, relaxed and level, its O at the origin, over a plate at y = 0.

    `spring`: stiffness and damping of a hinge. Contacts are plastic, as stiff as steps allow.
    """
    whole = mass.spatial
    assert whole is not None
    legs = "".join(_leg_mjcf(name, leg, design, spring) for name, leg in zip(("back", "front"), mass.legs, strict=True))
    half = 0.5 * design.size.depth
    pairs = "".join(
        f"""
    <pair geom1="plate" geom2="{name}{side:+g}" condim="3" friction="{friction} {friction} 0 0 0"
      solref="{2.0 * step:.9g} {CONTACT_DAMPING}" solreffriction="{2.0 * step:.9g} 1"
      solimp="0.99 0.99 1 0.5 1"/>"""
        for name in ("back", "front")
        for side in (-half, half)
    )
    return f"""
<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" cone="elliptic" integrator="implicitfast"
    tolerance="1e-12" iterations="50"/>
  <worldbody>
    <geom name="plate" type="plane" size="1 1 1" zaxis="0 1 0" contype="0" conaffinity="0"/>
    <body name="body">
      <freejoint/>
      <inertial pos="{_format_numbers(0.0, 0.0, whole.z)}" mass="{_format_numbers(float(mass.M))}"
        fullinertia="{_format_inertia(whole.body)}"/>{legs}
    </body>
  </worldbody>
  <contact>{pairs}
  </contact>
</mujoco>
"""


def compute_mobility(design: Design, mass: MassProperties) -> Array:
    """Inverse mass of all corners, shape (12, 12), 1/g: normal, along, across of each."""
    model = mujoco.MjModel.from_xml_string(walker_mjcf(design, mass))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rows = np.zeros((4, 3, model.nv))
    for corner in range(4):
        mujoco.mj_jacSite(model, data, rows[corner], None, corner)
    rows = rows[:, [1, 0, 2]].reshape(12, -1)
    moved = np.zeros_like(rows)
    mujoco.mj_solveM(model, data, moved, rows)
    return np.asarray(rows @ moved.T)


def simulate_speeds(
    design: Design,
    mass: MassProperties,
    spring: tuple[float, float],
    friction: float,
    drive: Drive,
    seconds: float,
    seeds: Iterable[int],
) -> Array:
    """Mean speed (mm/s) along the heading of each run, after a discarded half second."""
    count = round(drive.period / 4e-6)
    step = drive.period / count
    model = mujoco.MjModel.from_xml_string(walker_mjcf(design, mass, spring, friction, step))
    data = mujoco.MjData(model)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, full))
    means = []
    for seed in seeds:
        pitch, roll, phase = draw_start(seed)
        mujoco.mj_resetData(model, data)
        data.qpos[3:7] = 1.0, 0.5 * roll, 0.0, 0.5 * pitch
        data.qpos[3:7] /= math.sqrt(data.qpos[3:7] @ data.qpos[3:7])
        mujoco.mj_forward(model, data)
        data.qpos[1] = drive.amplitude - data.site_xpos[:, 1].min()
        data.qvel[1] = -drive.amplitude * drive.omega * math.cos(phase)
        mujoco.mj_getState(model, data, state, full)
        phases = phase + 2.0 * math.pi * (np.arange(count) + 0.5) / count
        pull = np.zeros((count, model.nbody, 6))
        pull[:, :, 1] = -np.outer(GRAVITY - drive.amplitude * drive.omega**2 * np.sin(phases), model.body_mass)
        pull = np.tile(pull.reshape(count, -1), (PERIODS_PER_POSE, 1))[None]
        places = []
        for _ in range(count_poses(seconds, drive.period)):
            states, _ = rollout.rollout(
                model, data, state[None], pull, control_spec=mujoco.mjtState.mjSTATE_XFRC_APPLIED, skip_checks=False
            )
            state[:] = states[0, -1]
            w, x, y, z = state[4:8]
            heading = np.array([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * z - w * y)])
            places.append([state[1], state[3], *heading / math.sqrt(heading @ heading)])
        means.append(speed_along_heading(np.array(places), PERIODS_PER_POSE * drive.period))
    return np.array(means)
