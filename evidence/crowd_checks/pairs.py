"""Binary check: pairs of walkers that meet in four ways, in space and in a plane."""

import math

import numpy as np

from evidence.crowd_checks import meetings, runs, setting
from evidence.crowd_checks.meetings import MEETINGS
from evidence.crowd_checks.runs import Array, Run
from evidence.crowd_checks.setting import RATE_HZ, Size
from walkergen.analysis.values import Value, mean
from walkergen.crowd.card import Card
from walkergen.dish import Dish
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

APART = 150.0
"""Distance of pairs, mm: no pair reaches another."""

SECONDS = 1.0
"""Time of a run: 0.3 s until two meet, 0.3 s in which they are watched, and as much again for
those that meet late, edge on edge."""

PLANES = 4
"""Runs in the plane for each in space: they cost little."""

Numbers = dict[tuple[str, str], Value]
"""Numbers by the name of a meeting and the quantity, means over pairs."""


def in_space(size: Size, design: Design, mass: MassProperties, card: Card) -> Numbers:
    """Numbers of pairs in space, let go at rest over their places."""
    scene = setting.scene(size, SECONDS, 0.0, size.pair_runs)
    starts = [places(size, card, number) for number in range(size.pair_runs)]
    return numbers(card, runs.in_space(scene, design, mass, starts, RATE_HZ, endless=True))


def in_plane(size: Size, card: Card) -> Numbers:
    """Numbers of pairs in the plane, from places drawn alike."""
    starts = [places(size, card, number) for number in range(PLANES * size.pair_runs)]
    side = APART * (_side(len(starts[0]) // 2) + 1)
    made = runs.in_plane(card, Dish("periodic", (side,)), starts, SECONDS, RATE_HZ, size.seed)
    return numbers(card, made)


def places(size: Size, card: Card, number: int) -> Array:
    """Places of all pairs of a run, those of one meeting one after the other, shape (N, 3)."""
    rng = np.random.default_rng(np.random.SeedSequence([size.seed, number], spawn_key=(2,)))
    outline, count = np.array(card.outline_mm[0]), len(MEETINGS) * size.pairs
    side, rows = _side(count), []
    for pair in range(count):
        two = meetings.places(MEETINGS[pair // size.pairs], outline, rng)
        two[:, :2] += APART * (np.array(divmod(pair, side)) - 0.5 * (side - 1))
        rows.append(two)
    return np.concatenate(rows)


def numbers(card: Card, made: list[Run]) -> Numbers:
    """Means over all pairs that met, of all runs."""
    outline, seen = np.array(card.outline_mm[0]), dict[tuple[str, str], list[float]]()
    for run in made:
        share = run.poses.shape[1] // 2 // len(MEETINGS)
        for pair in range(share * len(MEETINGS)):
            meeting = MEETINGS[pair // share]
            two = run.poses[:, 2 * pair : 2 * pair + 2]
            for quantity, number in (meetings.seen(meeting, outline, two) or {}).items():
                seen.setdefault((meeting.name, quantity), []).append(number)
    return {key: mean(values) for key, values in seen.items() if len(values) > 1}


def _side(count: int) -> int:
    """Pairs along a side of the square that holds so many."""
    return math.ceil(math.sqrt(count))
