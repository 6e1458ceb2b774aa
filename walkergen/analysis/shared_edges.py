"""Edges that passes of walkers share, straight or round, tested against free motion of the same length.

A pass comes to an edge from inside and leaves it again: tracks that end at the edge of a picture are none. Walkers that
slide share edges in few, long passes, whose length counts as well. Free motion is that of the same walkers: blocks of
their steps and turns in random order, from the same places.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis.tracks import Track
from walkergen.core.dish import Dish
from walkergen.core.numerics import Array, Complex, Mask, Whole

FREE_MOTIONS, FIRST_MOTIONS = 2000, 20
"""Number of free motions, all with fewer passes or all with shorter ones (together p < 0.001), and of the first."""

MAX_GAP, MAX_SAMPLES, STEP_SHARE = 5, 2000, 0.01
"""Longest gap (samples) that is bridged, most samples that are tested, and their step over the width of the places."""

NEAR_SHARE, AWAY_SHARE = 0.01, 0.15
"""Depths below an edge, over the width, of a walker at the edge and of one that has left it."""

OUTSIDE_SHARE = 0.001
"""Share of the places that may lie beyond an edge: noise, or a wrong link."""

MIN_EDGES, MIN_PASSES = 3, 5
"""Least number of edges of a rectangle with a pass, and of passes in all."""

MAX_TURN_DEG = 1.0
"""Angle of a rectangle from the axes, deg, up to which it counts as parallel to them."""

SUPPORT_DIRECTIONS = np.exp(1j * np.pi * np.arange(8) / 8)
"""Directions in which the width of the places gives a circle."""

BLOCKS = 20
"""Number of blocks of steps of a track."""


class SharedEdges(NamedTuple):
    """Edges that passes share."""

    dish: Dish
    """Disc or rectangle with these edges, to three digits."""
    turned_deg: float
    """Angle from x to the rectangle's nearest side, deg; 0 for a disc."""
    passes: int


class _Paths(NamedTuple):
    """Paths without gaps, one after the other."""

    places: Complex
    """Places, mm, shape (motions, samples)."""
    starts: Whole
    """Index of the first sample of each path."""
    step: float
    """Median step, mm."""


