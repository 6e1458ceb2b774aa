"""Design of a walker: all that a person chooses about it, validated once, here.

Geometry in the x-y plane with the middle of the body at the origin, y up; both legs leave the
body's bottom face at their anchors, tilted so that the feet lie behind them for tilt > 0, and the
two feet touch the plate `contact_spacing` apart, symmetric about the middle, whatever the tilt
(docs/physics.md section 1). Defaults are the paper's object.
"""

import math
from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from walkergen.errors import GeometryError
from walkergen.files.config import Name, Section, validate
from walkergen.walker.marks import Marks, problems, word

Length = Annotated[float, Field(gt=0, le=1e6)]
MassGram = Annotated[float, Field(gt=0, le=1e12)]
Tilt = Annotated[float, Field(ge=-85, le=85)]
Kind = Literal["flexible", "braced"]
KINDS: tuple[Kind, ...] = ("flexible", "braced")

Point = tuple[float, float]


class Body(Section):
    """Massive top of a walker: a rectangle in the x-y plane, extruded by its depth."""

    length_mm: Length = 28.0
    depth_mm: Length = 8.0
    thickness_mm: Length = 3.0


class Legs(Section):
    """Legs of a walker, which are alike; `kind` says which of the two thicknesses applies."""

    kind: Kind = "flexible"
    tilt_deg: Tilt = 10.0
    length_mm: Length = 7.5
    contact_spacing_mm: Length = 13.0
    flexible_thickness_mm: Length = 0.4
    thickness_sd_mm: Annotated[float, Field(ge=0, le=1e3)] = 0.02
    braced_thickness_mm: Length = 1.0
    brace_thickness_mm: Length = 0.5
    foot: Literal["square", "flat", "round"] = "flat"


class Material(Section):
    """Material that a walker is printed of, with solid infill."""

    density_g_cm3: Annotated[float, Field(gt=0, le=100)] = 1.24
    youngs_modulus_gpa: Annotated[float, Field(gt=0, le=1e4)] = 3.0
    youngs_modulus_sd_gpa: Annotated[float, Field(ge=0, le=1e4)] = 0.35


class Weighed(Section):
    """Masses from a balance, which override the mesh's, and the spread of masses."""

    body_mass_g: MassGram | None = None
    leg_mass_g: MassGram | None = None
    mass_sd_percent: Annotated[float, Field(ge=0, le=50)] = 2.0


class Family(Section):
    """Members that `walkergen family` makes when the command line does not say which."""

    tilt_deg: Annotated[list[Tilt], Field(min_length=1, max_length=1000)] = Field(
        default_factory=lambda: [float(tilt) for tilt in range(0, 50, 5)]
    )
    legs: Annotated[list[Kind], Field(min_length=1, max_length=2)] = Field(
        default_factory=lambda: list(KINDS)
    )

    @field_validator("tilt_deg", "legs")
    @classmethod
    def _no_repeats(cls, values: list[Any]) -> list[Any]:
        return list(dict.fromkeys(values))


class Design(Section):
    """Design of a walker. Construction raises GeometryError for parts that cannot be built."""

    name: Name = "walker"
    description: Annotated[str, Field(max_length=2000)] = ""
    body: Body = Body()
    legs: Legs = Legs()
    material: Material = Material()
    weighed: Weighed = Weighed()
    marks: Marks = Marks()
    family: Family = Family()

    @model_validator(mode="after")
    def _buildable(self) -> "Design":
        if problems := _problems(self):
            raise GeometryError("\n".join(problems))
        return self

    @property
    def braced(self) -> bool:
        """True when a brace makes the legs rigid."""
        return self.legs.kind == "braced"

    @property
    def tilt(self) -> float:
        """Tilt of the legs from the vertical, rad; feet behind their anchors when positive."""
        return math.radians(self.legs.tilt_deg)

    @property
    def leg_thickness(self) -> float:
        """Thickness of a leg across its centre line, mm."""
        return self.legs.braced_thickness_mm if self.braced else self.legs.flexible_thickness_mm

    @property
    def anchor_to_foot(self) -> Point:
        """Vector from an anchor (centre line on the bottom face) to where the leg touches, in mm.

        Flat foot (cut parallel to the plate): the middle of the cut. Square (cut across the leg):
        its lower corner. Round (a half circle): the lowest point of the arc. The centre line from
        anchor to end has the leg's length in every case.
        """
        sin, cos = math.sin(self.tilt), math.cos(self.tilt)
        length, half = self.legs.length_mm, 0.5 * self.leg_thickness
        if self.legs.foot == "round":
            return -(length - half) * sin, -(length - half) * cos - half
        if self.legs.foot == "square" and self.tilt != 0.0:
            side = math.copysign(half, self.tilt)
            return -length * sin + side * cos, -length * cos - side * sin
        return -length * sin, -length * cos

    @property
    def brace_offset(self) -> float:
        """Distance along x from an anchor to the middle of its brace, which is on the foot, mm."""
        sin = math.sin(self.tilt)
        if self.legs.foot == "round":
            return -(self.legs.length_mm - 0.5 * self.leg_thickness) * sin
        return -self.legs.length_mm * sin

    @property
    def anchors(self) -> tuple[Point, Point]:
        """Back and front anchors on the body's bottom face, from the middle of the body, mm."""
        half_spacing = 0.5 * self.legs.contact_spacing_mm
        shift = -self.anchor_to_foot[0]
        bottom = -0.5 * self.body.thickness_mm
        return (shift - half_spacing, bottom), (shift + half_spacing, bottom)

    def variant(self, *, tilt_deg: float | None = None, kind: Kind | None = None) -> "Design":
        """Design with another tilt or kind of legs. Raises InputError or GeometryError."""
        changes = {"tilt_deg": tilt_deg, "kind": kind}
        data = self.model_dump()
        data["legs"] |= {key: value for key, value in changes.items() if value is not None}
        return validate(data, Design, self.name)

    def members(
        self, tilts_deg: Iterable[float] | None = None, kinds: Iterable[Kind] | None = None
    ) -> list["Design"]:
        """Variants of a family, kinds outermost; by default those of its [family] table.

        Raises GeometryError, with the limit that was exceeded, if any member cannot be built.
        """
        tilts = list(self.family.tilt_deg if tilts_deg is None else tilts_deg)
        chosen = list(self.family.legs if kinds is None else kinds)
        if self.weighed.leg_mass_g is not None and chosen != [self.legs.kind]:
            raise GeometryError(
                f"{self.name}: weighed.leg_mass_g is the mass of a {self.legs.kind} leg; "
                f"make one kind only (--legs {self.legs.kind}) or remove the key"
            )
        found: list[Design] = []
        problems: list[str] = []
        for kind in chosen:
            for tilt in tilts:
                try:
                    found.append(self.variant(tilt_deg=tilt, kind=kind))
                except GeometryError as error:
                    problems.append(str(error))
        if problems:
            raise GeometryError("\n".join(problems))
        return found

    @property
    def mark(self) -> str:
        """Mark that the part shows: its tilt in digits, its notches drawn with #, or nothing."""
        return word(self.marks, self.family.tilt_deg, self.legs.tilt_deg)

    @property
    def unmarked(self) -> "Design":
        """Design without marks, otherwise the same."""
        return self.model_copy(update={"marks": Marks()})


