"""Collective check: a crowd in a dish, in space and in a plane."""

import numpy as np

from evidence.crowd_checks import runs, setting
from evidence.crowd_checks.runs import Array, Run
from evidence.crowd_checks.setting import COUNT, CROWD_RATE_HZ, Size
from walkergen.analysis.values import Value, mean
from walkergen.crowd.card import Card
from walkergen.crowd.space.placing import place
from walkergen.crowd.statistics import measure
from walkergen.crowd.statistics.film import of_places
from walkergen.scene import Scene
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

PLANES = 2
"""Runs in the plane for each in space."""

CLEARANCE_MM = 0.2
"""Least distance of bodies at the start."""

QUANTITIES = {
    "polar_order": "",
    "nematic_order": "",
    "local_polar_order": "",
    "local_nematic_order": "",
    "speed": "mm/s",
    "speed_along_heading": "mm/s",
    "packing_scatter": "",
    "wall_density": "",
    "wall_speed": "mm/s",
    "wall_alignment": "",
    "cluster_size": "",
    "alone": "",
}
"""Units of the numbers of a crowd, of `analysis.crowds`."""


def in_space(size: Size, design: Design, mass: MassProperties, card: Card) -> dict[str, Value]:
    """Numbers of the crowd in space."""
    scene = _scene(size, size.crowd_runs)
    whole = scene.run.model_copy(
        update={"seconds": size.crowd_seconds + size.crowd_discard_seconds, "discard_seconds": 0.0}
    )
    starts = [places(size, card, scene, number) for number in range(size.crowd_runs)]
    made = runs.in_space(scene.model_copy(update={"run": whole}), design, mass, starts, CROWD_RATE_HZ, endless=False)
    return numbers(size, card, scene, made)


def in_plane(size: Size, card: Card) -> dict[str, Value]:
    """Numbers of the crowd in the plane, from places drawn alike."""
    scene = _scene(size, PLANES * size.crowd_runs)
    starts = [places(size, card, scene, number) for number in range(scene.run.runs)]
    whole = size.crowd_seconds + size.crowd_discard_seconds
    made = runs.in_plane(card, scene.crowd.dish, starts, whole, CROWD_RATE_HZ, size.seed)
    return numbers(size, card, scene, made)


def places(size: Size, card: Card, scene: Scene, number: int) -> Array:
    """Places of all walkers of a run, shape (N, 3)."""
    rng = np.random.default_rng(np.random.SeedSequence([size.seed, number], spawn_key=(1,)))
    return place([_outline(card)] * COUNT, scene.crowd.dish, rng, CLEARANCE_MM)


def numbers(size: Size, card: Card, scene: Scene, made: list[Run]) -> dict[str, Value]:
    """Means over runs of the numbers that every run has."""
    films = []
    for run in made:
        kept = run.times >= size.crowd_discard_seconds - 1e-9
        films.append(
            of_places(
                run.times[kept] - run.times[kept][0],
                run.poses[kept],
                [card.name] * COUNT,
                {card.name: _outline(card)},
                scene.crowd.dish,
            )
        )
    by_run = measure(films).by_run
    known = [name for name in QUANTITIES if np.isfinite(by_run[name]).all()]
    return {name: mean(list(by_run[name])) for name in known}


def _scene(size: Size, number: int) -> Scene:
    return setting.scene(size, size.crowd_seconds, size.crowd_discard_seconds, number)


def _outline(card: Card) -> tuple[Array, ...]:
    return tuple(np.array(contour) for contour in card.outline_mm)
