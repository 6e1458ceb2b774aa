"""The core: from a design to a part, its masses, its predicted and its simulated speed.

It imports nothing above it. `__init__.pyi` is the table of its published names: code above the core imports these from
`walkergen.core`, and each loads its module when it is first used.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any


def _read_table() -> dict[str, str]:
    """Return the name of the module that defines each published name, as listed in `__init__.pyi`."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = (statement for statement in stub.body if isinstance(statement, ast.ImportFrom))
    return {name.name: str(line.module) for line in imports for name in line.names}


_MODULES = _read_table()

__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)
