"""Write walkergen/__init__.pyi: the types of the public API, for editors and mypy."""

from inspect import Parameter
from pathlib import Path
from textwrap import indent

import walkergen
from walkergen.api.functions import FUNCTION_NAMES, first_paragraph, make_signature, report_classes
from walkergen.command_table import load_request, split_docstring

STUB_HEADER = """\
# Made of the requests by packaging/stub.py
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


def make_stub() -> str:
    """Return the types of the public API: text of walkergen/__init__.pyi."""
    reports = [kind for name in FUNCTION_NAMES for kind in report_classes(name)]
    imports = sorted({*TYPE_IMPORTS, *(f"from {kind.__module__} import {kind.__name__}" for kind in reports)})
    parts = [STUB_HEADER.format(imports="\n".join(imports)), f"__all__ = {walkergen.__all__!r}\n"]
    for name in FUNCTION_NAMES:
        own, request = make_signature(name), load_request(name)
        lines = [f"    {_format_parameter(parameter)}," for parameter in own.parameters.values()]
        at = next(place for place, one in enumerate(own.parameters.values()) if one.kind is Parameter.KEYWORD_ONLY)
        lines.insert(at, "    *,")
        doc = indent(f'"""{first_paragraph(request)}\n\n{split_docstring(request)[1]}\n"""', "    ")
        parts.append("\n".join([f"def {name}(", *lines, f") -> {own.return_annotation}:", doc, ""]))
    return "\n".join(parts)


def _format_parameter(parameter: Parameter) -> str:
    """Format a parameter for a stub."""
    default = "" if parameter.default is Parameter.empty else f" = {parameter.default!r}"
    return f"{parameter.name}: {parameter.annotation}{default}"


if __name__ == "__main__":
    Path(walkergen.__file__).with_suffix(".pyi").write_text(make_stub(), encoding="utf-8")
