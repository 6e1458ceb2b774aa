"""Words and impacts of a film: titles, pace, impacts of a run."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.theory.impact import Kind

Array = npt.NDArray[np.float64]


class Impact(NamedTuple):
    """Impact of a foot on the plate."""

    time: float
    """Time since the first pose, s."""
    foot: int
    """Number of the corner that hits the plate."""
    impulse: Array
    """Impulse on the foot, shape (2,), g mm/s."""
    kind: Kind


def impact_of(event: Array) -> Impact:
    """Impact of a row of the simulation's events (see `record.Events`)."""
    time, foot, along, upward, _, _, kind = event
    return Impact(time, int(foot), np.array((along, upward)), Kind(int(kind)))


class Title(NamedTuple):
    """Words by which a picture tells its walker from others."""

    design: str
    tilt: str
    """Tilt of its legs with its unit."""
    kind: str

    @property
    def legs(self) -> str:
        """Tilt and kind of its legs."""
        return f"{self.tilt} {self.kind}"

    def __str__(self) -> str:
        return f"{self.design}, {self.tilt}, {self.kind}"


def pace(slow: float) -> str:
    """Pace of a movie in words; `slow` seconds of it show one second of the run."""
    if slow == 1.0:
        return "real time"
    return f"{slow:.3g} times slower" if slow > 1.0 else f"{1.0 / slow:.3g} times faster"
