"""Shapes of bodies from the keys of their table [body]. Each file is read, mended and checked once."""

import hashlib
from collections.abc import Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.files import file_reading, formatting
from walkergen.core.numerics import Array
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.body import (
    BUILTIN_OUTLINES,
    DEFAULT_RAILS_MM,
    Body,
    FinishedWalker,
    Shape,
    Size,
    lay_down,
    rectangle_shape,
)
from walkergen.readers.drawings import outlines, overlaps, size_check
from walkergen.readers.drawings.contours import NoUnitError
from walkergen.readers.drawings.lettering import text_outline
from walkergen.readers.walkers import base, body_mesh, leg_cutting

MAX_SPECK_SHARE = 0.005
"""Area of a piece of a drawing, over the largest, below which it is dirt."""


class Plan(NamedTuple):
    """Outline seen from above."""

    contours: list[Array]
    """Outer contours and holes, shape (n, 2) each, mm."""
    notes: tuple[str, ...]
    pieces: int
    """Number of pieces, apart from each other."""
    assumption: str = ""
    """Size that was assumed because the file states none."""


def shape_of(body: Body) -> Shape:
    """Return the shape of a body. Raises GeometryError, and InputError for files."""
    if body.plain:
        return rectangle_shape(body.length_mm, body.thickness_mm, body.depth_mm)
    return shape_by_key(body.cache_key)


@lru_cache(maxsize=64)
def shape_by_key(keys: str) -> Shape:
    """Return the shape of a body that is no rectangle. `keys`: the body as JSON. Raises GeometryError or InputError."""
    body = Body.model_validate_json(keys)
    if body.mesh is not None:
        return _mesh_shape(body)
    if body.profile_mm is not None:
        (side,) = outlines.polygon(body.profile_mm, "body.profile_mm")
        length, thickness = np.ptp(side, axis=0)
        return Shape(Size(float(length), float(thickness), body.depth_mm), side)
    plan = _plan_view(body)
    if body.mirror:
        plan = plan._replace(contours=[(ring * (-1.0, 1.0))[::-1] for ring in plan.contours])
    contours, mesh, notes = plan.contours, None, plan.notes
    has_separate_pieces = plan.pieces > 1 or (body.text is not None and _rails_mm(body) is None)
    if body.base or (body.base is None and has_separate_pieces):
        contours, raised = base.add_to_outline(contours, body.thickness_mm)
        if plan.pieces > 1:
            notes += (f"joined {plan.pieces} pieces by a base plate",)
        mesh = lay_down(raised, _plan_size(contours, body.thickness_mm))
    size = _plan_size(contours, body.thickness_mm)
    file_name = body.outline if body.text is None else body.font
    sha256 = (
        ""
        if file_name is None or file_name in BUILTIN_OUTLINES
        else hashlib.sha256(file_reading.read_bytes(Path(file_name))).hexdigest()
    )
    return Shape(size, None, tuple(contours), mesh, sha256, notes, assumption=plan.assumption)


def _plan_size(contours: Sequence[Array], thickness: float) -> Size:
    """Return the size of a body of this thickness, mm, whose plan view has these contours."""
    length, depth = np.ptp(np.vstack(contours), axis=0)
    return Size(float(length), thickness, float(depth))


def _mesh_shape(body: Body) -> Shape:
    """Return the shape of a body, or of a finished walker, from its mesh file."""
    assert body.mesh is not None
    options = body_mesh.ReadOptions(
        body.scale_mm, body.given_length_mm, body.up, body.forward, body.repair, body.base, body.mirror
    )
    body_file = body_mesh.read_body(Path(body.mesh), options)
    mesh: Mesh = body_file.mesh
    finished: FinishedWalker | None = None
    if body.legs_below_mm is not None:
        cut = leg_cutting.centre_on_body(leg_cutting.cut_legs(mesh, body.legs_below_mm))
        mesh = cut.body
        finished = FinishedWalker(cut.mesh, cut.body, tuple(leg.mesh for leg in cut.legs), cut.limbs)
    return Shape(_mesh_size(mesh), None, (), mesh, body_file.sha256, body_file.changes, finished)


