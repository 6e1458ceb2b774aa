"""Tracks of walkers from CSV files: trackpy's, Pogotrack's, or those that walkergen writes.

trackpy: frame, particle, x, y in pixels, optionally theta (rad) or theta_deg, the heading counted
from x toward y of the file's own axes. walkergen: t_s, x_mm; with theta_rad, the heading from x
toward y_mm, it is of a walker in space, seen from above; without it y_mm is vertical: a lane's.
Pogotrack (https://github.com/keivan-amini/pogotrack, docstring of `VideoProcessor` and function
`convert_datas`): time (s), x, y (cm), theta (degrees, from x toward y), particle, which may also be
called id; rows of frames that it skipped are blank. All may have `particle` and
`plate_speed_mm_s`, the plate's peak speed while the particle ran.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis.tracks import Track, Tracks
from walkergen.errors import InputError
from walkergen.files import columns, plain
from walkergen.files.columns import Columns

Array = npt.NDArray[np.float64]

MOST_FRAMES = 50_000_000
"""Largest number of frames of all tracks together, gaps included."""

LEAST_UNIT, LARGEST_UNIT = 1e-6, 1e9
"""Limits of frames per second, and of millimetres in a pixel."""

MOST_PARTICLES = 10_000
"""Largest number of tracks: measuring as many takes about 20 s (3 rows each, two busy cores)."""

MOST_TICKS = 1e15
"""Largest number of samples from the first to the last, which numbers still tell apart."""

LONGEST = 3.0
"""Longest time between neighbouring frames, over the usual one, within which a walker is followed:
a camera that slows down halves its rate or so; beyond, frames are missing."""

REGULAR = 0.01
"""Share of the interval by which times may lie off the regular grid."""


class Timed(NamedTuple):
    """Format of files that have their own times and lengths."""

    time: str
    """Column of the times, s."""
    axes: tuple[str, str]
    """Columns of the places."""
    heading: str
    particle: tuple[str, ...]
    """Names that the column of the particles may have."""
    length: float
    """Unit of the places, mm."""
    angle: float
    """Unit of the headings, rad."""

    @property
    def own_columns(self) -> str:
        """What the file has of its own, in words."""
        return f"{self.time} and {self.axes[0]}"


OURS = Timed("t_s", ("x_mm", "y_mm"), "theta_rad", ("particle",), 1.0, 1.0)
SCALE = ("mm_per_px", "mm_per_px_se")
"""Columns of a film's scale and its standard error, the same in all rows of a film."""

POGOTRACK = Timed("time", ("x", "y"), "theta", ("particle", "id"), 10.0, math.radians(1.0))


class Units(NamedTuple):
    """Units and axes of a file, as the command line gives them."""

    fps: float | None = None
    """Frames per second of a film."""
    mm_per_px: float | None = None
    y_down: bool = False
    """True when y grows downward in the file, as rows of an image do."""
    lane: bool = False
    """True when the walkers ran along a lane in x, so that y is ignored."""
    mm_per_px_se: float | None = None
    """Standard error of `mm_per_px`; None when it is not known."""


def read(path: Path, units: Units) -> Tracks:
    """Read the tracks of a CSV file.

    Raises InputError when columns or units are missing or contradict each other, when no row is
    usable, or when times do not lie on a regular grid. Bad rows are left out and named in `note`.
    """
    names = columns.header(path)
    if "t_s" in names and "x_mm" in names:
        return _trajectory(path, names, units)
    if "frame" in names and "x" in names:
        return _film(path, names, units)
    if "time" in names and "x" in names:
        return _timed(path, names, units, POGOTRACK, not units.lane)
    header = plain.line(", ".join(name for name in names if name))
    raise InputError(
        f"{path}: neither trackpy's columns (frame, particle, x, y) nor walkergen's (t_s, x_mm) "
        f"nor Pogotrack's (time, x, y, theta, particle); columns seen: {header}"
    )


