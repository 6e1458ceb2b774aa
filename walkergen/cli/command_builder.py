"""Commands made from requests: an option for each field, the layout of the help, and the function of a command."""

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command, get_group

from walkergen import command_table as commands
from walkergen.cli import console, streams
from walkergen.core.errors import use_spelling
from walkergen.core.files.progress import silent

if TYPE_CHECKING:
    from walkergen.request import Request


OTHER_HEADING = "Commands"
"""Heading over commands that belong to no group."""

HELP_OPTIONS = {"help_option_names": ["-h", "--help"]}
"""Settings of the whole command line: the flags for help."""


OPTION_HEADINGS = {
    "Contact and drive": ("restitution", "friction", "gamma", "frequency", "mode"),
    "Simulation": ("simulate", "model", "seconds", "runs", "step", "seed", "error", "of"),
    "Output": ("out", "trajectory", "rate-hz", "pictures", "all", "json", "quiet", "help"),
}
"""Options by their heading in the help of a command with many options. All other options are listed first."""

MIN_GROUPED_OPTIONS = 15
"""Number of options from which on a command's help has headings."""

TYPE_SUFFIX = re.compile(r" <[^>]*>$")
"""Type that typer appends to the name of an argument in the help."""


class Command(TyperCommand):
    """Command whose help has names, sentences and defaults, but no Python types."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the help of the arguments, then of the options, in sections if they are many."""
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
        width = max(len(name) for rows in sections.values() for name, _ in rows)
        for heading, rows in sections.items():
            if rows:
                with formatter.section(heading):
                    formatter.write_dl([(f"{name:{width}s}", text) for name, text in rows])


class Group(TyperGroup):
    """Group of commands, listed in its help under headings, each with its complete summary."""

    sentences: Mapping[str, tuple[str, str]] = {}
    """Heading and summary, by name, of commands that are imported only when they are run."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a list for each heading, keeping the order of headings and commands."""
        groups: dict[str, list[tuple[str, str]]] = {}
        width = max(map(len, self.commands), default=0)
        for name in self.commands:
            heading, text = self.sentences.get(name) or (OTHER_HEADING, _first_paragraph(self.commands[name]))
            groups.setdefault(heading, []).append((f"{name:{width}s}", text))
        for heading, rows in groups.items():
            with formatter.section(heading):
                formatter.write_dl(rows)


def epilog(*examples: str) -> str:
    """Return the examples at the end of a command's help. `examples`: command lines without the word `walkergen`."""
    return "\n".join(["\b", "Examples:", *(f"  walkergen {words}" for words in examples)])  # \b: no line wrapping


def _first_paragraph(command: Any) -> str:
    """Return the first paragraph of a command's help as one line."""
    return " ".join(str(command.short_help or command.help or "").split("\n\n")[0].split())


AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but warnings and errors.")]

SHELL_TYPES = (bool, int, float, Path)
"""Types that typer parses. For all others the request parses the text."""


def command_summary(name: str) -> str:
    """Return the first paragraph of a command's help, read from its source without an import."""
    if not commands.COMMANDS[name].folder:
        return str(make_command(name).help)
    path = Path(commands.__file__).parent / commands.COMMANDS[name].folder.replace(".", "/") / "request.py"
    title = f"{name.capitalize()}Request"
    classes = (node for node in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(node, ast.ClassDef))
    text = next(ast.get_docstring(node) for node in classes if node.name == title)
    return " ".join(str(text).split("\n\n")[0].split())


class Commands(Mapping[str, Any]):
    """Typer commands by name, each built on first use."""

    def __getitem__(self, name: str) -> Any:
        return make_command(name)

    def __iter__(self) -> Iterator[str]:
        return iter(commands.COMMANDS)

    def __len__(self) -> int:
        return len(commands.COMMANDS)


