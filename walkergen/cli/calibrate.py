"""The command `calibrate`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt


def calibrate(
    file: Annotated[Path, typer.Argument(metavar="MEASUREMENTS.csv", help="Form of `plate --calibration`, filled in.")],
    design: Annotated[
        str, typer.Option("--design", metavar="DESIGN", help="Walker: a template or a TOML file.")
    ] = opt.PAPER,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    scene: opt.SceneName = opt.SCENE,
    by: Annotated[
        str, typer.Option("--by", metavar="METHOD", help="What Young's modulus is by: deflection, ring or both.")
    ] = "both",
    roll_deg: Annotated[
        float,
        typer.Option(
            "--roll-deg", metavar="DEG", help="Deviation of pitch and roll of the drops, deg; 0: all let go flat."
        ),
    ] = 1.0,
    drops: Annotated[int, typer.Option("--drops", metavar="N", help="Simulated drops for each restitution.")] = 24,
    seed: opt.Seed = None,
    keys: opt.Values = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Estimate Young's modulus, density, friction, damping and restitution from your readings.

    The form is that of `walkergen plate --calibration`. What it holds is estimated, with errors
    from those of the readings and from their scatter, and written into design.toml and scene.toml
    for `family` and `simulate`; what it lacks stays as design and scene have it. Of films it takes
    those of slides: the quantity filmed_deg, angle of the incline, with a column tracks that names
    the film's tracks.csv. A drop test of the walker is simulated (a minute), the rest takes a
    second.
    """
    from walkergen.files import output
    from walkergen.lab.calibrate import make

    inputs = loading.inputs(keys, "design scene", seed=seed)
    walker, surroundings = inputs.one(design, tilt, legs), inputs.scene(scene)
    job = make.Job(walker, surroundings, roll_deg, drops, pictures, by)
    folder = output.results(file, out, "calibrate")
    with show.progress("calibrate", wanted=not quiet) as progress:
        result = make.calibrate(file, job, folder, progress)
    show.report(result, json, quiet)
