"""DXF drawings: closed contours in mm are read from users' files, and polygons in mm are written, with ezdxf."""

import codecs
import io
import itertools
import math
import tempfile
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen import extras
from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting
from walkergen.core.numerics import Array
from walkergen.readers.drawings import dxf_curves
from walkergen.readers.drawings.contours import FLATNESS, MAX_BYTES, MAX_END_GAP, Drawing, NoUnitError, is_within_gap

if TYPE_CHECKING:
    from ezdxf import document as documents

DXF_VERSION = "R2000"
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
    "RAY",
    "TEXT",
    "TOLERANCE",
    "VIEWPORT",
    "XLINE",
}
"""Entities that explain or colour a drawing and are no outline."""

NOTED_ANNOTATIONS = {"ATTDEF", "ATTRIB", "HATCH", "MTEXT", "TEXT"}
"""Annotations that a user may have meant to be cut; a note says that they are left out."""

BINARY_SIGNATURE = b"AutoCAD Binary DXF"
"""Beginning of a binary DXF file."""

UNPLOTTED_LAYER = "defpoints"
"""Layer that no program plots, with any settings."""

UNITS_MM = {8: 25.4e-6, 9: 25.4e-3, 21: 1200e3 / 3937.0, 22: 100e3 / 3937.0}
"""Millimetres of units that ezdxf has no size of: microinches, mils, feet and inches of the US survey."""

PAPER_SIZES_MM = (
    (148, 210),
    (210, 297),
    (297, 420),
    (420, 594),
    (594, 841),
    (841, 1189),
    (215.9, 279.4),
    (279.4, 431.8),
)
"""Sides of sheets of paper, mm: A5 to A0, letter, tabloid."""

PAPER_TOLERANCE_MM = 0.5
"""Maximum sum of the differences between a rectangle's sides and those of a sheet, mm."""

MIN_BORDER_SHARE = 0.9
"""Minimum size of a rectangle that is a sheet's border, as a share of the sheet along both sides."""

FRAME_WARNING_MM = 100.0
"""Side of a rectangle around everything else, mm. Above it a note states that the rectangle is the body."""

LINE_WIDTH_WARNING = 0.01
"""Width of a polyline over the drawing's longer side. Above it a note states that the width is ignored."""

MAX_MENDED_GAP = 1e-4
"""Maximum gap between ends that are joined with a note, over the drawing's longer side: 3 um on 28 mm."""

COMPOSITE_ENTITIES = {"LWPOLYLINE", "POLYLINE"}
"""Entities that are split into others, in addition to blocks."""

XREF_FLAG = 4
"""Flag of a block that is another drawing."""

FULL_TURN_TOLERANCE = 1e-9
"""Maximum gap between the ends of a full ellipse, as a share of a turn."""

MAX_ENTITIES, MAX_BLOCK_DEPTH = 20_000, 16
"""Entities of a drawing at most, counted as often as blocks repeat them, and blocks in blocks."""


def pack(polygons: Sequence[Array]) -> bytes:
    """Return the bytes of a DXF file of polygons in mm: a closed polyline each, for laser cutters.

    Equal polygons give equal bytes with one version of ezdxf: no date, no random identifier.
    Raises InputError where ezdxf is not installed.
    """
    extras.require("drawings", "DXF")
    import ezdxf
    from ezdxf import units

    with _fixed_metadata():
        document = ezdxf.new(DXF_VERSION, units=units.MM)
        for polygon in polygons:
            document.modelspace().add_lwpolyline(polygon.tolist(), close=True)
        stream = io.StringIO(newline="\n")
        document.write(stream)
    return bytes(document.encode(stream.getvalue()))


@contextmanager
def _fixed_metadata() -> Iterator[None]:
    """Make ezdxf write fixed dates and identifiers within the context, by a global option of ezdxf."""
    import ezdxf

    options = ezdxf.options
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def read_drawing(path: Path, scale_mm: float | None, source: str) -> Drawing:
    """Read the closed contours of a DXF file's model space, in mm. Every second contour inward is a hole.

    Lines and curves that meet within MAX_END_GAP are joined, and shorter ones left out. Left out are also layers that
    are hidden or do not plot, ANNOTATIONS and, with a note, lines drawn twice and the frame of a sheet. `scale_mm` (mm
    per unit of the drawing) takes precedence over the unit that the file states, $INSUNITS. Raises InputError, which
    begins with `source`, for a file that is no DXF, states no unit while `scale_mm` is None, or holds open or branching
    lines, or anything else than plane curves.
    """
    data = file_reading.read_bytes(path, MAX_BYTES)
    with file_reading.translate_library_errors(source, "DXF"):
        return _parse_drawing(data, scale_mm, source)


