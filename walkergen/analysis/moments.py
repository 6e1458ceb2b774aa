"""Sums over tracks that every statistic of motion derives from, and their independent samples.

The moments of two tracks, or of two pieces of one, add up. So one jackknife over independent samples gives the error of
every number.
"""

import itertools
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import lag_sums
from walkergen.analysis.tracks import Track
from walkergen.core.numerics import Array, Complex, Mask, Whole

MIN_PARTICLES = 8
"""Minimum number of particles for one sample a particle; with fewer, tracks are cut into pieces."""

MIN_PIECES = 10
"""Least number of pieces, in all, that the tracks of few particles are cut into."""

MAX_GROUPS = 64
"""Largest number of samples; further samples are merged: they hardly sharpen the error."""


class Grid(NamedTuple):
    """Lags (in samples of the tracks) and bins over which to sum."""

    step: int
    """Lag of the displacements along and across the heading."""
    square_lags: Whole
    turn_lags: Whole
    bins: tuple[Array, Array]
    """Edges (mm) of bins for displacements along and across; empty when there is no density."""


class Moments(NamedTuple):
    """Sums over one or many tracks, at the lags and in the bins of a `Grid`."""

    run: Array
    """Displacement along x (mm) from first to last sample, and number of steps between them."""
    near: Complex
    """Displacement ahead (mm; imaginary part: to the left) over neighbouring samples, along the
    headings at both, and number of such pairs."""
    far: Complex
    """As `near`, but along the headings a sample earlier and a sample later than both."""
    turned: Array
    """Change of heading (rad) over neighbouring samples, and number of such pairs."""
    along: Array
    """Number, sum (mm), sum of squares of displacements over `step` along the heading."""
    across: Array
    square: Array
    """Sum of squared displacements by lag, mm^2."""
    square_pairs: Array
    about_run: Array
    """As `square`, but in a lane and about the mean speed of each walker's whole track."""
    turn: Complex
    """Sum of products of headings, less their steady turn, by lag; without headings, of
    displacements over `step`, mm^2."""
    turn_pairs: Array
    density_along: Array
    """Number of displacements along the heading in each bin."""
    density_across: Array


def total(parts: Iterable[Moments]) -> Moments:
    """Return the sum of several moments, field by field."""
    fields: list[Any] = [sum(values[1:], values[0]) for values in zip(*parts, strict=True)]
    return Moments(*fields)


def subtract(whole: Moments, part: Moments) -> Moments:
    """Return `whole` less `part`, field by field."""
    fields: list[Any] = [a - b for a, b in zip(whole, part, strict=True)]
    return Moments(*fields)


def independent_samples(tracks: Sequence[Track]) -> tuple[list[list[Track]], int]:
    """Group tracks into independent samples. Return these, and their time-weighted median length, in positions.

    Samples are particles if there are enough, otherwise at least MIN_PIECES pieces of tracks of about equal length.
    Pieces are independent only if increments decorrelate, which `motion` checks.
    """
    long = [track for track in tracks if len(track.position) > 1]
    pieces = _cut_tracks(long) if has_few_particles(tracks) else long
    if not pieces:
        return [], 0
    lengths = np.sort([len(piece.position) for piece in pieces])
    length = int(lengths[np.searchsorted(np.cumsum(lengths), 0.5 * lengths.sum())])
    count = min(len(pieces), MAX_GROUPS)
    return [pieces[number::count] for number in range(count)], length


def has_few_particles(tracks: Sequence[Track]) -> bool:
    """Return whether particles, weighted by the time they were seen, are too few to be the samples."""
    lengths = np.array([len(track.position) - 1.0 for track in tracks])
    return bool(lengths.sum() ** 2 < MIN_PARTICLES * (lengths**2).sum())


