"""Settings of a run of a crowd in a plane, checked once."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from walkergen.core import Array, Dish, InputError, Whole
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import discs, lammps_input

MAX_KINDS = 14
"""LAMMPS has 32 groups of particles; a kind takes two."""

MAX_NUMBERS = 2_000_000_000
"""Most numbers in the poses of a run: 16 GB."""

MAX_OVERLAP_MM = 0.05
"""Deepest overlap of two bodies at the start, mm."""


def make_crowd(
    cards: Sequence[Card],
    kinds: npt.ArrayLike,
    dish: Dish,
    places: npt.ArrayLike,
    seconds: float,
    rate_hz: float,
    seed: int,
    running: bool = False,
) -> lammps_input.Crowd:
    """Create the input for a run of N walkers in a dish. Raises InputError for an invalid argument.

    `kinds`: index in `cards` of each walker, shape (N,). `places`: x, y (mm) and heading (rad) without overlaps, shape
    (N, 3). `running`: whether walkers start at the speeds of their cards, instead of at rest.
    """
    if not 1 <= len(cards) <= MAX_KINDS:
        raise argument_error("cards", len(cards), f"1 to {MAX_KINDS} kinds")
    poses, kind_of_walker = np.asarray(places, float), np.asarray(kinds)
    if poses.ndim != 2 or poses.shape[1:] != (3,) or not len(poses):
        raise argument_error("places", poses.shape, "of shape (N, 3), N >= 1")
    if not np.isfinite(poses).all():
        row = int(np.argmin(np.isfinite(poses).all(axis=1)))
        raise argument_error(f"places[{row}]", poses[row].tolist(), "numbers: x, y in mm, heading in rad")
    if kind_of_walker.shape != (len(poses),) or not np.issubdtype(kind_of_walker.dtype, np.integer):
        raise argument_error(
            "kinds", f"{kind_of_walker.dtype} of shape {kind_of_walker.shape}", f"{len(poses)} integers"
        )
    if kind_of_walker.min() < 0 or kind_of_walker.max() >= len(cards):
        raise argument_error("kinds", f"{kind_of_walker.min()} to {kind_of_walker.max()}", f"0 to {len(cards) - 1}")
    for name, value in (("seconds", seconds), ("rate_hz", rate_hz)):
        if not (math.isfinite(value) and value > 0.0):
            raise argument_error(name, value, "> 0")
    if not 0 <= seed < 2**63:
        raise argument_error("seed", seed, "0 to 2^63 - 1")
    count = lammps_input.frame_count(seconds, rate_hz)
    if count < 2 or 3 * count * len(poses) > MAX_NUMBERS:
        raise argument_error(
            "seconds times rate_hz",
            seconds * rate_hz,
            f">= 1, and below {MAX_NUMBERS // (3 * len(poses))} for {len(poses)} walkers",
        )
    turning, indices = _turning_rates(cards, kind_of_walker, seed), kind_of_walker.astype(np.int64)
    crowd = lammps_input.Crowd(cards, indices, dish, poses, turning, seconds, rate_hz, seed, running)
    _check_rate(crowd)
    _check_room(crowd)
    return crowd


def argument_error(name: str, value: object, allowed: str) -> InputError:
    """Return the error for an argument. `allowed` describes the values that it may have."""
    return InputError(f"{name} = {value}: must be {allowed}")


def _turning_rates(cards: Sequence[Card], kinds: Whole, seed: int) -> Array:
    """Draw each walker's mean turning rate, rad/s, shape (N,). A card may have a spread between prints."""
    generator = np.random.default_rng([seed, 1])
    means = np.array([card.turning_rad_s.number for card in cards])
    spreads = np.array([one.turning_sd_rad_s.number if one.turning_sd_rad_s else 0.0 for one in cards])
    return np.asarray(means[kinds] + spreads[kinds] * generator.standard_normal(len(kinds)))


