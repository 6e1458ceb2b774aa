"""The main job: from one design to solids, STL, plates, predicted speeds, pictures in a folder."""

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from walkergen.analysis.speeds import SAME_PLATE, Measured
from walkergen.errors import GeometryError
from walkergen.files.output import Folder, versions
from walkergen.files.progress import Progress
from walkergen.jobs.family import beside, tables
from walkergen.jobs.family.beside import Beside
from walkergen.jobs.family.tables import Simulated, Weighing
from walkergen.printing import checks, export, sheet
from walkergen.printing import layout as plates
from walkergen.printing import packing as plate
from walkergen.printing.checks import Finding
from walkergen.printing.printers import Printer
from walkergen.scene import Drive, Scene
from walkergen.shapes.mesh import Mesh
from walkergen.theory import discrepancy, prediction
from walkergen.theory.prediction import Curve, Prediction
from walkergen.theory.speed import Mode
from walkergen.walker import names, solids, weights
from walkergen.walker.body import Body
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind, Legs
from walkergen.walker.mass import MassProperties
from walkergen.walker.solids import Solids
from walkergen.walker.weights import Weighings

AROUND_DEG = 10.0
"""Tilts around a single one at which its theory is drawn as well."""
STEEPEST_DEG = 85.0
"""Largest tilt of a design's legs."""


class Job(NamedTuple):
    """Choices of the family command."""

    design: Design
    members: Sequence[Design]
    scene: Scene
    printer: Printer
    mode: Mode
    pictures: bool
    simulate: bool = False
    copies: Sequence[int] = ()
    """Number of copies of each member on the plates; one of each by default."""
    max_parts: int = plate.MOST_PARTS
    """Largest number of parts on a plate."""
    prusaslicer: bool = False
    """True to declare the 3MF files PrusaSlicer's own."""
    weighed: Mapping[str, Weighings] = MappingProxyType({})
    """Masses from a balance by the members' names."""
    strict: bool = False
    """True to refuse what prints otherwise than predicted, not only what fails."""
    measured: Measured | None = None
    """Measured speeds of printed walkers, for the figure."""


class Member(NamedTuple):
    """Walker of a family, with its mesh, masses and speeds."""

    design: Design
    name: str
    mesh: Mesh
    """Mesh of the walker as it stands, in the design's frame."""
    mass: MassProperties
    row: Prediction
    simulated: Simulated | None = None
    weighing: Weighing | None = None


Tell = Callable[[Sequence[Finding]], None]
"""Function called once, before writing, with the findings of the printability checks."""


def make(job: Job, path: Path, progress: Progress, tell: Tell) -> list[Member]:
    """Write a family's folder; finished files stay whole whatever happens later.

    Writes stl/, plates/, family.csv, family.md, weights.csv (unless somebody filled it in),
    speed.csv (what speed.png shows beside the members), speed.png, speed.pdf, preview.png,
    manifest.json. Files of an earlier run that this run does not
    make, and that nobody changed since, are removed at the end. Raises PlateError when a part is
    too large for the printer, PrintabilityError when a part would not print and InputError when
    weighed masses are impossible, all before anything is written, and OutputError when a file
    cannot be written.
    """
    started = time.perf_counter()
    steps = len(job.members) + 2
    built = [solids.build(design) for design in job.members]
    layout = plates.arrange(
        job.members,
        built,
        job.copies or [1] * len(job.members),
        job.printer,
        max_parts=job.max_parts,
    )
    tell(layout.findings)
    checks.refuse(layout.findings, job.strict)
    with Folder(path) as folder:
        made: list[Member] = []
        every = predicted(job.members, built, job.scene, job.mode, job.weighed)
        for member, mesh in zip(every, layout.meshes, strict=True):
            folder.write(f"stl/{member.name}.stl", export.stl_bytes(mesh, member.name))
            made.append(member)
            progress(member.name, len(made), steps)
        for name, data in plates.files(layout, "family", job.pictures, job.prusaslicer):
            folder.write(f"plates/{name}", data)
        parts = (member.name for member in made)
        weights.write_template(path, parts)  # people's: not in the manifest
        progress("plates", len(made) + 1, steps)
        _write_tables(job, made, folder)
        if job.simulate:  # takes long: everything else is already safe in the folder
            made = _with_simulations(job, made, progress)
            _write_tables(job, made, folder)
        if job.pictures:
            _write_pictures(job, made, folder)
        folder.finish(_facts(job, layout.findings, time.perf_counter() - started))
        progress("done", steps, steps)
    return made


