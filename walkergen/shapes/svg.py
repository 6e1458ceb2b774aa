"""SVG drawings: closed contours in mm out of people's files, and polygons in mm into ours.

A file is read in two steps. The first takes XML apart with the standard library and refuses
whatever would make the shape other than what is read here: scripts, pictures, references to other
files, entities (so that nothing is fetched and nothing expands). The second leaves paths, basic
shapes, transforms and styles to svgelements. Not left to it: the page's size, whose inches it takes
with six digits, and curves, which it does not flatten.
"""

import io
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn
from xml.parsers import expat

import numpy as np

from walkergen.errors import InputError
from walkergen.files import reading
from walkergen.shapes.contours import FLATNESS, GAP, MOST_BYTES, Array, Shape, flatten, meet

if TYPE_CHECKING:
    import svgelements

MM = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72.0, "pc": 25.4 / 6.0, "q": 0.25}
"""Units of length with a size of their own, in mm; a pixel has none until someone prints it."""

UNREADABLE = {
    "script": "a script",
    "animate": "an animation",
    "animateTransform": "an animation",
    "animateMotion": "an animation",
    "set": "an animation",
    "image": "a picture",
    "text": "text",
    "foreignObject": "a foreign object",
    "clipPath": "a clip path",
    "mask": "a mask",
    "symbol": "a symbol",
    "marker": "a marker",
}
"""Elements that make what people see other than the closed paths of the file."""

NUMBER = r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?"
NUMBERS = {
    **dict.fromkeys(
        ("cx", "cy", "height", "r", "rx", "ry", "width", "x", "x1", "x2", "y", "y1", "y2"),
        re.compile(rf"\s*({NUMBER}\s*([a-zA-Z]{{1,2}}|%)?|auto)\s*"),
    ),
    "d": re.compile(r"[MmZzLlHhVvCcSsQqTtAa0-9eE.,+\-\s]*"),
    "points": re.compile(r"[0-9eE.,+\-\s]*"),
}
"""What attributes of shapes look like; svgelements leaves out what it cannot read."""

SHAPES = {"circle", "ellipse", "line", "path", "polygon", "polyline", "rect"}

MOST_ELEMENTS = 20_000
"""Elements of a drawing at most, counted as often as <use> repeats them."""


