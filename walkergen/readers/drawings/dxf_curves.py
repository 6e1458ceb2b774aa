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
    """Return the points of a line or curve, in the drawing's units, shape (n, 2). Closed curves repeat their start.

    Raises InputError, which begins with `source`, for an entity that is no curve, draws nothing, or leaves the plane.
    """
    kind = entity.dxftype()
    if kind == "LINE":
        points = [entity.dxf.start, entity.dxf.end]
    elif kind == "LWPOLYLINE":
        points = list(entity.vertices_in_wcs())
        points += points[:1] if entity.closed else []
    elif kind == "SPLINE":
        points = _spline_points(entity, tolerance)
    elif kind in ("ARC", "CIRCLE", "ELLIPSE"):
        points = list(entity.flattening(tolerance))
    else:
        raise InputError(f"{source}: {kind} is not a plane curve. Draw lines, arcs, splines or polylines.")
    if len(points) < 2:
        raise InputError(f"{source}: a {kind} draws nothing (a radius of 0?). Remove it.")
    coordinates = np.array([tuple(point) for point in points], dtype=float)
    if np.ptp(coordinates[:, 2]) > tolerance:
        raise InputError(f"{source}: {kind} leaves the x-y plane. Draw the outline flat.")
    return coordinates[:, :2]


def _spline_points(entity: Any, tolerance: float) -> list[Any]:
    """Return the points of a spline. If it is marked as closed but its ends are apart, it is continued to its start."""
    from scipy.interpolate import BSpline, CubicSpline

    control_points, degree = np.array([tuple(point) for point in entity.control_points], dtype=float), entity.dxf.degree
    if _is_unclamped(entity):
        weights = np.array(entity.weights if len(entity.weights) else np.ones(len(control_points)))[:, None]
        curve = BSpline(np.array(entity.knots), np.hstack([weights * control_points, weights]), degree)
        return _sample_curve(curve, np.unique(curve.t[degree : len(control_points) + 1]), tolerance)
    points = list(entity.flattening(tolerance))
    if not entity.closed or not points or points[0].distance(points[-1]) <= tolerance:
        return points
    if len(entity.fit_points):
        fit_points = np.array([tuple(point) for point in (*entity.fit_points, entity.fit_points[0])], dtype=float)
        lengths = np.linalg.norm(np.diff(fit_points, axis=0), axis=1)
        knots = np.concatenate([[0.0], np.cumsum(lengths)])
        return _sample_curve(CubicSpline(knots, fit_points, bc_type="periodic"), knots, tolerance)
    wrapped_points = control_points[np.arange(len(control_points) + degree) % len(control_points)]
    curve = BSpline(np.arange(-degree, len(wrapped_points) + 1, dtype=float), wrapped_points, degree)
    return _sample_curve(curve, np.arange(len(control_points) + 1, dtype=float), tolerance)


def _is_unclamped(spline: Any) -> bool:
    """Return whether a spline's curve spans only its inner knots, so that it does not end in its control points."""
    degree, knots, count = spline.dxf.degree, list(spline.knots), len(spline.control_points)
    if len(knots) != count + degree + 1 or count <= degree:
        return False
    return bool(knots[0] < knots[degree] or knots[count] < knots[-1])


def _sample_curve(curve: Any, knots: Array, tolerance: float) -> list[Any]:
    """Return points of a curve, a function of its parameter, from its first to its last knot. See `_evaluate_span`."""
    spans = [flatten(partial(_evaluate_span, curve, low, high), tolerance) for low, high in itertools.pairwise(knots)]
    return [*(point for span in spans for point in span[:-1]), spans[-1][-1]]


def _evaluate_span(curve: Any, low: float, high: float, shares: Array) -> Array:
    """Return points between two knots, at `shares` (0 to 1), shape (n, 3). A curve's fourth coordinate is a weight."""
    points = np.asarray(curve(low + shares * (high - low)))
    return points[..., :3] / points[..., 3:] if points.shape[-1] == 4 else points
