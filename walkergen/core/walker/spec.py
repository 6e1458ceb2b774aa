"""Specification of a walker: the keys of its TOML file, each validated.

It holds text and numbers and reads no drawing. `resolve` finds the shape and the legs that they define.
"""

import copy
import hashlib
import os
import re
import unicodedata
from collections.abc import Mapping
from operator import not_
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, SerializeAsAny, Tag, ValidationInfo, field_validator, model_validator

from walkergen.core.errors import GeometryError, InputError
from walkergen.core.files.config import Name, Section, validate
from walkergen.core.walker.body import BUILTIN_OUTLINES, FILE_KEYS, SOURCE_KEYS, Body
from walkergen.core.walker.fittings import Battery, Cap, Marks, Motor, Part, Pockets
from walkergen.core.walker.limbs import KINDS, MAX_LEGS, RIGID_KINDS, Kind, Leg, Legs, Tilt

MassGram = Annotated[float, Field(ge=1e-15, le=1e12)]


class Material(Section):
    """Material of a printed walker, with solid infill; the defaults are those of PLA.

    The temperatures are used only in slicer settings without a profile of the filament. The maker of Prusament PLA
    states 210 +- 10 C, and 40 to 60 C for the bed.
    """

    density_g_cm3: Annotated[float, Field(ge=1e-3, le=100)] = 1.24
    youngs_modulus_gpa: Annotated[float, Field(ge=1e-6, le=1e4)] = 3.0
    youngs_modulus_sd_gpa: Annotated[float, Field(ge=0, le=1e4)] = 0.35
    poisson_ratio: Annotated[float, Field(ge=0, le=0.5)] = 0.36
    """Poisson's ratio; PLA's."""
    nozzle_deg_c: Annotated[int, Field(ge=100, le=500)] = 210
    bed_deg_c: Annotated[int, Field(ge=0, le=200)] = 60
    """Temperature of the bed; 0 for a bed without heating."""

    @property
    def youngs_modulus(self) -> float:
        """Young's modulus, Pa = g/(mm s^2)."""
        return 1e9 * self.youngs_modulus_gpa


class Weighed(Section):
    """Masses from a balance, which replace those of the mesh, and the spread of masses."""

    body_mass_g: MassGram | None = None
    leg_mass_g: MassGram | None = None
    mass_sd_percent: Annotated[float, Field(ge=0, le=50)] = 2.0

    @property
    def has_masses(self) -> bool:
        """Whether a weighed mass is given, which replaces that of the mesh."""
        return self.body_mass_g is not None or self.leg_mass_g is not None


class Family(Section):
    """Members of `walkergen family`, unless the command line selects others."""

    tilt_deg: Annotated[list[Tilt], Field(min_length=1, max_length=10_000)] = Field(
        default_factory=lambda: [float(tilt) for tilt in range(0, 50, 5)]
    )
    legs: Annotated[list[Kind], Field(min_length=1, max_length=2)] = Field(default_factory=lambda: list(KINDS))

    @field_validator("tilt_deg", "legs")
    @classmethod
    def _drop_repeats(cls, values: list[Any]) -> list[Any]:
        return list(dict.fromkeys(values))


OUTLINE_SUFFIXES, MESH_SUFFIXES = (
    (".svg", ".svgz", ".dxf", ".png", ".jpg", ".jpeg"),
    (".stl", ".obj", ".ply", ".off", ".3mf", ".glb"),
)
"""Endings of files that can replace a walker's file: they define the shape of its body."""

CAD_SUFFIXES = (".step", ".stp", ".iges", ".igs", ".f3d", ".scad", ".fcstd", ".blend")
"""Endings of files of CAD programs, which can also save meshes."""

DEFAULT_FAMILY = {"tilt_deg": [0.0, 5.0, 10.0, 15.0, 20.0], "legs": ["flexible"]}
"""Family of a walker that is only a shape."""

PLACEMENT_KEYS = ("contact_spacing_mm", "width_mm")
"""Keys of the positions of two equal legs."""

