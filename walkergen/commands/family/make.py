"""Family of one design in a folder: solids, STL, plates, predicted speeds and pictures."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen import sheets
from walkergen.analysis import speeds
from walkergen.analysis.speeds import PLATE_SPEED_TOLERANCE, Measured
from walkergen.commands.family import chart_data, member_runs, report
from walkergen.commands.family.chart_data import ChartData
from walkergen.commands.family.report import FamilyReport
from walkergen.commands.family.request import FamilyRequest
from walkergen.core.errors import GeometryError
from walkergen.core.files.output import Folder, versions
from walkergen.core.files.progress import Expect, Progress, range_progress
from walkergen.core.printing import export, plates, print_sheet
from walkergen.core.printing.findings import check_printable, warning_lines
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
from walkergen.files.report import format_next_step
from walkergen.inputs import filled_form_warnings, read_masses
from walkergen.points import members, speed_table
from walkergen.points.members import Member
from walkergen.request import choose_scene

CURVE_MARGIN_DEG = 10.0
"""Margin around a single tilt within which the theory is drawn as well, deg."""
MAX_TILT_DEG = 85.0
"""Largest tilt of a design's legs, deg."""


SPEEDS_SHARE, RUNS_SHARE = 0.2, 0.9
"""Shares of the progress bar at which predicted and then simulated speeds are complete; pictures have the rest."""


class FamilyInputs(NamedTuple):
    """Values that a request reads from files."""

    design: Design
    members: Sequence[Design]
    copies: Sequence[int]
    """Number of copies of each member on the plates."""
    scene: Scene
    printer: Printer
    weighed: Mapping[str, Weighings]
    """Masses from a balance by the members' names."""
    measured: Measured | None
    """Measured speeds of printed walkers, for the figure."""
    notes: Sequence[str]
    """Notes on rows of the files that were left out."""


def read_inputs(request: FamilyRequest) -> FamilyInputs:
    """Read the files that a request names. Raises InputError, and GeometryError for a body without space for legs."""
    given = request.inputs()
    try:
        design = given.design(request.design)
    except GeometryError as error:
        raise attach_picture(error, request.output_folder(Path("out") / "trouble")) from None
    scene = given.scene(choose_scene(request.scene, [design]))
    family, copies = given.batch(design, request.tilt, request.legs, request.copies, whole=True)
    masses, notes = read_masses(request.weights, family)
    measured = None
    if request.measured is not None:
        peak = scene.drive.peak_speed
        measured = speeds.select_plate_speed(speeds.read_speeds(request.measured, design.kind, peak), peak)
        notes = [*notes, *(f"{request.measured}: {note}" for note in measured.notes)]
    return FamilyInputs(design, family, copies, scene, given.printer(request.printer), masses, measured, notes)


