"""Walkers one by one: the speed of each, their mean, and how much they differ.

Prints of one design differ. So the mean over a few walkers has two errors: longer films reduce that within tracks, only
more walkers that between walkers.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import moments
from walkergen.analysis.estimates import FAR_WEIGHT, MIN_SIGNIFICANCE, NEAR_WEIGHT, UNITS, Settings, quantity, refusal
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.numerics import Array, Complex, statistics
from walkergen.core.numerics.distributions import fisher_tail
from walkergen.core.numerics.quantity import UNIT_SYMBOLS, Quantity

SCATTER_P_VALUE = 0.01
"""Probability, for equal walkers, of a spread that counts as resolved (an F test)."""

SHORTENED_SPEEDS = ("speed", "body_speed", "sideways_speed")
"""Speeds that are corrected alike, by the share of a speed that displacements show."""

MIN_TIME_SHARE = 0.25
"""Minimum time of a walker that is compared with others, as a share of the longest time seen."""

TRACK_PIECES = 10
"""Number of pieces of one track that give the error of its speed."""

MIN_CORRELATION_TIMES = 8.0
"""Correlation times that pieces must last to be independent: errors are then 7 % low at most."""


class WalkerMeans(NamedTuple):
    """Numbers of one walker."""

    particle: int
    seconds: float
    """Time from the walker's first frame to its last."""
    means: Mapping[str, Quantity]
    """Means by the names of `estimates.UNITS`, with their errors within this walker's track."""

    def mean(self, name: str) -> Quantity:
        """Return the mean of this name; refused without a reason if there is none."""
        return self.means.get(name, refusal(name, ""))


class WalkerComparison(NamedTuple):
    """Comparison of at least two walkers, each counted once."""

    walkers: int
    means: Mapping[str, Quantity]
    """Means over walkers by the names of `estimates.UNITS`, by Student's t with n - 1."""
    scatter: Quantity
    """Standard deviation of the speeds of walkers, mm/s."""
    limit: str
    """Description of the error that limits the mean speed: between walkers, or within their tracks."""


class _Series(NamedTuple):
    """Steps of one track whose mean is a speed or a rate."""

    steps: npt.NDArray[Any]
    """Shape (n,); NaN if unknown."""
    samples: Array
    """Numbers of samples that they span, shape (n,)."""
    unit: float
    """Factor from a mean step per sample to the speed or rate."""
    blocks: Array
    """Speeds or rates over blocks of neighbouring samples, whose correlation affects the error of the mean."""
    squared: bool = False
    """True when steps are products, and the root of their modulus is a speed."""

    def mean(self, sums: npt.NDArray[Any]) -> Array:
        """Return the mean speed or rate from sums of steps and of samples, shape (..., 2)."""
        ratio = sums[..., 0] / sums[..., 1].real
        return np.asarray(self.unit * (np.sqrt(np.abs(ratio)) if self.squared else ratio.real))


def walker_scatter(name: str, values: Array, noise: float, noise_freedom: float) -> Quantity:
    """Estimate the standard deviation between walkers, without the part that errors of their values cause.

    `values`, shape (n,) with n >= 2, are assumed normal; their errors have the mean variance `noise`, known with
    `noise_freedom` degrees of freedom. Refused with an upper bound if walkers may be equal.
    """
    freedom = len(values) - 1
    total = float(values.var(ddof=1))
    ratio = total / noise if noise > 0 else math.inf if total > 0 else 0.0
    if fisher_tail(freedom, noise_freedom, ratio) > SCATTER_P_VALUE:
        from scipy.special import chdtri

        least = chdtri(freedom, 0.95)  # chi^2 lies above it with 95 %
        most = math.sqrt(max(total * freedom / least - noise, 0.0))
        bound = (
            f"below {most:.2g} {UNIT_SYMBOLS[UNITS[name]]} (95 %)"
            if most
            else "smaller than each one's own error makes it"
        )
        return refusal(name, f"not resolved: {bound}")
    from scipy.special import fdtri

    value = math.sqrt(total - noise)
    se = total * math.sqrt(2.0 / freedom) / (2.0 * value)
    least = noise * float(fdtri(freedom, noise_freedom, 1.0 - SCATTER_P_VALUE))
    return quantity(name, value, se, freedom)._replace(noise=noise, power=2, least=least)


