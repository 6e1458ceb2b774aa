"""The command `weigh`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show


def weigh(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Mesh: STL, OBJ, PLY, OFF, 3MF or GLB.")],
    density: Annotated[
        float, typer.Option("--density", metavar="G/CM3", help="Density of the material, g/cm3.")
    ] = 1.24,
    scale: Annotated[float, typer.Option("--scale", metavar="MM", help="Length of the file's unit, mm.")] = 1.0,
    json: opt.AsJson = False,
) -> None:
    """Weigh a mesh: volume, mass, centre of mass, inertia tensor, principal moments and axes."""
    from walkergen.jobs.make.weigh import make, report

    show.report(report.of(make.weigh(file, density, scale), file, density, scale), json, False)
