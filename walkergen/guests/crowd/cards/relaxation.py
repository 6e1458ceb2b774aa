"""Relaxation: how long the velocity of a walker, or its rate of turning, remembers a push.

A walker of mass m in friction gamma follows its heading e by m dv/dt = gamma (v0 e - v) + noise,
an active Brownian particle with inertia (Scholz, Jahanshahi, Ldov, Loewen, Nat. Commun. 9, 5156,
2018). Its turning rate follows the mean turning rate in the same way. The part of the velocity that the heading
explains is subtracted for each walker. The correlation and the spread of the rest give the relaxation time m / gamma
and the diffusion. Vectors in the plane are complex numbers x + i y, and headings unit vectors. `exact`: True for
simulated tracks, False for films, whose positions have noise. `followed`: lagged heading, from `_lagged_heading`.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import optimize, signal

from walkergen.analysis import lag_sums, moments, persistent_walk
from walkergen.analysis.estimates import MIN_SAMPLES, quantity, refusal
from walkergen.analysis.motion import Curve
from walkergen.analysis.tracks import Track, Tracks
from walkergen.analysis.turning import PIECES
from walkergen.core import Array, Complex, Quantity, jackknife_error

FIT_CUTOFF = math.exp(-1.0)
"""Share of the first correlation at which its fit ends. Later lags do not reduce the error of the fitted time."""

MIN_STEPS_PER_RELAXATION, MAX_STEPS_PER_SAMPLE = 4, 40
"""Time steps of the lagged heading: at least so many in a relaxation time, at most so many in a sample interval."""

TRANSIENT_RELAXATIONS = 3.0
"""Relaxation times after which a walker's unknown initial velocity is forgotten."""

MIN_PIECES, MAX_ITERATIONS = 16, 4
"""Minimum number of samples from tracks of few walkers; iterations that find the relaxation time of the velocity (for
five walkers all agreed to 1e-4 after three)."""

MAX_LAGS = 1000

VELOCITY_KEY, DIFFUSION_KEY = "velocity_relaxation", "translational_diffusion"
"""Names of the quantities measured from a velocity."""


class Relaxation(NamedTuple):
    """Fluctuations of a velocity or of a turning rate about the expected value."""

    time: Quantity
    """Relaxation time, s; refused where data are too few."""
    resolved: bool
    """Whether the time exceeds a sample interval. If not, the time follows from spread and diffusion, and one sample
    interval is its upper bound."""
    deviation: float
    """Standard deviation of the fluctuations at an instant, along each axis, mm/s or rad/s."""
    noise: float
    """Standard deviation of the noise of each position (mm) or heading (rad); 0 for exact tracks."""
    correlation: Curve
    """Correlation of the fluctuations by lag (s), along each axis, in the square of their unit."""


def measure_velocity(tracks: Tracks, exact: bool) -> tuple[Relaxation, Quantity]:
    """Measure the relaxation of the velocity, and the translational diffusion (mm^2/s) along one axis.

    `exact`: whether positions have no noise, as in simulations. Both results are means over two axes, and are found by
    iteration, because the lag behind the heading depends on the relaxation.
    """
    relaxation_time, piece_size = 0.0, max(len(track.position) for track in tracks.tracks) // PIECES
    relaxation, diffusion = _missing_relaxation(VELOCITY_KEY, "no walker has a heading"), refusal(DIFFUSION_KEY, "")
    for _ in range(MAX_ITERATIONS):
        followed = [_lagged_heading(track, relaxation_time / tracks.interval) for track in tracks.tracks]
        skip = math.ceil(TRANSIENT_RELAXATIONS * relaxation_time / tracks.interval)
        fluctuations = [
            _residual_velocity(track, lagged, skip, tracks.interval)
            for track, lagged in zip(tracks.tracks, followed, strict=True)
        ]
        diffusion = _residual_diffusion(tracks, followed, skip, piece_size, relaxation_time)
        relaxation = fit_relaxation(VELOCITY_KEY, fluctuations, tracks.interval, exact, diffusion)
        new_time = relaxation.time.value
        if new_time is None or abs(new_time - relaxation_time) < 1e-3 * relaxation_time:
            break
        relaxation_time = new_time
    piece_seconds = piece_size * tracks.interval
    if (relaxation.time.value or 0.0) > piece_seconds:
        reason = f"relaxes within {relaxation.time.value:.2g} s, longer than pieces of {piece_seconds:.2g} s"
        relaxation = _missing_relaxation(VELOCITY_KEY, f"{reason}. Use longer runs or films")
    if relaxation.time.value is None:
        diffusion = refusal(DIFFUSION_KEY, relaxation.time.refused)
    if relaxation.noise and diffusion.value is not None:
        noise_part = relaxation.noise**2 / piece_seconds
        diffusion = diffusion._replace(value=max(diffusion.value - noise_part, 0.0))
    return relaxation, diffusion