def _parse_drawing(data: bytes, scale_mm: float | None, source: str) -> Drawing:
    """Return the contours, in mm, in the bytes of a DXF file, and notes. The library may raise any exception."""
    _check_ellipse_ratios(data, source)
    document = _parse_document(data)
    scale = _mm_per_unit(document, data, source) if scale_mm is None else scale_mm
    entities, notes = _collect_entities(document, source)
    if not entities:
        return Drawing([], tuple(notes))
    size = _drawing_size(entities, source)
    sampled = (dxf_curves.entity_points(entity, FLATNESS * size, source) for entity in entities)
    visible = [
        curve for curve in sampled if not np.ptp(curve, axis=0).max() <= MAX_END_GAP * size
    ]  # NaN is reported below
    curves, doubles = _remove_duplicates(visible, MAX_END_GAP * size)
    contours, gap_notes = _close_contours(curves, size, source)
    contours, frame_notes = _remove_frames([scale * contour for contour in contours])
    if doubles:
        notes.append(f"left out {formatting.format_count(doubles, 'line that is', 'lines that are')} drawn twice")
    if (width := max(map(_polyline_width, entities))) > LINE_WIDTH_WARNING * size:
        notes.append(f"took lines without their width, up to {width * scale:.3g} mm: their middle is the outline")
    return Drawing(contours, (*notes, *gap_notes, *frame_notes))


def _check_ellipse_ratios(data: bytes, source: str) -> None:
    """Raise InputError for an ellipse whose second axis is the longer one: ezdxf would turn it into a circle."""
    lines = [] if data.startswith(BINARY_SIGNATURE) else data.splitlines()
    kind = b""
    for code, value in zip(lines[::2], lines[1::2], strict=False):
        if code.strip() == b"0":
            kind = value.strip()
        elif kind == b"ELLIPSE" and code.strip() == b"40" and float(value) > 1.0 + 1e-9:
            raise InputError(f"{source}: an ELLIPSE has axes of the ratio {float(value):.4g}, at most 1. Redraw it.")


def _polyline_width(entity: Any) -> float:
    """Return the constant width of a polyline in units of the drawing, or 0 for other entities."""
    return float(entity.dxf.get("const_width", 0.0)) if entity.dxftype() == "LWPOLYLINE" else 0.0


def _remove_duplicates(curves: Sequence[Array], gap: float) -> tuple[list[Array], int]:
    """Return the curves without those drawn twice, in either direction, and the number of curves removed.

    Curves are equal if their ends and middles are in the same cells of a grid of 10 `gap`.
    """
    kept: dict[tuple[tuple[float, ...], ...], Array] = {}
    for curve in curves:
        is_closed = is_within_gap(curve[0], curve[-1], gap)
        ends = [curve.min(axis=0), curve.max(axis=0)] if is_closed else sorted([curve[0], curve[-1]], key=tuple)
        middle = curve[:-1].mean(axis=0) if is_closed else curve.mean(axis=0)
        key = tuple(tuple(np.round(point / (10.0 * gap)).tolist()) for point in (*ends, middle))
        kept.setdefault(key, curve)
    return list(kept.values()), len(curves) - len(kept)


def _remove_frames(contours: list[Array]) -> tuple[list[Array], list[str]]:
    """Return the contours without the frames and borders of a paper sheet around all others, and notes."""
    notes: list[str] = []
    sheet = np.full(2, np.inf)  # width and height of the frame found last
    while (index := _find_frame(contours)) is not None:
        size = np.ptp(contours[index], axis=0)
        is_paper = any(np.abs(np.sort(size) - sides).sum() < PAPER_TOLERANCE_MM for sides in PAPER_SIZES_MM)
        is_border = bool((size >= MIN_BORDER_SHARE * sheet).all())
        if not (is_paper or is_border):
            if size.max() > FRAME_WARNING_MM:
                notes.append(
                    f"took the rectangle of {size[0]:.4g} x {size[1]:.4g} mm for the body, and what lies in it for "
                    "holes. Leave it out if it is a frame"
                )
            break
        notes.append(
            f"left out a frame of {size[0]:.4g} x {size[1]:.4g} mm, {'a' if is_paper else 'in a'} sheet of paper"
        )
        contours, sheet = [*contours[:index], *contours[index + 1 :]], size
    return contours, notes