def walker_means(tracks: Tracks, settings: Settings, shortened: float, turns: Mapping[int, float]) -> list[WalkerMeans]:
    """Compute the numbers of every single walker.

    `shortened` is the share of a speed that displacements show (see `estimates.evaluate`), `turns` the mean turn (rad)
    per sample, by particle.
    """
    means_of_walkers = []
    for track in tracks.tracks:
        seen = np.flatnonzero(~np.isnan(track.position).any(axis=1))
        seconds = float(seen[-1] - seen[0]) * tracks.interval if len(seen) else 0.0
        series = _walker_series(track, settings, shortened, turns[track.particle])
        means = {name: _series_mean(name, steps, settings) for name, steps in series.items()}
        means_of_walkers.append(WalkerMeans(track.particle, seconds, means))
    return means_of_walkers


def _walker_series(track: Track, settings: Settings, shortened: float, turn: float) -> dict[str, _Series]:
    """Return by name the steps of one track whose means are its speeds and turning rate.

    `shortened`: share of a speed that displacements show; `turn`: mean turn per sample, rad.
    """
    step, interval = settings.grid.step, settings.interval
    position = moments.complex_position(track)
    seen = np.flatnonzero(~np.isnan(position))
    blocks = np.diff(position[::step]).real / (step * interval)
    along = _Series(np.diff(position[seen]).real, np.diff(seen), 1.0 / interval, blocks)
    if settings.lane:
        return {"lane_speed": along, "speed": along}
    if not math.isfinite(shortened) or (settings.headed and track.heading is None):
        unknown = _Series(np.zeros(0), np.zeros(0), math.nan, np.zeros(0))
        return {"lane_speed": along, "speed": unknown}
    if not settings.headed:
        moved, lag = moments.direction_vectors(track, step), settings.first_lag
        products = moments.mask_near_walls(np.conj(moved[:-lag]) * moved[lag:], track.free_samples(lag + step))
        motion = _Series(products, np.ones(len(products)), 1.0 / shortened, np.zeros(0), squared=True)
        return {"lane_speed": along, "speed": motion, "motion_speed": motion}
    assert track.heading is not None
    near, far = (_nanmean(moments.heading_displacements(track, turn, out)) for out in (0, 1))
    moved = NEAR_WEIGHT * near + FAR_WEIGHT * far
    speeds = moments.body_frame_displacements(track, step) / (step * interval * shortened)
    ones, unit = np.ones(len(moved)), 1.0 / (shortened * interval)
    ahead = _Series(moved.real, ones, unit, speeds.real)
    heading = np.exp(1j * track.heading)
    turned = moments.mask_near_walls(np.angle(heading[1:] * np.conj(heading[:-1])), track.free_samples(1))
    return {
        "lane_speed": along,
        "speed": ahead,
        "body_speed": ahead,
        "sideways_speed": _Series(moved.imag, ones, unit, speeds.imag),
        "turning_bias": _Series(turned, ones, 1.0 / interval, np.zeros(0)),
    }


def _nanmean(values: Complex) -> Complex:
    """Return the mean over the first axis of the values that are not NaN; NaN if all are."""
    present = ~np.isnan(values)
    mean = np.where(present, values, 0.0).sum(axis=0) / np.maximum(present.sum(axis=0), 1)
    return np.where(present.any(axis=0), mean, np.nan)


def _series_mean(name: str, series: _Series, settings: Settings) -> Quantity:
    """Return the mean of a series with its error, from pieces or the correlation time, or refused with a reason."""
    present = ~np.isnan(series.steps)
    values = np.stack([series.steps, series.samples])[:, present]
    edges = np.linspace(0, values.shape[1], TRACK_PIECES + 1).astype(int)[:-1]
    sums = np.add.reduceat(values, np.unique(edges), axis=1).T if present.any() else np.zeros((0, 2))
    if not math.isfinite(series.unit):
        return refusal(name, "no speed of all walkers is known: film for longer")
    if not len(sums):
        return refusal(name, "too short a track: film for longer")
    if series.squared and (reason := _unresolved_reason(sums, series.unit)):
        return refusal(name, reason)
    mean = Quantity(name, UNITS[name], float(series.mean(sums.sum(axis=0))))
    if len(sums) < TRACK_PIECES:
        return mean._replace(refused="too short a track for an error: film for longer")
    lasting = float(sums[:, 1].real.mean()) * settings.interval
    correlated = _error_if_correlated(series.blocks, settings.grid.step * settings.interval, lasting)
    if correlated is not None:
        error, reason = correlated
        return mean._replace(refused=reason) if reason else mean._replace(se=error)
    left_out = series.mean(sums.sum(axis=0) - sums)
    error = float(statistics.jackknife_error(left_out[:, None])[0])
    return mean._replace(se=error, freedom=TRACK_PIECES - 1.0)


