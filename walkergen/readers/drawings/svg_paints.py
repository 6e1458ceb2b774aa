"""Paints of an SVG drawing: whether colours, gradients, patterns and filters let a shape be seen, and in white."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import NamedTuple

import tinycss2.color4

Targets = Mapping[str, ET.Element]
"""Elements of the drawing by their id."""

XLINK_HREF = "{http://www.w3.org/1999/xlink}href"

NUMBER_PATTERN = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
SHARE_PATTERN = re.compile(rf"\s*({NUMBER_PATTERN})\s*%?\s*")
URL_PATTERN = re.compile(r"url\(\s*['\"]?#([^'\")]*)['\"]?\s*\)\s*")

MIN_WHITE = 0.95
"""Minimum share of full light of each colour for a paint that is the paper's."""

MAX_LINKS = 8
"""Most gradients that one may have its stops of, one after the other."""

BLACK = "black"


class Paint(NamedTuple):
    """Whether a fill or a line shows, and whether it is white."""

    shows: bool
    white: bool


INVISIBLE = Paint(shows=False, white=False)


def from_style(style: Mapping[str, str], key: str, targets: Targets) -> Paint:
    """Return the paint of a shape's property, fill or stroke, from its inherited style."""
    text = style.get(key, BLACK if key == "fill" else "none").strip()
    if is_zero(style.get(f"{key}-opacity")):
        return INVISIBLE
    if link := URL_PATTERN.match(text):
        if link[1] in targets:
            return Paint(_is_paint_visible(targets[link[1]], targets), white=False)
        text = text[link.end() :] or "none"  # what the file does not hold gives way to the colour after it
    return _parse_colour(text, style.get("color", BLACK))


def _parse_colour(text: str, current: str) -> Paint:
    """Return the paint of a colour's text. "currentColor" means the colour `current`."""
    if text.lower() == "none":
        return INVISIBLE
    colour = tinycss2.color4.parse_color(current if text.lower() == "currentcolor" else text)
    if colour in (None, "currentcolor"):
        return Paint(shows=True, white=False)
    light = colour.to("srgb").coordinates if colour.space in ("srgb", "hsl", "hwb") else (0.0,)
    return Paint(colour.alpha > 0.0, min(light) >= MIN_WHITE)


def _is_paint_visible(server: ET.Element, targets: Targets) -> bool:
    """Return whether a gradient (element `server`) has a visible stop, or a pattern any contents, perhaps by links."""
    for _ in range(MAX_LINKS):
        gradient = local_name(server).endswith("Gradient")
        if parts := [part for part in server if not gradient or local_name(part) == "stop"]:
            return not gradient or any(map(_is_stop_visible, parts))
        link = server.attrib.get("href", server.attrib.get(XLINK_HREF, ""))
        if link[:1] != "#" or link[1:] not in targets:
            return False
        server = targets[link[1:]]
    return False


def _is_stop_visible(stop: ET.Element) -> bool:
    """Return whether a stop of a gradient has a visible colour."""
    colour = _parse_colour(stop.attrib.get("stop-color", BLACK).strip(), BLACK)
    return colour.shows and not is_zero(stop.attrib.get("stop-opacity"))


def is_hidden_by_filter(text: str, targets: Targets) -> bool:
    """Return whether a value of the property filter hides everything: an empty filter, or opacity 0."""
    if link := URL_PATTERN.match(text):
        return link[1] in targets and local_name(targets[link[1]]) == "filter" and len(targets[link[1]]) == 0
    return any(is_zero(share) for share in re.findall(r"opacity\(([^)]*)\)", text))


def is_zero(text: str | None) -> bool:
    """Return whether a text is a number of 0 or below, such as an opacity that hides."""
    match = SHARE_PATTERN.fullmatch(text or "")
    return match is not None and float(match[1]) <= 0.0


def local_name(element: ET.Element) -> str:
    """Return the name of an element without its namespace."""
    return str(element.tag).rpartition("}")[2]
