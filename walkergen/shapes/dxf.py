"""DXF drawings, by ezdxf: closed contours in mm out of people's files, polygons in mm into ours.

Curves are flattened from their own equations: ezdxf's general path of an entity would replace arcs
by cubic curves, 3e-4 of the radius beside them.
"""

import io
import itertools
import tempfile
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen import extras
from walkergen.errors import InputError
from walkergen.files import reading
from walkergen.shapes.contours import FLATNESS, GAP, MOST_BYTES, Array, Shape, meet

if TYPE_CHECKING:
    from ezdxf.document import Drawing

VERSION = "R2000"
"""Format of what is written: the oldest that states its unit, which every laser cutter reads."""

ANNOTATIONS = {
    "ARC_DIMENSION",
    "ATTDEF",
    "ATTRIB",
    "DIMENSION",
    "HATCH",
    "LEADER",
    "MTEXT",
    "MULTILEADER",
    "POINT",
    "TEXT",
    "TOLERANCE",
    "VIEWPORT",
}
"""Entities that explain or colour a drawing and are no outline."""

COMPOSITE = {"INSERT", "LWPOLYLINE", "POLYLINE"}
"""Entities that are taken apart into others."""

MOST_ENTITIES, DEEPEST = 20_000, 16
"""Entities of a drawing at most, counted as often as blocks repeat them, and blocks in blocks."""


def pack(polygons: Sequence[Array]) -> bytes:
    """DXF file of polygons in mm: a closed polyline each, for laser cutters.

    Equal polygons give equal bytes with one version of ezdxf: no date, no random identifier.
    Raises InputError where ezdxf is not installed.
    """
    extras.require("drawings", "DXF")
    import ezdxf
    from ezdxf import units

    with _without_dates():
        document = ezdxf.new(VERSION, units=units.MM)
        for polygon in polygons:
            document.modelspace().add_lwpolyline(polygon.tolist(), close=True)
        stream = io.StringIO(newline="\n")
        document.write(stream)
    return bytes(document.encode(stream.getvalue()))


@contextmanager
def _without_dates() -> Iterator[None]:
    """Guard in which ezdxf writes fixed dates and identifiers, by a switch of the whole process."""
    import ezdxf

    options = ezdxf.options
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def read(path: Path, scale_mm: float | None, source: str) -> list[Shape]:
    """Closed contours of a DXF file's model space, in mm, as one shape whose holes alternate.

    Lines and curves that meet within GAP are joined; hidden layers and ANNOTATIONS are left out.
    `scale_mm` (mm per unit of the drawing) comes before the unit that the file states, $INSUNITS.
    Raises InputError, which begins with `source`, for a file that is no DXF, states no unit while
    `scale_mm` is None, or holds open or branching lines, or anything else than plane curves.
    """
    data = reading.content(path, MOST_BYTES)
    with reading.by_library(source, "DXF"):
        return _shapes(data, scale_mm, source)


def _shapes(data: bytes, scale_mm: float | None, source: str) -> list[Shape]:
    """Shape in the bytes of a file; its library raises whatever it likes."""
    document = _document(data)
    scale = _scale(document, data, source) if scale_mm is None else scale_mm
    entities = list(_entities(document, source))
    if not entities:
        return []
    size = _size(entities, source)
    curves = [_points(entity, FLATNESS * size, source) for entity in entities]
    return [Shape([scale * polygon for polygon in _joined(curves, GAP * size, source)], nonzero=False)]


def _document(data: bytes) -> "Drawing":
    """Drawing of the bytes that were read, and no others: ezdxf opens files by their names.

    Raises InputError where ezdxf is not installed.
    """
    extras.require("drawings", "DXF")
    import ezdxf

    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "drawing.dxf"
        copy.write_bytes(data)
        try:
            return ezdxf.readfile(copy)
        except StopIteration:
            raise ValueError("it breaks off") from None


def _scale(document: "Drawing", data: bytes, source: str) -> float:
    """Millimetres per unit of the drawing, as $INSUNITS of the file states it."""
    from ezdxf import units

    # Where a file has no header, ezdxf puts in its own, in metres: ask the file itself.
    unit = document.units if b"$INSUNITS" in data else 0
    factor = units.METER_FACTOR[unit] if 0 <= unit < len(units.METER_FACTOR) else None
    if factor is None:
        raise InputError(
            f"{source}: states no unit ($INSUNITS = {unit}): set scale_mm, the mm per unit of the "
            "drawing (1 for mm, 25.4 for inches)"
        )
    return 25.4 if unit == units.IN else units.METER_FACTOR[units.MM] / factor


