"""Motion of walkers from their tracks: speed, squared displacement, persistence, turning.

Every number has the standard error of a jackknife over independent samples, or a reason why it has none. Noise of the
positions does not shift the numbers: speeds are means of signed displacements, or without headings of products of
displacements that share no position. Squared displacements contain the noise as an offset, which is fitted and
reported.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from walkergen.analysis import (
    alignment,
    free_turning,
    interval_laws,
    lag_sums,
    moments,
    particle_scatter,
    spread_numbers,
    turning,
    verdicts,
    walls,
)
from walkergen.analysis.displacement_fit import DisplacementFit
from walkergen.analysis.estimates import UNITS, Settings, mean, refusal
from walkergen.analysis.line import Line, line_through_origin
from walkergen.analysis.moments import Grid, Moments
from walkergen.analysis.particle_scatter import WalkerComparison, WalkerMeans
from walkergen.analysis.tracks import Track, Tracks
from walkergen.analysis.turning import Turning
from walkergen.analysis.walls import Walls
from walkergen.core.errors import InputError
from walkergen.core.numerics import Array, Whole, statistics
from walkergen.core.numerics.quantity import Quantity

FITTED_LAG_DIVISOR = 4
"""Divisor of a sample's length that gives the longest fitted lag: longer lags have few pairs."""
MISFIT_P_VALUE = 0.01
"""Probability of a misfit below which the law of the squared displacement is doubted."""
FREE_PLACES_SHARE = 0.2
"""Share of the free places between walls that stay out of reach of walls for the longest lag."""
HALF_OCTAVE = math.sqrt(2.0)
"""Ratio of lags, at least, between which a local exponent is taken, to either side."""

REST_LAG_DIVISORS, MAX_REST_SHARE = (8, 16, 32), 0.03
"""Parts of the longest track over which walkers at rest move least, and their displacement over the largest."""
MAX_NAMED, REST_WORDS = 10, "rest and are left out of all numbers"
"""Largest number of walkers at rest that are named, and what is stated of them."""


class Curve(NamedTuple):
    """Values with their errors at lags (s) or in bins (mm), each of shape (n,)."""

    at: Array
    value: Array
    se: Array
    """Standard errors of the values; NaN where samples are too short for them."""


class Motion(NamedTuple):
    """Statistics of motion that a file of tracks gives."""

    estimates: dict[str, Quantity]
    """Estimates by the names of UNITS."""
    particles: int
    samples: int
    """Number of independent samples, which the errors come from."""
    tracked_s: float
    lag_s: float
    """Lag of the displacements along and across, rounded to whole samples, s."""
    method: str
    """Meaning of `speed` and origin of the errors, as text."""
    doubts: list[str]
    """Reasons to doubt what a number means; `track_warnings` has those to doubt the tracks themselves."""
    msd: Curve
    """Mean squared displacement, mm^2, by lag."""
    exponent: Curve
    """Local exponent d ln MSD / d ln lag at the lags of `msd`: 2 for a straight run, 1 for
    diffusion; NaN within half an octave of the ends. Noise of the positions lowers short lags'."""
    msd_fit: DisplacementFit | None
    """Fit of `msd` with its goodness; None without a fit."""
    correlation: Curve
    """Modulus of the correlation of headings, less each walker's mean turning, by lag (without
    headings: of displacements, mm^2)."""
    detrend_time_s: float
    """Time of the measurement of that mean turning, s; infinite if none is subtracted."""
    parallel: Curve
    """Density (1/mm) of displacements along the heading over `lag_s`, at the middles of bins."""
    orthogonal: Curve
    walkers: Sequence[WalkerMeans]
    """Numbers of each single walker."""
    by_plate_speed: tuple[tuple[float, Quantity, str], ...] = ()
    """Speed at each plate speed (mm/s), when the file has several, and its number of walkers as in `counted`."""
    line: Line | None = None
    """Line of speed against plate speed, through the origin."""
    scale_se: float | None = 0.0
    """Common error of all lengths, as a share of them (that of `Tracks`), in addition to the errors of
    the estimates; None if unknown."""
    counted: Mapping[str, str] = MappingProxyType({})
    """Number of walkers, such as "1 of 3 walkers", of each estimate that is of fewer than the file has, by its name."""
    walls: Walls | None = None
    """Walls around the walkers; None if none were found. With walls all numbers are of motion out of their reach."""


