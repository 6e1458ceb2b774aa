"""Report of a crowd, and its folder: numbers with errors, contact losses, figures, tracks of every run."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.core import ENERGY_TOLERANCE, Folder, Outcome, Progress, format_number, versions
from walkergen.files import report
from walkergen.files.report import Report, Table, format_next_step
from walkergen.guests.crowd import figures as crowd_figures
from walkergen.guests.crowd import files as tracks
from walkergen.guests.crowd import in_plane, tables
from walkergen.guests.crowd.population import GOOD_OUTCOMES, Population, Simulated
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.space.result import CrowdRun
from walkergen.guests.crowd.statistics import CrowdStatistics

MAX_ROWS = 2_000_000
"""Largest number of walkers times frames in a run whose tracks are written, some 100 bytes each."""


@dataclass(frozen=True, kw_only=True, repr=False)
class CrowdReport(Report):
    """Report of a crowd: its statistics with errors from independent runs."""

    simulated: Simulated
    """Runs and films that the numbers describe."""

    @property
    def statistics(self) -> CrowdStatistics:
        """Numbers, their course in time, and curves."""
        return self.simulated.statistics


class Contacts(NamedTuple):
    """Contacts of one run; the field names are the columns of runs.csv."""

    run: int
    touches: int
    """Times that bodies, or a body and a wall, began to touch."""
    touches_per_walker_s: float
    deepest_um: float
    """Largest depth by which a contact was compressed."""
    lost_normal_nj: float
    """Energy lost along the normals of contacts."""
    lost_friction_nj: float
    energy_error: float
    contact_error: float
    """Relative excess of the contacts' normal losses over those from restitution."""
    fallen: int
    """Number of walkers that did not reach the end of the run."""


CONTACT_COLUMNS = (
    report.text_column("run", "run"),
    report.number_column("touches", "touches"),
    report.number_column("per walker and s", "touches_per_walker_s", 3),
    report.number_column("deepest (µm)", "deepest_um", 2),
    report.number_column("lost to impact (nJ)", "lost_normal_nj", 3, wide=True),
    report.number_column("to friction (nJ)", "lost_friction_nj", 3, wide=True),
    report.number_column("energy error", "energy_error", 2),
    report.number_column("excess loss", "contact_error", 2),
    report.text_column("fallen", "fallen"),
)


def make_report(simulated: Simulated, folder: Path | None = None) -> CrowdReport:
    """Make the report of a crowd. `folder`: where its files will be written; None for no files."""
    population, statistics = simulated.population, simulated.statistics
    title = crowd_title(population)
    rows = [_contact_row(run, statistics.seconds) for run in simulated.runs]
    contacts = Table("contacts", rows, Contacts._fields, CONTACT_COLUMNS, "Contacts of bodies and walls")
    return CrowdReport(
        name="report",
        title=title,
        headline=f"{title}: {tables.describe_answer(statistics)}",
        caption=crowd_caption(population),
        tables=[*tables.make_tables(statistics), *([contacts] if rows else [])],
        facts={
            "scene": population.scene.name,
            "model": population.model,
            "kinds": {kind.name: kind.walkers for kind in population.kinds},
            "seed": population.scene.run.seed,
            "asked_runs": population.scene.run.runs,
            "packing": population.packing,
            **tables.facts(statistics),
            "contacts": [row._asdict() for row in rows],
            "outcomes": dict(simulated.outcomes),
        },
        lines=[tables.summary_line(statistics), *([in_plane.TESTED_RANGE] if population.model == "flat" else [])],
        warnings=list(_warnings(simulated)),
        figures=crowd_figures.figure_functions(statistics, title),
        folder=folder,
        simulated=simulated,
    )


def crowd_title(population: Population) -> str:
    """Return a title that names the walkers and their dish."""
    who = " and ".join(f"{kind.walkers} {kind.name}" for kind in population.kinds)
    return f"{who} in {population.scene.crowd.dish.words}"


