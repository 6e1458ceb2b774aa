"""The command `report`."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from walkergen.cli import loading, show, variants
from walkergen.cli import options as opt
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.jobs.page.report.contents import Contents
    from walkergen.scene import Scene


def report(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder that family wrote.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Page to write; FOLDER/report.html by default.")
    ] = None,
    run: Annotated[
        str | None, typer.Option("--run", metavar="SCENE", help="Simulate a second of one member there, to be played.")
    ] = None,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    keys: opt.Values = None,
    json: opt.AsJson = False,
) -> None:
    """Show a family on one self-contained HTML page that opens offline.

    With --run SCENE the page plays a second of a member's run, chosen by --tilt and --legs, in a
    scene in which walkers move in space, such as plane-90hz.
    """
    from walkergen import __version__
    from walkergen.files import output
    from walkergen.jobs.page.report import contents
    from walkergen.jobs.page.report import make as page

    inputs = loading.inputs(keys, "scene")
    if run is None and inputs.values:
        raise InputError("--set scene.KEY=VALUE: changes the scene of --run SCENE; give it")
    scene = None if run is None else inputs.scene(run)
    contents_of = contents.read(folder)
    target = out or folder / "report.html"
    sources = [folder / output.MANIFEST, *(folder / name for name in contents_of.states)]
    if os.path.realpath(target) in map(os.path.realpath, sources):  # of a loop of links, itself
        raise InputError(f"--out {str(target)!r}: is one of the family's files; give another name")
    if run is None and not (tilt is None and legs is None):
        raise InputError("--tilt, --legs: choose the member that --run SCENE simulates; give it")
    output.check_ours(target)
    played = None if scene is None else _played(contents_of, scene, tilt, legs)
    output.renew(target, page.render(contents_of, __version__, played))
    show.report(page.report_of(target, contents_of), json, quiet=False)


def _played(contents_of: "Contents", scene: "Scene", tilt: float | None, legs: str | None) -> "dict[str, Any]":
    """Simulate the member that the command line asks for."""
    from walkergen.jobs.page.report import play

    kinds = [None] if legs is None else variants.parse_kinds(legs)
    if len(kinds) != 1:
        raise InputError(f"--legs {legs!r}: one kind at a time")
    return play.simulate(contents_of.manifest, scene, tilt, kinds[0])
