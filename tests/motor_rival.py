"""A walker with a real mass on a hinge in MuJoCo, a rival of the rotor of `simulation.effects.motor`.

The rotor of the rival is a point mass, which its walker's masses count at the motor's place.
"""

import mujoco
import numpy as np
from space_rival import cross

from walkergen.jobs.trust.validate import mujoco_walker
from walkergen.scene import Scene
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

SPEED, TINY = 1e4, 1e-4
"""Gain of the servo that keeps a rotor's rate, g mm^2/s per rad/s; inertia of its point, g mm^2."""


def carrying(drive, motor=None, tilt=10.0, kind="flexible", **tables):
    """Plan of the paper's walker with a motor, on a still plate."""
    design = Design.model_validate(
        {"motor": motor or {}, "legs": {"tilt_deg": float(tilt), "kind": kind}}
    )
    data = {"arena": {"kind": "plane"}} | tables
    data["drive"] = {"kind": "motor", "frequency_hz": 90.0} | drive
    data["legs"] = {"model": "space"} | data.get("legs", {})
    return prepare(Scene.model_validate(data), design, solids.mass_of(design))


def pointed(plan, radius):
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
    plan, m = pointed(plan, radius)
    rotor = plan.world.acting.motor
    place, axis = np.array(rotor.place), np.cross(rotor.first, rotor.second)
    spring = (float(walker.stiffness[0]), float(walker.damping[0]))
    text = mujoco_walker.mujoco_walker(plan.case.design, mass, spring, friction, step)
    # The body without the mass at its place: O is its centre with it
    whole = mass.spatial.body + float(mass.M) * cross([0, 0, mass.spatial.z]).T @ cross(
        [0, 0, mass.spatial.z]
    )
    rest = float(mass.M) - m
    centre = (float(mass.M) * np.array([0.0, 0.0, mass.spatial.z]) - m * place) / rest
    tensor = whole - m * cross(place).T @ cross(place) - rest * cross(centre).T @ cross(centre)
    tensor -= TINY * np.eye(3)
    write = mujoco_walker._numbers
    old = text[text.index("<freejoint/>") : text.index("/>", text.index("<inertial")) + 2]
    new = f"""<freejoint/>
      <inertial pos="{write(*centre)}" mass="{write(rest)}"
        fullinertia="{mujoco_walker._inertia(tensor)}"/>
      <body name="rotor" pos="{write(*place)}">
        <joint name="turn" type="hinge" axis="{write(*axis)}"/>
        <inertial pos="{write(*(radius * np.array(rotor.first)))}" mass="{write(m)}"
          diaginertia="{write(TINY, TINY, TINY)}"/>
      </body>"""
    assert text.count(old) == 1
    text = text.replace(old, new).replace(
        "</mujoco>", f'<actuator><velocity joint="turn" kv="{SPEED!r}"/></actuator></mujoco>'
    )
    return mujoco.MjModel.from_xml_string(text)
