"""Tracks at regular times, built from rows of a table and interpolated where the frame rate varies."""

from pathlib import Path

import numpy as np

from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.errors import InputError
from walkergen.core.files import columns
from walkergen.core.files.columns import Columns
from walkergen.core.numerics import Array, Mask, Whole

MAX_FRAMES = 50_000_000
"""Largest number of frames of all tracks together, gaps included."""

MAX_PARTICLES = 10_000
"""Largest number of tracks: measuring as many takes about 20 s (3 rows each, two busy cores)."""

MAX_TICKS = 1e15
"""Largest number of samples from the first to the last that numbers can represent exactly."""

MAX_STEP_RATIO = 3.0
"""Longest time between neighbouring frames, over the usual one, within which a walker is followed."""

GRID_TOLERANCE = 0.01
"""Maximum deviation of times from the regular grid, as a share of the interval."""

ROUNDING_STEPS_S, ROUNDING_TOLERANCE = (1e-2, 1e-3, 1e-4), 1e-6
"""Steps of programs that round times, s, and the maximum deviation of a time, as a share of the step."""

MAX_ROUNDING_SHARE = 0.25
"""Maximum rounding, as a share of the interval, of times that still give the number of samples between them."""


def from_times(path: Path, table: Columns, name: str) -> Tracks:
    """Build tracks from rows with a column `time`, s, which is called `name` in the file `path`.

    x and, on a plane, y are in mm, `theta` in rad. Raises InputError for times off a regular grid.
    """
    interval, ticks, off_grid = _sample_ticks(path, table, name)
    note = ""
    if off_grid.any():
        table, note = _resample_regularly(table, int(off_grid.sum()))
        interval, ticks, off_grid = _sample_ticks(path, table, name)
    if off_grid.any():
        raise InputError(
            f"{path}: {name} on line {table.lines[off_grid][0]} lies off the regular times of the "
            f"other rows, {interval:g} s apart; sample at a fixed rate"
        )
    tracks = _build_tracks(path, table, np.rint(ticks), interval)
    lines = "; ".join(line for line in (note, tracks.note) if line)
    return tracks._replace(note=lines, first_s=float(table.values["time"].min()))


def from_frames(path: Path, table: Columns, fps: float) -> Tracks:
    """Build tracks from rows with a column `frame`, at `fps` frames per second. Raises InputError."""
    frames = table.values["frame"]
    table = table.reject_rows(frames != np.rint(frames), "frame is not a whole number")
    if not len(table.lines):
        raise InputError(f"{path}: nothing to read: {columns.describe_bad_rows(table.bad)}")
    frames = table.values["frame"]
    return _build_tracks(path, table, frames - frames.min(), 1.0 / fps)._replace(first_s=float(frames.min()) / fps)


def _resample_regularly(table: Columns, irregular: int) -> tuple[Columns, str]:
    """Interpolate the rows to whole multiples of the median time between frames; return them and a note.

    `irregular`: number of rows whose times are off a regular rate.
    Times without frames stay empty. Between two frames, the noise of a position has down to half its variance.
    """
    order = np.lexsort((table.values["time"], _particle_numbers(table)))
    table = Columns({name: values[order] for name, values in table.values.items()}, table.lines[order], table.bad)
    steps, near = _row_steps(table)
    if not near.any():
        return table, ""
    interval = float(np.median(steps[near]))
    near &= steps <= MAX_STEP_RATIO * interval
    times = table.values["time"]
    first, last = np.ceil(times[:-1] / interval), np.ceil(times[1:] / interval)  # `last` belongs to the next row
    counts = np.where(near, last - first, 0.0).astype(np.int64)
    rows = np.repeat(np.arange(len(counts)), counts)
    offsets = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    regular_times = np.asarray(interval * (first[rows] + offsets), dtype=float)
    share = (regular_times - times[rows]) / steps[rows]
    values: dict[str, Array] = {"time": regular_times}
    for name in table.values.keys() - {"time"}:
        column = table.values[name]
        change = np.diff(column)[rows]
        if name == "theta":
            change = (change + np.pi) % (2.0 * np.pi) - np.pi
        # A column with one number per walker, such as the plate's speed, does not change with time
        values[name] = column[rows] + np.where(change == 0.0, 0.0, share * change)
    low, high = (1e3 * float(end(steps[near])) for end in (np.min, np.max))
    note = (
        f"the film's rate varies, {low:.3g} to {high:.3g} ms from frame to frame ({irregular} of {len(times)} times "
        f"are irregular): places are taken between its frames, every {1e3 * interval:.3g} ms"
    )
    return Columns(values, table.lines[rows], table.bad), note


def _row_steps(table: Columns) -> tuple[Array, Mask]:
    """Return the times from row to row (s), and which of them join neighbouring frames of one particle."""
    steps = np.diff(table.values["time"])
    near = np.diff(_particle_numbers(table)) == 0
    if "frame" in table.values:
        near &= np.diff(table.values["frame"]) == 1
    return steps, near & (steps > 0)


def _sample_ticks(path: Path, table: Columns, name: str) -> tuple[float, Array, Mask]:
    """Return the time between samples (s), the rows' times in samples from the first, and which are off the grid."""
    times = table.values["time"]
    rounding = _rounding_step(times)
    interval = _sample_interval(path, times, _particle_numbers(table), rounding)
    ticks = (times - times.min()) / interval
    if ticks.max() > MAX_TICKS:
        raise InputError(
            f"{path}: {name} goes on for {ticks.max():.3g} samples of {interval:g} s. At most "
            f"{MAX_TICKS:g}: is a time mistyped?"
        )
    return interval, ticks, np.abs(ticks - np.rint(ticks)) > max(GRID_TOLERANCE, rounding / interval)


