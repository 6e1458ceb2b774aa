"""The walker in space from its definition (docs/physics.md section 7), in plain numpy.

A rival of `simulation.space` that shares no algebra with it: velocities are those of O and of the
body's turn, legs are volumes of points that swing and twist, and the mass matrix is a sum over
them. Corners come in the order back z < 0, back z > 0, front z < 0, front z > 0.
"""

import math
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from walkergen.commands.selftest.scenes import STILL_DRIVE
from walkergen.core.numerics.kernels import kernel
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import feet
from walkergen.core.simulation.effects.slope import Gravity
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.state import V_X, V_Z
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

UP, ALONG, ACROSS = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
LEVEL = np.array([UP, ALONG, ACROSS])
"""Directions of a contact of a level walker: normal, along the heading, across."""


def plan_of(tilt, kind="flexible", **tables):
    """Plan of the paper's walker, with the masses of its mesh, over a still plane."""
    design = Design().variant(tilt_deg=float(tilt), kind=kind)
    data = {"drive": STILL_DRIVE, "arena": {"kind": "plane"}} | tables
    return prepare(Scene.model_validate(data), design, solids.mass_of(design))


def weightless(plan):
    """The same plan without gravity."""
    acting = plan.world.acting._replace(gravity=Gravity(1.0, 0.0, 0.0))
    return plan._replace(world=plan.world._replace(acting=acting))


def land(plan, velocity, pitch=0.0, roll=0.0, clearance=1e-3, landings=1):
    """Let a walker at rest in itself run into the plate at `velocity` (x, y, z, mm/s).

    Returns the state after so many landings have ended, the landings, and the impulse on the
    walker (normal, along x, across) until then.
    """
    state = plan.initial_state(clearance, pitch, 0.0, roll)
    state[V_X : V_Z + 1] = velocity
    tally = record.new_tally(len(state), event_room=32)
    while tally.events.cursor[0] < landings:
        plan.advance(state, 12.0 * plan.world.options.step, tally)
    given = plan.world.walker.mass * (state[V_X : V_Z + 1] - velocity)
    return state, tally.events.rows[: tally.events.cursor[0]], LEVEL @ given