def _trajectory(path: Path, names: list[str], units: Units) -> Tracks:
    """Read simulated trajectories: on the plate with a heading, else with y_mm as the height."""
    headed = OURS.heading in names
    if units.y_down:
        y = "has y to the left of x" if headed else "is a lane's, without y across it"
        raise InputError(f"--y-down: {path} {y}; leave it out")
    return _timed(path, names, units, OURS, headed and not units.lane)


def _timed(path: Path, names: list[str], units: Units, form: Timed, on_plane: bool) -> Tracks:
    """Read tracks that have their own times and lengths, on a plane or along a lane."""
    for flag, value in (("--fps", units.fps), ("--mm-per-px", units.mm_per_px)):
        if value is not None:
            raise InputError(f"{flag} {value:g}: {path} has its own {form.own_columns}; leave it out")
    axes = form.axes if on_plane else form.axes[:1]
    headed = on_plane and form.heading in names
    particle = next((name for name in form.particle if name in names), "particle")
    extra = ("frame", *SCALE) if form is OURS else ()
    optional = (particle, "plate_speed_mm_s", *extra, *([form.heading] if headed else []))
    table = columns.read(path, (form.time, *axes), optional)
    if particle in table.values:
        table.values["particle"] = table.values[particle]
    interval, ticks = _ticks(path, table, form)
    between = ""
    if {"frame", "particle"} <= set(table.values) and _off(ticks).any():
        table, between = _at_regular_times(table, form.time, form.heading)
        interval, ticks = _ticks(path, table, form)
    if (off := _off(ticks)).any():
        raise InputError(
            f"{path}: {form.time} on line {table.lines[off][0]} lies off the regular times of the "
            f"other rows, {interval:g} s apart; sample at a fixed rate"
        )
    steps = np.rint(ticks)
    flip = np.array([1.0, -1.0 if units.y_down else 1.0])[: len(axes)]
    position = form.length * flip * np.stack([table.values[name] for name in axes], axis=1)
    heading = form.angle * flip[-1] * table.values[form.heading] if headed else None
    if heading is not None and np.isnan(heading).all():
        heading = None
    scale_se = _scale_se(path, table) if form is OURS else None
    tracks = _assemble(path, table, steps, position, heading, interval)
    note = "; ".join(line for line in (between, tracks.note) if line)
    return tracks._replace(scale_se=scale_se, note=note)


def _at_regular_times(table: Columns, time: str, heading: str) -> tuple[Columns, str]:
    """Rows at whole multiples of the usual time between frames, and in words what was done.

    Between neighbouring frames places, and the `heading` (rad), change in proportion to time;
    nothing is made up where a frame is missing. A place between two frames has down to half the
    variance of its noise.
    """
    order = np.lexsort((table.values[time], table.values["particle"]))
    table = Columns({name: values[order] for name, values in table.values.items()}, table.lines[order], table.bad)
    steps, near = _steps(table, time)
    if not near.any():
        return table, ""
    usual = float(np.median(steps[near]))
    near &= steps <= LONGEST * usual
    at = table.values[time]
    first, last = np.ceil(at[:-1] / usual), np.ceil(at[1:] / usual)  # the last belongs to the next
    counts = np.where(near, last - first, 0.0).astype(np.int64)
    rows = np.repeat(np.arange(len(counts)), counts)
    places = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    regular_times = np.asarray(usual * (first[rows] + places), dtype=float)
    share = (regular_times - at[rows]) / steps[rows]
    values: dict[str, Array] = {time: regular_times}
    for name in table.values.keys() - {time}:
        column = table.values[name]
        change = np.diff(column)[rows]
        if name == heading:
            change = (change + np.pi) % (2.0 * np.pi) - np.pi
        # What is one number of a walker, as its own or the plate's speed, does not change with time
        values[name] = column[rows] + np.where(change == 0.0, 0.0, share * change)
    low, high = (1e3 * float(end(steps[near])) for end in (np.min, np.max))
    note = (
        f"the film's rate varies, {low:.3g} to {high:.3g} ms from frame to frame: places are taken "
        f"between its frames, every {1e3 * usual:.3g} ms"
    )
    return Columns(values, table.lines[rows], table.bad), note


