"""The command `sweep`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.cli.times import parse_time
from walkergen.cli.worker_pools import Workers, pool_of
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.jobs.run.sweep.ask import Ask
    from walkergen.points.request import Request
    from walkergen.points.store import Store
    from walkergen.points.worker_pool import WorkerPool

FEW_POINTS = 512
"""Number of predicted points that take less time here than processes take to start."""


def sweep(
    design: Annotated[str | None, typer.Argument(metavar="DESIGN", help="Walker: a template or a TOML file.")] = None,
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="Values of any key: KEY=5, KEY=5,10,15, KEY=FIRST:LAST:STEP, or, with --sample, "
            "KEY=LOW:HIGH. Keys of the scene begin with scene.",
        ),
    ] = None,
    scene: Annotated[
        str | None, typer.Option("--scene", metavar="SCENE", help="Scene: a template or a TOML file.")
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            "--model",
            metavar="MODEL",
            help="prediction, the default; a model to simulate by; or crowd, for keys of crowds.",
            show_default=False,
        ),
    ] = None,
    error: Annotated[
        str | None, typer.Option("--error", metavar="ERROR", help="Error of each simulated speed: 5% or 3mm/s.")
    ] = None,
    sample: Annotated[
        str | None, typer.Option("--sample", metavar="METHOD:N", help="Samples of LOW:HIGH: sobol:256, latin:99.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the samples.")] = 1,
    keep: Annotated[
        str | None,
        typer.Option(
            "--keep",
            metavar="GROUPS",
            help="Numbers to keep: speed,spread,persistence,impacts,masses,printability; of crowds "
            "their statistics, as polar_order,largest_cluster.",
            show_default=False,
        ),
    ] = None,
    printer: Annotated[
        str | None, typer.Option("--printer", metavar="PRINTER", help="Printer of --keep printability.")
    ] = None,
    file: Annotated[Path | None, typer.Option("--file", metavar="FILE", help="All of this from a sweep.toml.")] = None,
    budget: Annotated[
        str | None, typer.Option("--budget", metavar="TIME", help="Time to spend where errors are worst: 10m.")
    ] = None,
    workers: Workers = None,
    dask: Annotated[
        str | None, typer.Option("--dask", metavar="ADDRESS", help="Cluster instead: tcp://scheduler:8786.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Begin, however long it takes.")] = False,
    out: opt.Out = None,
    pictures: opt.Pictures = True,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Map speeds over any keys of design and scene: a table and pictures, resumed when stopped.

    Keys that begin with scene.crowd. map what crowds do.
    """
    from walkergen.jobs.run.sweep import ask, make
    from walkergen.points.point import PREDICTION
    from walkergen.points.store import Store

    if file is None:
        wanted_points = _ask(design, values or [], scene, printer, model, error, sample, seed, keep)
    else:
        _check_file(DESIGN=design, set=values, scene=scene, printer=printer, error=error, sample=sample)
        wanted_points = ask.of_file(file)
    request = wanted_points.request()
    seconds = None if budget is None else parse_time(budget)
    if seconds is not None and error is not None:
        raise InputError(f"--error {error[:30]}: not with --budget, which adds runs until it is spent")
    folder = out or Path("out") / "sweeps" / wanted_points.name()
    store = Store()
    few = request.model == PREDICTION and request.space.points <= FEW_POINTS
    with pool_of(few, workers, dask) as pool:
        _check_cost(request, store, pool, yes)
        job = make.Job(request, wanted_points.title(), pictures, seconds)
        with show.progress("sweep", wanted=not quiet) as progress:
            result = make.make(job, folder, store, pool, progress)
    show.report(result, json, quiet)


def _ask(
    design: str | None,
    values: list[str],
    scene: str | None,
    printer: str | None,
    model: str | None,
    error: str | None,
    sample: str | None,
    seed: int,
    keep: str | None,
) -> "Ask":
    """Sweep that a command line asks for. Raises InputError."""
    from walkergen.jobs.run.sweep import ask
    from walkergen.points.tolerance import parse

    space, constants = ask.space_of(values, sample, seed)
    groups = None if keep is None else [word.strip() for word in keep.split(",")]
    wanted = None if error is None else parse(error)
    names = design, scene, printer
    return ask.of(names, Path(), space, constants, model, wanted, groups, "--set")


def _check_file(**flags: object) -> None:
    """Refuse what a file of a sweep says itself. Raises InputError."""
    for name, value in flags.items():
        if value is not None:
            flag = name if name.isupper() else f"--{name}"
            raise InputError(f"{flag} {value}: not with --file, which says it")


def _check_cost(request: "Request", store: "Store", pool: "WorkerPool | None", yes: bool) -> None:
    """Say what a large sweep costs and refuse it without --yes. Raises InputError."""
    from walkergen.jobs.run.sweep import cost

    if yes or request.space.points <= cost.UNASKED:
        return
    estimate = cost.estimate(request, store, 1 if pool is None else pool.workers)
    raise InputError(f"{cost.in_words(estimate)}; give --yes to begin, or take fewer points")