def _mesh_size(mesh: Mesh) -> Size:
    """Return the size of a mesh in the design's frame, mm."""
    length, thickness, depth = np.ptp(mesh.vertices, axis=0)
    return Size(float(length), float(thickness), float(depth))


def _plan_view(body: Body) -> Plan:
    """Return the outline in plan view, and notes on what was left out of its file."""
    if body.text is not None:
        return _text_plan(body)
    if body.outline == "disc":
        return Plan(outlines.disc(body.length_mm, "body.length_mm"), (), 1)
    if body.outline == "ellipse":
        return Plan(outlines.ellipse(body.length_mm, body.depth_mm), (), 1)
    if body.points_mm is not None:
        return Plan(outlines.polygon(body.points_mm), (), 1)
    assert body.outline is not None
    return _read_plan(body, Path(body.outline))


def _text_plan(body: Body) -> Plan:
    """Return the outline of the body's text. Without a base plate its letters must be one piece."""
    assert body.text is not None
    font = None if body.font is None else Path(body.font)
    height = body.depth_mm
    if body.given_length_mm is not None:
        contours = text_outline(body.text, 1.0, connected=False, font=font)
        height = body.given_length_mm / float(np.ptp(np.vstack(contours)[:, 0]))
    outline = text_outline(body.text, height, connected=body.base is False, rails=_rails_mm(body), font=font)
    return Plan(outline, (), len(overlaps.pieces(outline)))


def _rails_mm(body: Body) -> float | None:
    """Return the width of the bars that join the letters of a text, mm; None without bars.

    A single letter is too narrow to stand on legs without a base plate.
    """
    has_default = body.rails_mm is None and body.base is None and len(body.text or "") > 1
    return DEFAULT_RAILS_MM if has_default else body.rails_mm


def _read_plan(body: Body, path: Path) -> Plan:
    """Read the outline of a drawing or a picture, scaled as the body's keys state. Specks are dropped, with a note."""
    import shapely

    if path.suffix.lower() not in outlines.READERS:
        raise GeometryError(
            f"body.outline = {body.outline!r}: must be one of {', '.join(BUILTIN_OUTLINES)}, or a file "
            f"{', '.join(outlines.READERS)}"
        )
    assumption = ""
    read = partial(outlines.from_file, path, mend=body.repair, connected=not body.repair and body.base is None)
    try:
        outline = read(scale_mm=body.scale_mm, length_mm=body.given_length_mm)
    except NoUnitError:
        outline = read(length_mm=size_check.DEFAULT_LENGTH_MM)
        assumption = (
            f"made it {size_check.DEFAULT_LENGTH_MM:g} mm long, for it states no size: body.length_mm sets another"
        )
    if body.given_length_mm is None:
        size = float(np.ptp(np.vstack(outline.polygons), axis=0).max())
        size_check.check_size(size, f"body.outline = {path.name!r}", body.scale_mm or 1.0)
    pieces = overlaps.pieces(outline.polygons)
    kept = [piece for piece in pieces if piece.area > MAX_SPECK_SHARE * pieces[0].area]
    notes = outline.notes
    if specks := len(pieces) - len(kept):
        notes += (f"left out {formatting.format_count(specks, 'speck', 'specks')}",)
    if len(kept) > 1 and body.base is False:
        notes += (f"left out {formatting.format_count(len(kept) - 1, 'piece', 'pieces')} other than the largest",)
        kept = kept[:1]
    if len(kept) == len(pieces):
        return Plan(outline.polygons, notes, len(pieces), assumption)
    contours = overlaps.contours(shapely.union_all(kept))
    points = np.vstack(contours)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return Plan([ring - middle for ring in contours], notes, len(kept), assumption)