DEFAULT_LAG_S = 0.04
"""Lag of the displacements by default, s (paper's figure 6c)."""


def analyse(
    tracks: Tracks, lag_s: float | None = None, found_walls: Walls | None = None, descent: float | None = None
) -> Motion:
    """Compute the statistics of all tracks.

    `lag_s` (s) is the time of displacements along and across the body: by default DEFAULT_LAG_S, or one sample if that
    is longer. With walls all numbers are of motion out of their reach. `descent` is the direction (rad) toward which
    the plate descends; None: it is level.

    With tracks at several plate speeds only the speed at each, and the line through the origin (paper's figure 5), mean
    something; the other numbers are refused. Raises InputError when the lag is below one sample or beyond the longest
    track, or when no particle is seen twice.
    """
    shortest, longest = tracks.interval, max(len(t.position) for t in tracks.tracks)
    lag_s = max(DEFAULT_LAG_S, shortest) if lag_s is None else lag_s
    if not 0.999 * shortest <= lag_s < shortest * (longest - 1):
        raise InputError(
            f"‹lag_ms=›{1e3 * lag_s:g}: must lie between one sample, {1e3 * shortest:g} ms, and "
            f"the longest track, {1e3 * shortest * (longest - 1):g} ms"
        )
    if found_walls is not None:
        tracks = walls.add_wall_reach(tracks, found_walls)
    all_tracks = _analyse_one_speed(tracks, lag_s, found_walls, descent)
    plates = sorted({t.plate_speed for t in tracks.tracks if t.plate_speed is not None})
    if len(plates) < 2:
        return all_tracks
    groups = [tuple(t for t in tracks.tracks if t.plate_speed == plate) for plate in plates]
    analyses = [_analyse_one_speed(tracks._replace(tracks=group), lag_s, found_walls, descent) for group in groups]
    speeds = [
        (plate, analysis.estimates["speed"], analysis.counted.get("speed", ""))
        for plate, analysis in zip(plates, analyses, strict=True)
    ]
    usable = [(plate, speed.value, speed.se) for plate, speed, _ in speeds if speed.value is not None]
    line = line_through_origin(*np.array(usable, dtype=float).T) if len(usable) > 1 else None
    reason = f"tracks at {len(plates)} plate speeds: see speed against plate speed, or split"
    refused = {name: refusal(name, reason) for name in UNITS}
    return all_tracks._replace(
        estimates=refused,
        method=analyses[0].method,
        doubts=[doubt for doubt in all_tracks.doubts if REST_WORDS not in doubt],
        counted={},
        msd_fit=None,
        by_plate_speed=tuple(speeds),
        line=line,
        walkers=sorted((walker for analysis in analyses for walker in analysis.walkers), key=attrgetter("particle")),
    )


