"""Predicted speeds, as the command `predict` makes them."""

from collections.abc import Iterable

from walkergen.api.loading import Ground, Walker, members_of, scene_of, walker_of
from walkergen.errors import InputError
from walkergen.jobs.run.predict import make
from walkergen.jobs.run.predict.report import PredictReport
from walkergen.theory.speed import MODES, Mode
from walkergen.walker.limbs import Kind

SCENE = "lane-90hz"
"""Template of the scene by default, as on the command line."""


def predict(
    design: Walker,
    scene: Ground = SCENE,
    tilt: float | Iterable[float] | None = None,
    *,
    legs: Kind | Iterable[Kind] | None = None,
    mode: Mode = "coulomb",
    uncertain: bool = False,
) -> PredictReport:
    """Predict the speed of a walker or, of several tilts (deg) or kinds of legs, a row each.

    If `uncertain`, the report says what the bounds are made of. Raises InputError for what cannot
    be built, TheoryError where mode and law do not go together.
    """
    if mode not in MODES:
        raise InputError(f"mode={mode!r}: must be one of {', '.join(map(repr, MODES))}")
    tilts = tilt if isinstance(tilt, Iterable) else None if tilt is None else [tilt]
    ground, chosen = scene_of(scene), walker_of(design)
    members = members_of(chosen, tilts, legs, whole=False)
    return make.predict(chosen, members, ground, mode, uncertain=uncertain)