def cross(v):
    """Matrix of the vector product v x."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


class Walker:
    """Relaxed or deformed flexible walker with flat feet, of a design and its masses."""

    def __init__(self, design, mass):
        limb = design.limbs[0]
        self.tilt, self.length = limb.tilt, limb.length
        self.thickness, self.depth = limb.thickness, design.size.depth
        self.anchors = [np.array([*leg.anchor, 0.0]) for leg in mass.legs]
        self.mass = mass

    def leg_point(self, leg, xi, zeta, alpha=0.0, tau=0.0):
        """Point of a leg's mid-plane from O at half depth, body axes, mm."""
        u = np.array([-math.sin(self.tilt - alpha), -math.cos(self.tilt - alpha), 0.0])
        n, twist = np.cross(ACROSS, u), tau * xi / self.length
        across = math.cos(twist) * ACROSS + math.sin(twist) * n
        return self.anchors[leg] + xi * u + zeta * across

    def corners(self, angles=(0.0, 0.0, 0.0, 0.0)):
        """Corners of the feet from O, shape (4, 3); angles: hinge and twist of back and front."""
        half = 0.5 * self.depth
        return np.array(
            [
                self.leg_point(leg, self.length, zeta, *angles[2 * leg : 2 * leg + 2])
                for leg, zeta in product((0, 1), (-half, half))
            ]
        )

    def mass_matrix(self):
        """Mass matrix of (v_O, w, hinge and twist of back and front), relaxed, shape (10, 10)."""
        spatial, M = self.mass.spatial, np.zeros((10, 10))
        middle = np.array([0.0, 0.0, spatial.z])
        rows = np.zeros((3, 10))
        rows[:, :3], rows[:, 3:6] = np.eye(3), -cross(middle)
        M += self.mass.M * rows.T @ rows
        M[3:6, 3:6] += spatial.body
        for leg, (point, xi, weight) in product((0, 1), self._volume()):
            rows[:, 3:6], rows[:, 6:] = -cross(self.anchors[leg] + point), 0.0
            u = np.array([-math.sin(self.tilt), -math.cos(self.tilt), 0.0])
            rows[:, 6 + 2 * leg] = np.cross(ACROSS, point)
            rows[:, 7 + 2 * leg] = xi / self.length * np.cross(-u, point)
            M += self.mass.legs[leg].m * weight * rows.T @ rows
        return M

    def _volume(self):
        """Points of a leg from its anchor, with place along the axis and weight.

        A strip between two level cuts, by Gauss' rule, which is exact for the squares of a mass matrix.
        """
        nodes, weights = np.polynomial.legendre.leggauss(4)
        u = np.array([-math.sin(self.tilt), -math.cos(self.tilt), 0.0])
        wide = self.thickness / math.cos(self.tilt)
        for i, j, k in product(range(4), repeat=3):
            point = 0.5 * self.length * (1.0 + nodes[i]) * u
            point = point + 0.5 * wide * nodes[j] * ALONG + 0.5 * self.depth * nodes[k] * ACROSS
            yield point, point @ u, weights[i] * weights[j] * weights[k] / 8.0

    def rows(self, directions=LEVEL):
        """Velocities of the corners along directions in body axes by those of `mass_matrix`,
        relaxed, shape (12, 10)."""
        found = np.zeros((12, 10))
        angles, step = np.zeros(4), 1e-5
        for k, corner in enumerate(self.corners()):
            moved = np.zeros((3, 10))
            moved[:, :3], moved[:, 3:6] = np.eye(3), -cross(corner)
            for j in range(4):
                angles[j] = step
                ahead = self.corners(angles)[k]
                angles[j] = -step
                moved[:, 6 + j] = (ahead - self.corners(angles)[k]) / (2.0 * step)
                angles[j] = 0.0
            found[3 * k : 3 * k + 3] = directions @ moved
        return found

    def mobility(self, directions=LEVEL, held=()):
        """Inverse mass at the corners, shape (12, 12), 1/g; coordinates `held` cannot move."""
        free = np.setdiff1d(np.arange(10), held)
        J, M = self.rows(directions)[:, free], self.mass_matrix()[np.ix_(free, free)]
        return J @ np.linalg.solve(M, J.T)

    def landing(self, corner, tip, springs, velocity, sticks):
        """Impulse (normal, along, across) of a corner that lands alone, and sticks or has no friction.

        Small displacements, by DOP853 until the plate would pull. The legs' `springs` are undamped. The force of
        the tip's springs is carried as a variable of its own, and so is that of its tangential spring, which keeps
        its force under growing load and its stretch under falling load (Mindlin).
        """
        J, M = self.rows()[3 * corner : 3 * corner + 3], self.mass_matrix()
        held = np.diag([0.0] * 6 + list(springs))
        start = np.zeros(26)
        start[10:13] = velocity
        first = 1e-9 * math.sqrt(self.mass.M * tip.spring) * abs((J @ start[10:20])[0])
        start[23] = first

        def force(z):
            return np.array([z[23] - tip.damper * math.sqrt(tip.stiffness(z[23])[1]) * (J @ z[10:20])[0], *z[24:26]])

        def slopes(t, z):
            f, u = force(z), J @ z[10:20]
            k_n, _, bent = tip.stiffness(z[23])
            pulled = -tip.shear * k_n * u[1:] + min(-bent * u[0], 0.0) / k_n * z[24:26]
            gained = np.linalg.solve(M, J.T @ f - held @ z[:10])
            return np.concatenate([z[10:20], gained, f, [-k_n * u[0]], sticks * pulled])

        def pulls(t, z):
            return force(z)[0] - 0.5 * first

        pulls.terminal, pulls.direction = True, -1.0
        size = 1e9 * first
        scales = 1e-12 * np.concatenate([np.full(20, 1e-2), np.full(3, self.mass.M), np.full(3, size)])
        found = solve_ivp(slopes, (0.0, 1.0), start, "DOP853", rtol=1e-9, atol=scales, events=pulls)
        return found.y[20:23, -1]