def _analyse_one_speed(tracks: Tracks, lag_s: float, found_walls: Walls | None, descent: float | None) -> Motion:
    """Compute the statistics of tracks at one plate speed; arguments as in `analyse`."""
    count, resting = len(tracks.tracks), _resting_walkers(tracks)
    tracks = tracks._replace(tracks=tuple(track for track in tracks.tracks if track.particle not in resting))
    groups, length = moments.independent_samples(tracks.tracks)
    if not groups:
        raise InputError("no walker (particle) is seen in two frames: its motion is unknown")
    headed = any(track.heading is not None for track in tracks.tracks)
    grid = _choose_grid(tracks, lag_s, length, headed)
    lags = length // FITTED_LAG_DIVISOR
    if found_walls is not None:
        lags = min(lags, int(grid.square_lags[-1]))
    on_plane = headed and not tracks.lane
    aligned = alignment.self_alignment(groups, tracks.interval, descent)
    turnings = turning.walker_turnings(_level_headings(tracks, aligned, descent), tracks.interval) if on_plane else []
    mean_steps = _mean_lane_steps(tracks) if tracks.lane else _mean_turns(tracks, turnings)

    def sum_moments(members: Iterable[Track]) -> Moments:
        """Return the sum of the moments of several tracks."""
        return moments.total(moments.measure(t, grid, mean_steps[t.particle]) for t in members)

    parts = [sum_moments(group) for group in groups]
    of_pieces = moments.total(parts)
    left_out = [moments.subtract(of_pieces, part) for part in parts]
    in_pieces = moments.has_few_particles(tracks.tracks)
    # Whole tracks have pairs that their pieces lack.
    whole = sum_moments(tracks.tracks) if in_pieces else of_pieces
    all_sums = [whole, *left_out]
    squares: list[Array] = [mean(m.square, m.square_pairs).real for m in all_sums]
    msd = _jackknife_curve(grid.square_lags, squares, length)
    slopes = [_local_exponents(grid.square_lags, square) for square in squares]
    exponent = _jackknife_curve(grid.square_lags, slopes, length / HALF_OCTAVE)
    turn = [mean(m.turn, m.turn_pairs) for m in all_sums]
    fitted = grid.square_lags <= lags
    times = [walker.seconds for walker in turnings]
    if tracks.lane:
        times = [float(whole.run[1]) * tracks.interval / len(tracks.tracks)]
    own_s = float(np.mean(times)) if times else math.inf
    settings = Settings(
        grid,
        tracks.interval,
        tracks.lane,
        headed,
        own_s,
        memory=False,
        memory_open=False,
        square_errors=np.where(fitted, msd.se, np.nan),
        turn_errors=statistics.jackknife_error(np.stack([[values.real, values.imag] for values in turn[1:]])).ravel(),
        walls=found_walls is not None,
    )
    settings, numbers = verdicts.choose_memory(all_sums, settings)
    numbers, fit = spread_numbers.add_fit(numbers, all_sums, settings, lags)
    means_of_walkers = particle_scatter.walker_means(tracks, settings, numbers[0]["shortened"], mean_steps)
    comparison = particle_scatter.compare(means_of_walkers)
    if headed:
        shortened = verdicts.jackknife_quantity(numbers, "shortened")
        means_of_walkers = [
            walker._replace(means=particle_scatter.add_shared_error(walker.means, shortened))
            for walker in means_of_walkers
        ]
        if comparison is not None:
            comparison = comparison._replace(means=particle_scatter.add_shared_error(comparison.means, shortened))
    single_tracks = tracks.tracks if in_pieces and comparison is not None else ()
    without_one = [whole, *(moments.subtract(whole, sum_moments([track])) for track in single_tracks)]
    numbers_without_one, between_turns = verdicts.evaluate_all(without_one, settings), turning.scatter(turnings)
    estimates = verdicts.attach_errors(
        numbers[0],
        numbers[1:],
        settings,
        fit,
        spread_numbers.add_refit(numbers_without_one[1:], without_one[1:], settings, fit),
        lags * tracks.interval,
        _effective_freedom(parts, int(fitted.sum()) - 1),
        between_turns.known or (comparison is not None and comparison.scatter.known),
    )
    if in_pieces:
        estimates |= _speed_means(means_of_walkers, comparison, settings)
    elif comparison is not None and not (headed or tracks.lane):
        estimates |= _mean_speed_from_rms(estimates, comparison.scatter)
    no_scatter = refusal("speed_scatter", "fewer than 2 walkers with speeds of their own")
    estimates["speed_scatter"] = comparison.scatter if comparison else no_scatter
    if on_plane:
        estimates |= interval_laws.turning_scatter_refusals(estimates, between_turns) | {
            "turning_scatter": between_turns
        }
        noise2, lasting = (
            verdicts.jackknife_quantity(numbers, name) for name in ("heading_variance", "turning_memory")
        )
        estimates["rotational_diffusion"] = turning.diffusion(turnings, noise2, lasting)
    if headed and not tracks.lane:
        estimates |= aligned
    if found_walls is not None:
        estimates |= free_turning.persistence(tracks.tracks, settings, estimates["speed"])
    correlation = _jackknife_curve(grid.turn_lags, [np.abs(values) for values in turn], length)
    compared = comparison.means if comparison else _speed_means(means_of_walkers, None, settings) if in_pieces else {}
    fewer = dict.fromkeys(UNITS, count - len(resting)) | dict.fromkeys(
        compared, comparison.walkers if comparison else 1
    )
    return Motion(
        estimates=estimates,
        particles=count,
        samples=len(parts),
        tracked_s=sum(len(track.position) - 1 for track in tracks.tracks) * tracks.interval,
        lag_s=grid.step * tracks.interval,
        method=_describe_method(settings, in_pieces, comparison, len(parts), length * tracks.interval),
        doubts=[
            *([found_walls.description] if found_walls else []),
            *_misfit_doubts(fit),
            *_scatter_doubts(estimates, descent),
            *_rest_doubts(resting, count),
        ],
        msd=msd._replace(at=msd.at * tracks.interval),
        exponent=exponent._replace(at=exponent.at * tracks.interval),
        msd_fit=None if fit is None or math.isnan(fit.spreads[0].offset) else fit,
        correlation=correlation._replace(at=correlation.at * tracks.interval),
        detrend_time_s=own_s,
        parallel=_density_curve(grid.bins[0], [sample.density_along for sample in all_sums]),
        orthogonal=_density_curve(grid.bins[1], [sample.density_across for sample in all_sums]),
        walkers=sorted([*means_of_walkers, *resting.values()], key=attrgetter("particle")),
        counted={name: f"{few} of {count} walkers" for name, few in fewer.items() if few < count},
        walls=found_walls,
    )


