"""Design of a walker: all that a person chooses about it, validated once, here.

Geometry in the x-y plane with the middle of the body at the origin, y up; all legs leave the
body's bottom face at their anchors, tilted so that the feet lie behind them for tilt > 0. The two
equal legs of [legs] touch the plate `contact_spacing` apart, symmetric about the middle, whatever
the tilt (docs/physics.md section 1); those of [[legs]] stand where they are put. Defaults are the
paper's object.
"""

import copy
import hashlib
import math
import os
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from operator import not_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, SerializeAsAny, Tag, ValidationInfo, field_validator, model_validator

from walkergen.errors import GeometryError, InputError, Remedy
from walkergen.files.assignments import changed
from walkergen.files.config import Name, Section, validate
from walkergen.walker import buildable
from walkergen.walker.body import DRAWN, SOURCES, Body, Size, located
from walkergen.walker.fittings import Battery, Cap, Marks, Motor, Part, Pockets, place_problems
from walkergen.walker.limbs import KINDS, MOST_LEGS, Kind, Leg, Legs, Limb, Tilt, limb_of, pair_of
from walkergen.walker.material import Material, Weighed

if TYPE_CHECKING:
    from walkergen.walker.placing import Placement


class Family(Section):
    """Members that `walkergen family` makes when the command line does not say which."""

    tilt_deg: Annotated[list[Tilt], Field(min_length=1, max_length=10_000)] = Field(
        default_factory=lambda: [float(tilt) for tilt in range(0, 50, 5)]
    )
    legs: Annotated[list[Kind], Field(min_length=1, max_length=2)] = Field(default_factory=lambda: list(KINDS))

    @field_validator("tilt_deg", "legs")
    @classmethod
    def _no_repeats(cls, values: list[Any]) -> list[Any]:
        return list(dict.fromkeys(values))


OUTLINES, MESHES = (".svg", ".dxf", ".png", ".jpg", ".jpeg"), (".stl", ".obj", ".ply", ".off", ".3mf", ".glb")
"""Endings of files that stand for a walker by themselves, as the shape of its body."""

CAD = (".step", ".stp", ".iges", ".igs", ".f3d", ".scad", ".fcstd", ".blend")
"""Endings of files of programs that save meshes too."""

STORY = {"tilt_deg": [0.0, 5.0, 10.0, 15.0, 20.0], "legs": ["flexible"]}
"""Family of a shape that says nothing of its own."""

PLACES = ("contact_spacing_mm", "width_mm")
"""Keys that say where two equal legs stand."""

SHORT = {"tilt": "tilt_deg", "text": "body.text", "mirror": "body.mirror"}
"""Keys, by the words of commands for them."""

FOLLOWED = 10.0
"""Tilt, deg, of legs that give none, unless the design gives one."""


