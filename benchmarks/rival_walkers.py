"""The compliant walker of five coordinates in general physics engines: MuJoCo and pymunk.

One run of this file simulates one engine at one step: it reads a task (JSON) from standard input
and writes the runs' mean speeds and the CPU time they took. It needs the engine alone, not
walkergen. Both engines work in the plate's frame, where the plate rests and gravity is g plus the
plate's acceleration (exact, and no moving body): the walker starts with minus the plate's speed.
Units mm, g, s, rad; x forward, the second axis up, pitch and legs' angles counter-clockwise.
"""

import json
import math
import sys
import time
from collections.abc import Callable
from typing import Any

FOOT = 1e-3
"""Radius (mm) of the discs that stand for the foot's points; their lowest point is the foot."""

PLASTIC = 4.0
"""MuJoCo: damping ratio of a contact without restitution; at 1 it pushes back while it recovers
from the depth of the first step, which is a restitution of up to a quarter."""

IMPEDANCE = 0.99
"""MuJoCo: share of a contact's reference acceleration that is reached; its default is 0.9."""

RECOVERY = 0.01
"""pymunk: time constant (s) with which penetrations and the hinges' errors are taken back. Its
`bias` is the share left after one second: below about 1.4 ms it underflows to zero, which takes
all of them back in one step and stops the walker."""


def gravities(task: dict[str, Any], phase: float) -> list[float]:
    """Gravity plus the plate's acceleration in the middle of each step of one period, mm/s^2."""
    count, amplitude, omega = task["steps_per_period"], task["amplitude"], task["omega"]
    phases = [phase + 2.0 * math.pi * (place + 0.5) / count for place in range(count)]
    return [task["gravity"] - amplitude * omega**2 * math.sin(at) for at in phases]


def start(task: dict[str, Any], clearance: float, pitch: float, phase: float) -> list[float]:
    """Height and pitch of the body, and its vertical speed against the plate."""
    w = task["walker"]
    feet = [
        math.sin(pitch) * (anchor[0] + reach[0]) + math.cos(pitch) * (anchor[1] + reach[1])
        for anchor, reach in zip(w["anchors"], w["reaches"], strict=True)
    ]
    fall = -task["amplitude"] * task["omega"] * math.cos(phase)
    return [clearance - min(feet), pitch, fall]


def legs_of(walker: dict[str, Any]) -> list[tuple[Any, ...]]:
    """Name, anchor, reach and numbers of each leg."""
    each = walker["anchors"], walker["reaches"], walker["legs"]
    return list(zip(("back", "front"), *each, strict=True))


def own_inertia(leg: dict[str, Any]) -> float:
    """Moment of inertia of a leg about its own centre of mass, g mm^2."""
    return float(leg["inertia"] - leg["mass"] * (leg["centre"][0] ** 2 + leg["centre"][1] ** 2))


# --- MuJoCo: generalised coordinates, soft contacts, Newton's solver for the convex problem ---


def contact_spring(restitution: float, duration: float) -> tuple[float, float]:
    """MuJoCo's (stiffness, damping) of a contact of unit mass that lasts `duration` seconds.

    Its force is never negative, so the contact ends where damping and spring cancel.
    """

    def ends(ratio: float) -> tuple[float, float]:
        other = math.sqrt(1.0 - ratio * ratio)
        angle = math.atan2(2.0 * ratio * other, 2.0 * ratio * ratio - 1.0)
        return math.exp(-ratio / other * angle), angle / other

    low, high = 0.0, 1.0 - 1e-9
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ends(middle)[0] > restitution else (low, middle)
    omega = ends(low)[1] / duration
    return omega * omega, 2.0 * low * omega


def mujoco_model(task: dict[str, Any]) -> str:
    """The walker as MuJoCo's XML; its z is up, so that pitch turns about -y."""
    w, step, e = task["walker"], task["step"], task["restitution"]
    stiff = f"{2.0 * step:.9g} 1"  # the stiffest allowed: a slip ends in one step
    solref = f"{2.0 * step:.9g} {PLASTIC}"
    if e > 0.0:
        k, b = contact_spring(e, task["contact steps"] * step)
        solref = f"{-k:.9g} {-b:.9g}"
    limbs, pairs = "", ""
    for name, anchor, reach, leg in legs_of(w):
        centre, own = leg["centre"], own_inertia(leg)
        limbs += f"""
      <body pos="{anchor[0]} 0 {anchor[1]}">
        <inertial pos="{centre[0]} 0 {centre[1]}" mass="{leg["mass"]}"
                  diaginertia="{own} {own} {own}"/>
        <joint type="hinge" axis="0 -1 0" stiffness="{leg["stiffness"]}"
               damping="{leg["damping"]}"/>
        <geom name="{name}" type="sphere" size="{FOOT}" contype="0" conaffinity="0"
              pos="{reach[0]} 0 {reach[1] + FOOT}"/>
      </body>"""
        pairs += f"""
    <pair geom1="plate" geom2="{name}" condim="3" solref="{solref}" solreffriction="{stiff}"
          friction="{task["friction"]} {task["friction"]} 0 0 0"
          solimp="{IMPEDANCE} {IMPEDANCE} 1 0.5 1"/>"""
    return f"""<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" cone="elliptic" integrator="implicitfast"
          tolerance="1e-12" iterations="50"/>
  <worldbody>
    <geom name="plate" type="plane" size="1 1 1" contype="0" conaffinity="0"/>
    <body>
      <inertial pos="0 0 0" mass="{w["mass"]}"
                diaginertia="{w["inertia"]} {w["inertia"]} {w["inertia"]}"/>
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="0 -1 0"/>{limbs}
    </body>
  </worldbody>
  <contact>{pairs}
  </contact>
</mujoco>"""


