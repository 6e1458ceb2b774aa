"""Main job: one design becomes solids, STL, plates, predicted speeds and pictures in a folder."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from walkergen import sheets
from walkergen.analysis.speeds import PLATE_SPEED_TOLERANCE, Measured
from walkergen.commands.family import chart_data, member_runs, report
from walkergen.commands.family.chart_data import ChartData
from walkergen.commands.family.report import FamilyReport
from walkergen.core.errors import GeometryError
from walkergen.core.files.output import Folder, versions
from walkergen.core.files.progress import Progress
from walkergen.core.printing import export, plates, print_sheet
from walkergen.core.printing import packing as plate
from walkergen.core.printing.findings import Finding, check_printable
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Drive, Scene
from walkergen.core.theory import networks, prediction
from walkergen.core.theory.prediction import Curve
from walkergen.core.theory.speed import Mode
from walkergen.core.walker import names, solids, weighed_masses
from walkergen.core.walker.body import Body
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Kind, Legs
from walkergen.core.walker.weighed_masses import Weighings
from walkergen.points import members
from walkergen.points.members import Member
from walkergen.points.speed_prediction import Model

CURVE_MARGIN_DEG = 10.0
"""Margin around a single tilt within which the theory is drawn as well, deg."""
MAX_TILT_DEG = 85.0
"""Largest tilt of a design's legs, deg."""


class Job(NamedTuple):
    """Choices of the family command."""

    design: Design
    members: Sequence[Design]
    scene: Scene
    printer: Printer
    mode: Mode
    pictures: bool
    model: Model = "best"
    simulate: bool = False
    copies: Sequence[int] = ()
    """Number of copies of each member on the plates; by default one of each."""
    max_parts: int = plate.MAX_PARTS
    """Largest number of parts on a plate."""
    prusaslicer: bool = False
    """True to declare the 3MF files PrusaSlicer's own."""
    weighed: Mapping[str, Weighings] = MappingProxyType({})
    """Masses from a balance by the members' names."""
    strict: bool = False
    """True to refuse prints that differ from the prediction, not only failed prints."""
    measured: Measured | None = None
    """Measured speeds of printed walkers, for the figure."""
    page: bool = False
    """True to write report.html, one page with all results that opens offline."""


FindingsCallback = Callable[[Sequence[Finding]], None]
"""Function called once, before writing, with the findings of the printability checks."""


def make(job: Job, path: Path, progress: Progress, tell: FindingsCallback) -> FamilyReport:
    """Write a family's folder. Finished files stay complete if a later step fails.

    Writes stl/, plates/, family.csv, family.md, weights.csv (unless it is already filled in),
    speed.csv (additional data of speed.png), speed.png, speed.pdf, preview.png, report.html,
    manifest.json. Files of an earlier run that this run does not make are removed at the end,
    unless they were changed since. Raises PlateError when a part is too large for the printer,
    PrintabilityError when a part would not print and InputError when weighed masses are
    impossible, all before anything is written. Raises OutputError when a file
    cannot be written.
    """
    started = time.perf_counter()
    steps = len(job.members) + 2
    built = [solids.build(design) for design in job.members]
    layout = plates.arrange(
        job.members, built, job.copies or [1] * len(job.members), job.printer, max_parts=job.max_parts
    )
    tell(layout.findings)
    check_printable(layout.findings, job.strict)
    draw = sheets.plate_drawing() if job.pictures else None
    with Folder(path) as folder:
        walkers: list[Member] = []
        every = members.predict_members(job.members, built, job.scene, job.mode, job.weighed, job.model, progress)
        for member, mesh in zip(every, layout.meshes, strict=True):
            folder.write(f"stl/{member.name}.stl", export.stl_bytes(mesh, member.name))
            walkers.append(member)
            progress(member.name, len(walkers), steps)
        for name, data in plates.layout_files(layout, "family", draw, job.prusaslicer):
            folder.write(f"plates/{name}", data)
        parts = [*(member.name for member in walkers), *weighed_masses.carried_rows(job.design)]
        weighed_masses.write_template(path, parts)  # people's: not in the manifest
        progress("plates", len(walkers) + 1, steps)
        written = report.make_report(job.design, job.scene, job.mode, walkers, path)
        written.write(folder, pictures=False)
        if job.simulate:  # takes long: everything else is already safe in the folder
            walkers = member_runs.simulate_members(job.scene, walkers, progress)
        shown = _chart_data(job, walkers) if job.pictures else None
        if job.simulate or job.pictures:
            written = report.make_report(job.design, job.scene, job.mode, walkers, path, shown)
            written.write(folder, job.pictures)
        if job.pictures:
            folder.write("preview.png", _preview_png(job, walkers))
            if (picture := _trace_picture(job.design)) is not None:
                folder.write("taken.png", picture)
        facts = _facts(job, layout.findings, time.perf_counter() - started)
        if job.page:
            from walkergen.commands.family import page

            files = {name: (path / name).read_bytes() for name in sorted(folder.hashes)}
            folder.write("report.html", page.render(report.view_parts(walkers), files, facts))
        folder.finish(facts)
        progress("done", steps, steps)
    return written


