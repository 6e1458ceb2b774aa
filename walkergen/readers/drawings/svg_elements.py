"""Elements of an SVG drawing: those that somebody sees, where they stand, and what cuts them.

The tree is walked once, as a browser does: <use> and <symbol> stand for what they repeat, a nested
<svg> has its own units and is a window, clip paths cut. Geometry of single elements and transforms
are read by svgelements.
"""

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.readers.drawings import svg_paints, svg_styles
from walkergen.readers.drawings.svg_matrices import fitted, stretch, times, transform, view_box
from walkergen.readers.drawings.svg_paints import NUMBER, XLINK

if TYPE_CHECKING:
    import svgelements

Array = npt.NDArray[np.float64]

SVG = "{http://www.w3.org/2000/svg}"

SHAPES = ("circle", "ellipse", "line", "path", "polygon", "polyline", "rect")
GROUPS = ("a", "g", "switch", "svg", "use")

UNREADABLE = {"image": "a picture", "text": "text", "foreignObject": "a foreign object"}
"""Elements that people see and that are no closed paths."""

ACTIVE = {
    "script": "a script",
    "animate": "an animation",
    "animateTransform": "an animation",
    "animateMotion": "an animation",
    "set": "an animation",
}
"""Elements that would change the drawing."""

MOST_ELEMENTS, DEEPEST = 20_000, 256
"""Elements of a drawing at most, counted as often as <use> repeats them, and levels of them."""

LENGTH = re.compile(rf"\s*({NUMBER})([a-zA-Z]{{0,3}}|%)\s*")
PATH = re.compile(r"[MmZzLlHhVvCcSsQqTtAa0-9eE.,+\-\s]*")
POINTS = re.compile(r"[0-9eE.,+\-\s]*")

PIXELS = {"": 1.0, "px": 1.0, "in": 96.0, "cm": 96 / 2.54, "mm": 96 / 25.4, "q": 96 / 101.6, "pt": 96 / 72, "pc": 16.0}
"""Units of length, in the drawing's own units, as CSS has them."""

FONT = 16.0
"""Size of a font that nobody has set."""

FONTS = {
    "xx-small": 9.0,
    "x-small": 10.0,
    "small": 13.0,
    "medium": FONT,
    "large": 18.0,
    "x-large": 24.0,
    "xx-large": 32.0,
}
"""Sizes of fonts that browsers have names of."""


class Drawn(NamedTuple):
    """Shape that somebody sees."""

    path: "svgelements.Path"
    """Its geometry in its own units."""
    matrix: Array
    """From there to the drawing's units, shape (2, 3)."""
    nonzero: bool
    """Fill rule."""
    white: bool
    """Whether all of it is white."""
    line: float
    """Width of the line around it, in the drawing's units; 0 without."""
    clips: "tuple[Clip, ...]"
    """What cuts it, one after the other."""


class Clip(NamedTuple):
    """Window: the union of shapes."""

    shapes: tuple[Drawn, ...]


class Place(NamedTuple):
    """Where an element stands: what it has of those around it."""

    matrix: Array
    style: Mapping[str, str]
    """Inherited properties."""
    view: tuple[float, float]
    """Width and height that percents are of."""
    clips: tuple[Clip, ...] = ()
    depth: int = 0
    inside: tuple[ET.Element, ...] = ()
    """Elements that <use> stands for at present: none may stand for itself."""
    cutting: bool = False
    """True in a clip path, whose shapes cut whatever their colour."""


