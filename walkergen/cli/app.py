"""The command `app`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt

FOLDER = Path("out") / "app"
"""Folder of all that pages write."""


def app(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    printer: opt.PrinterName = opt.PRINTER,
    port: Annotated[
        int,
        typer.Option("--port", metavar="N", min=0, max=65535, help="Port; 0: any that is free."),
    ] = 8765,
    host: Annotated[
        str,
        typer.Option(
            "--host", metavar="ADDRESS", help="Address of this machine that others may call."
        ),
    ] = "127.0.0.1",
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")
    ] = True,
) -> None:
    """Design a walker on a page in the browser: slide its tilt, see how it runs, take the files.

    The page is served from this machine to this machine alone, and works without a network. Ctrl-C
    ends it.
    """
    from walkergen import cli
    from walkergen.app import serving

    serving.serve(design, scene, printer, FOLDER, host, port, browser)
    cli.leave(0)  # what was being made for a page may take long, and nobody waits for it
