"""What the readings of a calibration plate tell."""

from typing import NamedTuple

from walkergen.analysis.inverse import Branch, Curve, Inverse
from walkergen.lab.calibrate.contact import Rebound, Value
from walkergen.lab.calibrate.modulus import Density, Fit, Point, Systematic
from walkergen.scene import Scene
from walkergen.walker.design import Design


class Bent(NamedTuple):
    """What strips tell."""

    fit: Fit
    points: list[Point]
    density: Density
    by: str
    """Method that counts, of specimens.METHODS."""
    ring_over_bend: Systematic | None
    offset: Systematic | None


class Bounced(NamedTuple):
    """What a dropped walker tells."""

    rebound: Rebound
    curve: Curve
    """From the restitution of the feet to the rebound, drops from the hand."""
    inverse: Inverse
    text: str

    @property
    def single(self) -> Branch | None:
        """The one range of restitutions that agrees, or None."""
        inverse = self.inverse
        return None if inverse.everywhere or len(inverse.branches) != 1 else inverse.branches[0]


class Calibrated(NamedTuple):
    """Everything that the readings tell."""

    bent: Bent | None
    density: Value | None
    friction: Value | None
    damping: Value | None
    bounced: Bounced | None
    notes: list[str]
    settings: dict[str, float]
    """Keys of design and scene (these begin with scene.) with their values."""
    design: Design
    scene: Scene
