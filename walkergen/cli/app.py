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
    keys: opt.Values = None,
    port: Annotated[
        int, typer.Option("--port", metavar="N", min=0, max=65535, help="Port; 0: any that is free.")
    ] = 8765,
    host: Annotated[
        str, typer.Option("--host", metavar="ADDRESS", help="Address of this machine that others may call.")
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
) -> None:
    """Design a walker on a page in the browser: slide its tilt, see how it runs, take the files.

    The page is served from this machine to this machine alone, and works without a network. Ctrl-C
    ends it.
    """
    from walkergen import cli
    from walkergen.app import serving
    from walkergen.app.document import Document
    from walkergen.cli import loading

    inputs = loading.inputs(keys, "design scene printer")
    inputs.design(design), inputs.scene(scene), inputs.printer(printer)
    asked = Document(design, scene, printer, inputs.values)
    anew = asked != Document(opt.PAPER, opt.SCENE, opt.PRINTER, {})
    serving.serve(asked, anew, FOLDER, host, port, browser)
    cli.leave(0)  # what was being made for a page may take long, and nobody waits for it
