"""Points of the curves of DXF drawings, from their own equations.

ezdxf's general path of an entity would replace arcs by cubic curves, up to 3e-4 of the radius away.
"""

import itertools
from functools import partial
from typing import Any

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.readers.drawings.contours import flatten


def entity_points(entity: Any, tolerance: float, source: str) -> Array:
    """Return the points of a line or curve, in units of the drawing, shape (n, 2); a loop's ends meet.

    Raises InputError, which begins with `source`, for what is no curve, draws nothing, or leaves the plane.
    """
    kind = entity.dxftype()
    if kind == "LINE":
        drawn = [entity.dxf.start, entity.dxf.end]
    elif kind == "LWPOLYLINE":
        drawn = list(entity.vertices_in_wcs())
        drawn += drawn[:1] if entity.closed else []
    elif kind == "SPLINE":
        drawn = _spline_points(entity, tolerance)
    elif kind in ("ARC", "CIRCLE", "ELLIPSE"):
        drawn = list(entity.flattening(tolerance))
    else:
        raise InputError(f"{source}: {kind} is not a plane curve. Draw lines, arcs, splines or polylines.")
    if len(drawn) < 2:
        raise InputError(f"{source}: a {kind} draws nothing (a radius of 0?). Remove it.")
    placed = np.array([tuple(point) for point in drawn], dtype=float)
    if np.ptp(placed[:, 2]) > tolerance:
        raise InputError(f"{source}: {kind} leaves the x-y plane. Draw the outline flat.")
    return placed[:, :2]


def _spline_points(entity: Any, tolerance: float) -> list[Any]:
    """Return the points of a spline. A closed one that ends elsewhere continues round its points."""
    from scipy.interpolate import BSpline, CubicSpline

    held, degree = np.array([tuple(point) for point in entity.control_points], dtype=float), entity.dxf.degree
    if _is_unclamped(entity):
        weights = np.array(entity.weights if len(entity.weights) else np.ones(len(held)))[:, None]
        curve = BSpline(np.array(entity.knots), np.hstack([weights * held, weights]), degree)
        return _sample_curve(curve, np.unique(curve.t[degree : len(held) + 1]), tolerance)
    points = list(entity.flattening(tolerance))
    if not entity.closed or not points or points[0].distance(points[-1]) <= tolerance:
        return points
    if len(entity.fit_points):
        through = np.array([tuple(point) for point in (*entity.fit_points, entity.fit_points[0])], dtype=float)
        lengths = np.linalg.norm(np.diff(through, axis=0), axis=1)
        knots = np.concatenate([[0.0], np.cumsum(lengths)])
        return _sample_curve(CubicSpline(knots, through, bc_type="periodic"), knots, tolerance)
    around = held[np.arange(len(held) + degree) % len(held)]
    curve = BSpline(np.arange(-degree, len(around) + 1, dtype=float), around, degree)
    return _sample_curve(curve, np.arange(len(held) + 1, dtype=float), tolerance)


def _is_unclamped(spline: Any) -> bool:
    """Return whether a spline's curve spans the inner knots alone, so that it does not end in its control points."""
    degree, knots, count = spline.dxf.degree, list(spline.knots), len(spline.control_points)
    if len(knots) != count + degree + 1 or count <= degree:
        return False
    return bool(knots[0] < knots[degree] or knots[count] < knots[-1])


def _sample_curve(curve: Any, knots: Array, tolerance: float) -> list[Any]:
    """Return the points of a curve over its knots; a fourth coordinate, the weight, divides the others."""
    spans = [flatten(partial(_evaluate_span, curve, low, high), tolerance) for low, high in itertools.pairwise(knots)]
    return [*(point for span in spans for point in span[:-1]), spans[-1][-1]]


def _evaluate_span(curve: Any, low: float, high: float, at: Array) -> Array:
    points = np.asarray(curve(low + at * (high - low)))
    return points[..., :3] / points[..., 3:] if points.shape[-1] == 4 else points
