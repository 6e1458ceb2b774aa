"""SVG drawings: closed contours in mm are read from users' files, and polygons in mm are written.

A file is read in three steps. The standard library parses the XML and fetches nothing.
Style sheets become attributes (`svg_styles`). One walk of the tree finds the visible shapes
(`svg_elements`), which are painted (`svg_painting`) as areas (`svg_areas`).
"""

import math
import re
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn
from xml.parsers import expat

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting
from walkergen.core.numerics import Array
from walkergen.readers.drawings.contours import MAX_BYTES, Drawing, NoUnitError, area
from walkergen.readers.drawings.overlaps import REGION_SIZE, Frame, frame_of, separate_contours, unite

if TYPE_CHECKING:
    from walkergen.readers.drawings.svg_elements import Tree, VisibleShape
    from walkergen.readers.drawings.svg_paints import Colour

MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72.0, "pc": 25.4 / 6.0, "q": 0.25}
"""Units of length with a size of their own, in mm; a pixel has none until someone prints it."""

MAX_ENTITY_LENGTH = 200
"""Characters of an entity at most: drawing programs keep the names of namespaces in them."""

MIN_PAGE_SHARE = 0.99
"""Minimum size of a white rectangle that is the paper, as a share of the page along both sides."""

MIN_RECTANGLE_FILL, MIN_SHARP_FILL = 0.9, 0.999
"""Minimum share of its box that a rectangle fills: the corners of white paper may be round. A coloured rectangle with
round corners is a thing."""

MAX_OVERHANG_SHARE = 0.01
"""Share of the page that a shape may reach beyond it without a note."""

MAX_LINE_SHARE, MAX_OUTLINE_SHARE = 0.01, 0.02
"""Width of a line over the drawing's longer side up to which it has no area, where anything is filled and where nothing
is: 0.3 and 0.6 mm on a body of 28 mm. A nozzle prints no ring that is thinner."""

MIN_MARGIN_SHARE = 0.01
"""Share of a filled area by which outlines around it must be larger to be the outline of a body."""


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
    """Read the contours of the body in an SVG file, in mm, y up: all that differs in colour from the paper.

    Shapes are painted in their order over white paper, or over a coloured rectangle as large as the page. Lines thinner
    than MAX_LINE_SHARE have no area. If a drawing has only thin closed lines, they are outlines, as in DXF.
    `scale_mm` (mm per unit of the drawing, that of its viewBox) takes precedence over the size that the file states.
    Raises InputError, which begins with `source`, for a file that is no SVG, states no size in mm, cm, in, pt or pc
    while `scale_mm` is None, shows a picture or text, or an open outline.
    """
    data = file_reading.read_bytes(path, MAX_BYTES)
    with file_reading.translate_library_errors(source, "SVG"):
        if data.startswith(b"\x1f\x8b"):  # .svgz
            data = zlib.decompressobj(wbits=31).decompress(data, MAX_BYTES)
        return _parse_drawing(data, scale_mm, source)


def _parse_drawing(data: bytes, scale_mm: float | None, source: str) -> Drawing:
    """Return the contours in the bytes of an SVG file, and notes. The libraries may raise any exception."""
    from walkergen.readers.drawings import svg_elements, svg_styles, svg_tags

    root = _parse_xml(data, source)
    svg_tags.check_static(root, source)
    stated = {key: root.attrib[key] for key in ("width", "height") if _length_mm(root.attrib.get(key, "")) is not None}
    tree = svg_elements.Tree(root, source)
    try:
        svg_styles.apply_styles(root, source)
        root.attrib.update(stated)  # a style sheet may set the page to the window's size, such as 100 %
        scale = _mm_per_unit(root, source) if scale_mm is None else (scale_mm, scale_mm)
        page = _page_box(root, source)
        visible = tree.visible_shapes(page[2:])
        if not np.isfinite(_bounding_box(visible)).all():
            raise InputError(f"{source}: a coordinate is not finite. Use numbers up to 1e300.")
        drawing = _paint_shapes(visible, page, source)
    except RecursionError:
        raise InputError(f"{source}: elements are nested too deeply") from None
    except (ValueError, TypeError, IndexError, AttributeError, ZeroDivisionError) as error:
        raise InputError(f"{source}: a path cannot be read ({error!r:.80})") from error
    notes = [*_omission_notes(tree), *drawing.notes]
    if _is_beyond_page(drawing.contours, page):
        notes.append("took whole what the page's edge cuts in a browser")
    to_mm = np.array([scale[0], -scale[1]])  # y is down in SVG, and up in the body
    contours, contacts = ([points * to_mm for points in group] for group in (drawing.contours, drawing.contacts))
    return Drawing(contours, tuple(notes), contacts)