def run(request: FamilyRequest, progress: Progress, expect: Expect) -> FamilyReport:
    """Write a family's folder. Finished files stay complete if a later step fails.

    Writes stl/, plates/, family.csv, family.md, weights.csv (unless it is already filled in),
    speed.csv (additional data of speed.png), speed.png, speed.pdf, preview.png, report.html,
    manifest.json. Files of an earlier run that this run does not make are removed at the end,
    unless they were changed since. Raises PlateError when a part is too large for the printer,
    PrintabilityError when a part would not print and InputError when weighed masses are
    impossible, all before anything is written. Raises OutputError when a file
    cannot be written.
    """
    inputs = read_inputs(request)
    started = time.perf_counter()
    built = [solids.build(design) for design in inputs.members]
    layout = plates.arrange(inputs.members, built, inputs.copies, inputs.printer, max_parts=request.max_parts)
    check_printable(layout.findings, request.strict)
    draw = sheets.plate_drawing() if request.pictures else None
    path = request.out or Path("out") / inputs.design.name
    with Folder(path) as folder:
        walkers: list[Member] = []
        predicted = members.predict_members(
            inputs.members,
            built,
            inputs.scene,
            request.mode,
            inputs.weighed,
            request.model if request.speeds else "theory",
            range_progress(progress, 0.0, SPEEDS_SHARE if request.simulate else RUNS_SHARE),
            expect,
        )
        for member, mesh in zip(predicted, layout.meshes, strict=True):
            folder.write(f"stl/{member.name}.stl", export.stl_bytes(mesh, member.name))
            walkers.append(member)
        prints: list[Path] = []
        for name, data in plates.layout_files(layout, "family", draw, request.prusaslicer):
            folder.write(f"plates/{name}", data)
            prints += [path / "plates" / name] * name.endswith((".3mf", ".stl"))
        parts = [*(member.name for member in walkers), *weighed_masses.carried_rows(inputs.design)]
        weighed_masses.write_form(path, parts)  # people's: not in the manifest
        written = _report(request, inputs, walkers, path)
        written.write(folder, pictures=False)
        if request.simulate:  # takes long: everything else is already safe in the folder
            walkers = member_runs.simulate_members(
                inputs.scene, walkers, range_progress(progress, SPEEDS_SHARE, RUNS_SHARE)
            )
        progress("pictures", round(100 * RUNS_SHARE), 100)
        shown = _chart_data(inputs, request.mode, walkers) if request.pictures and request.speeds else None
        if request.simulate or shown is not None:
            _report(request, inputs, walkers, path, shown).write(folder, request.pictures)
        if request.pictures:
            folder.write("preview.png", _preview_png(inputs, walkers, request.speeds))
            if (picture := _trace_picture(inputs.design)) is not None:
                folder.write("taken.png", picture)
        facts = _facts(request, inputs, layout, time.perf_counter() - started)
        if request.page:
            from walkergen.commands.family import page

            files = {name: (path / name).read_bytes() for name in sorted(folder.hashes)}
            folder.write("report.html", page.render(report.view_parts(walkers, request.speeds), files, facts))
        folder.finish(facts)
        progress("done", 100, 100)
    forms = filled_form_warnings(path, inputs.members)
    headline = speed_table.headline if request.speeds else speed_table.count_walkers
    return replace(
        _report(request, inputs, walkers, path, shown, why=request.why),
        headline=headline(inputs.design.name, walkers, path),  # no file names its own folder
        warnings=[*warning_lines(layout.findings), *inputs.notes, *forms],
        next_step=format_next_step([path / "preview.png"] * request.pictures, prints),
    )


def _report(
    request: FamilyRequest,
    inputs: FamilyInputs,
    walkers: Sequence[Member],
    path: Path,
    shown: ChartData | None = None,
    why: bool = True,
) -> FamilyReport:
    """Return the report of the walkers, with or without speeds as requested. `why`: whether speeds are explained."""
    if not request.speeds:
        return report.make_parts_report(inputs.design, walkers, path)
    return report.make_report(inputs.design, inputs.scene, request.mode, walkers, path, shown, why)


def attach_picture(error: GeometryError, path: Path | None) -> GeometryError:
    """Return the error of a design. If no legs fit under its body, it names a picture that is saved in `path`.

    Raises OutputError.
    """
    from walkergen.readers.walkers.leg_placement import UnplacedError

    if path is None or not isinstance(error, UnplacedError):
        return error
    from walkergen.commands.family import unsupported_body
    from walkergen.files import figures

    with Folder(path, "") as folder:
        folder.write("trouble.png", figures.png(unsupported_body.draw_unsupported_body(error), dpi=100))
    return GeometryError(f"{error.text}. A picture is in {path / 'trouble.png'}", *error.keys)


def _trace_picture(design: Design) -> bytes | None:
    """Return a picture (PNG) of the outline traced from a photograph; None for other bodies."""
    from walkergen.commands.family import traced_outline
    from walkergen.files import figures

    source = traced_outline.find_picture(design)
    return None if source is None else figures.png(traced_outline.draw_outline(source), dpi=100)


