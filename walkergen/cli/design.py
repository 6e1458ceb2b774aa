"""The command `design`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.cli.worker_pools import Workers, pool_of


def design(
    speed: Annotated[float | None, typer.Option("--speed", metavar="MM/S", help="Speed wished, mm/s.")] = None,
    fastest: Annotated[bool, typer.Option("--fastest", help="Wish for the fastest.")] = False,
    calm: Annotated[
        bool, typer.Option("--least-sensitive", help="Wish for the least change of speed with friction.")
    ] = False,
    persistence: Annotated[
        float | None, typer.Option("--persistence", metavar="MM", help="Persistence length wished, mm.")
    ] = None,
    radius: Annotated[
        float | None, typer.Option("--turning-radius", metavar="MM", help="Radius of turning wished, mm.")
    ] = None,
    start: Annotated[
        str, typer.Option("--from", metavar="DESIGN", help="Walker to change; name or TOML file.")
    ] = opt.PAPER,
    vary: Annotated[
        list[str] | None, typer.Option("--vary", metavar="KEY=LOW:HIGH", help="Key of the file to vary; repeats.")
    ] = None,
    values: opt.Values = None,
    scene: opt.SceneName = opt.SCENE,
    printer: opt.PrinterName = opt.PRINTER,
    model: Annotated[
        str | None,
        typer.Option("--model", metavar="MODEL", help="prediction, or a model; by default the one of `simulate`."),
    ] = None,
    error: Annotated[str, typer.Option("--error", metavar="ERROR", help="Error allowed: 5% or 3mm/s.")] = "5%",
    seed: opt.Seed = None,
    workers: Workers = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="Folder; out/design-WISH by default.")
    ] = None,
    pictures: opt.Pictures = True,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Find designs that meet a wish: predictions first, then simulations, then a fresh run."""
    from walkergen.jobs.make.design import box, make
    from walkergen.jobs.make.design import wish as wishes
    from walkergen.jobs.make.design.lab import Bench, Job
    from walkergen.points import tolerance
    from walkergen.points.store import Store

    wish = wishes.of_options(speed, persistence, radius, fastest, calm, tolerance.parse(error))
    inputs = loading.inputs(values, "design scene printer", seed=seed)
    base, place = inputs.design(start), inputs.scene(scene)
    spans = box.of_options(vary or [], base)
    inputs.refuse(spans.keys, "--vary varies it: leave one of them out")
    job = Job(
        wish,
        base,
        place,
        spans,
        inputs.printer(printer),
        make.model_of(base, place, model, wish.asks_space),
        place.run.seed,
    )
    make.check(job)
    folder = out or Path("out") / f"design-{wish.slug}"
    store = Store()
    try:
        hands = pool_of(not job.simulated, workers)
        with hands as pool, show.progress("design", not quiet) as progress:
            result = make.make(job, Bench(store, pool, progress), folder, pictures)
    finally:
        store.close()
    show.report(result, json, quiet)
    if result.stopped:
        print(f"{result.stopped}; the nearest are in {folder}/", file=sys.stderr)
        raise typer.Exit(1)
