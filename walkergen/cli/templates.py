"""The command `templates`, with `show` and `copy` below it."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError

app = typer.Typer(help="List, show or copy the shipped TOML files.", invoke_without_command=True)


@app.callback()
def list_templates(context: typer.Context, json: opt.AsJson = False) -> None:
    """List the shipped walkers, scenes and printers."""
    if context.invoked_subcommand is not None:
        return
    from walkergen.files import templates

    rows = templates.listing()
    if json:
        show.rows_as_json(rows)
    else:
        show.templates(rows)


@app.command("show")
def show_template(name: str) -> None:
    """Print a template's TOML file."""
    from walkergen.files import templates

    print(templates.find(name).read_text(encoding="utf-8"), end="")


@app.command("copy")
def copy_template(
    name: str,
    to: Annotated[Path | None, typer.Argument(help="File to write; NAME.toml by default.")] = None,
) -> None:
    """Copy a template into a file of your own to edit."""
    from walkergen.files import output, templates

    source, target = templates.find(name), to or Path(f"{name}.toml")
    if target.exists():
        raise InputError(f"{target}: exists already; give another name: templates copy {name} FILE")
    output.write(target, source.read_bytes())
    print(target)
