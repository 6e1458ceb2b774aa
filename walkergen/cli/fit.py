"""The command `fit`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from walkergen.cli import loading, show, variants
from walkergen.cli import options as opt
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.files.progress import Progress
    from walkergen.jobs.fit.learn import Learned
    from walkergen.jobs.fit.make import Fitted
    from walkergen.jobs.fit.parameters import ModelName
    from walkergen.scene import Scene
    from walkergen.walker.design import Design

MODELS = ("theory", "compliant", "space")


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
            help="Model: theory (a second); compliant or space, simulated (minutes).",
        ),
    ] = "theory",
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="NAME=VALUE", help="Parameter to hold: friction=0.25."),
    ] = None,
    prior: Annotated[
        str | None,
        typer.Option(
            "--prior",
            metavar="PRIOR",
            help="Of restitution and friction, if simulated: flat, or as in the scene (scene).",
        ),
    ] = None,
    predict: Annotated[
        str | None,
        typer.Option(
            "--predict",
            metavar="DEG",
            help="Tilts to predict, if simulated: 8,12 or FIRST:LAST:STEP; else the family's.",
        ),
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
    braced; otherwise the design's) and plate_speed_mm_s (otherwise the scene's). The theory is
    fitted by least squares; a simulated model by emulators and sampling, with bands for one more
    print at every tilt: there a row is one print, its standard error that of its film. Both write
    scene.toml and design.toml for `walkergen family`.
    """
    from walkergen.files import output

    if model not in MODELS:
        raise InputError(f"--model {model[:30]!r}: must be one of {', '.join(MODELS)}")
    simulated = model != "theory"
    if not simulated and (prior, predict, seed) != (None, None, None):
        name = "--prior" if prior is not None else "--predict" if predict is not None else "--seed"
        raise InputError(f"{name}: the theory has none; add --model compliant or --model space")
    if simulated and mode != "coulomb":
        raise InputError(f"--mode {mode[:30]!r}: a mode of the theory; --model {model} has none")
    asked = loading.asked(
        keys, "design scene", law=law, seed=seed, model=model if simulated else None
    )
    resolved, chosen = asked.scene(scene), asked.design(design)
    folder = output.results(file, out, "fit")
    with show.progress("fit", wanted=not quiet) as progress:
        if simulated:
            learned = _learn(
                file, chosen, resolved, cast("ModelName", model), prior or "flat", fix or [],
                predict, pictures, folder, progress,
            )  # fmt: skip
        else:
            fitted = _fit(file, chosen, resolved, mode, fix or [], pictures, folder, progress)
    if simulated:
        _tell_learned(learned, file.name, json, quiet)
    else:
        _tell_fit(fitted, file.name, json, quiet)


def _fit(
    file: Path,
    design: "Design",
    scene: "Scene",
    mode: str,
    fix: list[str],
    pictures: bool,
    folder: Path,
    progress: "Progress",
) -> "Fitted":
    """Fit the theory."""
    from walkergen.jobs.fit import fixed, make

    job = make.Job(design, scene, loading.mode_of(mode, scene), fixed.of_theory(fix), pictures)
    return make.fit(file, job, folder, progress)


def _learn(
    file: Path,
    design: "Design",
    scene: "Scene",
    model: "ModelName",
    prior: str,
    fix: list[str],
    predict: str | None,
    pictures: bool,
    folder: Path,
    progress: "Progress",
) -> "Learned":
    """Fit a simulated model."""
    from walkergen.jobs.fit import fixed, learn, parameters

    if prior not in parameters.PRIORS:
        known = ", ".join(parameters.PRIORS)
        raise InputError(f"--prior {prior[:30]!r}: must be one of {known}")
    ahead = None if predict is None else variants.parse_tilts(predict)
    job = learn.Job(
        design, scene, model, prior, fixed.of_model(fix, model), ahead,
        pictures,
    )  # fmt: skip
    return learn.learn(file, job, folder, progress)


def _tell_fit(found: "Fitted", title: str, json: bool, quiet: bool) -> None:
    """Print the fitted parameters, the quality of the fit and the notes."""
    from walkergen.jobs.fit import tables

    if json:
        data = tables.as_dict(found.fit)
        show.as_json(data | {"notes": found.notes, "folder": str(found.folder)})
    elif not quiet:
        show.table(tables.to_table(found.fit, title))
        for line in (tables.quality(found.fit), tables.correlations(found.fit), *found.notes):
            if line:
                show.text(line)
        print(f"tables, figure, scene.toml and design.toml in {found.folder}/")


def _tell_learned(found: "Learned", title: str, json: bool, quiet: bool) -> None:
    """Print what was learnt, what follows at every tilt, and the notes."""
    from walkergen.jobs.fit import learnt_tables as tables

    if json:
        data = tables.as_dict(found)
        show.as_json(data | {"notes": found.notes, "folder": str(found.folder)})
    elif not quiet:
        show.table(tables.to_table(found.rows, title))
        show.table(tables.bands_table(found.bands))
        for line in (tables.quality(found.posterior, found.speeds), *found.notes):
            show.text(line)
        print(f"tables, figure, scene.toml and design.toml in {found.folder}/")
