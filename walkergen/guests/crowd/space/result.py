"""Result of one run of a crowd: every walker's motion, and the losses of its contacts."""

from typing import NamedTuple

from walkergen.core import Array


class Impulses(NamedTuple):
    """Sums of the impulses of contacts between bodies and walls, g mm/s."""

    normal: float
    along: float
    """Sum for friction in the plane."""
    up: float
    """Sum for friction up or down a face, as bodies do not hop in step."""


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
    """x, y (mm), heading (rad), height (mm), pitch and roll (rad), as in the trajectory of one walker, shape (F, N, 6).
    In a periodic square x and y are not wrapped."""
    touches: int
    """Times that two walkers, or a walker and a wall, began to touch."""
    deepest: float
    """Largest depth by which a contact was compressed, mm."""
    energy_error: float
    """Largest unexplained energy of a walker, over the energy it exchanged."""
    contact_error: float
    """Energy lost along the normals of contacts, less the loss expected from restitution, over the expected loss.
    Single impacts err little, jams lose too little, and near restitution 0 bodies touch for long and turn meanwhile."""
    losses: dict[str, float]
    """Energies lost by walkers in contacts, with the energy stored in them: "normal", "friction", g mm^2/s^2."""
    impulses: Impulses
    cpu_s: float
