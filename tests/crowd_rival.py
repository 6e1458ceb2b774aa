"""Two walkers that collide, without the kernel: closed forms, and MuJoCo as what moves the bodies.

Bodies are free boxes with the masses and tensors of a walker's mesh, in the frame of a walker: x
along the heading, y up, z to the right, from C. Lengths in mm, masses in g, times in s. The law
of a contact is that of simulation.crowd: an upright edge pushes with a stiffness while it is pressed
on, with e^2 times that as it comes back, and rubs by Coulomb; in MuJoCo it is an outer force. The
stiffness is such that bodies part after one time, for any mass that the contact moves.
"""

import math
from typing import NamedTuple

import mujoco
import numpy as np


class Box(NamedTuple):
    """Free body: its mass, tensor at C, and half lengths."""

    mass: float
    tensor: np.ndarray
    half: np.ndarray
    ahead: float = 0.0
    """Distance of the box's middle before C."""
    radius: float = 0.2
    """Of its upright edges."""
    heights: tuple[float, ...] = (0.0,)
    """Heights over C at which its edges touch, each with its share of the stiffness."""


class Law(NamedTuple):
    """Contact of one edge, all its heights together."""

    spring: float
    """Stiffness over the mass that it moves, 1/s^2."""
    restitution: float
    friction: float


class Motion(NamedTuple):
    """Place, turn (a matrix from body to space), velocity of C and rate, of one box, in space."""

    place: np.ndarray
    turn: np.ndarray
    velocity: np.ndarray
    rate: np.ndarray