def _cut_tracks(tracks: Sequence[Track]) -> list[Track]:
    """Cut tracks into at least MIN_PIECES pieces of about equal length, if they are long enough."""
    lengths = [len(track.position) - 1 for track in tracks]
    size = sum(lengths) // MIN_PIECES
    while size > 1 and sum(length // size for length in lengths) < MIN_PIECES:
        size -= max(1, size // 50)
    pieces = []
    for track, length in zip(tracks, lengths, strict=True):
        edges = _piece_edges(track, max(length // max(size, 1), 1))
        for first, last in itertools.pairwise(edges):
            window = slice(first, last + 1)  # neighbours share a position but no displacement
            heading = None if track.heading is None else track.heading[window]
            reach = None if track.reach is None else track.reach[window]
            pieces.append(track._replace(position=track.position[window], heading=heading, reach=reach))
    return pieces


def _piece_edges(track: Track, count: int) -> Whole:
    """Return the samples where to cut a track into `count` pieces of equal length or, with walls, equal free motion."""
    last, free = len(track.position) - 1, track.free_samples(1)
    if free is None or not free.any():
        return np.linspace(0, last, count + 1).astype(np.int64)
    passed = np.cumsum(free)
    inner = np.searchsorted(passed, np.linspace(0, passed[-1], count + 1)[1:-1])
    return np.unique(np.concatenate([[0], inner, [last]]))


def measure(track: Track, grid: Grid, mean_step: float = 0.0) -> Moments:
    """Compute the moments of one track or of a piece of one, at the lags and in the bins of `grid`.

    `mean_step` is subtracted in each sample: the mean turn (rad) of the whole track or, in a lane, its mean
    displacement (mm).
    """
    forward, sideways = displacements(track, grid.step)
    bins_along, bins_across = grid.bins
    square, square_pairs = sum_squares(track, grid.square_lags)
    headings, lane = direction_vectors(track, grid.step), track.position.shape[1] == 1
    times = np.arange(len(track.position), dtype=float)
    about_mean = np.zeros_like(square)
    if lane:
        drift = mean_step * times[:, None]
        about_mean, _ = lag_sums.sum_squares(track.position - drift, grid.square_lags)
    turn, turn_pairs = _sum_direction_products(track, headings * np.exp(-1j * mean_step * times[: len(headings)]), grid)
    return Moments(
        net_displacement(track),
        _sum_and_count(heading_displacements(track, mean_step, 0)),
        _sum_and_count(heading_displacements(track, mean_step, 1)),
        _sum_turns(track),
        _power_sums(forward),
        _power_sums(sideways),
        square,
        square_pairs,
        about_mean,
        turn,
        turn_pairs,
        _histogram(forward, bins_along),
        _histogram(sideways, bins_across),
    )


def sum_squares(track: Track, lags: Whole) -> tuple[Array, Array]:
    """Return sums of squared displacements (mm^2) and numbers of pairs by lag (samples), without pairs near walls."""
    if track.reach is None:
        return lag_sums.sum_squares(track.position, lags)
    place = track.position
    return lag_sums.sum_free_pairs(lambda lag: ((place[lag:] - place[:-lag]) ** 2).sum(axis=1), lags, track.reach)


def _sum_direction_products(track: Track, directions: Complex, grid: Grid) -> tuple[Complex, Array]:
    """Return sums of products of directions and numbers of pairs by lag, without pairs near walls."""
    if track.reach is None:
        return lag_sums.sum_products(directions, grid.turn_lags)
    free = track.reach - (0 if track.heading is not None else grid.step)
    return lag_sums.sum_free_pairs(lambda lag: np.conj(directions[:-lag]) * directions[lag:], grid.turn_lags, free)


def mask_near_walls(values: npt.NDArray[Any], free: Mask | None) -> npt.NDArray[Any]:
    """Return values with NaN where the sample they begin at is not `free`; the last axis is by sample."""
    return values if free is None else np.where(free[: values.shape[-1]], values, np.nan)


def complex_position(track: Track) -> Complex:
    """Return the position x + i y, mm, shape (times,); NaN if the walker was not seen; y = 0 in a lane."""
    x = track.position[:, 0]
    return x + 1.0j * track.position[:, 1] if track.position.shape[1] == 2 else x.astype(complex)


def direction_vectors(track: Track, step: int) -> Complex:
    """Return unit vectors of the heading or, without one, displacements over `step` (mm); shape (times,)."""
    if track.heading is not None:
        unit: Complex = np.exp(1j * track.heading)
        return unit
    position = complex_position(track)
    return position[step:] - position[:-step] if step < len(position) else position[:0]


def displacements(track: Track, step: int) -> tuple[Array, Array]:
    """Return the displacements over `step` samples along and across the heading at their start (mm), without NaN.

    In a lane they are along x, and none across. On a plane without headings there are none: the direction would have to
    be taken from the displacement itself.
    """
    none = np.zeros(0)
    position = complex_position(track)
    moved = mask_near_walls(position[step:] - position[:-step], track.free_samples(step))
    if track.position.shape[1] == 1:
        return moved.real[~np.isnan(moved)], none
    if track.heading is None:
        return none, none
    moved = moved * np.exp(-1j * track.heading[: len(moved)])
    moved = moved[~np.isnan(moved)]
    return moved.real, moved.imag


def net_displacement(track: Track) -> Array:
    """Return the displacement along x (mm) from first to last known sample, and the number of steps between them."""
    seen = np.flatnonzero(~np.isnan(track.position).any(axis=1))
    if len(seen) < 2:
        return np.zeros(2)
    first, last = seen[0], seen[-1]
    return np.array([track.position[last, 0] - track.position[first, 0], float(last - first)])


def body_frame_displacements(track: Track, step: int) -> Complex:
    """Return the displacements over `step` samples ahead (real part) and to the left, mm; NaN if unknown.

    They count along the mean of the unit vectors of the headings at both ends: so a walker that runs straight ahead
    while it turns steadily does not drift sideways.
    """
    assert track.heading is not None
    unit = np.exp(1j * track.heading[::step])
    moved: Complex = np.diff(complex_position(track)[::step]) * np.conj(0.5 * (unit[1:] + unit[:-1]))
    free = track.free_samples(step)
    return mask_near_walls(moved, None if free is None else free[::step])


def heading_displacements(track: Track, turn: float, offset: int) -> Complex:
    """Return displacements per sample (mm), shape (2, n): along the heading `offset` samples before, and after.

    Real parts are ahead, imaginary parts to the left; NaN if unknown. Headings are turned to the middle by the mean
    `turn` (rad per sample), and lengths are those on the arc: a walker that turns steadily is not slower, nor drifts
    aside.
    """
    if track.heading is None:
        return np.zeros((2, 0), dtype=complex)
    chord = np.sinc(0.5 * turn / np.pi)
    moved = np.diff(complex_position(track)) / chord
    beyond = np.full(offset, np.nan)
    heading = np.concatenate([beyond, track.heading, beyond])
    values = [
        moved * np.exp(-1j * (heading[first : first + len(moved)] - turn * (first - offset - 0.5)))
        for first in (0, 2 * offset + 1)
    ]
    free = track.free_samples(1 + 2 * offset)  # from the first heading to the last
    if free is not None:
        free = np.concatenate([np.zeros(offset, dtype=bool), free])
    return mask_near_walls(np.stack(values), free)


def _sum_and_count(values: Complex) -> Complex:
    """Return the sum and number of the values that are not NaN."""
    present = values[~np.isnan(values)]
    return np.array([present.sum(), len(present)])


def _sum_turns(track: Track) -> Array:
    """Return the sum of the turns (rad) between samples, and their number; zeros without headings."""
    if track.heading is None:
        return np.zeros(2)
    turns = mask_near_walls(np.diff(track.heading), track.free_samples(1))
    turns = np.angle(np.exp(1j * turns[~np.isnan(turns)]))
    return np.array([turns.sum(), float(len(turns))])


def _power_sums(values: Array) -> Array:
    """Return the number, the sum and the sum of squares of values."""
    return np.array([float(len(values)), values.sum(), (values**2).sum()])


def _histogram(values: Array, edges: Array) -> Array:
    """Return the number of values in each bin; empty without edges."""
    return np.histogram(values, edges)[0].astype(float) if len(edges) else np.zeros(0)
