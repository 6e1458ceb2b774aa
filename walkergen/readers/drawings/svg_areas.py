"""Areas that an SVG drawing's shapes cover with their fills and lines, cut by clips."""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.readers.drawings import svg_painting
from walkergen.readers.drawings.contours import FLATNESS, MAX_END_GAP, flatten, is_within_gap
from walkergen.readers.drawings.overlaps import REGION_SIZE, Frame, Region, unite
from walkergen.readers.drawings.svg_lengths import parse_length
from walkergen.readers.drawings.svg_matrices import mean_stretch

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from walkergen.readers.drawings.svg_elements import Clip, Line, VisibleShape

MIN_CORNER_TURN = math.radians(20.0)
"""Turn between two edges that is a corner, with a tip or without. Chords of a curve turn by less."""

MAX_DASHES = 2000
"""Dashes of a line at most. A line with more is drawn through."""


class Subpath(NamedTuple):
    """Part of a path that is drawn without lifting the pen."""

    local: Array
    """Points in the units of its shape, shape (n, 2)."""
    points: Array
    """Points in the drawing's units, without the repeated last one of a closed subpath."""
    closed: bool


def subpaths(shape: "VisibleShape", size: float) -> Iterator[Subpath]:
    """Yield the subpaths of a shape. `size` is the drawing's longer side, in its units."""
    linear, offset = shape.matrix[:, :2], shape.matrix[:, 2]
    tolerance = FLATNESS * size / max(float(np.linalg.norm(linear, 2)), 1e-300)
    for subpath in shape.path.as_subpaths():
        local = _subpath_points(subpath, tolerance)
        if len(local) < 2:
            continue  # a pen that is moved and draws nothing
        local = local[np.append(True, np.any(np.diff(local, axis=0) != 0.0, axis=1))]
        points = local @ linear.T + offset
        meets = is_within_gap(points[0], points[-1], MAX_END_GAP * size)
        yield Subpath(local, points[:-1] if meets else points, meets or type(list(subpath)[-1]).__name__ == "Close")


def filled_area(shape: "VisibleShape", frame: Frame) -> Region:
    """Return the area that a shape fills, cut by its clips, as a region in `frame`. Open subpaths are closed."""
    contours = [subpath.points for subpath in subpaths(shape, REGION_SIZE / frame.scale)]
    return _apply_clips(frame.region(contours, shape.nonzero), shape, frame)


def line_area(shape: "VisibleShape", line: "Line", frame: Frame) -> Region:
    """Return the area that a shape's line covers, cut by its clips, as a region in `frame`."""
    import shapely

    size = REGION_SIZE / frame.scale
    tolerance = FLATNESS * size / max(float(np.linalg.norm(shape.matrix[:, :2], 2)), 1e-300)
    covered = [
        _stroke_area(part, line, tolerance)
        for subpath in subpaths(shape, size)
        for part in _split_into_dashes(subpath, line.style)
    ]
    parts = shapely.get_parts(shapely.union_all(covered))
    rings = [np.asarray(ring.coords) for part in parts for ring in (part.exterior, *part.interiors)]
    linear, offset = shape.matrix[:, :2], shape.matrix[:, 2]
    return _apply_clips(frame.region([ring @ linear.T + offset for ring in rings], nonzero=False), shape, frame)


def line_width(shape: "VisibleShape") -> float:
    """Return the width of a shape's line in the drawing's units, 0 without a line."""
    return shape.line.width * mean_stretch(shape.matrix) if shape.line else 0.0


def _apply_clips(region: Region, shape: "VisibleShape", frame: Frame) -> Region:
    """Cut a region by the clips of a shape."""
    for clip in shape.clips:
        region = region ^ _clip_area(clip, frame)
    return region


def _clip_area(clip: "Clip", frame: Frame) -> Region:
    """Return the area that a clip leaves visible: the union of its shapes, or where its mask is light."""
    if not clip.is_mask:
        return unite([filled_area(shape, frame) for shape in clip.shapes])
    painted = svg_painting.paint(coats(clip.shapes, frame, 0.0))
    light = [area for area, colour in painted if colour.alpha * (1.0 if clip.by_alpha else colour.luminance) >= 0.5]
    return unite(light)


def coats(shapes: "Sequence[VisibleShape]", frame: Frame, thinnest: float) -> "list[svg_painting.Coat]":
    """Return the coats of paint of shapes, lowest first. Lines no wider than `thinnest` (drawing's units) have none."""
    found = []
    for shape in shapes:
        parts = []
        if shape.fill.alpha > 0.0:
            parts.append(svg_painting.Coat(filled_area(shape, frame), shape.fill, shape.layers))
        if shape.line and line_width(shape) > thinnest:
            coat = svg_painting.Coat(line_area(shape, shape.line, frame), shape.line.colour, shape.layers)
            line_first = shape.line.style.get("paint-order", "").split()[:1] == ["stroke"]
            parts.insert(0 if line_first else len(parts), coat)
        found += parts
    return found