def rotation_about_vertical(angle):
    """Turn about the vertical, positive from x towards -z: to the left seen from above."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def still(x, z, angle=0.0, velocity=(0.0, 0.0), rate=0.0):
    """Box whose C lies at (x, 0, z) and moves in the plane, turned by an angle."""
    v = np.array([velocity[0], 0.0, velocity[1]])
    return Motion(np.array([x, 0.0, z]), rotation_about_vertical(angle), v, np.array([0.0, rate, 0.0]))


def mobility(box, motion, arm):
    """Inverse mass of a point at an arm from C, shape (3, 3), 1/g, in space."""
    tensor = motion.turn @ box.tensor @ motion.turn.T
    cross = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
    return np.eye(3) / box.mass - cross @ np.linalg.solve(tensor, cross)


def inverse_mass(boxes, motions, point):
    """Inverse mass (1/g) of two boxes that touch at a point, shape (3, 3), in space."""
    return sum(mobility(box, motion, point - motion.place) for box, motion in zip(boxes, motions, strict=True))


def _stronge(tensor, velocity, restitution, friction):
    """Impulse (along, normal) of an impact whose restitution is that of work (Stronge 1990), from event to event."""
    xx, xy, yy = tensor
    v_x, v_y = velocity
    F_x = F_y = work = 0.0
    compressed = None
    while v_y < 0.0 or compressed is not None:
        held = v_x == 0.0 and abs(xy) <= friction * xx
        ratio = -xy / xx if held else -math.copysign(friction, v_x if v_x != 0.0 else xy)
        s_x, s_y = 0.0 if held else xy + ratio * xx, yy + ratio * xy
        steps = [(-v_x / s_x, "stop")] if s_x * v_x < 0.0 else []
        if compressed is not None:
            left = -(restitution**2) * compressed - (work - compressed)
            steps.append(((-v_y + math.sqrt(v_y**2 + 2.0 * s_y * left)) / s_y, "end"))
        elif s_y > 0.0:
            steps.append((-v_y / s_y, "compressed"))
        step, event = min(steps)
        work += v_y * step + 0.5 * s_y * step**2
        F_x, F_y, v_y = F_x + ratio * step, F_y + step, v_y + s_y * step
        v_x = 0.0 if event == "stop" else v_x + s_x * step
        if event == "compressed":
            compressed, v_y = work, 0.0
        if event == "end":
            break
    return F_x, F_y


def struck(boxes, motions, point, normal, law):
    """Motions after one contact at a point that does not move meanwhile, and in the plane.

    `normal` points from the second box into the first. A spring that gives back the share e^2 of
    its work is Stronge's law of restitution: stops of the sliding and turns of it included.
    """
    along = np.cross([0.0, 1.0, 0.0], normal)
    arms = [point - motion.place for motion in motions]
    H = inverse_mass(boxes, motions, point)
    slip = _speed_at(motions[0], arms[0]) - _speed_at(motions[1], arms[1])
    tensor = (along @ H @ along, along @ H @ normal, normal @ H @ normal)
    velocity = (float(slip @ along), float(slip @ normal))
    F_x, F_y = _stronge(tensor, velocity, law.restitution, law.friction)
    impulse = F_x * along + F_y * normal
    return [
        _apply_impulse(box, motion, arm, sign * impulse)
        for box, motion, arm, sign in zip(boxes, motions, arms, (1.0, -1.0), strict=True)
    ]


def flush(boxes, motions, points, normal, law):
    """Motions after simultaneous contacts, without friction, of boxes that do not turn.

    Their faces are each other's image by half a turn: both gaps close as one.
    """
    approach = (motions[0].velocity - motions[1].velocity) @ normal
    weights = np.linalg.solve(_coupling(boxes, motions, points, normal), np.ones(len(points)))
    for point, weight in zip(points, weights, strict=True):
        impulse = -(1.0 + law.restitution) * approach * weight * normal
        motions = [
            _apply_impulse(box, motion, point - motion.place, sign * impulse)
            for box, motion, sign in zip(boxes, motions, (1.0, -1.0), strict=True)
        ]
    return motions


def _coupling(boxes, motions, points, normal):
    """Inverse mass between the normals of contacts: velocity of a gap by an impulse in another."""
    H = np.zeros((len(points), len(points)))
    for box, motion in zip(boxes, motions, strict=True):
        tensor = motion.turn @ box.tensor @ motion.turn.T
        turns = np.array([np.cross(point - motion.place, normal) for point in points])
        H += 1.0 / box.mass + turns @ np.linalg.solve(tensor, turns.T)
    return H


def _speed_at(motion, arm):
    return motion.velocity + np.cross(motion.rate, arm)


def _apply_impulse(box, motion, arm, impulse):
    tensor = motion.turn @ box.tensor @ motion.turn.T
    return motion._replace(
        velocity=motion.velocity + impulse / box.mass,
        rate=motion.rate + np.linalg.solve(tensor, np.cross(arm, impulse)),
    )


def _numbers(values):
    return " ".join(repr(float(value)) for value in values)


def _inertia(tensor):
    return _numbers(tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def model_of(boxes, step, contact=""):
    """MuJoCo's model of free boxes without gravity, and its data."""
    world = "".join(
        f"""
      <body name="box{number}"><freejoint/>
        <inertial pos="0 0 0" mass="{box.mass!r}" fullinertia="{_inertia(box.tensor)}"/>
        <geom name="geom{number}" type="box" size="{_numbers(box.half)}" mass="0"
          pos="{_numbers((box.ahead, 0.0, 0.0))}"
          contype="0" conaffinity="0"/>
      </body>"""
        for number, box in enumerate(boxes)
    )
    model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" cone="elliptic" integrator="implicitfast"
    tolerance="1e-14" iterations="100"/>
  <worldbody>{world}</worldbody>
  <contact>{contact}</contact>
</mujoco>""")
    return model, mujoco.MjData(model)


def set_motions(data, motions):
    """Set the places and speeds of MuJoCo's boxes: its rates are in the body's axes."""
    for number, motion in enumerate(motions):
        at, moves = slice(7 * number, 7 * number + 3), slice(6 * number, 6 * number + 3)
        data.qpos[at], data.qvel[moves] = motion.place, motion.velocity
        turn = np.empty(4)
        mujoco.mju_mat2Quat(turn, motion.turn.ravel())
        data.qpos[at.stop : at.stop + 4] = turn
        data.qvel[moves.stop : moves.stop + 3] = motion.turn.T @ motion.rate


def get_motions(data, count):
    """Motions of MuJoCo's boxes."""
    found = []
    for number in range(count):
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, data.qpos[7 * number + 3 : 7 * number + 7])
        turn = turn.reshape(3, 3)
        moves = data.qvel[6 * number : 6 * number + 6]
        rate = turn @ moves[3:]
        place = data.qpos[7 * number : 7 * number + 3].copy()
        found.append(Motion(place, turn, moves[:3].copy(), rate))
    return found