def _omission_notes(tree: "Tree") -> list[str]:
    """Return notes on elements that were left out."""
    notes = [f"left out {formatting.format_count(tree.unseen, 'hidden shape', 'hidden shapes')}"] if tree.unseen else []
    if tree.filtered:
        notes.append(
            f"left out {formatting.format_count(tree.filtered, 'filter', 'filters')}: shadows and blurs have no edge"
        )
    return notes


def _paint_shapes(visible: "Sequence[VisibleShape]", page: Sequence[float], source: str) -> Drawing:
    """Return the contours of what shapes show on the page (left, top, width, height), in the drawing's units."""
    from walkergen.readers.drawings.svg_areas import coats, line_width
    from walkergen.readers.drawings.svg_painting import paint

    shapes, paper, notes = _choose_paper(visible, page)
    frame = frame_of(_bounding_box(shapes))
    has_fill = any(shape.fill.alpha > 0.0 for shape in shapes)
    thin = (MAX_LINE_SHARE if has_fill else MAX_OUTLINE_SHARE) * REGION_SIZE / frame.scale
    painted = paint(coats(shapes, frame, thin), paper)
    body = unite([area for area, colour in painted if colour.differs(paper)])
    outlined = [shape for shape in shapes if 0.0 < line_width(shape) <= thin]
    unfilled = [shape for shape in outlined if shape.fill.alpha == 0.0]
    if body.is_empty() and outlined:
        return Drawing(_thin_line_contours(outlined, frame, source), notes)
    if unfilled:
        contours = _thin_line_contours(unfilled, frame)
        around = frame.region(contours, nonzero=False)
        outside, share = (body - around).area(), MIN_MARGIN_SHARE * body.area()
        if outside < share and around.area() > body.area() + share:
            return Drawing(contours, (*notes, "took thin lines for the outline, and what is filled in them for marks"))
        notes += (f"left out {formatting.format_count(len(unfilled), 'thin line', 'thin lines')} without area",)
    if body.is_empty():
        body = unite([area for area, _ in painted])  # white on nothing
    contours, contacts = separate_contours(body, frame)
    return Drawing(contours, notes, contacts)


def _thin_line_contours(shapes: "Sequence[VisibleShape]", frame: Frame, source: str | None = None) -> list[Array]:
    """Return the contours that thin lines draw. Open lines are left out, or raise InputError if `source` is given."""
    from walkergen.readers.drawings.svg_areas import filled_area, subpaths

    contours = []
    for shape in shapes:
        parts = list(subpaths(shape, REGION_SIZE / frame.scale))
        for part in parts:
            if not (part.closed or shape.fill.alpha > 0.0) and source:
                begin, end = _format_point(part.local[0]), _format_point(part.local[-1])
                raise InputError(
                    f"{source}: a path is open: it begins at {begin} and ends at {end} of the drawing. Close it (Z), "
                    "leave it out, or make a path of its stroke"
                )
        closed = [part.points for part in parts if len(part.points) and (part.closed or shape.fill.alpha > 0.0)]
        contours += frame.contours(filled_area(shape, frame)) if shape.clips else closed
    return contours


