"""Prediction of walkers of one design: masses, speeds with bounds, and their report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Expect, Progress, ignore_estimate, silent
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.theory.prediction import Prediction
from walkergen.core.theory.speed import Mode
from walkergen.core.theory.surrogate import UnknownError
from walkergen.core.theory.uncertain_inputs import Share
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.files.report import Report
from walkergen.points import members, speed_table
from walkergen.points.members import Member
from walkergen.points.speed_prediction import Model

if TYPE_CHECKING:
    from walkergen.core.walker.weighed_masses import Weighings


@dataclass(frozen=True, kw_only=True, repr=False)
class PredictReport(Report):
    """Predicted speeds of walkers in a scene. For several walkers, single numbers are the first one's."""

    scene: Scene
    members: Sequence[Member]

    @property
    def design(self) -> Design:
        """Walker that was predicted."""
        return self.members[0].design

    @property
    def mass(self) -> MassProperties:
        """Mass properties of the first walker, from which its speed was computed."""
        return self.members[0].mass

    @property
    def row(self) -> Prediction:
        """Prediction of the first walker; its `columns()` are those of the table."""
        return self.members[0].row

    @property
    def speed(self) -> Quantity:
        """Median speed in mm/s; its `se` is the standard deviation of its distribution."""
        return self.row.speed


def make_report(
    design: Design,
    scene: Scene,
    mode: str,
    walkers: Sequence[Member],
    shares: Sequence[Sequence[Share]] = (),
    why: bool = True,
) -> PredictReport:
    """Make the report of predicted walkers.

    Parameters
    ----------
    design, scene, mode : Design, Scene, str
        Design and scene of the walkers, and mode of the theory.
    walkers : sequence of Member
        Predicted walkers.
    shares : sequence of sequence of Share
        Shares of the variance of each walker's speed by uncertain input; empty without them.
    why : bool
        True to print the sources of the speeds.
    """
    with_notes = why or speed_table.needs_notes(walkers, scene)
    tables = speed_table.tables("prediction", design.name, walkers, with_notes)
    rows = list(tables[0])
    for row, member, walker_shares in zip(rows, walkers, shares, strict=False):
        title = f"{member.name}: shares of the variance of the speed"
        tables.append(speed_table.shares_table(f"shares of {member.name}", walker_shares, title))
        row["shares"] = list(tables[-1])
    return PredictReport(
        name="predict",
        title=design.name,
        tables=tables,
        facts={"rows": rows},
        headline=speed_table.headline(design.name, walkers),
        caption=speed_table.caption(design, scene, mode) if why else "",
        lines=speed_table.note_lines(walkers, with_notes),
        scene=scene,
        members=walkers,
    )


def predict(
    design: Design,
    walkers: Sequence[Design],
    scene: Scene,
    mode: Mode,
    weighed: "Mapping[str, Weighings]" = MappingProxyType({}),
    uncertain: bool = False,
    model: Model = "best",
    why: bool = False,
    progress: Progress = silent,
    united: bool = True,
    expect: Expect = ignore_estimate,
) -> PredictReport:
    """Predict walkers of a design, and return their report.

    Parameters
    ----------
    design, walkers, scene, mode
        Design, its variants to predict, scene, and mode of the theory.
    weighed : mapping
        Masses from a balance, by names of walkers.
    uncertain : bool
        True to compute each uncertain input's share of the variance of the speed.
    model : str
        Source of speeds: best, known or theory.
    why : bool
        True to print the sources of the speeds.
    progress : Progress
        Callback for progress.
    united : bool
        Whether body and legs are united to one mesh, which only printing needs.

    Raises
    ------
    InputError
        If a weighed mass is impossible.
    TheoryError
        If the mode of the theory does not fit the scene's contact law.
    """
    built = [solids.build(walker, united=united) for walker in walkers]
    predicted = list(members.predict_members(walkers, built, scene, mode, weighed, model, progress, expect))
    shares = [_shares(member, scene) for member in (predicted if uncertain else ())]
    return make_report(design, scene, mode, predicted, shares, why)


def _shares(member: Member, scene: Scene) -> tuple[Share, ...]:
    """Return each uncertain input's share of the variance of a walker's speed; () if the speed is unknown.

    Raises InputError if the walker was simulated.
    """
    if member.row.speed.value is None:
        return ()
    try:
        return prediction.variance_shares(member.design, member.mass, scene)
    except UnknownError as reason:
        raise InputError(
            f"‹uncertain›: {member.name}: {reason}. Run `simulate` with ‹uncertain› for this walker."
        ) from None