class Design(Section):
    """Design of a walker. Construction raises GeometryError for parts that cannot be built."""

    @model_validator(mode="before")
    @classmethod
    def _stood(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        data = _one_body(data)
        if data.get("stance") != "as built":
            return data
        from walkergen.walker import stance

        follow = data.get("leg_tilt_deg")
        return stance.level(data, FOLLOWED if follow is None else follow)

    @classmethod
    def of_file(cls, path: Path) -> dict[str, Any] | None:
        """Data of a walker whose body is a drawing, a picture or a mesh. Raises InputError for files of CAD."""
        key = {"outline": OUTLINES, "mesh": MESHES}
        ending = path.suffix.lower()
        if ending in CAD:
            raise InputError(f"{path}: save it as a mesh in the program that made it: Export, STL (or 3MF), in mm")
        source = next((name for name, endings in key.items() if ending in endings), None)
        return None if source is None else {"name": named(path.stem), "body": {source: path.name}, "family": STORY}

    @classmethod
    def of_text(cls, text: str) -> "Design":
        """Walker whose body is a text. Raises GeometryError for letters that cannot be drawn."""
        return validate({"name": named(text), "body": {"text": text}, "family": STORY}, cls, f"text {text[:40]!r}")

    def settled(self, data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """Data in which a new shape of the body takes away what followed from the former.

        So do the places of two equal legs, which are found anew, masses and marks of the former, and the family: legs
        that were found do not stand at every tilt. What is set beside it stays.
        """
        body = data.get("body")
        former = {key: getattr(self.body, key) for key in SOURCES}
        source = next((key for key in SOURCES if values.get(f"body.{key}", former[key]) != former[key]), None)
        if not isinstance(body, dict) or (source is None and "body" not in values):
            return data
        if source is not None:
            data["body"] = Body.reshaped(body, source, self.body, values)
            if source != "profile_mm" and not any(key.partition(".")[0] == "family" for key in values):
                data["family"] = copy.deepcopy(STORY)
            if "name" not in values:
                data["name"] = named(Path(str(values[f"body.{source}"])).stem)
                data.pop("description", None)
        if source != "profile_mm" and not any(key.partition("[")[0] == "legs" for key in values):
            data["legs"] = self._unplaced(data.get("legs", {}), data["body"].get("outline") in DRAWN, values)
            if isinstance(data["legs"], dict):
                data.pop("leg_tilt_deg", None)
        for table in ("weighed", *(["marks"] if self.body.plain else [])):
            if not any(key.partition(".")[0] == table for key in values):
                data.pop(table, None)
        return data

    @classmethod
    def located(cls, data: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Data of a file, the files that it names found from its folder."""
        own = dict(data)
        for table in ("body", "walker"):
            if table in own:
                own[table] = located(own[table], folder)
        return own

    def _unplaced(self, legs: Any, drawn: bool, values: Mapping[str, Any]) -> Any:
        """Legs of a body that gets another shape, without their places; those of a list become two equal ones.

        Under outlines that need no file, `drawn`, a list stays.
        """
        if isinstance(legs, Mapping):
            return {key: value for key, value in legs.items() if key not in PLACES or f"legs.{key}" in values}
        first = self.limbs[0]
        own = {
            "kind": self.kind,
            "tilt_deg": self.tilt_deg,
            "length_mm": legs[0].get("length_mm", 7.5),
            "foot": first.foot,
        }
        return legs if drawn else own | {f"{self.kind}_thickness_mm": first.thickness}

    name: Name = "walker"
    description: Annotated[str, Field(max_length=2000)] = ""
    stance: Literal["level", "as built"] = "level"
    """Stance at rest: level, or turned until the feet of unlike legs are level."""
    body: Body = Body()
    legs: Annotated[
        Annotated[Legs, Tag("table")]
        | Annotated[Annotated[list[Leg], Field(min_length=1, max_length=MOST_LEGS)], Tag("list")],
        Discriminator(lambda legs: "list" if isinstance(legs, list) else "table"),
        SerializeAsAny(),  # a Ctrl-C that arrives while the discriminator serializes is lost
    ] = Legs()
    leg_tilt_deg: Tilt | None = None
    """Tilt of those legs of a list that give none of their own; None: 10 deg."""
    material: Material = Material()
    weighed: Weighed = Weighed()
    marks: Marks = Marks()
    motor: Motor | None = Field(default=None, exclude_if=not_)
    """Motor that the body carries. None: none, and its data are as if there were no such key."""
    battery: Battery | None = Field(default=None, exclude_if=not_)
    pockets: Pockets | None = Field(default=None, exclude_if=not_)
    """Pockets of motor and battery. None: `fit`, the usual ones."""
    cap: Cap | None = Field(default=None, exclude_if=not_)
    """Cap with a marker. None: none, and its data are as if there were no such key."""
    family: Family = Family()

    @field_validator("leg_tilt_deg")
    @classmethod
    def _of_a_list(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is not None and isinstance(info.data.get("legs"), Legs):
            raise ValueError("it is for a list [[legs]]; two equal legs have legs.tilt_deg")
        return value

    @model_validator(mode="after")
    def _buildable(self) -> "Design":
        if isinstance(self.legs, Legs) and not self.placed:
            faults = [] if self.whole else buildable.of_pair(self.legs, self.size)
        else:
            faults = buildable.of_list(self.limbs, self.size)
        if not faults and self.body.flat:
            faults = buildable.off_outline(self.limbs, self.body.shape)
        helps = self._legs_elsewhere if faults else tuple
        if not self.marks.blank:
            faults += self._unmarkable()
        if not faults and self.parts:
            foot = min(limb.foot_height for limb in self.limbs)
            faults = place_problems(self.parts, self.fit, self.size, foot)
        if self.pockets is not None and not self.parts:
            faults.append(
                "pockets = ...: are of a motor or a battery: add a table [motor] or [battery], or leave them out"
            )
        if faults:
            raise GeometryError("\n".join(faults), helps=helps)
        return self

    def _legs_elsewhere(self) -> Sequence[Remedy]:
        """What helps two equal legs that do not stand where they were put: that they place themselves."""
        if not isinstance(self.legs, Legs) or self.placed or self.whole:
            return []
        from walkergen.walker import placing

        return placing.auto(self.body, self.legs)

    def _unmarkable(self) -> list[str]:
        """Reasons why the body cannot bear its marks, one line each."""
        from walkergen.walker.marks import problems

        marks, (length, thickness, depth) = self.marks, self.size
        if self.letters and self.body.flat:  # letters on a body in plan view go into its upper side
            marks, thickness, depth = marks.model_copy(update={"kind": "text"}), depth, thickness
        unfit = problems(marks, self.family.tilt_deg, self.tilt_deg, (length, thickness, depth))
        if self.body.plain or (self.letters and self.body.flat):
            return unfit
        key = f"marks.serial = {marks.serial}" if marks.kind == "none" else f"marks.kind = {marks.kind!r}"
        rule = "only a rectangular body in side view bears marks, and a body in plan view text: leave them out"
        return [f"{key}: {rule}", *unfit]

    @property
    def size(self) -> Size:
        """Extent of the body along the run, upward and across, mm."""
        return self.body.shape.size

    @cached_property
    def limbs(self) -> tuple[Limb, ...]:
        """Every leg with all its numbers, in the order of the file; of two equal: back, front.

        Raises GeometryError for a leg that does not meet the body.
        """
        shape = self.body.shape
        if shape.whole is not None:
            from walkergen.walker import whole_mesh

            assert isinstance(self.legs, Legs)
            return tuple(
                whole_mesh.limb_of(leg, self.legs.kind, number, shape.size.depth)
                for number, leg in enumerate(shape.whole.legs, start=1)
            )
        depth, bottom = shape.size.depth, -0.5 * shape.size.thickness
        if isinstance(self.legs, Legs) and self.placed:
            return self._placement.limbs
        if isinstance(self.legs, Legs):
            limbs = pair_of(self.legs, depth, bottom)
        else:
            limbs = tuple(limb_of(leg, self._followed, depth, bottom) for leg in self.legs)
        if self.body.plain or self.body.flat:
            return limbs
        from walkergen.walker import landing

        return landing.landed(self.body.key, limbs)

    def __copy__(self) -> Self:
        copy = super().__copy__()
        copy.__dict__.pop("limbs", None)  # of `model_copy`, which may change what they follow from
        return copy

    @property
    def parts(self) -> dict[str, Part]:
        """Parts that the body carries, motor and battery, by the names of their tables."""
        parts = {"motor": self.motor, "battery": self.battery}
        return {name: part for name, part in parts.items() if part is not None}

    def driving_motor(self) -> Motor:
        """Motor that drives it. Raises InputError where it carries none."""
        if self.motor is None:
            raise InputError(
                f"drive.kind = 'motor': {self.name} carries none; give its design a table [motor] "
                "with diameter_mm, height_mm and mass_g, or take the template coinbot"
            )
        return self.motor

    @property
    def fit(self) -> Pockets:
        """Pockets that hold its parts, with clearance, wires and glue."""
        return self.pockets or Pockets()

    @property
    def kind(self) -> Kind:
        """Kind of legs: that of the first that is not rigid, or of the first."""
        limbs = self.limbs
        return next((limb.kind for limb in limbs if not limb.rigid), limbs[0].kind)

    @property
    def tilt_deg(self) -> float:
        """Tilt by which members of a family are told apart, deg: of all legs that follow it, or of
        the first leg.
        """
        if self.whole:
            return round(math.degrees(self.limbs[0].tilt), 2) + 0.0
        if isinstance(self.legs, Legs):
            return self.legs.tilt_deg
        first = self.legs[0]
        if self.follows or first.tilt_deg is None:
            return self._followed
        return 0.0 - first.tilt_deg if first.mirrored else first.tilt_deg

    @property
    def _followed(self) -> float:
        """Tilt of those legs of a list that give none of their own, deg."""
        return FOLLOWED if self.leg_tilt_deg is None else self.leg_tilt_deg

    @property
    def follows(self) -> bool:
        """True when a leg has the family's tilt."""
        if isinstance(self.legs, Legs):
            return not self.whole
        return any(leg.tilt_deg is None for leg in self.legs)

    @property
    def rigid(self) -> bool:
        """True when all legs are rigid, as braced ones are."""
        return all(limb.rigid for limb in self.limbs)

    @property
    def pair(self) -> bool:
        """True for two equal legs by the short form, [legs]."""
        return isinstance(self.legs, Legs) and not self.whole

    @property
    def placed(self) -> bool:
        """True for legs that are found for the body (`placing`)."""
        if not isinstance(self.legs, Legs) or self.whole:
            return False
        shaped = self.body.flat or self.body.mesh is not None
        written = self.legs.model_fields_set & set(PLACES)
        return self.legs.place == "auto" or (self.legs.place is None and shaped and not written)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was made of the body's file, and the legs that were found for it, a line each."""
        notes = [f"{self.name}: {'; '.join(changes)}"] if (changes := self.body.shape.changes) else []
        return (*notes, f"{self.name}: {self._placement.words}") if self.placed else tuple(notes)

    @property
    def _placement(self) -> "Placement":
        from walkergen.walker import placing

        return placing.placed(self.body.key, self.legs.model_dump_json())  # type: ignore[union-attr]

    def numbered(self) -> "Design":
        """Design whose legs that were found stand where they are by numbers, from which a person can go on."""
        if not isinstance(self.legs, Legs) or not self.placed:
            return self
        data, legs = self.model_dump(exclude_unset=True), self.legs.model_dump(exclude_unset=True)
        first, size = self.limbs[0], self.size
        if self.alike:
            own = {"place": "given", "contact_spacing_mm": self.foot_span, "width_mm": first.width}
            return validate(data | {"legs": legs | own}, Design, self.name)
        own = {key: legs[key] for key in ("kind", "length_mm", "brace_thickness_mm", "foot") if key in legs}
        own |= {"thickness_mm": self.legs.thickness_mm, "thickness_sd_mm": self.legs.thickness_sd_mm}
        listed = [
            own | {"along_mm": limb.along, "across_mm": limb.across, "width_mm": min(limb.width, size.depth)}
            for limb in self.limbs
        ]
        family = {"family": data.get("family", {}) | {"legs": [self.kind]}}
        return validate(data | {"leg_tilt_deg": self.tilt_deg, "legs": listed} | family, Design, self.name)

    def moved(self, folder: Path) -> "Design":
        """Design as a file in a folder has it: files of the body by their way from there."""
        files = {key: getattr(self.body, key) for key in ("outline", "mesh", "font")}
        ways = {
            key: Path(os.path.relpath(name, folder)).as_posix()
            for key, name in files.items()
            if name is not None and name not in DRAWN
        }
        return self.model_copy(update={"body": self.body.model_copy(update=ways)})

    @property
    def whole(self) -> bool:
        """True for a finished walker's mesh, cut into body and legs."""
        return self.body.legs_below_mm is not None

    @property
    def alike(self) -> bool:
        """True for two equal legs at equal distances from the middle, as the paper's."""
        if self.pair and not self.placed:
            return True
        if len(self.limbs) != 2:
            return False
        first, second = self.limbs
        image = second._replace(along=0.0 - second.along)
        own = first.friction is not None or first.restitution is not None
        return first == image and first.across == 0.0 and not own

    @property
    def symmetric(self) -> bool:
        """True when the legs are their own mirror image across the run, left and right."""
        legs = sorted(self.limbs, key=lambda limb: (limb.along, limb.tilt, limb.across))
        image = [limb._replace(across=0.0 - limb.across) for limb in self.limbs]
        return legs == sorted(image, key=lambda limb: (limb.along, limb.tilt, limb.across))

    @property
    def foot_span(self) -> float:
        """Distance along the run from the last foot to the first, mm."""
        places = [limb.along for limb in self.limbs]
        return max(places) - min(places)

    def variant(self, *, tilt_deg: float | None = None, kind: Kind | None = None, **keys: Any) -> "Design":
        """Design with another tilt or kind of legs, or with other values of any keys.

        Keys are those of the file, dotted, and the words of the commands: `tilt` is `tilt_deg`, `legs="braced"` is
        `kind`, `text` and `mirror` are the body's. Everything is validated together, as the file's lines are, unlike
        by pydantic's `model_copy`. Legs of a list keep their kinds, and follow the tilt where they have none of their
        own. Raises InputError or GeometryError, a line for every mistake.

        Example: `wg.load("koumakis2016").variant(tilt=12, **{"legs.flexible_thickness_mm": 0.3})`
        """
        words = {SHORT[key]: keys.pop(key) for key in [*keys] if key in SHORT}
        if isinstance(keys.get("legs"), str):  # a table or a list are the file's
            words["kind"] = keys.pop("legs")
        for key, value in (("tilt_deg", tilt_deg), ("kind", kind)):
            if value is not None and words.setdefault(key, value) is not value:
                raise InputError(f"{self.name}: {key}: given twice, by its short name too")
        own = self._named(words.pop("tilt_deg", None), words.pop("kind", None)) | words
        for key in own.keys() & keys.keys():
            raise InputError(f"{self.name}: {key}: given twice, by its short name too")
        return changed(self, own | keys, self.name)

    def __repr__(self) -> str:
        length, thickness, depth = self.size
        legs = f"{len(self.limbs)} {self.kind} legs, tilt {self.tilt_deg:g} deg"
        return f"<Design {self.name}: {legs}, body {length:.4g} x {depth:.4g} x {thickness:.4g} mm>"

    __str__ = __repr__

    def _named(self, tilt_deg: float | None, kind: Kind | None) -> dict[str, Any]:
        """Keys that a tilt and a kind of legs stand for. Raises GeometryError where there is none.

        None leaves the design's own.
        """
        if self.pair:
            own = {"legs.tilt_deg": tilt_deg, "legs.kind": kind}
            return {key: value for key, value in own.items() if value is not None}
        if kind not in (None, self.kind):
            raise GeometryError(f"{self.name}: the kind of each of its legs is its own: they cannot be made {kind}")
        if tilt_deg not in (None, self.tilt_deg) and not self.follows:
            raise GeometryError(
                f"{self.name}: every one of its legs has its own tilt, so that there is no variant "
                f"at {tilt_deg:g} deg: remove the tilt_deg of [[legs]] that shall follow"
            )
        return {"leg_tilt_deg": tilt_deg} if tilt_deg is not None and self.follows else {}

    def members(self, tilts_deg: Iterable[float] | None = None, kinds: Iterable[Kind] | None = None) -> list["Design"]:
        """Variants of a family, kinds outermost; by default those of its [family] table.

        Raises GeometryError, with the limit that was exceeded and the tilts at which, if any member
        cannot be built.
        """
        tilts = [self.tilt_deg] if not self.follows else self.family.tilt_deg
        tilts = tilts if tilts_deg is None else list(tilts_deg)
        chosen: list[Kind | None] = [None]
        if kinds is not None or self.pair:
            chosen = list(self.family.legs if kinds is None else kinds)
        if self.weighed.leg_mass_g is not None and chosen not in ([self.kind], [None]):
            raise GeometryError(
                f"{self.name}: weighed.leg_mass_g is the mass of a {self.kind} leg; "
                f"make one kind only (--legs {self.kind}) or remove the key"
            )
        variants: list[Design] = []
        problems: dict[str, list[str]] = {}
        for kind in chosen:
            for tilt in tilts:
                try:
                    variants.append(self.variant(tilt_deg=tilt, kind=kind))
                except GeometryError as error:
                    for line in str(error).splitlines():
                        problems.setdefault(line, []).append(f"{tilt:g}")
        if problems:
            raise GeometryError(
                "\n".join(
                    line
                    if len(where) == len(chosen) * len(tilts) or "tilt_deg = " in line
                    else f"at tilt {', '.join(dict.fromkeys(where))} deg: {line}"
                    for line, where in problems.items()
                )
            )
        return variants

    @property
    def mark(self) -> str:
        """Mark that the part shows: its tilt in digits, its notches drawn with #, or nothing."""
        if self.marks.blank:
            return ""
        from walkergen.walker.marks import word

        return word(self.marks, self.family.tilt_deg, self.tilt_deg)

    @property
    def letters(self) -> str:
        """Text that is engraved in letters, as numbers on a body in plan view are; "" without."""
        number = self.marks.kind == "none" and self.body.flat
        return self.marks.letters if number or self.marks.kind == "text" else ""

    @property
    def unmarked(self) -> "Design":
        """Design without marks, otherwise the same."""
        return self.model_copy(update={"marks": Marks()})


def named(text: str) -> str:
    """Name that file names may hold, of a text in any script."""
    plain = unicodedata.normalize("NFKD", text.replace("ß", "ss")).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", plain).strip("-_")[:64]
    return name or f"walker-{hashlib.sha256(text.encode(errors='surrogatepass')).hexdigest()[:6]}"


def _one_body(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Data in which a finished walker, [walker], is the body that is cut. Raises GeometryError."""
    if "walker" not in data:
        return data
    whole, table = dict(data), data["walker"]
    del whole["walker"]
    if not isinstance(table, Mapping) or not {"mesh", "legs_below_mm"} <= set(table):
        raise GeometryError(
            "walker = ...: a finished walker needs a table [walker] with mesh and legs_below_mm, "
            "the height above its lowest point below which it is legs"
        )
    if "body" in data or "legs" in data:
        raise GeometryError("walker = ...: a finished walker has its body and legs: leave out [body] and [legs]")
    whole["body"] = {key: value for key, value in table.items() if key != "legs"}
    if "legs" in table:
        whole["legs"] = {"kind": table["legs"]}
    return whole