def _problems(design: Design) -> list[str]:
    """Problems that keep a design from being built, a line each, with the limit passed."""
    found = []
    for text in _impossible(design, design.legs.tilt_deg):
        limit = _largest_tilt(design)
        hint = f"; tilt up to {limit:.2f} deg is possible" if limit is not None else ""
        found.append(f"legs.tilt_deg = {design.legs.tilt_deg:g} ({design.legs.kind}): {text}{hint}")
    body = design.body
    size = body.length_mm, body.thickness_mm, body.depth_mm
    return found + problems(design.marks, design.family.tilt_deg, design.legs.tilt_deg, size)


def _impossible(design: Design, tilt_deg: float) -> list[str]:
    """Problems of body, legs and braces at a tilt in deg, whatever the design's own tilt is."""
    legs, body = design.legs, design.body
    thickness = design.leg_thickness
    trial = design.model_copy(update={"legs": legs.model_copy(update={"tilt_deg": tilt_deg})})
    tilt = abs(math.radians(tilt_deg))
    half_width = 0.5 * thickness / math.cos(tilt)  # half the width of a leg along the bottom face
    found = []

    end = {"flat": 0.0, "square": 0.0, "round": 0.5 * thickness}[legs.foot]
    shortest_side = legs.length_mm - end
    if legs.foot != "flat":
        shortest_side -= 0.5 * thickness * math.tan(tilt)
    if shortest_side <= 0:
        found.append(
            f"the leg ({thickness:g} mm thick, {legs.length_mm:g} mm long) has no side left: "
            "make it longer, thinner, or its foot flat"
        )

    half_body = 0.5 * body.length_mm
    back, front = (anchor[0] for anchor in trial.anchors)
    reach = max(abs(back), abs(front)) + half_width
    if reach > half_body:
        found.append(
            f"a leg leaves the body: it reaches x = {reach:.3f} mm, the body ends at "
            f"{half_body:.3f} mm: lengthen the body, or shorten legs or contact spacing"
        )

    if thickness / math.cos(tilt) >= legs.contact_spacing_mm:
        found.append(
            f"the legs run into each other: each is {thickness / math.cos(tilt):.3f} mm wide along "
            f"the plate, the contact spacing is {legs.contact_spacing_mm:g} mm"
        )
    if design.braced:
        found += _impossible_brace(trial, tilt, half_width, half_body)
    return found


def _impossible_brace(trial: Design, tilt: float, half_width: float, half_body: float) -> list[str]:
    """Problems of the braces at the trial's tilt, here in rad and without sign; widths in mm."""
    legs = trial.legs
    brace = legs.brace_thickness_mm
    found = []
    foot_width = legs.braced_thickness_mm * {
        "flat": 1.0 / math.cos(tilt), "square": math.cos(tilt), "round": 1.0
    }[legs.foot]  # fmt: skip
    if brace > foot_width:
        found.append(
            f"the brace ({brace:g} mm) is thicker than the foot it stands on ({foot_width:.3f} mm)"
        )
    brace_x = abs(trial.brace_offset)
    if brace_x + half_width + 0.5 * brace >= legs.contact_spacing_mm:
        found.append(
            f"a leg crosses the other leg's brace: it spans {brace_x:.3f} mm, the contact spacing "
            f"is {legs.contact_spacing_mm:g} mm"
        )
    reach = max(abs(anchor[0] + trial.brace_offset) for anchor in trial.anchors) + 0.5 * brace
    if reach > half_body:
        found.append(
            f"a brace leaves the body: it reaches x = {reach:.3f} mm, the body ends at "
            f"{half_body:.3f} mm"
        )
    return found


def _largest_tilt(design: Design) -> float | None:
    """Largest tilt (deg, same sign) without any problem, by bisection; None when tilt 0 has one."""
    if _impossible(design, 0.0):
        return None
    good, bad = 0.0, design.legs.tilt_deg
    for _ in range(40):
        middle = 0.5 * (good + bad)
        good, bad = (good, middle) if _impossible(design, middle) else (middle, bad)
    return math.copysign(math.floor(abs(good) * 100) / 100, good)
