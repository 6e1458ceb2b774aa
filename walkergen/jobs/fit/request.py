"""What a person asks of a fit, checked, and the fit that it names: as command and notebook ask."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.fit import fixed, learn, make, parameters
from walkergen.jobs.fit.learn import Learned
from walkergen.jobs.fit.make import Fitted
from walkergen.scene import Scene
from walkergen.theory.speed import MODES
from walkergen.walker.design import Design

MODELS = ("prediction", "theory", "compliant", "space")


class Request(NamedTuple):
    """Choices of a fit, as people write them."""

    design: Design
    scene: Scene
    model: Any = "prediction"
    """One of MODELS."""
    fix: Sequence[str] = ()
    """Parameters to hold, NAME=VALUE."""
    prior: Any = None
    """One of `parameters.PRIORS`; None is the first."""
    ahead: Sequence[float] | None = None
    """Tilts to predict, deg; None for those of the design's family."""
    mode: Any = "coulomb"
    """Mode of the theory."""
    pictures: bool = True


def fit(path: Path, request: Request, folder: Path, progress: Progress) -> Fitted | Learned:
    """Fit a model to a CSV file of speeds and write what follows.

    See `learn.learn` and `make.fit`. Raises InputError for choices that do not go together.
    """
    design, scene, model, fix, prior, ahead, mode, pictures = request
    if model not in MODELS:
        raise InputError(f"--model {str(model)[:30]!r}: must be one of {', '.join(MODELS)}")
    if mode not in MODES:
        raise InputError(f"--mode {str(mode)[:30]!r}: must be one of {', '.join(MODES)}")
    if model == "theory":
        if (prior, ahead) != (None, None):
            name = "--predict" if prior is None else "--prior"
            raise InputError(f"{name}: the theory has none; leave out --model theory")
        given = make.Job(design, scene, mode, fixed.of_theory(fix), pictures)
        return make.fit(path, given, folder, progress)
    if mode != "coulomb":
        raise InputError(f"--mode {mode!r}: a mode of the theory; --model {model} has none")
    if model != "prediction":
        scene = scene.variant(**{"legs.model": model})
    prior = parameters.PRIORS[0] if prior is None else prior
    if prior not in parameters.PRIORS:
        known = ", ".join(parameters.PRIORS)
        raise InputError(f"--prior {str(prior)[:30]!r}: must be one of {known}")
    held = fixed.of_model(fix, model)
    job = learn.Job(design, scene, model, prior, held, ahead, pictures)
    return learn.learn(path, job, folder, progress)