def _check_rate(crowd: lammps_input.Crowd) -> None:
    """Raise InputError if headings may turn by more than half a turn (four standard deviations) between frames."""
    diffusion = max(card.rotational_diffusion_rad2_s.number for card in crowd.cards)
    interval = 1.0 / crowd.rate_hz
    turn = float(np.abs(crowd.turning).max()) * interval + 4.0 * math.sqrt(2.0 * diffusion * interval)
    if turn > math.pi:
        min_rate_hz = crowd.rate_hz * (turn / math.pi) ** 2
        raise argument_error("rate_hz", f"{crowd.rate_hz:g}", f">= {min_rate_hz:.3g}, to follow the headings")


def _check_room(crowd: lammps_input.Crowd) -> None:
    """Raise InputError where bodies overlap each other or a wall, or a periodic dish is too small."""
    shapes = [discs.cover_outline(card, lammps_input.outline_tolerance(crowd.cards)) for card in crowd.cards]
    reach = max(shape.reach for shape in shapes)
    period = crowd.dish.period
    if period and period < 4.0 * reach:
        raise argument_error(f"dish {crowd.dish.words}: side", f"{period:g} mm", f">= {4.0 * reach:.4g} mm")
    points, radii, owners = _place_discs(crowd, shapes)
    gaps = wall_gaps(crowd.dish, points, radii)
    if gaps.min() < -MAX_OVERLAP_MM:
        walker = int(owners[np.argmin(gaps)])
        raise InputError(
            f"places[{walker}] = {crowd.places[walker].round(3).tolist()}: is "
            f"{-gaps.min():.3g} mm inside a wall of {crowd.dish.words}. Move it"
        )
    tree = cKDTree(_wrap_points(points, period), boxsize=period or None)
    pairs = tree.query_pairs(2.0 * float(radii.max()), output_type="ndarray")
    pairs = pairs[owners[pairs[:, 0]] != owners[pairs[:, 1]]]
    apart = points[pairs[:, 0]] - points[pairs[:, 1]]
    if period:
        apart -= period * np.round(apart / period)
    overlaps = radii[pairs].sum(axis=1) - np.hypot(*apart.T)
    if len(overlaps) and overlaps.max() > MAX_OVERLAP_MM:
        first, second = sorted(owners[pairs[np.argmax(overlaps)]].tolist())
        raise InputError(
            f"places[{first}] and places[{second}]: the bodies overlap by {overlaps.max():.3g} mm. Move them apart"
        )


def _wrap_points(points: Array, period: float) -> Array:
    """Wrap points (mm) into a square from 0 to its side `period`, exclusive. Period 0 returns them unchanged."""
    if not period:
        return points
    wrapped = np.mod(points, period)
    return np.where(wrapped < period, wrapped, 0.0)  # a rounding error below 0 becomes the side itself


def _place_discs(crowd: lammps_input.Crowd, shapes: Sequence[discs.Discs]) -> tuple[Array, Array, Whole]:
    """Return centres (A, 2), radii (A,), mm, and walkers' indices (A,) of all A discs. `shapes`: discs by kind."""
    points, radii, owners = [], [], []
    for kind, shape in enumerate(shapes):
        walkers = np.flatnonzero(crowd.kinds == kind)
        x, y, angle = crowd.places[walkers].T[:, :, None]
        u, v = shape.places.T
        cosine, sine = np.cos(angle), np.sin(angle)
        place = np.stack((x + cosine * u - sine * v, y + sine * u + cosine * v), axis=-1)
        points.append(place.reshape(-1, 2))
        radii.append(np.tile(shape.radii, len(walkers)))
        owners.append(np.repeat(walkers, len(shape.radii)))
    return np.concatenate(points), np.concatenate(radii), np.concatenate(owners)


def wall_gaps(dish: Dish, points: Array, radii: Array) -> Array:
    """Return each disc's gap to the nearest wall (mm), shape (A,); negative in a wall. `points`: centres, (A, 2)."""
    if dish.kind == "rectangle":
        return np.asarray((0.5 * np.array(dish.sizes) - np.abs(points)).min(axis=1) - radii)
    if dish.kind == "periodic":
        return np.full(len(radii), np.inf)
    away = np.hypot(*points.T)
    outer = 0.5 * dish.sizes[0] - away - radii
    return np.asarray(outer if dish.kind == "disc" else np.minimum(outer, away - radii - 0.5 * dish.sizes[1]))