def predicted(
    members: Sequence[Design],
    built: Sequence[Solids],
    scene: Scene,
    mode: Mode,
    weighed: Mapping[str, Weighings] = MappingProxyType({}),
) -> Iterator[Member]:
    """Weigh and predict members one by one, with the same random numbers for all.

    With masses from a balance every member also has its mesh's mass and speed. Raises InputError,
    before the first member, when the masses are impossible.
    """
    named = [names.part(design) for design in members]
    final = [
        weights.applied(design, parts, weighed[name], name) if name in weighed else design
        for name, design, parts in zip(named, members, built, strict=True)
    ]
    for name, design, parts in zip(named, final, built, strict=True):
        mass = solids.weigh(design, parts)
        row = prediction.predict(design, mass, scene, mode)
        weighing = None
        if weighed:
            plain = weights.meshed(design)
            meshed = solids.weigh(plain, parts)
            speed = prediction.predict(plain, meshed, scene, mode).speed_mm_s
            weighing = _weighing(weighed.get(name, Weighings()), mass, meshed, speed)
        yield Member(design, name, parts.walker, mass, row, weighing=weighing)


def _weighing(
    found: Weighings, mass: MassProperties, meshed: MassProperties, speed: float
) -> Weighing:
    return Weighing(
        weighings=sum(one.weighings for one in found if one is not None),
        mass_g=float(mass.total),
        mass_se_g=weights.total_error(found, len(mass.legs)),
        mass_mesh_g=float(meshed.total),
        speed_mesh_mm_s=speed,
    )


def caption(design: Design, scene: Scene, mode: str) -> str:
    """Statement of the assumptions on which the speeds of a table of one design rest."""
    contact, assumed = scene.contact, scene.prediction
    what = "mean factor v/w" if design.alike else "balanced factor v/w (in the column mean)"
    return (
        f"Speed: the median by the model in space, with what is not known of contact, print and "
        f"masses, and {100 * assumed.model_sd:g} % for the model itself. {_capital(contact.origin)}"
        f": restitution (the feet's label) {contact.restitution:g} ± {contact.restitution_sd:g}, "
        f"friction {contact.friction:g} ± {contact.friction_sd:g}. "
        f"Theory (eq. 15): {what} x impact speed w, {assumed.impact_speed_factor:g} of the plate's "
        f"peak speed, {scene.impact_speed:.1f} mm/s; mode {mode}, law {contact.law}."
    )


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


def _write_tables(job: Job, made: Sequence[Member], folder: Folder) -> None:
    (rows, simulated), weighed = rows_of(made), weighed_of(made)
    folder.write("family.csv", tables.to_csv(rows, simulated, weighed).encode())
    told = caption(job.design, job.scene, job.mode)
    page = tables.to_markdown(rows, job.design.name, told, simulated)
    if weighed:
        page += tables.weighed_markdown(rows, weighed)
    if legend := names.legend(job.members):
        page += f"\n## Marks\n\n{legend}"
    folder.write("family.md", page.encode())


def rows_of(made: Sequence[Member]) -> tuple[list[Prediction], list[Simulated]]:
    """Predictions, and simulated speeds if there are any, in the members' order."""
    simulated = [member.simulated for member in made if member.simulated is not None]
    return [member.row for member in made], simulated


def weighed_of(made: Sequence[Member]) -> list[Weighing]:
    """Weighed masses beside those of the mesh, in the members' order, if any were weighed."""
    return [member.weighing for member in made if member.weighing is not None]


def _with_simulations(job: Job, made: Sequence[Member], progress: Progress) -> list[Member]:
    """The members with their simulated speeds, each an ensemble as the scene's [run] says."""
    from walkergen.simulation import points
    from walkergen.simulation.ensemble import listed

    asked = [points.Asked(job.scene, member.design, member.mass) for member in made]
    titles = [f"simulating {member.name}" for member in made]
    found = []
    for member, point in zip(made, points.each(asked, titles, progress, None), strict=True):
        summary = point.summary
        simulated = Simulated(
            summary.speed_mm_s, summary.speed_se_mm_s, summary.speed_low_95_mm_s,
            summary.speed_high_95_mm_s, point.model, point.method, listed(summary.outcomes),
            tables.verdict(member.row, summary),
        )  # fmt: skip
        row = tables.with_runs(member.row, simulated)
        found.append(member._replace(row=row, simulated=simulated))
    return found


