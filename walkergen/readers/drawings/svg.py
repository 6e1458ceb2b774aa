"""SVG drawings: closed contours in mm are read from users' files, and polygons in mm are written.

A file is read in three steps. The standard library parses the XML and fetches nothing.
Style sheets become attributes (`svg_styles`). One walk of the tree finds the visible shapes
(`svg_elements`), which are flattened here.
"""

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn
from xml.parsers import expat

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting
from walkergen.core.numerics import Array
from walkergen.readers.drawings.contours import (
    FLATNESS,
    MAX_BYTES,
    MAX_END_GAP,
    Drawing,
    NoUnitError,
    Shape,
    flatten,
    is_within_gap,
)

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from walkergen.readers.drawings.svg_elements import Clip, Tree, VisibleShape

MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72.0, "pc": 25.4 / 6.0, "q": 0.25}
"""Units of length with a size of their own, in mm; a pixel has none until someone prints it."""

MAX_ENTITY_LENGTH = 200
"""Characters of an entity at most: drawing programs keep the names of namespaces in them."""

MIN_PAGE_SHARE = 0.99
"""Minimum size of a white rectangle that is the paper, as a share of the page along both sides."""

MIN_RECTANGLE_FILL = 0.9
"""Minimum share of its box that a rectangle fills: corners may be round."""

MAX_OVERHANG_SHARE = 0.01
"""Share of the page that a shape may reach beyond it without a note."""

LINE_WIDTH_WARNING = 0.01
"""Width of lines over the drawing's longer side. Above it a note states that the width is ignored."""

CLIP_TOLERANCE = 1e-6
"""Maximum share of a shape's area that a clip path may cut without a change to the shape: rounding."""


def pack(polygons: Sequence[Array]) -> bytes:
    """Return the bytes of an SVG file of polygons in mm, y up: one path, its size in mm, for laser cutters.

    The page is the polygons' bounding box. Nothing is filled, and lines are a hundredth of a
    millimetre wide, which cutters take for a cut. Equal polygons give equal bytes.
    """
    points = np.vstack(polygons)
    (left, bottom), (right, top) = points.min(axis=0), points.max(axis=0)
    page = f"{float(right - left)!r}", f"{float(top - bottom)!r}"
    path = " ".join(
        "M " + " L ".join(f"{float(x - left)!r},{float(top - y)!r}" for x, y in polygon) + " Z" for polygon in polygons
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{page[0]}mm" height="{page[1]}mm" '
        f'viewBox="0 0 {page[0]} {page[1]}">\n'
        f'<path fill="none" stroke="#000000" stroke-width="0.01" fill-rule="evenodd" d="{path}"/>\n'
        "</svg>\n"
    ).encode()


def read_drawing(path: Path, scale_mm: float | None, source: str) -> Drawing:
    """Read the closed contours of an SVG file, in mm, y up, a shape for every visible element.

    `scale_mm` (mm per unit of the drawing, that of its viewBox) takes precedence over the size that the file states.
    Left out, with a note, are elements without colour and a white page. Raises InputError, which begins with `source`,
    for a file that is no SVG, states no size in mm, cm, in, pt or pc while `scale_mm` is None, shows a picture or text,
    or an open path.
    """
    data = file_reading.read_bytes(path, MAX_BYTES)
    with file_reading.translate_library_errors(source, "SVG"):
        return _parse_drawing(data, scale_mm, source)


