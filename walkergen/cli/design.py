"""The command `design`."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.exploring.crew import Crew
    from walkergen.jobs.design.make import Result
    from walkergen.scene import Scene
    from walkergen.walker.design import Design


def design(
    speed: Annotated[float | None, typer.Option("--speed", help="Speed wished, mm/s.")] = None,
    fastest: Annotated[bool, typer.Option("--fastest", help="Wish for the fastest.")] = False,
    calm: Annotated[
        bool,
        typer.Option("--least-sensitive", help="Wish for the least change of speed with friction."),
    ] = False,
    persistence: Annotated[
        float | None, typer.Option("--persistence", help="Persistence length wished, mm.")
    ] = None,
    radius: Annotated[
        float | None, typer.Option("--turning-radius", help="Radius of turning wished, mm.")
    ] = None,
    start: Annotated[
        str, typer.Option("--from", metavar="DESIGN", help="Walker to change; name or TOML file.")
    ] = opt.PAPER,
    vary: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="KEY=LOW:HIGH", help="Key of the file to vary; repeats."),
    ] = None,
    values: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Key of the file to hold; repeats."),
    ] = None,
    scene: opt.SceneName = opt.SCENE,
    printer: opt.PrinterName = opt.PRINTER,
    model: Annotated[
        str | None,
        typer.Option("--model", help="theory, or a model; by default the one of `simulate`."),
    ] = None,
    error: Annotated[
        str, typer.Option("--error", metavar="ERROR", help="Error allowed: 5% or 3mm/s.")
    ] = "5%",
    seed: opt.Seed = None,
    workers: Annotated[
        int | None, typer.Option("--workers", help="Number of processes; all cores by default.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FOLDER", help="Folder; out/design-WISH by default."),
    ] = None,
    pictures: opt.Pictures = True,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Find designs that meet a wish: the theory first, then simulations, then a fresh run."""
    from walkergen.exploring import wanted
    from walkergen.exploring.store import Store
    from walkergen.files import templates
    from walkergen.jobs.design import box, make
    from walkergen.jobs.design import wish as wishes
    from walkergen.jobs.design.lab import Bench, Job
    from walkergen.printing.printers import Printer

    wish = wishes.of_options(speed, persistence, radius, fastest, calm, wanted.parse(error))
    base, place = _settled(opt.design_of(start), opt.scene_of(scene, opt.Changes(seed=seed)),
                           values or [])  # fmt: skip
    spans = box.of_options(vary or [], base)
    job = Job(
        wish, base, place, spans, templates.load(printer, "printers", Printer),
        make.model_of(base, place, model, wish.asks_space), place.run.seed,
    )  # fmt: skip
    make.check(job)
    folder = out or Path("out") / f"design-{wish.slug}"
    store = Store()
    try:
        with _crew(job.simulated, workers) as crew, show.progress("design", not quiet) as progress:
            result = make.make(job, Bench(store, crew, progress), folder, pictures)
    finally:
        store.close()
    if json:
        from walkergen.jobs.design import tables

        show.as_json(tables.as_dict(result))
    elif not quiet:
        _show(result)
    if result.stopped:
        print(f"{result.stopped}; the nearest are in {folder}/", file=sys.stderr)
        raise typer.Exit(1)


def _settled(design: "Design", scene: "Scene", texts: list[str]) -> "tuple[Design, Scene]":
    """Design and scene with the values of --set. Raises InputError."""
    from walkergen.exploring.request import SCENE, changed
    from walkergen.files import assignments
    from walkergen.scene import Scene
    from walkergen.walker.design import Design

    values = {}
    for text in texts:
        key, value = assignments.split(text)
        own = key.removeprefix(SCENE)
        assignments.check(own, Design if own == key else Scene, f"--set {key}")
        if key in values:
            raise InputError(f"--set {key}: given twice; write its value once")
        values[key] = assignments.value_of(value)
    return changed(design, scene, values)


@contextmanager
def _crew(simulated: bool, workers: int | None) -> "Iterator[Crew | None]":
    """Processes for what is simulated; the theory is done here before they would have begun."""
    from walkergen.exploring import crew

    if not simulated and workers is None:
        yield None
        return
    with crew.local(workers) as found:
        yield found


def _show(result: "Result") -> None:
    """Print the designs, what was done, and where they are."""
    from rich import box
    from rich.console import Console

    from walkergen.jobs.design import tables

    console = Console(highlight=False)
    console.print(tables.to_table(result.job, result.designs, box.SIMPLE, False))
    console.print(tables.units(result.job), markup=False)
    for line in tables.notes(result):
        console.print(line.removeprefix("- "), markup=False)
    names = "design-1.toml" if len(result.designs) == 1 else f"design-1 to {len(result.designs)}"
    print(f"{names}, scenes, design.csv, design.md and design.png in {result.folder}/")
