"""The command `templates`, with `show` and `copy` below it."""

import os
from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import command_builder, console
from walkergen.cli.command_builder import Command, Group, epilog
from walkergen.core.errors import InputError

commands = typer.Typer(
    name="templates",
    cls=Group,
    epilog=epilog("templates", "templates copy koumakis2016 my.toml"),
    help="List, show or copy the shipped TOML files.",
    invoke_without_command=True,
)

TemplateName = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="Name of a template.",
        autocompletion=command_builder.name_completion(("walkers", "scenes", "printers")),
    ),
]


@commands.callback()
def list_templates(context: typer.Context, json: command_builder.AsJson = False) -> None:
    """List the shipped walkers, scenes and printers."""
    if context.invoked_subcommand is not None:
        return
    from walkergen.files import templates

    console.print_report(templates.list_templates(), json, quiet=False)


@commands.command("show", cls=Command, epilog=epilog("templates show lane-90hz", "templates show prusa-mk3s"))
def show_template(name: TemplateName) -> None:
    """Print a template's TOML file."""
    from walkergen.files import templates

    print(templates.find(name).read_text(encoding="utf-8"), end="")


@commands.command("copy", cls=Command, epilog=epilog("templates copy lane-90hz", "templates copy koumakis2016 my.toml"))
def copy_template(
    name: TemplateName,
    to: Annotated[Path | None, typer.Argument(metavar="FILE", help="File to write; NAME.toml by default.")] = None,
) -> None:
    """Copy a template into a file of your own to edit. The copy is named after its file.

    For a drawing, a picture or a mesh, the file has the walker made from it. The positions of its legs are numbers.
    """
    from walkergen.core.files import file_reading, output
    from walkergen.files import templates

    target = to or Path(f"{Path(name).stem}.toml")
    if not file_reading.has_safe_name(target) or target.suffix != ".toml":
        raise InputError(f"{str(target)!r}: must be a file name that ends in .toml, without control characters")
    text = _dump_shape(Path(name), target) if templates.is_path(name) else _rename_template(name, target)
    if os.path.lexists(target):
        raise InputError(f"{target}: already exists. Choose another name: templates copy {name} FILE")
    output.write(target, text.encode())
    print(target)


def _rename_template(name: str, target: Path) -> str:
    """Return a template's TOML text with its name replaced by that of the file `target`."""
    from walkergen.core.files import output
    from walkergen.files import templates

    return templates.read_with_name(templates.find(name), output.safe_folder_name(target).lstrip("_") or name)


def _dump_shape(path: Path, target: Path) -> str:
    """Return TOML text of the walker made from a drawing, picture or mesh, for the file `target`.

    Legs found automatically are written as numbers. Raises InputError for other files.
    """
    from walkergen.core.files.config import read_section
    from walkergen.core.walker.design import Design
    from walkergen.files import templates

    if Design.data_from_file(path) is None:
        raise InputError(f"{path}: cannot be copied. Give the name of a template, or a drawing, a picture or a mesh.")
    design = read_section(path, Design).with_explicit_leg_positions().with_paths_relative_to(target.parent)
    return templates.to_toml(design, f"Walker of {path.name}", every=False)