def find(tracks: Sequence[Track]) -> SharedEdges | None:
    """Return a dish's edges if more, or longer, passes run along them than in each of FREE_MOTIONS free motions.

    A pass is a stretch of a track along an edge. The result is None without such edges.
    """
    paths, rng = _join_paths(tracks), np.random.default_rng(0)
    if paths is None:
        return None
    turned, is_round = _choose_shape(paths.places[0])
    paths = paths._replace(places=paths.places * np.exp(-1j * turned))
    counts, sizes, lengths = _count_passes(paths, is_round)
    passes, more = int(counts.sum()), True
    longer = is_round or abs(math.degrees(turned)) < MAX_TURN_DEG  # a long straight run turns the rectangle to itself
    if passes < MIN_PASSES or (counts > 0).sum() < (1 if is_round else MIN_EDGES):
        return None
    for motions in (FIRST_MOTIONS, *(100,) * (FREE_MOTIONS // 100)):
        free_counts, _, free_lengths = _count_passes(paths._replace(places=_move_freely(paths, motions, rng)), is_round)
        more &= bool((free_counts.sum(axis=0) < passes).all())
        longer &= bool((free_lengths < lengths[0]).all())
        if not (more or longer):
            return None
    dish = Dish("disc" if is_round else "rectangle", tuple(float(f"{size[0]:.3g}") for size in sizes))
    return SharedEdges(dish, 0.0 if is_round else math.degrees(turned), passes)


def _join_paths(tracks: Sequence[Track]) -> _Paths | None:
    """Return the tracks as paths without gaps, with steps of about STEP_SHARE; None if places or widths are too few."""
    parts: list[Complex] = []
    for track in tracks:
        places = track.position @ np.array([1.0, 1.0j])
        seen = np.flatnonzero(~np.isnan(places))
        for part in np.split(seen, np.flatnonzero(np.diff(seen) > MAX_GAP) + 1):
            if len(part) > BLOCKS:
                parts.append(np.interp(np.arange(part[0], part[-1] + 1), part, places[part]))
    if not parts:
        return None
    whole, steps = np.concatenate(parts), np.concatenate([np.abs(np.diff(part)) for part in parts])
    width = min(float(np.ptp(whole.real)), float(np.ptp(whole.imag)))
    moving = steps[steps > 0.0]
    stride = max(int(STEP_SHARE * width / float(np.median(moving))), 1) if len(moving) else 1
    parts = [part[::stride] for part in parts if len(part) > BLOCKS * stride]
    share = MAX_SAMPLES / max(sum(map(len, parts)), MAX_SAMPLES)
    parts = [part[: max(int(share * len(part)), BLOCKS + 1)] for part in parts]
    if not parts:
        return None
    step = float(np.median(np.concatenate([np.abs(np.diff(part)) for part in parts])))
    starts = np.cumsum([0, *map(len, parts[:-1])])
    return _Paths(np.concatenate(parts)[None], starts, step) if 3.0 * step < AWAY_SHARE * width else None


def _choose_shape(places: Complex) -> tuple[float, bool]:
    """Return the angle (rad) of the smallest rectangle around places, and whether a disc fits them better."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(np.stack([places.real, places.imag], axis=1))
    corners = places[hull.vertices]
    angles = np.angle(np.roll(corners, -1) - corners) % (0.5 * np.pi)
    turned = corners * np.exp(-1j * angles[:, None])
    areas = np.ptp(turned.real, axis=1) * np.ptp(turned.imag, axis=1)
    angle = float(angles[np.argmin(areas)])
    radius = float(_fit_circle(places[None])[1][0])
    is_round = abs(math.log(hull.volume / (math.pi * radius**2))) < abs(math.log(hull.volume / areas.min()))
    return angle - (0.5 * np.pi if angle > 0.25 * np.pi else 0.0), is_round


def _fit_circle(places: Complex) -> tuple[Complex, Array]:
    """Return the middles and radii of circles around rows of places, by their extent in SUPPORT_DIRECTIONS."""
    ends = [_ends((places * np.conj(direction)).real) for direction in SUPPORT_DIRECTIONS]
    middle = sum(direction * (low + high) for direction, (low, high) in zip(SUPPORT_DIRECTIONS, ends, strict=True))
    return middle / len(ends), np.asarray(sum(high - low for low, high in ends) / (2.0 * len(ends)))


def _ends(values: Array) -> tuple[Array, Array]:
    """Return values below and above which OUTSIDE_SHARE of each row lies."""
    out = int(OUTSIDE_SHARE * values.shape[1])
    ordered = np.partition(values, (out, values.shape[1] - 1 - out), axis=1)
    return ordered[:, out], ordered[:, -1 - out]


def _count_passes(paths: _Paths, is_round: bool) -> tuple[Whole, list[Array], Array]:
    """Return passes at each edge, shape (edges, motions), diameters or sides, mm, and shares of path length near edges.

    Diameters (a disc), both sides (a rectangle) and shares have an entry for each motion.
    """
    depths, sizes = [], []
    if is_round:
        distance = np.abs(paths.places - _fit_circle(paths.places)[0][:, None])
        radius = _ends(distance)[1]
        depths, sizes = [radius[:, None] - distance], [2.0 * radius]
    else:
        for values in (paths.places.real, paths.places.imag):
            low, high = _ends(values)
            sizes.append(high - low)
            depths += [values - low[:, None], high[:, None] - values]
    nears = [np.maximum(NEAR_SHARE * size, paths.step)[:, None] for size in sizes]
    of_edge = [index * len(sizes) // len(depths) for index in range(len(depths))]
    near = [depth < nears[size] for depth, size in zip(depths, of_edge, strict=True)]
    away = [depth > AWAY_SHARE * sizes[size][:, None] for depth, size in zip(depths, of_edge, strict=True)]
    steps = np.abs(np.diff(paths.places, axis=1))
    steps[:, paths.starts[1:] - 1] = 0.0
    share = (steps * np.logical_or.reduce(near)[:, 1:]).sum(axis=1) / steps.sum(axis=1)
    return np.stack([_count_visits(*states, paths.starts) for states in zip(near, away, strict=True)]), sizes, share


def _count_visits(near: Mask, away: Mask, starts: Whole) -> Whole:
    """Count how often each motion comes near from away, and leaves again, within a path."""
    states = near.astype(np.int8) - away
    left = np.logical_or.reduceat(states < 0, starts, axis=1).sum(axis=1)
    states[:, starts] = states[:, starts - 1] = 1  # ends of a path are no visits
    rows = np.nonzero(states)[0]
    order = states[states != 0]
    visits = np.bincount(rows[1:][np.diff(order) > 0], minlength=len(states))
    return np.asarray(np.maximum(visits - left, 0))


def _move_freely(paths: _Paths, motions: int, rng: np.random.Generator) -> Complex:
    """Return the places of free motions with the steps and turns of the paths in blocks of random order."""
    moved = []
    for path in np.split(paths.places[0], paths.starts[1:]):
        steps = np.diff(path)
        count = len(steps) // BLOCKS
        starts = rng.integers(0, len(steps) - count + 1, (motions, len(steps) // count + 1))
        blocks = (starts[..., None] + np.arange(count)).reshape(motions, -1)[:, : len(steps)]
        lengths = np.abs(steps)
        headings = np.divide(steps, lengths, out=np.ones_like(steps), where=lengths > 0.0)
        turns = (headings * np.conj(np.roll(headings, 1)))[blocks]
        turns[:, 0] = np.exp(1j * rng.uniform(-np.pi, np.pi, motions))
        free = np.cumsum(lengths[blocks] * np.cumprod(turns, axis=1), axis=1)
        moved.append(path[0] + np.pad(free, ((0, 0), (1, 0))))
    return np.concatenate(moved, axis=1)
