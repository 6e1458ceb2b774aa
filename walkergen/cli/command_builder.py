"""Commands made from requests: an option for each field, with its help, and a function that shows the report."""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from inspect import Parameter, Signature, getdoc
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer
from typer.main import get_command, get_group

from walkergen import command_table as commands
from walkergen.cli import console, streams
from walkergen.cli.layout import Command, epilog
from walkergen.core.errors import use_spelling
from walkergen.core.files import formatting
from walkergen.core.files.progress import silent

if TYPE_CHECKING:
    from walkergen.request import Request

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but warnings and errors.")]

SHELL_TYPES = (bool, int, float, Path)
"""Types that the shell's own parser handles. For all others the request parses the text."""


def command_summary(name: str) -> str:
    """Return the first paragraph of a command's help, read from the file of its request without an import."""
    if not commands.COMMANDS[name].folder:
        return str(make_command(name).help)
    path = Path(commands.__file__).parent / commands.COMMANDS[name].folder.replace(".", "/") / "request.py"
    title = f"{name.capitalize()}Request"
    classes = (node for node in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(node, ast.ClassDef))
    text = next(ast.get_docstring(node) for node in classes if node.name == title)
    return " ".join(str(text).split("\n\n")[0].split())


class Commands(Mapping[str, Any]):
    """Commands by name, each made on first use."""

    def __getitem__(self, name: str) -> Any:
        return make_command(name)

    def __iter__(self) -> Iterator[str]:
        return iter(commands.COMMANDS)

    def __len__(self) -> int:
        return len(commands.COMMANDS)


@cache
def make_command(name: str) -> Any:
    """Make a command from its request. `templates` has subcommands, which have no requests."""
    home, own = typer.Typer(rich_markup_mode=None, add_completion=False), commands.COMMANDS[name]
    if own.folder:
        home.command(name, cls=Command, epilog=epilog(own.example, own.other))(
            make_function(name, commands.load_request(name))
        )
        return get_command(home)
    home.add_typer(import_module(f"walkergen.cli.{name}").commands)
    return get_group(home).commands[name]


def make_function(name: str, request: "type[Request]") -> Callable[..., None]:
    """Build the function of a command, as typer reads it: its parameters are the request's fields."""

    def command(json: bool = False, quiet: bool = False, **values: Any) -> None:
        given = {field: value for field, value in values.items() if value not in (None, [])}
        with use_spelling(request.to_flags):
            _run_request(name, request.from_values(given, shell=True), json, quiet)

    parameters = [_parameter(request, field) for field in request.model_fields]
    parameters += [
        Parameter(own, Parameter.KEYWORD_ONLY, default=False, annotation=kind)
        for own, kind in (("json", AsJson), ("quiet", Quiet))
        if request.reports
    ]
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    command.__doc__ = getdoc(request)
    return command


def _run_request(name: str, asked: "Request", json: bool, quiet: bool) -> None:
    """Run a request, show its report and exit with its code."""
    if not asked.reports:
        asked.run(silent)
        streams.exit_now(0)  # work for a page may take long, and the page is closed
    with console.progress(name, wanted=not quiet, hear=asked.register_time_callback) as progress:
        report = asked.run(progress)
    assert report is not None
    console.notes([] if quiet else asked.notes)
    console.report(report, json, quiet)
    if report.code:
        raise typer.Exit(report.code)


def _parameter(request: "type[Request]", field: str) -> Parameter:
    """Return the parameter of a field for typer: an argument, an option, a switch, or a repeatable option."""
    from walkergen.request import field_flag, flag_name

    own, info = field_flag(request, field), request.model_fields[field]
    kind = str if "str" in own.takes else _shell_type(info.annotation)
    default, name = _shell_default(info.get_default()), flag_name(request, field)
    default = default if isinstance(default, kind) else None
    shown: dict[str, Any] = {"metavar": own.metavar or None, "help": _help_with_limits(own.help, info.metadata)}
    if own.templates:
        shown["autocompletion"] = name_completion(own.templates)
    if kind is bool:
        name = f"{name}/--no-{name.removeprefix('--')}" if default else name
        shown["show_default"] = False
    elif own.repeats:
        kind, default = list[kind] | None, None  # type: ignore[valid-type]
    elif info.is_required():
        default = Parameter.empty
    elif default is None:
        kind = kind | None
    meeting = typer.Argument(**shown) if own.argument else typer.Option(name, **shown)
    return Parameter(field, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, meeting])


def _help_with_limits(text: str, metadata: Sequence[Any]) -> str:
    """Return the help with the limits of a number, which the request itself checks."""
    low, high = (
        next((formatting.format_number(getattr(item, name), 6) for item in metadata if hasattr(item, name)), "")
        for name in ("ge", "le")
    )
    limits = f"{low}..{high}" if high else f"at least {low}"
    return f"{text.removesuffix('.')}; {limits}." if low else text


def _shell_type(annotation: Any) -> Any:
    """Return the type for the shell's parser; text if only a request can parse the words."""
    kinds = [kind for kind in (get_args(annotation) or [annotation]) if kind is not type(None)]
    return kinds[0] if len(kinds) == 1 and kinds[0] in SHELL_TYPES else str


def _shell_default(default: Any) -> Any:
    """Return a default as a shell would give it."""
    return ",".join(default) if isinstance(default, (list, tuple)) and all(map(_is_text, default)) else default


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def name_completion(kinds: tuple[str, ...]) -> Callable[[str], list[str]]:
    """Return the shell completion for names of shipped templates. Without a match it completes file names."""

    def complete(incomplete: str) -> list[str]:
        from walkergen.files import templates

        names = [name for kind in kinds for name in templates.all_names(kind)]
        return [name for name in names if name.startswith(incomplete)]

    return complete
