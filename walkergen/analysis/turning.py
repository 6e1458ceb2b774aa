"""Turning rates of walkers: their scatter between walkers, and the diffusion of each one's heading.

The method is an analysis of variance over pieces of tracks. Pieces must outlast the turning rate's correlation time.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import lag_sums, moments, particle_scatter
from walkergen.analysis.estimates import MIN_SAMPLES, quantity, refusal
from walkergen.analysis.tracks import Track
from walkergen.core.numerics import Complex
from walkergen.core.numerics.quantity import Quantity

PIECES = 8
"""Number of pieces of the longest track whose turning rates show how much each walker's varies."""

WALLED_PIECES = 16
"""Number of such pieces between walls, where some contain no free motion."""

MIN_GAP_CORRELATION = 0.6
"""Least correlation of headings across a gap for the turn within it to be known (one normal turn in 500 is then
wrong)."""

MIN_VARIANCE_SHARE = 0.5
"""Least share of its variance that a memory leaves a piece's turn. A memory with a larger error counts as none."""


class Turning(NamedTuple):
    """Turning of one walker, in pieces of its track with r_i the rate in T_i s."""

    particle: int
    rate: float
    """Mean rate of turning, rad/s."""
    squares: float
    """Sum of T_i (r_i - rate)^2, rad^2/s."""
    pieces: int
    seconds: float
    """Total time of known turns: the sum of T_i."""
    noise: float
    """Expectation of `squares`, 1/s, if each heading is off by 1 rad and nothing turns. It counts the
    ends of stretches without a gap; neighbouring pieces share some of them."""


def walker_turnings(tracks: Sequence[Track], interval: float) -> list[Turning]:
    """Measure the turning of each walker whose headings are known in at least two pieces.

    Samples are `interval` s apart. Turns across a gap count if headings correlate by MIN_GAP_CORRELATION over its
    length.
    """
    headed = [track for track in tracks if track.heading is not None]
    units = {track.particle: moments.direction_vectors(track, 1) for track in headed}
    pieces = WALLED_PIECES if any(track.reach is not None for track in headed) else PIECES
    size = max((len(unit) - 1 for unit in units.values()), default=0) // pieces
    if not size:
        return []
    longest = _longest_bridged_gap(list(units.values()), size)
    turnings = [_walker_turning(track, units[track.particle], size, longest, interval) for track in headed]
    return [turning for turning in turnings if turning is not None]


def _longest_bridged_gap(units: Sequence[Complex], size: int) -> int:
    """Return the longest gap, of at most `size` samples, across which turns are known; 1: none.

    `units`: headings of each walker as complex unit vectors, NaN if unknown.
    """
    gaps = [np.diff(np.flatnonzero(~np.isnan(unit))) for unit in units]
    lags = np.unique(np.concatenate(gaps))
    lags = lags[(lags > 1) & (lags <= size)]
    total, pairs = np.zeros(len(lags)), np.zeros(len(lags))
    for unit in units:
        products, count = lag_sums.sum_products(unit, lags)
        total, pairs = total + np.abs(products), pairs + count  # the modulus ignores each walker's mean turn
    unknown = lags[total < MIN_GAP_CORRELATION * pairs]
    bridged = lags[lags < unknown[0]] if len(unknown) else lags
    return int(bridged[-1]) if len(bridged) else 1


