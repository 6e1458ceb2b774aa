"""The command `export`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show, variants
from walkergen.cli import options as opt
from walkergen.cli.layout import names_of
from walkergen.errors import InputError

HELP = (
    "File formats, such as stl,3mf: solids as they print; dxf, svg: profiles in mm of walkers that "
    "are prisms, outlines of bodies in plan view; mjcf: the walker on its plate, for MuJoCo. STEP "
    "needs a heavy kernel and is not written."
)


def export(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    formats: Annotated[str, typer.Option("--format", metavar="FORMAT", help=HELP)] = "stl",
    caps: opt.Caps = None,
    scene: Annotated[
        str | None,
        typer.Option(
            "--scene",
            metavar="SCENE",
            help="Scene of mjcf: a template or a TOML file; lane-90hz.",
            autocompletion=names_of("scenes"),
        ),
    ] = None,
    keys: opt.Values = None,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Write walkers as STL, 3MF, DXF or SVG files, one file per walker, or for MuJoCo."""
    from walkergen.jobs.make.export import make as exports

    wanted = [word.strip() for word in formats.split(",")]
    allowed = (*exports.FORMATS, exports.MJCF)
    for word in wanted:
        if word not in allowed:
            raise InputError(f"--format {word[:30]!r}: must be one of {', '.join(allowed)}")
    moving = exports.MJCF in wanted
    if scene is not None and not moving:
        raise InputError(f"--scene {scene[:60]}: only --format {exports.MJCF} has a scene")
    inputs = loading.inputs(keys, "design scene" if moving else "design")
    ground = inputs.scene(scene or opt.SCENE) if moving else None
    chosen = inputs.design(design)
    members = variants.capped(inputs.members(chosen, tilt, legs, whole=False), caps)
    folder = out or Path("out") / chosen.name
    with show.progress(chosen.name, wanted=not quiet) as progress:
        report = exports.make(members, wanted, folder, progress, ground)
    show.report(report, json, quiet)
