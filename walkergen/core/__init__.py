"""The core: from a design to a part, its masses, its predicted and its simulated speed.

It imports nothing above it. Its nouns and verbs stand here, in the order of docs/story.md; each loads its module when
it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from walkergen.core.numerics.quantity import Quantity
    from walkergen.core.printing.printers import Printer
    from walkergen.core.scene import Scene
    from walkergen.core.simulation.plan import prepare
    from walkergen.core.simulation.run import simulate
    from walkergen.core.theory.prediction import predict
    from walkergen.core.walker.design import Design
    from walkergen.core.walker.solids import build, mass_of

__all__ = ["Design", "Printer", "Quantity", "Scene", "build", "mass_of", "predict", "prepare", "simulate"]

_MODULES = {
    "Quantity": "numerics.quantity",
    "Design": "walker.design",
    "Scene": "scene",
    "build": "walker.solids",
    "mass_of": "walker.solids",
    "predict": "theory.prediction",
    "prepare": "simulation.plan",
    "simulate": "simulation.run",
    "Printer": "printing.printers",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
