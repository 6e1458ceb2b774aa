"""Dish of a crowd: the ground of many walkers, between walls or without an edge.

The middle of the dish is the origin of the plate's plane; x to the right, y up, seen from above.
"""

import math
import re
from typing import NamedTuple

from walkergen.core.errors import InputError

SIZE_SYNTAX = {
    "disc": ("disc:DIAMETER", 1),
    "ring": ("ring:OUTER,INNER", 2),
    "rectangle": ("rectangle:LENGTHxWIDTH", 2),
    "periodic": ("periodic:SIDE", 1),
}
"""Kinds of dishes: the form that users write, mm, and the number of sizes."""

MIN_SIZE_MM, MAX_SIZE_MM = 1.0, 1e5
"""Limits of the sizes of a dish, mm."""

EXAMPLES = "disc:120, ring:160,60, rectangle:200x100 or periodic:150"


class Dish(NamedTuple):
    """Ground of a crowd, lengths in mm."""

    kind: str
    """disc, ring, rectangle, or periodic: a square with opposite edges joined."""
    sizes: tuple[float, ...]
    """Diameters of a disc or ring (outer, inner), length along x and width of a rectangle, side of
    a periodic square."""

    @property
    def area(self) -> float:
        """Area between the walls, or of the periodic square, mm^2."""
        if self.kind == "disc":
            return 0.25 * math.pi * self.sizes[0] ** 2
        if self.kind == "ring":
            return 0.25 * math.pi * (self.sizes[0] ** 2 - self.sizes[1] ** 2)
        return self.sizes[0] * self.sizes[-1]

    @property
    def box(self) -> tuple[float, float]:
        """Length and width of the smallest rectangle around the dish, mm."""
        return self.sizes[0], self.sizes[1] if self.kind == "rectangle" else self.sizes[0]

    @property
    def period(self) -> float:
        """Side after which a periodic square repeats; 0 for a dish with walls."""
        return self.sizes[0] if self.kind == "periodic" else 0.0

    @property
    def words(self) -> str:
        """Dish in the form that users write, such as "rectangle:200x100"."""
        mark = "x" if self.kind == "rectangle" else ","
        return f"{self.kind}:{mark.join(f'{size:g}' for size in self.sizes)}"


OPEN_GROUND = Dish("periodic", (MAX_SIZE_MM,))
"""Ground without walls."""


def parse_dish(text: str, source: str = "‹arena›") -> Dish:
    """Parse a dish from a user's text, as in "disc:120". Raises InputError whose text begins with the key `source`."""
    kind, _, rest = text.partition(":")
    given = f"{source.replace('›', '=›')}{text[:80]!r}" if source.startswith("‹") else f"{source} = {text[:80]!r}"
    if kind not in SIZE_SYNTAX:
        raise InputError(f"{given}: must be a kind of dish with sizes in mm, for example {EXAMPLES}")
    form, count = SIZE_SYNTAX[kind]
    words = re.split(r"[,x]", rest)
    try:
        sizes = tuple(float(word) for word in words)
    except ValueError:
        sizes = ()
    if len(sizes) != count:
        raise InputError(f"{given}: must be {form}, mm, as in {EXAMPLES}")
    if not all(MIN_SIZE_MM <= size <= MAX_SIZE_MM for size in sizes):
        raise InputError(f"{given}: its sizes must lie between {MIN_SIZE_MM:g} and {MAX_SIZE_MM:g} mm")
    if kind == "ring" and not sizes[1] < sizes[0]:
        raise InputError(f"{given}: the inner diameter must be below the outer one; exchange them")
    return Dish(kind, sizes)
