"""Values of fields: read from the text of a command line, or taken from Python and checked.

Parsers raise ValueError with the rule that a value breaks. The request adds the name of its field.
"""

import errno
import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from walkergen.core.errors import InputError
from walkergen.core.files import assignments, file_reading, formatting

MAX_TILT_DEG, MAX_TILTS, MAX_BUDGET_S = 85, 10_000, 86_400.0
"""Largest tilt (deg), most tilts of a request, longest budget of time (s)."""


RANGE_PATTERN = re.compile(r"\s*([0-9]+\.?[0-9]*)\s*(?:-|\.\.|–)\s*([0-9]+\.?[0-9]*)\s*")
"""Range as people write it, which is not the form of a command."""


def read_number(text: Any) -> Any:
    """Return the number in a text. Return any other value unchanged, for a request to refuse it with the range."""
    for read in (int, float) if isinstance(text, str) else ():
        try:
            return read(text)
        except ValueError:
            continue
    return text


def parse_number(text: object) -> float:
    """Return a number, parsed if it is text."""
    value = formatting.parse_number(text) if isinstance(text, str) else text
    if value is None or isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{str(text)[:30]!r} is not a finite number")
    return float(value) + 0.0


def parse_tilt(text: object) -> float:
    """Return a tilt in degrees, parsed if it is text."""
    try:
        value = parse_number(text)
    except ValueError:
        value = math.nan
    if not -MAX_TILT_DEG <= value <= MAX_TILT_DEG:
        shown = repr(text[:30]) if isinstance(text, str) else str(text)
        raise ValueError(f"{shown} must be a number in -{MAX_TILT_DEG}..{MAX_TILT_DEG} deg")
    return value


def split_values(value: Any) -> list[Any]:
    """Return the entries of a comma-separated text or of a collection; a single value is a list of one."""
    if isinstance(value, str):
        return [word.strip() for word in value.split(",")]
    try:
        return list(value)
    except TypeError:  # a single value, or an array of no dimension
        return [value]


def parse_tilts(value: Any) -> list[float] | None:
    """Return tilts in degrees. Text is 10, or 5,10,15, or FIRST:LAST:STEP with both ends."""
    if value is None:
        return None
    tilts: list[float] = []
    for piece in split_values(value):
        if advice := suggest_range(piece):
            raise ValueError(f"{piece!r} is not a number. {advice}")
        numbers = [parse_tilt(word) for word in (piece.split(":") if isinstance(piece, str) else [piece])]
        if len(numbers) not in (1, 3):
            raise ValueError("write one tilt (10), a list (5,10,15) or FIRST:LAST:STEP (0:40:5), in degrees")
        tilts += numbers if len(numbers) == 1 else _tilt_range(*numbers)
    unique = list(dict.fromkeys(tilts))
    if len(unique) > MAX_TILTS:
        raise ValueError(f"{len(unique)} tilts. At most {MAX_TILTS} are allowed.")
    return unique


def suggest_range(text: Any) -> str:
    """Return advice on a text such as 5-15, which is meant as a range; "" for any other value."""
    ends = RANGE_PATTERN.fullmatch(text) if isinstance(text, str) else None
    if ends is None or float(ends[1]) >= float(ends[2]):
        return ""
    step = 0.5 * 10.0 ** math.floor(math.log10(float(ends[2]) - float(ends[1])))
    return f"Write {ends[1]}:{ends[2]}:{step:g} for a range in steps of {step:g}."


def _tilt_range(first: float, last: float, step: float) -> list[float]:
    """Return tilts from first to last in steps, deg. Raises ValueError for a step of the wrong sign or size."""
    if step == 0 or (last - first) / step < 0:
        raise ValueError(f"step {step:g} does not lead from first to last. Write FIRST:LAST:STEP (0:40:5).")
    count = (last - first) / step
    if count > MAX_TILTS:
        raise ValueError(f"more than {MAX_TILTS} tilts. Choose a larger step.")
    # Rounded to what people write, so that 0:1:0.1 gives 0.3 and not 0.30000000000000004.
    return [round(first + index * step, 9) + 0.0 for index in range(int(count + 1e-9) + 1)]


def parse_kinds(value: Any) -> list[Any] | None:
    """Return kinds of legs from comma-separated text or a list, without repetition; None for None."""
    return None if value is None else list(dict.fromkeys(split_values(value)))


def parse_settings(value: Any) -> dict[str, Any]:
    """Return values by key from texts KEY=VALUE or a mapping. Raises InputError for a key with two values."""
    if isinstance(value, Mapping):
        return dict(value)
    settings: dict[str, Any] = {}
    for text in parse_texts(value):
        key, word = assignments.split_key_value(text)
        new = assignments.parse_value(word, key)
        if key in settings and repr(settings[key]) != repr(new):
            raise InputError(f"‹set› {key[:60]}: given twice. Remove one of them.", key)
        settings[key] = new
    return settings


def parse_texts(value: Any) -> list[str]:
    """Return one or several texts as a list. Raises ValueError for other values."""
    texts = [value] if isinstance(value, str) else split_values(() if value is None else value)
    if not all(isinstance(text, str) for text in texts):
        raise ValueError("must be texts KEY=VALUE, or a dict of values by keys")
    return texts


def parse_time(value: Any) -> float | None:
    """Return a time in seconds. Text has a unit: 60s, 5min, 5m or 1h."""
    units = {"min": 60.0, "m": 60.0, "s": 1.0, "h": 3600.0}
    seconds = value
    if isinstance(value, str):
        unit = next((unit for unit in units if value.endswith(unit)), "")
        number = formatting.parse_number(value.removesuffix(unit))
        if not unit or number is None:
            raise ValueError("write a time with its unit: 60s, 5min, 1h")
        seconds = number * units[unit]
    if seconds is not None and not 1.0 <= parse_number(seconds) <= MAX_BUDGET_S:
        raise ValueError(f"must be a time in 1s..{MAX_BUDGET_S / 3600:g}h")
    return None if seconds is None else float(seconds)


def parse_effects(value: Any) -> float | None:
    """Return a share of the speed, 0.01 for text "auto:1%"; other values are returned unchanged."""
    if not isinstance(value, str):
        return value  # type: ignore[no-any-return]
    share = formatting.parse_number(value.removeprefix("auto:").removesuffix("%"))
    if share is None or not (value.startswith("auto:") and value.endswith("%")) or not 1e-4 <= share <= 100.0:
        raise ValueError("must be a share of the speed in 0.0001..100 %. Write auto:1%.")
    return 0.01 * share


def parse_path(value: Any) -> Path | None:
    """Convert text to a Path; other values are returned unchanged."""
    return Path(value) if isinstance(value, (str, os.PathLike)) else value


def parse_target(value: Any) -> Path | None:
    """Return a path to write to. Raises ValueError for an unsafe name, OutputError for a folder without access."""
    path = parse_path(value)
    if isinstance(path, Path):
        if not file_reading.has_safe_name(path):
            raise ValueError("contains control characters. Choose another name.")
        _check_writable(path)
    return path


def _check_writable(path: Path) -> None:
    """Raise OutputError if no file or folder can be created at a path."""
    from walkergen.core.files import output

    existing = next((each for each in (path, *path.parents) if os.path.lexists(each)), path)
    reason = 0 if existing.is_dir() or existing == path else errno.ENOTDIR
    if existing.is_dir() and not os.access(existing, os.W_OK | os.X_OK):
        reason = errno.EACCES
    if reason:
        raise output.write_error(path, OSError(reason, os.strerror(reason)))