def _unresolved_reason(sums: npt.NDArray[Any], unit: float) -> str:
    """Return the reason why products of displacements give no speed; '' if they do.

    `sums`, shape (pieces, 2): products (speed = `unit` times the root of their mean) and numbers. The modulus of a mean
    that is all noise would be a speed above 0.
    """
    if len(sums) < 2:
        return "too short a track: film for longer"
    whole, count = sums.sum(axis=0)
    left_out = (whole - sums[:, 0]).real / (count - sums[:, 1]).real
    product, error = (whole / count).real, statistics.jackknife_error(left_out[:, None])[0]
    if product > MIN_SIGNIFICANCE * error:
        return ""
    most = unit * math.sqrt(max(product, 0.0) + 2.0 * error)
    return f"no lasting direction is resolved: slower than {most:.2g} mm/s (95 %)"


def _error_if_correlated(blocks: Array, block_s: float, piece_s: float) -> tuple[float, str] | None:
    """Return the error of the mean of correlated blocks of `block_s` s and '', or NaN and the reason why there is none.

    The correlation time of the blocks gives their number of independent samples. Return None without blocks, or if
    pieces of `piece_s` s are independent.
    """
    if not len(blocks):
        return None
    values, least = blocks[~np.isnan(blocks)], statistics.MIN_SERIES_LENGTH
    if len(values) < least:
        return math.nan, f"no track lasts {least * block_s:.2g} s: film for longer"
    time = statistics.correlation_time([values], block_s)
    if time is None:
        return math.nan, "changes too slowly for tracks so short: film for longer"
    if piece_s >= MIN_CORRELATION_TIMES * time:
        return None
    error = statistics.error_of_mean([values], block_s, time)
    if error is None:
        total = len(values) * block_s
        reason = f"changes within {time:.2g} s, too few times in {total:.3g} s: film for longer"
        return math.nan, reason
    return error, ""


def compare(all_walkers: Sequence[WalkerMeans]) -> WalkerComparison | None:
    """Return means and scatter over walkers that have a speed and are seen for long enough; None if fewer than two."""
    longest = max(walker.seconds for walker in all_walkers)
    walkers = [walker for walker in all_walkers if walker.seconds >= MIN_TIME_SHARE * longest]
    walkers = [walker for walker in walkers if walker.mean("speed").value is not None]
    if len(walkers) < 2:
        return None
    means = {}
    for name in walkers[0].means:
        values = [value for walker in walkers if (value := walker.mean(name).value) is not None]
        if len(values) == len(walkers):
            means[name] = quantity(name, *statistics.weighted_mean(np.array(values)))
    speeds = [walker.mean("speed") for walker in walkers]
    errors = [speed.se for speed in speeds if speed.se is not None]
    if len(errors) < len(speeds):
        reason = next(speed.refused for speed in speeds if speed.refused)
        return WalkerComparison(
            len(walkers), means, refusal("speed_scatter", reason), "no error within a track is known"
        )
    noise = float(np.mean(np.square(errors)))
    noise_freedom = sum(min(speed.freedom, statistics.MIN_SAMPLES) for speed in speeds)
    scatter = walker_scatter("speed_scatter", np.array([speed.value for speed in speeds]), noise, noise_freedom)
    return WalkerComparison(len(walkers), means, scatter, _limiting_error(scatter, noise))


def add_shared_error(means: Mapping[str, Quantity], shortened: Quantity) -> dict[str, Quantity]:
    """Return means whose speeds' errors include the relative error of the factor `shortened`, common to all walkers."""
    relative = shortened.se / shortened.value if shortened.se and shortened.value else 0.0
    return {
        name: mean._replace(se=math.hypot(mean.se, relative * mean.value))
        if name in SHORTENED_SPEEDS and mean.se is not None and mean.value is not None
        else mean
        for name, mean in means.items()
    }


def _limiting_error(scatter: Quantity, noise: float) -> str:
    """Describe what limits the mean speed: `scatter` between walkers, or errors within tracks, mean square `noise`."""
    if scatter.value is None:
        return "walkers do not differ by more than the errors of their tracks: film for longer to reduce these"
    if scatter.value**2 > noise:
        return "differences between walkers set its error: more walkers help, longer films do not"
    return "errors of tracks set its error, more than differences between walkers: film for longer"
