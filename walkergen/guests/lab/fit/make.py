"""Fit: from measured speeds to the contact that predicts, simulates or describes them."""

from pathlib import Path

from walkergen.core.files.progress import Expect, Progress, ignore_estimate
from walkergen.guests.lab.fit import model_fit, report, theory
from walkergen.guests.lab.fit.job import Job, with_default_prior
from walkergen.guests.lab.fit.report import FitReport
from walkergen.guests.lab.report import write_report


def fit(path: Path, job: Job, folder: Path, progress: Progress, expect: Expect = ignore_estimate) -> FitReport:
    """Fit a model to a CSV file of speeds, and write what follows into a folder.

    Files: tables, page and figure of the report, scene.toml, design.toml (of the theory as it was
    given) and a manifest. See `learn.learn` and `theory.fit`. Raises InputError, before anything is
    written, for unusable input and for choices that do not go together.
    """
    job = with_default_prior(job)
    choices = {"file": path.name, "fixed": job.held}
    if job.model == "theory":
        fitted, word = report.make_theory_report(theory.fit(path, job, progress), job, path, folder), "Fitted to"
        choices["mode"] = job.mode
    else:
        fitted, word = (
            report.make_model_report(model_fit.learn(path, job, progress, expect), job, path, folder),
            "Learnt from",
        )
        choices |= {"model": job.model, "prior": job.prior}
    return write_report(fitted, job, choices, f"{word} {path.name}: {job.caption}", every=True)
