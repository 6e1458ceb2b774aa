"""The command `simulate`."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.scene import Scene
    from walkergen.walker.design import Design

UNCERTAIN_SECONDS = 4.0
"""Measured time of a run of --uncertain unless asked otherwise, s."""

CHOSEN = tuple(loading.FLAGS[name] for name in ("step", "seconds", "runs"))
"""Keys whose values --error chooses itself."""


def simulate(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    model: opt.Model = None,
    law: opt.LawName = None,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    step: opt.Step = None,
    seed: opt.Seed = None,
    keys: opt.Values = None,
    trajectory: Annotated[
        Path | None,
        typer.Option(
            "--trajectory", metavar="FILE", help="File for the tracks of all runs: .csv, .npz, or .xyz for OVITO."
        ),
    ] = None,
    rate: Annotated[
        float, typer.Option("--rate", metavar="HZ", min=1e-3, max=1e7, help="Samples per second of it.")
    ] = 1000.0,
    error: Annotated[str | None, typer.Option("--error", metavar="ERROR", help="Error to meet: 5% or 3mm/s.")] = None,
    uncertain: opt.Uncertain = False,
    draws: Annotated[
        int, typer.Option("--draws", metavar="N", help="Prints of --uncertain, best a power of two.")
    ] = 64,
    out: Annotated[Path | None, typer.Option("--out", metavar="FOLDER", help="Folder for --uncertain.")] = None,
    of: Annotated[
        str, typer.Option("--of", metavar="NAME", help="What --error is about, as JSON names it.")
    ] = "speed_mm_s",
    whole: Annotated[
        bool, typer.Option("--all", help="Print all that was measured, not the first lines alone.")
    ] = False,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Bounce a walker on the plate and measure its speed; on a plane also how it turns.

    Several tilts, or both kinds of legs, make a table.
    """
    from walkergen.jobs.run.simulate import make, report, trajectories
    from walkergen.points.tolerance import parse
    from walkergen.walker import solids

    if trajectory is not None:
        trajectories.check(trajectory)
    inputs = loading.inputs(
        keys,
        "design scene",
        restitution=restitution,
        friction=friction,
        law=law,
        gamma=gamma,
        frequency=frequency,
        seconds=seconds,
        runs=runs,
        seed=seed,
        step=step,
        model=model,
    )
    if uncertain:
        why = "not with --uncertain; leave one of them out"
        _refuse(why, error=error, trajectory=trajectory)
        inputs.refuse((loading.FLAGS["runs"],), why)
    elif out is not None:
        raise InputError(f"--out {str(out)!r}: only --uncertain writes a folder")
    if error is not None:
        inputs.refuse(CHOSEN, "--error chooses it; leave one of them out")
    elif of != "speed_mm_s":
        raise InputError(f"--of {of[:60]}: names what --error is about; give --error as well")
    resolved_scene = inputs.scene(scene, **({"seconds": UNCERTAIN_SECONDS} if uncertain else {}))
    members = inputs.members(inputs.design(design), tilt, legs, whole=False)
    if len(members) > 1:
        why = f"means one walker, seen {len(members)}: give one --tilt and one kind of --legs"
        _refuse(why, trajectory=trajectory, error=error, uncertain=uncertain or None)
        _simulate_several(resolved_scene, members, json, quiet)
        return
    (chosen,) = members
    if uncertain:
        _simulate_uncertain(resolved_scene, chosen, draws, out, json, quiet)
        return
    mass = solids.mass_of(chosen)
    interval = None if trajectory is None else 1.0 / rate
    with show.progress("simulate", wanted=not quiet) as progress:
        experiment = make.asked(resolved_scene, chosen, mass, interval)
        simulated = make.measure(experiment, progress, None if error is None else parse(error), of)
        done, wished = simulated.point.summary.runs, simulated.scene.run.runs
        if trajectory is not None and done == wished:
            trajectories.write(trajectory, experiment._replace(scene=simulated.scene), simulated.point, progress)
    if done < wished:
        print(f"interrupted after {done} of {wished} runs", file=sys.stderr)
    show.report(report.of(simulated, whole), json, quiet)
    if trajectory is not None and done == wished and not (json or quiet):
        print(trajectory)
    if done < wished:
        if trajectory is not None:
            print(f"{trajectory}: not written", file=sys.stderr)
        raise typer.Exit(130)


def _refuse(why: str, **chosen: object) -> None:
    """Refuse options that are given. Raises InputError."""
    for name, value in chosen.items():
        if value is not None:
            flag = f"--{name}" if value is True else f"--{name} {value}"
            raise InputError(f"{flag}: {why}")


def _simulate_several(scene: "Scene", members: "Sequence[Design]", json: bool, quiet: bool) -> None:
    """Simulate walkers one after the other and print a row each; after Ctrl-C those that are done.

    Raises InputError for one that cannot be simulated, before any is.
    """
    from walkergen.jobs.run.simulate import several

    wanted, rows = several.asked(scene, members), []
    with show.progress("simulate", wanted=not quiet) as progress:
        try:
            for row in several.each(wanted, progress):
                rows.append(row)
        except KeyboardInterrupt:
            print(f"interrupted after {len(rows)} of {len(wanted)} walkers", file=sys.stderr)
    show.report(several.of(rows, scene, wanted), json, quiet)
    if missing := members[len(rows) :]:
        names = ", ".join(f"{design_of.tilt_deg:g} deg {design_of.kind}" for design_of in missing)
        print(f"missing: {names}", file=sys.stderr)
        raise typer.Exit(130)


def _simulate_uncertain(
    scene: "Scene", design: "Design", draws: int, out: Path | None, json: bool, quiet: bool
) -> None:
    """Simulate uncertain prints and print their speeds, with what to measure next."""
    from walkergen.jobs.run.simulate import prints
    from walkergen.jobs.run.simulate import uncertain as drawing

    with show.progress("simulate", wanted=not quiet) as progress:
        measured = drawing.measure(scene, design, draws, progress)
    result = prints.of(measured, design, scene.name, out)
    if out is not None:
        prints.write(result, out)
    show.report(result, json, quiet)