def measure_along_heading(tracks: Tracks, exact: bool, both: Relaxation, diffusion: Quantity) -> Relaxation:
    """Measure the relaxation of the velocity along the heading.

    `exact`: whether positions have no noise. `both` (both axes) and `diffusion`: results of `measure_velocity`.
    """
    fluctuations, parts_ahead = [], []
    for track in tracks.tracks:
        rest, middle_heading = _residuals_and_headings(track, both.time.value or 0.0, tracks.interval)
        fluctuations.append(rest)
        parts_ahead.append((rest * np.conj(middle_heading)).real * middle_heading)
    return fit_relaxation(VELOCITY_KEY, fluctuations, tracks.interval, exact, diffusion, axes=1, earlier=parts_ahead)


def measure_turning(tracks: Tracks, exact: bool, diffusion: Quantity) -> Relaxation:
    """Measure the relaxation of the turning rate. `exact`: tracks have no noise. `diffusion`: of headings, rad^2/s."""
    rates = []
    for track in tracks.tracks:
        heading = np.exp(1j * _headings(track))
        turned = np.angle(heading[1:] * np.conj(heading[:-1])) / tracks.interval
        rates.append((turned - np.nanmean(turned)).astype(complex))
    return fit_relaxation("turning_relaxation", rates, tracks.interval, exact, diffusion, axes=1)


def fit_relaxation(
    key: str,
    fluctuations: Sequence[Complex],
    interval: float,
    exact: bool,
    diffusion: Quantity,
    axes: int = 2,
    earlier: Sequence[Complex] | None = None,
) -> Relaxation:
    """Return the relaxation of fluctuations: the time of an exponential fitted to their correlation.

    Parameters
    ----------
    key : str
        Name of the quantity that holds the relaxation time.
    fluctuations : sequence of ndarray
        Fluctuations of each track about its mean (mm/s or rad/s), one for each interval, as complex numbers.
    interval : float
        Time between fluctuations, s.
    exact : bool
        False if positions have noise. Neighbouring intervals share it, so the fit then starts at the second lag.
    diffusion : Quantity
        Diffusion of each axis.
    axes : int
        Number of axes of the fluctuations: 1 or 2.
    earlier : sequence of ndarray, optional
        Series whose correlation with the later `fluctuations` is computed, by default `fluctuations` itself.
    """
    pieces = _independent_samples(fluctuations)
    first_parts = pieces if earlier is None else _independent_samples(earlier)
    length = max((len(piece) for piece in pieces), default=0)
    longest = length // 4
    lags = np.arange(min(longest, MAX_LAGS) + 1, dtype=np.int64)
    first = 1 if exact else 2
    if len(pieces) < MIN_SAMPLES or longest < first + 3 or diffusion.value is None:
        too_few = (
            f"{len(pieces)} independent samples of {length} intervals, but at least "
            f"{MIN_SAMPLES} of {4 * (first + 3)} are needed. Use more runs or longer films"
        )
        return _missing_relaxation(key, diffusion.refused or too_few)
    sums = [lag_sums.sum_cross_products(part, piece, lags) for part, piece in zip(first_parts, pieces, strict=True)]
    # Subtracting each track's mean lowered the mean product by `removed`
    seconds = float(np.mean([np.count_nonzero(~np.isnan(series)) for series in fluctuations])) * interval
    removed = 2.0 * diffusion.value / seconds
    total, pairs = (np.sum(parts, axis=0) for parts in zip(*sums, strict=True))
    whole, *without = [  # correlations of all samples, and without each in turn
        (total - own).real / (axes * np.maximum(pairs - number, 1.0)) + removed for own, number in [(0.0, 0.0), *sums]
    ]
    errors = jackknife_error(np.array(without))
    curve = Curve(interval * lags.astype(float), whole, errors)
    fits = _fit_exponentials([whole, *without], errors, interval, first)
    if fits is not None and fits[0][1] > interval:
        times = np.array([time for _, time in fits])
        height, time = fits[0]
        x = interval / time
        variance = height * x**2 / (2.0 * (math.cosh(x) - 1.0))
        at_once = variance * 2.0 * (x - 1.0 + math.exp(-x)) / x**2
        noise = 0.0 if exact else interval * math.sqrt(max(whole[0] - at_once, 0.0) / 2.0)
        se = float(jackknife_error(times[1:, None])[0])
        relaxed = Quantity(key, "s", float(time), se, len(pieces) - 1.0)
        return Relaxation(
            relaxed, resolved=True, deviation=math.sqrt(max(variance, 0.0)), noise=noise, correlation=curve
        )
    return _unresolved_relaxation(key, whole[0], np.array(without)[:, 0], diffusion, interval, curve)


