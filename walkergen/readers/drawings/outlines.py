"""Outlines: shapes of bodies as polygons in mm, from lengths, points and users' drawings.

An outline is a list of polygons, shape (n, 2), mm, without a repeated last point: outer contours
counter-clockwise, holes clockwise, the outer ones first. The middle of its bounding box is the
origin. Outlines from all sources pass `from_contours`: one piece, no contour that crosses or
touches itself or another.
"""

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from walkergen.core.errors import GeometryError, InputError, Remedy
from walkergen.core.numerics import Array
from walkergen.readers.drawings import dxf, overlaps, silhouette, svg
from walkergen.readers.drawings.contours import MAX_POINTS, Drawing
from walkergen.readers.drawings.contours import area as area

Polygon = Array

ELLIPSE_SEGMENTS = 360
"""Edges of a disc or ellipse: 5.1e-5 of its area is missing, 0.5 micrometres at a disc of 28 mm."""

MIN_LENGTH_MM, MAX_LENGTH_MM, MAX_COORDINATE_MM = 0.1, 1000.0, 1e9
"""Limits of an outline's longer side, mm: beyond them a unit was mistaken."""

MAX_CONTOURS = 2000
"""Contours of an outline at most."""

MIN_WIDTH_RATIO = 1e-9
"""Width over length below which the points of a contour lie on a line."""

READERS = {
    ".svg": svg.read_drawing,
    ".svgz": svg.read_drawing,
    ".dxf": dxf.read_drawing,
    ".png": silhouette.read_drawing,
    ".jpg": silhouette.read_drawing,
    ".jpeg": silhouette.read_drawing,
}


class OverlapError(GeometryError):
    """Contours that cross or touch."""


def disc(diameter: float, source: str = "body.diameter_mm") -> list[Polygon]:
    """Return the outline of a disc of this diameter, mm: see `ellipse`. Raises GeometryError."""
    return ellipse(diameter, diameter, source)


