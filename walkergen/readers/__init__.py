"""Readers: bodies from drawings, letters and meshes; automatic placement of legs; marks and caps.

These are the functions that the core requires (`walker/readers.py`). Each loads its module when it is called, so that
a plain walker waits for none of them.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from walkergen.core.walker.readers import Readers

if TYPE_CHECKING:
    from walkergen.core.errors import Remedy
    from walkergen.core.shapes import joining
    from walkergen.core.shapes.mesh import Mesh
    from walkergen.core.walker.body import Body, Shape
    from walkergen.core.walker.design import Design
    from walkergen.core.walker.fittings import Cap, Marks
    from walkergen.core.walker.limbs import Legs, Limb, Polygon
    from walkergen.core.walker.mass import SolidMass


def shape_of(body: "Body") -> "Shape":
    """Return the shape of a body that is no rectangle. Raises GeometryError, and InputError for files."""
    from walkergen.readers.walkers import body_shapes

    return body_shapes.shape_of(body)


def solid_of(body_key: str) -> "joining.Body":
    """Return the solid of a body, given by its JSON, ready for the modeller."""
    from walkergen.readers.walkers import leg_attachment

    return leg_attachment.prepare_body(body_key)


def mass_of(body_key: str) -> "SolidMass":
    """Return the mass of a body, given by its JSON, at 1 g/mm^3."""
    from walkergen.readers.walkers import leg_attachment

    return leg_attachment.body_mass(body_key)


def meet_body(body_key: str, limbs: "tuple[Limb, ...]") -> "tuple[Limb, ...]":
    """Return legs that go on up to a body, given by its JSON. Raises GeometryError for those that miss it."""
    from walkergen.readers.walkers import leg_attachment

    return leg_attachment.extend_legs(body_key, limbs)


def place_legs(body_key: str, legs_key: str) -> "tuple[Limb, ...]":
    """Place legs under a body automatically. Raises UnplacedError if no place fits."""
    from walkergen.readers.walkers import leg_placement

    return leg_placement.find_placement(body_key, legs_key).limbs


def describe_placement(body_key: str, legs_key: str) -> str:
    """Describe where legs were placed under a body."""
    from walkergen.readers.walkers import leg_placement

    return leg_placement.find_placement(body_key, legs_key).words


def suggest_placement(body: "Body", legs: "Legs") -> "Sequence[Remedy]":
    """Return the remedy for legs that are unstable where they were put: automatic placement."""
    from walkergen.readers.walkers import leg_placement

    return leg_placement.auto_remedies(body, legs)


def stand_level(data: Mapping[str, Any], follow_deg: float) -> dict[str, Any]:
    """Turn the data of a design, given as built, until it is level on two feet. Raises GeometryError."""
    from walkergen.readers.walkers import stance

    return stance.level_feet(data, follow_deg)


def mark_text(marks: "Marks", tilts_deg: Sequence[float], tilt_deg: float) -> str:
    """Return the mark of the member with this tilt: digits, or its notches drawn with #."""
    from walkergen.readers.walkers.marks import format_mark

    return format_mark(marks, tilts_deg, tilt_deg)


def mark_problems(
    marks: "Marks", tilts_deg: Sequence[float], tilt_deg: float, size: tuple[float, float, float]
) -> list[str]:
    """Return reasons why a body of length, thickness and depth (mm) has no room for its marks, a line each."""
    from walkergen.readers.walkers.marks import problems

    return problems(marks, tilts_deg, tilt_deg, size)


def add_notches(design: "Design", corners: "Polygon") -> "Polygon":
    """Return the profile of a rectangular body with notches in its upper edge."""
    from walkergen.readers.walkers import engraving

    return engraving.add_notches(design, corners)


def engraved_profiles(design: "Design") -> "list[Polygon]":
    """Return the pockets in the side of a body, about its middle: its digits or its text."""
    from walkergen.readers.walkers import engraving

    return engraving.engraved_profiles(design)


def cut_letters(ground: "Mesh", design: "Design") -> "Mesh":
    """Return a body in plan view with its text cut into the upper side. Raises GeometryError."""
    from walkergen.readers.walkers import engraving

    return engraving.cut_letters(ground, design)


def put_cap(cap: "Cap", body: "Mesh", depth: float) -> "Mesh":
    """Return a cap where it lies on a body. Raises GeometryError for a body that does not hold it."""
    from walkergen.readers.walkers import caps

    return caps.place_on_body(cap, body, depth)


READERS = Readers(
    shape_of=shape_of,
    solid_of=solid_of,
    mass_of=mass_of,
    meet_body=meet_body,
    place_legs=place_legs,
    describe_placement=describe_placement,
    suggest_placement=suggest_placement,
    stand_level=stand_level,
    mark_text=mark_text,
    mark_problems=mark_problems,
    add_notches=add_notches,
    engraved_profiles=engraved_profiles,
    cut_letters=cut_letters,
    put_cap=put_cap,
)
"""The readers, as the core loads them."""
