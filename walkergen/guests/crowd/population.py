"""Population of a crowd, initial positions of its walkers, and results: in space and in a plane."""

from collections import Counter
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from walkergen.core import ENDED_WELL, Array, Design, InputError, MassProperties, Scene
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.space.placing import place_outlines
from walkergen.guests.crowd.space.result import CrowdRun
from walkergen.guests.crowd.statistics import CrowdFilm, CrowdStatistics
from walkergen.guests.crowd.statistics.film import from_positions
from walkergen.guests.crowd.statistics.summary import MIN_FRAMES
from walkergen.points import effect_selection
from walkergen.points.trajectory import check_sample_count
from walkergen.readers.walkers import top_outline

Model = Literal["space", "flat"]

GOOD_OUTCOMES = tuple(outcome.value for outcome in ENDED_WELL)

CLEARANCE_MM = 0.2
"""Least distance of bodies at the start: they drop turned by up to a milliradian."""

PLACES_STREAM_KEY = 1
"""Key of the random stream for initial positions, which differs from the walkers' streams."""


class Kind(NamedTuple):
    """Walkers of one kind in a crowd: their number, and their design (in space) or card (in a plane)."""

    name: str
    walkers: int
    outline: tuple[Array, ...]
    """Outer contours seen from above, mm: from O in space, from C in a plane."""
    design: Design | None = None
    mass: MassProperties | None = None
    card: Card | None = None

    @property
    def area(self) -> float:
        """Area of the outline, mm^2."""
        return top_outline.area_of(self.outline)


class Population(NamedTuple):
    """Walkers of a crowd and their scene, as read from files."""

    scene: Scene
    kinds: tuple[Kind, ...]

    @property
    def model(self) -> Model:
        """Model that moves the walkers: "space" (3D) for designs, "flat" (2D) for cards."""
        return "space" if self.kinds[0].card is None else "flat"

    @property
    def kind_indices(self) -> tuple[int, ...]:
        """Index in `kinds` of each walker, in ascending order."""
        return tuple(number for number, kind in enumerate(self.kinds) for _ in range(kind.walkers))

    @property
    def packing(self) -> float:
        """Area of all outlines over that of the dish."""
        return sum(kind.walkers * kind.area for kind in self.kinds) / self.scene.crowd.dish.area


class Simulated(NamedTuple):
    """Completed runs of a crowd, and their results."""

    request: CrowdRequest
    population: Population
    films: tuple[CrowdFilm, ...]
    runs: tuple[CrowdRun, ...]
    """Results of the runs, ordered by number; empty for a crowd in a plane."""
    statistics: CrowdStatistics
    wall_s: float

    @property
    def outcomes(self) -> Counter[str]:
        """Number of walkers with each outcome, all runs together."""
        return Counter(outcome for run in self.runs for outcome in run.outcomes)

    @property
    def fallen(self) -> dict[str, int]:
        """Number of walkers with each outcome other than reaching the end, all runs together."""
        return {name: count for name, count in self.outcomes.items() if name not in GOOD_OUTCOMES}

    @property
    def energy_error(self) -> float:
        """Largest unexplained energy of a walker in any run, over the energy exchanged."""
        return max((run.energy_error for run in self.runs), default=0.0)


def make_film(population: Population, times: Array, poses: Array) -> CrowdFilm:
    """Return the film of a run, seen from above, from the walkers' poses at `times` (s, shape (F,)).

    `poses`: x, y (mm) and heading (rad) come first, shape (F, N, 3 or more).
    """
    outlines = {kind.name: kind.outline for kind in population.kinds}
    names = [population.kinds[number].name for number in population.kind_indices]
    return from_positions(times, poses, names, outlines, population.scene.crowd.dish)


def check_population(request: CrowdRequest, population: Population) -> None:
    """Raise InputError for two kinds with one name, a scene with `run.accepted_error`, or too few or many frames."""
    names = [kind.name for kind in population.kinds]
    if len(set(names)) < len(names):
        raise InputError(f"‹count›: two designs have the name {max(names, key=names.count)!r}. Rename one.")
    run, rate_hz = population.scene.run, request.rate_hz
    effect_selection.check_no_accepted_error(
        population.scene, "is for the speed of one walker, and a crowd includes every effect of its scene"
    )
    if not run.seconds * rate_hz >= MIN_FRAMES:
        raise InputError(
            f"‹rate_hz=›{rate_hz:g}: a run of {run.seconds:g} s has fewer than {MIN_FRAMES} frames. "
            "Raise ‹rate_hz› or ‹seconds›."
        )
    check_sample_count(population.scene, 1.0 / (rate_hz * len(population.kind_indices)), run.runs)


def place_walkers(population: Population, contours: Sequence[Sequence[Array]], number: int) -> Array:
    """Draw the poses at which run `number` begins, shape (N, 3). Raises InputError if walkers do not fit.

    `contours`: outlines of each kind. Poses are x, y (mm) and heading (rad) of the contours' origins.
    """
    stream = np.random.SeedSequence([population.scene.run.seed, number], spawn_key=(PLACES_STREAM_KEY,))
    outlines = [contours[kind] for kind in population.kind_indices]
    return place_outlines(outlines, population.scene.crowd.dish, np.random.default_rng(stream), CLEARANCE_MM)
