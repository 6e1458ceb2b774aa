"""Design of a walker: the user's choices, with the shape and the legs that they determine.

Geometry in the x-y plane with the middle of the body at the origin, y up; all legs leave the body's bottom face at
their anchors, tilted so that the feet lie behind them for tilt > 0. The two equal legs of [legs] touch the plate
`contact_spacing` apart, symmetric about the middle, at any tilt (docs/physics.md section 1). Legs of [[legs]] are at
their given places. Defaults are the paper's object.
"""

import math
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any, Self

from pydantic import model_validator

from walkergen.core.errors import GeometryError, InputError
from walkergen.core.files.assignments import replace_values
from walkergen.core.files.config import validate
from walkergen.core.walker import resolve
from walkergen.core.walker.body import Shape, Size
from walkergen.core.walker.fittings import Marks
from walkergen.core.walker.limbs import Kind, Legs, Limb
from walkergen.core.walker.spec import DEFAULT_TILT_DEG, WalkerSpec, merge_walker_table

SHORT_KEYS = {"tilt": "tilt_deg", "text": "body.text", "mirror": "body.mirror"}
"""Keys of a walker's file, by their short names in commands."""


MESH_TOLERANCE_MM = 1e-4
"""Difference of the legs of a mesh that count as equal, mm: some last bits of the 32-bit floats of its file."""


