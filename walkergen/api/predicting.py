"""Predicted speeds, as the command `predict` makes them."""

from collections.abc import Iterable, Iterator
from typing import overload

from walkergen.analysis.speed import Speed, speed_of
from walkergen.api.loading import Ground, Walker, members_of, scene_of
from walkergen.api.table import Result, Table, table_of
from walkergen.errors import InputError
from walkergen.jobs.family import make as families
from walkergen.scene import Scene
from walkergen.theory.prediction import Prediction
from walkergen.theory.speed import MODES, Mode
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind
from walkergen.walker.mass import MassProperties

SCENE = "lane-90hz"
"""Template of the scene by default, as on the command line."""


class Predicted(Result):
    """Predicted speed of one walker, and the masses that it follows from."""

    def __init__(self, scene: Scene, member: families.Member) -> None:
        self.scene = scene
        self.design: Design = member.design
        self.mass: MassProperties = member.mass
        self.row: Prediction = member.row
        """Row of the family's table, with units in its names."""

    @property
    def speed(self) -> Speed:
        """Median speed in mm/s; its `se` is the standard deviation of its distribution."""
        row = self.row
        return speed_of(
            row.speed_mm_s, row.speed_sd_mm_s, row.speed_low_95_mm_s, row.speed_high_95_mm_s
        )

    @property
    def table(self) -> Table:
        """Row of the prediction, with units in the names of the columns."""
        return table_of([self.row])

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words."""
        yield "walker", _named(self.design)
        yield "scene", self.scene.name
        yield "predicted speed", str(self.speed)
        yield "mass", f"{float(self.mass.total):.3f} g"
        if self.row.note:
            yield "note", self.row.note


@overload
def predict(
    design: Walker, scene: Ground = SCENE, tilt: float | None = None, *,
    legs: Kind | None = None, mode: Mode = "coulomb",
) -> Predicted: ...  # fmt: skip
@overload
def predict(
    design: Walker, scene: Ground = SCENE, *, tilt: Iterable[float],
    legs: Kind | Iterable[Kind] | None = None, mode: Mode = "coulomb",
) -> Table: ...  # fmt: skip


def predict(
    design: Walker, scene: Ground = SCENE, tilt: float | Iterable[float] | None = None, *,
    legs: Kind | Iterable[Kind] | None = None, mode: Mode = "coulomb",
) -> Predicted | Table:  # fmt: skip
    """Predict the speed of a walker or, of several tilts (deg), a table with a row each.

    Raises InputError for what cannot be built, TheoryError where mode and law do not go together.
    """
    if mode not in MODES:
        raise InputError(f"mode={mode!r}: must be one of {', '.join(map(repr, MODES))}")
    several = isinstance(tilt, Iterable)
    tilts = tilt if isinstance(tilt, Iterable) else None if tilt is None else [tilt]
    ground, members = scene_of(scene), members_of(design, tilts, legs, whole=False)
    built = [solids.build(member) for member in members]
    made = list(families.predicted(members, built, ground, mode))
    if not several and len(made) == 1:
        return Predicted(ground, made[0])
    told = families.caption(members[0], ground, mode) if made else ""
    return table_of([one.row for one in made], members[0].name if made else "", [told])


def _named(design: Design) -> str:
    return f"{design.name}, {design.kind} legs, tilt {design.tilt_deg:g} deg"