def _write_pictures(job: Job, made: Sequence[Member], folder: Folder) -> None:
    from walkergen.files import figures as pictures
    from walkergen.jobs.family import figures as plots
    from walkergen.jobs.family import preview

    drive, contact = job.scene.drive, job.scene.contact
    title = (
        f"{job.design.name}: {drive.frequency:g} Hz, {drive.peak_gamma:g} g, "
        f"{contact.origin}: restitution {contact.restitution:g} ± {contact.restitution_sd:g}, "
        f"friction {contact.friction:g} ± {contact.friction_sd:g}"
    )
    rows, simulated = rows_of(made)
    measured = job.measured
    if measured is not None and not job.design.follows:
        measured = beside.of_members(measured, {one.row.legs: one.row.tilt_deg for one in made})
    shown = Beside(_curves(job, made), measured, _stated(job.design, job.scene))
    figure = plots.speed_figure(rows, shown, title, simulated, not job.design.follows)
    folder.write("speed.csv", beside.to_csv(shown).encode())
    folder.write("speed.png", pictures.png(figure))
    folder.write("speed.pdf", pictures.pdf(figure))
    parts = [preview.Part(member.design, member.mesh) for member in made]
    folder.write("preview.png", pictures.png(preview.preview_figure(parts, job.design.name), 150))


def _curves(job: Job, made: Sequence[Member]) -> dict[Kind, Curve]:
    """Speed against tilt by the members' kinds of legs; none where only the members can be drawn.

    A single tilt is shown with the tilts around it. There is no curve of legs whose tilts are their
    own, nor on a body on which the walker cannot be built at every tilt in between (legs would meet
    a hole, or miss it).
    """
    if not job.design.follows:
        return {}
    tilts = [member.design.tilt_deg for member in made]
    low, high = min(tilts), max(tilts)
    if low == high:
        low, high = max(low - AROUND_DEG, -STEEPEST_DEG), min(high + AROUND_DEG, STEEPEST_DEG)
    found = {}
    for kind in dict.fromkeys(member.design.kind for member in made):
        design = job.design.variant(kind=kind)
        try:
            found[kind] = prediction.curve(design, job.scene, job.mode, low, high)
        except GeometryError:  # at a tilt in between; of members it would have been told before
            return {}
    return found


def _stated(design: Design, scene: Scene) -> tuple[float, float] | None:
    """Tilt (deg) and speed (mm/s) that the paper states; None unless walker and plate are its."""
    if not isinstance(design.legs, Legs):
        return None
    legs = design.legs.model_copy(update={"tilt_deg": 10.0, "kind": "flexible"})
    same = design.body == Body() and legs == Legs()
    drive, paper = scene.drive, Drive(frequency_hz=90.0, gamma=1.8)
    if same and math.isclose(drive.peak_speed, paper.peak_speed, rel_tol=SAME_PLATE):
        return 10.0, 60.0
    return None


def _facts(job: Job, findings: Sequence[Finding], seconds: float) -> dict[str, Any]:
    """Facts for the manifest: inputs resolved, versions of the software, time taken."""
    return {
        "design": job.design.model_dump(mode="json"),
        "body": sheet.body_facts(job.design),
        "members": [names.part(member) for member in job.members],
        "legs_up": [names.part(member) for member in job.members if not solids.on_side(member)],
        "copies": list(job.copies),
        "weighed": {
            name: {what: one and one._asdict() for what, one in found._asdict().items()}
            for name, found in job.weighed.items()
        },
        "scene": job.scene.model_dump(mode="json"),
        "printer": job.printer.model_dump(mode="json"),
        "print": sheet.facts(job.printer, findings),
        "mode": job.mode,
        "draws": prediction.DRAWS,
        "seed": prediction.SEED,
        "discrepancy": discrepancy.digest(),
        "versions": versions(),
        "time_taken_s": round(seconds, 3),
    }
