"""Layout of the help: commands in groups, complete sentences, examples; readable at 60 columns."""

import re
from collections.abc import Mapping
from typing import Any

from typer.core import TyperCommand, TyperGroup

OTHER_HEADING = "Commands"
"""Heading over commands that belong to no group."""

HELP_OPTIONS = {"help_option_names": ["-h", "--help"]}
"""Settings of the whole command line: the flags for help."""


OPTION_HEADINGS = {
    "Contact and drive": ("restitution", "friction", "gamma", "frequency", "mode"),
    "Simulation": ("simulate", "model", "seconds", "runs", "step", "seed", "error", "of"),
    "Output": ("out", "trajectory", "rate-hz", "pictures", "all", "json", "quiet", "help"),
}
"""Options under their own headings if a command has many; the other options are listed first."""

MIN_GROUPED_OPTIONS = 15
"""Smallest number of options that are grouped under headings."""

TYPE_SUFFIX = re.compile(r" <[^>]*>$")
"""Suffix that the library adds to an argument's name."""


class Command(TyperCommand):
    """Command whose help has names, sentences and defaults, and no names of Python's types."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then the options."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        sections |= {heading: [] for heading in OPTION_HEADINGS}
        params = self.get_params(ctx)
        headings = {name: heading for heading, names in OPTION_HEADINGS.items() for name in names}
        for param in params:
            record = param.get_help_record(ctx)
            if record is None:
                continue
            heading = "Arguments" if param.param_type_name == "argument" else "Options"
            if heading == "Options" and len(params) >= MIN_GROUPED_OPTIONS:
                long = next(name for name in param.opts if name.startswith("--"))
                heading = headings.get(long.removeprefix("--"), heading)
            name, text = record
            sections[heading].append((TYPE_SUFFIX.sub("", name), text))
        wide = max(len(name) for rows in sections.values() for name, _ in rows)
        for heading, rows in sections.items():
            if rows:
                with formatter.section(heading):
                    formatter.write_dl([(f"{name:{wide}s}", text) for name, text in rows])


class Group(TyperGroup):
    """Commands listed under their headings, each with its complete sentence."""

    sentences: Mapping[str, tuple[str, str]] = {}
    """Headings and sentences of commands that are imported only when they are run."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a list for each heading, keeping the order of headings and commands."""
        groups: dict[str, list[tuple[str, str]]] = {}
        wide = max(map(len, self.commands), default=0)
        for name in self.commands:
            heading, text = self.sentences.get(name) or (OTHER_HEADING, _first_paragraph(self.commands[name]))
            groups.setdefault(heading, []).append((f"{name:{wide}s}", text))
        for heading, rows in groups.items():
            with formatter.section(heading):
                formatter.write_dl(rows)


def epilog(*examples: str) -> str:
    """Return examples of a command for the end of its help."""
    return "\n".join(["\b", "Examples:", *(f"  walkergen {words}" for words in examples)])  # \b: no line wrapping


def _first_paragraph(command: Any) -> str:
    """Return the first paragraph of a command's help as one line."""
    return " ".join(str(command.short_help or command.help or "").split("\n\n")[0].split())
