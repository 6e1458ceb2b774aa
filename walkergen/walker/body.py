"""Bodies of walkers: what people write of them, and the shape that it stands for.

A body is a prism in side view (a rectangle or a polygon, extruded across the run), a prism in plan
view (a disc, an ellipse, a polygon, a drawing, letters, extruded upward), or a mesh from a file.
Frame: the middle of the body's box at the origin of x and y, z from 0 to its depth.
"""

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from walkergen.errors import GeometryError
from walkergen.files import reading
from walkergen.files.config import Section
from walkergen.shapes.mesh import Mesh
from walkergen.walker.limbs import Length

if TYPE_CHECKING:
    from walkergen.shapes.outlines import Outline, Polygon
    from walkergen.walker.whole_mesh import CutWalker

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
Points = Annotated[
    list[Annotated[list[float], Field(min_length=2, max_length=2)]], Field(min_length=3, max_length=100_000)
]

DRAWN = ("disc", "ellipse", "polygon")
"""Outlines that need no file."""

SOURCES = ("profile_mm", "outline", "text", "mesh")
"""Keys that give a body another shape than a rectangle; one of them at most."""


class Body(Section):
    """Massive top of a walker: by default a rectangle in the x-y plane, extruded by its depth."""

    length_mm: Length = 28.0
    depth_mm: Length = 8.0
    thickness_mm: Length = 3.0
    profile_mm: Points | None = None
    """Corners of a side view, (x, y), extruded across by depth_mm."""
    outline: Annotated[str, Field(min_length=1, max_length=4096)] | None = None
    """Plan view: "disc" (of length_mm), "ellipse" (length_mm, depth_mm), "polygon" (points_mm), or
    a drawing, .svg or .dxf, beside the file; extruded upward by thickness_mm."""
    points_mm: Points | None = None
    """Corners of the outline "polygon", seen from above."""
    text: str | None = None
    """Letters as the plan view, as high as depth_mm."""
    rails_mm: Length | None = None
    """Width of two bars along the feet and the tops of the letters, which join them to one part."""
    mesh: Annotated[str, Field(min_length=1, max_length=4096)] | None = None
    """Mesh of the body, beside the file."""
    scale_mm: Length | None = None
    """Millimetres in a unit of the drawing or mesh. None: what a drawing states; 1 for a mesh."""
    up: Axis = "z"
    forward: Axis = "x"
    """Axes of the mesh that point up and forward."""
    legs_below_mm: Length | None = None
    """Height above its lowest point below which a mesh, of a whole walker, is legs."""
    repair: bool = False
    """True to mend a mesh that is not closed; what was changed is told."""

    @model_validator(mode="after")
    def _one_source(self) -> "Body":
        sources = [key for key in SOURCES if getattr(self, key) is not None]
        if len(sources) > 1:
            raise ValueError(f"{' and '.join(sources)} each give the body a shape: keep one of them")
        if (self.points_mm is not None) != (self.outline == "polygon"):
            raise ValueError('points_mm and outline = "polygon" go together')
        if self.scale_mm is not None and not (self.mesh or self._drawing):
            raise ValueError("scale_mm is for a drawing or a mesh; lengths here are mm already")
        if self.rails_mm is not None and self.text is None:
            raise ValueError("rails_mm joins the letters of text")
        if self.legs_below_mm is not None and self.mesh is None:
            raise ValueError("legs_below_mm is for a mesh of a whole walker")
        for key in sources:
            if wrong := sorted(self._follows(key) & self.model_fields_set):
                raise ValueError(f"{wrong[0]} follows from {key}: leave it out")
        return self

    def _follows(self, source: str) -> set[str]:
        """Sizes that follow from a source of the shape."""
        flat = {"disc": {"depth_mm"}, "ellipse": set()}
        return {
            "profile_mm": {"length_mm", "thickness_mm"},
            "text": {"length_mm"},
            "mesh": {"length_mm", "depth_mm", "thickness_mm"},
            "outline": flat.get(self.outline or "", {"length_mm", "depth_mm"}),
        }[source]

    @property
    def idle(self) -> set[str]:
        """Keys that say nothing of a body of this shape; other sources of one are among them."""
        keys = {key for key in SOURCES if getattr(self, key) is None}
        for key in set(SOURCES) - keys:
            keys |= self._follows(key)
        needs = {
            "points_mm": self.outline == "polygon",
            "rails_mm": self.text is not None,
            "scale_mm": bool(self.mesh or self._drawing),
            **dict.fromkeys(("up", "forward", "legs_below_mm", "repair"), bool(self.mesh)),
        }
        return keys | {key for key, needed in needs.items() if not needed}

    @property
    def _drawing(self) -> bool:
        return self.outline is not None and self.outline not in DRAWN

    @property
    def plain(self) -> bool:
        """True for a rectangle in side view."""
        shaped = self.profile_mm is not None or self.mesh is not None
        return not (shaped or self.flat)

    @property
    def flat(self) -> bool:
        """True for a body in plan view, which prints flat, upside down with its legs up."""
        return self.outline is not None or self.text is not None

    @property
    def shape(self) -> "Shape":
        """Shape of the body. Raises GeometryError, and InputError for files."""
        if self.plain:
            return _rectangle(self.length_mm, self.thickness_mm, self.depth_mm)
        return _shape(self.key)

    @property
    def key(self) -> str:
        """JSON of what was written, by which a shape is kept."""
        return self.model_dump_json(exclude_unset=True)