def attach_picture(error: GeometryError, path: Path | None) -> GeometryError:
    """Return the error of a design. If no legs fit under its body, a picture of it is attached, saved in `path`.

    Raises OutputError.
    """
    from walkergen.readers.walkers.leg_placement import UnplacedError

    if path is None or not isinstance(error, UnplacedError):
        return error
    from walkergen.commands.family import unsupported_body
    from walkergen.files import figures

    with Folder(path, "") as folder:
        folder.write("trouble.png", figures.png(unsupported_body.draw_unsupported_body(error), 100))
    return GeometryError(f"{error.text}; drawn in {path / 'trouble.png'}", *error.keys)


def _trace_picture(design: Design) -> bytes | None:
    """Return a picture (PNG) of the outline traced from a photograph; None for other bodies."""
    from walkergen.commands.family import traced_outline
    from walkergen.files import figures

    source = traced_outline.find_picture(design)
    return None if source is None else figures.png(traced_outline.draw_outline(source), 100)


def _preview_png(job: Job, walkers: Sequence[Member]) -> bytes:
    """Return a picture (PNG) of all members, side by side."""
    from walkergen.commands.family import preview
    from walkergen.files import figures

    said = [
        prediction.describe_briefly(member.row) if len(walkers) <= preview.MAX_LARGE_PARTS else "" for member in walkers
    ]
    parts = [preview.Part(member.design, member.mesh, speed=text) for member, text in zip(walkers, said, strict=True)]
    return figures.png(preview.preview_figure(parts, job.design.name), 150)


def _chart_data(job: Job, walkers: Sequence[Member]) -> ChartData:
    """Return the additional speeds of speed.png."""
    measured = job.measured
    if measured is not None and not job.design.follows:
        measured = chart_data.assign_member_tilts(
            measured, {walker.row.legs: walker.row.tilt_deg for walker in walkers}
        )
    return ChartData(_curves(job, walkers), measured, _paper_speed(job.design, job.scene))


def _curves(job: Job, walkers: Sequence[Member]) -> dict[Kind, Curve]:
    """Compute speed against tilt by the members' kinds of legs; empty if only the members can be drawn.

    A single tilt is shown with the tilts around it. Legs with individual tilts have no curve. Neither
    has a body on which the walker cannot be built at every tilt in between (legs would meet
    a hole, or miss it).
    """
    if not job.design.follows:
        return {}
    tilts = [member.design.tilt_deg for member in walkers]
    low, high = min(tilts), max(tilts)
    if low == high:
        low, high = max(low - CURVE_MARGIN_DEG, -MAX_TILT_DEG), min(high + CURVE_MARGIN_DEG, MAX_TILT_DEG)
    curves = {}
    for kind in dict.fromkeys(member.design.kind for member in walkers):
        design = job.design.variant(kind=kind)
        own = [member for member in walkers if member.design.kind == kind]
        if _has_dense_tilts(design, own, low, high) and not job.weighed:
            curves[kind] = prediction.curve_from_rows(
                [(one.design, one.mass, one.row) for one in own], job.scene, job.mode
            )
            continue
        try:
            curves[kind] = prediction.predict_curve(design, job.scene, job.mode, low, high)
        except GeometryError:  # at a tilt in between; an error of a member would have been raised before
            return {}
    return curves


def _has_dense_tilts(design: Design, walkers: Sequence[Member], low: float, high: float) -> bool:
    """Return whether members are a design at tilts from `low` to `high` (deg), at half a curve's density or more."""
    tilts = np.sort([walker.design.tilt_deg for walker in walkers])
    gaps = np.diff(tilts, prepend=low, append=high)
    if gaps.max() > 2.0 * (high - low) / (prediction.CURVE_POINTS - 1) or (np.diff(tilts) == 0.0).any():
        return False
    return all(one.design.unmarked == design.unmarked.variant(tilt_deg=one.design.tilt_deg) for one in walkers)


def _paper_speed(design: Design, scene: Scene) -> tuple[float, float] | None:
    """Return tilt (deg) and speed (mm/s) of the paper; None unless walker and plate are the paper's."""
    if not isinstance(design.legs, Legs):
        return None
    legs = design.legs.model_copy(update={"tilt_deg": 10.0, "kind": "flexible"})
    drive, paper = scene.drive, Drive(frequency_hz=90.0, gamma=1.8)
    same = design.body == Body() and legs == Legs() and drive.kind == "plate"
    if same and math.isclose(drive.peak_speed, paper.peak_speed, rel_tol=PLATE_SPEED_TOLERANCE):
        return 10.0, 60.0
    return None


def _facts(job: Job, findings: Sequence[Finding], seconds: float) -> dict[str, Any]:
    """Return facts for the manifest: resolved inputs, software versions, elapsed time."""
    return {
        "design": job.design.model_dump(mode="json"),
        "body": print_sheet.body_facts(job.design),
        "members": [names.part_name(member) for member in job.members],
        "legs_up": [names.part_name(member) for member in job.members if not solids.is_printed_on_side(member)],
        "copies": list(job.copies),
        "weighed": {
            name: {part: mean and weighed_masses.to_dict(mean) for part, mean in weighings._asdict().items()}
            for name, weighings in job.weighed.items()
        },
        "scene": job.scene.model_dump(mode="json"),
        "printer": job.printer.model_dump(mode="json"),
        "print": print_sheet.manifest_facts(job.printer, findings),
        "mode": job.mode,
        "draws": prediction.DRAW_COUNT,
        "seed": prediction.SEED,
        "surrogate": networks.digest(),
        "versions": versions(),
        "time_taken_s": round(seconds, 3),
    }