def _preview_png(inputs: FamilyInputs, walkers: Sequence[Member], speeds: bool) -> bytes:
    """Return a picture (PNG) of all members, side by side, with their speeds if `speeds` and if they are few."""
    from walkergen.commands.family import preview
    from walkergen.files import figures

    described = speeds and len(walkers) <= preview.MAX_LARGE_PARTS
    captions = [prediction.describe_briefly(member.row) if described else "" for member in walkers]
    parts = [
        preview.Part(member.design, member.mesh, speed=text, way=_run_direction(member, speeds))
        for member, text in zip(walkers, captions, strict=True)
    ]
    title = speed_table.count_walkers(inputs.design.name, walkers)
    title += f" and how they run on {inputs.scene.name}" if described else ""
    return figures.png(preview.preview_figure(parts, title), dpi=150)


def _run_direction(member: Member, speeds: bool) -> int:
    """Return 1 for a walker that runs forward, -1 for backward, 0 if it stands: by its speed or, without, its legs."""
    speed = member.row.speed.value if speeds else None
    if speed is None:
        return member.design.run_direction
    return 0 if prediction.is_standing(member.row) else int(math.copysign(1, speed))


def _chart_data(inputs: FamilyInputs, mode: Mode, walkers: Sequence[Member]) -> ChartData:
    """Return what speed.png shows besides the family's predictions: curves, measured speeds and the paper's speed.

    If the legs do not follow the family's tilt, measured speeds get the tilt of the walker with their kind of legs.
    """
    measured = inputs.measured
    if measured is not None and not inputs.design.has_family_tilt:
        measured = chart_data.assign_member_tilts(
            measured, {walker.row.legs: walker.row.tilt_deg for walker in walkers}
        )
    return ChartData(_curves(inputs, mode, walkers), measured, _paper_speed(inputs.design, inputs.scene))


def _curves(inputs: FamilyInputs, mode: Mode, walkers: Sequence[Member]) -> dict[Kind, Curve]:
    """Compute speed against tilt by the members' kinds of legs; empty if only the members can be drawn.

    A single tilt is shown with the tilts around it. Legs with individual tilts have no curve. Neither
    has a body on which the walker cannot be built at every tilt in between (legs would meet
    a hole, or miss it).
    """
    if not inputs.design.has_family_tilt:
        return {}
    tilts = [member.design.tilt_deg for member in walkers]
    low, high = min(tilts), max(tilts)
    if low == high:
        low, high = max(low - CURVE_MARGIN_DEG, -MAX_TILT_DEG), min(high + CURVE_MARGIN_DEG, MAX_TILT_DEG)
    curves = {}
    for kind in dict.fromkeys(member.design.kind for member in walkers):
        design = inputs.design.variant(kind=kind)
        same_kind = [member for member in walkers if member.design.kind == kind]
        if _has_dense_tilts(design, same_kind, low, high) and not inputs.weighed:
            curves[kind] = prediction.curve_from_rows(
                [(one.design, one.mass, one.row) for one in same_kind], inputs.scene, mode
            )
            continue
        try:
            curves[kind] = prediction.predict_curve(design, inputs.scene, mode, low, high)
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


def _facts(request: FamilyRequest, inputs: FamilyInputs, layout: plates.Layout, seconds: float) -> dict[str, Any]:
    """Return facts for the manifest: resolved inputs, software versions, elapsed time."""
    return {
        "design": inputs.design.model_dump(mode="json"),
        "body": print_sheet.body_facts(inputs.design),
        "members": [names.part_name(member) for member in inputs.members],
        "legs_up": [names.part_name(member) for member in inputs.members if not solids.is_printed_on_side(member)],
        "copies": list(inputs.copies),
        "weighed": {
            name: {part: mean and weighed_masses.to_dict(mean) for part, mean in weighings._asdict().items()}
            for name, weighings in inputs.weighed.items()
        },
        "scene": inputs.scene.model_dump(mode="json"),
        "printer": layout.printer.model_dump(mode="json"),
        "print": print_sheet.manifest_facts(layout.printer, layout.findings, any(layout.supported)),
        "mode": request.mode,
        "draws": prediction.DRAW_COUNT,
        "seed": prediction.SEED,
        "surrogate": networks.digest(),
        "versions": versions(),
        "time_taken_s": round(seconds, 3),
    }