def _parse_drawing(data: bytes, scale_mm: float | None, source: str) -> Drawing:
    """Return the shapes in the bytes of an SVG file, and notes. The libraries may raise any exception."""
    from walkergen.readers.drawings import svg_elements, svg_styles, svg_tags

    root = _parse_xml(data, source)
    svg_tags.check_static(root, source)
    stated = {key: root.attrib[key] for key in ("width", "height") if _length_mm(root.attrib.get(key, "")) is not None}
    tree = svg_elements.Tree(root, source)
    try:
        svg_styles.apply_styles(root, source)
        root.attrib.update(stated)  # styles of the page are of a window, as 100 %
        scale = _mm_per_unit(root, source) if scale_mm is None else (scale_mm, scale_mm)
        page = _page_box(root, source)
        visible = tree.visible_shapes(page[2:])
        box = _bounding_box(visible)
        if not np.isfinite(box).all():
            raise InputError(f"{source}: a coordinate is not finite. Use numbers up to 1e300.")
        size = float((box[1] - box[0]).max()) if visible else 0.0
        shapes = [_clipped_shape(one, size, source) for one in visible]
    except RecursionError:
        raise InputError(f"{source}: elements are nested too deeply") from None
    except (ValueError, TypeError, IndexError, AttributeError, ZeroDivisionError) as error:
        raise InputError(f"{source}: a path cannot be read ({error!r:.80})") from error
    shapes, notes = _drop_page(visible, shapes, page)
    notes = [*_omission_notes(tree), *notes]
    if beyond := sum(_is_beyond_page(shape, page) for shape in shapes):
        notes.append(
            f"took {formatting.format_count(beyond, 'shape', 'shapes')} whole that the page's edge cuts in a browser"
        )
    if (line := max((one.line for one in visible), default=0.0)) > LINE_WIDTH_WARNING * size:
        notes.append(f"took lines without their width, up to {line * scale[0]:.3g} mm: their middle is the outline")
    to_mm = np.array([scale[0], -scale[1]])  # people see y down; the shape has it up
    return Drawing([Shape([ring * to_mm for ring in shape.contours], shape.nonzero) for shape in shapes], tuple(notes))


def _omission_notes(tree: "Tree") -> list[str]:
    """Return notes on elements that were left out."""
    notes = [f"left out {formatting.format_count(tree.unseen, 'hidden shape', 'hidden shapes')}"] if tree.unseen else []
    if tree.filtered:
        notes.append(
            f"left out {formatting.format_count(tree.filtered, 'filter', 'filters')}: shadows and blurs have no edge"
        )
    return notes


def _drop_page(
    visible: "Sequence[VisibleShape]", shapes: list[Shape], page: Sequence[float]
) -> tuple[list[Shape], list[str]]:
    """Return the shapes of `visible` without white ones as large as the page (left, top, width, height), and notes."""
    covers_page = [_is_page_rectangle(shape, page) for shape in shapes]
    is_paper = [covers and one.white for covers, one in zip(covers_page, visible, strict=True)]
    if any(is_paper) and not all(is_paper):
        left = [shape for shape, white in zip(shapes, is_paper, strict=True) if not white]
        return left, ["left out a white rectangle as large as the page"]
    if any(covers_page) and not all(covers_page):
        return shapes, ["took a rectangle as large as the page for a body, and what lies in it for holes"]
    return shapes, []


def _is_beyond_page(shape: Shape, page: Sequence[float]) -> bool:
    """Return whether a shape reaches beyond the page (left, top, width, height), if the page has a size."""
    points = np.vstack([np.zeros((0, 2)), *shape.contours])
    low, size = np.array(page[:2]), np.array(page[2:])
    margin = MAX_OVERHANG_SHARE * size if np.isfinite(size).all() else np.full(2, np.inf)
    return bool(((points < low - margin) | (points > low + size + margin)).any())


