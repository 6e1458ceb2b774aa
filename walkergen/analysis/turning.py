"""Turning rates of walkers: their scatter between walkers, and the diffusion of each one's heading.

An analysis of variance of pieces of tracks of equal length. Pieces have to outlast the memory of
the turning rate.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import special

from walkergen.analysis.estimates import FEWEST_SAMPLES, SIGNIFICANT, Estimate
from walkergen.analysis.tracks import Track
from walkergen.numerics import statistics

Array = npt.NDArray[np.float64]

PIECES = 8
"""Number of pieces of the longest track whose turning rates show how much each walker's varies."""

CHANCE = 0.01
"""Probability, for walkers that are alike, of a scatter that counts as resolved (an F test)."""


def scatter(tracks: Sequence[Track], interval: float) -> Estimate:
    """Standard deviation of the mean turning rates of walkers (rad/s), samples `interval` s apart.

    It is the spread of the walkers' means less what the spread of each walker's pieces makes of it,
    so that diffusion of the heading alone gives none.
    """
    means, within, pieces = _means(tracks, _size(tracks))
    if len(means) < FEWEST_SAMPLES:
        told = f"{len(means)} walkers with several pieces of a track; at least {FEWEST_SAMPLES}"
        return Estimate(None, None, told)
    spread, noise = _parts(means, within, pieces)
    free = len(means) - 1
    ratio = spread / noise if noise > 0 else math.inf if spread > 0 else 0.0
    if special.fdtrc(free, pieces.sum() - len(pieces), ratio) > CHANCE:
        least = special.chdtri(free, 0.95)  # chi^2 lies above it with 95 %
        most = math.sqrt(max(spread * free / least - noise, 0.0)) / interval
        return Estimate(None, None, f"not resolved: below {most:.2g} rad/s (95 %)")
    value = math.sqrt(spread - noise)
    others = ~np.eye(len(means), dtype=bool)
    left_out = [_parts(means[one], within[one], pieces[one]) for one in others]
    error = statistics.jackknife_error(np.array([[a - b] for a, b in left_out]))[0] / (2.0 * value)
    return Estimate(value / interval, float(error) / interval)


def diffusion(tracks: Sequence[Track], interval: float, noise: float) -> Estimate:
    """Coefficient of rotational diffusion D_r (rad^2/s) about each walker's own mean turning.

    Turns of a piece of t seconds have the variance 2 D_r t + 2 `noise`^2 with the noise of a
    heading (rad). The error is that of a variance of independent normal values.
    """
    size = _size(tracks)
    _, within, pieces = _means(tracks, size)
    free = int(pieces.sum()) - len(pieces)
    if free < FEWEST_SAMPLES:
        told = f"{free} independent pieces of tracks; at least {FEWEST_SAMPLES}: film for longer"
        return Estimate(None, None, told)
    lasting = size * interval
    spread = within.sum() / free * size**2 / (2.0 * lasting)
    if not math.isfinite(noise):
        return Estimate(None, None, "the noise of the headings is unknown: film for longer")
    return Estimate(spread - noise**2 / lasting, spread * math.sqrt(2.0 / free))


def persistence(diffused: Estimate, speed: Estimate) -> dict[str, Estimate]:
    """Persistence of walkers that turn at rates of their own, from rotational diffusion and speed.

    Their correlation falls by the scatter of these rates, and tells next to nothing of diffusion.
    """
    found = {"persistence_rate": diffused}
    rate, error = diffused.value, diffused.se
    if rate is None or error is None or not rate > SIGNIFICANT * error:
        told = diffused.reason or "rotational diffusion is not resolved: film for longer"
        return found | dict.fromkeys(
            ("persistence_time", "persistence_length"), Estimate(None, None, told)
        )
    found["persistence_time"] = Estimate(1.0 / rate, error / rate**2)
    length = Estimate(None, None, speed.reason)
    if speed.value is not None and speed.se is not None:
        way = abs(speed.value) / rate
        length = Estimate(way, math.hypot(way * error, speed.se) / rate)
    return found | {"persistence_length": length}


def _size(tracks: Sequence[Track]) -> int:
    """Number of samples of a piece."""
    return max((len(track.position) - 1 for track in tracks), default=0) // PIECES


def _means(tracks: Sequence[Track], size: int) -> tuple[Array, Array, Array]:
    """Mean turn a sample of each walker, sum of squares of its pieces about it, their number.

    Pieces have `size` samples or a little more, whose squares count as those of `size`; a walker
    with fewer than two pieces, or without headings, gives nothing.
    """
    rows = []
    for track in tracks:
        if track.heading is None:
            continue
        turned = np.angle(np.exp(1j * np.diff(track.heading)))
        count = len(turned) // size if size else 0
        if count < 2:
            continue
        parts = [part[~np.isnan(part)] for part in np.array_split(turned, count)]
        rates = np.array([part.mean() for part in parts if len(part)])
        if len(rates) > 1:
            longer = len(turned) / (count * size)
            squares = longer * ((rates - rates.mean()) ** 2).sum()
            rows.append((rates.mean(), squares, len(rates)))
    means, within, pieces = np.array(rows, dtype=float).reshape(-1, 3).T
    return means, within, pieces


def _parts(means: Array, within: Array, pieces: Array) -> tuple[float, float]:
    """Variance of the walkers' means, and the part of it that the spread of pieces makes."""
    one_piece = within.sum() / (pieces.sum() - len(pieces))
    return float(means.var(ddof=1)), float(one_piece * (1.0 / pieces).mean())
