"""Statistics of a crowd from independent runs: numbers, their course in time, and curves.

Every error comes from the scatter of four or more runs. Fewer runs give errors of numbers that vary in time, if the
runs are much longer than their correlation time. Their curves have no errors.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis.motion import Curve
from walkergen.core import Array, Dish, InputError, Quantity, correlation_time, error_of_mean, weighted_mean
from walkergen.guests.crowd.statistics import clusters, displacements, fluctuations, order, packing, pairs, walls
from walkergen.guests.crowd.statistics.film import CrowdFilm, mean_over_walkers

UNITS = {
    "packing": "",
    "packing_scatter": "",
    "polar_order": "",
    "nematic_order": "",
    "local_polar_order": "",
    "local_nematic_order": "",
    "circulation": "",
    "milling": "",
    "speed": "mm_s",
    "speed_along_heading": "mm_s",
    "spread_exponent": "",
    "fluctuation_exponent": "",
    "clusters": "",
    "largest_cluster": "",
    "cluster_size": "",
    "alone": "",
    "touching": "",
    "wall_density": "",
    "wall_speed": "mm_s",
    "wall_alignment": "",
}
"""Names of the numbers and their units as keys write them ("" is a pure number). `milling` is the
mean modulus of `circulation`, which may go either way; `wall_density` is over the mean."""

SHARE, COSINE, AT_LEAST_0 = (0.0, 1.0), (-1.0, 1.0), (0.0, math.inf)

RANGES = {
    **dict.fromkeys(("packing", "polar_order", "nematic_order", "milling", "largest_cluster", "alone"), SHARE),
    **dict.fromkeys(("local_polar_order", "local_nematic_order", "circulation", "wall_alignment"), COSINE),
    **dict.fromkeys(("packing_scatter", "speed", "clusters", "touching", "wall_density", "wall_speed"), AT_LEAST_0),
    "cluster_size": (1.0, math.inf),
}
"""Possible values of numbers. Their confidence bounds are clipped to this range, at no loss of confidence."""

WHOLE_RUN_NUMBERS = ("spread_exponent", "fluctuation_exponent")
"""Numbers of a whole run, without a course in time."""

MIN_RUNS = 4
"""Number of runs below which their scatter gives no error, as for single walkers (`core.simulation.ensemble`)."""

MAX_PAIR_FRAMES = 200
"""Largest number of evenly spaced frames for pair statistics."""

MIN_FRAMES = 4
"""Least number of frames of a run."""

EQUAL_TOLERANCE = 1e-12
"""Relative tolerance for numbers that are equal in all runs, as the packing."""

NO_OUTLINE = "no outlines known"
NO_HEADING = "no headings known"
NO_WALL = "a periodic dish has no wall"
NO_PAIRS = "too few walkers"


class CrowdStatistics(NamedTuple):
    """Statistics of a crowd over all runs."""

    numbers: dict[str, Quantity]
    """Numbers by their keys, those of `UNITS`."""
    by_chance: dict[str, float]
    """Mean values of numbers for walkers at random positions and headings."""
    by_run: dict[str, Array]
    """Numbers of each run, shape (runs,)."""
    series: dict[str, Curve]
    """Course in time (s) of numbers, mean over the runs; errors NaN below MIN_RUNS."""
    curves: dict[str, Curve]
    """g, polar_correlation, nematic_correlation by distance (mm); msd (mm^2) by lag (s);
    fluctuations (variance) by mean number; local_packing (density) by packing; cluster_shares by
    size; wall_density, wall_speed (mm/s), wall_alignment by distance from the wall (mm)."""
    runs: int
    walkers: int
    frames: int
    """Frames of a run."""
    seconds: float
    """Length of a run, s."""
    dish: Dish
    notes: tuple[str, ...]
    """Sentences without full stops on how the numbers were measured."""


class _Run(NamedTuple):
    """Statistics of one run, by name."""

    series: dict[str, tuple[Array, Array]]
    """Times (s) and values of each number that has a course in time."""
    curves: dict[str, tuple[Array, Array]]
    """Abscissae and values of each curve."""
    totals: dict[str, float]
    """Numbers of the whole run."""


def measure(films: Sequence[CrowdFilm]) -> CrowdStatistics:
    """Measure one crowd from its independent runs in one dish. Raises InputError if runs differ or are too short."""
    _check_runs(films)
    shortest = min(len(film.times) for film in films)
    films = [film.select_frames(np.arange(shortest)) for film in films]
    varying = fluctuations.measure(films)
    runs = [_measure_run(film) for film in films]
    for run, exponent, variances in zip(runs, varying.exponents, varying.variances, strict=True):
        run.totals["fluctuation_exponent"] = float(exponent)
        run.curves["fluctuations"] = varying.means, variances
    by_run = {name: _values_by_run(runs, name) for name in UNITS}
    film = films[0]
    return CrowdStatistics(
        {name: _quantity(name, by_run[name], runs, film) for name in UNITS},
        _random_values(film),
        by_run,
        {name: _mean_curve([run.series[name] for run in runs]) for name in runs[0].series},
        {name: _mean_curve([run.curves[name] for run in runs]) for name in runs[0].curves},
        len(films),
        round(film.mean_walkers),
        shortest,
        float(film.times[-1] - film.times[0]),
        film.dish,
        _notes(films),
    )


def _check_runs(films: Sequence[CrowdFilm]) -> None:
    """Raise InputError if there is no run, or if runs differ or are too short."""
    if not films:
        raise InputError("a crowd has no run. Simulate or film at least one.")
    first = films[0]
    for film in films:
        if film.dish != first.dish or set(film.kinds) != set(first.kinds):
            raise InputError(f"runs differ: {_describe(film)} and {_describe(first)}. Measure them separately.")
        if len(film.times) < MIN_FRAMES:
            raise InputError(f"a run of a crowd has {len(film.times)} frames. At least {MIN_FRAMES} are needed.")


def _describe(film: CrowdFilm) -> str:
    """Return a text with the names of a film's designs and its dish."""
    return f"{', '.join(sorted(set(film.kinds)))} in {film.dish.words}"


