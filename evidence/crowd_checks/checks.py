"""Two checks, each in space and in a plane: a walker alone, and pairs that meet in four ways.

Each returns its quantities by case: what space has and what the plane has by the same keys.
"""

import math
from collections.abc import Mapping

import numpy as np

from evidence.crowd_checks import meetings, runs, setting
from evidence.crowd_checks.meetings import MEETINGS, Meeting
from evidence.crowd_checks.runs import Run
from evidence.crowd_checks.setting import RATE_HZ, Size
from walkergen.analysis import tracks
from walkergen.core.dish import Dish
from walkergen.core.files.progress import silent
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.guests.crowd.cards import make, walker_motion
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.cards.walker_motion import Measured

Cases = Mapping[str, Mapping[str, Quantity]]
"""Quantities by the name of a case and their key."""

ALONE_PER_SIDE = 8
"""Walkers alone along a side of the plane: so many squared."""

DISCARDED_S = 1.0
"""Start of a run alone that is left out, s."""

PAIR_DISTANCE_MM = 150.0
"""Distance of pairs, mm: no pair reaches another."""

PAIR_S = 1.0
"""Time of a run of pairs: 0.3 s until two meet, 0.3 s of observation, and as much again for late meetings."""

ALONE_UNITS = (
    ("speed", "mm_s"),
    ("turning", "rad_s"),
    ("D_R", "rad2_s"),
    ("D_T", "mm2_s"),
    ("velocity_relaxes_within", "s"),
    ("turning_relaxes_within", "s"),
    ("delay", "s"),
)
"""Keys and units of a walker alone."""


def simulate_alone_in_space(size: Size, design: Design, mass: MassProperties) -> tuple[Card, Cases]:
    """Card of the walker, and its quantities."""
    scene = setting.make_scene(size, size.alone_seconds, DISCARDED_S, size.alone_runs)
    measured = walker_motion.simulate_walker(scene, design, mass, silent)
    return make.make_card(scene, design, mass, measured), motion_quantities(measured)


def simulate_alone_in_plane(size: Size, card: Card) -> Cases:
    """Quantities of walkers of a card in a plane, so far apart that none meets another."""
    seconds = DISCARDED_S + size.alone_seconds
    apart = 4.0 * (card.length_mm + abs(card.speed_mm_s.number) * seconds)
    line = (np.arange(ALONE_PER_SIDE) - 0.5 * (ALONE_PER_SIDE - 1)) * apart
    x, y = np.meshgrid(line, line)
    rng = np.random.default_rng(np.random.SeedSequence(size.seed, spawn_key=(3,)))
    start = np.column_stack((x.ravel(), y.ravel(), rng.uniform(-math.pi, math.pi, ALONE_PER_SIDE**2)))
    (run,) = runs.simulate_in_plane(
        card, Dish("periodic", (ALONE_PER_SIDE * apart,)), [start], seconds, RATE_HZ, size.seed
    )
    kept = run.poses[run.times >= DISCARDED_S - 1e-9]
    own = tracks.from_positions([kept[:, i] for i in range(ALONE_PER_SIDE**2)], 1.0 / RATE_HZ, lane=False)
    return motion_quantities(walker_motion.measure_tracks(own, True, ()))


def motion_quantities(measured: Measured) -> Cases:
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
    named = zip(ALONE_UNITS, estimates, strict=True)
    return {"alone": {key: own._replace(key=key, unit=unit) for (key, unit), own in named}}


def simulate_pairs_in_space(size: Size, design: Design, mass: MassProperties, card: Card) -> tuple[Cases, Cases]:
    """Quantities of pairs in space, let go at rest over their places, and what their friction gave, by meeting."""
    scene, seen, rubbed = setting.make_scene(size, PAIR_S, 0.0, size.pair_runs), {}, {}
    for meeting in MEETINGS:
        starts = [pair_places(size, card, meeting, number) for number in range(size.pair_runs)]
        made = runs.simulate_in_space(scene, design, mass, starts, RATE_HZ, endless=True)
        seen[meeting.name] = pair_quantities(card, meeting, made)
        impulses = [run.impulses for run in made if run.impulses and run.impulses.normal]
        shares = {"along": [i.along / i.normal for i in impulses], "up": [i.up / i.normal for i in impulses]}
        rubbed[meeting.name] = {key: mean(key, "", values) for key, values in shares.items()}
    return seen, rubbed


def simulate_pairs_in_plane(size: Size, card: Card) -> Cases:
    """Quantities of pairs in the plane, from places drawn alike."""
    dish, seen = Dish("periodic", (PAIR_DISTANCE_MM * (_pairs_per_side(size.pairs) + 1),)), {}
    for meeting in MEETINGS:
        starts = [
            pair_places(size, card, meeting, number) for number in range(setting.PLANE_RUNS_PER_RUN * size.pair_runs)
        ]
        made = runs.simulate_in_plane(card, dish, starts, PAIR_S, RATE_HZ, size.seed)
        seen[meeting.name] = pair_quantities(card, meeting, made)
    return seen


def pair_places(size: Size, card: Card, meeting: Meeting, number: int) -> Array:
    """Places of all pairs of a run, shape (N, 3)."""
    rng = np.random.default_rng(np.random.SeedSequence([size.seed, number, MEETINGS.index(meeting)], spawn_key=(2,)))
    outline, side, rows = np.array(card.outline_mm[0]), _pairs_per_side(size.pairs), []
    for pair in range(size.pairs):
        two = meetings.start_places(meeting, outline, rng)
        two[:, :2] += PAIR_DISTANCE_MM * (np.array(divmod(pair, side)) - 0.5 * (side - 1))
        rows.append(two)
    return np.concatenate(rows)


def pair_quantities(card: Card, meeting: Meeting, made: list[Run]) -> Mapping[str, Quantity]:
    """Means over all pairs that met, of all runs."""
    outline, numbers = np.array(card.outline_mm[0]), dict[str, list[float]]()
    for run in made:
        for pair in range(run.poses.shape[1] // 2):
            two = run.poses[:, 2 * pair : 2 * pair + 2]
            for key, number in (meetings.measure_meeting(meeting, outline, two) or {}).items():
                numbers.setdefault(key, []).append(number)
    return {key: mean(key, meetings.UNITS[key], values) for key, values in numbers.items()}


def set_friction(card: Card, rubbed: Cases) -> Card:
    """Card with the friction in the plane that pairs in space measured, the mean over the meetings."""
    return card.model_copy(update={"friction": sum(one["along"].number for one in rubbed.values()) / len(rubbed)})


def _pairs_per_side(count: int) -> int:
    """Pairs along a side of the square that holds so many."""
    return math.ceil(math.sqrt(count))