def crowd_caption(population: Population) -> str:
    """Describe the model, the scene or the cards, and the packing in a line, without a full stop."""
    crowd = population.scene.crowd
    if population.model == "flat":
        cards = " and ".join(f"{kind.name} ({kind.card.scene})" for kind in population.kinds if kind.card)
        return f"model flat, by the cards of {cards}, packing {population.packing:.3g}"
    return (
        f"{population.scene.name}, model space, packing {population.packing:.3g}; bodies meet with restitution "
        f"{crowd.restitution:g} and friction {crowd.friction:g}"
    )


def _contact_row(run: CrowdRun, seconds: float) -> Contacts:
    """Return the row of a run in the table of contacts. `seconds`: length of the run."""
    return Contacts(
        run.number,
        run.touches,
        run.touches / (len(run.kinds) * seconds),
        1e3 * run.deepest,
        run.losses["normal"],
        run.losses["friction"],
        run.energy_error,
        run.contact_error,
        sum(outcome not in GOOD_OUTCOMES for outcome in run.outcomes),
    )


def _warnings(simulated: Simulated) -> Iterator[str]:
    """Yield the reasons to doubt the numbers."""
    if fallen := simulated.fallen:
        outcomes = ", ".join(f"{count} {name}" for name, count in fallen.items())
        yield f"walkers that did not reach the end of their runs: {outcomes}. They stayed where they fell"
    worst = simulated.energy_error
    if worst > ENERGY_TOLERANCE:
        yield (
            f"{Outcome.ENERGY.value}: {format_number(100.0 * worst, 2)} % of the energy exchanged "
            f"is unaccounted for, more than {100.0 * ENERGY_TOLERANCE:g} %"
        )


def write(report: CrowdReport, folder: Path, pictures: bool, progress: Progress) -> CrowdReport:
    """Write page, tables, figures, tracks and manifest into a folder, and return the report.

    Raises
    ------
    OutputError
        For a file that walkergen must not replace.
    """
    steps = 3
    progress("pictures" if pictures else "tables", 0, steps)
    with Folder(folder) as target:
        report.write(target, pictures)
        if pictures:
            from walkergen.guests.crowd import movie  # brings matplotlib

            target.write("crowd.png", movie.render_still(report.simulated.films[0], report.title))
        progress("writing tracks", 2, steps)
        for number, film in enumerate(report.simulated.films):
            if film.x.size > MAX_ROWS:
                continue
            for suffix, to_bytes in tracks.FORMATS.items():
                target.write(f"tracks/run-{number}{suffix}", to_bytes(film))
        target.finish(manifest_inputs(report.simulated.request, report.simulated.population))
    progress("done", steps, steps)
    return replace(report, next_step=format_next_step([folder / "crowd.png"] * pictures))


def write_inputs(request: CrowdRequest, population: Population, folder: Path) -> Report:
    """Write the input of LAMMPS for every run into a folder, and return a report that lists the files."""
    inputs = in_plane.input_files(request, population)
    with Folder(folder) as target:
        for name, data in inputs.items():
            target.write(name, data)
        target.finish(manifest_inputs(request, population))
    return Report(
        name="inputs",
        title=crowd_title(population),
        tables=[],
        lines=["in each of its folders: `lmp -in crowd.in`"],
        folder=folder,
        caption=crowd_caption(population),
        facts={"files": sorted(inputs)},
    )


def manifest_inputs(request: CrowdRequest, population: Population) -> dict[str, Any]:
    """Return every resolved input of a crowd, for its manifest."""
    designs = [kind.design for kind in population.kinds if kind.design]
    return {
        "model": population.model,
        "scene": population.scene.model_dump(mode="json"),
        "designs": [design.model_dump(mode="json") for design in designs],
        "bodies_sha256": [design.shape.sha256 for design in designs],
        "cards": [kind.card.model_dump(mode="json") for kind in population.kinds if kind.card],
        "counts": [kind.walkers for kind in population.kinds],
        "rate_hz": request.rate_hz,
        "versions": versions(),
    }


def folder_name(population: Population) -> str:
    """Return the name of a crowd's folder, after its walkers and its dish."""
    who = "-".join(kind.name for kind in population.kinds)
    count = sum(kind.walkers for kind in population.kinds)
    dish = population.scene.crowd.dish.words.replace(":", "-").replace(",", "-")
    return f"crowd-{who}-{count}-{dish}"[:100]