class Tip(NamedTuple):
    """Corner of a leg (g/s^2) with a Hertzian tip (g/(mm^0.5 s^2), infinite: rigid) and a damper (g^0.5)."""

    spring: float
    tip: float
    damper: float
    shear: float

    def stiffness(self, force):
        """Tangent stiffness, F^2 / 2U, and the tangent's slope by the depth, at an elastic force."""
        if math.isinf(self.tip):
            return self.spring, self.spring, 0.0
        soft = max(force, 1e-30) ** (-1 / 3) * self.tip ** (-2 / 3)  # depth of the tip over the force
        tangent = 1.0 / (1.0 / self.spring + 2 / 3 * soft)
        return tangent, 1.0 / (1.0 / self.spring + 0.8 * soft), 2 / 9 * soft / max(force, 1e-30) * tangent**3


def tip_of(walker, corner):
    """Numbers of the contact of a corner of `simulation.space`."""
    return Tip(*(float(row[corner]) for row in (walker.spring, walker.tip, walker.damper, walker.shear)))


def sliding(W, friction):
    """Direction (along, across) of the first slip from rest: W_tn - mu W_tt u = lambda u."""
    angles = np.linspace(0.0, 2.0 * math.pi, 20001)
    u = np.array([np.cos(angles), np.sin(angles)])
    a = W[1:, :1] - friction * W[1:, 1:] @ u
    turns = np.flatnonzero(np.diff(np.sign(u[0] * a[1] - u[1] * a[0])))
    speeds = np.sum(u * a, axis=0)[turns]
    return u[:, turns[np.argmax(speeds)]]


def keller(W, friction, velocity, restitution, law):
    """Impulse (normal, along, across) of one stiff corner, by Keller's equation.

    dv/dp = W (1, -mu v_t / |v_t|) along the normal impulse p; at v_t = 0 the corner sticks if
    |W_tt^-1 W_tn| <= mu, and slips on along `sliding` otherwise. `law`: "poisson" (restitution
    is that of impulses), "stronge" (its square is that of the normal work), or "viscous": a spring and a damper,
    which give the restitution without friction. They do not change the path, only where on it the force ends.
    """
    slow, viscous = 1e-6 * np.linalg.norm(velocity), law == "viscous"
    damper = 2.0 * feet.damping_ratio(restitution) / math.sqrt(W[0, 0])
    first = 1e-9 * abs(velocity[0]) / math.sqrt(W[0, 0])
    # velocity, impulse, normal work, depth of a spring of stiffness 1
    z, end = np.array([*velocity, 0.0, 0.0, 0.0, 0.0, first]), None
    force = None if math.hypot(*z[1:3]) > slow else _sticking_force(W, friction, z, slow)

    def press(z):
        return z[7] - damper * z[0]

    while True:

        def slopes(p, z, force=force):
            s = math.hypot(z[1], z[2])
            f = force if force is not None else np.array([1.0, *(-friction / s * z[1:3])])
            rates = np.concatenate([W @ f, f, z[:1]])
            return np.append(press(z) * rates if viscous else rates, -z[0])

        def stops(p, z, force=force):
            return 1.0 if force is not None else math.hypot(z[1], z[2]) - slow

        def ends(p, z, end=end):
            if viscous:
                return 0.5 * first - press(z)
            return z[0] if end is None else (z[3] if law == "poisson" else z[6]) - end

        stops.terminal = ends.terminal = True
        stops.direction, ends.direction = -1.0, 1.0
        found = solve_ivp(slopes, (0.0, 1e3), z, "DOP853", rtol=1e-9, atol=1e-12, events=[stops, ends])
        z = found.y[:, -1].copy()
        if len(found.t_events[0]):
            force = _sticking_force(W, friction, z, slow)
        elif viscous:
            return z[3:6]
        elif end is None:
            end = (1.0 + restitution) * z[3] if law == "poisson" else (1.0 - restitution**2) * z[6]
        else:
            return z[3:6]


def _sticking_force(W, friction, z, slow):
    """Force per normal force of a corner whose slip has stopped; None, and set off, if it slips."""
    z[1:3] = 0.0
    needed = np.linalg.solve(W[1:, 1:], -W[1:, 0])
    if math.hypot(*needed) <= friction:
        return np.array([1.0, *needed])
    z[1:3] = 1.001 * slow * sliding(W, friction)
    return None


EVERY = 4
"""Periods of the drive between two places of a run."""