def _choose_paper(
    visible: "Sequence[VisibleShape]", page: Sequence[float]
) -> "tuple[Sequence[VisibleShape], Colour, tuple[str, ...]]":
    """Return the shapes on the paper, the paper's colour, and notes. `page`: left, top, width and height.

    White rectangles and thin frames as large as the page are paper. A coloured rectangle below all shapes is paper if a
    shape has a third colour, and all are apart from the page's edge.
    """
    from walkergen.readers.drawings.svg_paints import WHITE

    covers = [_is_page_rectangle(shape, page) for shape in visible]
    blank = [cover and not _shows_on_white(shape, page) for cover, shape in zip(covers, visible, strict=True)]
    notes: tuple[str, ...] = ()
    if any(blank) and not all(blank):
        visible = [shape for shape, is_blank in zip(visible, blank, strict=True) if not is_blank]
        covers = [cover for cover, is_blank in zip(covers, blank, strict=True) if not is_blank]
        notes = ("left out a white or thin rectangle as large as the page",)
    if not any(covers) or all(covers):
        return visible, WHITE, notes
    sheet, others = visible[0].fill, visible[1:]
    opaque = [shape for shape in others if not shape.layers]
    colours = [colour for shape in opaque for colour in (shape.fill, shape.line.colour if shape.line else shape.fill)]
    has_third = any(paint.alpha == 1.0 and paint.differs(WHITE) and paint.differs(sheet) for paint in colours)
    low, high = _bounding_box(others) - np.array(page[:2])
    margin = (1.0 - MIN_PAGE_SHARE) * np.array(page[2:])
    is_apart = bool((low > margin).all() and (high < np.array(page[2:]) - margin).all())
    if covers[0] and sheet.alpha == 1.0 and has_third and is_apart:
        return others, sheet, (*notes, "took a coloured rectangle as large as the page for paper")
    if any(paint.differs(sheet) for paint in colours):
        notes += ("took a rectangle as large as the page for a body, and what is white in it for holes",)
    return visible, WHITE, notes


def _shows_on_white(shape: "VisibleShape", page: Sequence[float]) -> bool:
    """Return whether a shape's fill differs from white, or its line does and is not a thin one about the page."""
    from walkergen.readers.drawings.svg_areas import line_width
    from walkergen.readers.drawings.svg_paints import WHITE

    is_lined = line_width(shape) > MAX_LINE_SHARE * max(page[2:])
    return shape.fill.differs(WHITE) or bool(is_lined and shape.line and shape.line.colour.differs(WHITE))


def _is_beyond_page(contours: Sequence[Array], page: Sequence[float]) -> bool:
    """Return whether contours reach beyond the page (left, top, width, height), if the page has a size."""
    points = np.vstack([np.zeros((0, 2)), *contours])
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
    """Return left, top, width and height of the page in the drawing's units; infinite sides if unknown."""
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
    for shape in visible:
        if (bounds := shape.path.bbox()) is not None:
            x0, y0, x1, y1 = bounds
            box_corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)
            corners.append(box_corners @ shape.matrix[:, :2].T + shape.matrix[:, 2])
    points = np.vstack(corners)
    return np.array([points.min(axis=0), points.max(axis=0)]) if len(points) else np.zeros((2, 2))


def _is_page_rectangle(shape: "VisibleShape", page: Sequence[float]) -> bool:
    """Return whether a shape is a rectangle like the page (left, top, width, height). A white one may be rounded."""
    from walkergen.readers.drawings.svg_areas import subpaths
    from walkergen.readers.drawings.svg_paints import WHITE

    low, high = _bounding_box([shape])
    overlap = np.minimum(high, np.add(page[:2], page[2:])) - np.maximum(low, page[:2])
    if not (all(map(math.isfinite, page)) and (overlap >= MIN_PAGE_SHARE * np.array(page[2:])).all()):
        return False
    found = list(subpaths(shape, max(page[2:])))
    share = MIN_SHARP_FILL if shape.fill.differs(WHITE) else MIN_RECTANGLE_FILL
    return len(found) == 1 and abs(area(found[0].points)) >= share * math.prod(high - low)


def _format_point(point: Array) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