@cache
def make_command(name: str) -> Any:
    """Build the typer command of this name from its request class, or from its module for `templates`."""
    app, entry = typer.Typer(rich_markup_mode=None, add_completion=False), commands.COMMANDS[name]
    if entry.folder:
        app.command(name, cls=Command, epilog=epilog(entry.example, entry.other))(
            make_function(name, commands.load_request(name))
        )
        return get_command(app)
    app.add_typer(import_module(f"walkergen.cli.{name}").commands)
    return get_group(app).commands[name]


def make_function(name: str, request: "type[Request]") -> Callable[..., None]:
    """Build the function that typer calls for a command. Its parameters are the fields of the request class."""

    def command(json: bool = False, quiet: bool = False, **values: Any) -> None:
        """Run the request with these values of its fields. `json`, `quiet`: form of the printed report."""
        given = {field: value for field, value in values.items() if value not in (None, [])}
        with use_spelling(request.to_flags):
            _run_request(name, request.from_values(given, shell=True), json, quiet)

    parameters = [_parameter(request, field) for field in request.model_fields]
    parameters += [
        Parameter(option, Parameter.KEYWORD_ONLY, default=False, annotation=kind)
        for option, kind in (("json", AsJson), ("quiet", Quiet))
        if request.reports
    ]
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    command.__doc__ = commands.split_docstring(request)[0]
    return command


def _run_request(name: str, request: "Request", json: bool, quiet: bool) -> None:
    """Run a request with progress, print its report, and raise typer.Exit for an exit code other than 0."""
    if not request.reports:
        request.run(silent)
        streams.exit_now(0)  # work for a page may take long, and the page is closed
    with console.progress(name, wanted=not quiet, on_expected=request.register_time_callback) as progress:
        report = request.run(progress)
    assert report is not None
    console.print_notes([] if quiet else request.notes)
    console.print_report(report, json, quiet)
    if report.code:
        raise typer.Exit(report.code)


def _parameter(request: "type[Request]", field: str) -> Parameter:
    """Return the parameter that typer reads for a field of a request class: an argument, an option or a switch."""
    from walkergen import field_values
    from walkergen.request import field_flag, field_help, flag_name

    flag, info = field_flag(request, field), request.model_fields[field]
    kind = str if "str" in flag.takes else _shell_type(info.annotation)
    default, name = _shell_default(info.get_default()), flag_name(request, field)
    default = default if isinstance(default, kind) else None
    shown: dict[str, Any] = {"metavar": flag.metavar or None, "help": field_help(request, field)}
    if kind in (int, float):
        shown["parser"] = field_values.read_number
    if flag.templates:
        shown["autocompletion"] = name_completion(flag.templates)
    if kind is bool:
        name = f"{name}/--no-{name.removeprefix('--')}" if default else name
        shown["show_default"] = False
    elif flag.repeats:
        needed = info.is_required()
        kind, default = (list[kind], Parameter.empty) if needed else (list[kind] | None, None)  # type: ignore[valid-type]
    elif info.is_required():
        default = Parameter.empty
    elif default is None:
        kind = kind | None
    option = typer.Argument(**shown) if flag.argument else typer.Option(name, **shown)
    return Parameter(field, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, option])


def _shell_type(annotation: Any) -> Any:
    """Return the type that typer parses for a field's annotation; str if only the request can parse it."""
    kinds = [kind for kind in (get_args(annotation) or [annotation]) if kind is not type(None)]
    return kinds[0] if len(kinds) == 1 and kinds[0] in SHELL_TYPES else str


def _shell_default(default: Any) -> Any:
    """Return a default as typed on a command line: a list of texts is joined by commas."""
    return ",".join(default) if isinstance(default, (list, tuple)) and all(map(_is_text, default)) else default


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def name_completion(kinds: tuple[str, ...]) -> Callable[[str], list[str]]:
    """Return a function that completes the names of templates of these kinds for the shell."""

    def complete(incomplete: str) -> list[str]:
        from walkergen.files import templates

        names = [name for kind in kinds for name in templates.all_names(kind)]
        return [name for name in names if name.startswith(incomplete)]

    return complete
