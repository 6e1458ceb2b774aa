"""Folder of a crowd: tables, page, figures, a snapshot, tracks of every run, a movie."""

from pathlib import Path
from typing import Any

from walkergen.crowd import files as crowd_files
from walkergen.crowd import movie as crowd_movie
from walkergen.crowd.job import plane
from walkergen.crowd.job.report import CrowdReport, caption_of, title_of
from walkergen.crowd.runs import Job
from walkergen.files.output import Folder, versions
from walkergen.files.progress import Progress
from walkergen.files.report import Report

MOST_ROWS = 2_000_000
"""Walkers times frames of a run up to which its tracks are written, some 100 bytes each."""


def write(report: CrowdReport, folder: Path, pictures: bool, progress: Progress) -> CrowdReport:
    """Write everything into a folder. Raises OutputError where a file there is not ours."""
    simulated = report.simulated
    with Folder(folder) as target:
        report.write(target, pictures)
        if pictures:
            target.write("crowd.png", crowd_movie.still(simulated.films[0], report.title))
        for number, film in enumerate(simulated.films):
            if film.x.size > MOST_ROWS:
                continue
            for suffix in crowd_files.writable():
                progress("writing tracks", 99, 100)
                target.write(f"tracks/run-{number}{suffix}", crowd_files.FORMATS[suffix](film))
        target.finish(facts(simulated.job))
    return report


def write_inputs(job: Job, folder: Path) -> Report:
    """Write the input of LAMMPS for every run into a folder, and say what is there."""
    inputs = plane.inputs(job)
    with Folder(folder) as target:
        for name, data in inputs.items():
            target.write(name, data)
        target.finish(facts(job))
    lines = ["in each of its folders: `lmp -in crowd.in`"]
    return Report(
        name="inputs",
        title=title_of(job),
        tables=[],
        lines=lines,
        folder=folder,
        caption=caption_of(job),
        facts={"files": sorted(inputs)},
    )


def facts(job: Job) -> dict[str, Any]:
    """What a manifest says of a crowd: every input resolved."""
    designs = [kind.design for kind in job.kinds if kind.design]
    return {
        "model": job.model,
        "scene": job.scene.model_dump(mode="json"),
        "designs": [design.model_dump(mode="json") for design in designs],
        "bodies_sha256": [design.body.shape.sha256 for design in designs],
        "cards": [kind.card.model_dump(mode="json") for kind in job.kinds if kind.card],
        "counts": [kind.walkers for kind in job.kinds],
        "rate_hz": job.rate_hz,
        "versions": versions(),
    }


def name_of(job: Job) -> str:
    """Name of a crowd's folder, after its walkers and the dish."""
    who = "-".join(kind.name for kind in job.kinds)
    count = sum(kind.walkers for kind in job.kinds)
    dish = job.scene.crowd.dish.words.replace(":", "-").replace(",", "-")
    return f"crowd-{who}-{count}-{dish}"[:100]
