"""Reproduction of the paper's figures 2, 3, 5, 6 on our geometry, and a verdict on each fact."""

from collections.abc import Mapping, Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

from evidence.reproduce import compare, curves, figures, maximum, mechanisms, motion, page, report, runs, theory
from evidence.reproduce.compare import FITTED, LOW_RESTITUTION, Findings
from evidence.reproduce.runs import Assumption, Case, Point
from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder, versions
from walkergen.core.files.progress import Progress, range_progress
from walkergen.core.scene import Scene
from walkergen.core.theory.speed import MODES
from walkergen.core.walker.design import Design
from walkergen.files import figures as pictures
from walkergen.files import templates
from walkergen.files.report import Report
from walkergen.request import PAPER_WALKER

SCENES = "lane-90hz", "lane-90hz-fitted"
"""Scenes with the contact as measured, and as fitted."""

DRIVES_TILT_DEG = 15.0
"""Tilt of the walkers in figure 5, deg (stated)."""

SECONDS, RUNS, MIN_RUNS = 8.0, 8, 8
"""Length (s) and number of the runs of an ensemble of the paper's model, and least number, since standard errors come
from the spread of independent runs."""

MIN_SECONDS = 0.1
"""Least length of runs, s: those of figure 6 then last for some displacements over 40 ms."""

LOW_RESTITUTION_VALUE = 0.3
"""Restitution of the foot of the third contact: chosen, not measured."""


class Job(NamedTuple):
    """Walker, contacts, tilts and drives to reproduce with."""

    design: Design
    measured: Scene
    """Scene with the contact as the authors measured it."""
    fitted: Scene
    """Scene with the contact that fitted the experiment best."""
    tilts_deg: Sequence[float] | None = None
    """Tilts; None for those of the sweep figure2."""
    gammas: Sequence[float] | None = None
    """Peak accelerations over g; None for those of the sweep figure5."""


class Parts(NamedTuple):
    """Simulations of a job: ensembles that keep their impacts, and walkers of figure 6."""

    assumptions: list[Assumption]
    cases: dict[str, list[Case]]
    plane: list[Design]


def make_job(tilts_deg: Sequence[float] | None, gammas: Sequence[float] | None, run: Mapping[str, Any]) -> Job:
    """Job with the paper's walker and scenes, and other values of some keys of their runs. Raises InputError."""
    changes = {f"run.{key}": value for key, value in {"seconds": SECONDS, "runs": RUNS, **run}.items()}
    measured, fitted = (templates.load(name, "scenes", Scene).variant(**changes) for name in SCENES)
    return Job(templates.load(PAPER_WALKER, "walkers", Design), measured, fitted, tilts_deg, gammas)


def reproduce(job: Job, folder: Path, progress: Progress) -> Report:
    """Write figureN.png, .pdf, .csv as soon as each is made, mechanisms.*, reproduce.md and .csv.

    Equal jobs give equal bytes of every CSV. Ctrl-C keeps the figures already done. Raises
    InputError when the runs or tilts are too few for error bars and peaks.
    """
    parts, ways = check_job(job), mechanisms.load_designs(job.design)
    counts = {name: len(cases) for name, cases in parts.cases.items()}
    shares = _share_progress(counts | {"figure6": len(parts.assumptions) * len(parts.plane)}, progress)
    progress("theory", 0, 1)
    tilts_deg = job.tilts_deg or runs.sweep_values("figure2")[0]
    theories = [theory.predict_curve(job.design, own, mode, tilts_deg) for own in parts.assumptions for mode in MODES]
    peaks = [maximum.find_tilts(job.design.variant(kind="flexible"), mode) for mode in MODES]

    def points(name: str) -> list[Point]:
        return list(runs.simulate_cases(parts.cases[name], shares[name]))

    with Folder(folder) as target:
        target.claim()
        found = Findings(parts.assumptions, theories, peaks, points("figure2"))
        _write_part(found, target, "figure2")
        found = found._replace(
            restitutions=curves.group_by_restitution([*found.tilts, *points("figure2-restitutions")])
        )
        _write_part(found, target, "figure2-restitutions")
        found = found._replace(drives=points("figure5"))
        _write_part(found, target, "figure5")
        found = found._replace(plane=motion.simulate_plane(parts.assumptions, parts.plane, shares["figure6"]))
        _write_part(found, target, "figure6")
        found = found._replace(mechanisms=mechanisms.compare_mechanisms(ways, points("mechanisms")))
        _write_part(found, target, "mechanisms")
        result = report.make_report(found, compare.compare_facts(found), folder)
        target.write("reproduce.csv", result["reproduce"].csv().encode())
        target.write("reproduce.md", page.to_markdown(result, found).encode())
        scenes = {"measured": job.measured, "fitted": job.fitted}
        facts = {name: each.model_dump(mode="json") for name, each in {"design": job.design, **scenes}.items()}
        target.finish({**facts, "tilts_deg": job.tilts_deg, "gammas": job.gammas, "versions": versions()})
    return result


