"""The command that shows a family's folder: `report`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError


def report(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="What `family` wrote.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="FOLDER/report.html by default."),
    ] = None,
    json: opt.AsJson = False,
) -> None:
    """Show a family on one self-contained HTML page that opens offline."""
    from walkergen import __version__, output
    from walkergen.report import contents, page

    found = contents.read(folder)
    target = out or folder / "report.html"
    sources = [folder / output.MANIFEST, *(folder / name for name in found.states)]
    if target.resolve() in [path.resolve() for path in sources]:
        raise InputError(f"--out {str(target)!r}: is one of the family's files; give another name")
    output.write(target, page.render(found, __version__))
    show.page(target, found, json)


ALL = (report,)
