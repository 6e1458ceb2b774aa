"""Number of walkers of each design in a crowd, from a count or a packing."""

from collections.abc import Mapping
from typing import Any

from walkergen.core import InputError, Scene, parse_count

DEFAULT_COUNT = 10
"""Default number of walkers in a crowd."""

MAX_WALKERS = 100_000

DEFAULT_RUNS = 4
"""Default number of independent runs of a crowd."""


def parse_walker_count(value: int | str | Mapping[str, int]) -> int | dict[str, int]:
    """Parse a number of walkers, or numbers by designs: 30, "30", {"rotator": 10} or "polar-disc:20,rotator:10".

    Raises ValueError for any other form, and InputError for a total below 1 or too large.
    """
    whole = parse_count(value, MAX_WALKERS) if isinstance(value, str) else value
    if isinstance(whole, int) and not isinstance(whole, bool):
        return check_count(whole, f"‹count=›{whole}")
    pairs: list[tuple[str, Any]] = []
    if isinstance(value, Mapping):
        pairs = [(str(name), count) for name, count in value.items()]
    elif isinstance(value, str) and ":" in value:
        for part in value.split(","):
            name, _, number = part.strip().rpartition(":")
            pairs.append((name, parse_count(number, MAX_WALKERS)))
    for name, count in pairs:
        if not name or isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAX_WALKERS:
            raise ValueError(f"write DESIGN:N for {name[:40]!r}, with a whole number N in 1..{MAX_WALKERS}")
    if not pairs:
        raise ValueError(
            f"must be a whole number in 1..{MAX_WALKERS}, or designs with their numbers, as in polar-disc:20,rotator:10"
        )
    counts = dict(pairs)
    if len(counts) < len(pairs):
        raise ValueError("names a design twice. Add its numbers.")
    check_count(sum(counts.values()), f"‹count=›{','.join(f'{name}:{count}' for name, count in pairs)[:60]}")
    return counts


def check_count(count: int, source: str) -> int:
    """Return `count`. Raises InputError if it is below 1 or too large; `source` begins the message."""
    if not 1 <= count <= MAX_WALKERS:
        change = "Raise" if count < 1 else "Lower"
        raise InputError(f"{source}: the crowd must have 1 to {MAX_WALKERS} walkers. {change} this value.")
    return count


def walker_count(scene: Scene, area_mm2: float) -> int:
    """Return the number of walkers, of this area each, that a scene sets by count or packing. Raises InputError."""
    crowd, dish = scene.crowd, scene.crowd.dish
    if crowd.packing is None:
        count = DEFAULT_COUNT if crowd.count is None else crowd.count
        return check_count(count, f"crowd.count = {count}")
    count = round(crowd.packing * dish.area / area_mm2)
    source = f"crowd.packing = {crowd.packing:g}: gives {count} walkers of {area_mm2:.4g} mm²"
    return check_count(count, f"{source} in {dish.words}")
