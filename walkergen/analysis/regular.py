"""Films of variable rate: places between their frames, at the regular times of statistics."""

import numpy as np
import numpy.typing as npt

from walkergen.files.columns import Columns

Array = npt.NDArray[np.float64]

LONGEST = 3.0
"""Longest time between neighbouring frames, over the usual one, within which a walker is followed:
a camera that slows down halves its rate or so; beyond, frames are missing."""


def at_regular_times(table: Columns, time: str, heading: str) -> tuple[Columns, str]:
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
