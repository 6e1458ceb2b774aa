"""The command `crowd`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.cli.loading import Inputs
    from walkergen.crowd.runs import Job
    from walkergen.scene import Scene
    from walkergen.walker.design import Design

MODELS = ("space", "flat")

PLANE = "plane-90hz"

MOST_FPS = 50
"""Frames a second of a movie at most; tracks may have more."""


def crowd(
    design: Annotated[
        str | None,
        typer.Argument(
            metavar="DESIGN",
            help="Walker: a template, a TOML file or a card; koumakis2016 by default.",
            show_default=False,
        ),
    ] = None,
    scene: opt.SceneName = PLANE,
    count: Annotated[
        str | None, typer.Option("--count", metavar="N", help="Walkers: 30, or of designs polar-disc:20,rotator:10.")
    ] = None,
    packing: Annotated[
        float | None,
        typer.Option("--packing", metavar="SHARE", help="Area of all bodies over the dish's, for --count."),
    ] = None,
    arena: Annotated[
        str | None,
        typer.Option(
            "--arena", metavar="DISH", help="Dish, mm: disc:120, ring:160,60, rectangle:200x100 or periodic:150."
        ),
    ] = None,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    seconds: opt.Seconds = None,
    runs: Annotated[
        int | None, typer.Option("--runs", metavar="N", help="Independent runs, which give the errors: 4.")
    ] = None,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    step: opt.Step = None,
    seed: opt.Seed = None,
    model: Annotated[
        str | None,
        typer.Option(
            "--model", metavar="MODEL", help="space, of designs, or flat, of cards (.json), by LAMMPS: for thousands."
        ),
    ] = None,
    rate: Annotated[
        float, typer.Option("--rate", metavar="HZ", min=1e-3, max=1e5, help="Frames a second of tracks.")
    ] = 25.0,
    threads: Annotated[
        int | None, typer.Option("--threads", metavar="N", min=1, max=1024, help="Runs at once: every core.")
    ] = None,
    write_only: Annotated[
        bool, typer.Option("--write-only", help="Write the input of LAMMPS of a flat crowd, no more.")
    ] = False,
    keys: opt.Values = None,
    movie: Annotated[
        Path | None,
        typer.Option("--movie", metavar="FILE", help="Film of the first run: .mp4, .gif, or .png, its end."),
    ] = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Let many walkers run in a dish and meet: order, clusters and packing with errors.

    Writes a folder with a page, tables, figures and the tracks of every run. The same seed gives
    the same bytes on any number of threads. A card, as `walkergen card` writes it, in place of a
    design makes a crowd in a plane, of thousands.
    """
    from walkergen.crowd import make, report
    from walkergen.crowd import members as crowd_members
    from walkergen.crowd import movie as crowd_movie

    asked = None if count is None else crowd_members.parse(count)
    shares = asked if isinstance(asked, list) else None
    inputs = loading.inputs(
        keys,
        "design scene",
        restitution=restitution,
        friction=friction,
        gamma=gamma,
        frequency=frequency,
        seconds=seconds,
        runs=runs,
        seed=seed,
        step=step,
        packing=packing,
        arena=arena,
        count=sum(share.walkers for share in shares) if shares else asked,
    )
    if movie is not None:
        crowd_movie.check(movie, "--movie")
    ground = inputs.scene(scene, runs=crowd_members.RUNS)
    if shares is not None and design is not None:
        raise InputError(f"{design[:60]}: --count {count} names the designs: leave one of them out")
    names = [share.name for share in shares] if shares else [design or opt.PAPER]
    counts = None if shares is None else [share.walkers for share in shares]
    flat = _is_flat(model, names)
    if write_only and not flat:
        raise InputError("--write-only: is for --model flat, whose input of LAMMPS it writes")
    job = (_flat if flat else _in_space)(inputs, ground, names, counts, rate, tilt, legs)
    folder = out or Path("out") / report.name_of(job)
    if write_only:
        show.report(report.write_inputs(job, folder), json, quiet)
        return
    with show.progress("crowd", wanted=not quiet) as progress:
        simulated = make.simulate(job, threads, progress)
        result = report.write(report.of(simulated, folder), folder, pictures, progress)
        if movie is not None:
            film, fps = simulated.films[0], min(max(round(rate), 1), MOST_FPS)
            crowd_movie.write(movie, film, result.title, "heading", fps, progress)
    done, wished = len(simulated.films), ground.run.runs
    if done < wished:
        print(f"interrupted after {done} of {wished} runs", file=sys.stderr)
    show.report(result, json, quiet)
    if movie is not None and not (json or quiet):
        print(movie)
    if done < wished:
        raise typer.Exit(130)


def _is_flat(model: str | None, names: list[str]) -> bool:
    """Whether a crowd moves in a plane, by cards. Raises InputError for what is not of one kind."""
    if model not in (None, *MODELS):
        raise InputError(f"--model {model[:30]!r}: must be one of {', '.join(MODELS)}")
    cards = [name.lower().endswith(".json") for name in names]
    if all(cards) and model != "space":
        return True
    if any(cards):
        name = names[cards.index(True)]
        raise InputError(f"{name}: is a card, which model flat alone knows: give designs, or cards for all")
    if model == "flat":
        raise InputError(
            f"--model flat: needs the card of {names[0]}: `walkergen card {names[0]}` writes one, "
            "card.json; give its path in place of the design"
        )
    return False


def _in_space(
    inputs: "Inputs",
    scene: "Scene",
    names: list[str],
    counts: list[int] | None,
    rate: float,
    tilt: float | None,
    legs: str | None,
) -> "Job":
    """Crowd of designs."""
    from walkergen.crowd import in_space as crowd_space

    return crowd_space.asked(scene, _walkers(inputs, names, tilt, legs), counts, rate)


def _flat(
    inputs: "Inputs",
    scene: "Scene",
    names: list[str],
    counts: list[int] | None,
    rate: float,
    tilt: float | None,
    legs: str | None,
) -> "Job":
    """Crowd of cards. Raises InputError for what their measurement has settled."""
    from walkergen.crowd import in_plane
    from walkergen.crowd.cards import card

    why = "a card was measured with its own: make another card (`walkergen card`), or leave it out"
    for flag, value in (("--tilt", tilt), ("--legs", legs)):
        if value is not None:
            raise InputError(f"{flag} {value}: {why}")
    settled = [key for key in inputs.values if not key.startswith(("scene.crowd.", "scene.run."))]
    inputs.refuse([*settled, "scene.run.step_us"], why)
    return in_plane.asked(scene, [card.read(Path(name)) for name in names], counts, rate)


def _walkers(inputs: "Inputs", names: list[str], tilt: float | None, legs: str | None) -> "list[Design]":
    """Designs of a crowd; a tilt and a kind of legs are for one design alone."""
    if len(names) == 1:
        return [inputs.one(names[0], tilt, legs)]
    for flag, value in (("--tilt", tilt), ("--legs", legs)):
        if value is not None:
            raise InputError(f"{flag} {value}: is for one design, seen {len(names)}: leave it out")
    return [inputs.design(name) for name in names]
