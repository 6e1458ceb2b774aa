"""Seam between models and runs: a model is a few functions under names that all models share."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import Drive
from walkergen.scene import Scene
from walkergen.simulation.effects.effect import Case
from walkergen.simulation.effects.resolve import Resolved
from walkergen.simulation.record import Tally
from walkergen.simulation.world import State, World

Array = npt.NDArray[np.float64]


class Model(NamedTuple):
    """One way to move a walker; every function but `pose` reads a `World`."""

    start: Callable[..., State]
    """start(world, clearance in mm, pitch, phase, roll, heading in rad) -> a state at rest in the
    laboratory, its legs relaxed, its lower foot `clearance` over the plate; planes have no roll and no heading."""
    advance: Callable[[World, State, float, Tally], int]
    """advance(world, state, seconds, tally) -> a status of `world`; the state changes in place."""
    energy: Callable[[World, State], float]
    """Mechanical energy of a state, g mm^2/s^2."""
    feet: Callable[[World, State], Array]
    """Shape (feet, 4), a row for each foot, in a plane back and front: x (mm), height over the
    plate (mm), v_x and v_y over the plate (mm/s)."""
    momentum: Callable[[World, State], float]
    """Momentum of body and legs along the plate, g mm/s."""
    pose: Callable[[State], tuple[float, float, float]]
    """Place along x and across it (mm) and heading (rad)."""
    coarser: Callable[[World, float], World]
    """coarser(world, factor) -> the world with a step or tolerance `factor` times larger."""
    resting: Callable[[World], float]
    """Speed (mm/s) below which a foot does not rebound."""
    columns: tuple[str, ...]
    """Names, with units, of the leading entries of a state, which a trajectory shows."""
    drawn: Callable[[Case, Resolved, World, np.random.Generator], World]
    """drawn(case, resolved, world, generator) -> the world of one run: its own print and plate."""


def same(case: Case, resolved: Resolved, world: World, rng: np.random.Generator) -> World:
    """The world itself: nothing differs from run to run."""
    return world


class Plan(NamedTuple):
    """Simulation to be run: a scene, what it calls for, and the model with its world."""

    case: Case
    resolved: Resolved
    model: Model
    world: World

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.case.scene

    @property
    def shaken(self) -> Drive:
        """Drive of the plate, or of one that would move under the walker as its motor moves it."""
        return self.case.shaken

    def lasting(self, **run: float) -> "Plan":
        """Plan with other seconds, discard_seconds, runs or seed in the scene's [run]."""
        changed = self.scene.run.model_copy(update=run)
        scene = self.scene.model_copy(update={"run": changed})
        return self._replace(case=self.case._replace(scene=scene))

    def drawn(self, rng: np.random.Generator) -> "Plan":
        """Plan of one run, whose print and plate are drawn where the scene calls for it."""
        return self._replace(world=self.model.drawn(self.case, self.resolved, self.world, rng))

    def start(self, clearance: float, pitch: float, phase: float, roll: float = 0.0, heading: float = 0.0) -> State:
        """A state at rest, its lower foot `clearance` (mm) over the plate; angles in rad."""
        return self.model.start(self.world, clearance, pitch, phase, roll, heading)

    def advance(self, state: State, seconds: float, tally: Tally) -> int:
        """Advance a state in place by `seconds`; returns a status of `world`."""
        return self.model.advance(self.world, state, seconds, tally)

    def energy(self, state: State) -> float:
        """Mechanical energy of a state, g mm^2/s^2."""
        return float(self.model.energy(self.world, state))

    def feet(self, state: State) -> Array:
        """Places and velocities of the feet, shape (feet, 4), as in `Model.feet`."""
        return self.model.feet(self.world, state)
