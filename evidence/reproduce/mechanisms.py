"""The three ways to run that the paper names, side by side: flexible legs, materials, lengths.

Rigid walkers come from templates, and are simulated as flexible ones are, by MODEL.
"""

from collections.abc import Sequence
from typing import NamedTuple

from evidence.quantities import ratio
from evidence.reproduce.runs import Point
from evidence.reproduce.theory import theory_speeds
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.theory import uncertain_inputs
from walkergen.core.theory.prediction import DRAW_COUNT, SEED, impact_speed
from walkergen.core.theory.stationary import stationary_speed
from walkergen.core.theory.uncertain_inputs import PREDICTION_READER
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

MODEL = "space"
"""Series of `runs.NOISE_RATIOS` that simulates all three."""

FLEXIBLE_TILT_DEG = 10.0
"""Tilt of the flexible legs, deg: that of the paper's peak."""

RIGID_MECHANISMS = {"two-materials": "feet of two materials", "unequal-legs": "rigid legs of unequal length"}
"""Mechanisms of rigid walkers, by template."""

DIRECTIONS = {Verdict.AGREE: "same", Verdict.DISAGREE: "opposite"}


class Mechanism(NamedTuple):
    """One way to run: its walker, with the theory's speed and the simulated one."""

    what: str
    design: Design
    theory: Quantity
    """Speed from the theory, mm/s, and its standard deviation from uncertain inputs."""
    used: str
    """What the theory balanced."""
    simulated: Point

    @property
    def ratio(self) -> Quantity:
        """Simulated speed over the theory's, with the error of the simulation."""
        if not self.theory.value:
            return Quantity("ratio", "", None, refused="the theory has no speed")
        return ratio(self.simulated.speed, self.theory._replace(se=0.0))

    @property
    def direction(self) -> str:
        """Direction of the simulated walker against the theory's: undecided where its bounds hold zero."""
        return DIRECTIONS.get(self.ratio.compare_with_range(0.0, float("inf")), "undecided")


def load_designs(paper: Design) -> list[tuple[str, Design]]:
    """Mechanisms and their walkers: flexible legs as the paper's, then those of OTHERS."""
    tilted = paper.variant(tilt_deg=FLEXIBLE_TILT_DEG, kind="flexible")
    others = [(what, templates.load(name, "walkers", Design)) for name, what in RIGID_MECHANISMS.items()]
    return [("tilted flexible legs", tilted), *others]


def compare_mechanisms(ways: Sequence[tuple[str, Design]], points: Sequence[Point]) -> list[Mechanism]:
    """Compare every mechanism's theory with its simulation."""
    return [_compare_mechanism(what, design, point) for (what, design), point in zip(ways, points, strict=True)]


def _compare_mechanism(what: str, design: Design, point: Point) -> Mechanism:
    assumption = point.assumption
    mass, inputs = solids.mass_of(design), uncertain_inputs.inputs(assumption.scene, design, PREDICTION_READER)
    contact, values = assumption.scene.contact, uncertain_inputs.sample_inputs(inputs, DRAW_COUNT, SEED)
    foot_speeds = stationary_speed(design, mass, contact.restitution, contact.friction)
    drawn = theory_speeds(design, mass, assumption.scene, "coulomb", uncertain_inputs.label_columns(inputs, values))
    used = "mean of both feet" if design.is_symmetric_pair else "balance of both feet"
    speed = float(foot_speeds.factor) * impact_speed(assumption.scene, mass)
    return Mechanism(what, design, Quantity("theory", "mm_s", speed, float(drawn.std())), used, point)