def _unresolved_relaxation(
    key: str, mean_square: float, jackknife: Array, diffusion: Quantity, interval: float, curve: Curve
) -> Relaxation:
    """Compute a relaxation shorter than `interval` from the mean square of the fluctuations.

    `mean_square`: of all samples. `jackknife`: mean squares without each sample in turn, shape (samples,).
    """
    assert diffusion.value is not None
    whole = _relaxation_time(mean_square, diffusion.value, interval)
    times = [_relaxation_time(own, diffusion.value, interval) for own in jackknife]
    se = float(jackknife_error(np.array(times)[:, None])[0])
    if diffusion.se is not None:
        more = _relaxation_time(mean_square, diffusion.value + diffusion.se, interval)
        se = math.hypot(se, more - whole)
    deviation = math.sqrt(diffusion.value / whole) if whole else math.sqrt(max(mean_square, 0.0))
    relaxed = Quantity(key, "s", whole, se, len(jackknife) - 1.0)
    return Relaxation(relaxed, resolved=False, deviation=deviation, noise=0.0, correlation=curve)


def _relaxation_time(mean_square: float, diffusion: float, interval: float) -> float:
    """Return the relaxation time (s) for a mean square of velocities averaged over `interval` s; 0 if none fits it."""
    ratio = mean_square * interval / (2.0 * diffusion) if diffusion > 0 else 0.0
    if not 0.0 < ratio < 1.0:
        return 0.0

    def excess(x: float) -> float:
        """Return the ratio for a relaxation time of `interval` / x, less the measured ratio."""
        return 1.0 + math.expm1(-x) / x - ratio

    if excess(1e-6) > 0.0 or excess(1e9) < 0.0:
        return 0.0
    return interval / float(optimize.brentq(excess, 1e-6, 1e9))


def _fit_exponentials(
    correlations: Sequence[Array], errors: Array, interval: float, first: int
) -> list[tuple[float, float]] | None:
    """Fit the height and time (s) of an exponential to each of the correlations; None if one cannot be fitted.

    `correlations`: of all samples, then without each in turn. `first`: lag at which fits begin, in intervals. Fits end
    where the correlation of all samples has fallen to FIT_CUTOFF times its first fitted value.
    """
    whole = correlations[0]
    if not whole[first] > 3.0 * errors[first] > 0.0:
        return None
    low = np.flatnonzero(whole[first:] < FIT_CUTOFF * whole[first])
    end = first + (max(int(low[0]) + 1, 3) if len(low) else len(whole))
    window = slice(first, min(end, len(whole)))
    lag: Array = interval * np.arange(len(whole), dtype=float)[window]

    def exponential(at: Array, height: float, rate: float) -> Array:
        return np.asarray(height * np.exp(-rate * at))

    start = float(whole[first]), 1.0 / (interval * end)
    fits = []
    for correlation in correlations:
        fitted = persistent_walk.fit(exponential, lag, correlation[window], errors[window], start)
        if fitted is None or not fitted[1] > 0.0:
            return None
        fits.append((float(fitted[0]), 1.0 / float(fitted[1])))
    return fits


def _independent_samples(by_track: Sequence[Complex]) -> list[Complex]:
    """Return the tracks' series as independent samples. If there are few, they are cut into pieces."""
    filled = [series for series in by_track if len(series)]
    if len(filled) >= moments.MIN_PARTICLES:
        return filled
    pieces = math.ceil(MIN_PIECES / max(len(filled), 1))
    return [piece for series in filled for piece in np.array_split(series, pieces) if len(piece)]


def _headings(track: Track) -> Array:
    """Return the headings of a track, rad; NaN where it has none."""
    return np.full(len(track.position), np.nan) if track.heading is None else track.heading


def _lagged_heading(track: Track, samples: float) -> Complex:
    """Return the heading's unit vector, lagged by a relaxation of `samples` intervals, as a mean over each interval."""
    heading, count = _headings(track), len(track.position)
    (known,) = np.nonzero(~np.isnan(heading))
    if len(known) < 2:
        return np.full(count - 1, np.nan, complex)
    least = MIN_STEPS_PER_RELAXATION
    substeps = min(max(least, math.ceil(least / samples) if samples else least), MAX_STEPS_PER_SAMPLE)
    times = np.linspace(0.0, count - 1.0, (count - 1) * substeps + 1)
    unit = np.exp(1j * np.interp(times, known, np.unwrap(heading[known])))  # turns steadily, also in gaps
    if samples > 1.0 / MAX_STEPS_PER_SAMPLE:
        decay = math.exp(-1.0 / (substeps * samples))
        numerator = [0.5 * (1.0 - decay)] * 2
        start = signal.lfiltic(numerator, [1.0, -decay], unit[:1], unit[:1])
        unit, _ = signal.lfilter(numerator, [1.0, -decay], unit, zi=start)
    means = 0.5 * (unit[1:] + unit[:-1])
    return np.asarray(means.reshape(count - 1, substeps).mean(axis=1))


