"""Self-alignment (curvity): the rate of turning toward the direction of a force, over the speed that the force causes.

A walker with heading n that moves at v turns at kappa (n x v), kappa > 0 toward v (P. Baconnier et al., Rev. Mod. Phys.
97, 015007, 2025; curvity of M. Casiulis et al., arXiv 2409.04618). On a slope, turning and the drift across the heading
both go with the sine of the angle from heading to descent. kappa is the ratio of their slopes. The sine is that of a
sample before, so that noise of headings does not correlate, and about its mean, so that a walker's steady turning does
not count.
"""

from collections.abc import Sequence

import numpy as np

from walkergen.analysis.estimates import (
    ALIGNMENT_NAMES,
    MIN_SAMPLES,
    MIN_SIGNIFICANCE,
    NO_SLOPE_REASON,
    quantity,
    refusal,
)
from walkergen.analysis.tracks import Track
from walkergen.core.numerics import Array, statistics
from walkergen.core.numerics.quantity import Quantity

ALIKE_REASON = "headings hardly differ against the slope: let walkers start at others"


def self_alignment(groups: Sequence[Sequence[Track]], interval: float, descent: float | None) -> dict[str, Quantity]:
    """Estimate `self_alignment` (1/mm) and `slope_turning` (rad/s), by name; unresolved ones are refused with a reason.

    `groups`: the tracks of each independent sample. `interval`: time between positions of a track, s. `descent`:
    direction in which the plate descends, rad; None if it is level.
    """
    if descent is None:
        return {name: refusal(name, NO_SLOPE_REASON) for name in ALIGNMENT_NAMES}
    sums = np.array([sum((_sample_sums(track, descent) for track in group), np.zeros(8)) for group in groups])
    if len(sums) < MIN_SAMPLES:
        reason = f"{len(sums)} independent samples; at least {MIN_SAMPLES}"
        return {name: refusal(name, reason) for name in ALIGNMENT_NAMES}
    ratios = np.array([_covariances(sums.sum(axis=0) - left_out) for left_out in (0.0 * sums[0], *sums)])
    (_, across, spread), errors = ratios[0], statistics.jackknife_error(ratios[1:])
    if not spread > MIN_SIGNIFICANCE * errors[2]:
        return {name: refusal(name, ALIKE_REASON) for name in ALIGNMENT_NAMES}
    found = {}
    for name, values in zip(ALIGNMENT_NAMES, ratios[:, :1].T / (ratios[:, 1], interval * ratios[:, 2]), strict=True):
        error = float(statistics.jackknife_error(values[1:, None])[0])
        found[name] = quantity(name, values[0], error, len(sums) - 1.0)
    if not abs(across) > MIN_SIGNIFICANCE * errors[1]:
        reason = "walkers hardly drift across their headings: a steeper slope, or more runs"
        found[ALIGNMENT_NAMES[0]] = refusal(ALIGNMENT_NAMES[0], reason)
    return found


def remove_slope_turning(track: Track, rate: float, interval: float, descent: float) -> Track:
    """Return the track with the turning that the slope causes subtracted from its headings. `interval`: of samples, s.

    `rate`: turning rate of a heading across the slope, rad/s. `descent`: direction of descent, rad.
    """
    assert track.heading is not None
    turned = np.nancumsum(rate * interval * np.sin(descent - track.heading))
    return track._replace(heading=track.heading - np.append(0.0, turned[:-1]))


def _sample_sums(track: Track, descent: float) -> Array:
    """Return sums over the samples of a track, shape (8,); `descent` is the direction of descent, rad.

    In this order: number of samples; sin(descent - heading) one sample earlier; this sine in the middle of the sample;
    turn (rad); drift to the left (mm); the first sine times the second, times the turn, times the drift.
    """
    if track.heading is None or track.position.shape[1] < 2:
        return np.zeros(8)
    heading, displacement = track.heading, np.diff(track.position, axis=0)[1:]
    turn = np.angle(np.exp(1j * np.diff(heading)[1:]))
    middle_heading = heading[1:-1] + 0.5 * turn
    drift = displacement[:, 1] * np.cos(middle_heading) - displacement[:, 0] * np.sin(middle_heading)
    first_sine, sine = np.sin(descent - heading[:-2]), np.sin(descent - middle_heading)
    rows = np.stack(
        [np.ones_like(sine), first_sine, sine, turn, drift, *(first_sine * factor for factor in (sine, turn, drift))]
    )
    finite = np.isfinite(rows).all(axis=0)
    if (away_from_walls := track.free_samples(2)) is not None:
        finite &= away_from_walls[: len(finite)]
    return np.asarray(rows[:, finite].sum(axis=1))


def _covariances(sums: Array) -> tuple[float, float, float]:
    """Return the covariances of the earlier sine with turn, drift (mm) and middle sine, from sums of `_sample_sums`."""
    _, sine, middle_sine, turn, drift, sine_products, turn_products, drift_products = sums / max(sums[0], 1.0)
    return turn_products - sine * turn, drift_products - sine * drift, sine_products - sine * middle_sine