def _touching(motions, boxes, one):
    """Edges of box `one` that touch the other: (place, normal into `one`, give) of each height.

    Both are cores with rounded edges; edge on edge is found from box 0 alone.
    """
    own, other = boxes[one], boxes[1 - one]
    mine, theirs = motions[one], motions[1 - one]
    core, against = own.half - own.radius, other.half - other.radius
    middle = np.array([other.ahead, 0.0, 0.0])
    for low, high in zip(own.heights, other.heights, strict=True):
        for sign_x, sign_z in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
            corner = np.array([own.ahead + sign_x * core[0], low, sign_z * core[2]])
            point = mine.place + mine.turn @ corner
            local = theirs.turn.T @ (point - theirs.place)
            nearest = np.clip(local, middle - against, middle + against)
            nearest[1] = local[1]
            away = local - nearest
            distance = math.sqrt(away @ away)
            give = own.radius + other.radius - distance
            on_edge = abs(away[0]) > 0.0 and abs(away[2]) > 0.0
            if give <= 0.0 or distance == 0.0 or (on_edge and one == 1):
                continue
            normal = theirs.turn @ (away / distance)
            at = point - (own.radius - 0.5 * give) * normal
            level = 0.5 * (low + mine.place[1] + high + theirs.place[1])
            yield np.array([at[0], level, at[2]]), normal, give


def collide(boxes, motions, law, seconds, step, push=None):
    """Motions of two boxes after so many seconds, moved by MuJoCo under the law.

    `push`: force on the first box, g mm/s^2, in space. Returns them with the greatest give and the
    mean force on the second box over the last half of the time.
    """
    model, data = model_of(boxes, step)
    set_motions(data, motions)
    mujoco.mj_forward(model, data)
    deepest, forces = 0.0, []
    for _ in range(round(seconds / step)):
        now, applied = get_motions(data, 2), np.zeros((2, 6))
        if push is not None:
            applied[0, :3] += push
        for one in (0, 1):
            for point, normal, give in _touching(now, boxes, one):
                force = _force(boxes, now, one, point, normal, give, law, step)
                deepest = max(deepest, give)
                for body, sign in ((one, 1.0), (1 - one, -1.0)):
                    arm = point - now[body].place
                    applied[body, :3] += sign * force
                    applied[body, 3:] += sign * np.cross(arm, force)
        data.xfrc_applied[1:] = applied
        mujoco.mj_step(model, data)
        forces.append(applied[1, :3])
    return get_motions(data, 2), deepest, np.mean(forces[len(forces) // 2 :], axis=0)


def _force(boxes, now, one, point, normal, give, law, step):
    """Force on an edge of box `one` that gives: Coulomb's at most what stops it in a step."""
    arms = [point - motion.place for motion in now]
    slip = _speed_at(now[one], arms[one]) - _speed_at(now[1 - one], arms[1 - one])
    approach, H = float(slip @ normal), inverse_mass(boxes, now, point)
    press = law.spring / len(boxes[one].heights) / float(normal @ H @ normal) * give
    if approach > 0.0:
        press *= law.restitution**2
    along = slip - approach * normal
    size = math.sqrt(along @ along)
    if law.friction == 0.0 or size == 0.0:
        return press * normal
    stopping = size**3 / step / float(along @ H @ along)
    return press * normal - min(law.friction * press, stopping) * along / size


def meet(boxes, motions, seconds, step, spring):
    """Motions after MuJoCo's own contact of its boxes, elastic and without friction.

    Its contacts set the acceleration of the gap, here as a spring's over the mass that it moves.
    """
    contact = f"""<pair geom1="geom0" geom2="geom1" condim="1" margin="0"
      solref="{_numbers((-spring, 0.0))}" solimp="0.9999 0.9999 1 0.5 1"/>"""
    model, data = model_of(boxes, step, contact)
    set_motions(data, motions)
    mujoco.mj_forward(model, data)
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
    return get_motions(data, 2)
