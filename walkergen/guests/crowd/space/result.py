"""Result of one run of a crowd: every walker's motion, and the losses of its contacts."""

from typing import NamedTuple

from walkergen.core import Array


class Impulses(NamedTuple):
    """Sums of the impulses of contacts between bodies and walls, g mm/s."""

    normal: float
    along: float
    """Of friction in the plane."""
    up: float
    """Of friction up or down a face: bodies hop out of step."""


class CrowdRun(NamedTuple):
    """One run of N walkers, F frames at a fixed rate after the discarded start."""

    number: int
    outcomes: tuple[str, ...]
    """Outcome of each walker: values of `run.Outcome`."""
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
    """Largest unexplained energy of a walker, over the energy it exchanged."""
    contact_error: float
    """What contacts took along their normals, less what restitution says, over it: that of a blow
    is small, in jams restitution comes out higher than it should; near restitution 0 bodies hold on
    to each other for long, and turn meanwhile."""
    losses: dict[str, float]
    """Energies lost by walkers in contacts, with the energy stored in them: "normal", "friction", g mm^2/s^2."""
    impulses: Impulses
    cpu_s: float