def run_mujoco(task: dict[str, Any]) -> dict[str, Any]:
    """Runs in C by MuJoCo's own `rollout`: gravity acts as a force at each body's centre."""
    import mujoco
    import numpy as np
    from mujoco import rollout

    model = mujoco.MjModel.from_xml_string(mujoco_model(task))
    data = mujoco.MjData(model)
    every = 10  # periods in one call
    state_size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)

    def run(where: tuple[float, float, float]) -> Callable[[int], float]:
        height, pitch, fall = start(task, *where)
        mujoco.mj_resetData(model, data)
        data.qpos[1], data.qpos[2], data.qvel[1] = height, pitch, fall
        state = np.empty(state_size)
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        pull = np.zeros((task["steps_per_period"], model.nbody, 6))
        pull[:, :, 2] = -np.outer(gravities(task, where[2]), model.body_mass)
        pull = np.tile(pull.reshape(len(pull), -1), (every, 1))[None]

        def advance(periods: int) -> float:
            for _ in range(periods // every):
                states, _ = rollout.rollout(
                    model, data, state[None], pull, control_spec=mujoco.mjtState.mjSTATE_XFRC_APPLIED, skip_checks=False
                )
                state[:] = states[0, -1]
            return float(state[1])

        return advance

    return measured(task, run) | {"version": mujoco.__version__}


# --- pymunk (Chipmunk): maximal coordinates, Newton's restitution, sequential impulses ---


def run_pymunk(task: dict[str, Any]) -> dict[str, Any]:
    """Runs step by step from Python, which pymunk has no way around."""
    import pymunk

    def run(where: tuple[float, float, float]) -> Callable[[int], float]:
        space, body = pymunk_space(pymunk, task, where)
        pulls = [(0.0, -value) for value in gravities(task, where[2])]
        step = task["step"]

        def advance(periods: int) -> float:
            for _ in range(periods):
                for pull in pulls:
                    space.gravity = pull
                    space.step(step)
            return float(body.position.x)

        return advance

    return measured(task, run) | {"version": pymunk.version}


def pymunk_space(pymunk: Any, task: dict[str, Any], where: tuple[float, float, float]) -> Any:
    """The walker about to drop: (space, body)."""
    w = task["walker"]
    height, pitch, fall = start(task, *where)
    space = pymunk.Space()
    space.iterations = task["iterations"]
    space.collision_slop, space.collision_bias = 0.0, math.exp(-1.0 / RECOVERY)
    plate = pymunk.Segment(space.static_body, (-1e5, -10.0), (1e5, -10.0), 10.0)
    body = pymunk.Body(w["mass"], w["inertia"])
    body.position, body.angle, body.velocity = (0.0, height), pitch, (0.0, fall)
    space.add(plate, body)
    feet = []
    for _, anchor, reach, limb in legs_of(w):
        c_x, c_y = limb["centre"]
        leg = pymunk.Body(limb["mass"], own_inertia(limb))
        centre = (anchor[0] + c_x, anchor[1] + c_y)
        leg.position, leg.angle, leg.velocity = body.local_to_world(centre), pitch, (0.0, fall)
        hinge = pymunk.PivotJoint(body, leg, tuple(anchor), (-c_x, -c_y))
        hinge.error_bias = math.exp(-1.0 / RECOVERY)
        spring = pymunk.DampedRotarySpring(body, leg, 0.0, limb["stiffness"], limb["damping"])
        tip = (reach[0] - c_x, reach[1] - c_y + FOOT)
        foot = pymunk.Circle(leg, FOOT, tip)
        foot.filter = pymunk.ShapeFilter(group=1)
        feet.append(foot)
        space.add(leg, foot, hinge, spring)
    for shape in (plate, *feet):  # pymunk multiplies the two surfaces' values
        shape.elasticity = math.sqrt(task["restitution"])
        shape.friction = math.sqrt(task["friction"])
    return space, body


def measured(
    task: dict[str, Any], run: Callable[[tuple[float, float, float]], Callable[[int], float]]
) -> dict[str, Any]:
    """Mean speed of each run after its discarded start; CPU time without the set-up."""
    speeds, cpu = [], 0.0
    period = 2.0 * math.pi / task["omega"]
    for where in task["starts"]:
        advance = run(where)
        began = time.process_time()
        first = advance(task["discarded_periods"])
        last = advance(task["periods"])
        cpu += time.process_time() - began
        speeds.append((last - first) / (task["periods"] * period))
    periods = task["discarded_periods"] + task["periods"]
    return {"speeds": speeds, "cpu_s": cpu, "simulated_s": len(speeds) * periods * period}


RUNS = {"mujoco": run_mujoco, "pymunk": run_pymunk}

if __name__ == "__main__":
    json.dump(RUNS[sys.argv[1]](json.load(sys.stdin)), sys.stdout)