@kernel
def _elastic_force(spring, tip, depth):
    """Force of a leg's corner and a Hertzian tip in series, by Newton's method for the force."""
    force = 1.0 / (1.0 / (spring * depth) + 1.0 / (tip * depth * math.sqrt(depth)))
    for _ in range(60):
        pressed = (force / tip) ** (2.0 / 3.0)
        change = (depth - force / spring - pressed) / (1.0 / spring + pressed / (1.5 * force))
        force = max(force + change, 0.1 * force)
        if abs(change) < 1e-10 * force:
            break
    return force


@kernel
def _turn(R, q):
    """Fill the matrix of a unit quaternion."""
    w, x, y, z = q
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@kernel
def _bare(M, R, v, push, momentum, angles, hinges):
    """Fill the generalised forces without contacts, in the body's axes."""
    for i in range(10):
        momentum[i] = push[i] = 0.0
        for j in range(10):
            momentum[i] += M[i, j] * v[j]
        for j in range(3):
            push[i] -= GRAVITY * M[i, j] * R[1, j]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        push[i] -= v[3 + j] * momentum[k] - v[3 + k] * momentum[j]
        push[3 + i] -= v[3 + j] * momentum[3 + k] - v[3 + k] * momentum[3 + j]
        push[3 + i] -= v[j] * momentum[k] - v[k] * momentum[j]
    for j in range(4):
        push[6 + j] -= hinges[0, j % 2] * angles[j] + hinges[1, j % 2] * v[6 + j]


@kernel
def _press(tip, friction, depth, u, rises, stretch, held, h, f):
    """Fill the force (3, in space) of a corner, and move its stretch; returns its tangential stiffness, 0 if open."""
    force = _elastic_force(tip[0], tip[1], depth)
    soft = (force / tip[1]) ** (2.0 / 3.0) / force
    k_n, viscous = 1.0 / (1.0 / tip[0] + soft / 1.5), 1.0 / (1.0 / tip[0] + 0.8 * soft)
    force -= tip[2] * math.sqrt(viscous) * (u[1] - rises)
    if force <= 0.0:
        return 0.0
    k_t = tip[3] * k_n
    kept = min(held / k_t, 1.0)
    stretch[0], stretch[1] = kept * stretch[0] + h * u[0], kept * stretch[1] + h * u[2]
    pull = k_t * math.hypot(stretch[0], stretch[1])
    if pull > friction * force:
        stretch[0] *= friction * force / pull
        stretch[1] *= friction * force / pull
    f[0], f[1], f[2] = -k_t * stretch[0], force, -k_t * stretch[1]
    return k_t