def _steps(table: Columns, time: str) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Times from row to row, and where both are one particle's in neighbouring frames."""
    steps = np.diff(table.values[time])
    near = (np.diff(table.values["particle"]) == 0) & (np.diff(table.values["frame"]) == 1)
    return steps, near & (steps > 0)


def _ticks(path: Path, table: Columns, form: Timed) -> tuple[float, Array]:
    """Time between samples, s, and the times of the rows in it, from 0 on."""
    times = table.values[form.time]
    interval = _interval(path, times, _particles(table))
    ticks = (times - times.min()) / interval
    if ticks.max() > MOST_TICKS:
        raise InputError(
            f"{path}: {form.time} goes on for {ticks.max():.3g} samples of {interval:g} s; at most "
            f"{MOST_TICKS:g}: is a time mistyped?"
        )
    return interval, ticks


def _off(ticks: Array) -> npt.NDArray[np.bool_]:
    """True for rows that lie off the regular times."""
    return np.asarray(np.abs(ticks - np.rint(ticks)) > REGULAR)


def _scale_se(path: Path, table: Columns) -> float | None:
    """Largest share by which lengths of a file may be off; 0 for a simulation, which has no scale.

    None where a row does not know it.
    """
    if not set(SCALE) <= set(table.values):
        return 0.0
    scale, error = (table.values[name] for name in SCALE)
    if (scale <= 0).any() or (error < 0).any():
        raise InputError(f"{path}: mm_per_px must be > 0 and mm_per_px_se >= 0, or blank")
    share = float(np.max(error / scale))
    return None if math.isnan(share) else share


def _interval(path: Path, times: Array, particle: Array) -> float:
    """Time between samples, s: the commonest step of a particle."""
    order = np.lexsort((times, particle))
    same = np.diff(particle[order]) == 0
    steps = np.diff(times[order])[same]
    steps = steps[steps > 0]
    if not len(steps):
        raise InputError(f"{path}: no particle has two different times; nothing moves")
    low = float(np.quantile(steps, 0.5, method="lower"))  # a step, not the mean of two
    close = steps[np.abs(steps - low) < REGULAR * low]
    # Written times are rounded: the mean over all close steps is the best estimate.
    return float(close.mean())


def _film(path: Path, names: list[str], units: Units) -> Tracks:
    fps, scale = _film_units(path, units)
    if "theta" in names and "theta_deg" in names:
        raise InputError(f"{path}: both theta (rad) and theta_deg; keep one")
    angle = next((name for name in ("theta", "theta_deg") if name in names), None)
    optional = ("particle", "plate_speed_mm_s", *([angle] if angle else []))
    table = columns.read(path, ("frame", "x") if units.lane else ("frame", "x", "y"), optional)
    frames = table.values["frame"]
    table = table.without(frames != np.rint(frames), "frame is not a whole number")
    if not len(table.lines):
        raise InputError(f"{path}: nothing to read: {columns.summary(table.bad)}")
    flip = -1.0 if units.y_down else 1.0
    axes = [table.values["x"]] if units.lane else [table.values["x"], flip * table.values["y"]]
    heading = None
    if angle is not None and not units.lane:
        unit = math.radians(1.0) if angle == "theta_deg" else 1.0
        heading = flip * unit * table.values[angle]
        if np.isnan(heading).all():
            heading = None
    position = scale * np.stack(axes, axis=1)
    frames = table.values["frame"]
    tracks = _assemble(path, table, frames - frames.min(), position, heading, 1.0 / fps)
    error = units.mm_per_px_se
    return tracks._replace(scale_se=None if error is None else error / scale)


