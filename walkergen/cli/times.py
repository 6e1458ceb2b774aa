"""Times as people write them on a command line."""

from walkergen.errors import InputError
from walkergen.files import words

MOST_BUDGET = 86_400.0
"""Longest time that a budget may have, s."""


def parse_time(text: str) -> float:
    """Convert "60s", "5min", "5m" or "1h" into seconds. Raises InputError outside 1 s to 24 h."""
    units = {"min": 60.0, "m": 60.0, "s": 1.0, "h": 3600.0}
    unit = next((unit for unit in units if text.endswith(unit)), "")
    value = words.value(text.removesuffix(unit))
    if not unit or value is None:
        raise InputError(f"--budget {text[:30]!r}: write a time with its unit: 60s, 5min, 1h")
    seconds = value * units[unit]
    if not 1.0 <= seconds <= MOST_BUDGET:
        raise InputError(f"--budget {text[:30]!r}: must lie in 1s..{MOST_BUDGET / 3600:g}h")
    return seconds