def _residual_velocity(track: Track, followed: Complex, skip: int, interval: float) -> Complex:
    """Return the velocity (mm/s) less its best multiple of the lagged heading `followed`, from interval `skip` on."""
    velocity = np.diff(moments.complex_position(track))[skip:] / interval
    lagged = followed[skip:]
    known = ~np.isnan(velocity) & ~np.isnan(lagged)
    if not known.any():
        return np.zeros(0, complex)
    share = np.vdot(lagged[known], velocity[known]) / np.vdot(lagged[known], lagged[known]).real
    return np.asarray(np.where(known, velocity - share * lagged, np.nan))


def _residuals_and_headings(track: Track, relaxation_time: float, interval: float) -> tuple[Complex, Complex]:
    """Return `_residual_velocity` (mm/s) and the heading's unit vector in each interval after the transient."""
    skip = math.ceil(TRANSIENT_RELAXATIONS * relaxation_time / interval)
    rest = _residual_velocity(track, _lagged_heading(track, relaxation_time / interval), skip, interval)
    heading = np.exp(1j * _headings(track))
    turned = np.angle(heading[1:] * np.conj(heading[:-1]))[skip:]
    return rest, (heading[skip:-1] * np.exp(0.5j * turned))[: len(rest)]


def _residual_diffusion(tracks: Tracks, followed: Sequence[Complex], skip: int, size: int, memory: float) -> Quantity:
    """Compute the diffusion D (mm^2/s) of each axis from pieces of tracks of `size` samples.

    The first `skip` samples are left out. A multiple of the path along its lagged heading is fitted to a walker's
    displacements in all pieces. The squared rest in a piece of t s is 4 D t on average, less in pieces that are not
    much longer than the velocity's relaxation time `memory` (s).
    """
    diffusions: list[Array] = []
    for track, velocity in zip(tracks.tracks, followed, strict=True):
        displacements, paths, seconds = _piece_displacements(track, velocity, skip, size, tracks.interval)
        if len(displacements) < 2:
            continue
        speed = np.sum(np.conj(paths) * displacements / seconds) / np.sum(np.abs(paths) ** 2 / seconds)
        build_up = 1.0 + memory / seconds * np.expm1(-seconds / memory) if memory else 1.0
        rest = np.abs(displacements - speed * paths) ** 2 / (4.0 * seconds * build_up)
        diffusions.append(rest * len(displacements) / (len(displacements) - 1.0))
    count = sum(len(by_piece) - 1 for by_piece in diffusions)
    if count < MIN_SAMPLES:
        reason = f"{count} independent pieces of tracks, but at least {MIN_SAMPLES} are needed"
        return refusal(DIFFUSION_KEY, f"{reason}. Use more runs or longer films")
    values = np.concatenate(diffusions)
    se = float(values.std(ddof=1)) / math.sqrt(count)
    return quantity(DIFFUSION_KEY, float(values.mean()), se, float(count))


def _piece_displacements(
    track: Track, followed: Complex, skip: int, size: int, interval: float
) -> tuple[Complex, Complex, Array]:
    """Return displacement (mm), integral of the lagged heading (s) and duration (s) of pieces of `size` samples."""
    place = moments.complex_position(track)
    count = max((len(place) - 1 - skip) // max(size, 1), 0)
    rows: list[tuple[complex, complex, float]] = []
    for start, end in pairwise(np.linspace(skip, len(place) - 1, count + 1).astype(int)):
        (seen,) = np.nonzero(~np.isnan(place[start : end + 1]))
        if len(seen) < 2 or np.isnan(followed[start:end]).any():
            continue
        low, high = start + seen[0], start + seen[-1]
        path = interval * followed[low:high].sum()
        rows.append((place[high] - place[low], path, (high - low) * interval))
    displacements, paths, seconds = np.array(rows, dtype=complex).reshape(-1, 3).T
    return displacements, paths, seconds.real


def _missing_relaxation(key: str, reason: str) -> Relaxation:
    """Return a relaxation without values, because of `reason`."""
    time, empty = Quantity(key, "s", None, refused=reason), np.zeros(0)
    return Relaxation(time, resolved=False, deviation=math.nan, noise=0.0, correlation=Curve(empty, empty, empty))