def _find_frame(contours: Sequence[Array]) -> int | None:
    """Return the index of the contour that is a rectangle around all others, or None if there is none."""
    lows, highs = (np.array([end(contour, axis=0) for contour in contours]) for end in (np.min, np.max))
    largest = int(np.argmax((highs - lows).prod(axis=1)))
    low, high, others = lows[largest], highs[largest], np.arange(len(contours)) != largest
    corners = len(contours[largest]) == 4 and np.isin(contours[largest], [low, high]).all()
    inside = (low < lows[others]).all() and (highs[others] < high).all()
    return largest if others.any() and corners and inside else None


def _parse_document(data: bytes) -> "documents.Drawing":
    """Parse the bytes of a DXF file with ezdxf, from a temporary copy: ezdxf opens files by their names.

    Raises InputError where ezdxf is not installed.
    """
    extras.require("drawings", "DXF")
    import ezdxf

    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "drawing.dxf"
        copy.write_bytes(data.removeprefix(codecs.BOM_UTF8))
        try:
            return ezdxf.readfile(copy)
        except StopIteration:
            raise ValueError("it breaks off") from None
        except OSError:  # names the copy
            raise ValueError("its first lines are not those of one") from None


def _mm_per_unit(document: "documents.Drawing", data: bytes, source: str) -> float:
    """Return the mm per unit of the drawing, from the file's $INSUNITS. Raises NoUnitError if it states none."""
    from ezdxf import units

    # Where a file has no header, ezdxf puts in its own, in metres: ask the file itself.
    unit = document.units if b"$INSUNITS" in data else 0
    if unit in UNITS_MM:
        return UNITS_MM[unit]
    factor = units.METER_FACTOR[unit] if 0 <= unit < len(units.METER_FACTOR) else None
    if factor is None:
        raise NoUnitError(
            f"{source}: states no unit ($INSUNITS = {unit}): set scale_mm, the mm per unit of the "
            "drawing (1 for mm, 25.4 for inches)"
        )
    return 25.4 if unit == units.IN else units.METER_FACTOR[units.MM] / factor


def _collect_entities(document: "documents.Drawing", source: str) -> tuple[list[Any], list[str]]:
    """Return visible lines and curves of the model space, with blocks and polylines split, and notes on the others.

    In a block, layer 0 is the layer of its insertion. If that layer is off, entities on other layers still show.
    """
    frozen = {layer.dxf.name.lower() for layer in document.layers if layer.is_frozen()}
    unplotted = {layer.dxf.name.lower() for layer in document.layers if not layer.dxf.get("plot", 1)} | {
        UNPLOTTED_LAYER
    }
    hidden = frozen | unplotted | {layer.dxf.name.lower() for layer in document.layers if layer.is_off()}
    waiting = deque((entity, 0, "0") for entity in document.modelspace())
    lines: list[Any] = []
    omissions: Counter[str] = Counter()
    seen = 0
    while waiting:
        entity, depth, outer_layer = waiting.popleft()
        kind, seen = entity.dxftype(), seen + 1
        if seen + len(waiting) > MAX_ENTITIES or depth > MAX_BLOCK_DEPTH:
            raise InputError(
                f"{source}: draws more than {MAX_ENTITIES} entities, or blocks more than {MAX_BLOCK_DEPTH} "
                "deep; simplify it"
            )
        layer = outer_layer if entity.dxf.layer == "0" else entity.dxf.layer.lower()
        if entity.dxf.get("invisible", 0) or layer in (frozen if kind == "INSERT" else hidden):
            omissions["hidden or not plotted"] += layer != UNPLOTTED_LAYER
        elif kind == "INSERT":
            block = entity.block()
            omissions["of another drawing"] += block is not None and bool(block.block.dxf.flags & XREF_FLAG)
            copies = itertools.islice(entity.multi_insert(), MAX_ENTITIES + 1) if entity.mcount > 1 else [entity]
            waiting += [(part, depth + 1, layer) for copy in copies for part in copy.virtual_entities()]
        elif kind in COMPOSITE_ENTITIES and not (entity.dxftype() == "LWPOLYLINE" and not entity.has_arc):
            if kind == "POLYLINE":
                _drop_control_points(entity)
            waiting += [(part, depth + 1, layer) for part in entity.virtual_entities()]
        elif kind not in ANNOTATIONS:
            lines.append(_normalize_ellipse(entity) if kind == "ELLIPSE" else entity)
        elif kind in NOTED_ANNOTATIONS:
            omissions[kind] += 1
    counts = [f"{count} {reason}" for reason, count in sorted(omissions.items()) if count]
    return lines, [f"left out {', '.join(counts)}"] if counts else []


