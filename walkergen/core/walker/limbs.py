"""Legs of a walker: their keys, and every leg resolved to numbers.

There are two forms: [legs] for two equal legs, or [[legs]], a list of legs with their own tilt, thickness, position and
material. Frame: the middle of the body at the origin, x along the run, y up, z across; a leg leaves the body's
underside at its anchor, and its foot lies behind the anchor for tilt > 0.
"""

import math
from collections.abc import Mapping
from operator import not_
from typing import Annotated, ClassVar, Literal, NamedTuple, get_args

from pydantic import Field

from walkergen.core.files.config import Fraction, Friction, Section
from walkergen.core.numerics import Array

MIN_LENGTH_MM, MAX_LENGTH_MM = 1e-6, 1e6
Length = Annotated[float, Field(ge=MIN_LENGTH_MM, le=MAX_LENGTH_MM)]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Tilt = Annotated[float, Field(ge=-85, le=85)]
Kind = Literal["flexible", "braced"]
KINDS: tuple[Kind, ...] = get_args(Kind)
RIGID_KINDS: tuple[Kind, ...] = ("braced",)
"""Kinds of legs that are part of the body: they neither bend nor twist."""

FootKind = Literal["square", "flat", "round"]

MAX_LEGS = 64
"""Largest number of legs of a walker."""

Point = tuple[float, float]
Polygon = Array


class Legs(Section):
    """Two equal legs; `kind` selects one of the two thicknesses."""

    removed_keys: ClassVar[Mapping[str, str]] = {"place": "Write placement = 'auto' or 'given'."}

    kind: Kind = "flexible"
    tilt_deg: Tilt = 10.0
    length_mm: Length = 7.5
    placement: Literal["auto", "given"] | None = Field(default=None, exclude_if=not_)
    """Whether legs are placed automatically, or as contact_spacing_mm and width_mm define. None: automatically, for a
    body in plan view or a mesh if neither key is set."""
    contact_spacing_mm: Length = 13.0
    width_mm: Length | None = None
    """Width across the run. None: the depth of the body."""
    flexible_thickness_mm: Length = 0.4
    thickness_sd_mm: Annotated[float, Field(ge=0, le=1e3)] = 0.02
    braced_thickness_mm: Length = 1.0
    brace_thickness_mm: Length = 0.5
    foot: FootKind = "flat"

    @property
    def thickness_mm(self) -> float:
        """Thickness that applies to the kind of legs."""
        thickness: float = getattr(self, f"{self.kind}_thickness_mm")
        return thickness


class Leg(Section):
    """One leg of a list."""

    kind: Kind = "flexible"
    tilt_deg: Tilt | None = None
    """Tilt of this leg, deg. None: the family tilt (the design's leg_tilt_deg)."""
    mirrored: bool = False
    """Whether the leg leans the other way, with minus its tilt."""
    length_mm: Length = 7.5
    thickness_mm: Length | None = None
    """Thickness. None: 0.4 mm for a flexible leg, 1 mm for a braced one, as in [legs]."""
    thickness_sd_mm: Annotated[float, Field(ge=0, le=1e3)] = 0.02
    brace_thickness_mm: Length = 0.5
    foot: FootKind = "flat"
    along_mm: Coordinate
    """Position of its foot along the body, from the middle, mm, at any tilt."""
    across_mm: Coordinate = 0.0
    """Position of its middle across the body, mm."""
    width_mm: Length | None = None
    """Width across the run. None: the depth of the body."""
    friction: Friction | None = None
    """Friction of a foot of another material than the scene's contact. None: that of the scene."""
    restitution: Fraction | None = None
    """Restitution of its foot. None: that of the scene."""


