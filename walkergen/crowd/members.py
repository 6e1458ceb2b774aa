"""Walkers of a crowd: how many of which design, as people write it or a packing says; its runs."""

from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files import columns
from walkergen.scene import Scene

DEFAULT = 10
"""Walkers of a crowd unless something says how many."""

FEWEST, MOST = 2, 100_000

RUNS, RATE_HZ = 4, 25.0
"""Independent runs of a crowd, and frames a second of them, unless asked otherwise."""


class Share(NamedTuple):
    """So many walkers of one design."""

    name: str
    """Template, or path of a file."""
    walkers: int


def parse(text: str) -> int | list[Share]:
    """Number of walkers as in "30", or designs as in "polar-disc:20,rotator:10". InputError."""
    told = f"--count {text[:60]!r}"
    if (whole := columns.whole(text, MOST)) is not None:
        return check(whole, told)
    shares = []
    for part in text.split(","):
        name, colon, number = part.strip().rpartition(":")
        count = columns.whole(number, MOST)
        if not colon:
            raise InputError(
                f"{told}: must be a whole number in {FEWEST}..{MOST}, or designs with their "
                "numbers, as in polar-disc:20,rotator:10"
            )
        if not name or count is None:
            raise InputError(f"{told}: {part[:40]!r} must be DESIGN:N, N in 1..{MOST}")
        shares.append(Share(name, count))
    names = [share.name for share in shares]
    if len(set(names)) < len(names):
        raise InputError(f"{told}: names a design twice; add its numbers up")
    check(sum(share.walkers for share in shares), told)
    return shares


def check(count: int, told: str) -> int:
    """Return a number of walkers. Raises InputError for less than a crowd, or too many."""
    if not FEWEST <= count <= MOST:
        alone = "; `walkergen simulate` is about one" if count == 1 else ""
        raise InputError(f"{told}: a crowd has {FEWEST} to {MOST} walkers{alone}")
    return count


def number_of(scene: Scene, area_mm2: float) -> int:
    """Number of walkers of an outline of this area that a scene asks for. Raises InputError."""
    crowd, dish = scene.crowd, scene.crowd.dish
    if crowd.packing is None:
        count = DEFAULT if crowd.count is None else crowd.count
        return check(count, f"crowd.count = {count}")
    count = round(crowd.packing * dish.area / area_mm2)
    told = f"crowd.packing = {crowd.packing:g}: {count} walkers of {area_mm2:.4g} mm²"
    return check(count, f"{told} in {dish.words}")
