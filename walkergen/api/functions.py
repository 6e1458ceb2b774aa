"""Functions of `import walkergen as wg`, made from the requests of commands, and their types for editors.

`python -m walkergen.api.functions` prints walkergen/__init__.pyi.
"""

import ast
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from inspect import Parameter, Signature, getdoc, getsourcefile
from pathlib import Path
from textwrap import indent
from types import UnionType
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin

import walkergen
from walkergen.command_table import COMMANDS, load_request
from walkergen.core.errors import spell_all, use_spelling

if TYPE_CHECKING:
    from walkergen.request import Request
FUNCTION_NAMES = tuple(name for name in COMMANDS if name in walkergen.__all__ and name != "templates")
"""Commands that are also Python functions."""

TEXT_FIELDS = ("title", "caption", "facts", "lines", "warnings", "errors")  # of a report, which name arguments

STUB_HEADER = """\
# Made of the requests by `python -m walkergen.api.functions`
import os
from collections.abc import Iterable, Mapping
from typing import Any, Literal

{imports}

__version__: str

Name = str | os.PathLike[str]
Walker = Design | Name
Ground = Scene | Name
Machine = Printer | Name
"""

TYPE_IMPORTS = (
    "from walkergen.api.loading import load, templates",
    "from walkergen.guests.crowd.cards.card import Card",
    "from walkergen.core.errors import WalkergenError",
    "from walkergen.core.files.progress import Progress",
    "from walkergen.core.printing.printers import Printer",
    "from walkergen.core.scene import Scene",
    "from walkergen.core.walker.design import Design",
    "from walkergen.core.walker.limbs import Kind",
)
"""Imports for the types of arguments."""


@cache
def make_function(name: str) -> Callable[..., Any]:
    """Return the function of a command. Unlike the command, it writes no folder unless one is given."""
    request, signature = load_request(name), make_signature(name)

    def call(*given: Any, **named: Any) -> Any:
        values = signature.bind(*given, **named).arguments
        progress = values.pop("progress", None)
        from walkergen.core.files.progress import silent

        with use_spelling(partial(request.to_arguments, given=values)):
            report = request.from_values(values).run(progress or silent)
        return report and replace(report, **{name: spell_all(getattr(report, name)) for name in TEXT_FIELDS})

    call.__name__ = call.__qualname__ = name
    call.__module__ = "walkergen"
    call.__doc__ = make_docstring(name)
    call.__signature__ = signature  # type: ignore[attr-defined]
    call.__annotations__ = {own.name: own.annotation for own in signature.parameters.values()}
    return call


def make_docstring(name: str) -> str:
    """Return the docstring of a function: that of its command, and an example."""
    return f"{getdoc(load_request(name))}\n\nExample: `{COMMANDS[name].call}`"


def make_signature(name: str) -> Signature:
    """Return the signature of a function: positional arguments, then keyword arguments, with types for editors."""
    request = load_request(name)
    fields = request.model_fields
    first = [field for field in request.by_position if field in fields]
    names = [*first, *(field for field in fields if field not in first)]
    parameters = []
    for field in names:
        own = fields[field]
        kind = Parameter.POSITIONAL_OR_KEYWORD if field in first else Parameter.KEYWORD_ONLY
        default = Parameter.empty if own.is_required() else own.get_default()
        parameters.append(Parameter(field, kind, default=default, annotation=_field_type(request, field)))
    told = Parameter("progress", Parameter.KEYWORD_ONLY, default=None, annotation="Progress | None")
    return Signature([*parameters, told], return_annotation=request.run.__annotations__["return"])


def _field_type(request: "type[Request]", field: str) -> str:
    """Return the type of a field's argument in Python."""
    from walkergen.request import field_flag

    return field_flag(request, field).takes or _format_type(request.model_fields[field].annotation)


def _format_type(kind: Any) -> str:
    """Format a type as in source code, with bars for unions."""
    if get_origin(kind) in (Union, UnionType):
        return " | ".join(map(_format_type, get_args(kind)))
    if kind is type(None):
        return "None"
    return kind.__name__ if isinstance(kind, type) else str(kind).replace("typing.", "")


def make_stub() -> str:
    """Return the types of the public API: text of walkergen/__init__.pyi."""
    imports = sorted({*TYPE_IMPORTS, *(line for name in FUNCTION_NAMES for line in _report_imports(name))})
    parts = [STUB_HEADER.format(imports="\n".join(imports)), f"__all__ = {walkergen.__all__!r}\n"]
    for name in FUNCTION_NAMES:
        own = make_signature(name)
        lines = [f"    {_format_parameter(parameter)}," for parameter in own.parameters.values()]
        at = next(place for place, one in enumerate(own.parameters.values()) if one.kind is Parameter.KEYWORD_ONLY)
        lines.insert(at, "    *,")
        text = make_docstring(name)
        doc = indent(f'"""{text}\n"""' if "\n" in text else f'"""{text}"""', "    ")
        parts.append("\n".join([f"def {name}(", *lines, f") -> {own.return_annotation}:", doc, ""]))
    return "\n".join(parts)


def _format_parameter(parameter: Parameter) -> str:
    """Format a parameter for a stub."""
    default = "" if parameter.default is Parameter.empty else f" = {parameter.default!r}"
    return f"{parameter.name}: {parameter.annotation}{default}"


def _report_imports(name: str) -> list[str]:
    """Return the lines that import the reports of a function, as the module of its request does for its types."""
    request = load_request(name)
    tree = ast.parse(Path(str(getsourcefile(request))).read_text(encoding="utf-8"))
    returned = str(request.run.__annotations__["return"]).split(" | ")
    return [
        f"from {node.module} import {alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.name in returned
    ]


if __name__ == "__main__":
    print(make_stub(), end="")
