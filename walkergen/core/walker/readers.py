"""Functions of `walkergen.readers` for walkers other than the paper's: shapes from files, places for legs, marks, caps.

The core runs alone for a body that is a plain rectangle. The readers stand above it and import it; they are loaded
when a design first asks for one of them.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.core.errors import Remedy
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.body import Body, Shape
from walkergen.core.walker.fittings import Cap, Marks
from walkergen.core.walker.limbs import Legs, Limb, Polygon
from walkergen.core.walker.mass import SolidMass

if TYPE_CHECKING:
    from walkergen.core.shapes import joining


class Readers(NamedTuple):
    """Functions of `walkergen.readers`, with their arguments and results; their docstrings are there.

    A str for a body or legs is their JSON, the key for caching results. `Any` is a `Design`.
    """

    shape_of: Callable[[Body], Shape]
    solid_of: "Callable[[str], joining.Body]"
    mass_of: Callable[[str], SolidMass]
    meet_body: Callable[[str, tuple[Limb, ...]], tuple[Limb, ...]]
    place_legs: Callable[[str, str], tuple[Limb, ...]]
    describe_placement: Callable[[str, str], str]
    suggest_placement: Callable[[Body, Legs], Sequence[Remedy]]
    stand_level: Callable[[Mapping[str, Any], float], dict[str, Any]]
    mark_text: Callable[[Marks, Sequence[float], float], str]
    mark_problems: Callable[[Marks, Sequence[float], float, tuple[float, float, float]], list[str]]
    add_notches: Callable[[Any, Polygon], Polygon]
    engraved_profiles: Callable[[Any], list[Polygon]]
    cut_letters: Callable[[Mesh, Any], Mesh]
    put_cap: Callable[[Cap, Mesh, float], Mesh]


def load_readers() -> Readers:
    """Load the readers."""
    readers: Readers = import_module("walkergen.readers").READERS
    return readers