def make_parts(job: Job, tilts_deg: Sequence[float], gammas: Sequence[float]) -> Parts:
    """Collect the simulations of a job at these tilts and drives, with the values of the shipped sweeps."""
    assumptions = make_assumptions(job)
    flexible, braced = job.design.variant(kind="flexible"), job.design.variant(kind="braced")
    of_flexible = _make_cases(assumptions, flexible, runs.PAPER_MODEL, "space")
    tilted = of_flexible + _make_cases(assumptions, braced, "space, braced")
    driven = [*of_flexible, *_make_cases(assumptions, flexible, "space, noisy plate")]
    restitutions, tilts_of_restitutions = runs.sweep_values("figure2-restitutions")
    varied = [_vary_contact(f"e = {e:g}", assumptions[0].scene, {"restitution": e}) for e in restitutions]
    in_space = _make_cases(varied, flexible, "space")
    ways = [Case(assumptions[0], mechanisms.MODEL, design) for _, design in mechanisms.load_designs(job.design)]
    cases = {
        "figure2": [_tilt_case(case, tilt) for case in tilted for tilt in tilts_deg],
        "figure2-restitutions": [_tilt_case(case, tilt) for case in in_space for tilt in tilts_of_restitutions],
        "figure5": [_tilt_case(case, DRIVES_TILT_DEG)._replace(gamma=gamma) for case in driven for gamma in gammas],
        "mechanisms": ways,
    }
    return Parts(assumptions, cases, [flexible.variant(tilt_deg=tilt) for tilt in runs.sweep_values("figure6")[0]])


def _make_cases(assumptions: Sequence[Assumption], design: Design, *models: str) -> list[Case]:
    return [Case(assumption, model, design) for assumption in assumptions for model in models]


def _tilt_case(case: Case, tilt_deg: float) -> Case:
    return case._replace(design=case.design.variant(tilt_deg=tilt_deg))


def _share_progress(counts: Mapping[str, int], progress: Progress) -> dict[str, Progress]:
    """Progress of each of several parts, which have so many ensembles, within the whole."""
    share = 1.0 / sum(counts.values())
    ends = zip(counts.items(), accumulate(counts.values()), strict=True)
    return {name: range_progress(progress, share * (end - count), share * end) for (name, count), end in ends}


def check_job(job: Job) -> Parts:
    """Return the simulations of a job. Raises InputError if they cannot give error bars, peaks or lines."""
    tilts_deg = runs.sweep_values("figure2")[0] if job.tilts_deg is None else job.tilts_deg
    gammas = runs.sweep_values("figure5")[0] if job.gammas is None else job.gammas
    for scene in (job.measured, job.fitted):
        if scene.run.runs < MIN_RUNS:
            raise InputError(f"--runs {scene.run.runs}: must be at least {MIN_RUNS}. Their spread gives errors.")
        if scene.run.seconds < MIN_SECONDS:
            allowed = f"must be at least {MIN_SECONDS:g}, for displacements over 40 ms"
            raise InputError(f"--seconds {scene.run.seconds:g}: {allowed}")
    for flag, values, fewest in (("--tilt", tilts_deg, 3), ("--gamma", gammas, 2)):
        if len(values) < fewest or list(values) != sorted(set(values)) or values[0] < 0.0:
            listed = ",".join(f"{value:g}" for value in values)
            raise InputError(f"{flag} {listed[:60]}: must be at least {fewest} values >= 0 in rising order")
    job.design.members([*tilts_deg, DRIVES_TILT_DEG], ("flexible", "braced"))
    return make_parts(job, tilts_deg, gammas)


def make_assumptions(job: Job) -> list[Assumption]:
    """List the sets of contact numbers: measured, fitted, and a low restitution of the foot."""
    low = _vary_contact(LOW_RESTITUTION, job.measured, {"restitution": LOW_RESTITUTION_VALUE})
    return [Assumption("measured", job.measured), Assumption(FITTED, job.fitted), low]


def _vary_contact(name: str, scene: Scene, contact: Mapping[str, float]) -> Assumption:
    """Assumption of other numbers of the contact."""
    return Assumption(name, scene.model_copy(update={"contact": scene.contact.model_copy(update=contact)}))


def _write_part(found: Findings, target: Folder, name: str) -> None:
    """Write the tables of a part, and its figure."""
    for table in report.TABLES[name](found):
        target.write(f"{table.name}.csv", table.csv().encode())
    if name in figures.FIGURES:
        figure = figures.FIGURES[name](found)
        target.write(f"{name}.png", pictures.png(figure))
        target.write(f"{name}.pdf", pictures.pdf(figure))