def _normalize_ellipse(ellipse: Any) -> Any:
    """Return the ellipse, changed in place to begin at parameter 0 if it is complete: programs begin it anywhere."""
    turns = (ellipse.dxf.end_param - ellipse.dxf.start_param) / (2.0 * np.pi)
    if abs(turns - round(turns)) < FULL_TURN_TOLERANCE:
        ellipse.dxf.start_param, ellipse.dxf.end_param = 0.0, 2.0 * np.pi
    return ellipse


def _drop_control_points(polyline: Any) -> None:
    """Remove the control points of a smoothed polyline, which no program shows, in place."""
    from ezdxf.lldxf.const import VTX_SPLINE_FRAME_CONTROL_POINT as FRAME

    polyline.vertices[:] = [vertex for vertex in polyline.vertices if not vertex.dxf.get("flags", 0) & FRAME]


def _drawing_size(entities: Sequence[Any], source: str) -> float:
    """Return the longer side of the entities' bounding box, in units of the drawing. Raises InputError if unknown."""
    from ezdxf import bbox

    box = bbox.extents(entities, fast=True)
    size = max(box.size.x, box.size.y) if box.has_data else 0.0
    if not (np.isfinite(size) and size > 0.0):
        kinds = ", ".join(sorted({entity.dxftype() for entity in entities})[:5])
        raise InputError(f"{source}: its size is unknown. It contains only {kinds}.")
    return float(size)


def _close_contours(curves: Sequence[Array], size: float, source: str) -> tuple[list[Array], list[str]]:
    """Join open curves to closed contours. Return all contours, and notes on closed gaps. `size`: the drawing's."""
    gap, contours, open_curves = MAX_END_GAP * size, [], []
    for curve in curves:
        if not np.isfinite(curve).all():
            raise InputError(f"{source}: a coordinate is not finite. Draw the outline again.")
        if is_within_gap(curve[0], curve[-1], gap):
            contours.append(curve[:-1])
        else:
            open_curves.append(curve)
    chains, _ = _join_ends(open_curves, gap, source)
    if all(is_within_gap(chain[0], chain[-1], gap) for chain in chains):
        return [*contours, *(chain[:-1] for chain in chains)], []
    nearly_closed = [chain for chain in chains if is_within_gap(chain[0], chain[-1], MAX_MENDED_GAP * size)]
    open_chains = [chain for chain in chains if not is_within_gap(chain[0], chain[-1], MAX_MENDED_GAP * size)]
    open_chains, gaps = _join_ends(open_chains, MAX_MENDED_GAP * size, source)
    chains = [*nearly_closed, *open_chains]
    for chain in chains:
        width = math.dist(chain[0], chain[-1])
        if width > MAX_MENDED_GAP * size:
            raise InputError(
                f"{source}: a line is open: it begins at {_format_point(chain[0])} and ends at "
                f"{_format_point(chain[-1])}, "
                f"{width:.3g} apart. Close it."
            )
        gaps.append((chain[-1], width))
    notes = [
        f"closed a gap of {width:.2g} at {_format_point(place)} of the drawing" for place, width in gaps if width > gap
    ]
    return [*contours, *(chain[:-1] for chain in chains)], notes


def _join_ends(curves: Sequence[Array], gap: float, source: str) -> tuple[list[Array], list[tuple[Array, float]]]:
    """Join open curves whose ends lie within a gap. Return the joined curves, and position and width of each joint."""
    from ezdxf import edgeminer

    if not curves:
        return [], []
    edges = [edgeminer.make_edge(tuple(curve[0]), tuple(curve[-1]), payload=curve) for curve in curves]
    deposit = edgeminer.Deposit(edges, gap_tol=gap)
    for end in (end for edge in edges for end in (edge.start, edge.end)):
        if deposit.max_degree > 2 and len(deposit.edges_linked_to(end)) > 2:
            raise InputError(f"{source}: three or more lines meet in {_format_point(end)}. Keep only the outline.")
    chains, joints = [], []
    for chain in edgeminer.find_all_simple_chains(deposit):
        # The points of an edge that is reversed in its chain are still in the order of the drawing.
        parts = [edge.payload[::-1] if edge.is_reverse else edge.payload for edge in chain]
        joints += [(one[-1], math.dist(one[-1], other[0])) for one, other in itertools.pairwise(parts)]
        chains.append(np.vstack([parts[0], *(part[1:] for part in parts[1:])]))
    return chains, joints


def _format_point(point: Sequence[float] | Array) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