class Limb(NamedTuple):
    """Leg with all its numbers; lengths in mm."""

    kind: Kind
    tilt: float
    """Tilt from the vertical, rad; the foot lies behind the anchor when positive."""
    length: float
    """Length of the centre line from the underside of the body to the end of the leg."""
    thickness: float
    thickness_sd: float
    """Standard deviation of the thickness from print to print."""
    brace: float
    """Thickness of the brace, which only braced legs have."""
    foot: FootKind
    along: float
    """Position of the foot along the body."""
    across: float
    """Position of the leg's middle across the body."""
    width: float
    """Width across the run."""
    bottom: float
    """Height of its anchor, on the underside of the body, y <= 0."""
    embedding: float
    """Height of the leg inside the body."""
    friction: float | None
    restitution: float | None

    @property
    def rigid(self) -> bool:
        """Whether the leg neither bends nor twists, as a braced leg."""
        return self.kind in RIGID_KINDS

    @property
    def anchor_to_foot(self) -> Point:
        """Vector from the anchor (centre line on the underside) to the point that touches the plate, mm.

        Flat foot (cut parallel to the plate): the middle of the cut. Square (cut across the leg):
        its lower corner. Round (a half circle): the lowest point of the arc. The centre line from
        anchor to end has the leg's length in every case.
        """
        sin, cos = math.sin(self.tilt), math.cos(self.tilt)
        length, half = self.length, 0.5 * self.thickness
        if self.foot == "round":
            return -(length - half) * sin, -(length - half) * cos - half
        if self.foot == "square" and self.tilt != 0.0:
            side = math.copysign(half, self.tilt)
            return -length * sin + side * cos, -length * cos - side * sin
        return -length * sin, -length * cos

    @property
    def anchor(self) -> Point:
        """Anchor on the underside of the body, x and y from the middle of the body, mm."""
        return -self.anchor_to_foot[0] + self.along, self.bottom

    @property
    def half_width(self) -> float:
        """Half the width of the leg along the underside, mm."""
        return 0.5 * self.thickness / math.cos(abs(self.tilt))

    @property
    def foot_height(self) -> float:
        """Height of the foot, from the middle of the body, mm."""
        return self.bottom + self.anchor_to_foot[1]


class Strut(NamedTuple):
    """Upright support of a leg, from its foot to the underside, as wide as the leg."""

    offset: float
    """Position of its middle along the run, from the anchor, mm."""
    thickness: float
    """Thickness along the run, mm."""


def embedding_height(bottom: float) -> float:
    """Return how far legs reach up into a body, mm: a quarter of its thickness, so that leg and body overlap.

    `bottom` is the height of the body's flat underside from its middle, mm, and negative.
    """
    return -0.5 * bottom


def resolve_pair(legs: Legs, depth: float, bottom: float) -> tuple[Limb, ...]:
    """Return two equal legs, back and front, on a body `depth` mm deep with its underside at height `bottom`, mm."""
    half = 0.5 * legs.contact_spacing_mm
    return tuple(_make_limb(legs, legs.tilt_deg, legs.thickness_mm, along, depth, bottom) for along in (-half, half))


def resolve_leg(leg: Leg, default_tilt_deg: float, depth: float, bottom: float) -> Limb:
    """Return a leg of a list, on a body `depth` mm deep with its underside at height `bottom`, mm.

    Parameters
    ----------
    leg : Leg
        Keys of the leg.
    default_tilt_deg : float
        Tilt of a leg whose keys set none, degrees.
    depth : float
        Depth of the body, mm.
    bottom : float
        Height of the body's underside from its middle, mm.
    """
    tilt = default_tilt_deg if leg.tilt_deg is None else leg.tilt_deg
    thickness = leg.thickness_mm or Legs(kind=leg.kind).thickness_mm
    limb = _make_limb(leg, 0.0 - tilt if leg.mirrored else tilt, thickness, leg.along_mm, depth, bottom)
    return limb._replace(across=leg.across_mm, friction=leg.friction, restitution=leg.restitution)


def _make_limb(keys: Legs | Leg, tilt_deg: float, thickness: float, along: float, depth: float, bottom: float) -> Limb:
    """Return a leg with its foot `along` mm from the body's middle. The other arguments are as in `resolve_leg`."""
    return Limb(
        kind=keys.kind,
        tilt=math.radians(tilt_deg),
        length=keys.length_mm,
        thickness=thickness,
        thickness_sd=keys.thickness_sd_mm,
        brace=keys.brace_thickness_mm,
        foot=keys.foot,
        along=along,
        across=0.0,
        width=keys.width_mm or depth,
        bottom=bottom,
        embedding=embedding_height(bottom),
        friction=None,
        restitution=None,
    )