def pack(polygons: Sequence[Array]) -> bytes:
    """SVG file of polygons in mm, y up: one path, its size in mm, for laser cutters.

    The page is the polygons' bounding box; nothing is filled, and lines are a hundredth of a
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


def read(path: Path, scale_mm: float | None, source: str) -> list[Shape]:
    """Closed contours of an SVG file, in mm, y up, a shape for every element that draws.

    `scale_mm` (mm per unit of the drawing, that of its viewBox) comes before the size that the file
    states. Raises InputError, which begins with `source`, for a file that is no SVG, states no size
    in mm, cm, in, pt or pc while `scale_mm` is None, holds what UNREADABLE lists or an open path.
    """
    data = reading.content(path, MOST_BYTES)
    with reading.by_library(source, "SVG"):
        return _shapes(data, scale_mm, source)


def _shapes(data: bytes, scale_mm: float | None, source: str) -> list[Shape]:
    """Shapes in the bytes of a file; its library raises whatever it likes."""
    import svgelements

    root = _tree(data, source)
    _refuse_unreadable(root, source)
    scale = _scale(root, source) if scale_mm is None else (scale_mm, scale_mm)
    if "viewBox" in root.attrib:  # units of the drawing, then: the page's size is in `scale`
        for key in ("width", "height", "preserveAspectRatio"):
            root.attrib.pop(key, None)
    try:
        parsed = svgelements.SVG.parse(io.BytesIO(ET.tostring(root)), reify=False, on_error="raise")
        drawn = [svgelements.Path(element) for element in parsed.elements(_visible)]
        size = _size(drawn)
        if not math.isfinite(size):
            raise InputError(f"{source}: a coordinate is not finite; give numbers up to 1e300")
        return [_shape(path, size, scale, source) for path in drawn]
    except RecursionError:
        raise InputError(f"{source}: elements are nested too deeply") from None
    except (ValueError, TypeError, IndexError, AttributeError, ZeroDivisionError) as error:
        raise InputError(f"{source}: a path cannot be read ({error!r:.80})") from error


def _tree(data: bytes, source: str) -> ET.Element:
    """Root of the XML; entities and style sheets from elsewhere are refused before they act."""

    def refuse(what: str) -> NoReturn:
        raise InputError(f"{source}: holds {what}; save it as a plain SVG")

    parser = expat.ParserCreate()
    parser.EntityDeclHandler = lambda *_: refuse("an entity")
    parser.ProcessingInstructionHandler = lambda *_: refuse("a processing instruction")
    try:
        parser.Parse(data, True)
        root = ET.fromstring(data)
    except (expat.ExpatError, ET.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{source}: is no SVG file: {error}") from None
    if _name(root) != "svg":
        raise InputError(f"{source}: is no SVG file: its root is <{_name(root)[:40]}>")
    return root


def _refuse_unreadable(root: ET.Element, source: str) -> None:
    for element in root.iter():
        if (name := _name(element)) in UNREADABLE:
            hint = "convert it to paths" if name == "text" else "leave it out and save a plain SVG"
            raise InputError(f"{source}: holds {UNREADABLE[name]} (<{name}>); {hint}")
        if handler := next((key for key in element.attrib if key.lower().startswith("on")), None):
            raise InputError(f"{source}: holds a script ({handler}); save it as a plain SVG")
        for key, pattern in NUMBERS.items() if name in SHAPES else ():
            if not pattern.fullmatch(value := element.attrib.get(key, "0")):
                raise InputError(f"{source}: <{name}> has {key} = {value[:40]!r}; give numbers")
        if name == "style" and "@import" in (element.text or ""):
            raise InputError(f"{source}: its <style> imports another file; save it as a plain SVG")
    targets = {element.attrib["id"]: element for element in root.iter() if "id" in element.attrib}
    if _repeated(root, targets, {}, source) > MOST_ELEMENTS:
        raise InputError(f"{source}: draws more than {MOST_ELEMENTS} elements; simplify it")


def _repeated(
    element: ET.Element, targets: dict[str, ET.Element], counts: dict[ET.Element, float], source: str
) -> float:
    """Number of elements that are drawn, those that <use> repeats counted every time.

    Counted from the leaves, so that uses of uses cost no more than the file is long.
    """
    stack = [element]
    while stack:
        top = stack[-1]
        below = [*top, *_used(top, targets, source)]
        if top not in counts:
            counts[top] = math.nan  # being counted: met again, it uses itself
            stack += below
            continue
        stack.pop()
        if math.isnan(counts[top]):
            counts[top] = 1.0 + sum(counts[child] for child in below)
            if math.isnan(counts[top]):
                raise InputError(f"{source}: a <use> repeats itself without end")
    return counts[element]


def _used(element: ET.Element, targets: dict[str, ET.Element], source: str) -> Iterator[ET.Element]:
    """Element that a <use> repeats. Raises InputError when it is not in the file."""
    if _name(element) != "use":
        return
    for key, link in element.attrib.items():
        if key.rsplit("}", 1)[-1] == "href":
            if link[:1] != "#" or link[1:] not in targets:
                raise InputError(f"{source}: <use> refers to {link[:60]!r}, which the file does not hold")
            yield targets[link[1:]]


def _scale(root: ET.Element, source: str) -> tuple[float, float]:
    """Sizes in mm of a unit of the drawing along x and y, from the page's size and its viewBox."""
    page = _length(root.attrib.get("width", "")), _length(root.attrib.get("height", ""))
    if page[0] is None or page[1] is None:
        seen = " and ".join(
            f"{key} = {root.attrib[key][:20]!r}" if key in root.attrib else f"no {key}" for key in ("width", "height")
        )
        raise InputError(
            f"{source}: states no size in mm ({seen}): set scale_mm, the mm per unit of the "
            "drawing (0.264583 for pixels of 96 to the inch)"
        )
    if "viewBox" not in root.attrib:
        return 25.4 / 96.0, 25.4 / 96.0  # CSS: 96 units to the inch
    numbers = re.split(r"[\s,]+", root.attrib["viewBox"].strip())
    try:
        _, _, width, height = (float(number) for number in numbers)
        x, y = page[0] / width, page[1] / height
    except (ValueError, ZeroDivisionError):
        width = height = x = y = 0.0
    if not (x > 0.0 and y > 0.0):
        raise InputError(
            f"{source}: viewBox = {root.attrib['viewBox'][:60]!r}: must be four numbers, of which "
            "width and height are > 0, as those of the page must be"
        )
    fit = root.attrib.get("preserveAspectRatio", "")
    if "none" in fit:
        return x, y
    return (max(x, y),) * 2 if "slice" in fit else (min(x, y),) * 2


