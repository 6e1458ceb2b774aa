"""One corner of a foot by the kernels of the simulator, and by DOP853 (docs/physics.md section 7).

The rival carries the force of the normal springs as its own variable: F' = -u dF/dd, without the root of a depth.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from walkergen.core.numerics.kernels import kernel
from walkergen.core.simulation import record
from walkergen.core.simulation.space.forces import guess_modes, solve
from walkergen.core.simulation.space.landings import advance_contact
from walkergen.core.simulation.space.state import NEAR_DTYPE, OPEN, ROW_LENGTH


class Corner(NamedTuple):
    """A corner of a leg of a stiffness (g/s^2) with a Hertzian tip (g/(mm^0.5 s^2)), and its inverse mass (1/g)."""

    mobility: np.ndarray
    spring: float
    tip: float
    damper: float
    """g^0.5, as `Walker.damper`."""
    shear: float = 0.8
    friction: float = 0.0


class Landing(NamedTuple):
    """What one landing gave."""

    velocity: np.ndarray
    """Normal, along, across at its end, mm/s."""
    impulse: np.ndarray
    sums: np.ndarray
    lost: float
    """Kinetic energy before less that after, g mm^2/s^2."""
    path: np.ndarray
    """Depth (mm), normal force (g mm/s^2) and share of the step for each step in contact."""


@kernel
def _land(state, near, H, A, h, sums, path):
    """Step one corner until it leaves: the number of steps in contact, or 0."""
    contact, taken = near[0], 0
    for step in range(1_000_000):
        for p in range(3):
            contact.middle[p] += contact.speed[p] - contact.free[p]
            contact.free[p] = contact.speed[p]
        if guess_modes(state, near, H, 1, h, 0) > 0:
            solve(near, H, A, 1, h)
        else:
            for p in range(3):
                contact.force[p], contact.middle[p] = 0.0, contact.free[p]
        left = advance_contact(state, near, 0, 0, (step + 1) * h, h, sums)
        for p in range(3):
            contact.speed[p] = 2.0 * contact.middle[p] - contact.speed[p]
            contact.impulse[p] += h * contact.force[p]
        if left:
            return taken
        if contact.tried != OPEN and taken < len(path):
            path[taken, 0], path[taken, 1] = -contact.gap[0], contact.force[0]
            path[taken, 2] = contact.share
            taken += 1
    return 0


def land(corner, velocity, h, part=0.5):
    """Land a corner at a velocity (normal, along, across), from the given part of a step of h seconds on."""
    velocity = np.array(velocity, float)
    near, sums = np.zeros(1, NEAR_DTYPE), np.zeros_like(record.new_tally(0).sums)
    (contact,) = near
    contact.friction, contact.shear, contact.damper = corner.friction, corner.shear, corner.damper
    contact.spring, contact.tip = corner.spring, corner.tip
    contact.speed[:] = contact.free[:] = contact.middle[:] = velocity
    contact.gap[0] = -velocity[0] * h * part
    path = np.zeros((200_000, 3))
    steps = _land(np.zeros(ROW_LENGTH), near, corner.mobility, np.zeros((3, 4)), h, sums, path)
    assert 0 < steps < len(path)
    np.testing.assert_allclose(
        contact.speed - velocity, corner.mobility @ contact.impulse, atol=1e-10 * np.abs(velocity).max()
    )
    inverse = np.linalg.inv(corner.mobility)
    lost = 0.5 * (velocity @ inverse @ velocity - contact.speed @ inverse @ contact.speed)
    return Landing(contact.speed.copy(), contact.impulse.copy(), sums, lost, path[:steps])


class Rival:
    """The same corner by DOP853: phases of sticking and sliding end at events.

    A state: force of the normal springs, velocity (3), force of the tangential spring (2), impulse (3).
    """

    def __init__(self, corner):
        self.corner = corner

    def springs(self, force):
        """Depth, tangent stiffness and its slope by the depth, and the stiffness F^2 / 2U of damping."""
        k, K = self.corner.spring, self.corner.tip
        if math.isinf(K):
            return force / k, k, 0.0, k
        force = max(force, 1e-30)
        soft = force ** (-1 / 3) * K ** (-2 / 3)  # depth of the tip over the force
        tangent = 1.0 / (1.0 / k + 2 / 3 * soft)
        return force * (1.0 / k + soft), tangent, 2 / 9 * soft / force * tangent**3, 1.0 / (1.0 / k + 0.8 * soft)

    def press(self, z):
        """Normal force on the corner."""
        return z[0] - self.corner.damper * math.sqrt(self.springs(z[0])[3]) * z[1]

    def slopes(self, z, slides):
        """Time derivative of a state. Mindlin's spring: pressed on it keeps its force, relieved its stretch."""
        press, k_n = self.press(z), self.springs(z[0])[1]
        size = math.hypot(*z[4:6])
        rub = z[4:6] * (self.corner.friction * press / size if slides and size > 0.0 else 1.0)
        force = np.array([press, *-rub])
        gained, pulled = self.corner.mobility @ force, self.spring_rate(z)
        if slides:
            pulled = pulled - self.excess(z) * z[4:6] / size
        return np.concatenate([[-k_n * z[1]], gained, pulled, force])

    def spring_rate(self, z):
        """Rate of the tangential spring's force without a slider."""
        _, k_n, bent, _ = self.springs(z[0])
        relieved = min(-bent * z[1], 0.0) / k_n
        return self.corner.shear * k_n * z[2:4] + relieved * z[4:6]

    def excess(self, z):
        """Rate at which the tangential force would leave the circle of friction."""
        mu, ahead = self.corner.friction, np.array(z)
        rub = z[4:6] * mu * self.press(z) / math.hypot(*z[4:6])
        rates = np.array([-self.springs(z[0])[1] * z[1], *self.corner.mobility @ [self.press(z), *-rub]])
        step = 1e-6 * z[0] / (abs(rates[0]) + 1e-300)
        ahead[:4] = z[:4] + step * rates
        after = self.press(ahead)
        ahead[:4] = z[:4] - step * rates
        rises = (after - self.press(ahead)) / (2.0 * step)
        return self.spring_rate(z) @ z[4:6] / math.hypot(*z[4:6]) - mu * rises

    def land(self, velocity):
        """Velocity after a landing and its impulse, to 1e-7 of it."""
        mu, velocity = self.corner.friction, np.array(velocity, float)
        size = velocity @ np.linalg.solve(self.corner.mobility, velocity)
        k, K = self.corner.spring, self.corner.tip
        first = min(math.sqrt(size * k), (size**3 * K**2) ** 0.2) * 1e-9  # of the force that stops it, at most
        since = self.springs(first)[0] / -velocity[0]
        stretch = since * velocity[1:] * self.corner.shear * self.springs(first)[1]
        z = np.array([first, *velocity, *stretch, 0.0, 0.0, 0.0])
        limit = mu * self.press(z) / max(math.hypot(*stretch), 1e-300)
        slides = mu > 0.0 and limit < 1.0
        z[4:6] *= min(limit, 1.0)
        for _ in range(50):

            def leaves(t, z, slides=slides):
                return self.press(z) - 0.5 * first

            def turns(t, z, slides=slides):
                if mu == 0.0:
                    return 1.0
                return self.excess(z) if slides else mu * self.press(z) - math.hypot(*z[4:6])

            leaves.terminal = turns.terminal = True
            leaves.direction = turns.direction = -1.0
            path = solve_ivp(
                lambda t, z, slides=slides: self.slopes(z, slides),
                (0.0, 1e6 * since * 1e6),
                z,
                "DOP853",
                rtol=1e-10,
                atol=1e-13 * np.array([first * 1e9, *[40.0] * 3, *[first * 1e9] * 2, *[1e-3] * 3]),
                events=[leaves, turns],
            )
            z = path.y[:, -1]
            if len(path.t_events[0]):
                return z[1:4], z[6:9]
            slides = not slides
        raise AssertionError("no end")


def deepest_of(walker, point, force, speed):
    """Upper bound (mm) of the compression of a point on which a whole walker falls, pressed on by a constant force.

    Others, hinges and dampers only take energy. With the work F d + m v^2/2 in a spring alone, k d^2/2 or
    2/5 K d^(5/2), the leg is pressed by at most F/k + sqrt((F/k)^2 + m v^2/k) and the tip by at most
    (5 F/2K)^(2/3) + (5 m v^2/4K)^(2/5). In series both take less than that, so their sum is a bound.
    """
    k, tip, twice = walker.spring[point], walker.tip[point], walker.mass * speed**2
    leg = force / k + math.sqrt((force / k) ** 2 + twice / k)
    return leg + (2.5 * force / tip) ** (2 / 3) + (1.25 * twice / tip) ** 0.4
