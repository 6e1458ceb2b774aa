"""The command `accuracy`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.cli.times import parse_time
from walkergen.files import words

if TYPE_CHECKING:
    from walkergen.jobs.accuracy.make import Study


MOST_ROWS = 60
"""Number of rows of a ladder beyond which only its notes are printed: files have the rows."""


def accuracy(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    keys: opt.Values = None,
    only: Annotated[
        str, typer.Option("--only", metavar="LADDERS", help="Comma-separated ladders to measure.")
    ] = "models,steps,statistics,shape",
    budget: Annotated[
        str,
        typer.Option("--budget", metavar="TIME", help="Time of all simulations: 10s, 5min, 1h."),
    ] = "60s",
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Measure what accuracy costs in time: models, steps, statistics, shape."""
    from walkergen.jobs.accuracy import make as study
    from walkergen.walker import names

    chosen = study.check(only)
    seconds = parse_time(budget)
    asked = loading.asked(keys, "design scene", restitution=restitution, friction=friction)
    resolved, member = asked.scene(scene), asked.one(design, tilt, legs)
    name = f"{member.name}_{names.tilt(member)}_{member.kind}_{resolved.name}"
    folder = out or Path("out") / "accuracy" / name
    with show.progress("accuracy", wanted=not quiet) as progress:
        found = study.make(study.Job(member, resolved, chosen, seconds), folder, progress)
    if json:
        show.as_json(
            {
                "ladders": {
                    ladder.name: [rung._asdict() for rung in ladder.rungs]
                    for ladder in found.ladders
                },
                "answers": [answer._asdict() for answer in found.answers],
                "simulated_s": found.simulated_s,
                "least_budget_s": found.least_s,
                "folder": str(folder),
            }
        )
    elif not quiet:
        _show_study(found, folder)
    if found.least_s is not None:
        least = words.budget(found.least_s)
        print(
            f"--budget {budget}: too short for {only}, which were given {least}, the least that "
            "gives error bars here; --only takes fewer",
            file=sys.stderr,
        )


def _show_study(found: "Study", folder: Path) -> None:
    """Print the ladders, what to run for which error, and where the tables and figures are."""
    from walkergen.jobs.accuracy import tables as ladders

    for ladder in found.ladders:
        if len(ladder.rungs) <= MOST_ROWS:
            show.table(ladders.to_table(ladder))
        else:
            show.text(f"{ladder.title}: {len(ladder.rungs)} rows in {ladder.name}.md")
        show.text(f"error: {ladder.error}\nreference: {ladder.reference}")
        for note in ladder.notes:
            show.text(f"- {note}")
        print()
    if found.answers:
        print("What to run for which error of the mean speed:")
        show.table(ladders.answers_table(found.answers))
    print(f"in {folder}/: a table (CSV, Markdown) and a figure (PNG, PDF) for each ladder"
          + (", accuracy.md, choice.png" if found.answers else ""))  # fmt: skip
