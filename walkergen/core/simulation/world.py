"""World that kernels read by name, and how their motion may end."""

from typing import Any, NamedTuple

from walkergen.core.numerics import Array
from walkergen.core.simulation.drive import Drive
from walkergen.core.simulation.effects.active_effects import Acting

State = Array

OK, TOPPLED, FAILED, FOLDED = range(4)
"""Statuses of `steps.advance`: ran to the end; a corner of the body touched the plate; no progress;
a leg turned by 90 deg against the body."""


class World(NamedTuple):
    """Everything that does not change while a walker moves."""

    walker: Any
    """A `space.state.Walker`."""
    drive: Drive
    acting: Acting
    options: Any
    """Steps: a `space.state.Options`."""
