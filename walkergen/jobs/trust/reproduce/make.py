"""Reproduction of the paper's figures 2, 3, 5, 6 on our geometry, and a verdict on each fact."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.files.report import Report, Table
from walkergen.jobs.trust.published import FACTS
from walkergen.jobs.trust.reproduce import compare, mechanisms, page, plane, report, sweeps, theory
from walkergen.jobs.trust.reproduce.compare import Findings, Theory
from walkergen.jobs.trust.reproduce.sweeps import Assumption, Case, Point
from walkergen.scene import Scene
from walkergen.theory import maximum
from walkergen.theory.speed import MODES
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind

TILTS = (0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 35.0, 45.0)
"""Tilts of the simulated walkers, deg."""

GAMMAS = (1.2, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.2, 2.4)
"""Peak accelerations over g for figure 5."""

TILT_OF_DRIVES = 15.0
"""Tilt of the walkers in figure 5, deg (stated)."""

SECONDS, RUNS, FEWEST_RUNS = 8.0, 8, 8
"""Length (s) and number of each planar ensemble's runs, and least number, since standard errors
come from the spread of independent runs."""

SHORTEST = 0.1
"""Least length of runs, s: those of figure 6 then last for some displacements over 40 ms."""

LABELS = (0.1, 0.2, 0.5)
"""Restitutions in space beside those of the assumptions, to find that of the stated peak."""

TILTS_OF_LABELS = (7.5, 10.0, 12.5, 15.0)
"""Tilts about that peak, deg."""

LOW_RESTITUTION = 0.3
"""Restitution of the foot with which compliant legs have about the experiment's speeds, in their
plane and in space: chosen for that, not measured."""


PICTURES_S, CPU_PER_S = 8.0, 0.025
"""Time of theory and pictures, and CPU time of a simulated second, s, mean of all ensembles."""


class Job(NamedTuple):
    """Walker, contacts, tilts and drives to reproduce with."""

    design: Design
    measured: Scene
    """Scene with the contact as the authors measured it."""
    fitted: Scene
    """Scene with the contact that fitted the experiment best."""
    tilts_deg: Sequence[float] = TILTS
    gammas: Sequence[float] = GAMMAS


def make(job: Job, folder: Path, progress: Progress) -> Report:
    """Write figureN.png, .pdf, .csv as soon as each is made, mechanisms.*, reproduce.md and .csv.

    Equal jobs give equal bytes of every CSV. Ctrl-C keeps the figures already done. Raises
    InputError when the runs or tilts are too few for error bars and peaks.
    """
    check(job)
    assumptions = assumptions_of(job)
    flexible, braced, labelled, driven = _sweeps(job, assumptions)
    on_plane = [job.design.variant(tilt_deg=tilt, kind="flexible") for tilt in plane.TILTS]
    ways = mechanisms.designs(job.design)
    parts = parts_of(_counts(job), progress)
    progress("theory", 0, 1)
    theories = _theories(job, assumptions)
    peaks = [maximum.tilts(job.design.variant(kind="flexible"), mode) for mode in MODES]

    tilts = sweeps.along_tilts(flexible + braced, job.tilts_deg, parts[0])
    findings = Findings(assumptions, theories, peaks, tilts, {}, (), ())
    with Folder(folder, "") as target:
        _write(findings, target, "figure2", "figure3")
        findings = findings._replace(labels=_labels(findings, labelled, parts[1]))
        _write_table(report.labels(findings.labels), target)
        findings = findings._replace(drives=sweeps.along_drives(driven, job.gammas, parts[2]))
        _write(findings, target, "figure5")
        findings = findings._replace(plane=plane.along_tilts(assumptions, on_plane, parts[3]))
        _write(findings, target, "figure6")
        findings = findings._replace(mechanisms=mechanisms.measure(assumptions[0], ways, parts[4]))
        _write(findings, target, "mechanisms")
        rows = compare.rows(findings)
        _write_table(report.compared(rows), target)
        target.write("reproduce.md", page.to_markdown(findings, rows, job.design.name).encode())
    return report.of(findings, rows, page.TITLE, folder)


def expected_s(job: Job) -> float:
    """Wall time of a job on an idle machine with compiled kernels, s, within a factor of two."""
    check(job)
    run = job.measured.run
    simulated_s = sum(_counts(job)) * run.runs * (run.seconds + run.discard_seconds)
    return PICTURES_S + CPU_PER_S * simulated_s / (os.cpu_count() or 1)


def _sweeps(job: Job, assumptions: Sequence[Assumption]) -> tuple[list[Case], list[Case], list[Case], list[Case]]:
    """Cases of flexible and of braced legs along the tilts, of other labels, and along drives."""
    flexible = _cases(job, assumptions, "flexible", ("relaxed", "compliant", "space"))
    braced = _cases(job, assumptions, "braced", ("rigid", "space, braced"))
    driven = [
        case._replace(design=case.design.variant(tilt_deg=TILT_OF_DRIVES))
        for case in flexible + _cases(job, assumptions, "flexible", ("space, noisy plate",))
    ]
    return flexible, braced, _labelled(job, assumptions), driven


def _counts(job: Job) -> list[int]:
    """Numbers of ensembles: along tilts, of other labels, along drives, on a plane, of ways."""
    assumptions = assumptions_of(job)
    flexible, braced, labelled, driven = _sweeps(job, assumptions)
    return [
        len(job.tilts_deg) * len(flexible + braced),
        len(TILTS_OF_LABELS) * len(labelled),
        len(job.gammas) * len(driven),
        len(assumptions) * len(plane.TILTS),
        len(mechanisms.designs(job.design)),
    ]


def parts_of(counts: Sequence[int], progress: Progress) -> list[Progress]:
    """Progress of each of several parts, which have so many ensembles, within the whole."""
    steps = 100 * sum(counts)

    def part(start: int, count: int) -> Progress:
        return lambda what, done, of: progress(what, 100 * start + 100 * count * done // of, steps)

    return [part(sum(counts[:number]), count) for number, count in enumerate(counts)]


def _labelled(job: Job, assumptions: Sequence[Assumption]) -> list[Case]:
    """Cases in space with the measured friction and the restitutions LABELS."""
    measured = assumptions[0].scene
    others = [
        Assumption(
            f"e = {label:g}",
            measured.model_copy(update={"contact": measured.contact.model_copy(update={"restitution": label})}),
        )
        for label in LABELS
    ]
    return _cases(job, others, "flexible", ("space",))


def _labels(findings: Findings, cases: Sequence[Case], progress: Progress) -> dict[float, list[Point]]:
    """Ensembles in space by restitution, those of the assumptions with this friction included."""
    measured = findings.assumptions[0].scene.contact.friction
    by_restitution = {
        assumption.scene.contact.restitution: [
            point for point in findings.tilts if (point.assumption, point.model) == (assumption.name, "space")
        ]
        for assumption in findings.assumptions
        if assumption.scene.contact.friction == measured
    }
    points = sweeps.along_tilts(cases, TILTS_OF_LABELS, progress)
    for case in cases:
        of_case = [point for point in points if point.assumption == case.assumption.name]
        by_restitution.setdefault(case.assumption.scene.contact.restitution, of_case)
    return dict(sorted(by_restitution.items()))


def check(job: Job) -> None:
    """Refuse jobs that could not give error bars, peaks or lines. Raises InputError."""
    for scene in (job.measured, job.fitted):
        if scene.run.runs < FEWEST_RUNS:
            allowed = f"at least {FEWEST_RUNS}, whose spread gives the error bars"
            raise InputError(f"--runs {scene.run.runs}: {allowed}")
        if scene.contact.law != "poisson":
            allowed = "the paper's law is poisson, and so is eq. 15's; use a scene with it"
            raise InputError(f"{scene.name}: contact.law = {scene.contact.law!r}: {allowed}")
        if scene.run.seconds < SHORTEST:
            allowed = f"at least {SHORTEST:g}, for displacements over 40 ms"
            raise InputError(f"--seconds {scene.run.seconds:g}: {allowed}")
    for flag, values, fewest in (("--tilt", job.tilts_deg, 3), ("--gamma", job.gammas, 2)):
        if len(values) < fewest or list(values) != sorted(set(values)) or values[0] < 0.0:
            listed = ",".join(f"{value:g}" for value in values)
            allowed = "none negative, each above the last"
            raise InputError(f"{flag} {listed[:60]}: give {fewest} or more, {allowed}")
    tilts = [*job.tilts_deg, TILT_OF_DRIVES, *plane.TILTS, *TILTS_OF_LABELS]
    job.design.members(tilts, ("flexible", "braced"))
    for case in _cases(job, assumptions_of(job), "flexible", ("space", "space, noisy plate")):
        sweeps.check(case)


def assumptions_of(job: Job) -> list[Assumption]:
    """List the sets of contact numbers: measured, fitted, and a low restitution of the foot."""
    low = {"restitution": LOW_RESTITUTION}
    scene = _as_measured(job.measured)
    lower = scene.model_copy(update={"contact": scene.contact.model_copy(update=low)})
    return [Assumption("measured", scene), Assumption(compare.FITTED, job.fitted), Assumption(compare.LOW, lower)]


def _as_measured(scene: Scene) -> Scene:
    """Scene with the contact that the paper measured, where it gives no other."""
    measured: dict[str, float] = {}
    for name in ("restitution", "friction"):
        fact = FACTS[name]
        measured |= {name: fact.value, f"{name}_sd": fact.high - fact.value}
    contact = scene.contact
    lacking = {key: measured[key] for key in measured.keys() - contact.model_fields_set}
    return scene.model_copy(update={"contact": contact.model_copy(update=lacking)})


def _theories(job: Job, assumptions: Sequence[Assumption]) -> list[Theory]:
    low, high = job.tilts_deg[0], job.tilts_deg[-1]
    flexible = job.design.variant(kind="flexible")

    return [
        Theory(
            assumption.name,
            mode,
            theory.curve(flexible, assumption.scene, mode, low, high),
            assumption.scene.prediction.impact_speed_factor,
            compare.stationary_type_three(flexible, assumption.scene, job.tilts_deg, mode),
        )
        for assumption in assumptions
        for mode in MODES
    ]


def _cases(job: Job, assumptions: Sequence[Assumption], kind: Kind, models: Sequence[str]) -> list[Case]:
    design = job.design.variant(kind=kind)
    return [Case(assumption, model, design) for assumption in assumptions for model in models]


def _write(findings: Findings, target: Folder, *names: str) -> None:
    """Write figures and the tables behind them."""
    from walkergen.files import figures

    for name in names:
        for table in report.TABLES[name](findings):
            _write_table(table, target)
        figure = report.draw(name, findings)
        target.write(f"{name}.png", figures.png(figure))
        target.write(f"{name}.pdf", figures.pdf(figure))


def _write_table(table: Table, target: Folder) -> None:
    target.write(f"{table.name}.csv", table.csv().encode())