def _parse_xml(data: bytes, source: str) -> ET.Element:
    """Parse the XML and return its root. Raises InputError if it is no SVG, or has entities beyond short text."""

    def refuse(what: str) -> NoReturn:
        """Raise InputError for content that is not accepted."""
        raise InputError(f"{source}: it contains {what}. Save it as a plain SVG.")

    def check_entity(name: str, parameter: int, value: str | None, *elsewhere: Any) -> None:
        """Refuse an entity that is more than a few plain letters."""
        if parameter or value is None or "&" in value or len(value) > MAX_ENTITY_LENGTH:
            refuse(f"an entity ({name[:40]}) that is more than a few plain letters")

    def check_instruction(target: str, _: str) -> None:
        """Refuse the instruction that loads a style sheet."""
        if target == "xml-stylesheet":
            refuse("a style sheet from elsewhere")

    parser = expat.ParserCreate()
    parser.EntityDeclHandler, parser.ProcessingInstructionHandler = check_entity, check_instruction
    try:
        parser.Parse(data, True)
        root = ET.fromstring(data)
    except (expat.ExpatError, ET.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{source}: it is not an SVG file: {error}") from None
    name = str(root.tag).rpartition("}")[2]
    if name != "svg":
        raise InputError(f"{source}: it is not an SVG file: its root is <{name[:40]}>")
    return root


def _page_box(root: ET.Element, source: str) -> tuple[float, float, float, float]:
    """Return left, top, width and height of the page in the drawing's units, infinite without a page."""
    from walkergen.readers.drawings.svg_lengths import PIXELS_PER_UNIT
    from walkergen.readers.drawings.svg_matrices import parse_view_box

    if "viewBox" in root.attrib:
        return parse_view_box(root.attrib["viewBox"], source)
    sides = []
    for key in ("width", "height"):
        match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([a-zA-Z]*)\s*", root.attrib.get(key, ""))
        unit = PIXELS_PER_UNIT.get(match[2].lower()) if match else None
        sides.append(float(match[1]) * unit if match and unit else math.inf)
    return 0.0, 0.0, sides[0], sides[1]


def _mm_per_unit(root: ET.Element, source: str) -> tuple[float, float]:
    """Return the sizes in mm of a unit of the drawing along x and y, from the page's size and its viewBox."""
    from walkergen.readers.drawings.svg_matrices import fit_matrix, parse_view_box

    page = [_length_mm(root.attrib.get("width", "")), _length_mm(root.attrib.get("height", ""))]
    for index, (key, length) in enumerate(zip(("height", "width"), page, strict=True)):
        has_ratio = page[1 - index] is None and root.attrib.get(key, "auto") == "auto" and "viewBox" in root.attrib
        if length is not None and has_ratio:  # the ratio of the viewBox gives the other side
            box = parse_view_box(root.attrib["viewBox"], source)
            page[1 - index] = length * box[3 - index] / box[2 + index]
    if page[0] is None or page[1] is None:
        seen = " and ".join(
            f"{key} = {root.attrib[key][:20]!r}" if key in root.attrib else f"no {key}" for key in ("width", "height")
        )
        raise NoUnitError(
            f"{source}: states no size in mm ({seen}): set scale_mm, the mm per unit of the drawing "
            "(0.264583 for pixels of 96 to the inch, 0.352778 for those of Illustrator, 72 to the inch)"
        )
    if "viewBox" not in root.attrib:
        return 25.4 / 96.0, 25.4 / 96.0  # CSS: 96 units to the inch
    box = parse_view_box(root.attrib["viewBox"], source)
    if not (page[0] / box[2] > 0.0 and page[1] / box[3] > 0.0):
        raise InputError(f"{source}: a page of {page[0]:g} x {page[1]:g} mm; its width and height must be > 0")
    matrix = fit_matrix(box, page[0], page[1], root.attrib.get("preserveAspectRatio", ""))
    return float(matrix[0, 0]), float(matrix[1, 1])


def _length_mm(text: str) -> float | None:
    """Return a length with a physical unit, such as "3 cm", in mm, or None for any other text."""
    match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([a-zA-Z]+)\s*", text)
    try:
        return float(match[1]) * MM_PER_UNIT[match[2].lower()] if match else None
    except (ValueError, KeyError):
        return None


def _bounding_box(visible: "Sequence[VisibleShape]") -> Array:
    """Return the lower and upper corner of the drawing's contents, in its units, shape (2, 2)."""
    corners = [np.zeros((0, 2))]
    for one in visible:
        if (bounds := one.path.bbox()) is not None:
            x0, y0, x1, y1 = bounds
            box_corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)
            corners.append(box_corners @ one.matrix[:, :2].T + one.matrix[:, 2])
    points = np.vstack(corners)
    return np.array([points.min(axis=0), points.max(axis=0)]) if len(points) else np.zeros((2, 2))


