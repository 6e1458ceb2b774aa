"""The walker in space from its definition (docs/physics.md section 7), in plain numpy.

A rival of `simulation.space` that shares no algebra with it: velocities are those of O and of the
body's turn, legs are volumes of points that swing and twist, and the mass matrix is a sum over
them. Corners come in the order back z < 0, back z > 0, front z < 0, front z > 0.
"""

import math
from itertools import product

import numpy as np
from scipy.integrate import solve_ivp

from walkergen.jobs.trust.selftest.scenes import STILL
from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.effects.slope import Gravity
from walkergen.simulation.plan import prepare
from walkergen.simulation.space.state import V_X, V_Z
from walkergen.walker import solids
from walkergen.walker.design import Design

UP, ALONG, ACROSS = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
LEVEL = np.array([UP, ALONG, ACROSS])
"""Directions of a contact of a level walker: normal, along the heading, across."""


def plan_of(tilt, kind="flexible", **tables):
    """Plan of the paper's walker, with the masses of its mesh, over a still plane."""
    design = Design().variant(tilt_deg=float(tilt), kind=kind)
    data = {"drive": STILL, "arena": {"kind": "plane"}} | tables
    data["legs"] = {"model": "space"} | data.get("legs", {})
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
    state = plan.start(clearance, pitch, 0.0, roll)
    state[V_X : V_Z + 1] = velocity
    tally = record.new(len(state), event_room=32)
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

        A strip between two level cuts, by Gauss' rule, which is exact for the squares of a mass
        matrix.
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

    def landing(self, corner, stiffness, damping, springs, velocity):
        """Impulse (normal, along, across) of a corner that lands alone and does not slide.

        Small displacements, so that springs and dampers (normal and tangential) and the legs'
        undamped `springs` make a linear system, by DOP853 until the plate would pull.
        """
        J, M = self.rows()[3 * corner : 3 * corner + 3], self.mass_matrix()
        k, c = (np.array([one[0], one[1], one[1]]) for one in (stiffness, damping))
        held = np.diag([0.0] * 6 + list(springs))

        def force(z):
            return -k * (J @ z[:10]) - c * (J @ z[10:20])

        def slopes(t, z):
            f = force(z)
            return np.concatenate([z[10:20], np.linalg.solve(M, J.T @ f - held @ z[:10]), f])

        def pulls(t, z):
            return force(z)[0] + (1.0 if t == 0.0 else 0.0)

        pulls.terminal, pulls.direction = True, -1.0
        start = np.zeros(23)
        start[10:13] = velocity
        found = solve_ivp(slopes, (0.0, 1.0), start, "DOP853", rtol=1e-9, atol=1e-14, events=pulls)
        return found.y[20:, -1]


def sliding(W, friction):
    """Direction (along, across) in which slip sets off from rest: W_tn - mu W_tt u = lambda u."""
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
    is that of impulses) or "stronge" (its square is that of the normal work).
    """
    slow = 1e-6 * np.linalg.norm(velocity)
    z, end = np.array([*velocity, 0.0, 0.0, 0.0, 0.0]), None  # velocity, impulse, normal work
    force = None if math.hypot(*z[1:3]) > slow else _held(W, friction, z, slow)
    while True:

        def slopes(p, z, force=force):
            s = math.hypot(z[1], z[2])
            f = force if force is not None else np.array([1.0, *(-friction / s * z[1:3])])
            return np.concatenate([W @ f, f, z[:1]])

        def stops(p, z, force=force):
            return 1.0 if force is not None else math.hypot(z[1], z[2]) - slow

        def ends(p, z, end=end):
            return z[0] if end is None else (z[3] if law == "poisson" else z[6]) - end

        stops.terminal = ends.terminal = True
        stops.direction, ends.direction = -1.0, 1.0
        found = solve_ivp(slopes, (0.0, 1e3), z, "DOP853", rtol=1e-9, atol=1e-12, events=[stops, ends])
        z = found.y[:, -1].copy()
        if len(found.t_events[0]):
            force = _held(W, friction, z, slow)
        elif end is None:
            end = (1.0 + restitution) * z[3] if law == "poisson" else (1.0 - restitution**2) * z[6]
        else:
            return z[3:6]


def _held(W, friction, z, slow):
    """Force per normal force of a corner whose slip has stopped; None, and set off, if it slips."""
    z[1:3] = 0.0
    needed = np.linalg.solve(W[1:, 1:], -W[1:, 0])
    if math.hypot(*needed) <= friction:
        return np.array([1.0, *needed])
    z[1:3] = 1.001 * slow * sliding(W, friction)
    return None
