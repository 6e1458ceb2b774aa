"""Functions of `import walkergen as wg`, made from the requests of commands. packaging/stub.py writes their types."""

import ast
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from inspect import Parameter, Signature, getdoc, getsourcefile
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin

import walkergen
from walkergen.command_table import COMMANDS, load_request, split_docstring
from walkergen.core.errors import spell_all, use_spelling

if TYPE_CHECKING:
    from walkergen.request import Request

FUNCTION_NAMES = tuple(name for name in COMMANDS if name in walkergen.__all__ and name != "templates")
"""Commands that are also Python functions."""

TEXT_FIELDS = ("title", "caption", "facts", "lines", "warnings", "errors")
"""Fields of a report whose texts may name arguments."""

ALIASES = {
    "Walker": "Design | str | PathLike",
    "Ground": "Scene | str | PathLike",
    "Machine": "Printer | str | PathLike",
    "Name": "str | PathLike",
    "Kind": "str",
}
"""Types of arguments, by their short names in signatures."""

PROGRESS_HELP = "Function that is called with a step's name, the number done and the total."

RAISED = """\
WalkergenError
    If an argument is invalid, a part cannot be built, a result cannot be computed or a file cannot be written."""


@cache
def make_function(name: str) -> Callable[..., Any]:
    """Build the Python function of a command from its request class."""
    request, signature = load_request(name), make_signature(name)

    def call(*args: Any, **kwargs: Any) -> Any:
        """Run the command's job with these arguments. Return its report; None for a job without one.

        Texts of the report, and errors, contain the names of Python arguments instead of flags.
        """
        values = signature.bind(*args, **kwargs).arguments
        progress = values.pop("progress", None)
        from walkergen.core.files.progress import silent

        with use_spelling(partial(request.to_arguments, given=values)):
            report = request.from_values(values).run(progress or silent)
        return report and replace(report, **{name: spell_all(getattr(report, name)) for name in TEXT_FIELDS})

    call.__name__ = call.__qualname__ = name
    call.__module__ = "walkergen"
    call.__doc__ = make_docstring(name)
    call.__signature__ = signature  # type: ignore[attr-defined]
    call.__annotations__ = {each.name: each.annotation for each in signature.parameters.values()}
    return call


def make_docstring(name: str) -> str:
    """Return the numpydoc docstring of a command's function, made from its request class, fields and reports."""
    request = load_request(name)
    text, notes = split_docstring(request)
    sections = {
        "Parameters": [_describe_parameter(request, each) for each in make_signature(name).parameters.values()],
        "Returns": [f"{kind.__name__}\n    {first_paragraph(kind)}" for kind in report_classes(name)],
        "Raises": [RAISED],
    }
    parts = [f"{title}\n{'-' * len(title)}\n" + "\n".join(lines) for title, lines in sections.items()]
    return "\n\n".join(filter(None, [_name_arguments(request, text), *parts, notes]))


def _describe_parameter(request: "type[Request]", parameter: Parameter) -> str:
    """Return the numpydoc entry of a parameter: name, type and default, and the help of the request's field."""
    from walkergen.request import field_help

    name, kind = parameter.name, str(parameter.annotation)
    kind = re.sub(r"\b(Walker|Ground|Machine|Name|Kind)\b", lambda found: ALIASES[found[0]], kind)
    if parameter.default is None:
        kind = f"{kind.removesuffix(' | None')}, optional"
    elif parameter.default is not Parameter.empty:
        kind = f"{kind}, default: {parameter.default!r}"
    text = PROGRESS_HELP if name == "progress" else _name_arguments(request, field_help(request, name))
    return f"{name} : {kind}\n    {text}"


def _name_arguments(request: "type[Request]", text: str) -> str:
    """Replace the flags of a command in a text by the arguments of its Python function, except in backquotes."""
    from walkergen.request import flag_name

    arguments = {flag_name(request, field): f"`{field}`" for field in request.model_fields}
    arguments |= {f"{flag[:2]}no-{flag[2:]}": f"`{field[1:-1]}=False`" for flag, field in arguments.items()}  # --no-x
    return re.sub(r"`[^`]*`|--[a-z][a-z-]*", lambda found: arguments.get(found[0], found[0]), text)


def first_paragraph(thing: Any) -> str:
    """Return the first paragraph of a docstring as one line."""
    return " ".join(str(getdoc(thing)).partition("\n\n")[0].split())


def make_signature(name: str) -> Signature:
    """Return the signature of a command's Python function: the fields of its request, then `progress`."""
    request = load_request(name)
    fields = request.model_fields
    first = [field for field in request.by_position if field in fields]
    names = [*first, *(field for field in fields if field not in first)]
    parameters = []
    for field in names:
        info = fields[field]
        kind = Parameter.POSITIONAL_OR_KEYWORD if field in first else Parameter.KEYWORD_ONLY
        default = Parameter.empty if info.is_required() else info.get_default()
        parameters.append(Parameter(field, kind, default=default, annotation=_field_type(request, field)))
    progress = Parameter("progress", Parameter.KEYWORD_ONLY, default=None, annotation="Progress | None")
    return Signature([*parameters, progress], return_annotation=request.run.__annotations__["return"])


def _field_type(request: "type[Request]", field: str) -> str:
    """Return the type, as text, of the Python argument for a field of a request class."""
    from walkergen.request import field_flag

    return field_flag(request, field).takes or _format_type(request.model_fields[field].annotation)


def _format_type(kind: Any) -> str:
    """Format a type as in source code, with bars for unions."""
    if get_origin(kind) in (Union, UnionType):
        return " | ".join(map(_format_type, get_args(kind)))
    if kind is type(None):
        return "None"
    return kind.__name__ if isinstance(kind, type) else str(kind).replace("typing.", "")


def report_classes(name: str) -> list[type]:
    """Return the classes of reports that a command's function may return, from the annotation of its request."""
    request = load_request(name)
    tree = ast.parse(Path(str(getsourcefile(request))).read_text(encoding="utf-8"))
    modules = {
        alias.name: node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    names = str(request.run.__annotations__["return"]).split(" | ")
    return [getattr(import_module(str(modules[each])), each) for each in names]
