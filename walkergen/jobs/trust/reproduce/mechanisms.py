"""The three ways to run that the paper names, side by side: flexible legs, materials, lengths.

Rigid walkers come from templates, and are simulated as flexible ones are, by MODEL.
"""

from collections.abc import Sequence
from typing import NamedTuple

from walkergen.analysis.values import Value
from walkergen.files import templates
from walkergen.files.progress import Progress
from walkergen.jobs.trust.reproduce import sweeps
from walkergen.jobs.trust.reproduce.sweeps import Assumption, Case, Point
from walkergen.theory import uncertain
from walkergen.theory.prediction import DRAWS, SEED, theory_speeds
from walkergen.theory.stationary import stationary
from walkergen.theory.uncertain import PREDICTION
from walkergen.walker import solids
from walkergen.walker.design import Design

MODEL = "space"
"""Series of `sweeps.SERIES` by which all three are simulated."""

TILT = 10.0
"""Tilt of the flexible legs, deg: that of the paper's peak."""

OTHERS = {"two-materials": "feet of two materials", "unequal-legs": "rigid legs of unequal length"}
"""Mechanisms of rigid walkers, by template."""


class Mechanism(NamedTuple):
    """One way to run: its walker, with the theory's speed and the simulated one."""

    name: str
    """Name of the walker's design."""
    what: str
    design: Design
    theory: Value
    """Speed by the theory, mm/s, and its standard deviation by what is not known exactly."""
    used: str
    """What the theory balanced."""
    simulated: Point

    @property
    def ratio(self) -> Value | None:
        """Simulated speed over the theory's, with the error of the simulation."""
        speed = self.simulated.speed
        if speed is None or self.theory.mean == 0.0:
            return None
        return Value(speed.mean / self.theory.mean, speed.se / abs(self.theory.mean))

    @property
    def direction(self) -> str:
        """Verdict on the direction, within two standard errors of the simulated speed."""
        ratio = self.ratio
        if ratio is None or abs(ratio.mean) <= 2.0 * ratio.se:
            return "undecided"
        return "same" if ratio.mean > 0.0 else "opposite"


def designs(paper: Design) -> list[tuple[str, Design]]:
    """Mechanisms and their walkers: flexible legs as the paper's, then those of OTHERS."""
    tilted = paper.variant(tilt_deg=TILT, kind="flexible")
    others = [(what, templates.load(name, "walkers", Design)) for name, what in OTHERS.items()]
    return [("tilted flexible legs", tilted), *others]


def measure(assumption: Assumption, chosen: Sequence[tuple[str, Design]], progress: Progress) -> list[Mechanism]:
    """Predict and simulate every mechanism with the contact of an assumption."""
    points = sweeps.measured([Case(assumption, MODEL, design) for _, design in chosen], progress)
    return [_beside(what, design, assumption, point) for (what, design), point in zip(chosen, points, strict=True)]


def _beside(what: str, design: Design, assumption: Assumption, point: Point) -> Mechanism:
    mass, inputs = solids.mass_of(design), uncertain.inputs(assumption.scene, design, PREDICTION)
    contact, values = assumption.scene.contact, uncertain.draws(inputs, DRAWS, SEED)
    foot_speeds = stationary(design, mass, contact.restitution, contact.friction, law=contact.law)
    drawn = theory_speeds(design, mass, assumption.scene, "coulomb", uncertain.named(inputs, values))
    used = "mean of both feet" if design.alike else "balance of both feet"
    theory = Value(float(foot_speeds.factor) * assumption.scene.impact_speed, float(drawn.std()))
    return Mechanism(design.name, what, design, theory, used, point)
