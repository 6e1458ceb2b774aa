"""walkergen: from a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted.

Units inside are mm, g, s and radians. From Python, start with `import walkergen as wg` and
`wg.load("koumakis2016")`; what wg offers is in `walkergen.api`, loaded when it is first used.
"""

import sys

__version__ = "0.1.0"

_FUNCTIONS = (
    *("accuracy", "analyse", "calibrate", "check", "crowd", "explain", "export", "family", "fit"),
    *("movie", "plate", "predict", "selftest", "simulate", "sweep", "track"),
)
"""Commands that are functions here, made of the same requests; wg.templates is a table."""

_HOMES = {
    "Design": "api",
    "Printer": "core.printing.printers",
    "Scene": "core.scene",
    "WalkergenError": "core.errors",
    "load": "api.loading",
    "templates": "api.loading",
}
"""Modules of the names that are offered in addition to the functions; __init__.pyi has their types."""

__all__ = sorted(["__version__", *_HOMES, *_FUNCTIONS])


class _Package(type(sys)):
    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute. Functions such as `wg.crowd` stay when a module of the same name is imported."""
        if not (name in __all__ and isinstance(value, type(sys))):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> object:
    """Import a public name when it is first used, so that the import of walkergen stays fast."""
    if name not in __all__:
        raise AttributeError(f"module 'walkergen' has no attribute {name!r}")
    from importlib import import_module

    if name in _HOMES:
        value = getattr(import_module(f"walkergen.{_HOMES[name]}"), name)
    else:
        value = import_module("walkergen.api.functions").make_function(name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return all names of the module, for completion in a notebook."""
    return sorted({*globals(), *__all__})
