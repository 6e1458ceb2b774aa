"""Walls about walkers: found by the hull of their tracks, and kept out of what is measured of free motion.

A pair of times counts only if the first place is so far from every wall that none could be reached in between at the
highest speed. To cut tracks where they meet a wall would favour walkers that turn away in time.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import lag_sums
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.dish import Dish
from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity

BAND_DEPTH, INSIDE_DEPTH = 0.05, 0.15
"""Depths below the hull of the tracks, as shares of its width, of a band along it and of its inside."""

MIN_PLACES, MIN_VISITS, MIN_INSIDE_SHARE = 100, 4, 0.1
"""Minimum numbers of places and of visits of the band from inside, and minimum share inside, for a hull that may be a
wall."""

MIN_CROWDING = 2.1
"""Minimum ratio of the band's share of the places to its share of the area. Walkers along a wall have 2.2 or more, free
ones 1.9 or less."""

PRESSED_CROWDING, PRESSED_INSIDE_SHARE = 3.6, 0.01
"""The same, and the share that is inside, of walkers that hardly leave their walls."""

SLIDING_DEPTH, MIN_SLIDING_SHARE, MIN_CROSSING_SHARE, MIN_CORNERED_GIRTH = 0.01, 0.5, 0.005, 1.15
"""Walkers that slide along walls: depth (share of the width), least share of the places within it, least share inside,
and least squared girth of the hull over that of a disc. Free walkers have 0.42 or less within this depth, except on a
circle, never inside and with a girth near 1 (square: 1.27)."""

EVEN_CROWDING, STATIONARY_SHARES = 0.8, ((32, 0.4), (16, 0.5))
"""The same ratio for walkers that turn back at a wall, with a constant squared displacement: from these parts of the
longest track on, at least this share of that of unrelated places."""

LAG_COUNT, LAST_LAG_DIVISOR = 12, 8
"""Number of lags with a constant squared displacement, up to this part of the longest track."""

VELOCITY_S = 0.04
"""Time over which displacements are velocities, s."""

SPEED_QUANTILE = 0.995
"""Quantile of the displacements that gives the speed toward walls."""

TOUCHING_DEPTH, AWAY_DEPTH, MIN_DEPTH_SHARE = 0.5, 3.0, 0.01
"""Maximum depth of a walker at a wall, minimum depth of one that left it (in steps of its velocity), and least such
step over the width."""

MAX_OUTLIER_SHARE, MAX_PEELS = 0.002, 5
"""Maximum share of the places beyond the hull, and maximum number of rounds that remove its corners."""

STILL_TOLERANCE = 1e-9
"""Share of the extent below which a displacement is none."""


class Walls(NamedTuple):
    """Walls about walkers."""

    edges: Array
    """Edges of the hull: outward normals and their distances from the origin, mm, shape (edges, 3)."""
    dish: Dish | None
    """Dish with given walls; None if the hull of the tracks gives them."""
    middle: Array
    """Middle of the hull, mm."""
    closest: float
    """Distance between a given dish's wall and the outermost places, mm: a walker is no point."""
    speed: float
    """Speed that walkers may reach walls with, mm/s."""
    contacts: Quantity
    """Runs into a wall, 1/s, with the error of Poisson's law."""
    along: float
    """Share of the time that a walker was at a wall."""
    extent: tuple[float, float]
    """Length along x and width along y of the places, mm."""

    @property
    def description(self) -> str:
        """Walls, and what is measured between them, in words."""
        size = " x ".join(formatting.format_number(width, 3) for width in self.extent)
        source = f"of ‹arena=›{self.dish.words}" if self.dish else f"about {size} mm, by the hull of the tracks"
        return (
            f"walls {source}: run into {formatting.format_with_error(*self.contacts.pair)} times a second, "
            f"{formatting.format_number(100 * self.along, 2)} % of the time along them; numbers are of free "
            "motion, from places without a wall in reach"
        )

    def distance(self, places: Array) -> Array:
        """Return the distance of places, shape (n, 2), from the nearest wall, mm; below 0 beyond it."""
        if self.dish is not None:
            return _dish_distance(self.dish, places - self.middle) - self.closest
        depths = [offset - places @ normal for normal, offset in ((edge[:2], float(edge[2])) for edge in self.edges)]
        return np.asarray(np.min(depths, axis=0))


def find_walls(tracks: Tracks, dish: Dish | None = None) -> Walls | None:
    """Find the walls about walkers on a plane: those of `dish`, or those that the tracks show.

    None without walls, in a lane, and for a periodic dish.
    """
    if tracks.lane or (dish is not None and dish.period):
        return None
    step = max(round(VELOCITY_S / tracks.interval), 1)
    lengths = np.concatenate([np.hypot(*_displacements(track, step).T) for track in tracks.tracks])
    lengths = lengths[~np.isnan(lengths)]
    places = np.concatenate([track.position for track in tracks.tracks])
    places = places[~np.isnan(places).any(axis=1)]
    width = float(np.ptp(places, axis=0).min()) if len(places) >= MIN_PLACES else 0.0
    if width <= STILL_TOLERANCE * np.abs(places).max(initial=0.0) or not len(lengths) or not np.median(lengths) > 0.0:
        return None
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    speed = float(np.quantile(lengths, SPEED_QUANTILE)) / (step * tracks.interval)
    closest = 0.0 if dish is None else float(np.quantile(_dish_distance(dish, places - middle), 1.0 - SPEED_QUANTILE))
    extent = (float(np.ptp(places[:, 0])), float(np.ptp(places[:, 1])))
    edges, area, girth = _convex_hull(places)
    walls = Walls(edges, dish, middle, closest, speed, Quantity("wall_contacts", "per_s", None), 0.0, extent)
    depths = [walls.distance(track.position) for track in tracks.tracks]
    goes_around = float(lengths.sum()) / step > girth
    cornered = girth**2 > MIN_CORNERED_GIRTH * 4.0 * math.pi * area
    slides = goes_around and _is_sliding(depths, width, cornered)
    if dish is None and not slides and not _is_confining(tracks, places, depths, width, area, girth):
        return None
    size = max(float(np.median(lengths)), MIN_DEPTH_SHARE * width)
    contacts = sum(_count_visits(depth, TOUCHING_DEPTH * size, AWAY_DEPTH * size) for depth in depths)
    seconds = len(places) * tracks.interval
    rate = Quantity("wall_contacts", "per_s", contacts / seconds, math.sqrt(max(contacts, 1)) / seconds)
    return walls._replace(
        contacts=rate, along=float((np.concatenate(depths) < TOUCHING_DEPTH * size).sum()) / len(places)
    )