@kernel
def _integrate(M, inverse, legs, tips, friction, hinges, drive, start, h, count, places):
    """Fill `places` with place and heading of O every `count` steps of h seconds.

    `legs`: anchor (2), tilt, length, half depth of each leg; `tips`: spring, tip, damper, shear; `hinges`: stiffness,
    damping of hinge and twist; `drive`: amplitude, omega, phase; `start`: O (3), turn (4).
    """
    at, q, angles, v = start[:3].copy(), start[3:7].copy(), np.zeros(4), np.zeros(10)
    push, momentum, turned = np.zeros(10), np.zeros(10), np.zeros(4)
    stretch, held, J = np.zeros((4, 2)), np.zeros(4), np.zeros((3, 10))
    R, u, f, arm = np.zeros((3, 3)), np.zeros(3), np.zeros(3), np.zeros(3)
    amplitude, omega, phase = drive
    for taken in range(count * len(places)):
        _turn(R, q)
        if taken % count == 0:
            across = math.hypot(R[0, 0], R[2, 0])
            row = places[taken // count]
            row[0], row[1], row[2], row[3] = at[0], at[2], R[0, 0] / across, R[2, 0] / across
        now = phase + omega * h * taken
        level, rises = amplitude * math.sin(now), amplitude * omega * math.cos(now)
        _bare(M, R, v, push, momentum, angles, hinges)
        for k in range(4):
            leg, side = k // 2, -1.0 if k % 2 == 0 else 1.0
            j = 2 * leg
            tilt, length, zeta = legs[leg, 2] - angles[j], legs[leg, 3], side * legs[leg, 4]
            c, s = math.cos(angles[j + 1]), math.sin(angles[j + 1])
            ux, uy, nx, ny = -math.sin(tilt), -math.cos(tilt), math.cos(tilt), -math.sin(tilt)
            arm[0], arm[1] = legs[leg, 0] + length * ux + zeta * s * nx, legs[leg, 1] + length * uy + zeta * s * ny
            arm[2] = zeta * c
            depth = level - (at[1] + R[1, 0] * arm[0] + R[1, 1] * arm[1] + R[1, 2] * arm[2])
            if depth <= 0.0:
                stretch[k, 0], stretch[k, 1], held[k] = 0.0, 0.0, 0.0
                continue
            J[:] = 0.0
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                J[i, i], J[i, 3 + a], J[i, 3 + b] = 1.0, arm[b], -arm[a]
            J[0, 6 + j], J[1, 6 + j] = length * nx - zeta * s * ux, length * ny - zeta * s * uy
            J[0, 7 + j], J[1, 7 + j], J[2, 7 + j] = zeta * c * nx, zeta * c * ny, -zeta * s
            for i in range(3):
                u[i] = 0.0
                for b in range(10):
                    for a in range(3):
                        u[i] += R[i, a] * J[a, b] * v[b]
            held[k] = _press(tips[k], friction, depth, u, rises, stretch[k], held[k], h, f)
            if held[k] == 0.0:
                stretch[k, 0], stretch[k, 1] = 0.0, 0.0
                continue
            for a in range(3):
                own = R[0, a] * f[0] + R[1, a] * f[1] + R[2, a] * f[2]
                for b in range(10):
                    push[b] += J[a, b] * own
        for i in range(10):
            for j in range(10):
                v[i] += h * inverse[i, j] * push[j]
        for i in range(3):
            at[i] += h * (R[i, 0] * v[0] + R[i, 1] * v[1] + R[i, 2] * v[2])
        for j in range(4):
            angles[j] += h * v[6 + j]
        x, y, z = 0.5 * h * v[3], 0.5 * h * v[4], 0.5 * h * v[5]
        turned[0] = q[0] - q[1] * x - q[2] * y - q[3] * z
        turned[1] = q[1] + q[0] * x + q[2] * z - q[3] * y
        turned[2] = q[2] + q[0] * y + q[3] * x - q[1] * z
        turned[3] = q[3] + q[0] * z + q[1] * y - q[2] * x
        size = math.sqrt(turned[0] ** 2 + turned[1] ** 2 + turned[2] ** 2 + turned[3] ** 2)
        for i in range(4):
            q[i] = turned[i] / size


def speeds(plan, seconds, seeds, step=1.5e-6):
    """Mean speeds (mm/s) along the heading of the walker of a plan, after half a second, by small explicit steps.

    In ten freedoms, as `Walker` has them: momenta of the relaxed legs' mass matrix in the body's axes, exact places
    of the corners, and forces of each corner at the start of a step.
    """
    walker, drive, rival = plan.world.walker, plan.world.drive, Walker(plan.case.design, plan.case.mass)
    legs = np.array([[*anchor[:2], rival.tilt, rival.length, 0.5 * rival.depth] for anchor in rival.anchors])
    order = [
        int(np.flatnonzero((walker.leg == leg) & (np.sign(walker.side) == side))[0])
        for leg in (0, 1)
        for side in (-1, 1)
    ]
    tips = np.array([tip_of(walker, k) for k in order])
    hinges = np.array([walker.stiffness[:2], walker.damping[:2]])
    M = rival.mass_matrix()
    count = math.ceil(EVERY * drive.period / step)
    h, means = EVERY * drive.period / count, []
    for seed in seeds:
        pitch, roll, phase = np.random.default_rng(seed).uniform((-1e-3, -1e-3, 0.0), (1e-3, 1e-3, 6.28))
        height = drive.amplitude + 0.02 - rival.corners()[:, 1].min()
        start = np.array([0.0, height, 0.0, 1.0, 0.5 * roll, 0.0, 0.5 * pitch])
        places = np.zeros((round((seconds + 0.5) / (h * count)) + 1, 4))
        numbers = np.array([drive.amplitude, drive.omega, phase])
        _integrate(
            M, np.linalg.inv(M), legs, tips, plan.scene.contact.friction, hinges, numbers, start, h, count, places
        )
        settled = places[round(0.5 / (h * count)) :]
        along = 0.5 * (settled[1:, 2:] + settled[:-1, 2:])
        means.append(np.sum(np.diff(settled[:, :2], axis=0) * along) / ((len(settled) - 1) * h * count))
    return np.array(means)