DEFAULT_TILT_DEG = 10.0
"""Tilt of legs of a list if neither they nor the design have one, deg."""


class WalkerSpec(Section):
    """Keys of a walker's file."""

    name: Name = "walker"
    description: Annotated[str, Field(max_length=2000)] = ""
    stance: Literal["level", "as built"] = "level"
    """Stance at rest: "level", or "as built" for unlike legs. A walker as built is turned until its feet are level."""
    body: Body = Body()
    legs: Annotated[
        Annotated[Legs, Tag("table")]
        | Annotated[Annotated[list[Leg], Field(min_length=1, max_length=MAX_LEGS)], Tag("list")],
        Discriminator(lambda legs: "list" if isinstance(legs, list) else "table"),
        SerializeAsAny(),  # a Ctrl-C that arrives while the discriminator serializes is lost
    ] = Legs()
    leg_tilt_deg: Tilt | None = None
    """Tilt of the legs of a list without a tilt of their own, deg. None: 10."""
    material: Material = Material()
    weighed: Weighed = Weighed()
    marks: Marks = Marks()
    motor: Motor | None = Field(default=None, exclude_if=not_)
    """Motor in the body. None: no motor; saved files omit the key."""
    battery: Battery | None = Field(default=None, exclude_if=not_)
    pockets: Pockets | None = Field(default=None, exclude_if=not_)
    """Pockets of motor and battery. None: those of `fit`, with default values."""
    cap: Cap | None = Field(default=None, exclude_if=not_)
    """Cap with a marker. None: no cap; saved files omit the key."""
    family: Family = Family()

    @field_validator("leg_tilt_deg")
    @classmethod
    def _check_leg_tilt(cls, value: float | None, info: ValidationInfo) -> float | None:
        """Return `leg_tilt_deg`, which is for a list of legs. Raises ValueError if it is set for two equal legs."""
        if value is not None and isinstance(info.data.get("legs"), Legs):
            raise ValueError("applies only to a list of legs, [[legs]]. Two equal legs have legs.tilt_deg instead.")
        return value

    @model_validator(mode="before")
    @classmethod
    def _merge_walker(cls, data: Any) -> Any:
        """Return a file's tables before validation, with [body] and [legs] in place of a finished walker's [walker]."""
        return merge_walker_table(data) if isinstance(data, Mapping) else data

    @classmethod
    def data_from_file(cls, path: Path) -> dict[str, Any] | None:
        """Return the data of a walker whose body is this drawing, picture or mesh, or None for another kind of file.

        Raises InputError for a CAD file.
        """
        ending, endings = path.suffix.lower(), {"outline": OUTLINE_SUFFIXES, "mesh": MESH_SUFFIXES}
        if ending in CAD_SUFFIXES:
            raise InputError(f"{path}: it is a CAD file. Export it as STL or 3MF, in mm, from its program.")
        source = next((key for key in endings if ending in endings[key]), None)
        data = {"name": name_from_text(path.stem), "body": {source: path.name}, "family": DEFAULT_FAMILY}
        return None if source is None else data

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return a walker whose body is a text. Raises GeometryError for letters that cannot be drawn."""
        data = {"name": name_from_text(text), "body": {"text": text}, "family": DEFAULT_FAMILY}
        return validate(data, cls, f"text {text[:40]!r}")

    @classmethod
    def with_paths_below(cls, data: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Return the data of a walker's file, with relative paths of the body's files joined to `folder`."""
        tables = {name: dict(data[name]) for name in ("body", "walker") if isinstance(data.get(name), Mapping)}
        for table in tables.values():
            files = [key for key in FILE_KEYS if isinstance(table.get(key), str)]
            table |= {key: str(folder / table[key]) for key in files if table[key] not in ("", *BUILTIN_OUTLINES)}
        return {**data, **tables}

    def adjust_other_keys(self, data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the data of a walker's file after a user has set `values`, without keys for an old shape of the body.

        If the values do not set a new shape, nothing is dropped. For a new shape, positions of two equal legs are found
        automatically, so old ones are dropped. Weighed masses and marks are dropped too. The family becomes
        DEFAULT_FAMILY, since automatic legs do not fit every tilt. Keys in `values` are kept.

        Parameters
        ----------
        data : dict
            Tables of the file, which contain the values already. They are changed in place.
        values : mapping
            Values that the user has set, by dotted keys.

        Returns
        -------
        dict
            The same data.
        """
        if values.get("legs.placement") == "auto":  # no legs of the mesh itself
            body = data.pop("walker", data.get("body"))
            dropped = {"legs", *({"legs_below_mm"} if "body.legs_below_mm" not in values else ())}
            if isinstance(body, dict):
                data["body"] = {key: value for key, value in body.items() if key not in dropped}
        body = data.get("body")
        former = {key: getattr(self.body, key) for key in SOURCE_KEYS}
        source = next((key for key in SOURCE_KEYS if values.get(f"body.{key}", former[key]) != former[key]), None)
        if not isinstance(body, dict) or (source is None and "body" not in values):
            return data
        if source is not None:
            data["body"] = Body.drop_old_shape_keys(body, source, self.body, values)
            if source != "profile_mm" and not any(key.partition(".")[0] == "family" for key in values):
                data["family"] = copy.deepcopy(DEFAULT_FAMILY)
            if "name" not in values:
                data["name"] = name_from_text(Path(str(values[f"body.{source}"])).stem)
                data.pop("description", None)
        if source != "profile_mm" and not any(key.partition("[")[0] == "legs" for key in values):
            data["legs"] = self._drop_positions(
                data.get("legs", {}), data["body"].get("outline") in BUILTIN_OUTLINES, values
            )
            if isinstance(data["legs"], dict):
                data.pop("leg_tilt_deg", None)
        for table in ("weighed", *(["marks"] if self.body.plain else [])):
            if not any(key.partition(".")[0] == table for key in values):
                data.pop(table, None)
        return data

    def _drop_positions(self, legs: Any, keep_list: bool, values: Mapping[str, Any]) -> Any:
        """Return the keys of `legs` for a new shape of the body, without positions that are not set in `values`.

        A list of legs becomes the table of two equal legs, unless `keep_list`.
        """
        if isinstance(legs, Mapping):
            return {key: value for key, value in legs.items() if key not in PLACEMENT_KEYS or f"legs.{key}" in values}
        first = self.legs if isinstance(self.legs, Legs) else self.legs[0]
        pair = {
            "kind": self.kind,
            "tilt_deg": self.tilt_from_keys_deg,
            "length_mm": legs[0].get("length_mm", 7.5),
            "foot": first.foot,
        }
        thickness = first.thickness_mm or Legs(kind=first.kind).thickness_mm
        return legs if keep_list else pair | {f"{self.kind}_thickness_mm": thickness}

    def with_paths_relative_to(self, folder: Path) -> Self:
        """Return a copy of the walker in which paths of the body's files are relative to a folder."""
        files = {key: getattr(self.body, key) for key in FILE_KEYS}
        paths = {
            key: Path(os.path.relpath(name, folder)).as_posix()
            for key, name in files.items()
            if name is not None and name not in BUILTIN_OUTLINES
        }
        return self.model_copy(update={"body": self.body.model_copy(update=paths)})

    @property
    def parts(self) -> dict[str, Part]:
        """Motor and battery in the body, by the names of their tables."""
        parts = {"motor": self.motor, "battery": self.battery}
        return {name: part for name, part in parts.items() if part is not None}

    def driving_motor(self) -> Motor:
        """Return the motor that drives the walker. Raises InputError if there is none."""
        if self.motor is None:
            raise InputError(
                f"drive.kind = 'motor': {self.name} has no motor. Add a table [motor] to its design, "
                "with diameter_mm, height_mm and mass_g, or use the template coinbot."
            )
        return self.motor

    @property
    def pocket_settings(self) -> Pockets:
        """Settings of the pockets that hold the walker's parts: clearance, channel, wires and glue."""
        return self.pockets or Pockets()

    @property
    def kind(self) -> Kind:
        """Kind of legs: that of the first leg that is not rigid, or of the first leg if all are rigid."""
        kinds = [self.legs.kind] if isinstance(self.legs, Legs) else [leg.kind for leg in self.legs]
        return next((kind for kind in kinds if kind not in RIGID_KINDS), kinds[0])

    @property
    def tilt_from_keys_deg(self) -> float:
        """Tilt of the walker according to its keys, deg: the family tilt, or the first leg's if all have their own.

        A mirrored first leg has minus its `tilt_deg`. The keys of a finished walker do not define its tilt.
        """
        if isinstance(self.legs, Legs):
            return self.legs.tilt_deg
        first = self.legs[0]
        if self.has_family_tilt or first.tilt_deg is None:
            return self.family_tilt_of_list_deg
        return 0.0 - first.tilt_deg if first.mirrored else first.tilt_deg

    @property
    def family_tilt_of_list_deg(self) -> float:
        """Family tilt of a list of legs, deg: `leg_tilt_deg`, or 10 if it is not set."""
        return DEFAULT_TILT_DEG if self.leg_tilt_deg is None else self.leg_tilt_deg

    @property
    def has_family_tilt(self) -> bool:
        """Whether at least one leg has the family tilt, which varies from member to member of a family."""
        if isinstance(self.legs, Legs):
            return not self.is_complete_mesh
        return any(leg.tilt_deg is None for leg in self.legs)

    @property
    def is_complete_mesh(self) -> bool:
        """Whether the body is a mesh of a finished walker, cut into body and legs."""
        return self.body.legs_below_mm is not None

    @property
    def has_legs_table(self) -> bool:
        """Whether the legs are two equal ones in the short form, [legs]."""
        return isinstance(self.legs, Legs) and not self.is_complete_mesh

    @property
    def has_automatic_legs(self) -> bool:
        """Whether legs are placed automatically (`readers.walkers.leg_placement`)."""
        if not isinstance(self.legs, Legs) or self.is_complete_mesh:
            return False
        shaped = self.body.flat or self.body.mesh is not None
        written = self.legs.model_fields_set & set(PLACEMENT_KEYS)
        return self.legs.placement == "auto" or (self.legs.placement is None and shaped and not written)

    @property
    def letters(self) -> str:
        """Text and serial number to engrave as letters, or "". A serial number alone needs a body in plan view."""
        number = self.marks.kind == "none" and self.body.flat
        return self.marks.letters if number or self.marks.kind == "text" else ""


def name_from_text(text: str) -> str:
    """Convert a text in any script to a name in ASCII letters, digits, - and _, of at most 64 letters."""
    plain = unicodedata.normalize("NFKD", text.replace("ß", "ss")).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", plain).strip("-_")[:64]
    return name or f"walker-{hashlib.sha256(text.encode(errors='surrogatepass')).hexdigest()[:6]}"


def merge_walker_table(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a walker's data with [body] and [legs] in place of [walker]. Raises GeometryError if it is faulty."""
    if "walker" not in data:
        return data
    merged, table = dict(data), data["walker"]
    del merged["walker"]
    if not isinstance(table, Mapping) or not {"mesh", "legs_below_mm"} <= set(table):
        raise GeometryError(
            "walker: a finished walker needs a table [walker] with mesh and legs_below_mm. Parts below this "
            "height above its lowest point are legs."
        )
    if "body" in data or "legs" in data:
        raise GeometryError("walker: a finished walker already has a body and legs. Remove [body] and [legs].")
    merged["body"] = {key: value for key, value in table.items() if key != "legs"}
    if "legs" in table:
        merged["legs"] = {"kind": table["legs"]}
    return merged
