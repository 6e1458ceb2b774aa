"""Fit: from measured speeds to the contact by which they are predicted, simulated or described."""

from pathlib import Path

from walkergen.files.progress import Progress
from walkergen.lab.fit import learn, report, theory
from walkergen.lab.fit.report import FitReport
from walkergen.lab.fit.request import Request, checked
from walkergen.lab.report import written


def fit(path: Path, request: Request, folder: Path, progress: Progress) -> FitReport:
    """Fit a model to a CSV file of speeds, and write what follows into a folder.

    Files: tables, page and figure of the report, scene.toml, design.toml (of the theory as it was
    given) and a manifest. See `learn.learn` and `theory.fit`. Raises InputError, before anything is
    written, for unusable input and for choices that do not go together.
    """
    request = checked(request)
    choices = {"file": path.name, "fixed": request.held}
    if request.model == "theory":
        told, word = report.of_theory(theory.fit(path, request, progress), request, path, folder), "Fitted to"
        choices["mode"] = request.mode
    else:
        told, word = report.of_model(learn.learn(path, request, progress), request, path, folder), "Learnt from"
        choices |= {"model": request.model, "prior": request.prior}
    return written(told, request, choices, f"{word} {path.name}: {request.caption}", every=True)