class Tree:
    """A drawing whose elements are walked; it counts them, and those that nobody sees."""

    def __init__(self, root: ET.Element, source: str) -> None:
        self.root, self.source = root, source
        # of two with one id browsers take the first
        self.targets = {one.attrib["id"]: one for one in reversed([*root.iter()]) if "id" in one.attrib}
        self.count = self.unseen = self.filtered = 0
        self.rem = FONT

    def drawn(self, view: tuple[float, float]) -> list[Drawn]:
        """Shapes that somebody sees, in their order; `view` is the page in the drawing's units."""
        if self.root.attrib.get("transform", "none").strip() not in ("", "none"):
            raise self._refuse("the page itself has a transform; apply it to the paths")
        place = self._inside(self.root, Place(np.eye(2, 3), {}, view))
        self.rem = float(place.style["font-size"])
        return [shape for child in self.root for shape in self._walk(child, place)]

    def _refuse(self, what: str) -> InputError:
        return InputError(f"{self.source}: {what}")

    def _inside(self, element: ET.Element, place: Place) -> Place:
        """Place of what an element holds."""
        own = {
            key: element.attrib[key] for key in svg_styles.INHERITED if element.attrib.get(key, "inherit") != "inherit"
        }
        style = {**place.style, **own}
        style["font-size"] = repr(self._font(element.attrib.get("font-size"), place))
        return place._replace(style=style, depth=place.depth + 1)

    def _font(self, text: str | None, place: Place) -> float:
        around, word = float(place.style.get("font-size", FONT)), (text or "1em").strip().lower()
        if size := {**FONTS, "larger": 1.2 * around, "smaller": around / 1.2, "inherit": around}.get(word):
            return size
        match, units = LENGTH.fullmatch(word), {**PIXELS, **self._relative(around), "%": 0.01 * around}
        return float(match[1]) * units.get(match[2], math.nan) if match else math.nan

    def _relative(self, font: float) -> dict[str, float]:
        """Units of length by the size of the font."""
        return {"em": font, "ex": 0.5 * font, "ch": 0.5 * font, "rem": self.rem}

    def _walk(self, element: ET.Element, place: Place) -> Iterator[Drawn]:
        """Shapes that an element draws."""
        name = name_of(element)
        self.count += 1
        if self.count > MOST_ELEMENTS:
            raise self._refuse(f"draws more than {MOST_ELEMENTS} elements; simplify it")
        if place.depth > DEEPEST:
            raise self._refuse("elements are nested too deeply")
        if name not in (*SHAPES, *GROUPS, *UNREADABLE):
            return
        inner = self._inside(element, place)
        if self._hidden(element, inner):
            self.unseen += name in SHAPES
            return
        if name in UNREADABLE:
            hint = "convert it to paths" if name == "text" else "leave it out and save a plain SVG"
            raise self._refuse(f"holds {UNREADABLE[name]} (<{name}>); {hint}")
        inner = inner._replace(matrix=self._moved(element, inner), clips=inner.clips)
        inner = inner._replace(clips=(*inner.clips, *self._cuts(element, inner)))
        if name in SHAPES:
            yield from self._shape(element, inner)
        elif name == "use":
            yield from self._used(element, inner)
        elif name == "svg":
            yield from self._window(element, inner, element.attrib)
        else:
            children = [child for child in element if isinstance(child.tag, str)]
            if name == "switch":  # the first that asks for nothing special
                children = [child for child in children if _suits(child)][:1]
            for child in children:
                yield from self._walk(child, inner)

    def _hidden(self, element: ET.Element, place: Place) -> bool:
        """Whether an element and all that it holds is hidden, whatever its parts say."""
        filtered, name = element.attrib.get("filter", "none").strip(), name_of(element)
        if element.attrib.get("display") == "none":
            return True
        if name in UNREADABLE and place.style.get("visibility", "visible") != "visible":
            return True
        if name == "text" and not ("".join(element.itertext()).strip() and any(self._paints(place))):
            return True
        if place.cutting:
            return False
        self.filtered += filtered != "none"
        return svg_paints.zero(element.attrib.get("opacity")) or svg_paints.hidden_by_filter(filtered, self.targets)

    def _paints(self, place: Place) -> tuple[svg_paints.Paint | None, svg_paints.Paint | None]:
        """Fill and line of a shape; None for what does not show."""
        fill, line = (svg_paints.of(place.style, key, self.targets) for key in ("fill", "stroke"))
        lined = line.shows and not svg_paints.zero(place.style.get("stroke-width"))
        return fill if fill.shows else None, line if lined else None

    def _shape(self, element: ET.Element, place: Place) -> Iterator[Drawn]:
        """Shape of an element, if anybody sees it."""
        style, (filled, lined) = place.style, self._paints(place)
        if name_of(element) == "line":
            filled = None
        if place.cutting:
            filled, lined = svg_paints.Paint(True, False), None
        paints = [paint for paint in (filled, lined) if paint]
        if style.get("visibility", "visible") != "visible" or not paints:
            self.unseen += 1
            return
        if any(element.attrib.get(f"marker-{end}", "none") != "none" for end in ("start", "mid", "end")):
            raise self._refuse("holds a marker on a line; leave it out")
        path = self._path(element, place)
        wide = LENGTH.fullmatch(style.get("stroke-width", "1")) if lined else None
        units = {**PIXELS, **self._relative(float(style.get("font-size", FONT)))}
        line = float(wide[1]) * units.get(wide[2].lower(), 1.0) * stretch(place.matrix) if wide else 0.0
        nonzero, white = style.get("fill-rule", "nonzero") != "evenodd", all(paint.white for paint in paints)
        yield Drawn(path, place.matrix, nonzero, white, line, place.clips)

    def _path(self, element: ET.Element, place: Place) -> "svgelements.Path":
        """Geometry of a shape in its own units."""
        import svgelements as svg

        name, text = name_of(element), element.attrib.get
        if name == "path":
            data = re.sub(r"^none$|^path\(\s*['\"](.*)['\"]\s*\)$", r"\1", text("d", "").strip())
            return self._drawn(element, "d", data, PATH, svg.Path)
        if name in ("polygon", "polyline"):
            kind = svg.Polygon if name == "polygon" else svg.Polyline
            return svg.Path(self._drawn(element, "points", text("points", ""), POINTS, kind))
        wide, high = place.view
        across = float(np.hypot(wide, high) / np.sqrt(2.0))
        spans = {"x": wide, "cx": wide, "width": wide, "rx": wide, "x1": wide, "x2": wide, "r": across}

        def length(key: str) -> float:
            return self._length(element, key, place, spans.get(key, high))

        if name == "line":
            return svg.Path(f"M {length('x1')!r},{length('y1')!r} L {length('x2')!r},{length('y2')!r}")
        radii = [None if text(key, "auto") == "auto" else length(key) for key in ("rx", "ry")]
        rx, ry = (other if radius is None else radius for radius, other in zip(radii, radii[::-1], strict=True))
        if name == "rect":
            box = length("x"), length("y"), length("width"), length("height")
            return svg.Path(svg.Rect(*box, rx=rx or 0.0, ry=ry or 0.0) if box[2] > 0.0 and box[3] > 0.0 else "")
        if name == "circle":
            rx = ry = length("r")
        return svg.Path(svg.Ellipse(length("cx"), length("cy"), rx, ry) if rx and ry else "")

    def _drawn(
        self,
        element: ET.Element,
        key: str,
        text: str,
        pattern: re.Pattern[str],
        kind: "Callable[[str], svgelements.Path]",
    ) -> "svgelements.Path":
        """Parse an attribute with svgelements, to its end. Raises InputError."""
        try:
            if pattern.fullmatch(text):
                return kind(text)
        except (ValueError, TypeError, IndexError):
            pass  # as what does not match: numbers that lack others
        raise self._refuse(f"<{name_of(element)}> has {key} = {text[:40]!r}; give numbers")

    def _length(self, element: ET.Element, key: str, place: Place, whole: float, otherwise: float = 0.0) -> float:
        """Length of an attribute in the drawing's units; percents are of `whole`."""
        text = element.attrib.get(key)
        if text is None or text.strip() == "auto":
            return otherwise
        match = LENGTH.fullmatch(text)
        units = {**PIXELS, **self._relative(float(place.style.get("font-size", FONT))), "%": 0.01 * whole}
        value = float(match[1]) * units.get(match[2].lower(), math.nan) if match else math.nan
        if math.isnan(value):
            raise self._refuse(f"<{name_of(element)}> has {key} = {text[:40]!r}; give numbers")
        return value

    def _moved(self, element: ET.Element, place: Place) -> Array:
        """Matrix of an element, its transform about its origin."""
        text = element.attrib.get("transform", "none").strip()
        if text in ("", "none"):
            return place.matrix
        own = transform(text)
        if own is None:
            told = f"<{name_of(element)}> has transform = {text[:40]!r}"
            raise self._refuse(f"{told}; give numbers to matrix, translate, scale, rotate, skewX, skewY")
        origin = np.array(self._origin(element, place))
        own[:, 2] += origin - own[:, :2] @ origin
        return times(place.matrix, own)

    def _origin(self, element: ET.Element, place: Place) -> tuple[float, float]:
        """Point about which an element is transformed."""
        text = element.attrib.get("transform-origin")
        if text is None:
            return 0.0, 0.0
        low, size = (0.0, 0.0), place.view
        if element.attrib.get("transform-box", "view-box") in ("fill-box", "content-box", "border-box"):
            if name_of(element) not in SHAPES:
                raise self._refuse("transform-box of a group; apply its transform to the paths")
            x0, y0, x1, y1 = self._path(element, place).bbox() or (0.0, 0.0, 0.0, 0.0)
            low, size = (x0, y0), (x1 - x0, y1 - y0)
        words = {"left": "0%", "right": "100%", "top": "0%", "bottom": "100%", "center": "50%"}
        parts = text.split()
        if parts[0] in ("top", "bottom") or parts[1:2] in (["left"], ["right"]):
            parts[:2] = [*parts[1:2], "center"][:1] + parts[:1]
        along = [words.get(part, part) for part in (*parts[:2], "center")][:2]
        held = ET.Element("origin", {"x": along[0], "y": along[1] if along[1] != "center" else "50%"})
        x, y = (self._length(held, key, place, whole) for key, whole in (("x", size[0]), ("y", size[1])))
        return low[0] + x, low[1] + y

    def _used(self, element: ET.Element, place: Place) -> Iterator[Drawn]:
        """Shapes of the element that a <use> stands for."""
        link = element.attrib.get("href", element.attrib.get(XLINK, ""))
        target = self.targets.get(link[1:]) if link[:1] == "#" else None
        if target is None:
            raise self._refuse(f"<use> refers to {link[:60]!r}, which the file does not hold")
        if target in place.inside:
            raise self._refuse("a <use> repeats itself without end")
        shift = [self._length(element, key, place, whole) for key, whole in zip("xy", place.view, strict=True)]
        place = place._replace(
            matrix=times(place.matrix, np.column_stack([np.eye(2), shift])), inside=(*place.inside, target)
        )
        if name_of(target) in ("symbol", "svg"):
            sizes: dict[str, str] = {key: element.attrib[key] for key in ("width", "height") if key in element.attrib}
            yield from self._window(target, self._inside(target, place), {**target.attrib, **sizes})
        else:
            yield from self._walk(target, place)

    def _window(self, element: ET.Element, place: Place, attributes: Mapping[str, str]) -> Iterator[Drawn]:
        """Shapes of a nested <svg> or a <symbol>: in units of its own, cut at its edges."""
        held = ET.Element(name_of(element), dict(attributes))
        wide, high = place.view
        nested = name_of(element) == "svg"
        x, y = (self._length(held, key, place, whole) if nested else 0.0 for key, whole in (("x", wide), ("y", high)))
        width, height = self._length(held, "width", place, wide, wide), self._length(held, "height", place, high, high)
        inner = np.array([[1.0, 0.0, x], [0.0, 1.0, y]])
        view = width, height
        if "viewBox" in attributes:
            box = view_box(attributes["viewBox"], self.source)
            inner, view = times(inner, fitted(box, width, height, attributes.get("preserveAspectRatio", ""))), box[2:]
        clips = place.clips
        if attributes.get("overflow", "hidden") in ("hidden", "scroll"):
            import svgelements

            edge = (
                svgelements.Path(svgelements.Rect(x, y, width, height))
                if width > 0 and height > 0
                else svgelements.Path()
            )
            clips = (*clips, Clip((Drawn(edge, place.matrix, True, False, 0.0, ()),)))
        place = place._replace(matrix=times(place.matrix, inner), view=view, clips=clips)
        for child in element:
            if isinstance(child.tag, str):
                yield from self._walk(child, place)

    def _cuts(self, element: ET.Element, place: Place) -> Iterator[Clip]:
        """Clip path and mask of an element; a mask cuts like one where all of it is white."""
        for key in ("clip-path", "mask"):
            text = element.attrib.get(key, "none").strip()
            if text == "none":
                continue
            match = re.match(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)", text)
            target = self.targets.get(match[1]) if match else None
            if target is None or name_of(target) not in ("clipPath", "mask"):
                raise self._refuse(f"is cut by {text[:60]!r}, which the file does not hold; apply it to the paths")
            if target in place.inside:
                raise self._refuse(f"a <{name_of(target)}> cuts itself without end")
            yield self._clip(element, target, place)

    def _clip(self, element: ET.Element, target: ET.Element, place: Place) -> Clip:
        """Window that a clip path or a mask opens."""
        matrix = place.matrix
        if target.attrib.get("clipPathUnits", target.attrib.get("maskContentUnits")) == "objectBoundingBox":
            if name_of(element) not in SHAPES:
                raise self._refuse("a group is cut in units of its box; apply it to the paths")
            x0, y0, x1, y1 = self._path(element, place).bbox() or (0.0, 0.0, 0.0, 0.0)
            matrix = times(matrix, np.array([[x1 - x0, 0.0, x0], [0.0, y1 - y0, y0]]))
        rule = name_of(target) == "clipPath"
        fresh = Place(matrix, {}, place.view, (), place.depth + 1, (*place.inside, target), rule)
        fresh = fresh._replace(matrix=self._moved(target, fresh))
        inner, counts = self._inside(target, fresh), (self.unseen, self.filtered)
        inner = inner._replace(clips=tuple(self._cuts(target, inner)))
        shapes = tuple(shape for child in target for shape in self._walk(child, inner))
        self.unseen, self.filtered = counts
        if not rule and not (shapes and all(shape.white for shape in shapes)):
            raise self._refuse("holds a mask that is not white; apply it to the paths")
        nonzero = [child.attrib.get("clip-rule", inner.style.get("clip-rule")) != "evenodd" for child in target]
        if rule and len(nonzero) == len(shapes):
            shapes = tuple(shape._replace(nonzero=own) for shape, own in zip(shapes, nonzero, strict=True))
        return Clip(shapes)


def name_of(element: ET.Element) -> str:
    """Name of an element of SVG without its namespace; "" for one of another."""
    tag = str(element.tag)
    return tag.removeprefix(SVG) if tag.startswith(SVG) or "}" not in tag else ""


def _suits(element: ET.Element) -> bool:
    """Whether a <switch> may show an element: it asks for no program, and for no language but English."""
    languages = element.attrib.get("systemLanguage", "en").lower().split(",")
    return "requiredExtensions" not in element.attrib and any(re.match("en(-|$)", each.strip()) for each in languages)


def refuse_active(root: ET.Element, source: str) -> None:
    """Raise InputError for what would change the drawing: scripts, animations."""
    for element in root.iter():
        if (name := str(element.tag).rpartition("}")[2]) in ACTIVE:
            raise InputError(f"{source}: holds {ACTIVE[name]} (<{name}>); leave it out and save a plain SVG")
        if handler := next((key for key in element.attrib if key.lower().startswith("on")), None):
            raise InputError(f"{source}: holds a script ({handler}); save it as a plain SVG")