class Size(NamedTuple):
    """Extent of a body, mm."""

    length: float
    thickness: float
    depth: float


class Shape(NamedTuple):
    """Shape that a body's keys stand for."""

    size: Size
    side: "Polygon | None"
    """Profile in the x-y plane, counter-clockwise; None for other bodies than those in side view.
    """
    plan: "tuple[Polygon, ...]" = ()
    """Outline seen from above, x to the right, outer contour first, then holes."""
    mesh: Mesh | None = None
    """Mesh from a file, in the design's frame."""
    sha256: str = ""
    """Hash of the bytes of the file, if there is one."""
    changes: tuple[str, ...] = ()
    """What was left out of the file, or mended, a few words each."""
    whole: "CutWalker | None" = None
    """Body and legs of a mesh that was a whole walker, in the design's frame."""


def located(table: Any, folder: Path) -> Any:
    """Table [body] as in a file, its drawing or mesh found from the folder of that file."""
    if not isinstance(table, Mapping):
        return table
    own = dict(table)
    for key in ("outline", "mesh"):
        name = own.get(key)
        if isinstance(name, str) and name and name not in DRAWN:
            own[key] = str(folder / name)
    return own


@lru_cache(maxsize=64)
def _rectangle(length: float, thickness: float, depth: float) -> Shape:
    x, y = 0.5 * length, 0.5 * thickness
    side = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    side.flags.writeable = False  # all designs of that size share it
    return Shape(Size(length, thickness, depth), side)


@lru_cache(maxsize=64)
def _shape(keys: str) -> Shape:
    """Shape of a body that is no rectangle, read and checked once; `keys` is its JSON."""
    body = Body.model_validate_json(keys)
    if body.mesh is not None:
        from walkergen.walker import own_mesh

        own = own_mesh.read(Path(body.mesh), body.scale_mm or 1.0, body.up, body.forward, body.repair)
        if body.legs_below_mm is not None:
            from walkergen.walker import whole_mesh

            cut = whole_mesh.centred(whole_mesh.cut_legs(own.mesh, body.legs_below_mm))
            size = _size_of(cut.body)
            return Shape(size, None, (), cut.body, own.sha256, own.changes, cut)
        return Shape(_size_of(own.mesh), None, (), own.mesh, own.sha256, own.changes)
    if body.profile_mm is not None:
        from walkergen.shapes import outlines

        (side,) = outlines.polygon(body.profile_mm, "body.profile_mm")
        length, thickness = np.ptp(side, axis=0)
        return Shape(Size(float(length), float(thickness), body.depth_mm), side)
    plan, notes = _plan(body)
    length, depth = np.ptp(plan[0], axis=0)
    size = Size(float(length), body.thickness_mm, float(depth))
    sha256 = ""
    if body._drawing and body.outline is not None:
        from walkergen.shapes.contours import MOST_BYTES

        sha256 = hashlib.sha256(reading.content(Path(body.outline), MOST_BYTES)).hexdigest()
    return Shape(size, None, tuple(plan), sha256=sha256, changes=notes)


def _size_of(mesh: Mesh) -> Size:
    length, thickness, depth = np.ptp(mesh.vertices, axis=0)
    return Size(float(length), float(thickness), float(depth))


def _plan(body: Body) -> "Outline":
    """Outline in plan view, and what was left out of the file that it is from."""
    from walkergen.shapes import outlines
    from walkergen.shapes.outlines import Outline

    if body.text is not None:
        from walkergen.shapes.lettering import letters

        return Outline(letters(body.text, body.depth_mm, rails=body.rails_mm), ())
    if body.outline == "disc":
        return Outline(outlines.disc(body.length_mm, "body.length_mm"), ())
    if body.outline == "ellipse":
        return Outline(outlines.ellipse(body.length_mm, body.depth_mm), ())
    if body.points_mm is not None:
        return Outline(outlines.polygon(body.points_mm), ())
    assert body.outline is not None
    if Path(body.outline).suffix.lower() not in outlines.READERS:
        raise GeometryError(
            f"body.outline = {body.outline!r}: must be one of {', '.join(DRAWN)}, or a file "
            f"{' or '.join(outlines.READERS)}"
        )
    return outlines.from_file(Path(body.outline), body.scale_mm)
