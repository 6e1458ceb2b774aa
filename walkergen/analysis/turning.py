"""Scatter of turning rates between walkers, apart from what chance turning gives each of them."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import special

from walkergen.analysis.estimates import FEWEST_SAMPLES, Estimate
from walkergen.analysis.tracks import Track
from walkergen.numerics import statistics

Array = npt.NDArray[np.float64]

PIECES = 8
"""Number of pieces of the longest track whose turning rates show how much each walker's varies."""

CHANCE = 0.01
"""Probability, for walkers that are alike, of a scatter that counts as resolved (an F test)."""


def scatter(tracks: Sequence[Track], interval: float) -> Estimate:
    """Standard deviation of the mean turning rates of walkers (rad/s), samples `interval` s apart.

    An analysis of variance of pieces of equal length: the spread of the walkers' means less what
    the spread of the pieces of each walker makes of it. Pieces have to outlast the memory of the
    turning rate; then diffusion of the heading alone gives no scatter.
    """
    longest = max((len(track.position) for track in tracks), default=0)
    means, within, pieces = _means([t for t in tracks if t.heading is not None], longest // PIECES)
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


def _means(tracks: Sequence[Track], size: int) -> tuple[Array, Array, Array]:
    """Mean turn a sample of each walker, sum of squares of its pieces about it, their number.

    Pieces have `size` samples or a little more; a walker with fewer than two gives nothing.
    """
    rows = []
    for track in tracks:
        assert track.heading is not None
        turned = np.angle(np.exp(1j * np.diff(track.heading)))
        count = len(turned) // size if size else 0
        if count < 2:
            continue
        parts = [part[~np.isnan(part)] for part in np.array_split(turned, count)]
        rates = np.array([part.mean() for part in parts if len(part)])
        if len(rates) > 1:
            rows.append((rates.mean(), ((rates - rates.mean()) ** 2).sum(), len(rates)))
    means, within, pieces = np.array(rows, dtype=float).reshape(-1, 3).T
    return means, within, pieces


def _parts(means: Array, within: Array, pieces: Array) -> tuple[float, float]:
    """Variance of the walkers' means, and the part of it that the spread of pieces makes."""
    one_piece = within.sum() / (pieces.sum() - len(pieces))
    return float(means.var(ddof=1)), float(one_piece * (1.0 / pieces).mean())
