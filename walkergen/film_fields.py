"""Fields of requests that read a film, or its tracks: rate, scale, axes and units."""

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator

from walkergen.core.files import formatting
from walkergen.field_values import split_values
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.analysis.track_files import Units

SIGN = re.compile(r"±|\+/?-")
"""Sign before an error."""

Measured = tuple[float, float | None] | None
"""Number with its standard error, if known."""


def parse_measured(entry: Any) -> Measured:
    """Return a number above 0 and its standard error, None if not given, from 0.05, "0.05±0.001" or "0.05+-0.001"."""
    if entry is None:
        return None
    value, *errors = map(formatting.parse_number, SIGN.split(str(entry)))
    error = errors[0] if errors else 0.0
    if value is None or value <= 0 or len(errors) > 1 or error is None or not 0 <= error < value:
        raise ValueError(
            "must be a number above 0, such as 0.05. Add a standard error below the number with ±: "
            "0.05±0.001 or 0.05+-0.001"
        )
    return value, error if errors else None


def parse_tracks(value: Any) -> Any:
    """Return one or several file names or patterns such as `*.npz` as a list of paths; other values are unchanged."""
    many = isinstance(value, (list, tuple)) and bool(value) and isinstance(value[0], (str, os.PathLike))
    return parse_paths(value) if many or isinstance(value, (str, os.PathLike)) else value


def parse_paths(value: Any) -> list[Path]:
    """Return one or several file names, or patterns of them, as a list of paths. Raises ValueError for other values."""
    paths = split_values(value) if not isinstance(value, (str, os.PathLike)) else [value]
    if not all(isinstance(path, (str, os.PathLike)) for path in paths):
        raise ValueError("must be names of files")
    return [path for text in paths for path in _expand_pattern(Path(text))]


def _expand_pattern(path: Path) -> list[Path]:
    """Return the files that match a pattern, which not every shell expands; the path itself if it has none."""
    if not re.search(r"[*?\[]", str(path)) or path.exists():
        return [path]
    return sorted(Path(path.anchor).glob(str(path.relative_to(path.anchor)))) or [path]


Fps = Annotated[float | None, Flag("Frames per second of the film.", "N")]
YDown = Annotated[bool, Flag("Let y grow downward, as image rows do.")]
MmPerPx = Annotated[
    Measured,
    BeforeValidator(parse_measured),
    Flag("Millimetres per pixel of the film, as 0.05±0.001.", "MM", takes="float | str | None"),
]
Unit = Annotated[
    str | None,
    Flag("Units of positions, times and headings, if the file does not state them: mm, or cm,ms,deg.", "UNIT"),
]


def units(fps: float | None, mm_per_px: Measured, y_down: bool, unit: str | None, lane: bool = False) -> "Units":
    """Return the units of a film's tracks, from the fields above. `lane`: True if walkers run in a lane."""
    from walkergen.analysis.track_files import Units

    scale, error = mm_per_px or (None, None)
    return Units(fps, scale, y_down, lane, error, unit or "")