def _is_sliding(depths: Sequence[Array], width: float, cornered: bool) -> bool:
    """Return whether walkers mostly slide along their hull, and cross it or follow its corners (`cornered`).

    `depths` below the hull by track, and its `width`, mm.
    """
    depth = np.concatenate(depths)
    depth = depth[~np.isnan(depth)]
    visits = sum(_count_visits(each, BAND_DEPTH * width, INSIDE_DEPTH * width) for each in depths)
    thin, inside = (depth < SLIDING_DEPTH * width).mean(), (depth > INSIDE_DEPTH * width).mean()
    return bool(thin > MIN_SLIDING_SHARE and (cornered or (visits and inside > MIN_CROSSING_SHARE)))


def _is_confining(
    tracks: Tracks, places: Array, depths: Sequence[Array], width: float, area: float, girth: float
) -> bool:
    """Return whether the hull holds walkers back; `depths` below it by track, its width and perimeter in mm."""
    band = BAND_DEPTH * width
    visits = sum(_count_visits(depth, band, INSIDE_DEPTH * width) for depth in depths)
    depth = np.concatenate(depths)
    depth = depth[~np.isnan(depth)]
    inside = float((depth > INSIDE_DEPTH * width).mean())
    crowding = float((depth < band).mean()) * area / (band * girth - math.pi * band**2)
    if visits < MIN_VISITS or inside < (PRESSED_INSIDE_SHARE if crowding > PRESSED_CROWDING else MIN_INSIDE_SHARE):
        return False
    return crowding > MIN_CROWDING or (crowding > EVEN_CROWDING and _is_stationary(tracks, places))


def _is_stationary(tracks: Tracks, places: Array) -> bool:
    """Return whether squared displacements are those of unrelated `places` (mm), from short lags on."""
    longest = max(len(track.position) for track in tracks.tracks)
    lags = lag_sums.log_spaced_lags(longest // LAST_LAG_DIVISOR, LAG_COUNT, max(longest // STATIONARY_SHARES[0][0], 1))
    squares, pairs = np.sum([lag_sums.sum_squares(track.position, lags) for track in tracks.tracks], axis=0)
    share = squares / np.maximum(pairs, 1.0) / (2.0 * float(places.var(axis=0).sum()))
    return all((share[lags >= longest // part] > least).all() for part, least in STATIONARY_SHARES)


def _count_visits(depth: Array, near: float, away: float) -> int:
    """Count how often a walker comes to a wall, nearer than `near`, after it was farther than `away` (mm)."""
    states = np.where(depth < near, 1, np.where(depth > away, -1, 0))
    states = states[states != 0]
    return int((np.diff(states) > 0).sum())


def add_wall_reach(tracks: Tracks, walls: Walls) -> Tracks:
    """Return the tracks with `reach`: the number of samples after each place in which no wall can be reached."""
    step_mm = walls.speed * tracks.interval
    tracks_with_reach = []
    for track in tracks.tracks:
        reach = (
            np.floor(walls.distance(track.position) / step_mm) - 1.0
        )  # noise may have moved the place by a frame's way
        tracks_with_reach.append(track._replace(reach=np.where(np.isnan(reach), -1, reach).astype(np.int64)))
    return tracks._replace(tracks=tuple(tracks_with_reach))


def _displacements(track: Track, step: int) -> Array:
    """Return the displacements over `step` samples before each sample, shape (times, 2), mm; NaN if unknown."""
    moved = np.full(track.position.shape, np.nan)
    moved[step:] = track.position[step:] - track.position[:-step]
    return moved


def _convex_hull(places: Array) -> tuple[Array, float, float]:
    """Return edges (see `Walls.edges`), area (mm^2) and perimeter (mm) of the hull of places, less a few outermost."""
    from scipy.spatial import ConvexHull

    fewest = (1.0 - MAX_OUTLIER_SHARE) * len(places)
    hull = ConvexHull(places)
    for _ in range(MAX_PEELS):
        inner = np.delete(places, hull.vertices, axis=0)
        if len(inner) < fewest:
            break
        places, hull = inner, ConvexHull(inner)
    return np.asarray(hull.equations * (1.0, 1.0, -1.0)), float(hull.volume), float(hull.area)


def _dish_distance(dish: Dish, places: Array) -> Array:
    """Return the distance of places, relative to the middle of a dish, from its nearest wall, mm."""
    if dish.kind == "rectangle":
        return np.asarray(np.min(0.5 * np.array(dish.sizes) - np.abs(places), axis=1))
    radius = np.hypot(*places.T)
    outer = 0.5 * dish.sizes[0] - radius
    return np.asarray(np.minimum(outer, radius - 0.5 * dish.sizes[1]) if dish.kind == "ring" else outer)
