"""Plans of simulations: from a scene, a design and its masses, all data that the runs of a walker need."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from walkergen.core.drive import Drive as PlateDrive
from walkergen.core.numerics import Array, kernels
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects import harmonic
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.effects.resolve import Resolved, resolve
from walkergen.core.simulation.record import Tally
from walkergen.core.simulation.space import model, steps
from walkergen.core.simulation.space.walker import coarser, make_walker
from walkergen.core.simulation.world import Drive, State, World
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties


class Plan(NamedTuple):
    """Simulation ready to run: scene and walker (`case`), effects (`resolved`), data for kernels (`world`)."""

    case: Case
    resolved: Resolved
    world: World

    @property
    def scene(self) -> Scene:
        """Scene of the runs: drive, plate, contact and settings."""
        return self.case.scene

    @property
    def equivalent_drive(self) -> PlateDrive:
        """Drive of the plate. For a walker with a motor: the drive of a plate that would move it in the same way."""
        return self.case.equivalent_drive

    def with_run_settings(self, **run: float) -> "Plan":
        """Return the plan with other values in the scene's [run].

        Parameters
        ----------
        **run : float
            seconds, discard_seconds (s), runs or seed.

        Returns
        -------
        Plan
            The changed plan.
        """
        changed = self.scene.run.model_copy(update=run)
        scene = self.scene.model_copy(update={"run": changed})
        return self._replace(case=self.case._replace(scene=scene))

    def coarser(self, factor: float) -> "Plan":
        """Return the plan with time steps that are `factor` times longer."""
        return self._replace(world=coarser(self.world, factor))

    def sample_print(self, rng: np.random.Generator) -> "Plan":
        """Return the plan of one run, with uneven feet, plate noise and roughness drawn at random if simulated."""
        return self._replace(world=model.sample_world(self.case, self.resolved, self.world, rng))

    def initial_state(
        self, clearance: float, pitch: float, phase: float, roll: float = 0.0, heading: float = 0.0
    ) -> State:
        """Return the state of a walker at rest, its lowest corner `clearance` mm over the plate. Angles are in rad."""
        return model.initial_state(self.world, clearance, pitch, phase, roll, heading)

    def advance(self, state: State, seconds: float, tally: Tally) -> int:
        """Advance a state in place by `seconds` and fill `tally`. Return a status of `world`, such as OK or TOPPLED."""
        return int(steps.advance(self.world, state, seconds, tally))

    def advancer(self, state: State, tally: Tally) -> Callable[[float], int]:
        """Return a function that advances `state` by a time (s) as `advance` does, but looks up its code only once."""
        code = kernels.entry_point(steps.advance, self.world, state, 1.0, tally)
        return lambda seconds: int(code(self.world, state, seconds, tally))

    def energy(self, state: State) -> float:
        """Return the mechanical energy of a walker in a state, g mm^2/s^2."""
        return float(model.energy(self.world, state))

    def feet(self, state: State) -> Array:
        """Return positions (x and height, mm) and velocities (mm/s) of the middles of the feet, shape (legs, 4)."""
        return model.feet(self.world, state)


def prepare(scene: Scene, design: Design, mass: MassProperties) -> Plan:
    """Prepare the plan of a scene: resolve its effects and put the walker into its world.

    Parameters
    ----------
    scene : Scene
        Drive, plate, contact and settings of the runs.
    design : Design
        Design of the walker.
    mass : MassProperties
        Its masses, from `mass_of`.

    Returns
    -------
    Plan
        Plan of all runs, for `simulate`.

    Raises
    ------
    InputError
        If choices of the scene contradict each other or the design.

    References
    ----------
    docs/physics.md sections 5 and 7.

    Examples
    --------
    >>> from walkergen.core import Design, Scene, mass_of, prepare
    >>> design = Design()
    >>> prepare(Scene(), design, mass_of(design)).scene.run.runs
    16
    """
    case = Case(scene, design, mass)
    resolved = resolve(case)
    harmonics = harmonic.parameters(case) if resolved.is_on(harmonic.NAME) else harmonic.OFF
    motor = scene.drive.kind == "motor"  # an effect on the walker, over a plate that is still
    drive = Drive(0.0 if motor else scene.drive.amplitude, scene.drive.omega, harmonics)
    walker, options = make_walker(case, resolved)
    return Plan(case, resolved, World(walker, drive, resolved.acting, options))
