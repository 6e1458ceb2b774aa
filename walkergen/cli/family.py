"""The command `family`."""

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.analysis.speeds import Measured
    from walkergen.scene import Scene
    from walkergen.walker.design import Design


def family(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    scene: opt.SceneName = opt.SCENE,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    printer: opt.PrinterName = opt.PRINTER,
    keys: opt.Values = None,
    copies: opt.Copies = None,
    max_parts: opt.MaxParts = 5000,
    prusaslicer: opt.ForPrusaSlicer = False,
    weights: opt.WeightsFile = None,
    out: opt.Out = None,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Simulate every walker as well (takes minutes).")
    ] = False,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    measured: Annotated[
        Path | None, typer.Option("--measured", metavar="FILE", help="Measured speeds (CSV) for speed.png.")
    ] = None,
    page: Annotated[bool, typer.Option("--page", help="Write report.html, a page of all of it.")] = False,
    run: Annotated[
        str | None, typer.Option("--run", metavar="SCENE", help="Scene of a second's run for the page to play.")
    ] = None,
    pictures: Annotated[bool, typer.Option(show_default=False, help="Draw speed.png and preview.png.")] = True,
    strict: opt.Strict = False,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Make a family of walkers: STL files, plates, predicted speeds, pictures.

    With --page also one self-contained HTML page that opens offline; with --run SCENE it plays a
    second of a walker's run, in a scene in which walkers move in space, such as plane-90hz.
    """
    from walkergen.jobs.make.family import make as families

    if run is not None and not page:
        raise InputError("--run: the page plays it: give --page")

    inputs = loading.inputs(
        keys,
        "design scene printer",
        restitution=restitution,
        friction=friction,
        law=law,
        gamma=gamma,
        frequency=frequency,
        seconds=seconds,
        runs=runs,
    )
    chosen, resolved = inputs.design(design), inputs.scene(scene)
    members, counts = inputs.batch(chosen, tilt, legs, copies, whole=True)
    job = families.Job(
        design=chosen,
        members=members,
        scene=resolved,
        printer=inputs.printer(printer),
        mode=loading.mode_of(mode, resolved),
        pictures=pictures,
        simulate=simulate,
        copies=counts,
        max_parts=max_parts,
        prusaslicer=prusaslicer,
        weighed=loading.weighed(weights, members, quiet),
        strict=strict,
        measured=_measured(measured, chosen, resolved),
        page=page,
        run_in=None if run is None else loading.inputs(None, "scene").scene(run),
    )
    folder = out or Path("out") / chosen.name
    with show.progress(chosen.name, wanted=not quiet) as progress:
        result = families.make(job, folder, progress, partial(show.warnings, quiet=quiet))
    show.report(replace(result, folder=None), json, quiet)
    if not (json or quiet):
        print(
            f"{len(result.members)} walkers in {folder}/: stl, plates, family, weights"
            + (", speed, preview" if pictures else "")
            + (", report.html" if page else "")
        )
    show.kept_forms(folder, members)


def _measured(path: Path | None, design: "Design", scene: "Scene") -> "Measured | None":
    """Read speeds measured on the scene's plate; name rows left out on the error stream."""
    if path is None:
        return None
    from walkergen.analysis import speeds

    measured = speeds.on_plate(path, design.kind, scene.drive.peak_speed)
    for note in measured.notes:
        print(f"{path}: {note}", file=sys.stderr)
    return measured
