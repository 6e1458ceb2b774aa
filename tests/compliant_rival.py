"""The walker in maximal coordinates: three free bodies held together by Lagrange multipliers.

A rival of `simulation.compliant.chain` that shares no algebra with it: coordinates are (x, y,
angle) of the body and of each leg; hinges and contacts are rows of one constraint matrix.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from walkergen.simulation.world import (
    ANGLE_BACK,
    ANGLE_FRONT,
    PHASE,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    V_X,
    V_Y,
    X,
    Y,
)


def turn(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def perp(u):
    return np.array([-u[1], u[0]])


class Rival:
    def __init__(self, world):
        self.plate, self.gravity = world.drive, world.acting.gravity
        self.walker, walker, legs = world.walker, world.walker, world.walker.legs
        self.anchors = np.array(walker.anchors)
        self.centres = np.array([leg.centre for leg in legs])
        self.tips = np.array(walker.reaches) - self.centres
        self.masses = np.array([walker.mass, walker.mass, walker.inertia])
        for leg, centre in zip(legs, self.centres, strict=True):
            own = leg.inertia - leg.mass * centre @ centre
            self.masses = np.append(self.masses, [leg.mass, leg.mass, own])

    def coordinates(self, state):
        """(positions, velocities), each of shape (9,), of a state of the simulator."""
        p, v = [*state[[X, Y, PITCH]]], [*state[[V_X, V_Y, SPIN]]]
        pairs = ((ANGLE_BACK, RATE_BACK), (ANGLE_FRONT, RATE_FRONT))
        for anchor, centre, (angle, rate) in zip(self.anchors, self.centres, pairs, strict=True):
            psi, spin = state[PITCH] + state[angle], state[SPIN] + state[rate]
            A, C = turn(state[PITCH]) @ anchor, turn(psi) @ centre
            p += [*(state[[X, Y]] + A + C), psi]
            v += [*(state[[V_X, V_Y]] + perp(A) * state[SPIN] + perp(C) * spin), spin]
        return np.array(p), np.array(v)

    def hinges(self, p, v):
        """Rows of the hinge constraints and their J' v (9 columns)."""
        rows, bias = np.zeros((4, 9)), np.zeros(4)
        for i, anchor in enumerate(self.anchors):
            k = 3 + 3 * i
            A, C = turn(p[2]) @ anchor, turn(p[k + 2]) @ self.centres[i]
            rows[2 * i : 2 * i + 2, :2] = np.eye(2)
            rows[2 * i : 2 * i + 2, 2] = perp(A)
            rows[2 * i : 2 * i + 2, k : k + 2] = -np.eye(2)
            rows[2 * i : 2 * i + 2, k + 2] = perp(C)
            bias[2 * i : 2 * i + 2] = -A * v[2] ** 2 - C * v[k + 2] ** 2
        return rows, bias

    def foot(self, p, v, i):
        """Position, rows of its velocity and J' v of foot i."""
        k = 3 + 3 * i
        T = turn(p[k + 2]) @ self.tips[i]
        rows = np.zeros((2, 9))
        rows[:, k : k + 2] = np.eye(2)
        rows[:, k + 2] = perp(T)
        return p[k : k + 2] + T, rows, -T * v[k + 2] ** 2

    def forces(self, p, v):
        g = self.gravity
        f = self.masses * np.array([g.along or 0.0, -g.into, 0.0] * 3)
        for k, leg in zip((5, 8), self.walker.legs, strict=True):
            torque = -leg.stiffness * (p[k] - p[2]) - leg.damping * (v[k] - v[2])
            f[k] += torque
            f[2] -= torque
        return f

    def solve(self, rows, right, forces, targets):
        """M a = forces + rows^T lambda, targets a = right; returns a and lambda."""
        n = len(rows)
        matrix = np.block([[np.diag(self.masses), -rows.T], [targets, np.zeros((n, n))]])
        solution = np.linalg.solve(matrix, np.concatenate([forces, right]))
        return solution[:9], solution[9:]

    def mobility(self, state):
        """4 x 4 inverse mass at the feet (back x, y, front x, y)."""
        p, v = self.coordinates(state)
        hinges, _ = self.hinges(p, v)
        feet = np.vstack([self.foot(p, v, 0)[1], self.foot(p, v, 1)[1]])
        return np.column_stack([feet @ self.solve(hinges, np.zeros(4), feet[i], hinges)[0] for i in range(4)])

    def acceleration(self, p, v, t, foot=None, mode="open", friction=0.0):
        """Acceleration (9,) and contact force (2,) with one foot open, stuck or sliding."""
        rows, bias = self.hinges(p, v)
        targets, right = rows, -bias
        if mode != "open":
            _, tip, tip_bias = self.foot(p, v, foot)
            lift = -self.plate.amplitude * self.plate.omega**2 * math.sin(self.phase(t))
            wanted = np.array([0.0, lift]) - tip_bias
            direction = {"forward": -friction, "backward": friction}.get(mode)
            if mode == "stick":
                extra, targets = tip, np.vstack([targets, tip])
                right = np.concatenate([right, wanted])
            else:
                extra = (direction * tip[0] + tip[1])[None]
                targets, right = np.vstack([targets, tip[1:]]), np.append(right, wanted[1])
            rows = np.vstack([rows, extra])
        a, multipliers = self.solve(rows, right, self.forces(p, v), targets)
        force = np.zeros(2)
        if mode == "stick":
            force = multipliers[4:]
        elif mode != "open":
            force = multipliers[4] * np.array([direction, 1.0])
        return a, force

    def phase(self, t):
        return self.start + self.plate.omega * t

    def kick(self, p, v, foot, impulse):
        hinges, _ = self.hinges(p, v)
        rows = self.foot(p, v, foot)[1]
        return v + self.solve(hinges, np.zeros(4), rows.T @ impulse, hinges)[0]

    def landing(self, state, duration, foot, script):
        """Follow one landing through the contact modes of `script`, each written by hand as
        (mode, friction, event): event(p, v, force, relative position, relative velocity) ends the
        mode when it falls through zero; then `impulse` of the next entry applies. Returns (p, v).
        """
        self.start = state[PHASE]
        p, v = self.coordinates(state)
        t = 0.0
        for mode, friction, event, impulse in script:
            if impulse is not None:
                v = self.kick(p, v, foot, impulse(self, p, v, t))

            def slopes(t, z, mode=mode, friction=friction):
                return np.concatenate([z[9:], self.acceleration(z[:9], z[9:], t, foot, mode, friction)[0]])

            def crossing(t, z, mode=mode, friction=friction, event=event):
                force = self.acceleration(z[:9], z[9:], t, foot, mode, friction)[1]
                position, rows, _ = self.foot(z[:9], z[9:], foot)
                plate = self.plate
                height = plate.amplitude * math.sin(self.phase(t))
                speed = plate.amplitude * plate.omega * math.cos(self.phase(t))
                relative = rows @ z[9:] - np.array([0.0, speed])
                return event(force, position[1] - height, relative)

            crossing.terminal, crossing.direction = True, -1.0
            found = solve_ivp(
                slopes,
                (t, duration),
                np.concatenate([p, v]),
                "DOP853",
                rtol=1e-12,
                atol=1e-14,
                max_step=2e-5,
                events=crossing if event else None,
            )
            t, p, v = found.t[-1], found.y[:9, -1], found.y[9:, -1]
            if found.status == 0:
                break
        return p, v