def ellipse(length: float, depth: float, source: str = "body.length_mm") -> list[Polygon]:
    """Return the outline of an ellipse with these axes along x and y, mm, by ELLIPSE_SEGMENTS edges.

    The polygon is inscribed, its vertices on the ellipse and its bounding box exact. Mirrored in
    either axis it is the same, bit for bit. Its area is sin(t) / t of the ellipse's, t = 2 pi /
    ELLIPSE_SEGMENTS. Raises GeometryError, which begins with `source`.
    """
    angles = np.linspace(0.0, 0.5 * np.pi, ELLIPSE_SEGMENTS // 4 + 1)
    quarter = np.column_stack([np.cos(angles), np.sin(angles)])
    quarter[-1] = (0.0, 1.0)
    left = quarter[-2:0:-1] * np.array([-1.0, 1.0])
    upper = np.vstack([quarter, left])
    axes = 0.5 * np.array([length, depth])
    return from_contours([np.vstack([upper, -upper]) * axes], f"{source} = {length:g}")


def polygon(points: Sequence[Sequence[float]] | Polygon, source: str = "body.points_mm") -> list[Polygon]:
    """Return the outline with these corners, mm, in either sense of rotation. The last is joined to the first.

    Raises GeometryError, which begins with `source`, for fewer than three points, a repeated
    point, or an outline that `from_contours` refuses.
    """
    try:
        corners = np.array(points, dtype=np.float64)
    except (TypeError, ValueError):
        corners = np.empty(0)
    where = f"{source} = {len(points)} points"
    if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 3:
        raise GeometryError(f"{where}: it must have three points [x, y] or more, mm")
    _, first, number = np.unique(corners, axis=0, return_index=True, return_counts=True)
    if number.max() > 1:
        twice = corners[first[number > 1].min()]
        raise GeometryError(
            f"{where}: {_format_point(twice)} is given twice. Remove one (the last point is joined "
            "to the first automatically)."
        )
    return from_contours([corners], where)


class Outline(NamedTuple):
    """Outline from a file."""

    polygons: list[Polygon]
    notes: tuple[str, ...]
    """Notes on what was left out of the file or mended, a few words each."""


def from_file(
    path: Path,
    scale_mm: float | None = None,
    source: str = "body.outline",
    length_mm: float | None = None,
    mend: bool = False,
    connected: bool = True,
) -> Outline:
    """Return the outline of the body that a drawing or a picture shows, with y up.

    The file states the unit, unless `scale_mm` gives the mm per unit of the drawing, or `length_mm` the length of all.
    Where lines are outlines, as in DXF, a path inside another is a hole, and so on alternately; with `mend`,
    paths that cross or touch are united. If `connected`, there must be one piece. Raises InputError for a file that
    cannot be read (see svg.py, dxf.py and silhouette.py), NoUnitError for one that states no unit,
    GeometryError for a shape that `from_contours` refuses. All begin with `source` = the name.
    """
    where = f"{source} = {path.name!r}"
    if scale_mm is not None and not (np.isfinite(scale_mm) and scale_mm > 0.0):
        raise InputError(f"{where}: scale_mm = {scale_mm:g} must be a number > 0")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{where}: must be a drawing, .svg or .dxf, or a picture, .png or .jpg")
    drawing = reader(path, scale_mm if length_mm is None else 1.0, where)
    if length_mm is not None:
        drawing = _scale_to_length(drawing, length_mm)
    contours, contacts, notes = drawing.contours, drawing.contacts, drawing.notes
    try:
        polygons = from_contours(contours, where, connected, contacts)
    except OverlapError:
        if not mend:
            raise
        contours, contacts = overlaps.unite_contours(contours)
        polygons = from_contours(contours, where, connected, contacts)
        notes += ("united paths that cross or touch",)
    if contacts:
        places = ", ".join(map(_format_point, contacts[:3])) + (", ..." if len(contacts) > 3 else "")
        notes += (f"parts touch only in a point, and stay apart there: {places} mm",)
    return Outline(polygons, notes)


def _scale_to_length(drawing: Drawing, length: float) -> Drawing:
    """Return a drawing scaled to this length along x, mm."""
    x = np.concatenate([contour[:, 0] for contour in drawing.contours] or [np.zeros(1)])
    extent = float(np.ptp(x))
    scale = length / extent if 0.0 < extent < np.inf else 1.0
    contours, contacts = ([scale * points for points in group] for group in (drawing.contours, drawing.contacts))
    return drawing._replace(contours=contours, contacts=contacts)


def from_contours(
    contours: Sequence[Polygon], source: str, connected: bool = True, contacts: Sequence[Array] = ()
) -> list[Polygon]:
    """Return the contours of an outline, checked, sorted and centred. Every second contour inward is a hole.

    Raises GeometryError, which begins with `source`, for an outline without contours or area, with
    a number that is not finite, beyond MAX_POINTS, MAX_CONTOURS or the sizes allowed, with
    contours that cross or touch, or, where `connected`, of several pieces. `contacts`: points in which pieces touched.
    """
    contours = [_drop_repeated_points(contour) for contour in contours]
    try:
        _check_extent(contours)
        for contour in contours:
            _check_simple(contour)
        _check_apart(contours)
        are_holes = _find_holes(contours)
        pieces = [contour for contour, is_hole in zip(contours, are_holes, strict=True) if not is_hole]
        if connected and len(pieces) > 1:
            _refuse_pieces(pieces, contacts)
    except GeometryError as error:
        raise type(error)(f"{source}: {error.fault}", helps=error.helps) from None
    points = np.vstack(pieces)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return [
        _orient_contour(contour - middle, counter_clockwise=not wants_holes)
        for wants_holes in (False, True)
        for contour, is_hole in zip(contours, are_holes, strict=True)
        if is_hole == wants_holes
    ]


def _refuse_pieces(pieces: Sequence[Polygon], contacts: Sequence[Array]) -> NoReturn:
    """Raise GeometryError for an outline of several pieces, with the points in which they touch, if they do."""
    if contacts:
        where = f"that touch only in a point, at {_format_point(contacts[0])} mm. Let them overlap"
    else:
        where = f"as about {' and '.join(_format_point(piece.mean(axis=0)) for piece in pieces[:2])}. Join them"
    remedy = Remedy("join them by a base plate", {"body.repair": True})
    raise GeometryError(f"is in {len(pieces)} pieces, {where}, or keep one.", helps=partial(tuple, [remedy]))


def _drop_repeated_points(contour: Polygon) -> Polygon:
    """Return a contour without points that the next point repeats."""
    kept: Polygon = contour[np.any(contour != np.roll(contour, -1, axis=0), axis=1)]
    return kept


def _check_extent(contours: Sequence[Polygon]) -> None:
    """Raise GeometryError unless points are finite, and their number and the outline's size are allowed."""
    if not contours:
        raise GeometryError("draws no closed path")
    number = sum(map(len, contours))
    if number > MAX_POINTS or len(contours) > MAX_CONTOURS:
        raise GeometryError(
            f"has {number} points in {len(contours)} contours, more than {MAX_POINTS} in {MAX_CONTOURS}. Simplify it."
        )
    points = np.vstack(contours)
    within = (np.abs(points) <= MAX_COORDINATE_MM).all(axis=1)
    if not within.all():
        wrong = int(np.flatnonzero(~within)[0]) + 1
        raise GeometryError(
            f"point {wrong} is {_format_point(points[wrong - 1])}. Give finite numbers up to {MAX_COORDINATE_MM:g}"
        )
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if not MIN_LENGTH_MM <= size <= MAX_LENGTH_MM:
        hint = "micrometres" if size > MAX_LENGTH_MM else "metres or inches"
        raise GeometryError(
            f"is {size:g} mm long, allowed are {MIN_LENGTH_MM:g} to {MAX_LENGTH_MM:g} mm; were {hint} taken "
            "for millimetres?"
        )


def _check_simple(contour: Polygon) -> None:
    """Raise GeometryError when a contour encloses nothing, or crosses or touches itself."""
    from shapely import Polygon as Area
    from shapely.validation import explain_validity

    centred = contour - contour.mean(axis=0) if len(contour) else contour
    spread = np.linalg.svd(centred, compute_uv=False) if len(contour) > 2 else np.zeros(2)
    if len(contour) < 3 or spread[1] <= MIN_WIDTH_RATIO * spread[0]:
        raise OverlapError("has points on a line, that enclose no area")
    enclosed = Area(contour)
    if not enclosed.is_valid:
        match = re.search(r"\[(\S+) (\S+)\]", explain_validity(enclosed))
        place = f" at ({float(match[1]):.6g}, {float(match[2]):.6g}) mm" if match else ""
        raise OverlapError(f"crosses or touches itself{place}. Draw it as one simple loop.")


def _check_apart(contours: Sequence[Polygon]) -> None:
    """Raise GeometryError when two contours cross or touch, for example one that is drawn twice."""
    from shapely import STRtree, linearrings

    rings = [linearrings(contour) for contour in contours]
    for first, second in STRtree(rings).query(rings, predicate="intersects").T:
        if first < second:
            common = rings[first].intersection(rings[second]).representative_point()
            raise OverlapError(
                f"has two paths that cross or touch at ({common.x:.6g}, {common.y:.6g}) mm; unite "
                "them, or leave one out if it is drawn twice"
            )


def _find_holes(contours: Sequence[Polygon]) -> list[bool]:
    """Return for each contour whether it is a hole: it lies within an odd number of others."""
    from shapely import STRtree, points, polygons

    starts = points(np.array([contour[0] for contour in contours]))  # contours do not cross: a point will do
    inner, _ = STRtree([polygons(contour) for contour in contours]).query(starts, predicate="within")
    return [bool(count % 2) for count in np.bincount(inner, minlength=len(contours))]


def _orient_contour(contour: Polygon, counter_clockwise: bool) -> Polygon:
    """Return the contour with its points counter-clockwise, or else clockwise."""
    turned = contour if (area(contour) > 0.0) == counter_clockwise else contour[::-1]
    return np.ascontiguousarray(turned)


def _format_point(point: Polygon) -> str:
    x, y = np.round(point, 9) + 0.0  # no -1e-13
    return f"({x:.6g}, {y:.6g})"