def _split_into_dashes(subpath: Subpath, style: Mapping[str, str]) -> list[Subpath]:
    """Return the dashes of a subpath's line, or the subpath itself for a line without dashes."""
    from shapely import LineString
    from shapely.ops import substring

    texts = style.get("stroke-dasharray", "none").replace(",", " ").split()
    lengths = [parse_length(text, 16.0, 16.0, math.nan) for text in texts]
    points = np.vstack([subpath.local, subpath.local[:1]]) if subpath.closed else subpath.local
    total = float(np.hypot(*np.diff(points, axis=0).T).sum())
    period = sum(lengths) * (1 + len(lengths) % 2)
    if not (lengths and min(lengths) >= 0.0 and period > 0.0 and total / period * len(lengths) < MAX_DASHES):
        return [subpath]
    line, dashes, start, number = LineString(points), [], 0.0, 0
    while start < total:
        end = start + lengths[number % len(lengths)]
        if number % 2 == 0:
            dash = np.asarray(substring(line, start, min(end, total)).coords)
            dashes.append(Subpath(dash, dash, closed=False))
        start, number = end, number + 1
    return dashes


def _stroke_area(subpath: Subpath, line: "Line", tolerance: float) -> "BaseGeometry":
    """Return the area that a line along a subpath covers, in the shape's units."""
    import shapely

    radius, style = 0.5 * line.width, line.style
    quarter = min(max(math.ceil(0.25 * math.pi / math.sqrt(min(2.0 * tolerance / radius, 1.0))), 4), 90)
    cap = {"round": "round", "square": "square"}.get(style.get("stroke-linecap", ""), "flat")
    points = subpath.local
    if subpath.closed and (points[0] == points[-1]).all():
        points = points[:-1]
    if len(points) < 2:
        dot = shapely.Point(subpath.local[0])
        return shapely.Polygon() if cap == "flat" else dot.buffer(radius, quad_segs=quarter, cap_style=cap)
    if style.get("stroke-linejoin", "") == "round":
        path = np.vstack([points, points[:1]]) if subpath.closed else points
        return shapely.LineString(path).buffer(radius, quad_segs=quarter, cap_style=cap, join_style="round")
    is_bevel = style.get("stroke-linejoin", "") == "bevel"
    limit = 1.0 if is_bevel else parse_length(style.get("stroke-miterlimit", "4"), 0.0, 0.0, 0.0)
    return _mitred_area(points, subpath.closed, radius, limit, cap)


def _mitred_area(points: Array, closed: bool, radius: float, limit: float, cap: Any) -> "BaseGeometry":
    """Return the area of a line along points, with pointed corners where `limit` (the SVG miter limit) allows them."""
    import shapely

    whole = np.vstack([points, points[:1]]) if closed else points
    areas = [shapely.LineString(whole).buffer(radius, cap_style=cap, join_style="bevel")]
    before, after = (points - np.roll(points, 1, axis=0)), (np.roll(points, -1, axis=0) - points)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    long = 1.0 / np.maximum(np.cos(0.5 * turns), 1e-9) > limit
    ends = slice(None) if closed else slice(1, -1)
    for index in np.arange(len(points))[ends][~long[ends] & (turns[ends] > MIN_CORNER_TURN)]:
        arms = np.array([points[index] - before[index], points[index], points[index] + after[index]])
        lengths = np.hypot(*np.array([before[index], after[index]]).T)
        arms[[0, 2]] = points[index] + np.minimum(radius / lengths, 1.0)[:, None] * (arms[[0, 2]] - points[index])
        areas.append(shapely.LineString(arms).buffer(radius, cap_style="flat", join_style="mitre", mitre_limit=limit))
    return shapely.union_all(areas)


def _subpath_points(subpath: Any, tolerance: float) -> Array:
    """Return the points of a subpath, from its start, in the coordinates of its element, shape (n, 2)."""
    points: list[Any] = []
    for segment in subpath:
        kind = type(segment).__name__
        if kind == "Move":
            points.append(segment.end)
        elif kind in ("Line", "Close"):
            points += [segment.start, segment.end]
        else:
            points += list(flatten(partial(_evaluate_segment, segment), tolerance))
    return _to_array(points)


def _evaluate_segment(segment: Any, parameters: Array) -> Array:
    """Return points of a segment of svgelements at parameters of 0 to 1, shape (n, 2)."""
    return _to_array(segment.npoint(parameters))


def _to_array(points: Any) -> Array:
    """Convert points of svgelements to an array, shape (n, 2)."""
    return np.array([(point[0], point[1]) for point in points], dtype=np.float64)
