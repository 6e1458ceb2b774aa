"""walkergen: from a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted.

Units inside are mm, g, s and radians. From Python, start with `import walkergen as wg` and
`wg.load("koumakis2016")`; what wg offers is in `walkergen.api`, loaded when it is first used.
"""

import sys

__version__ = "0.1.0"

_HOMES = {
    "Design": "walker.design",
    "Printer": "printing.printers",
    "Scene": "scene",
    "WalkergenError": "errors",
    "analyse": "api.analysing",
    "bench": "api.measuring",
    "calibrate": "api.measuring",
    "crowd": "api.crowding",
    "export": "api.making",
    "family": "api.making",
    "fit": "api.measuring",
    "load": "api.loading",
    "predict": "api.predicting",
    "simulate": "api.simulating",
    "sweep": "api.sweeping",
    "templates": "api.loading",
    "track": "api.tracking",
    "weigh": "api.measuring",
}
"""Modules of the names that are offered here; __init__.pyi has their types."""

__all__ = sorted(["__version__", *_HOMES])


class _Package(type(sys)):
    def __setattr__(self, name: str, value: object) -> None:
        """Keep `wg.crowd` and `wg.track` the functions when the rooms of these names are imported."""
        if not (name in _HOMES and isinstance(value, type(sys))):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> object:
    """Load a name from its module when it is first used, so that the import itself stays fast."""
    if name not in _HOMES:
        raise AttributeError(f"module 'walkergen' has no attribute {name!r}")
    from importlib import import_module

    found = getattr(import_module(f"walkergen.{_HOMES[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Names for completion in a notebook."""
    return sorted({*globals(), *_HOMES})
