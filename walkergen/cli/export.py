"""The command `export`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.errors import InputError

HELP = (
    "File formats, such as stl,3mf: solids as they print; dxf, svg: profiles in mm of walkers that "
    "are prisms, outlines of bodies in plan view. STEP needs a heavy kernel and is not written."
)


def export(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    formats: Annotated[str, typer.Option("--format", metavar="FORMAT", help=HELP)] = "stl",
    keys: opt.Values = None,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Write walkers as STL, 3MF, DXF or SVG files, one file per walker."""
    from walkergen.jobs.orders import make as batch

    wanted = [word.strip() for word in formats.split(",")]
    for word in wanted:
        if word not in batch.FORMATS:
            raise InputError(f"--format {word[:30]!r}: must be one of {', '.join(batch.FORMATS)}")
    asked = loading.asked(keys, "design")
    chosen = asked.design(design)
    members = asked.members(chosen, tilt, legs, whole=False)
    folder = out or Path("out") / chosen.name
    with show.progress(chosen.name, wanted=not quiet) as progress:
        files = batch.export_parts(members, wanted, folder, progress)
    show.files(files, json, quiet)
