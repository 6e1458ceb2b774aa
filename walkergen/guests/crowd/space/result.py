"""Result of one run of a crowd: where every walker was, and what its contacts took."""

from typing import NamedTuple

from walkergen.core.numerics import Array


class Impulses(NamedTuple):
    """Sums of what contacts between bodies and walls gave, g mm/s."""

    normal: float
    along: float
    """Of friction in the plane."""
    up: float
    """Of friction up or down a face: bodies hop out of step."""


class CrowdRun(NamedTuple):
    """One run of N walkers, F frames at a fixed rate after the discarded start."""

    number: int
    outcomes: tuple[str, ...]
    """How it ended for each walker: values of `run.Outcome`."""
    kinds: tuple[str, ...]
    """Name of each walker's design, length N."""
    times: Array
    """Times since the record began, s, shape (F,)."""
    poses: Array
    """Places x, y (mm), heading, height (mm), pitch and roll (rad) as a trajectory of one walker
    shows them, shape (F, N, 6); in a periodic square x and y are not wrapped."""
    touches: int
    """Times that two walkers, or a walker and a wall, began to touch."""
    deepest: float
    """Deepest give of a contact, mm."""
    energy_error: float
    """Largest energy of a walker that nothing accounts for, over what it exchanged."""
    contact_error: float
    """What contacts took along their normals, less what restitution says, over it: that of a blow
    is small, in jams restitution comes out higher than it should; near restitution 0 bodies hold on
    to each other for long, and turn meanwhile."""
    losses: dict[str, float]
    """Energies that contacts took from walkers, with what they hold: "normal", "friction", g mm^2/s^2."""
    impulses: Impulses
    cpu_s: float