def _entities(document: "Drawing", source: str) -> Iterator[Any]:
    """Lines and curves of the model space that are seen, blocks and polylines taken apart."""
    hidden = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    waiting = deque((entity, 0) for entity in document.modelspace())
    seen = 0
    while waiting:
        entity, depth = waiting.popleft()
        kind, seen = entity.dxftype(), seen + 1
        if seen + len(waiting) > MOST_ENTITIES or depth > DEEPEST:
            raise InputError(
                f"{source}: draws more than {MOST_ENTITIES} entities, or blocks more than {DEEPEST} deep; simplify it"
            )
        if entity.dxf.layer.lower() in hidden or entity.dxf.get("invisible", 0):
            continue
        if kind == "INSERT" and entity.mcount > 1:
            copies = itertools.islice(entity.multi_insert(), MOST_ENTITIES + 1)
            waiting += [(part, depth + 1) for part in copies]
        elif kind in COMPOSITE and not _straight(entity):
            waiting += [(part, depth + 1) for part in entity.virtual_entities()]
        elif kind not in ANNOTATIONS:
            yield entity


def _straight(entity: Any) -> bool:
    """True for a polyline of straight lines, which is taken as it is."""
    return entity.dxftype() == "LWPOLYLINE" and not entity.has_arc


def _size(entities: Sequence[Any], source: str) -> float:
    """Longer side of what is drawn, in units of the drawing."""
    from ezdxf import bbox

    box = bbox.extents(entities, fast=True)
    size = max(box.size.x, box.size.y) if box.has_data else 0.0
    if not (np.isfinite(size) and size > 0.0):
        kinds = ", ".join(sorted({entity.dxftype() for entity in entities})[:5])
        raise InputError(f"{source}: has no size that can be told; it holds {kinds}")
    return float(size)


def _points(entity: Any, tolerance: float, source: str) -> Array:
    """Points of a line or curve, in units of the drawing, shape (n, 2); a loop's ends meet."""
    kind = entity.dxftype()
    if kind == "LINE":
        points = [entity.dxf.start, entity.dxf.end]
    elif kind == "LWPOLYLINE":
        points = list(entity.vertices_in_wcs())
        points += points[:1] if entity.closed else []
    elif kind in ("ARC", "CIRCLE", "ELLIPSE", "SPLINE"):
        points = list(entity.flattening(tolerance))
    else:
        raise InputError(f"{source}: {kind} is no plane curve; draw lines, arcs, splines, polylines")
    if len(points) < 2:
        raise InputError(f"{source}: a {kind} draws nothing (a radius of 0?); leave it out")
    placed = np.array([tuple(point) for point in points], dtype=float)
    if np.ptp(placed[:, 2]) > tolerance:
        raise InputError(f"{source}: {kind} leaves the x-y plane; draw the outline flat")
    return placed[:, :2]


def _joined(curves: Sequence[Array], gap: float, source: str) -> Iterator[Array]:
    """Closed contours out of closed curves, and of open ones joined end to end."""
    from ezdxf import edgeminer

    edges = []
    for curve in curves:
        if not np.isfinite(curve).all():
            raise InputError(f"{source}: a coordinate is not finite; draw the outline anew")
        if meet(curve[0], curve[-1], gap):
            yield curve[:-1]
        else:
            edges.append(edgeminer.make_edge(tuple(curve[0]), tuple(curve[-1]), payload=curve))
    if not edges:
        return
    deposit = edgeminer.Deposit(edges, gap_tol=gap)
    if deposit.max_degree > 2:
        raise InputError(f"{source}: three lines or more meet in a point; leave the outline alone")
    for chain in edgeminer.find_all_simple_chains(deposit):
        # An edge that was turned around in its chain still bears its points as they were drawn.
        parts = [edge.payload[::-1] if edge.is_reverse else edge.payload for edge in chain]
        points = np.vstack([parts[0], *(part[1:] for part in parts[1:])])
        if not meet(points[0], points[-1], gap):
            raise InputError(
                f"{source}: a line is open: it begins at ({points[0][0]:.6g}, {points[0][1]:.6g}) "
                f"and ends at ({points[-1][0]:.6g}, {points[-1][1]:.6g}); close it"
            )
        yield points[:-1]