class Design(WalkerSpec):
    """Design of a walker: the keys of its file, its shape and its legs.

    Arguments are the tables and keys of a walker's file, as ``legs={"tilt_deg": 12.0}``. Names state the units.

    Raises
    ------
    pydantic.ValidationError
        If a key is unknown or a value is outside its range.
    GeometryError
        If a part cannot be built.

    Notes
    -----
    The body's middle is the origin of the x-y plane, with y up. Feet lie behind their anchors for a positive tilt.
    The family tilt is the tilt in which the members of a family differ: `legs.tilt_deg` of two equal legs. In a list of
    legs it is `leg_tilt_deg`, which applies to the legs without a tilt of their own.

    References
    ----------
    docs/physics.md section 1.

    Examples
    --------
    >>> from walkergen.core import Design
    >>> Design(name="short", legs={"length_mm": 4.0})
    <Design short: 2 flexible legs, tilt 10 deg, body 28 x 8 x 3 mm>
    """

    @model_validator(mode="before")
    @classmethod
    def _prepare_data(cls, data: Any) -> Any:
        """Return the data to validate: with the legs of a mesh if it has any, turned if the stance is "as built"."""
        if not isinstance(data, Mapping):
            return data
        data = merge_walker_table(data)
        body = data.get("body")
        if isinstance(body, Mapping) and "mesh" in body and "legs_below_mm" not in body:
            data = resolve.load_readers().use_own_legs(data)
        if data.get("stance") != "as built":
            return data
        tilt_deg = data.get("leg_tilt_deg")
        return resolve.load_readers().level_feet(data, DEFAULT_TILT_DEG if tilt_deg is None else tilt_deg)

    @model_validator(mode="after")
    def _check_buildable(self) -> Self:
        resolve.check_buildable(self)
        return self

    @property
    def shape(self) -> Shape:
        """Shape of the body.

        Raises
        ------
        GeometryError
            If the body has no printable shape.
        InputError
            If a file of the body cannot be read.
        """
        return resolve.shape_of(self.body)

    @property
    def size(self) -> Size:
        """Extent of the body along the run, upward and across, mm."""
        return self.shape.size

    @cached_property
    def limbs(self) -> tuple[Limb, ...]:
        """Legs with all their numbers, in the order of the file. Two equal legs are listed back, front.

        Raises
        ------
        GeometryError
            If a leg does not meet the body.
        """
        return resolve.place_legs(self)

    def __copy__(self) -> Self:
        copy = super().__copy__()
        copy.__dict__.pop("limbs", None)  # `model_copy` may change the keys that define them
        return copy

    @property
    def tilt_deg(self) -> float:
        """Tilt that identifies a member of a family, deg: the family tilt, or the first leg's if all have their own."""
        return resolve.member_tilt_deg(self)

    @property
    def rigid(self) -> bool:
        """Whether all legs are rigid, as braced ones are."""
        return all(limb.rigid for limb in self.limbs)

    @property
    def run_direction(self) -> int:
        """1 if the flexible legs lean for a run forward, along x, -1 if backward, 0 if neither or some of each."""
        signs = {math.copysign(1, limb.tilt) for limb in self.limbs if limb.tilt != 0.0 and not limb.rigid}
        return int(sum(signs))

    @property
    def notes(self) -> tuple[str, ...]:
        """Messages on changes to the body's file, its assumed size and the positions of automatic legs."""
        remarks = [*self.shape.changes, *filter(None, [self.shape.assumption])]
        notes = [f"{self.name}: {'; '.join(remarks)}"] if remarks else []
        if self.has_automatic_legs or self.is_complete_mesh:
            notes.append(f"{self.name}: {resolve.describe_placement(self)}")
        return tuple(notes)

    def with_leg_thicknesses(self, thicknesses_mm: Iterable[float]) -> "Design":
        """Return a copy of a finished walker's design whose legs have other thicknesses, as prints differ.

        Parameters
        ----------
        thicknesses_mm : iterable of float
            Thickness of each leg, in the order of `limbs`.

        Returns
        -------
        Design
            The copy. Copies of it have the thicknesses of the mesh again.
        """
        copy, limbs = self.model_copy(), zip(self.limbs, thicknesses_mm, strict=True)
        copy.__dict__["limbs"] = tuple(limb._replace(thickness=thickness) for limb, thickness in limbs)
        return copy

    def with_explicit_leg_positions(self) -> "Design":
        """Return the design with the automatic positions of its legs written as numbers, which a user can edit.

        Returns
        -------
        Design
            The same walker, or the design itself if it has no automatic legs.
        """
        if not isinstance(self.legs, Legs) or not self.has_automatic_legs:
            return self
        data, legs = self.model_dump(exclude_unset=True), self.legs.model_dump(exclude_unset=True)
        first, size = self.limbs[0], self.size
        if self.is_symmetric_pair:
            keys = {"placement": "given", "contact_spacing_mm": self.foot_span, "width_mm": first.width}
            return validate(data | {"legs": legs | keys}, Design, self.name)
        keys = {key: legs[key] for key in ("kind", "length_mm", "brace_thickness_mm", "foot") if key in legs}
        keys |= {"thickness_mm": self.legs.thickness_mm, "thickness_sd_mm": self.legs.thickness_sd_mm}
        listed = [
            keys | {"along_mm": limb.along, "across_mm": limb.across, "width_mm": min(limb.width, size.depth)}
            for limb in self.limbs
        ]
        family = {"family": data.get("family", {}) | {"legs": [self.kind]}}
        return validate(data | {"leg_tilt_deg": self.tilt_deg, "legs": listed} | family, Design, self.name)

    @property
    def is_symmetric_pair(self) -> bool:
        """Whether there are two equal legs at equal distances from the middle, as in the paper."""
        if self.has_legs_table and not self.has_automatic_legs:
            return True
        if len(self.limbs) != 2:
            return False
        first, second = self.limbs
        image = second._replace(along=0.0 - second.along)
        has_own_contact = first.friction is not None or first.restitution is not None
        if self.is_complete_mesh:  # in 32-bit floats
            numbers = [tuple(value for value in limb if isinstance(value, float)) for limb in (first, image)]
            return math.dist(*numbers) + abs(first.across) <= MESH_TOLERANCE_MM
        return first == image and first.across == 0.0 and not has_own_contact

    @property
    def is_mirror_symmetric(self) -> bool:
        """Whether a mirror that swaps left and right leaves the set of legs unchanged."""
        legs = sorted(self.limbs, key=lambda limb: (limb.along, limb.tilt, limb.across))
        image = [limb._replace(across=0.0 - limb.across) for limb in self.limbs]
        return legs == sorted(image, key=lambda limb: (limb.along, limb.tilt, limb.across))

    @property
    def foot_span(self) -> float:
        """Distance along the run from the rearmost foot to the foremost, mm."""
        positions = [limb.along for limb in self.limbs]
        return max(positions) - min(positions)

    def variant(self, *, tilt_deg: float | None = None, kind: Kind | None = None, **keys: Any) -> "Design":
        """Return the design with another tilt or kind of legs, or with other values of any keys.

        Everything is validated together, as the file's lines are, unlike by pydantic's `model_copy`.

        Parameters
        ----------
        tilt_deg : float, optional
            Tilt of the legs, degrees. Legs of a list that have a tilt keep it.
        kind : {"flexible", "braced"}, optional
            Kind of two equal legs. Legs of a list keep their kinds.
        **keys : Any
            Values by dotted keys of the file, or by options of the commands: `tilt` is `tilt_deg`, `legs="braced"`
            is `kind`, `text` and `mirror` belong to the body.

        Returns
        -------
        Design
            The variant. This design is unchanged.

        Raises
        ------
        InputError
            If a key is unknown, given twice or has an invalid value. The message has a line for each.
        GeometryError
            If a part of the variant cannot be built.

        Examples
        --------
        >>> import walkergen as wg
        >>> wg.load("koumakis2016").variant(tilt=12, **{"legs.flexible_thickness_mm": 0.3})
        <Design koumakis2016: 2 flexible legs, tilt 12 deg, body 28 x 8 x 3 mm>
        """
        options = {SHORT_KEYS[key]: keys.pop(key) for key in [*keys] if key in SHORT_KEYS}
        if isinstance(keys.get("legs"), str):  # a table or a list are the file's
            options["kind"] = keys.pop("legs")
        for key, value in (("tilt_deg", tilt_deg), ("kind", kind)):
            if value is not None and options.setdefault(key, value) is not value:
                raise InputError(f"{self.name}: {key}: given twice, by its short name too")
        values = self._tilt_and_kind_keys(options.pop("tilt_deg", None), options.pop("kind", None)) | options
        for key in values.keys() & keys.keys():
            raise InputError(f"{self.name}: {key}: given twice, by its short name too")
        return replace_values(self, values | keys, self.name)

    def __repr__(self) -> str:
        length, thickness, depth = self.size
        legs = f"{len(self.limbs)} {self.kind} legs, tilt {self.tilt_deg:g} deg"
        return f"<Design {self.name}: {legs}, body {length:.4g} x {depth:.4g} x {thickness:.4g} mm>"

    __str__ = __repr__

    def _tilt_and_kind_keys(self, tilt_deg: float | None, kind: Kind | None) -> dict[str, Any]:
        """Return the values, by dotted keys, that give the legs a tilt (degrees) and a kind. None changes nothing.

        Raises GeometryError if these legs cannot have that tilt or kind.
        """
        if self.has_legs_table:
            values = {"legs.tilt_deg": tilt_deg, "legs.kind": kind}
            return {key: value for key, value in values.items() if value is not None}
        if kind is not None and self.is_complete_mesh:
            return self._tilt_and_kind_keys(tilt_deg, None) | {"legs.kind": kind}
        if kind not in (None, self.kind):
            raise GeometryError(f"{self.name}: its legs cannot be made {kind}. Change their kind in [[legs]].")
        if tilt_deg not in (None, self.tilt_deg) and not self.has_family_tilt:
            raise GeometryError(
                f"{self.name}: each of its legs has its own tilt, so there is no variant "
                f"at {tilt_deg:g} deg. Remove tilt_deg from the [[legs]] that shall change."
            )
        return {"leg_tilt_deg": tilt_deg} if tilt_deg is not None and self.has_family_tilt else {}

    def members(self, tilts_deg: Iterable[float] | None = None, kinds: Iterable[Kind] | None = None) -> list["Design"]:
        """Return a variant of the design for each kind and tilt of legs in a family, by default of the table [family].

        Parameters
        ----------
        tilts_deg : iterable of float, optional
            Tilts, degrees.
        kinds : iterable of {"flexible", "braced"}, optional
            Kinds of legs.

        Returns
        -------
        list of Design
            Designs, ordered by kind, then by tilt.

        Raises
        ------
        GeometryError
            If a member cannot be built. The message has the limit that was exceeded and the tilts.
        """
        tilts = [self.tilt_deg] if not self.has_family_tilt else self.family.tilt_deg
        tilts = tilts if tilts_deg is None else list(tilts_deg)
        kinds_or_none: list[Kind | None] = [None]
        if kinds is not None or self.has_legs_table:
            kinds_or_none = list(self.family.legs if kinds is None else kinds)
        if self.weighed.leg_mass_g is not None and kinds_or_none not in ([self.kind], [None]):
            raise GeometryError(
                f"{self.name}: weighed.leg_mass_g is the mass of a {self.kind} leg. "
                f"Make one kind only (‹legs=›{self.kind}), or remove the key."
            )
        variants: list[Design] = []
        problems: dict[str, list[str]] = {}
        for kind in kinds_or_none:
            for tilt in tilts:
                try:
                    variants.append(self.variant(tilt_deg=tilt, kind=kind))
                except GeometryError as error:
                    for line in error.text.splitlines():
                        problems.setdefault(line, []).append(f"{tilt:g}")
        if problems:
            raise GeometryError(
                "\n".join(
                    line
                    if len(tilts_of_problem) == len(kinds_or_none) * len(tilts) or "tilt_deg = " in line
                    else f"at tilt {', '.join(dict.fromkeys(tilts_of_problem))} deg: {line}"
                    for line, tilts_of_problem in problems.items()
                )
            )
        return variants

    @property
    def mark(self) -> str:
        """Text of the mark on the printed part: its tilt in digits, its letters, its notches drawn as #, or ""."""
        if self.marks.blank:
            return ""
        return resolve.load_readers().format_mark(self.marks, self.family.tilt_deg, self.tilt_deg)

    @property
    def unmarked(self) -> "Design":
        """Design without marks, otherwise the same."""
        return self.model_copy(update={"marks": Marks()})
