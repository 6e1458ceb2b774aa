"""The command `card`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.cli.layout import names_of
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.scene import Scene

PLANE = "plane-90hz"
"""Scene of a card by default: a lane lets no walker turn."""


def card(
    what: Annotated[
        str,
        typer.Argument(
            metavar="WALKER",
            help="Walker, a template or a TOML file; or a film's tracks, .csv; or a card, .json.",
            autocompletion=names_of("walkers"),
        ),
    ] = opt.PAPER,
    scene: opt.SceneName = PLANE,
    design: Annotated[
        str | None,
        typer.Option("--design", metavar="DESIGN", help="Walker that was filmed: a template or a TOML file."),
    ] = None,
    arena: Annotated[
        str | None, typer.Option("--arena", metavar="DISH", help="Dish against whose wall it runs as well: disc:120.")
    ] = None,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    seed: opt.Seed = None,
    fps: Annotated[float | None, typer.Option("--fps", metavar="N", help="Frames per second of the film.")] = None,
    mm_per_px: Annotated[
        str | None, typer.Option("--mm-per-px", metavar="MM", help="Millimetres per pixel, as 0.05±0.001.")
    ] = None,
    y_down: Annotated[bool, typer.Option("--y-down", help="Let y grow downward, as image rows do.")] = False,
    keys: opt.Values = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Measure all that a crowd in a plane has to know of a walker.

    Speed, turning, both diffusions, how long its velocity remembers a push and how late it follows
    the heading, each with its error; whether a model without inertia is enough; inputs for pymunk,
    HOOMD-blue and LAMMPS. From simulated runs, from tracks with headings of a film of a --design,
    or from a card that somebody edited.
    """
    from walkergen.crowd.cards import make
    from walkergen.files import output

    path = Path(what)
    kind = path.suffix.lower()
    of_film = {"--design": design, "--fps": fps, "--mm-per-px": mm_per_px, "--y-down": y_down or None}
    inputs = loading.inputs(keys, "design scene", seconds=seconds, runs=runs, seed=seed, arena=arena)
    if kind == ".json":
        _refuse("a card is read as it is", {**of_film, "--tilt": tilt, "--legs": legs}, inputs)
        result = make.of_file(path)
        asked: dict[str, Any] = {"card": path.name}
        folder = output.results(path, out, "card")
    elif kind == ".csv":
        inputs.refuse([loading.FLAGS["arena"]], "a film tells nothing of walls; leave it out")
        inputs.refuse(
            [loading.FLAGS[key] for key in ("seconds", "runs", "seed")],
            "tracks of a film are as long as they are; leave it out",
        )
        result, asked = _filmed(path, of_film, inputs.scene(scene), inputs, tilt, legs)
        folder = output.results(path, out, "card")
    else:
        _refuse("is for tracks of a film", of_film, None)
        chosen, plane = inputs.one(what, tilt, legs), inputs.scene(scene)
        with show.progress("card", wanted=not quiet) as progress:
            result = make.of_design(plane, chosen, arena is not None, progress)
        asked = {"design": chosen.model_dump(mode="json"), "scene": plane.model_dump(mode="json")}
        folder = out or make.folder_of(chosen)
    show.report(make.write(result, asked, folder, pictures), json, quiet)


def _filmed(
    path: Path, of_film: dict[str, Any], scene: "Scene", inputs: loading.Inputs, tilt: float | None, legs: str | None
) -> tuple[Any, dict[str, Any]]:
    """Card of filmed walkers, and what was asked. Raises InputError without a design."""
    from walkergen.analysis.track_files import Units
    from walkergen.crowd.cards import make
    from walkergen.files.measured import measured

    name = of_film["--design"]
    if name is None:
        raise InputError(
            f"{path}: a film tells no mass and no outline: give the walker with --design, a template or a TOML file"
        )
    scale, scale_se = measured(of_film["--mm-per-px"], "--mm-per-px")
    y_down = bool(of_film["--y-down"])
    units = Units(of_film["--fps"], scale, y_down=y_down, mm_per_px_se=scale_se)
    chosen = inputs.one(name, tilt, legs)
    asked = {
        "file": path.name,
        **units._asdict(),
        "design": chosen.model_dump(mode="json"),
        "scene": scene.model_dump(mode="json"),
    }
    return make.of_film(path, units, scene, chosen), asked


def _refuse(why: str, flags: dict[str, Any], inputs: loading.Inputs | None) -> None:
    """Refuse flags that are given, and keys that are set. Raises InputError."""
    given = [flag for flag, value in flags.items() if value is not None]
    if inputs is not None:
        given += list(inputs.flags.values())
    if given:
        raise InputError(f"{given[0]}: {why}; leave it out")