def _film_units(path: Path, units: Units) -> tuple[float, float]:
    for flag, value, what in (
        ("--fps", units.fps, "frames per second of the film"),
        ("--mm-per-px", units.mm_per_px, "millimetres per pixel (1 if x and y are in mm)"),
    ):
        if value is None:
            raise InputError(f"{path}: counts frames and pixels; give {flag}, the {what}")
        if not LEAST_UNIT <= value <= LARGEST_UNIT:
            raise InputError(f"{flag} {value:g}: must be a number in {LEAST_UNIT:g}..{LARGEST_UNIT:g}")
    assert units.fps is not None
    assert units.mm_per_px is not None
    return units.fps, units.mm_per_px


def _particles(table: Columns) -> Array:
    """Number of each row's particle; 0 for all rows when the file does not number particles."""
    return table.values.get("particle", np.zeros(len(table.lines)))


def _assemble(path: Path, table: Columns, steps: Array, position: Array, heading: Array | None, tick: float) -> Tracks:
    """Sort rows into tracks, on the coarsest grid of times that holds all of their steps."""
    particle = _particles(table)
    plate = table.values.get("plate_speed_mm_s", np.full(len(steps), np.nan))
    order = np.lexsort((steps, particle))
    twice = np.zeros(len(steps), dtype=bool)
    twice[order[1:]] = (np.diff(particle[order]) == 0) & (np.diff(steps[order]) == 0)
    unnumbered = particle != np.rint(particle)  # NaN as well
    if twice.any() and "particle" not in table.values:
        raise InputError(
            f"{path}: line {table.lines[twice][0]} repeats a frame and there is no column "
            "particle; link the positions first (trackpy.link)"
        )
    bad = table.without(twice, "its particle has been seen at this time before").bad
    bad |= table.without(unnumbered, "particle is not a whole number").bad
    order = order[~(twice | unnumbered)[order]]
    if not len(order):
        raise InputError(f"{path}: nothing to read: {columns.summary(bad)}")
    names, starts = np.unique(particle[order], return_index=True)
    if len(names) > MOST_PARTICLES:
        raise InputError(f"{path}: {len(names)} particles; at most {MOST_PARTICLES}: leave out short tracks")
    groups = np.split(order, starts[1:])
    stride = int(np.gcd.reduce([np.gcd.reduce(np.diff(steps[g]).astype(np.int64)) for g in groups]))
    stride = max(stride, 1)
    total = sum(int(steps[g[-1]] - steps[g[0]]) // stride + 1 for g in groups)
    if total > MOST_FRAMES:
        raise InputError(
            f"{path}: the particles' first and last times are {total} steps apart in all, with "
            f"{len(order)} rows; at most {MOST_FRAMES}: is a time or frame mistyped?"
        )
    tracks = tuple(
        _track(path, int(name), group, (steps - steps[group[0]]) // stride, position, heading, plate)._replace(
            start=int(steps[group[0]] // stride)
        )
        for name, group in zip(names, groups, strict=True)
    )
    return Tracks(tracks, stride * tick, len(bad), columns.summary(bad))


def _track(
    path: Path,
    name: int,
    rows: npt.NDArray[np.int64],
    places: Array,
    position: Array,
    heading: Array | None,
    plate: Array,
) -> Track:
    at = places[rows].astype(np.int64)
    grid = np.full((int(at[-1]) + 1, position.shape[1]), np.nan)
    grid[at] = position[rows]
    angles = None
    if heading is not None:
        angles = np.full(len(grid), np.nan)
        angles[at] = heading[rows]
    speeds = np.unique(plate[rows][~np.isnan(plate[rows])])
    if len(speeds) > 1:
        raise InputError(
            f"{path}: particle {name} has several plate_speed_mm_s ({speeds[0]:g}, {speeds[1]:g}); "
            "number the particle anew for each"
        )
    if len(speeds) and speeds[0] < 0:
        raise InputError(f"{path}: plate_speed_mm_s = {speeds[0]:g}: must be >= 0")
    return Track(name, grid, angles, float(speeds[0]) if len(speeds) else None)
