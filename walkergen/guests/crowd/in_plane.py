"""A crowd in a plane (2D): walkers with the properties on their cards, placed, moved by LAMMPS, and measured."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import InputError, OneRun, Quantity, Scene, Stopped, Tell
from walkergen.guests.crowd import population as populations
from walkergen.guests.crowd import walker_counts
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import crowd as flat
from walkergen.guests.crowd.flat import crowd_checks, lammps_input
from walkergen.guests.crowd.population import Kind, Population
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.statistics import CrowdFilm, measure
from walkergen.readers.walkers import top_outline

CONTACT_KEYS = ("restitution", "friction")
"""Keys of a scene's [crowd] that replace a card's own where they are set."""

MAX_TESTED_PACKING = 0.3
"""Largest packing at which a crowd of cards was compared with the same crowd in space (docs/crowds-flat.md)."""

TESTED_RANGE = (
    f"cards were compared with walkers in space up to packing {MAX_TESTED_PACKING:g} (koumakis2016, in a square "
    "without walls). Positions agree or are undecided. The speed is that in space times 0.999 ± 0.026 at packing 0.1, "
    "and times 0.992 ± 0.035 at 0.3"
)
"""Tested range of the numbers of a crowd in a plane, as text."""


def make_population(
    request: CrowdRequest, scene: Scene, cards: Sequence[Card], counts: Sequence[int] | None = None
) -> Population:
    """Return a population of `counts` walkers of each card, by default as many as the scene sets.

    Raises
    ------
    InputError
        For a scene with a lid, which the card fixes, and as `check_population` does.
    """
    crowd, lid = scene.crowd, scene.arena.lid_mm
    if lid is not None:
        raise InputError(f"arena.lid_mm = {lid:g}: the card fixes the lid. Leave the key out.")
    scene_contacts = {key: getattr(crowd, key) for key in CONTACT_KEYS if key in crowd.model_fields_set}
    kinds = []
    for number, card in enumerate(cards):
        outline = tuple(np.array(contour) for contour in card.outline_mm)
        area = top_outline.area_of(outline)
        walkers = walker_counts.walker_count(scene, area) if counts is None else counts[number]
        kinds.append(Kind(card.name, walkers, outline, card=card.model_copy(update=scene_contacts)))
    population = Population(scene, tuple(kinds))
    populations.check_population(request, population)
    return population


class InPlane(NamedTuple):
    """Crowd in a plane, as an experiment of `core.measure`. Each run of LAMMPS starts at its own positions."""

    request: CrowdRequest
    population: Population

    def prepare(self) -> OneRun[CrowdFilm]:
        """Return a function that places and simulates the walkers of run `number`.

        Raises InputError for a crowd denser than was tested. A run raises it if the crowd does not fit, or LAMMPS is
        absent.
        """
        population = self.population
        check_packing(population.packing)
        total_seconds = _total_seconds(population)

        def simulate_run(number: int, stopped: Stopped, tell: Tell) -> CrowdFilm:
            """Simulate run `number` and return its film. `tell` receives the share that is done."""

            def report_frames(task: str, frames: int, total: int) -> None:
                """Report progress to `tell`; end the run if it is stopped."""
                if stopped():
                    raise KeyboardInterrupt  # ends LAMMPS, on this thread
                tell(frames / total)

            run = flat.simulate(_make_crowd(self.request, population, number), progress=report_frames)
            recorded = run.times >= population.scene.run.discard_seconds - 1e-9 * total_seconds
            return populations.make_film(population, run.times[recorded] - run.times[recorded][0], run.poses[recorded])

        return simulate_run

    def film(self, run: CrowdFilm) -> CrowdFilm:
        """Return the film of a run, seen from above: `run` itself, because a run in a plane is stored as a film."""
        return run

    def quantities(self, records: Sequence[CrowdFilm]) -> list[Quantity]:
        """Compute the statistics of the crowd from the films of its runs."""
        return list(measure(records).numbers.values())

    def finer(self) -> None:
        """Return None: there is no finer experiment, as the step's effect on a crowd is unknown."""


def check_packing(packing: float) -> None:
    """Raise InputError if the packing (area of walkers over that of the dish) is above the tested range of cards."""
    if round(packing, 2) > MAX_TESTED_PACKING:
        raise InputError(
            f"packing {packing:.3g}: {TESTED_RANGE}. Use fewer walkers, a larger ‹arena›, designs in place of cards, "
            "or ‹write_only›."
        )


def input_files(request: CrowdRequest, population: Population) -> dict[str, bytes]:
    """Return the LAMMPS input of every run by file name: run-N/crowd.in and the files it reads."""
    return {
        f"run-{number}/{name}": data
        for number in range(population.scene.run.runs)
        for name, data in flat.input_files(_make_crowd(request, population, number)).items()
    }


def _total_seconds(population: Population) -> float:
    """Return the time of a run, its discarded start included, s."""
    return population.scene.run.seconds + population.scene.run.discard_seconds


def _make_crowd(request: CrowdRequest, population: Population, number: int) -> lammps_input.Crowd:
    """Create the input for LAMMPS of run `number`, which sets its initial positions and its noise."""
    seed = int(np.random.SeedSequence([population.scene.run.seed, number]).generate_state(1)[0])
    places = populations.place_walkers(population, [kind.outline for kind in population.kinds], number)
    cards = [kind.card for kind in population.kinds if kind.card]
    dish, seconds = population.scene.crowd.dish, _total_seconds(population)
    return crowd_checks.make_crowd(cards, population.kind_indices, dish, places, seconds, request.rate_hz, seed)
