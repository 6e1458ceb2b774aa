"""Prediction of walkers of one design: built, weighed, and their speeds with bounds."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from walkergen.commands.predict import report
from walkergen.commands.predict.report import PredictReport
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress, silent
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.theory.speed import Mode
from walkergen.core.theory.surrogate import UnknownError
from walkergen.core.theory.uncertain_inputs import Share
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import members
from walkergen.points.members import Member
from walkergen.points.speed_prediction import Model

if TYPE_CHECKING:
    from walkergen.core.walker.weighed_masses import Weighings


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
) -> PredictReport:
    """Predict walkers of a design; if `uncertain`, with the sources of their bounds, if `why` with reasons.

    `weighed` are masses from a balance by the walkers' names. `united` meshes are needed only for printing.
    Raises InputError for impossible masses, TheoryError for incompatible mode and law.
    """
    built = [solids.build(walker, united=united) for walker in walkers]
    predicted = list(members.predict_members(walkers, built, scene, mode, weighed, model, progress))
    shares = [_shares(member, scene) for member in (predicted if uncertain else ())]
    return report.make_report(design, scene, mode, predicted, shares, why)


def _shares(member: Member, scene: Scene) -> tuple[Share, ...]:
    """Return the shares of a walker's bounds; none without bounds. Raises InputError if it was simulated."""
    if member.row.speed.value is None:
        return ()
    try:
        return prediction.variance_shares(member.design, member.mass, scene)
    except UnknownError as reason:
        raise InputError(
            f"‹uncertain›: {member.name}: {reason}: `simulate --uncertain` tells of such walkers"
        ) from None
