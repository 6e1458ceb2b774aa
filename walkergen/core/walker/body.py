"""Bodies of walkers: their keys, and the shapes that these define.

A body is a prism in side view (a rectangle or a polygon, extruded across the run), a prism in plan
view (a disc, an ellipse, a polygon, a drawing, letters, extruded upward), or a mesh from a file.
Frame: the middle of the body's box at the origin of x and y, z from 0 to its depth.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from operator import not_
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from walkergen.core.files.config import Section
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.limbs import Kind, Length, Limb, Polygon

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
Points = Annotated[
    list[Annotated[list[float], Field(min_length=2, max_length=2)]], Field(min_length=3, max_length=100_000)
]

BUILTIN_OUTLINES = ("disc", "ellipse", "polygon")
"""Outlines that need no file."""

FILE_KEYS = ("outline", "mesh", "font")
"""Keys that may name a file."""

DEFAULT_RAILS_MM = 2.0
"""Width of the bars that join letters. With a base plate, the letters would hang over air as they print."""

SOURCE_KEYS = ("profile_mm", "outline", "text", "mesh")
"""Keys that give a body another shape than a rectangle; one of them at most."""

SOURCE_DETAIL_KEYS = ("points_mm", "font", "rails_mm", "scale_mm", "up", "forward", "legs_below_mm", "base", "mirror")
"""Keys that describe a source in detail."""


class Body(Section):
    """Massive top of a walker: by default a rectangle in the x-y plane, extruded by its depth."""

    length_mm: Length = 28.0
    depth_mm: Length = 8.0
    thickness_mm: Length = 3.0
    profile_mm: Points | None = None
    """Corners of a side view, (x, y), extruded across by depth_mm."""
    outline: Annotated[str, Field(min_length=1, max_length=4096)] | None = None
    """Plan view: "disc" (of length_mm), "ellipse" (length_mm, depth_mm), "polygon" (points_mm), or
    a drawing (.svg, .dxf) or a picture (.png, .jpg) in the folder of the file. It is extruded upward by thickness_mm.
    A drawing, a text or a mesh is scaled to length_mm if this is set."""
    points_mm: Points | None = None
    """Corners of the outline "polygon", seen from above."""
    text: str | None = None
    """Text whose letters are the plan view, depth_mm high."""
    font: Annotated[str, Field(min_length=1, max_length=4096)] | None = None
    """Font of the text (.ttf, .otf, .ttc) in the folder of the file. None: DejaVu Sans."""
    rails_mm: Length | None = None
    """Width of two bars that join the letters to one part, along their feet and their tops. None: DEFAULT_RAILS_MM
    for two letters and more, unless `base` is set."""
    mesh: Annotated[str, Field(min_length=1, max_length=4096)] | None = None
    """Mesh of the body, in the folder of the file."""
    scale_mm: Length | None = None
    """Millimetres in a unit of the drawing or mesh. None: the unit that a drawing states, or 1 for a mesh."""
    up: Axis = "z"
    forward: Axis = "x"
    """Axes of the mesh that point up and forward."""
    legs_below_mm: Length | None = None
    """Height above the lowest point of a mesh of a finished walker. Parts below it are legs."""
    repair: bool = True
    """Whether faults of a mesh and crossing paths are repaired. The changes are reported."""
    base: bool | None = Field(default=None, exclude_if=lambda value: value is None)
    """Whether a flat plate lies under all pieces. None: under one letter without rails, and under pieces that only it
    joins. Without a plate the largest piece of a file is the body."""
    mirror: bool = Field(default=False, exclude_if=not_)
    """Whether the shape is mirrored: its front becomes its back."""

    @model_validator(mode="after")
    def _check_contradictions(self) -> "Body":
        """Raise ValueError if keys of the body contradict each other."""
        sources = [key for key in SOURCE_KEYS if getattr(self, key) is not None]
        if len(sources) > 1:
            raise ValueError(f"{' and '.join(sources)} each give the body a shape: keep one of them")
        if (self.points_mm is not None) != (self.outline == "polygon"):
            raise ValueError('points_mm and outline = "polygon" go together')
        if self.scale_mm is not None and not (self.mesh or self._has_drawing):
            raise ValueError("scale_mm applies only to a drawing or a mesh; other lengths are mm already")
        if self.rails_mm is not None and self.text is None:
            raise ValueError("rails_mm applies only to body.text")
        if self.text is not None and any("\ud800" <= letter <= "\udfff" for letter in self.text):
            raise ValueError("text holds bytes that are not UTF-8: write it again")
        if self.font is not None and self.text is None:
            raise ValueError("font applies only to body.text")
        if not self.is_flat_or_mesh and (self.base or self.mirror):
            raise ValueError("base and mirror apply only to a text, an outline or a mesh")
        if self.is_flat_or_mesh and self.base and self.legs_below_mm is not None:
            raise ValueError("base and legs_below_mm: a finished walker has no base plate. Remove one of them.")
        if self.scale_mm is not None and self.given_length_mm is not None:
            raise ValueError("scale_mm and length_mm each give the size: keep one of them")
        if self.text is not None and {"length_mm", "depth_mm"} <= self.model_fields_set:
            raise ValueError("length_mm and depth_mm each give the letters' size: keep one of them")
        if self.legs_below_mm is not None and self.mesh is None:
            raise ValueError("legs_below_mm applies only to a mesh of a finished walker")
        for key in sources:
            if wrong := sorted(self._derived_keys(key) & self.model_fields_set):
                raise ValueError(f"{wrong[0]} follows from {key}: remove it")
        return self

    def _derived_keys(self, source: str) -> set[str]:
        """Return the keys of the size that follow from the key `source`, such as "outline". Users must not set them."""
        flat: dict[str, set[str]] = {"ellipse": set(), "polygon": {"length_mm", "depth_mm"}}
        return {
            "profile_mm": {"length_mm", "thickness_mm"},
            "text": set(),
            "mesh": {"depth_mm", "thickness_mm"},
            "outline": flat.get(str(self.outline or ""), {"depth_mm"}),  # of any type before it is checked
        }[source]

    @classmethod
    def drop_old_shape_keys(
        cls, table: Mapping[str, Any], source: str, former: "Body", values: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return the table [body] after a change of the body's shape, without the keys of its old shape.

        Parameters
        ----------
        table : mapping
            Table with the change, in which the keys of both shapes are still set.
        source : str
            Key that gives the new shape, one of SOURCE_KEYS.
        former : Body
            Body before the change.
        values : mapping
            Values that the user has just set, by keys such as "body.length_mm". They are kept.
        """
        dropped = set(SOURCE_KEYS) - {source}
        if getattr(former, source) is None:
            dropped |= {*SOURCE_DETAIL_KEYS, "length_mm", "depth_mm"}
        dropped |= cls.model_construct(**{source: table[source]})._derived_keys(source)
        if source == "outline" and table[source] != "polygon":
            dropped.add("points_mm")
        return {key: value for key, value in table.items() if key not in dropped or f"body.{key}" in values}

    @property
    def is_flat_or_mesh(self) -> bool:
        """Whether the shape comes from a text, an outline or a mesh. A rectangle and profile_mm are none of these."""
        return self.flat or self.mesh is not None

    @property
    def scales_with_length(self) -> bool:
        """Whether length_mm scales the whole shape."""
        return self.is_flat_or_mesh and self.outline != "polygon" and self.legs_below_mm is None

    def with_keys(self, **keys: Any) -> "Body":
        """Return a validated copy of the body with `keys` set. A length_mm replaces scale_mm and depth_mm."""
        table = self.model_dump(exclude_unset=True) | keys
        for key in {"scale_mm", "depth_mm"} if "length_mm" in keys else ():
            table.pop(key, None)
        return Body.model_validate(table)

    @property
    def given_length_mm(self) -> float | None:
        """Length that the user set for a drawing, text or mesh, mm, or None if it is not set or does not apply."""
        scaled = self.text is not None or self.mesh is not None or self._has_drawing
        return self.length_mm if scaled and "length_mm" in self.model_fields_set else None

    @property
    def unused_keys(self) -> set[str]:
        """Names of the keys that have no effect on a body of this shape."""
        keys = {key for key in SOURCE_KEYS if getattr(self, key) is None}
        for key in set(SOURCE_KEYS) - keys:
            keys |= self._derived_keys(key)
        needs = {
            "points_mm": self.outline == "polygon",
            **dict.fromkeys(("font", "rails_mm"), self.text is not None),
            **dict.fromkeys(("scale_mm", "repair"), bool(self.mesh or self._has_drawing)),
            **dict.fromkeys(("up", "forward", "legs_below_mm"), bool(self.mesh)),
            **dict.fromkeys(("base", "mirror"), self.is_flat_or_mesh),
        }
        return keys | {key for key, needed in needs.items() if not needed}

    @property
    def _has_drawing(self) -> bool:
        """Whether the outline is a file, not one of the built-in outlines."""
        return self.outline is not None and self.outline not in BUILTIN_OUTLINES

    @property
    def plain(self) -> bool:
        """Whether the body is a rectangle in side view."""
        shaped = self.profile_mm is not None or self.mesh is not None
        return not (shaped or self.flat)

    @property
    def flat(self) -> bool:
        """Whether the body is given in plan view. It then prints flat, upside down with its legs up."""
        return self.outline is not None or self.text is not None

    @property
    def cache_key(self) -> str:
        """JSON text of the keys that are set. It identifies the shape in caches."""
        return self.model_dump_json(exclude_unset=True)


