"""Two braced walkers without weight, far above a still plate, that run into each other."""

import math

import numpy as np

from walkergen.commands.selftest.scenes import STILL_DRIVE
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects.slope import Gravity
from walkergen.core.simulation.space.pose import update_pose
from walkergen.core.simulation.space.state import C_X, C_Y, C_Z, V_X, V_Z, W_X, work_for
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.guests.crowd.space import bodies, run

APART = 200.0
"""Distance (mm) at which both are let go before they are put where a test wants them."""


class Pair:
    """Two walkers at places (x, z, heading in rad), with velocities (x, z) and turning rates.

    Their touches are so many times shorter than by default.
    """

    def __init__(self, places, velocities, spins=(0.0, 0.0), shorter=1.0, **keys):
        design = Design().variant(tilt_deg=10.0, kind="braced")
        data = {"drive": STILL_DRIVE, "arena": {"kind": "plane"}}
        scene = Scene.model_validate(data | {"crowd": keys})
        mass = solids.mass_of(design)
        far = [(0.0, 0.0, places[0][2]), (APART, 0.0, places[1][2])]
        self.plan = run.prepare(scene, [(design, mass)], [0, 0], np.array(far), endless=True)
        law = self.plan.law
        law = law._replace(spring=law.spring * shorter**2, tick=law.tick * 0.5 ** math.ceil(math.log2(shorter)))
        self.plan = self.plan._replace(law=law)
        self.walkers = [
            (world._replace(acting=world.acting._replace(gravity=Gravity(1e-9, 0.0, 0.0))), state)
            for world, state in run.release_walkers(self.plan, 0)
        ]
        for (world, state), at, velocity, spin in zip(self.walkers, places, velocities, spins, strict=True):
            state[C_X], state[C_Y], state[C_Z] = at[0], 100.0, at[1]
            state[V_X], state[V_Z] = velocity
            level(state, at[2])
            work = work_for(world.walker, state)
            update_pose(world, state, work)
            state[W_X : W_X + 3] = work.R.T @ (0.0, spin, 0.0)
        self.crowd, self.walkers = run.make_crowd(self.plan, self.walkers)

    @property
    def walker(self):
        """What the kernels know of either."""
        return self.walkers[0][0].walker

    @property
    def shape(self):
        """The shape of either, seen from above."""
        return self.plan.shapes[0]

    def advance(self, seconds):
        """Advance both; returns the book of their contacts."""
        run.advance(self.crowd, seconds, 1, lambda: False)
        return self.crowd.book

    def momentum(self):
        """Linear and angular momentum about the origin, shape (6,)."""
        total = np.zeros(6)
        for world, state in self.walkers:
            work = work_for(world.walker, state.copy())
            update_pose(world, state, work)
            p = world.walker.mass * state[V_X : V_X + 3]
            own = work.R @ world.walker.inertia @ state[W_X : W_X + 3]
            total += np.concatenate([p, own + np.cross(state[C_X : C_X + 3], p)])
        return total

    def energy(self):
        """Kinetic energy of both, g mm^2/s^2."""
        return sum(
            0.5 * world.walker.mass * state[V_X : V_X + 3] @ state[V_X : V_X + 3]
            + 0.5 * state[W_X : W_X + 3] @ world.walker.inertia @ state[W_X : W_X + 3]
            for world, state in self.walkers
        )

    def energy_loss(self):
        """Energy that their contacts took, g mm^2/s^2."""
        return self.crowd.book[bodies.RUBBED] - self.crowd.book[bodies.WORK]


def level(state, heading):
    """Set the rotation of a level walker with this heading."""
    from walkergen.core.simulation.space.state import Q_0

    state[Q_0 : Q_0 + 4] = np.cos(0.5 * heading), 0.0, np.sin(0.5 * heading), 0.0
