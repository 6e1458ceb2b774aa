"""Runs of walkers from the same places in space and in a plane; places are of centres of mass."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.dish import Dish
from walkergen.core.numerics import Array
from walkergen.core.scene import Scene
from walkergen.core.simulation import batch
from walkergen.core.simulation.batch import Stopped, Tell
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.guests.crowd.cards import walker_motion
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import crowd as flat
from walkergen.guests.crowd.flat import crowd_checks
from walkergen.guests.crowd.space import run as crowds
from walkergen.guests.crowd.space.result import Impulses


class Run(NamedTuple):
    """Where the centres of mass of N walkers were at F times."""

    times: Array
    """s, shape (F,)."""
    poses: Array
    """x, y (mm) and heading (rad), shape (F, N, 3)."""
    impulses: Impulses | None = None
    """Of all contacts, in space."""


def simulate_in_space(
    scene: Scene, design: Design, mass: MassProperties, places: Sequence[Array], rate_hz: float, endless: bool
) -> list[Run]:
    """Simulate runs in space, one from each of `places` (N, 3), at rest.

    `endless` removes the scene's dish. Results are equal on any number of threads; Ctrl-C is raised again.
    """
    count = len(places[0])
    plan = crowds.prepare(scene, [(design, mass)], [0] * count, np.zeros((count, 3)), endless)
    shift = walker_motion.centre_of_mass(mass)

    def simulate_run(number: int, stopped: Stopped, tell: Tell) -> Run:
        run = crowds.simulate(plan._replace(places=places[number]), number, rate_hz, stopped)
        poses = walker_motion.shift_poses(run.poses[:, :, :3].reshape(-1, 3), shift)
        return Run(run.times, poses.reshape(len(run.times), count, 3), run.impulses)

    return batch.run_all(simulate_run, len(places))


def simulate_in_plane(
    card: Card, dish: Dish, places: Sequence[Array], seconds: float, rate_hz: float, seed: int
) -> list[Run]:
    """Simulate runs in a plane, one from each of `places` (N, 3), at rest."""

    def simulate_run(number: int, stopped: Stopped, tell: Tell) -> Run:
        def stop_if_requested(what: str, frames: int, total: int) -> None:
            if stopped():
                raise KeyboardInterrupt  # ends LAMMPS, on this thread

        own = int(np.random.SeedSequence([seed, number]).generate_state(1)[0])
        kinds = np.zeros(len(places[number]), int)
        asked = crowd_checks.make_crowd([card], kinds, dish, places[number], seconds, rate_hz, own)
        run = flat.simulate(asked, progress=stop_if_requested)
        return Run(run.times, run.poses)

    return batch.run_all(simulate_run, len(places))
