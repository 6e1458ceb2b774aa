"""The command `bench`, with `drop`, `slide` and `pluck` below it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.cli.layout import Command, Group, epilog
from walkergen.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from walkergen.files.progress import Progress
    from walkergen.files.report import Report
    from walkergen.lab.bench.make import Drop, Test
    from walkergen.walker.design import Design

commands = typer.Typer(
    name="bench",
    cls=Group,
    epilog=epilog("bench"),
    help="Simulate tests that a person can make with a phone, and invert what they measured.",
    no_args_is_help=True,
)

FPS = 20
"""Frames per second of the film of a drop."""

MeasuredSd = Annotated[
    float | None, typer.Option("--measured-sd", metavar="NUMBER", help="Standard error of the measured number.")
]
Tries = Annotated[int, typer.Option("--tries", metavar="N", min=1, max=10_000, help="Tries whose mean was measured.")]


@commands.command(cls=Command, epilog=epilog("bench drop"))
def drop(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    scene: opt.SceneName = opt.SCENE,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    measured: Annotated[
        float | None, typer.Option("--measured", metavar="NUMBER", help="Rebound seen: root of height over height.")
    ] = None,
    measured_sd: MeasuredSd = None,
    tries: Tries = 1,
    height_mm: Annotated[float, typer.Option("--height-mm", metavar="MM", help="Height of the drop, mm.")] = 10.0,
    roll_deg: Annotated[
        float,
        typer.Option("--roll-deg", metavar="DEG", help="Deviation of pitch and roll of drops from the hand, deg."),
    ] = 1.0,
    drops: Annotated[int, typer.Option("--drops", metavar="N", help="Drops from the hand for each point.")] = 24,
    seed: opt.Seed = None,
    keys: opt.Values = None,
    movie: Annotated[
        Path | None, typer.Option("--movie", metavar="FILE", help="GIF of a drop from the hand; MP4 beside it.")
    ] = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Drop a walker on a still plate: from its rebound to the restitution of its feet."""
    from walkergen.lab import inverse
    from walkergen.lab.bench import make

    if movie is not None and movie.suffix.lower() != ".gif":
        raise InputError(f"--movie {str(movie)[:80]!r}: must end in .gif (the MP4 comes beside it)")
    inputs = loading.inputs(keys, "design scene", restitution=restitution, friction=friction, seed=seed)
    chosen = inputs.one(design, tilt, legs)
    seen = inverse.measured(measured, measured_sd, tries, make.MOST["drop"])
    test = make.Test(chosen, inputs.scene(scene), seen, pictures)
    how = make.Drop(height_mm, roll_deg, drops)

    films: list[Path] = []

    def dropped(folder: Path, progress: "Progress") -> "Report":
        report = make.dropped(test, how, folder, progress)
        if movie is not None:
            films.append(_film(test, how, movie, progress))
        return report

    _report("drop", chosen, out, json, quiet, dropped)
    if not (json or quiet):
        print("".join(f"{film}\n" for film in films), end="")


def _film(test: "Test", how: "Drop", path: Path, progress: "Progress") -> Path:
    """Film the first of the drops from the hand, from the release to where it rises no more."""
    from walkergen.jobs.run.movie import make as movies
    from walkergen.lab import drops, resting

    let = drops.from_hand(how.height, how.turn_deg, how.drops, test.scene.run.seed)[0]
    scene = resting.filmed(test.scene)
    job = movies.plan([test.design], scene, seconds=drops.seconds_of(how.height), fps=FPS, view="perspective")
    return movies.make(job._replace(let_go=lambda plan: drops.let_go(plan, let)), path, progress).gif


@commands.command(cls=Command, epilog=epilog("bench slide"))
def slide(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    scene: opt.SceneName = opt.SCENE,
    measured: Annotated[
        float | None, typer.Option("--measured", metavar="NUMBER", help="Slope at which it slid, deg.")
    ] = None,
    measured_sd: MeasuredSd = None,
    keys: opt.Values = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Tilt a still plate until the walker slides: from that slope to the friction of its feet."""
    from walkergen.lab import inverse
    from walkergen.lab.bench import make

    inputs = loading.inputs(keys, "design scene")
    chosen = inputs.one(design, tilt, legs)
    seen = inverse.measured(measured, measured_sd, 1, make.MOST["slide"])
    test = make.Test(chosen, inputs.scene(scene), seen, pictures)
    _report("slide", chosen, out, json, quiet, lambda *where: make.slid(test, *where))


@commands.command(cls=Command, epilog=epilog("bench pluck"))
def pluck(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    scene: opt.SceneName = opt.SCENE,
    measured: Annotated[
        float | None, typer.Option("--measured", metavar="NUMBER", help="Frequency heard, Hz, the body held.")
    ] = None,
    measured_sd: MeasuredSd = None,
    decrement: Annotated[
        float | None,
        typer.Option("--decrement", metavar="NUMBER", help="Logarithm of a swing over the next on the same side."),
    ] = None,
    decrement_sd: Annotated[
        float | None, typer.Option("--decrement-sd", metavar="NUMBER", help="Standard error of the decrement.")
    ] = None,
    keys: opt.Values = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Pluck a leg, its body held: from its tone to Young's modulus, from its decay to damping."""
    from walkergen.lab import inverse
    from walkergen.lab.bench import make

    inputs = loading.inputs(keys, "design scene")
    chosen = inputs.one(design, tilt, legs)
    heard = inverse.measured(measured, measured_sd, 1, make.MOST["pluck"])
    decay = inverse.measured(decrement, decrement_sd, 1, make.MOST_DECREMENT, "--decrement")
    test = make.Test(chosen, inputs.scene(scene), heard, pictures)
    _report("pluck", chosen, out, json, quiet, lambda *where: make.plucked(test, decay, *where))


def _report(
    what: str, design: "Design", out: Path | None, json: bool, quiet: bool, test: "Callable[[Path, Progress], Report]"
) -> None:
    """Make a test's report in `out`, or below out/ and the walker's name, and print it."""
    from walkergen.lab.bench import make

    folder = out or make.folder_of(what, design)
    with show.progress(f"bench {what}", wanted=not quiet) as progress:
        report = test(folder, progress)
    show.report(report, json, quiet)
