"""Layout of the help: commands in groups, whole sentences, examples; readable at 60 columns."""

import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import Any

from typer import Typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_group

from walkergen.cli.examples import EXAMPLES

OTHERS = "Commands"
"""Heading over commands that belong to no group."""

HELP_OPTIONS = {"help_option_names": ["-h", "--help"]}
"""Settings of the whole command line: what asks for help."""


OPTIONS = {
    "Contact and drive": ("restitution", "friction", "gamma", "frequency", "law", "mode"),
    "Simulation": ("simulate", "model", "seconds", "runs", "step", "seed", "error", "of"),
    "Output": ("out", "trajectory", "rate", "pictures", "all", "json", "quiet", "help"),
}
"""Options under headings of their own, where a command has many; the others stand first."""

MANY = 15
"""Number of options from which on they stand under headings."""

TYPE = re.compile(r" <[^>]*>$")
RANGE = re.compile(r"([-+.0-9e]+)<=x<=([-+.0-9e]+)")
"""What the library adds to an argument's name, and how it writes what is allowed."""


class Command(TyperCommand):
    """Command whose help has names, sentences and defaults, and no names of Python's types."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then the options."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        sections |= {heading: [] for heading in OPTIONS}
        params = self.get_params(ctx)
        headings = {name: heading for heading, names in OPTIONS.items() for name in names}
        for param in params:
            record = param.get_help_record(ctx)
            if record is None:
                continue
            heading = "Arguments" if param.param_type_name == "argument" else "Options"
            if heading == "Options" and len(params) >= MANY:
                long = next(name for name in param.opts if name.startswith("--"))
                heading = headings.get(long.removeprefix("--"), heading)
            name, text = record
            sections[heading].append((TYPE.sub("", name), RANGE.sub(r"\1..\2", text)))
        wide = max(len(name) for rows in sections.values() for name, _ in rows)
        for heading, rows in sections.items():
            if rows:
                with formatter.section(heading):
                    formatter.write_dl([(f"{name:{wide}s}", text) for name, text in rows])


class Group(TyperGroup):
    """Commands listed under the headings that they were given, each with its whole sentence."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a list for each heading, in the order in which headings and commands came."""
        groups: dict[str, list[tuple[str, str]]] = {}
        wide = max((len(name) for name in self.commands), default=0)
        for name, command in self.commands.items():
            heading = getattr(command, "rich_help_panel", None)
            heading = heading if isinstance(heading, str) else OTHERS
            groups.setdefault(heading, []).append((f"{name:{wide}s}", _sentence(command)))
        for heading, rows in groups.items():
            with formatter.section(heading):
                formatter.write_dl(rows)


class Modules(Mapping[str, Any]):
    """Commands by name, under headings: each is imported, from its module, when it is needed."""

    def __init__(self, headings: Mapping[str, str]) -> None:
        self.headings = headings

    def __getitem__(self, name: str) -> Any:
        return _command(name, self.headings[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self.headings)

    def __len__(self) -> int:
        return len(self.headings)


@cache
def _command(name: str, heading: str) -> Any:
    """Command, or group of commands, of a module."""
    module, home = import_module(f"walkergen.cli.{name}"), Typer(rich_markup_mode=None)
    if hasattr(module, "commands"):
        home.add_typer(module.commands, rich_help_panel=heading)
    else:
        register = home.command(cls=Command, epilog=epilog(name), rich_help_panel=heading)
        register(getattr(module, name))
    return get_group(home).commands[name]


def epilog(command: str) -> str:
    """Examples of a command, such as "bench drop", for the end of its help."""
    lines = [f"  walkergen {words}" for words in EXAMPLES[command]]
    return "\n".join(["\b", "Examples:", *lines])  # \b: lines stay as they are


def names_of(*kinds: str) -> Callable[[str], list[str]]:
    """Completion, for the shell, of names of shipped templates; where none fits it names files."""

    def complete(incomplete: str) -> list[str]:
        from walkergen.files import templates

        names = [name for kind in kinds for name in templates.names(kind)]
        return [name for name in names if name.startswith(incomplete)]

    return complete


def _sentence(command: Any) -> str:
    """First paragraph of a command's help as one line."""
    return " ".join(str(command.short_help or command.help or "").split("\n\n")[0].split())