def _resting_walkers(tracks: Tracks) -> dict[int, WalkerMeans]:
    """Return the walkers that move far less than the fastest, by number, each with the reason why it is left out.

    Walkers are compared by their largest root mean square displacement over parts of the longest track.
    """
    longest = max(len(track.position) for track in tracks.tracks)
    steps = [max(longest // divisor, 1) for divisor in REST_LAG_DIVISORS]
    sizes = {}
    for track in tracks.tracks:
        squares = [
            (track.position[step:] - track.position[:-step]) ** 2 for step in steps if step < len(track.position)
        ]
        found = [np.nanmean(square.sum(axis=1)) for square in squares if not np.isnan(square).any(axis=1).all()]
        if found:
            sizes[track.particle] = math.sqrt(max(found))
    least = MAX_REST_SHARE * max(sizes.values(), default=0.0)
    reason = f"rests: moves less than {100 * MAX_REST_SHARE:g} % of the fastest, and is left out"
    return {
        track.particle: WalkerMeans(
            track.particle, (len(track.position) - 1) * tracks.interval, {"speed": refusal("speed", reason)}
        )
        for track in tracks.tracks
        if sizes.get(track.particle, math.inf) < least
    }


def _rest_doubts(resting: Mapping[int, WalkerMeans], count: int) -> list[str]:
    """Return the note on walkers that rest, in a list; [] without any."""
    numbers = ", ".join(map(str, list(resting)[:MAX_NAMED]))
    return [f"{len(resting)} of {count} walkers {REST_WORDS}: {numbers}"] if resting else []


def _effective_freedom(parts: Sequence[Moments], lag_index: int) -> float:
    """Return the degrees of freedom of samples whose numbers of pairs differ at the lag of this index (Kish 1965)."""
    pairs = np.array([part.square_pairs[lag_index] for part in parts])
    return max(float(pairs.sum() ** 2 / (pairs**2).sum()) - 1.0, 1.0) if pairs.any() else len(parts) - 1.0


def _level_headings(tracks: Tracks, estimates: Mapping[str, Quantity], descent: float | None) -> Sequence[Track]:
    """Return the tracks with headings as on a level plate; unchanged if the turning by the slope is unknown."""
    rate = estimates["slope_turning"].value
    if descent is None or rate is None:
        return tracks.tracks
    return [
        track if track.heading is None else alignment.remove_slope_turning(track, rate, tracks.interval, descent)
        for track in tracks.tracks
    ]


def _mean_turns(tracks: Tracks, turnings: Sequence[Turning]) -> dict[int, float]:
    """Return the mean turn per sample of each particle, rad; the mean over all particles for those unknown."""
    rates = np.array([(walker.rate, walker.seconds) for walker in turnings]).reshape(-1, 2).T
    mean_rate = float(rates[0] @ rates[1] / rates[1].sum()) if turnings else 0.0
    turns = dict.fromkeys((track.particle for track in tracks.tracks), mean_rate * tracks.interval)
    return turns | {walker.particle: walker.rate * tracks.interval for walker in turnings}


def _mean_lane_steps(tracks: Tracks) -> dict[int, float]:
    """Return the mean displacement per sample of each particle in a lane, mm."""
    sums = {track.particle: moments.net_displacement(track) for track in tracks.tracks}
    return {particle: float(displacement / max(samples, 1.0)) for particle, (displacement, samples) in sums.items()}


def _choose_grid(tracks: Tracks, lag_s: float, length: int, headed: bool) -> Grid:
    """Choose the lags, and the bins of displacements over `lag_s` s, for samples of this `length` in positions."""
    step = max(round(lag_s / tracks.interval), 1)
    longest = max(len(track.position) for track in tracks.tracks)
    moved = [moments.displacements(track, step) for track in tracks.tracks]
    along, across = (np.concatenate(parts) for parts in zip(*moved, strict=True))
    # Displacements without headings must not share a position, whose noise would correlate them.
    first = 1 if headed else step + 1
    max_turn_lag, max_square_lag = length // FITTED_LAG_DIVISOR, max(longest // 4, 1)
    reach = [track.reach for track in tracks.tracks if track.reach is not None]
    if reach:  # walls end the pairs that are free, not the tracks
        free = np.concatenate(reach)
        free = free[free >= (1 if headed else 2 * step + 1)]
        longest_free = int(np.quantile(free, 1.0 - FREE_PLACES_SHARE)) if len(free) else 0
        max_square_lag = min(max_square_lag, max(longest_free, 1))
        max_turn_lag = min(max_turn_lag, max_square_lag - (0 if headed else step))
    turns = np.zeros(0, np.int64) if tracks.lane else lag_sums.log_spaced_lags(max_turn_lag, count=32, shortest=first)
    squares = lag_sums.log_spaced_lags(max_square_lag, count=64)
    return Grid(step, squares, turns, (_bin_edges(along, step), _bin_edges(across, step)))


def _bin_edges(values: Array, step: int) -> Array:
    """Compute the edges of bins by Freedman and Diaconis' rule; every `step`-th of the values is independent."""
    if len(values) < 2 or np.ptp(values) <= 1e-9 * np.abs(values).max():
        return np.zeros(0)  # equal up to rounding: there is no density
    low, high = np.quantile(values, [0.25, 0.75])
    width = 2.0 * (high - low) / (len(values) / step) ** (1 / 3)
    count = math.ceil(np.ptp(values) / width) if width > 0 else 1
    return np.linspace(values.min(), values.max(), min(max(count, 5), 200) + 1)  # 5 to 200 bins


def _local_exponents(lags: Whole, values: Array) -> Array:
    """Compute d ln(value) / d ln(lag) at each lag, from parabolas through lags half an octave and more apart.

    Closer lags would show noise. NaN if there is no such lag on both sides, or no value > 0.
    """
    below = np.searchsorted(lags, lags / HALF_OCTAVE, side="right") - 1
    above = np.searchsorted(lags, lags * HALF_OCTAVE)
    (inside,) = np.nonzero((below >= 0) & (above < len(lags)))
    heights, log_lags = np.log(np.where(values > 0, values, np.nan)), np.log(lags)
    low, high = below[inside], above[inside]
    before, after = log_lags[inside] - log_lags[low], log_lags[high] - log_lags[inside]
    rise, fall = heights[inside] - heights[low], heights[high] - heights[inside]
    exponents = np.full(len(lags), np.nan)
    exponents[inside] = (rise * after / before + fall * before / after) / (before + after)
    return exponents


def _jackknife_curve(lags: Whole, values: Sequence[Array], length: float) -> Curve:
    """Return the curve of `values[0]` (all samples) by lag, with errors from `values[1:]` (one sample left out each).

    Errors are NaN beyond half of a sample's `length`. Lags and length are in positions.
    """
    resolved = lags <= int(length) // 2
    return Curve(
        lags.astype(float), values[0], np.where(resolved, statistics.jackknife_error(np.stack(values[1:])), np.nan)
    )


def _density_curve(edges: Array, counts: Sequence[Array]) -> Curve:
    """Return the density (1/mm) in bins with these edges (mm). `counts`: all samples, then one left out."""
    if not len(edges):
        return Curve(np.zeros(0), np.zeros(0), np.zeros(0))
    densities = [count / (max(count.sum(), 1.0) * np.diff(edges)) for count in counts]
    error = statistics.jackknife_error(np.stack(densities[1:]))
    if not all(count.any() for count in counts):
        error = np.full_like(error, np.nan)
    return Curve(0.5 * (edges[1:] + edges[:-1]), densities[0], error)


def _speed_means(
    walkers: Sequence[WalkerMeans], comparison: WalkerComparison | None, settings: Settings
) -> Mapping[str, Quantity]:
    """Return the mean speeds and turning over walkers if these were compared, otherwise those of the longest track."""
    if comparison is not None:
        return comparison.means
    means = max(walkers, key=lambda walker: walker.seconds).means
    longest = {name: mean if mean.known else mean._replace(value=None) for name, mean in means.items()}
    # Without headings the fit of all products is sharper than the first one.
    return longest if settings.lane or settings.headed else {"lane_speed": longest["lane_speed"]}


def _mean_speed_from_rms(estimates: Mapping[str, Quantity], scatter: Quantity) -> Mapping[str, Quantity]:
    """Return the mean speed, from the root mean square speed in `estimates` and the `scatter`; {} if impossible."""
    speed = estimates["speed"]
    if speed.value is None or scatter.value is None or scatter.value > abs(speed.value):
        return {}
    speed = speed._replace(value=math.sqrt(speed.value**2 - scatter.value**2))
    return {"speed": speed, "motion_speed": speed}


def _misfit_doubts(fit: DisplacementFit | None) -> list[str]:
    """Return the doubt, in a list, that the squared displacement follows another law than the fit's; else []."""
    if fit is None or not fit.p_value < MISFIT_P_VALUE:
        return []
    return [
        "the squared displacement follows another law: diffusivity, crossover, ballistic speed "
        "and noise are those of the best fit, see msd.csv"
    ]


def _scatter_doubts(estimates: Mapping[str, Quantity], descent: float | None) -> list[str]:
    """Return the doubt, in a list, about numbers of walkers on a slope, or of walkers that turn unequally; else []."""
    if descent is not None:
        return ["a slope turns and drives walkers: persistence, diffusivity and crossover are those on it"]
    if estimates["turning_scatter"].value is None:
        return []
    return [
        "walkers turn at rates of their own (turning scatter), of which the fit of the squared "
        "displacement (diffusivity, crossover) knows nothing"
    ]


def _describe_method(
    settings: Settings, in_pieces: bool, comparison: WalkerComparison | None, samples: int, length_s: float
) -> str:
    """Describe what `speed` means and where errors come from: particles or, `in_pieces`, tracks cut to `length_s` s."""
    if settings.lane:
        speed = "along the lane"
    elif settings.headed:
        speed = "along the body's heading"
    else:
        speed = "along the direction of motion, root mean square of the velocity that persists for the lag"
    if not in_pieces:
        method = f"speed {speed}; errors from {samples} independent samples of particles"
        return f"{method}; mean speed: {comparison.limit}" if comparison else method
    free = "equal times of free motion, of persistence from independent pairs of directions"
    pieces = f"{samples} pieces of " + (free if settings.walls else f"{length_s:.3g} s")
    if comparison is None:
        return f"speed {speed}; errors from {pieces}, which do not show how walkers differ"
    walkers = comparison.walkers
    return (
        f"speed {speed}; errors of speeds and turning bias over {walkers} walkers, by Student's t "
        f"with {walkers - 1} degrees of freedom; of other numbers from {pieces}, or over walkers "
        f"where they differ by more; mean speed: {comparison.limit}"
    )