def _length(text: str) -> float | None:
    """Length with a physical unit, in mm; None for any other."""
    match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([a-zA-Z]+)\s*", text)
    try:
        return float(match[1]) * MM[match[2].lower()] if match else None
    except (ValueError, KeyError):
        return None


def _visible(element: Any) -> bool:
    import svgelements

    hidden = getattr(element, "values", {}).get("visibility") in ("hidden", "collapse")
    return isinstance(element, svgelements.Shape) and not hidden


def _size(paths: Sequence["svgelements.Path"]) -> float:
    """Longer side of what is drawn, in units of the drawing; 0 when nothing is."""
    boxes = np.array([box for path in paths if (box := path.bbox()) is not None], dtype=float)
    if not boxes.size:
        return 0.0
    return float((boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)).max())


def _shape(path: "svgelements.Path", size: float, scale: tuple[float, float], source: str) -> Shape:
    matrix = path.transform
    linear = np.array([[matrix.a, matrix.c], [matrix.b, matrix.d]])
    offset, stretch = np.array([matrix.e, matrix.f]), float(np.linalg.norm(linear, 2))
    contours = []
    for subpath in path.as_subpaths():
        own = _points(subpath, FLATNESS * size / max(stretch, 1e-300))
        if len(own) < 2:
            continue  # a pen that is moved and draws nothing
        # People see y down; the shape has it up.
        points = (own @ linear.T + offset) * np.array([scale[0], -scale[1]])
        if meet(points[0], points[-1], GAP * size * max(scale)):
            points = points[:-1]
        elif type(list(subpath)[-1]).__name__ != "Close":
            raise InputError(
                f"{source}: a path is open: it begins at {_shown(own[0])} and ends at "
                f"{_shown(own[-1])} of the drawing; close it (Z) or leave it out"
            )
        contours.append(points)
    return Shape(contours, str(path.values.get("fill-rule", "nonzero")) != "evenodd")


def _points(subpath: Any, tolerance: float) -> Array:
    """Points of a subpath, from its start, in the coordinates of its element, shape (n, 2)."""
    points: list[Any] = []
    for segment in subpath:
        kind = type(segment).__name__
        if kind == "Move":
            points.append(segment.end)
        elif kind in ("Line", "Close"):
            points += [segment.start, segment.end]
        else:
            points += list(flatten(partial(_at, segment), tolerance))
    return _array(points)


def _at(segment: Any, at: Array) -> Array:
    return _array(segment.npoint(at))


def _array(points: Any) -> Array:
    return np.array([(point[0], point[1]) for point in points], dtype=np.float64)


def _shown(point: Array) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def _name(element: ET.Element) -> str:
    """Name of an element without its namespace."""
    return str(element.tag).rsplit("}", 1)[-1]