def _walker_turning(track: Track, vectors: Complex, size: int, longest_gap: int, interval: float) -> Turning | None:
    """Measure the turning of one walker in pieces of about `size` samples; None without two pieces.

    `vectors`: its headings as complex unit vectors. Turns across more than `longest_gap` samples are left out.
    """
    seen = np.flatnonzero(~np.isnan(vectors))
    steps = np.diff(seen)
    turns = np.angle(vectors[seen[1:]] * np.conj(vectors[seen[:-1]]))
    count = (len(vectors) - 1) // size
    if count < 2 or not (steps == 1).any():
        return None
    # Wrapped about the walker's mean turn, which may be more than half a turn across a gap.
    expected = turns[steps == 1].mean() * steps
    turns = expected + np.angle(np.exp(1j * (turns - expected)))
    is_known = steps <= longest_gap
    if track.reach is not None:
        is_known &= track.reach[seen[:-1]] >= steps
    turns, steps, first, last = (turns[is_known], steps[is_known], seen[:-1][is_known], seen[1:][is_known])
    piece = np.searchsorted(np.linspace(0, len(vectors) - 1, count + 1), last) - 1
    begins_stretch = np.append(True, first[1:] != last[:-1])
    begins = begins_stretch | np.append(True, piece[1:] != piece[:-1])
    turned, seconds, begin_counts = (
        np.bincount(piece, weights)[np.unique(piece)] for weights in (turns, steps * interval, begins)
    )
    if len(turned) < 2:
        return None
    total = float(seconds.sum())
    rate = float(turned.sum()) / total
    squares = float((seconds * (turned / seconds - rate) ** 2).sum())
    noise = 2.0 * float((begin_counts / seconds).sum() - begins_stretch.sum() / total)
    return Turning(track.particle, rate, squares, len(turned), total, noise)


def scatter(turnings: Sequence[Turning]) -> Quantity:
    """Estimate the standard deviation of the mean turning rates of at least two walkers, rad/s.

    The part that the spread between each walker's own pieces explains is subtracted, so that diffusion of the heading
    alone causes no scatter.
    """
    if len(turnings) < 2:
        reason = f"{len(turnings)} walkers with several pieces of a track; at least 2"
        return refusal("turning_scatter", reason)
    rates, seconds = np.array([(turning.rate, turning.seconds) for turning in turnings]).T
    freedom = _degrees_of_freedom(turnings)
    noise = _sum_squares(turnings) / freedom * float((1.0 / seconds).mean())
    return particle_scatter.walker_scatter("turning_scatter", rates, noise, freedom)


def diffusion(turnings: Sequence[Turning], noise2: Quantity, memory: Quantity) -> Quantity:
    """Estimate rotational diffusion D_r (rad^2/s) about each walker's own mean turning.

    Turns of a piece of t seconds have the variance 2 D_r (t - `memory`) + 2 `noise2`. `memory` is the
    correlation time (s) of a rate of turning (Ornstein and Uhlenbeck 1930), 0 if unknown. `noise2` is the
    variance of a heading's noise (rad^2). Both act at a piece's ends. The error is that of a variance of
    independent normal values, of the memory and of the noise.
    """
    free = _degrees_of_freedom(turnings)
    if free < MIN_SAMPLES:
        reason = f"{free} independent pieces of tracks; at least {MIN_SAMPLES}: film for longer"
        return refusal("rotational_diffusion", reason)
    if noise2.value is None or noise2.se is None:
        return refusal("rotational_diffusion", "the noise of the headings is unknown: film for longer")
    raised = sum(turning.noise for turning in turnings) / (2.0 * free)
    lasting, lasting_se = memory.pair if memory.known else (0.0, 0.0)
    if raised * lasting_se > MIN_VARIANCE_SHARE:  # headings that hardly turn show none
        lasting, lasting_se = 0.0, 0.0
    turned = 1.0 - raised * lasting
    if turned < MIN_VARIANCE_SHARE:
        reason = f"turning lasts for {lasting:.2g} s, too long for pieces of the tracks: film for longer"
        return refusal("rotational_diffusion", reason)
    variance, noise = _sum_squares(turnings) / (2.0 * free) / turned, raised * noise2.value / turned
    # What noise and memory add to the error makes the variance as uncertain as one of fewer pieces.
    added = raised / turned * math.hypot(noise2.se, (variance - noise) * lasting_se)
    error = math.hypot(variance * math.sqrt(2.0 / free), added)
    freedom = 2.0 * (variance / error) ** 2 if error else free
    if freedom < 1.0:  # the bounds of such a variance span a factor of 1000 and more, up to infinity
        reason = "the headings turn less than the error of their noise, or of how long turning lasts: film for longer"
        return refusal("rotational_diffusion", reason)
    return quantity("rotational_diffusion", variance - noise, error, freedom)._replace(noise=noise)


def _degrees_of_freedom(turnings: Sequence[Turning]) -> int:
    return sum(turning.pieces - 1 for turning in turnings)


def _sum_squares(turnings: Sequence[Turning]) -> float:
    return sum(turning.squares for turning in turnings)
