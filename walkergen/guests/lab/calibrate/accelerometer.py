"""Accelerometer recordings on the plate, as exported by phone apps: times and three axes.

Columns are recognised by their names: phyphox ("Time (s)", "Acceleration x (m/s^2)", "Linear Acceleration x (m/s^2)"),
Physics Toolbox (time, ax or gFx), Sensor Logger (seconds_elapsed, x), and any others with these names. Gyroscope
columns (phyphox "Gyroscope x (rad/s)", Physics Toolbox wx) are read too.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import columns, safe_text
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY

TIME_PATTERN = re.compile(r"(time|t|seconds[ _]?elapsed|elapsed)[ _]*(\(?(s|ms|us|ns)\)?)?", re.IGNORECASE)
AXIS_PATTERN = re.compile(
    r"(?P<linear>linear[ _]*)?(acceleration|accelerometer|accel|acc|a|gf)?[ _]*(?P<axis>[xyz])[ _]*"
    r"(\(?(?P<unit>m/s\^?2|m/s²|m s-2|g|mm/s\^?2)\)?)?",
    re.IGNORECASE,
)
RATE_PATTERN = re.compile(
    r"(gyroscope|gyro|rotation[ _]*rate|w|omega)[ _]*(?P<axis>[xyz])[ _]*(\(?(?P<unit>rad/s|deg/s|°/s)\)?)?",
    re.IGNORECASE,
)
SECONDS_BY_UNIT = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}

MIN_SAMPLES, MAX_INTERVAL_S = 400, 0.1
"""Smallest number of samples of a recording, and longest interval (s): longer ones suggest a wrong unit of time."""


class Recording(NamedTuple):
    """Recording of an accelerometer."""

    times: Array
    """Times, s, shape (n,), from 0."""
    felt: Array
    """Accelerations along the phone's x, y and z, mm/s^2, shape (n, 3): with gravity upward, or without."""
    linear: bool
    """Whether the app has removed gravity."""
    turned: Array | None = None
    """Rates of turning about the phone's x, y and z, rad/s, shape (n, 3); None: not recorded."""

    @property
    def rate(self) -> float:
        """Samples per second."""
        return 1.0 / float(np.median(np.diff(self.times)))


def read_recording(path: Path) -> Recording:
    """Read the recording in a CSV file. Raises InputError without times or axes, or with too few samples."""
    names = columns.read_header(path)
    time, unit = _find_time_column(names, path)
    axes, linear, scale = _find_axis_columns(names, path)
    rates, radians = _find_rate_columns(names)
    found = columns.read_numbers(path, [time, *axes, *rates])
    times = SECONDS_BY_UNIT[unit] * found.values[time]
    felt = scale * np.column_stack([found.values[axis] for axis in axes])
    order = np.argsort(times, kind="stable")
    order = order[np.append(True, np.diff(times[order]) > 0.0)]  # a repeated sample counts once
    turned = radians * np.column_stack([found.values[name] for name in rates])[order] if rates else None
    recording = Recording(times[order] - times[order[0]], felt[order], linear, turned)
    if len(order) < MIN_SAMPLES:
        raise InputError(f"{path}: {len(order)} samples: must be at least {MIN_SAMPLES}; record for half a minute")
    if 1.0 / recording.rate > MAX_INTERVAL_S:
        raise InputError(
            f"{path}: {time} steps by {1.0 / recording.rate:.3g}: must be seconds, or name its unit, as in 'time (ms)'"
        )
    return recording


def _find_time_column(names: list[str], path: Path) -> tuple[str, str]:
    """Return the name of the column of times, and its unit, such as ms. Elapsed seconds are preferred."""
    found = {name: match for name in names if (match := TIME_PATTERN.fullmatch(name.strip()))}
    if not found:
        raise InputError(f"{path}: no column of times, as 'Time (s)'; columns seen: {_format_names(names)}")
    name = next((name for name in found if "elapsed" in name.lower()), next(iter(found)))
    return name, (found[name][3] or "s").lower()


def _find_axis_columns(names: list[str], path: Path) -> tuple[list[str], bool, float]:
    """Return the columns of x, y and z, whether gravity was removed from them (avoided), and the factor to mm/s^2."""
    found = [(name, match) for name in names if (match := AXIS_PATTERN.fullmatch(name.strip()))]
    for linear in (False, True):
        by_axis = {match["axis"].lower(): (name, match) for name, match in found if bool(match["linear"]) is linear}
        if len(by_axis) == 3:
            chosen = [by_axis[axis] for axis in "xyz"]
            unit = (chosen[0][1]["unit"] or ("g" if "gf" in chosen[0][0].lower() else "m/s^2")).lower()
            scale = GRAVITY if unit == "g" else 1.0 if unit.startswith("mm") else 1e3
            return [name for name, _ in chosen], linear, scale
    raise InputError(
        f"{path}: no three axes of accelerations, as 'Acceleration x (m/s^2)'; columns seen: {_format_names(names)}"
    )


def _find_rate_columns(names: list[str]) -> tuple[list[str], float]:
    """Return the columns of a gyroscope's x, y and z, or none unless all exist, and the factor to rad/s."""
    found = {
        match["axis"].lower(): (name, match["unit"])
        for name in names
        if (match := RATE_PATTERN.fullmatch(name.strip()))
    }
    if len(found) < 3:
        return [], 1.0
    unit = (found["x"][1] or "rad/s").lower()
    return [found[axis][0] for axis in "xyz"], 1.0 if unit == "rad/s" else np.pi / 180.0


def _format_names(names: list[str]) -> str:
    return safe_text.shorten_line(", ".join(names))[:200]
