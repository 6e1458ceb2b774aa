"""Readers: bodies from drawings, letters and meshes; automatic placement of legs; marks and caps.

These are the functions that the core requires (`Readers` in `walkergen/core/walker/resolve.py`). Each loads its module
when it is first used, so that a walker with a plain body loads none of them.
"""

from importlib import import_module
from typing import Any

_FUNCTIONS = {
    "body_shapes": ("shape_of",),
    "caps": ("place_on_body",),
    "engraving": ("add_notches", "cut_letters", "engraved_profiles"),
    "leg_attachment": ("body_mass", "extend_legs", "prepare_body"),
    "leg_placement": ("find_placement",),
    "own_legs": ("use_own_legs",),
    "marks": ("format_mark", "mark_problems"),
    "stance": ("level_feet",),
}


def __getattr__(name: str) -> Any:
    """Return a function of `_FUNCTIONS` by name. Its module is loaded when the function is first used."""
    for module, functions in _FUNCTIONS.items():
        if name in functions:
            return getattr(import_module(f"{__name__}.walkers.{module}"), name)
    raise AttributeError(f"module {__name__} has no attribute {name!r}")