def _clipped_shape(shape: "VisibleShape", size: float, source: str) -> Shape:
    """Return the contours of a shape in the drawing's units, cut by its clips. `size` is the drawing's longer side."""
    contours = list(_unclipped_contours(shape, size, source))
    for clip in shape.clips:
        if contours:
            contours, nonzero = _clip_contours(contours, shape.nonzero, clip, size, source)
            shape = shape._replace(nonzero=nonzero)
    return Shape(contours, shape.nonzero)


def _unclipped_contours(shape: "VisibleShape", size: float, source: str) -> "Sequence[Array]":
    """Return a shape's contours before clipping, for a drawing of this size. Raises InputError for an open path."""
    linear, offset = shape.matrix[:, :2], shape.matrix[:, 2]
    stretch, contours = float(np.linalg.norm(linear, 2)), []
    for subpath in shape.path.as_subpaths():
        local = _subpath_points(subpath, FLATNESS * size / max(stretch, 1e-300))
        if len(local) < 2:
            continue  # a pen that is moved and draws nothing
        points = local @ linear.T + offset
        if is_within_gap(points[0], points[-1], MAX_END_GAP * size):
            points = points[:-1]
        elif type(list(subpath)[-1]).__name__ != "Close":
            raise InputError(
                f"{source}: a path is open: it begins at {_format_point(local[0])} and ends at "
                f"{_format_point(local[-1])} of the drawing; close it (Z), leave it out, or make a path of its stroke"
            )
        contours.append(points)
    return contours


def _clip_contours(
    contours: Sequence[Array], nonzero: bool, clip: "Clip", size: float, source: str
) -> tuple[list[Array], bool]:
    """Clip contours to a clip's shapes, and return them and whether their fill rule is nonzero."""
    from shapely import union_all

    window = union_all([_filled_area(*_clipped_shape(shape, size, source)) for shape in clip.shapes])
    area = _filled_area(contours, nonzero)
    left = area.intersection(window)
    if left.area >= (1.0 - CLIP_TOLERANCE) * area.area:
        return list(contours), nonzero
    pieces = [piece for piece in getattr(left, "geoms", [left]) if piece.geom_type == "Polygon" and piece.area > 0.0]
    rings = [ring for piece in pieces for ring in (piece.exterior, *piece.interiors)]
    return [np.array(ring.coords)[:-1] for ring in rings], False


def _filled_area(contours: Sequence[Array], nonzero: bool) -> "BaseGeometry":
    """Return the area that contours fill by the rule nonzero, or else even-odd."""
    from shapely import Polygon, union_all

    rings = [Polygon(contour).buffer(0.0) for contour in contours if len(contour) > 2]
    if nonzero:
        return union_all(rings)
    area: BaseGeometry = Polygon()
    for ring in rings:
        area = area.symmetric_difference(ring)
    return area


def _is_page_rectangle(shape: Shape, page: Sequence[float]) -> bool:
    """Return whether a shape is a rectangle, perhaps with round corners, like the page (left, top, width, height)."""
    if len(shape.contours) != 1 or not all(map(math.isfinite, page)):
        return False
    x, y = shape.contours[0].T
    low, high = shape.contours[0].min(axis=0), shape.contours[0].max(axis=0)
    fills_box = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) >= MIN_RECTANGLE_FILL * math.prod(high - low)
    overlap = np.minimum(high, np.add(page[:2], page[2:])) - np.maximum(low, page[:2])
    return bool(fills_box and (overlap >= MIN_PAGE_SHARE * np.array(page[2:])).all())


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


def _format_point(point: Array) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