class Size(NamedTuple):
    """Extent of a body, mm."""

    length: float
    thickness: float
    depth: float


class FinishedWalker(NamedTuple):
    """Parts of a mesh that was a whole walker, in the design's frame."""

    mesh: Mesh
    body: Mesh
    legs: tuple[Mesh, ...]
    """Legs from back to front. Legs side by side are in the order of their z."""
    limbs: Callable[[Kind, float], tuple[Limb, ...]]
    """Its legs with all their numbers, from their kind and the body's depth, mm. Raises GeometryError."""


class Shape(NamedTuple):
    """Shape that the keys of a body define."""

    size: Size
    side: Polygon | None
    """Profile in the x-y plane, counter-clockwise; None for other bodies than those in side view."""
    plan: tuple[Polygon, ...] = ()
    """Outline seen from above, x to the right, outer contour first, then holes."""
    mesh: Mesh | None = None
    """Mesh from a file, in the design's frame."""
    sha256: str = ""
    """Hash of the bytes of the file, if there is one."""
    changes: tuple[str, ...] = ()
    """Parts of the file that were left out or repaired, a few words each."""
    finished: FinishedWalker | None = None
    """Body and legs of a mesh that was a whole walker, in the design's frame."""
    assumption: str = ""
    """Size that was assumed because the file states none."""

    def solid(self) -> Mesh:
        """Return the closed mesh of the body, in the design's frame. Raises SolidError."""
        if self.mesh is not None:
            return self.mesh
        from walkergen.core.shapes.modeller import extrude  # heavy: the modeller

        if self.side is not None:
            return extrude([self.side], self.size.depth)
        return lay_down(extrude(self.plan, self.size.thickness), self.size)


def lay_down(plan: Mesh, size: Size) -> Mesh:
    """Return the mesh of an extruded plan view, turned to the design's frame: its y becomes -z, and its z becomes y."""
    x, v, w = plan.vertices.T
    return Mesh(np.column_stack([x, w - 0.5 * size.thickness, 0.5 * size.depth - v]), plan.triangles)


@lru_cache(maxsize=64)
def rectangle_shape(length: float, thickness: float, depth: float) -> Shape:
    """Return the shape of a body that is a rectangle in side view. Lengths in mm."""
    x, y = 0.5 * length, 0.5 * thickness
    side = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    side.flags.writeable = False  # all designs of that size share it
    return Shape(Size(length, thickness, depth), side)