def _rounding_step(times: Array) -> float:
    """Return the step (s, a power of ten) to which all times are rounded; 0 if they have more digits."""
    for step in ROUNDING_STEPS_S:
        if (np.abs(times / step - np.rint(times / step)) < ROUNDING_TOLERANCE).all():
            return step
    return 0.0


def _sample_interval(path: Path, times: Array, particle: Array, rounding: float) -> float:
    """Return the time between samples, s: the commonest step of a particle. `rounding`: from `_rounding_step`, s."""
    order = np.lexsort((times, particle))
    same = np.diff(particle[order]) == 0
    steps = np.diff(times[order])[same]
    steps = steps[steps > 0]
    if not len(steps):
        raise InputError(f"{path}: no particle has two different times; nothing moves")
    low = float(np.quantile(steps, 0.5, method="lower"))  # a step, not the mean of two
    if GRID_TOLERANCE * low < rounding < MAX_ROUNDING_SHARE * low:  # steps of 36 and 35 ms are one rate
        counts = np.rint(steps / low)
        close = np.abs(steps - counts * low) <= counts * rounding * (1.0 + ROUNDING_TOLERANCE)
        return float(steps[close].sum() / counts[close].sum())
    close = np.abs(steps - low) < GRID_TOLERANCE * low
    # Written times are rounded: the mean over all close steps is the best estimate.
    return float(steps[close].mean())


def _particle_numbers(table: Columns) -> Array:
    """Return the number of each row's particle; 0 for all rows when the file does not number particles."""
    return table.values.get("particle", np.zeros(len(table.lines)))


def _build_tracks(path: Path, table: Columns, ticks: Array, interval: float) -> Tracks:
    """Sort rows into tracks, on the coarsest grid with all `ticks`: the rows' times from 0, over `interval` (s)."""
    position = np.stack([table.values[axis] for axis in ("x", "y") if axis in table.values], axis=1)
    heading = table.values.get("theta")
    if heading is not None and np.isnan(heading).all():
        heading = None
    particle = _particle_numbers(table)
    plate = table.values.get("plate_speed_mm_s", np.full(len(ticks), np.nan))
    order = np.lexsort((ticks, particle))
    repeated = np.zeros(len(ticks), dtype=bool)
    repeated[order[1:]] = (np.diff(particle[order]) == 0) & (np.diff(ticks[order]) == 0)
    unnumbered = particle != np.rint(particle)  # NaN as well
    if repeated.any() and "particle" not in table.values:
        raise InputError(
            f"{path}: line {table.lines[repeated][0]} repeats a frame and there is no column "
            "particle. Link the positions first (trackpy.link)"
        )
    bad = table.reject_rows(repeated, "its particle has been seen at this time before").bad
    bad |= table.reject_rows(unnumbered, "particle is not a whole number").bad
    order = order[~(repeated | unnumbered)[order]]
    if not len(order):
        raise InputError(f"{path}: nothing to read: {columns.describe_bad_rows(bad)}")
    names, starts = np.unique(particle[order], return_index=True)
    if len(names) > MAX_PARTICLES:
        raise InputError(f"{path}: {len(names)} particles. At most {MAX_PARTICLES}: leave out short tracks")
    groups = np.split(order, starts[1:])
    stride = int(np.gcd.reduce([np.gcd.reduce(np.diff(ticks[g]).astype(np.int64)) for g in groups]))
    stride = max(stride, 1)
    total = sum(int(ticks[g[-1]] - ticks[g[0]]) // stride + 1 for g in groups)
    if total > MAX_FRAMES:
        raise InputError(
            f"{path}: the particles' first and last times are {total} steps apart in all, with "
            f"{len(order)} rows. At most {MAX_FRAMES}: is a time or frame mistyped?"
        )
    tracks = tuple(
        _build_track(
            path, int(name), group, (ticks[group] - ticks[group[0]]) // stride, position, heading, plate
        )._replace(start=int(ticks[group[0]] // stride))
        for name, group in zip(names, groups, strict=True)
    )
    return Tracks(tracks, stride * interval, len(bad), columns.describe_bad_rows(bad))


def _build_track(
    path: Path, particle: int, rows: Whole, samples: Array, position: Array, heading: Array | None, plate_speeds: Array
) -> Track:
    """Build a particle's track from its `rows` in the other arrays (mm, rad, mm/s), at `samples` of a regular grid."""
    speeds = np.unique(plate_speeds[rows][~np.isnan(plate_speeds[rows])])
    if len(speeds) > 1:
        raise InputError(
            f"{path}: particle {particle} has several plate_speed_mm_s ({speeds[0]:g}, {speeds[1]:g}). "
            "Give it a new number for each"
        )
    if len(speeds) and speeds[0] < 0:
        raise InputError(f"{path}: plate_speed_mm_s = {speeds[0]:g}: must be >= 0")
    speed = float(speeds[0]) if len(speeds) else None
    seen = Track(particle, position[rows], None if heading is None else heading[rows], speed)
    return seen.spread(samples.astype(np.int64))
