"""The command `fit`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show, variants
from walkergen.cli import options as opt
from walkergen.errors import InputError


def fit(
    file: Annotated[Path, typer.Argument(metavar="SPEEDS.csv", help="File of measured speeds.")],
    design: Annotated[
        str, typer.Option("--design", metavar="DESIGN", help="Walker: a template or a TOML file.")
    ] = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    model: Annotated[
        str,
        typer.Option(
            "--model",
            metavar="MODEL",
            help="Model: prediction, as family prints it; theory; compliant or space, simulated (minutes).",
        ),
    ] = "prediction",
    fix: Annotated[
        list[str] | None, typer.Option("--fix", metavar="NAME=VALUE", help="Parameter to hold: friction=0.25.")
    ] = None,
    prior: Annotated[
        str | None,
        typer.Option("--prior", metavar="PRIOR", help="Of restitution and friction: flat, or as in the scene (scene)."),
    ] = None,
    predict: Annotated[
        str | None,
        typer.Option("--predict", metavar="DEG", help="Tilts to predict: 8,12 or FIRST:LAST:STEP; else the family's."),
    ] = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    seed: opt.Seed = None,
    keys: opt.Values = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Estimate the contact from measured speeds, and predict walkers that were not measured.

    The CSV file has columns tilt_deg, speed_mm_s and, if known, speed_se_mm_s, legs (flexible or
    braced; otherwise the design's) and plate_speed_mm_s (otherwise the scene's). A row is one
    print, its standard error that of its film. In place of a speed, a column tracks may name the
    tracks.csv of a film: a row for each of its walkers, or for the one in a column particle. The
    contact learnt is that by which speeds are predicted, in seconds, or that of a simulated model
    by emulators, with bands for one more print at every tilt; that of the theory, the paper's
    eq. 15, is found by least squares. All write scene.toml and design.toml for `walkergen family`.
    """
    from walkergen.files import output
    from walkergen.lab.fit import make
    from walkergen.lab.fit.job import Job

    simulated = model in ("compliant", "space")
    if seed is not None and model == "theory":
        raise InputError("--seed: the theory has none; leave out --model theory")
    inputs = loading.inputs(keys, "design scene", law=law, seed=seed, model=model if simulated else None)
    wish = Job(
        inputs.design(design),
        inputs.scene(scene),
        model,
        fix or (),
        prior,
        None if predict is None else variants.parse_tilts(predict),
        mode,
        pictures,
    )
    folder = output.results(file, out, "fit")
    with show.progress("fit", wanted=not quiet) as progress:
        result = make.fit(file, wish, folder, progress)
    show.report(result, json, quiet)
