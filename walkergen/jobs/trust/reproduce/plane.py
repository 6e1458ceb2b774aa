"""Motion on a plane: tracks of runs in space, and how their squared displacement grows."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import lagged, motion
from walkergen.analysis.motion import Curve, Motion
from walkergen.analysis.tracks import Track, Tracks
from walkergen.analysis.values import Value, mean
from walkergen.files.progress import Progress
from walkergen.jobs.trust.reproduce.sweeps import Assumption, on_plane
from walkergen.numerics import statistics
from walkergen.points import walkers
from walkergen.scene import Scene
from walkergen.simulation import experiments
from walkergen.simulation.run import ENDED_WELL, RunResult
from walkergen.simulation.trajectory import sampled
from walkergen.walker import solids
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

TILTS = (10.0, 15.0, 35.0)
"""Tilts of the walkers in figure 6, deg (stated)."""

INTERVAL = 4e-3
"""Time between samples of a track, s: a tenth of the lag of figure 6c."""

LONGER = 1.5
"""Length of these runs over that of planar runs: lags reach a quarter of it, 3 s by default."""

PER_DECADE = 8
"""Number of lags in a decade; an exponent is the slope over two steps, a quarter of a decade."""

SHORTEST = 0.04
"""Shortest lag of the exponents, s: that of figure 6c, some four periods of the drive."""

LATE = 1.0
"""Lag from which the paper's slow walker is diffusive, s (stated)."""

HALFWAY = 1.5
"""Local exponent at the crossover, halfway from ballistic to diffusive."""


class Growth(NamedTuple):
    """Growth of the mean squared displacement with the lag."""

    exponents: Curve
    """Local exponents d log MSD / d log lag by lag (s); empty for runs too short, or at rest."""
    first: Value | None
    """Exponent at the shortest lag."""
    smallest: Value | None
    """Smallest exponent at any lag."""
    late: Value | None
    """Exponent from LATE to the longest lag; None when that is shorter than 1.5 LATE."""
    crossover: Value | None
    """Lag at which the exponent first falls to HALFWAY, s; None when it does not in every run."""


class Runs(NamedTuple):
    """Runs of one walker on a plane, over those that ended well."""

    assumption: str
    tilt_deg: float
    tracks: Tracks
    motion: Motion
    """Statistics by the analysis that films go through."""
    growth: Growth
    speed: Value
    """Mean speed along the heading, mm/s."""
    lost: int
    """Number of runs that ended badly."""


def along_tilts(assumptions: Sequence[Assumption], designs: Sequence[Design], progress: Progress) -> list[Runs]:
    """Simulate walkers on a plane under every assumption, but ensembles without two good runs."""
    cases = [(assumption.name, on_plane(assumption.scene), design) for assumption in assumptions for design in designs]
    requests = [
        experiments.Walker(_longer(scene), design, solids.mass_of(design), sample_interval=INTERVAL)
        for _, scene, design in cases
    ]
    tilts = [design.tilt_deg for *_, design in cases]
    names = [name for name, *_ in cases]
    titles = [f"{name}, on a plane, {tilt:g} deg" for name, tilt in zip(names, tilts, strict=True)]
    simulated = walkers.each(requests, titles, progress)
    ensembles = [measured(name, tilt, point.results) for name, tilt, point in zip(names, tilts, simulated, strict=True)]
    return [runs for runs in ensembles if runs is not None]


def _longer(scene: Scene) -> Scene:
    run = scene.run.model_copy(update={"seconds": LONGER * scene.run.seconds})
    return scene.model_copy(update={"run": run})


def measured(assumption: str, tilt_deg: float, results: Sequence[RunResult]) -> Runs | None:
    """Statistics of runs with their samples; None when fewer than two ended well."""
    good = [result for result in results if result.outcome in ENDED_WELL]
    if len(good) < 2:
        return None
    tracks = Tracks(tuple(_track(result) for result in good), INTERVAL, 0, "")
    return Runs(
        assumption,
        tilt_deg,
        tracks,
        motion.analyse(tracks),
        growth(tracks),
        mean([result.speed for result in good]),
        len(results) - len(good),
    )


def _track(result: RunResult) -> Track:
    rows = sampled(result)
    return Track(result.number, rows[:, 1:3].copy(), rows[:, 3].copy())


def growth(tracks: Tracks) -> Growth:
    """Local exponents at lags from SHORTEST to a quarter of the shortest track, and what they say.

    An exponent is the slope over two neighbouring steps of lags on the logarithmic scale. Errors
    are those of a jackknife over the tracks.
    """
    longest = min(len(track.position) for track in tracks.tracks) // motion.FITTED
    shortest = max(round(SHORTEST / tracks.interval), 1)
    count = round(PER_DECADE * math.log10(max(longest / shortest, 1.0))) + 1
    lags = lagged.spread_out(longest, count, shortest)
    sums = np.array([lagged.squares(track.position, lags) for track in tracks.tracks])
    whole = sums.sum(axis=0)
    if len(lags) < 3 or not (whole - sums > 0.0).all():
        none = np.zeros(0)
        return Growth(Curve(none, none, none), None, None, None, None)
    log_sums = [np.log(squares / pairs) for squares, pairs in (whole, *(whole - sums))]
    log_lags = np.log(lags * tracks.interval)
    slopes = np.array([(logs[2:] - logs[:-2]) / (log_lags[2:] - log_lags[:-2]) for logs in log_sums])
    errors = np.asarray(statistics.jackknife_error(slopes[1:]))
    lowest = int(slopes[0].argmin())
    return Growth(
        Curve(np.exp(log_lags[1:-1]), slopes[0], errors),
        Value(float(slopes[0, 0]), float(errors[0])),
        Value(float(slopes[0, lowest]), float(errors[lowest])),
        _value([_late(log_lags, logs) for logs in log_sums]),
        _value([_crossover(log_lags[1:-1], exponents) for exponents in slopes]),
    )


def _value(replicates: Sequence[float]) -> Value | None:
    """Value of the whole, which comes first, with the error that the rest give it."""
    numbers = np.array(replicates)
    if not np.isfinite(numbers).all():
        return None
    return Value(float(numbers[0]), float(statistics.jackknife_error(numbers[1:, None])[0]))


def _late(log_lag: Array, log_squares: Array) -> float:
    """Slope of log MSD from LATE to the longest lag; NaN when that is shorter than 1.5 LATE."""
    first, last = math.log(LATE), float(log_lag[-1])
    if last < first + math.log(1.5):
        return math.nan
    return float((log_squares[-1] - np.interp(first, log_lag, log_squares)) / (last - first))


def _crossover(log_lag: Array, slopes: Array) -> float:
    """Lag (s) at which the slopes first fall to HALFWAY; NaN when they do not."""
    below = np.flatnonzero(slopes <= HALFWAY)
    if not len(below) or below[0] == 0:
        return math.nan
    at = int(below[0])
    share = (slopes[at - 1] - HALFWAY) / (slopes[at - 1] - slopes[at])
    return math.exp(log_lag[at - 1] + share * (log_lag[at] - log_lag[at - 1]))
