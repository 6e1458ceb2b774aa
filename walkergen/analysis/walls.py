"""Walls about walkers: given, or proven by their tracks, and kept out of what is measured of free motion.

A pair of times counts only if the first place is so far from every wall that none could be reached in between at the
highest speed. To cut tracks where they meet a wall would favour walkers that turn away in time.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.analysis import shared_edges
from walkergen.analysis.shared_edges import SharedEdges
from walkergen.analysis.tracks import Tracks
from walkergen.core.dish import Dish
from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity

MIN_PLACES = 100
"""Minimum number of places that may show walls."""

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
    """Dish with given walls; None if the tracks prove them, and their hull gives the distances."""
    middle: Array
    """Middle of the hull, mm."""
    slack: Array
    """Lengths along x and y by which a given dish exceeds the places, mm: its middle is known so well."""
    speed: float
    """Speed that walkers may reach walls with, mm/s."""
    contacts: Quantity
    """Runs into a wall, 1/s, with the error of Poisson's law."""
    along: float
    """Share of the time that a walker was at a wall."""
    extent: tuple[float, float]
    """Length along x and width along y of the places, mm."""
    shared: SharedEdges | None = None
    """Edges that prove the walls; None if these are given."""

    @property
    def description(self) -> str:
        """Walls, and what is measured between them, in words."""
        named = f"walls of ‹arena=›{self.dish.words}" if self.dish else ""
        if self.shared is not None:
            sizes = " x ".join(f"{size:g}" for size in self.shared.dish.sizes)
            angle = self.shared.turned_deg
            turned = f" turned by {angle:.1f} deg" if abs(angle) > shared_edges.MAX_TURN_DEG else ""
            state = "Give" if turned else f"State them with ‹arena=›{self.shared.dish.words}, or"
            named = (
                f"Walls found: {self.shared.dish.kind} {sizes} mm{turned} ({self.shared.passes} passes share its "
                f"edges). {state} ‹arena=›open{' if there are none' if turned else ''}. They are"
            )
        return (
            f"{named}{'' if self.shared else ':'} run into {formatting.format_with_error(*self.contacts.pair)} times a "
            f"second, {formatting.format_number(100 * self.along, 2)} % of the time along them; numbers are of free "
            "motion, from places without a wall in reach"
        )

    def distance(self, places: Array) -> Array:
        """Return the distance of places, shape (n, 2), from the nearest wall, mm; below 0 beyond it."""
        if self.dish is not None:
            return _dish_distance(self.dish, places - self.middle, self.slack)
        depths = [offset - places @ normal for normal, offset in ((edge[:2], float(edge[2])) for edge in self.edges)]
        return np.asarray(np.min(depths, axis=0))


def find_walls(tracks: Tracks, dish: Dish | None = None) -> Walls | None:
    """Find the walls about walkers on a plane: those of `dish`, or those that the tracks show.

    None without walls, in a lane, and for a periodic dish.
    """
    if tracks.lane or (dish is not None and dish.period):
        return None
    step = max(round(VELOCITY_S / tracks.interval), 1)
    lengths = np.concatenate([np.hypot(*(each.position[step:] - each.position[:-step]).T) for each in tracks.tracks])
    lengths = lengths[~np.isnan(lengths)]
    places = np.concatenate([track.position for track in tracks.tracks])
    places = places[~np.isnan(places).any(axis=1)]
    width = float(np.ptp(places, axis=0).min()) if len(places) >= MIN_PLACES else 0.0
    if width <= STILL_TOLERANCE * np.abs(places).max(initial=0.0) or not len(lengths) or not np.median(lengths) > 0.0:
        return None
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    speed = float(np.quantile(lengths, SPEED_QUANTILE)) / (step * tracks.interval)
    extent = (float(np.ptp(places[:, 0])), float(np.ptp(places[:, 1])))
    shared = None
    if dish is None and (shared := shared_edges.find(tracks.tracks)) is None:
        return None
    none = Quantity("wall_contacts", "per_s", None)
    slack = np.zeros(2) if dish is None else np.maximum(np.array(dish.box) - extent, 0.0)
    walls = Walls(_convex_hull(places), dish, middle, slack, speed, none, 0.0, extent, shared)
    depths = [walls.distance(track.position) for track in tracks.tracks]
    size = max(float(np.median(lengths)), MIN_DEPTH_SHARE * width)
    contacts = sum(_count_visits(depth, TOUCHING_DEPTH * size, AWAY_DEPTH * size) for depth in depths)
    seconds = len(places) * tracks.interval
    rate = Quantity("wall_contacts", "per_s", contacts / seconds, math.sqrt(max(contacts, 1)) / seconds)
    return walls._replace(
        contacts=rate, along=float((np.concatenate(depths) < TOUCHING_DEPTH * size).sum()) / len(places)
    )


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
        # Noise may have moved the place by a frame's way
        reach = np.floor(walls.distance(track.position) / step_mm) - 1.0
        tracks_with_reach.append(track._replace(reach=np.where(np.isnan(reach), -1, reach).astype(np.int64)))
    return tracks._replace(tracks=tuple(tracks_with_reach))


def _convex_hull(places: Array) -> Array:
    """Return the edges (see `Walls.edges`) of the hull of places, less a few outermost."""
    from scipy.spatial import ConvexHull

    fewest = (1.0 - MAX_OUTLIER_SHARE) * len(places)
    hull = ConvexHull(places)
    for _ in range(MAX_PEELS):
        inner = np.delete(places, hull.vertices, axis=0)
        if len(inner) < fewest:
            break
        places, hull = inner, ConvexHull(inner)
    return np.asarray(hull.equations * (1.0, 1.0, -1.0))


def _dish_distance(dish: Dish, places: Array, slack: Array) -> Array:
    """Return the least distance (mm) of places, relative to the middle of theirs, from a wall of a dish.

    The dish exceeds the places by `slack` along x and y, mm, because a walker is no point or was not everywhere.
    """
    if dish.kind == "rectangle":
        return np.asarray(np.min(0.5 * (np.array(dish.sizes) - slack) - np.abs(places), axis=1))
    radius, margin = np.hypot(*places.T), 0.5 * math.hypot(*slack)
    outer = 0.5 * dish.sizes[0] - radius
    inner = radius - 0.5 * dish.sizes[1] if dish.kind == "ring" else outer
    return np.asarray(np.minimum(outer, inner) - margin)
