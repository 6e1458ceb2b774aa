"""What is to be said of a tracked film: facts, notes and warnings."""

from typing import Any, NamedTuple

from walkergen.track.film.marked import Marked
from walkergen.track.film.unmarked import Unmarked


class Told(NamedTuple):
    """What is to be said of a film beside its tracks."""

    found: Unmarked | Marked
    """What the tracks rest on."""
    facts: dict[str, Any]
    """For JSON and the manifest, with units in the names."""
    notes: list[str]
    """What was looked for, in words, and the scale with its error."""
    warnings: list[str]
    """What went wrong, each with its size or its number of frames."""
