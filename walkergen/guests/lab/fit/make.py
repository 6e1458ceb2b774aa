"""Fit a model (surrogate, simulation or theory) to measured speeds, and write the results."""

from pathlib import Path
from typing import Any

from walkergen.core.files.progress import Expect, Progress, ignore_estimate
from walkergen.guests.lab.fit import held_parameters, model_fit, report, theory
from walkergen.guests.lab.fit.fields import FitFields
from walkergen.guests.lab.fit.parameters import DEFAULT_PRIOR
from walkergen.guests.lab.fit.report import FitReport
from walkergen.guests.lab.report import Setup, write_report


def fit(
    request: FitFields, setup: Setup, folder: Path, progress: Progress, expect: Expect = ignore_estimate
) -> FitReport:
    """Fit a model to a file of speeds, write the results into a folder, and return the report.

    Files: tables, page and figure of the report, scene.toml, design.toml (unchanged by the theory) and a manifest. See
    `model_fit.fit` and `theory.fit`. Raises InputError, before anything is written, for unusable input and for choices
    that exclude each other.
    """
    path, held = request.speeds, held_parameters.parse_held(request)
    assumptions = held_parameters.describe_assumptions(request, setup.design.name, held)
    choices: dict[str, Any] = {"file": path.name, "fixed": held}
    if request.model == "theory":
        described = theory.fit(request, setup, held, progress)
        made = report.make_theory_report(described, setup, f"fitted with {assumptions}", path, folder)
        word = "Fitted to"
        choices["mode"] = request.mode
    else:
        fitted = model_fit.fit(request, setup, held, progress, expect)
        made = report.make_model_report(fitted, f"fitted with {assumptions}", path, folder)
        word = "Fitted to"
        choices |= {"model": request.model, "prior": request.prior or DEFAULT_PRIOR}
    comment = f"{word} {path.name}: {assumptions}"
    return write_report(made, setup, choices, request.pictures, comment, all_keys=True)
