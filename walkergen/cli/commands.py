"""The commands. Heavy imports stay inside them, so that help and errors come at once."""

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.analysis.speeds import Measured
    from walkergen.design import Design
    from walkergen.scene import Scene


def family(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    scene: opt.SceneName = opt.SCENE,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    printer: opt.PrinterName = opt.PRINTER,
    copies: opt.Copies = "1",
    max_parts: opt.MaxParts = 5000,
    prusaslicer: opt.ForPrusaSlicer = False,
    weights: opt.WeightsFile = None,
    out: opt.Out = None,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Simulate every walker as well (minutes).")
    ] = False,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    measured: Annotated[
        Path | None,
        typer.Option("--measured", metavar="FILE", help="CSV of measured speeds, for speed.png."),
    ] = None,
    pictures: Annotated[bool, typer.Option(help="Draw speed.png and preview.png.")] = True,
    strict: opt.Strict = False,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Make a family of walkers: STL files, plates, predicted speeds, pictures."""
    from walkergen import family as families
    from walkergen import templates
    from walkergen import weights as balance
    from walkergen.printing.printers import Printer

    chosen = opt.design_of(design)
    changes = opt.Changes(
        restitution=restitution, friction=friction, law=law, seconds=seconds, runs=runs
    )
    resolved = opt.scene_of(scene, changes)
    members, counts = opt.batch_of(chosen, tilt, legs, copies, whole=True)
    job = families.Job(
        design=chosen,
        members=members,
        scene=resolved,
        printer=templates.load(printer, "printers", Printer),
        mode=opt.mode_of(mode, resolved),
        pictures=pictures,
        simulate=simulate,
        copies=counts,
        max_parts=max_parts,
        prusaslicer=prusaslicer,
        weighed={} if weights is None else balance.read(weights, members),
        strict=strict,
        measured=_measured(measured, chosen, resolved),
    )
    folder = out or Path("out") / chosen.name
    with show.progress(chosen.name, wanted=not quiet) as progress:
        made = families.make(job, folder, progress, partial(show.warnings, quiet=quiet))
    (rows, simulated), weighed = families.rows_of(made), families.weighed_of(made)
    if json:
        show.rows_as_json(rows, simulated, weighed)
    elif not quiet:
        told = families.caption(resolved, job.mode)
        show.predictions(rows, told, chosen.name, simulated, weighed)
        print(f"{len(made)} walkers in {folder}/: stl, plates, family, weights"
              + (", speed, preview" if pictures else ""))  # fmt: skip


def _measured(path: Path | None, design: "Design", scene: "Scene") -> "Measured | None":
    """Measured speeds on the scene's plate; what is left out is told on the error stream."""
    if path is None:
        return None
    from walkergen.analysis import speeds

    plate_speed = scene.drive.peak_speed
    found = speeds.at_plate_speed(speeds.read(path, design.legs.kind, plate_speed), plate_speed)
    if found.bad:
        print(f"{path}: {found.bad}", file=sys.stderr)
    return found


def predict(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    scene: opt.SceneName = opt.SCENE,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    weights: opt.WeightsFile = None,
    json: opt.AsJson = False,
) -> None:
    """Predict the speed of walkers, without writing any file."""
    from walkergen import family as families
    from walkergen import solids
    from walkergen import weights as balance

    chosen = opt.design_of(design)
    changes = opt.Changes(restitution=restitution, friction=friction, law=law)
    resolved = opt.scene_of(scene, changes)
    checked = opt.mode_of(mode, resolved)
    members = opt.members_of(chosen, tilt, legs, whole=False)
    built = [solids.build(member) for member in members]
    masses = {} if weights is None else balance.read(weights, members)
    made = list(families.predicted(members, built, resolved, checked, masses))
    (rows, _), weighed = families.rows_of(made), families.weighed_of(made)
    if json:
        show.rows_as_json(rows, weighed)
    else:
        told = families.caption(resolved, checked)
        show.predictions(rows, told, chosen.name, weighed=weighed)


def export(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    formats: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="stl, 3mf, or stl,3mf.")
    ] = "stl",
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Write walkers as STL or 3MF files, one a walker."""
    from walkergen import batch

    wanted = [word.strip() for word in formats.split(",")]
    for word in wanted:
        if word not in batch.FORMATS:
            raise InputError(f"--format {word[:30]!r}: must be one of {', '.join(batch.FORMATS)}")
    chosen = opt.design_of(design)
    members = opt.members_of(chosen, tilt, legs, whole=False)
    folder = out or Path("out") / chosen.name
    with show.progress(chosen.name, wanted=not quiet) as progress:
        files = batch.export_parts(members, wanted, folder, progress)
    show.files(files, json, quiet)


templates_app = typer.Typer(
    help="List, show or copy the shipped TOML files.", invoke_without_command=True
)


@templates_app.callback()
def list_templates(context: typer.Context, json: opt.AsJson = False) -> None:
    """List the shipped walkers, scenes and printers."""
    if context.invoked_subcommand is not None:
        return
    from walkergen import templates

    rows = templates.listing()
    if json:
        show.rows_as_json(rows)
    else:
        show.templates(rows)


@templates_app.command("show")
def show_template(name: str) -> None:
    """Print a template."""
    from walkergen import templates

    print(templates.find(name).read_text(encoding="utf-8"), end="")


@templates_app.command("copy")
def copy_template(
    name: str,
    to: Annotated[Path | None, typer.Argument(help="File to write; NAME.toml by default.")] = None,
) -> None:
    """Copy a template into a file of your own to edit."""
    from walkergen import output, templates

    source, target = templates.find(name), to or Path(f"{name}.toml")
    if target.exists():
        raise InputError(f"{target}: exists already; give another name: templates copy {name} FILE")
    output.write(target, source.read_bytes())
    print(target)


ALL = (family, predict, export)
