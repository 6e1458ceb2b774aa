"""What a person asks of a fit, checked, and the fit that it names: as command and notebook ask."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.lab.fit import fixed, learn, make, parameters, report
from walkergen.lab.fit.report import FitReport
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


def fit(path: Path, request: Request, folder: Path, progress: Progress) -> FitReport:
    """Fit a model to a CSV file of speeds, and write what follows into a folder.

    Files: tables, page and figure of the report, scene.toml, design.toml (of the theory as it was
    given) and a manifest. See `learn.learn` and `make.fit`. Raises InputError, before anything is
    written, for unusable input and for choices that do not go together.
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
        theory_job = make.Job(design, scene, mode, fixed.of_theory(fix), pictures)
        caption = make.caption(theory_job)
        results = report.of_theory(make.fit(path, theory_job, progress), path, caption, folder)
        comment = f"Fitted to {path.name}: {caption}"
        return _written(results, request, path, comment, {"mode": mode, "fixed": dict(theory_job.fixed)})
    if mode != "coulomb":
        raise InputError(f"--mode {mode!r}: a mode of the theory; --model {model} has none")
    if model != "prediction":
        scene = scene.variant(**{"legs.model": model})
    prior = parameters.PRIORS[0] if prior is None else prior
    if prior not in parameters.PRIORS:
        priors = ", ".join(parameters.PRIORS)
        raise InputError(f"--prior {str(prior)[:30]!r}: must be one of {priors}")
    held = fixed.of_model(fix, model)
    job = learn.Job(design, scene, model, prior, held, ahead, pictures)
    caption = learn.caption(job)
    results = report.of_model(learn.learn(path, job, progress), path, caption, folder)
    choices = {"model": model, "prior": prior, "fixed": dict(held)}
    written = request._replace(scene=scene)
    return _written(results, written, path, f"Learnt from {path.name}: {caption}", choices)


def _written(fitted: FitReport, request: Request, path: Path, comment: str, choices: Mapping[str, Any]) -> FitReport:
    """Report, once it is written with the scene and design that go on."""
    assert fitted.folder is not None
    with Folder(fitted.folder) as target:
        fitted.write(target, request.pictures)
        target.write("scene.toml", templates.dump(fitted.scene, comment).encode())
        target.write("design.toml", templates.dump(fitted.design, comment).encode())
        target.finish(
            {
                "file": path.name,
                "design": request.design.model_dump(mode="json"),
                "scene": request.scene.model_dump(mode="json"),
                **choices,
            }
        )
    return fitted