def _measure_run(film: CrowdFilm) -> _Run:
    """Compute all statistics of one run except the fluctuations, which are about the mean of all runs."""
    thinned = film.select_frames(np.arange(0, len(film.times), -(-len(film.times) // MAX_PAIR_FRAMES)))
    run = _Run({}, {}, {})
    _add_motion(run, film)
    _add_pairs(run, thinned)
    if film.has_headings:
        circulation = order.circulation(film)
        run.series["polar_order"] = film.times, order.polar_order(film)
        run.series["nematic_order"] = film.times, order.nematic_order(film)
        if not film.dish.period:
            run.series["circulation"] = film.times, circulation
            run.series["milling"] = film.times, np.abs(circulation)
    if film.has_sizes:
        _add_outline_statistics(run, film, thinned)
    if not film.dish.period:
        _add_walls(run, film)
    return run


def _add_motion(run: _Run, film: CrowdFilm) -> None:
    """Add speeds and mean squared displacements to the statistics of a run."""
    between = 0.5 * (film.times[1:] + film.times[:-1])
    speed, ahead = displacements.speeds(film)
    run.series["speed"] = between, mean_over_walkers(speed)
    if film.has_headings:
        run.series["speed_along_heading"] = between, mean_over_walkers(ahead)
    run.curves["msd"] = displacements.squared_displacement(film)
    run.totals["spread_exponent"] = displacements.growth_exponent(*run.curves["msd"])


def _add_pairs(run: _Run, thinned: CrowdFilm) -> None:
    """Add pair correlation and local order to a run's statistics, from a film of fewer frames."""
    found = pairs.measure(thinned, pairs.bin_edges(thinned))
    run.curves["g"] = found.at, found.g
    if thinned.has_headings:
        run.curves["polar_correlation"] = found.at, found.polar
        run.curves["nematic_correlation"] = found.at, found.nematic
        run.series["local_polar_order"] = thinned.times, found.near_polar
        run.series["local_nematic_order"] = thinned.times, found.near_nematic


def _add_outline_statistics(run: _Run, film: CrowdFilm, thinned: CrowdFilm) -> None:
    """Add packing, and clusters from a film of fewer frames, to the statistics of a run."""
    local = packing.local_packing(film)
    run.series["packing"] = film.times, packing.total_packing(film)
    run.series["packing_scatter"] = film.times, packing.scatter(local)
    if local.shape[1] > 1:
        run.curves["local_packing"] = packing.probability_density(local)
    joined = clusters.measure(thinned)
    run.curves["cluster_shares"] = (np.exp2(np.arange(len(joined.shares), dtype=float)), joined.shares)
    for name, values in (
        ("clusters", joined.number),
        ("largest_cluster", joined.largest),
        ("cluster_size", joined.size),
        ("alone", joined.alone),
        ("touching", joined.touching),
    ):
        run.series[name] = thinned.times, values


def _add_walls(run: _Run, film: CrowdFilm) -> None:
    """Add density, speed and alignment at walls to the statistics of a run."""
    at_walls = walls.measure(film)
    between = 0.5 * (film.times[1:] + film.times[:-1])
    run.series["wall_density"] = film.times, at_walls.near_density
    run.series["wall_speed"] = between, at_walls.near_speed
    run.curves["wall_density"] = at_walls.at, at_walls.density
    run.curves["wall_speed"] = at_walls.at, at_walls.speed
    if film.has_headings:
        run.series["wall_alignment"] = film.times, at_walls.near_alignment
        run.curves["wall_alignment"] = at_walls.at, at_walls.alignment


def _values_by_run(runs: Sequence[_Run], name: str) -> Array:
    """Return the number `name` of each run, a mean over time if it has a course in time; NaN if it is unknown."""
    return np.array(
        [_finite_mean(run.series[name][1]) if name in run.series else run.totals.get(name, math.nan) for run in runs]
    )


def _quantity(name: str, values: Array, runs: Sequence[_Run], film: CrowdFilm) -> Quantity:
    """Return the mean of the runs' values, (runs,), as a quantity, with the reason for an unknown value or error."""
    unit = UNITS[name]
    if np.isnan(values).any():
        return Quantity(name, unit, None, refused=_missing_reason(name, film))
    courses = [run.series[name] for run in runs if name in run.series]
    constant = all(np.ptp(course[np.isfinite(course)]) == 0.0 for _, course in courses)
    if np.ptp(values) <= EQUAL_TOLERANCE * abs(float(values[0])) and (len(values) > 1 or (courses and constant)):
        return Quantity(name, unit, float(values[0]), 0.0)
    if len(values) >= MIN_RUNS:
        return _clip_bounds(Quantity(name, unit, *weighted_mean(values)[:2], freedom=len(values) - 1.0))
    return _clip_bounds(_quantity_of_few_runs(name, float(values.mean()), courses, len(values)))


def _quantity_of_few_runs(name: str, value: float, courses: Sequence[tuple[Array, Array]], runs: int) -> Quantity:
    """Return the mean `value` of runs, with an error if they are much longer than the correlation time of `courses`."""
    values = [course for _, course in courses]
    if values and all(np.isfinite(course).all() for course in values):
        interval = float(courses[0][0][1] - courses[0][0][0])
        time = correlation_time(values, interval)
        se = None if time is None else error_of_mean(values, interval, time)
        if time is not None and se is not None:
            independent = sum(map(len, values)) * interval / (2.0 * time)
            return Quantity(name, UNITS[name], value, se, independent - 1.0)
    return Quantity(name, UNITS[name], value, refused=few_runs_reason(runs))


def few_runs_reason(runs: int) -> str:
    """Return the reason why so few runs give no confidence bounds."""
    return "one run is too short for bounds" if runs == 1 else f"{runs} runs are too few for bounds"


def _clip_bounds(number: Quantity) -> Quantity:
    """Return a quantity whose bounds end at its possible values."""
    least, most = RANGES.get(number.key, (-math.inf, math.inf))
    wide, narrow = number.interval(0.95), number.interval(0.68)
    if wide is None or narrow is None or (wide[0] >= least and wide[1] <= most):
        return number
    low_95, low_68, high_68, high_95 = (min(max(end, least), most) for end in (wide[0], *narrow, wide[1]))
    return number._replace(ends=(low_95, low_68, high_68, high_95))


def _missing_reason(name: str, film: CrowdFilm) -> str:
    """Return the reason why a film gives no value for a number."""
    walled = name.startswith("wall_") or name in ("circulation", "milling")
    if walled and film.dish.period:
        return NO_WALL
    outlined = ("packing", "packing_scatter", "clusters", "largest_cluster", "cluster_size", "alone", "touching")
    if name in outlined and not film.has_sizes:
        return NO_OUTLINE
    return NO_PAIRS if film.has_headings or name in outlined else NO_HEADING


def _mean_curve(curves: Sequence[tuple[Array, Array]]) -> Curve:
    """Return the mean of the runs' curves (abscissae, values), and its error: NaN below MIN_RUNS or without values."""
    values = np.stack([values for _, values in curves])
    error = np.full(values.shape[1], math.nan)
    if len(values) >= MIN_RUNS:
        error = values.std(axis=0, ddof=1) / math.sqrt(len(values))
    return Curve(curves[0][0], values.mean(axis=0), error)


def _random_values(film: CrowdFilm) -> dict[str, float]:
    """Return the values of numbers, by name, that walkers at random positions and headings have on average."""
    walkers = max(film.mean_walkers, 1.0)
    return {
        "polar_order": order.random_order(walkers),
        "nematic_order": order.random_order(walkers),
        "local_polar_order": 0.0,
        "local_nematic_order": 0.0,
        "circulation": 0.0,
        "milling": order.random_circulation(walkers),
        "fluctuation_exponent": 0.5,
        "wall_density": 1.0,
        "wall_alignment": 0.0,
    }


def _notes(films: Sequence[CrowdFilm]) -> tuple[str, ...]:
    """Return sentences about errors and the definitions of clusters, local order and walls."""
    film = films[0]
    if len(films) >= MIN_RUNS:
        errors = f"errors come from the scatter of {len(films)} independent runs"
    else:
        errors = (
            f"{few_runs_reason(len(films))}, except of numbers that change fast; {MIN_RUNS} or more give bounds of all"
        )
    lines = [errors]
    if film.has_sizes:
        how = (
            f"outlines are nearer than {clusters.TOUCHING_GAP * float(film.radii.mean()):.3g} mm"
            if film.outlines
            else "centres are nearer than the sum of the outer radii"
        )
        lines.append(f"walkers touch, and belong to one cluster, if their {how}")
    near = pairs.NEIGHBOUR_DIAMETERS * pairs.length_scale(film)
    lines.append(f"local orders are means over pairs nearer than {near:.3g} mm")
    if not film.dish.period:
        lines.append(f"a walker is at the wall within {walls.near_distance(film):.3g} mm of it")
    return tuple(lines)


def _finite_mean(values: Array) -> float:
    """Return the mean of the finite values; NaN without any."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan
