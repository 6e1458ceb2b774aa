"""Three checks, each in space and in a plane: a walker alone, pairs that meet in four ways, a crowd in a dish.

Each returns its quantities by case: what space has and what the plane has by the same keys.
"""

import math
from collections.abc import Mapping

import numpy as np

from evidence.crowd_checks import meetings, runs, setting
from evidence.crowd_checks.meetings import MEETINGS
from evidence.crowd_checks.runs import Array, Run
from evidence.crowd_checks.setting import COUNT, CROWD_RATE_HZ, DISH, RATE_HZ, Size
from walkergen.analysis import tracks
from walkergen.crowd.cards import make, walker_motion
from walkergen.crowd.cards.card import Card
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.crowd.space.placing import place
from walkergen.crowd.statistics import measure
from walkergen.crowd.statistics.film import of_places
from walkergen.crowd.statistics.measuring import UNITS
from walkergen.dish import Dish
from walkergen.files.progress import silent
from walkergen.numerics.quantity import Quantity, mean
from walkergen.scene import Scene
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Cases = Mapping[str, Mapping[str, Quantity]]
"""Quantities by the name of a case and their key."""

SIDE = 8
"""Walkers alone along a side of the plane: so many squared."""

FORGOTTEN_S = 1.0
"""Start of a run alone that is left out, s."""

APART = 150.0
"""Distance of pairs, mm: no pair reaches another."""

PAIR_S = 1.0
"""Time of a run of pairs: 0.3 s until two meet, 0.3 s in which they are watched, and as much again for
those that meet late, edge on edge."""

MORE_PAIRS, MORE_CROWDS = 4, 2
"""Runs in the plane, which cost little, for each in space."""

CLEARANCE_MM = 0.2
"""Least distance of bodies of a crowd at the start."""

ALONE = (
    ("speed", "mm_s"),
    ("turning", "rad_s"),
    ("D_R", "rad2_s"),
    ("D_T", "mm2_s"),
    ("velocity_relaxes_within", "s"),
    ("turning_relaxes_within", "s"),
    ("delay", "s"),
)
"""Keys and units of a walker alone."""

CROWD = (
    *("polar_order", "nematic_order", "local_polar_order", "local_nematic_order", "speed", "speed_along_heading"),
    *("packing_scatter", "wall_density", "wall_speed", "wall_alignment", "cluster_size", "alone"),
)
"""Statistics of a crowd that are compared."""


def alone_in_space(size: Size, design: Design, mass: MassProperties) -> tuple[Card, Cases]:
    """Card of the walker, and its quantities."""
    scene = setting.scene(size, size.alone_seconds, FORGOTTEN_S, size.alone_runs)
    measured = walker_motion.simulated(scene, design, mass, silent)
    return make.card_of(scene, design, mass, measured), of_motion(measured)


def alone_in_plane(size: Size, card: Card) -> Cases:
    """Quantities of walkers of a card in a plane, so far apart that none meets another."""
    seconds = FORGOTTEN_S + size.alone_seconds
    apart = 4.0 * (card.length_mm + abs(card.speed_mm_s.number) * seconds)
    line = (np.arange(SIDE) - 0.5 * (SIDE - 1)) * apart
    x, y = np.meshgrid(line, line)
    rng = np.random.default_rng(np.random.SeedSequence(size.seed, spawn_key=(3,)))
    start = np.column_stack((x.ravel(), y.ravel(), rng.uniform(-math.pi, math.pi, SIDE**2)))
    (run,) = runs.in_plane(card, Dish("periodic", (SIDE * apart,)), [start], seconds, RATE_HZ, size.seed)
    kept = run.poses[run.times >= FORGOTTEN_S - 1e-9]
    own = tracks.of_places([kept[:, i] for i in range(SIDE**2)], 1.0 / RATE_HZ, lane=False)
    return of_motion(walker_motion.of_tracks(own, True, ()))


def of_motion(measured: Measured) -> Cases:
    """Quantities of a walker alone."""
    known = measured.motion.estimates
    estimates = (
        known["speed"],
        known["turning_bias"],
        known["rotational_diffusion"],
        measured.translation,
        measured.velocity.time,
        measured.turning.time,
        measured.delay.mean,
    )
    named = zip(ALONE, estimates, strict=True)
    return {"alone": {key: own._replace(key=key, unit=unit) for (key, unit), own in named}}


def pairs_in_space(size: Size, design: Design, mass: MassProperties, card: Card) -> Cases:
    """Quantities of pairs in space, let go at rest over their places."""
    scene = setting.scene(size, PAIR_S, 0.0, size.pair_runs)
    starts = [pair_places(size, card, number) for number in range(size.pair_runs)]
    return of_pairs(card, runs.in_space(scene, design, mass, starts, RATE_HZ, endless=True))


def pairs_in_plane(size: Size, card: Card) -> Cases:
    """Quantities of pairs in the plane, from places drawn alike."""
    starts = [pair_places(size, card, number) for number in range(MORE_PAIRS * size.pair_runs)]
    side = APART * (_side(len(starts[0]) // 2) + 1)
    return of_pairs(card, runs.in_plane(card, Dish("periodic", (side,)), starts, PAIR_S, RATE_HZ, size.seed))


def pair_places(size: Size, card: Card, number: int) -> Array:
    """Places of all pairs of a run, those of one meeting one after the other, shape (N, 3)."""
    rng = np.random.default_rng(np.random.SeedSequence([size.seed, number], spawn_key=(2,)))
    outline, count = np.array(card.outline_mm[0]), len(MEETINGS) * size.pairs
    side, rows = _side(count), []
    for pair in range(count):
        two = meetings.places(MEETINGS[pair // size.pairs], outline, rng)
        two[:, :2] += APART * (np.array(divmod(pair, side)) - 0.5 * (side - 1))
        rows.append(two)
    return np.concatenate(rows)


def of_pairs(card: Card, made: list[Run]) -> Cases:
    """Means over all pairs that met, of all runs."""
    outline, cases = np.array(card.outline_mm[0]), dict[str, dict[str, list[float]]]()
    for run in made:
        share = run.poses.shape[1] // 2 // len(MEETINGS)
        for pair in range(share * len(MEETINGS)):
            meeting = MEETINGS[pair // share]
            two = run.poses[:, 2 * pair : 2 * pair + 2]
            for key, number in (meetings.seen(meeting, outline, two) or {}).items():
                cases.setdefault(meeting.name, {}).setdefault(key, []).append(number)
    return {
        case: {key: mean(key, meetings.UNITS[key], values) for key, values in numbers.items()}
        for case, numbers in cases.items()
    }


def crowd_in_space(size: Size, design: Design, mass: MassProperties, card: Card) -> Cases:
    """Quantities of the crowd in space."""
    scene = _crowd_scene(size, size.crowd_runs)
    whole = {"seconds": size.crowd_seconds + size.crowd_discard_seconds, "discard_seconds": 0.0}
    undiscarded = scene.model_copy(update={"run": scene.run.model_copy(update=whole)})
    starts = [crowd_places(size, card, scene, number) for number in range(size.crowd_runs)]
    return of_crowd(size, card, scene, runs.in_space(undiscarded, design, mass, starts, CROWD_RATE_HZ, endless=False))


def crowd_in_plane(size: Size, card: Card) -> Cases:
    """Quantities of the crowd in the plane, from places drawn alike."""
    scene = _crowd_scene(size, MORE_CROWDS * size.crowd_runs)
    starts = [crowd_places(size, card, scene, number) for number in range(scene.run.runs)]
    whole = size.crowd_seconds + size.crowd_discard_seconds
    made = runs.in_plane(card, scene.crowd.dish, starts, whole, CROWD_RATE_HZ, size.seed)
    return of_crowd(size, card, scene, made)


def crowd_places(size: Size, card: Card, scene: Scene, number: int) -> Array:
    """Places of all walkers of a run, shape (N, 3)."""
    rng = np.random.default_rng(np.random.SeedSequence([size.seed, number], spawn_key=(1,)))
    return place([_outline(card)] * COUNT, scene.crowd.dish, rng, CLEARANCE_MM)


def of_crowd(size: Size, card: Card, scene: Scene, made: list[Run]) -> Cases:
    """Means over runs of the statistics that every run has."""
    films = []
    for run in made:
        kept = run.times >= size.crowd_discard_seconds - 1e-9
        times, kinds = run.times[kept] - run.times[kept][0], [card.name] * COUNT
        films.append(of_places(times, run.poses[kept], kinds, {card.name: _outline(card)}, scene.crowd.dish))
    by_run = measure(films).by_run
    known = [key for key in CROWD if np.isfinite(by_run[key]).all()]
    return {f"{COUNT} in {DISH}": {key: mean(key, UNITS[key], by_run[key]) for key in known}}


def _side(count: int) -> int:
    """Pairs along a side of the square that holds so many."""
    return math.ceil(math.sqrt(count))


def _crowd_scene(size: Size, number: int) -> Scene:
    return setting.scene(size, size.crowd_seconds, size.crowd_discard_seconds, number)


def _outline(card: Card) -> tuple[Array, ...]:
    return tuple(np.array(contour) for contour in card.outline_mm)
