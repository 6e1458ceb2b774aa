"""Elements of an SVG drawing: the visible ones, their positions, and what clips them.

The tree is walked once, as in a browser: <use> and <symbol> are replaced by what they repeat, a nested
<svg> has its own units and is a window, clip paths cut. Geometry of single elements and transforms
are read by svgelements.
"""

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.readers.drawings import svg_paints, svg_styles
from walkergen.readers.drawings.svg_lengths import DEFAULT_FONT_SIZE, font_size, parse_font_size, parse_length
from walkergen.readers.drawings.svg_matrices import compose, fit_matrix, parse_transform, parse_view_box
from walkergen.readers.drawings.svg_paints import BLACK, XLINK_HREF, Colour
from walkergen.readers.drawings.svg_tags import SHAPE_TAGS, element_name, is_switch_choice

if TYPE_CHECKING:
    import svgelements


GROUP_TAGS = ("a", "g", "switch", "svg", "use")

UNREADABLE_TAGS = {"image": "a picture", "text": "text", "foreignObject": "a foreign object"}
"""Elements that people see and that are no closed paths."""

MAX_ELEMENTS, MAX_DEPTH = 20_000, 256
"""Elements of a drawing at most, counted as often as <use> repeats them, and levels of them."""

PATH_PATTERN = re.compile(r"[MmZzLlHhVvCcSsQqTtAa0-9eE.,+\-\s]*")
POINTS_PATTERN = re.compile(r"[0-9eE.,+\-\s]*")


class Line(NamedTuple):
    """Line along a path."""

    colour: Colour
    width: float
    """Width in the units of its shape."""
    style: Mapping[str, str]
    """Inherited properties, such as its ends, corners and dashes."""


class Layer(NamedTuple):
    """Element that is drawn separately and then laid, as a whole, over the elements below."""

    number: int
    opacity: float


class VisibleShape(NamedTuple):
    """Visible shape of a drawing."""

    path: "svgelements.Path"
    """Its geometry in its own units."""
    matrix: Array
    """Transform from the shape's units to the drawing's, shape (2, 3)."""
    nonzero: bool = True
    """Fill rule: True for nonzero, False for evenodd."""
    fill: Colour = BLACK
    line: Line | None = None
    clips: "tuple[Clip, ...]" = ()
    """Clips of the shape, one after the other."""
    layers: tuple[Layer, ...] = ()
    """Layers in which it lies, from outside."""


class Clip(NamedTuple):
    """Area to which a shape is cut: the union of shapes, or where a mask is light."""

    shapes: tuple[VisibleShape, ...]
    is_mask: bool = False
    by_alpha: bool = False
    """Whether a mask shows what is opaque in it, whatever its colour."""


class Context(NamedTuple):
    """Context of an element: what it inherits from the elements around it."""

    matrix: Array
    style: Mapping[str, str]
    """Inherited properties."""
    view: tuple[float, float]
    """Width and height that percentages refer to."""
    clips: tuple[Clip, ...] = ()
    layers: tuple[Layer, ...] = ()
    depth: int = 0
    inside: tuple[ET.Element, ...] = ()
    """Elements that <use> repeats at present: none may repeat itself."""
    cutting: bool = False
    """Whether the element is in a clip path, where shapes cut in any colour."""


