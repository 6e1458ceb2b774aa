"""Reproduction of the paper: figures 2, 3 and 5 on our geometry, and a verdict on each fact."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from walkergen import prediction
from walkergen.errors import InputError
from walkergen.files import output
from walkergen.files.progress import Progress
from walkergen.jobs.paper import compare, sweeps
from walkergen.jobs.paper import page as supplement
from walkergen.jobs.paper import tables as comparison
from walkergen.jobs.paper.compare import Findings, Row, Theory
from walkergen.jobs.paper.sweeps import Assumption, Case
from walkergen.scene import Scene
from walkergen.simulation.effects.effect import ModelName
from walkergen.theory.speed import MODES
from walkergen.walker.design import Design, Kind

TILTS = (0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 35.0, 45.0)
"""Tilts of the simulated walkers, deg."""

GAMMAS = (1.2, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.2, 2.4)
"""Peak accelerations over g for figure 5."""

TILT_OF_DRIVES = 15.0
"""Tilt of the walkers in figure 5, deg (stated)."""

SECONDS, RUNS, FEWEST_RUNS = 8.0, 8, 8
"""Length (s) and number of each ensemble's runs, and least number, since standard errors come from
the spread of independent runs."""

LOW_RESTITUTION = 0.3
"""Restitution of the foot with which the compliant walker in its plane has the experiment's speeds:
chosen for that, not measured."""


class Job(NamedTuple):
    """Walker, contacts, tilts and drives to reproduce with."""

    design: Design
    measured: Scene
    """Scene with the contact as the authors measured it."""
    fitted: Scene
    """Scene with the contact that fitted the experiment best."""
    tilts_deg: Sequence[float] = TILTS
    gammas: Sequence[float] = GAMMAS


def make(job: Job, folder: Path, progress: Progress) -> tuple[Findings, list[Row]]:
    """Write figureN.png, .pdf, .csv as soon as each is made, then reproduce.md and reproduce.csv.

    Equal jobs give equal bytes of every CSV. Ctrl-C keeps the figures already done. Raises
    InputError when the runs or tilts are too few for error bars and peaks.
    """
    check(job)
    assumptions = assumptions_of(job)
    flexible = _cases(job, assumptions, "flexible", ("relaxed", "compliant"))
    braced = _cases(job, assumptions, "braced", ("rigid",))
    ahead = len(flexible) * len(job.tilts_deg), len(braced) * len(job.tilts_deg)
    behind = len(flexible) * len(job.gammas)
    steps = 100 * (sum(ahead) + behind)
    progress("theory", 0, steps)
    theories = _theories(job, assumptions)
    peaks = [compare.peak_range(job.design.variant(kind="flexible"), mode) for mode in MODES]

    def told(start: int, count: int) -> Progress:
        return lambda what, done, of: progress(what, 100 * start + 100 * count * done // of, steps)

    tilts = sweeps.along_tilts(flexible, job.tilts_deg, told(0, ahead[0]))
    tilts += sweeps.along_tilts(braced, job.tilts_deg, told(ahead[0], ahead[1]))
    found = Findings(assumptions, theories, peaks, tilts, ())
    _write_figures(found, job, folder, (2, 3))
    upright = [
        case._replace(design=case.design.variant(tilt_deg=TILT_OF_DRIVES)) for case in flexible
    ]
    drives = sweeps.along_drives(upright, job.gammas, told(sum(ahead), behind))
    found = found._replace(drives=drives)
    _write_figures(found, job, folder, (5,))
    rows = compare.rows(found)
    output.write(folder / "reproduce.csv", comparison.rows_to_csv(rows).encode())
    page = supplement.to_markdown(found, rows, job.design.name)
    output.write(folder / "reproduce.md", page.encode())
    return found, rows


def check(job: Job) -> None:
    """Refuse jobs that could not give error bars, peaks or lines. Raises InputError."""
    for scene in (job.measured, job.fitted):
        if scene.run.runs < FEWEST_RUNS:
            told = f"at least {FEWEST_RUNS}, whose spread gives the error bars"
            raise InputError(f"--runs {scene.run.runs}: {told}")
        if scene.contact.law != "poisson":
            told = "the paper's law is poisson, and so is eq. 15's; use a scene with it"
            raise InputError(f"{scene.name}: contact.law = {scene.contact.law!r}: {told}")
    for flag, values, fewest in (("--tilt", job.tilts_deg, 3), ("--gamma", job.gammas, 2)):
        if len(values) < fewest or list(values) != sorted(set(values)) or values[0] < 0.0:
            seen = ",".join(f"{value:g}" for value in values)
            told = "none negative, each above the last"
            raise InputError(f"{flag} {seen[:60]}: give {fewest} or more, {told}")
    job.design.members([*job.tilts_deg, TILT_OF_DRIVES], ("flexible", "braced"))


def assumptions_of(job: Job) -> list[Assumption]:
    """List the sets of contact numbers: measured, fitted, and a low restitution of the foot."""
    low = {"restitution": LOW_RESTITUTION}
    scene = job.measured
    lower = scene.model_copy(update={"contact": scene.contact.model_copy(update=low)})
    return [
        Assumption("measured", scene),
        Assumption(compare.FITTED, job.fitted),
        Assumption("low restitution", lower),
    ]


def _theories(job: Job, assumptions: Sequence[Assumption]) -> list[Theory]:
    low, high = job.tilts_deg[0], job.tilts_deg[-1]
    flexible = job.design.variant(kind="flexible")
    return [
        Theory(
            one.name,
            mode,
            prediction.curve(flexible, one.scene, mode, low, high),
            one.scene.prediction.impact_speed_factor,
            compare.stationary_type_three(flexible, one.scene, job.tilts_deg, mode),
        )
        for one in assumptions
        for mode in MODES
    ]


def _cases(
    job: Job, assumptions: Sequence[Assumption], kind: Kind, models: Sequence[ModelName]
) -> list[Case]:
    design = job.design.variant(kind=kind)
    return [Case(one, model, design) for one in assumptions for model in models]


def _write_figures(found: Findings, job: Job, folder: Path, numbers: Sequence[int]) -> None:
    from walkergen.files import figures as pictures
    from walkergen.jobs.paper import figures as reproduced

    tables = {2: comparison.speeds_to_csv, 3: comparison.types_to_csv, 5: comparison.speeds_to_csv}
    for number in numbers:
        points = found.drives if number == 5 else found.tilts
        figure = reproduced.FIGURES[number](found)
        output.write(folder / f"figure{number}.csv", tables[number](points).encode())
        output.write(folder / f"figure{number}.png", pictures.png(figure))
        output.write(folder / f"figure{number}.pdf", pictures.pdf(figure))
    if 2 in numbers:
        theory = comparison.theory_to_csv(found.theories)
        output.write(folder / "figure2_theory.csv", theory.encode())
