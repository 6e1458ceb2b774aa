"""Third check, in space and in a plane: crowds from rest until they are stationary, unchanged or with one change."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from evidence.crowd_checks import runs, setting
from evidence.crowd_checks.runs import Run
from evidence.crowd_checks.setting import CROWD_RATE_HZ, DISH, Size
from walkergen.core import dish as dishes
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.space.placing import place_outlines
from walkergen.guests.crowd.statistics import CrowdFilm, measure, pairs
from walkergen.guests.crowd.statistics.displacements import speeds
from walkergen.guests.crowd.statistics.film import from_positions
from walkergen.guests.crowd.statistics.summary import UNITS
from walkergen.readers.walkers import top_outline

CLEARANCE_MM = 0.2
"""Least distance of bodies at the start."""

STATISTICS = (
    *("speed", "speed_along_heading", "polar_order", "nematic_order", "local_polar_order", "local_nematic_order"),
    *("packing_scatter", "cluster_size", "alone"),
)
"""Statistics of a crowd that are compared."""

SHELLS = (0.0, 0.5, 0.75, 1.0, 1.5)
"""Distances, in lengths of the body, between which g is averaged: side by side, nose on side, nose on nose, next."""

Simulate = Callable[[Scene, Sequence[Array]], list[Run]]
"""Runs of a scene from places at rest."""


class Crowd(NamedTuple):
    """A crowd of one packing."""

    numbers: Mapping[str, Quantity]
    """Means over runs of the statistics that every run has."""
    gained: Quantity
    """Speed of the second half of the record over that of the first, less 1: about 0 for a stationary crowd."""


def simulate_in_space(
    size: Size, design: Design, mass: MassProperties, card: Card, packing: float, number: int, **keys: float
) -> Crowd:
    """Crowd of a packing in space, of so many runs; `keys` change its scene."""

    def simulate(scene: Scene, starts: Sequence[Array]) -> list[Run]:
        return runs.simulate_in_space(scene.variant(**keys), design, mass, starts, CROWD_RATE_HZ, endless=False)

    return _simulate_crowd(size, card, packing, number, simulate)


def simulate_in_plane(size: Size, card: Card, packing: float, number: int) -> Crowd:
    """Simulate the crowd of `simulate_in_space` in the plane; runs of the same number start from the same places."""

    def simulate(scene: Scene, starts: Sequence[Array]) -> list[Run]:
        return runs.simulate_in_plane(card, scene.crowd.dish, starts, scene.run.seconds, CROWD_RATE_HZ, size.seed)

    return _simulate_crowd(size, card, packing, number, simulate)


def _simulate_crowd(size: Size, card: Card, packing: float, number: int, simulate: Simulate) -> Crowd:
    scene = setting.make_scene(size, size.crowd_discard_seconds + size.crowd_seconds, 0.0, number)
    starts = [start_places(size, card, packing, run) for run in range(number)]
    return measure_films([make_film(size, card, run) for run in simulate(scene, starts)], card.length_mm)


def start_places(size: Size, card: Card, packing: float, number: int) -> Array:
    """Places of all walkers of a run, shape (N, 3)."""
    dish, outline = dishes.parse_dish(DISH, "DISH"), _outline_arrays(card)
    count = round(packing * dish.area / top_outline.area_of(outline))
    rng = np.random.default_rng(np.random.SeedSequence([size.seed, number, count], spawn_key=(1,)))
    return place_outlines([outline] * count, dish, rng, CLEARANCE_MM)


def measure_films(films: Sequence[CrowdFilm], length: float) -> Crowd:
    """Crowd of its runs, of bodies of this length (mm)."""
    by_run = measure(films).by_run
    numbers = {key: mean(key, UNITS[key], by_run[key]) for key in STATISTICS if np.isfinite(by_run[key]).all()}
    g = np.array([pairs.measure(film, length * np.array(SHELLS)).g for film in films])
    for upper, values in zip(SHELLS[1:], g.T, strict=True):
        key = f"g_up_to_{upper:g}_lengths"
        numbers[key] = mean(key, "", values)
    halves = [np.array_split(speeds(film)[0].mean(axis=1), 2) for film in films]
    return Crowd(numbers, mean("gained", "", [after.mean() / before.mean() - 1.0 for before, after in halves]))


def make_film(size: Size, card: Card, run: Run) -> CrowdFilm:
    """Film of a run without its start."""
    kept = run.times >= size.crowd_discard_seconds - 1e-9
    times, count = run.times[kept] - run.times[kept][0], run.poses.shape[1]
    dish = dishes.parse_dish(DISH, "DISH")
    return from_positions(times, run.poses[kept], [card.name] * count, {card.name: _outline_arrays(card)}, dish)


def _outline_arrays(card: Card) -> tuple[Array, ...]:
    return tuple(np.array(contour) for contour in card.outline_mm)