class Tree:
    """Drawing whose elements are visited in order.

    `count` is the number of elements so far, `unseen` of hidden shapes and `filtered` of filters. `targets` are
    elements by id. `rem` is the font size of the page.
    """

    def __init__(self, root: ET.Element, source: str) -> None:
        self.root, self.source = root, source
        # of two elements with the same id browsers take the first
        self.targets = {node.attrib["id"]: node for node in reversed([*root.iter()]) if "id" in node.attrib}
        self.count = self.unseen = self.filtered = 0
        self.rem = DEFAULT_FONT_SIZE

    def visible_shapes(self, view: tuple[float, float]) -> list[VisibleShape]:
        """Return the visible shapes, lowest first. `view`: width and height of the page in the drawing's units."""
        if self.root.attrib.get("transform", "none").strip() not in ("", "none"):
            raise self._input_error("the page has a transform. Apply it to the paths.")
        context = self._inner_context(self.root, Context(np.eye(2, 3), {}, view))
        self.rem = float(context.style["font-size"])
        return [shape for child in self.root for shape in self._element_shapes(child, context)]

    def _input_error(self, what: str) -> InputError:
        return InputError(f"{self.source}: {what}")

    def _inner_context(self, element: ET.Element, context: Context) -> Context:
        """Return the context of the contents of an element that is itself in `context`."""
        own_style = {
            key: element.attrib[key]
            for key in svg_styles.INHERITED_PROPERTIES
            if element.attrib.get(key, "inherit") != "inherit"
        }
        style = {**context.style, **own_style}
        style["font-size"] = repr(parse_font_size(element.attrib.get("font-size"), font_size(context.style), self.rem))
        return context._replace(style=style, depth=context.depth + 1)

    def _element_shapes(self, element: ET.Element, context: Context) -> Iterator[VisibleShape]:
        """Yield the visible shapes of an element and of its contents."""
        name = element_name(element)
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise self._input_error(f"it draws more than {MAX_ELEMENTS} elements. Simplify it.")
        if context.depth > MAX_DEPTH:
            raise self._input_error("elements are nested too deeply")
        if name not in (*SHAPE_TAGS, *GROUP_TAGS, *UNREADABLE_TAGS):
            return
        inner = self._inner_context(element, context)
        if self._is_hidden(element, inner):
            self.unseen += name in SHAPE_TAGS
            return
        if name in UNREADABLE_TAGS:
            hint = "Convert it to paths." if name == "text" else "Remove it, and save a plain SVG."
            raise self._input_error(f"holds {UNREADABLE_TAGS[name]} (<{name}>). {hint}")
        inner = inner._replace(matrix=self._element_matrix(element, inner), clips=inner.clips)
        inner = inner._replace(clips=(*inner.clips, *self._find_clips(element, inner)))
        opacity = svg_paints.parse_share(element.attrib.get("opacity"))
        if opacity < 1.0 and not inner.cutting:
            inner = inner._replace(layers=(*inner.layers, Layer(self.count, opacity)))
        if name in SHAPE_TAGS:
            yield from self._visible_shape(element, inner)
        elif name == "use":
            yield from self._use_shapes(element, inner)
        elif name == "svg":
            yield from self._window_shapes(element, inner, element.attrib)
        else:
            children = [child for child in element if isinstance(child.tag, str)]
            if name == "switch":  # the first without special requirements
                children = [child for child in children if is_switch_choice(child)][:1]
            for child in children:
                yield from self._element_shapes(child, inner)

    def _is_hidden(self, element: ET.Element, context: Context) -> bool:
        """Return whether an element hides itself and all its contents, even visible ones. Count its filter."""
        filtered, name = element.attrib.get("filter", "none").strip(), element_name(element)
        if element.attrib.get("display") == "none":
            return True
        if name in UNREADABLE_TAGS and context.style.get("visibility", "visible") != "visible":
            return True
        if name == "text" and not (
            "".join(element.itertext()).strip() and _has_colour(*self._fill_and_line(element, context))
        ):
            return True
        if context.cutting:
            return False
        self.filtered += filtered != "none"
        return svg_paints.parse_share(element.attrib.get("opacity")) == 0.0 or svg_paints.is_hidden_by_filter(
            filtered, self.targets
        )

    def _fill_and_line(self, element: ET.Element, context: Context) -> tuple[Colour, Line | None]:
        """Return the colour of a shape's fill, perhaps clear, and its line, or None without a line."""
        if context.cutting:
            return BLACK, None
        fill, stroke = (svg_paints.from_style(context.style, key, self.targets) for key in ("fill", "stroke"))
        across = float(np.hypot(*context.view) / np.sqrt(2.0))
        width = parse_length(context.style.get("stroke-width", "1"), font_size(context.style), self.rem, across)
        return (
            svg_paints.CLEAR if element_name(element) == "line" else fill,
            Line(stroke, width, context.style) if stroke.alpha > 0.0 and width > 0.0 else None,
        )

    def _visible_shape(self, element: ET.Element, context: Context) -> Iterator[VisibleShape]:
        """Yield the shape of an element, if it is visible."""
        is_visible = context.style.get("visibility", "visible") == "visible"
        fill, line = self._fill_and_line(element, context) if is_visible else (svg_paints.CLEAR, None)
        if not _has_colour(fill, line):
            self.unseen += 1
            return
        if any(element.attrib.get(f"marker-{end}", "none") != "none" for end in ("start", "mid", "end")):
            raise self._input_error("it contains a marker on a line. Remove it.")
        path, nonzero = self._build_path(element, context), context.style.get("fill-rule", "nonzero") != "evenodd"
        yield VisibleShape(path, context.matrix, nonzero, fill, line, context.clips, context.layers)

    def _build_path(self, element: ET.Element, context: Context) -> "svgelements.Path":
        """Return the geometry of a shape in its own units."""
        import svgelements as svg

        name, text = element_name(element), element.attrib.get
        if name == "path":
            data = re.sub(r"^none$|^path\(\s*['\"](.*)['\"]\s*\)$", r"\1", text("d", "").strip())
            return self._parse_path(element, "d", data, PATH_PATTERN, svg.Path)
        if name in ("polygon", "polyline"):
            kind = svg.Polygon if name == "polygon" else svg.Polyline
            return svg.Path(self._parse_path(element, "points", text("points", ""), POINTS_PATTERN, kind))
        wide, high = context.view
        across = float(np.hypot(wide, high) / np.sqrt(2.0))
        spans = {"x": wide, "cx": wide, "width": wide, "rx": wide, "x1": wide, "x2": wide, "r": across}

        def length(key: str) -> float:
            """Return the length in attribute `key`, in the element's units."""
            return self._parse_length(element, key, context, spans.get(key, high))

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

    def _parse_path(
        self,
        element: ET.Element,
        key: str,
        text: str,
        pattern: re.Pattern[str],
        kind: "Callable[[str], svgelements.Path]",
    ) -> "svgelements.Path":
        """Parse an attribute's text, which must match the pattern, to a path of this kind. Raises InputError."""
        try:
            if pattern.fullmatch(text):
                return kind(text)
        except (ValueError, TypeError, IndexError):
            pass  # like text that does not match: a number is missing
        raise self._input_error(f"<{element_name(element)}> has {key} = {text[:40]!r}. Give numbers")

    def _parse_length(
        self, element: ET.Element, key: str, context: Context, whole: float, otherwise: float = 0.0
    ) -> float:
        """Return the length in attribute `key`, in the element's units, or `otherwise`. Percents are of `whole`."""
        text = element.attrib.get(key)
        if text is None or text.strip() == "auto":
            return otherwise
        value = parse_length(text, font_size(context.style), self.rem, whole)
        if math.isnan(value):
            raise self._input_error(f"<{element_name(element)}> has {key} = {text[:40]!r}. Give numbers")
        return value

    def _element_matrix(self, element: ET.Element, context: Context) -> Array:
        """Return the matrix from an element's units to the drawing's, shape (2, 3), its own transform included."""
        text = element.attrib.get("transform", "none").strip()
        if text in ("", "none"):
            return context.matrix
        transform = parse_transform(text)
        if transform is None:
            found = f"<{element_name(element)}> has transform = {text[:40]!r}"
            raise self._input_error(f"{found}. Use matrix, translate, scale, rotate, skewX or skewY with numbers.")
        origin = np.array(self._transform_origin(element, context))
        transform[:, 2] += origin - transform[:, :2] @ origin
        return compose(context.matrix, transform)

    def _transform_origin(self, element: ET.Element, context: Context) -> tuple[float, float]:
        """Return the point, x and y in its own units, about which an element is transformed."""
        text = element.attrib.get("transform-origin")
        if text is None:
            return 0.0, 0.0
        low, size = (0.0, 0.0), context.view
        if element.attrib.get("transform-box", "view-box") in ("fill-box", "content-box", "border-box"):
            if element_name(element) not in SHAPE_TAGS:
                raise self._input_error("it has a transform-box of a group. Apply its transform to the paths.")
            x0, y0, x1, y1 = self._build_path(element, context).bbox() or (0.0, 0.0, 0.0, 0.0)
            low, size = (x0, y0), (x1 - x0, y1 - y0)
        words = {"left": "0%", "right": "100%", "top": "0%", "bottom": "100%", "center": "50%"}
        parts = text.split()
        # Words may be in either order: put the horizontal one first
        if parts[0] in ("top", "bottom") or parts[1:2] in (["left"], ["right"]):
            parts[:2] = [*parts[1:2], "center"][:1] + parts[:1]
        axes = [words.get(part, part) for part in (*parts[:2], "center")][:2]
        origin = ET.Element("origin", {"x": axes[0], "y": axes[1] if axes[1] != "center" else "50%"})
        x, y = (self._parse_length(origin, key, context, whole) for key, whole in (("x", size[0]), ("y", size[1])))
        return low[0] + x, low[1] + y

    def _use_shapes(self, element: ET.Element, context: Context) -> Iterator[VisibleShape]:
        """Yield the shapes of the element that a <use> repeats."""
        link = element.attrib.get("href", element.attrib.get(XLINK_HREF, ""))
        target = self.targets.get(link[1:]) if link[:1] == "#" else None
        if target is None:
            raise self._input_error(f"<use> refers to {link[:60]!r}, which the file does not contain.")
        if target in context.inside:
            raise self._input_error("a <use> contains itself. Remove it, and save a plain SVG.")
        shift = [
            self._parse_length(element, key, context, whole) for key, whole in zip("xy", context.view, strict=True)
        ]
        context = context._replace(
            matrix=compose(context.matrix, np.column_stack([np.eye(2), shift])), inside=(*context.inside, target)
        )
        if element_name(target) in ("symbol", "svg"):
            sizes: dict[str, str] = {key: element.attrib[key] for key in ("width", "height") if key in element.attrib}
            yield from self._window_shapes(target, self._inner_context(target, context), {**target.attrib, **sizes})
        else:
            yield from self._element_shapes(target, context)

    def _window_shapes(
        self, element: ET.Element, context: Context, attributes: Mapping[str, str]
    ) -> Iterator[VisibleShape]:
        """Yield the shapes of a nested <svg> or a <symbol> with these attributes, cut at the edges of its window."""
        window = ET.Element(element_name(element), dict(attributes))
        wide, high = context.view
        nested = element_name(element) == "svg"
        x, y = (
            self._parse_length(window, key, context, whole) if nested else 0.0
            for key, whole in (("x", wide), ("y", high))
        )
        width, height = (
            self._parse_length(window, "width", context, wide, wide),
            self._parse_length(window, "height", context, high, high),
        )
        inner = np.array([[1.0, 0.0, x], [0.0, 1.0, y]])
        view = width, height
        if "viewBox" in attributes:
            box = parse_view_box(attributes["viewBox"], self.source)
            inner, view = (
                compose(inner, fit_matrix(box, width, height, attributes.get("preserveAspectRatio", ""))),
                box[2:],
            )
        clips = context.clips
        if attributes.get("overflow", "hidden") in ("hidden", "scroll"):
            import svgelements

            edge = (
                svgelements.Path(svgelements.Rect(x, y, width, height))
                if width > 0 and height > 0
                else svgelements.Path()
            )
            clips = (*clips, Clip((VisibleShape(edge, context.matrix),)))
        context = context._replace(matrix=compose(context.matrix, inner), view=view, clips=clips)
        for child in element:
            if isinstance(child.tag, str):
                yield from self._element_shapes(child, context)

    def _find_clips(self, element: ET.Element, context: Context) -> Iterator[Clip]:
        """Yield the clip path and the mask of an element."""
        for key in ("clip-path", "mask"):
            text = element.attrib.get(key, "none").strip()
            if text == "none":
                continue
            match = re.match(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)", text)
            target = self.targets.get(match[1]) if match else None
            if target is None or element_name(target) not in ("clipPath", "mask"):
                raise self._input_error(f"is cut by {text[:60]!r}, which the file lacks. Apply it to the paths.")
            if target in context.inside:
                raise self._input_error(f"a <{element_name(target)}> cuts itself without end")
            yield self._build_clip(element, target, context)

    def _build_clip(self, element: ET.Element, target: ET.Element, context: Context) -> Clip:
        """Return the clip of an element that a clip path or a mask, `target`, defines."""
        matrix = context.matrix
        if target.attrib.get("clipPathUnits", target.attrib.get("maskContentUnits")) == "objectBoundingBox":
            if element_name(element) not in SHAPE_TAGS:
                raise self._input_error("a group is clipped in units of its box. Apply the clip to the paths.")
            x0, y0, x1, y1 = self._build_path(element, context).bbox() or (0.0, 0.0, 0.0, 0.0)
            matrix = compose(matrix, np.array([[x1 - x0, 0.0, x0], [0.0, y1 - y0, y0]]))
        is_clip_path = element_name(target) == "clipPath"
        inside = (*context.inside, target)
        clip_context = Context(matrix, {}, context.view, (), (), context.depth + 1, inside, is_clip_path)
        clip_context = clip_context._replace(matrix=self._element_matrix(target, clip_context))
        inner, counts = self._inner_context(target, clip_context), (self.unseen, self.filtered)
        inner = inner._replace(clips=tuple(self._find_clips(target, inner)))
        shapes = tuple(shape for child in target for shape in self._element_shapes(child, inner))
        self.unseen, self.filtered = counts
        nonzero = [child.attrib.get("clip-rule", inner.style.get("clip-rule")) != "evenodd" for child in target]
        if is_clip_path and len(nonzero) == len(shapes):
            shapes = tuple(shape._replace(nonzero=rule) for shape, rule in zip(shapes, nonzero, strict=True))
        return Clip(shapes, not is_clip_path, target.attrib.get("mask-type") == "alpha")


def _has_colour(fill: Colour, line: Line | None) -> bool:
    """Return whether a shape's fill or its line has a colour."""
    return fill.alpha > 0.0 or line is not None
