"""Prediction of walkers of one design: built, weighed, and their speeds with bounds."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from walkergen.jobs.run.predict import report
from walkergen.jobs.run.predict.report import PredictReport
from walkergen.points import members
from walkergen.scene import Scene
from walkergen.theory import prediction
from walkergen.theory.speed import Mode
from walkergen.walker import solids
from walkergen.walker.design import Design

if TYPE_CHECKING:
    from walkergen.walker.weights import Weighings


def predict(
    design: Design,
    walkers: Sequence[Design],
    scene: Scene,
    mode: Mode,
    weighed: "Mapping[str, Weighings]" = MappingProxyType({}),
    uncertain: bool = False,
) -> PredictReport:
    """Predict walkers of a design; if `uncertain`, with what their bounds are made of.

    `weighed` are masses from a balance by the walkers' names. Raises InputError for impossible
    masses, TheoryError where mode and law do not go together.
    """
    built = [solids.build(walker) for walker in walkers]
    predicted = list(members.predicted(walkers, built, scene, mode, weighed))
    shares = [prediction.shares(one.design, one.mass, scene, mode) for one in (predicted if uncertain else ())]
    return report.of(design, scene, mode, predicted, shares)
