"""Paints of an SVG drawing: the colours of fills, lines, gradients and patterns, and what they hide."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import NamedTuple

import tinycss2.color4

Targets = Mapping[str, ET.Element]
"""Elements of the drawing by their id."""

XLINK_HREF = "{http://www.w3.org/1999/xlink}href"

NUMBER_PATTERN = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
SHARE_PATTERN = re.compile(rf"\s*({NUMBER_PATTERN})\s*(%?)\s*")
URL_PATTERN = re.compile(r"url\(\s*['\"]?#([^'\")]*)['\"]?\s*\)\s*")

MAX_PAPER_DIFFERENCE = 0.05
"""Largest difference of red, green or blue from the paper's, over full light, for what shows paper. Such a grey differs
from white by 4.5 units of CIE lightness, twice what an eye just sees side by side (2.3)."""

MAX_LINKS = 8
"""Maximum number of links from one gradient to the next."""


class Colour(NamedTuple):
    """Colour of a paint; all values from 0 to 1."""

    red: float
    green: float
    blue: float
    alpha: float

    def faded(self, opacity: float) -> "Colour":
        """Return the colour with its alpha multiplied by an opacity from 0 to 1."""
        return self._replace(alpha=self.alpha * opacity)

    def over(self, below: "Colour") -> "Colour":
        """Return the colour of this paint over another."""
        rest = below.alpha * (1.0 - self.alpha)
        alpha = self.alpha + rest
        if alpha == 0.0:
            return below
        red, green, blue = (
            round((self.alpha * one + rest * other) / alpha, 6) for one, other in zip(self[:3], below[:3], strict=True)
        )
        return Colour(red, green, blue, round(alpha, 6))

    @property
    def luminance(self) -> float:
        """Luminance of the colour, 0 to 1, with the weights of SVG masks."""
        return 0.2125 * self.red + 0.7154 * self.green + 0.0721 * self.blue

    def differs(self, paper: "Colour") -> bool:
        """Return whether this paint on the paper visibly differs from it."""
        shown = self.over(paper)
        return max(abs(one - other) for one, other in zip(shown[:3], paper[:3], strict=True)) > MAX_PAPER_DIFFERENCE


BLACK, WHITE = Colour(0.0, 0.0, 0.0, 1.0), Colour(1.0, 1.0, 1.0, 1.0)
CLEAR = BLACK.faded(0.0)


def from_style(style: Mapping[str, str], key: str, targets: Targets) -> Colour:
    """Return the paint of a shape's property, fill or stroke, from its inherited style."""
    text = style.get(key, "black" if key == "fill" else "none").strip()
    opacity = parse_share(style.get(f"{key}-opacity"))
    if link := URL_PATTERN.match(text):
        if link[1] in targets:
            return _paint_server_colour(targets[link[1]], targets).faded(opacity)
        text = text[link.end() :] or "none"  # a missing target is replaced by the colour after the link
    return _parse_colour(text, style.get("color", "black")).faded(opacity)


def _parse_colour(text: str, current: str) -> Colour:
    """Return the colour that a CSS text states; black for an unknown one. "currentColor" means the text `current`."""
    if text.lower() == "none":
        return CLEAR
    colour = tinycss2.color4.parse_color(current if text.lower() == "currentcolor" else text)
    if colour in (None, "currentcolor"):
        return BLACK
    red, green, blue = colour.to("srgb").coordinates if colour.space in ("srgb", "hsl", "hwb") else (0.0, 0.0, 0.0)
    return Colour(red, green, blue, colour.alpha)


def _paint_server_colour(server: ET.Element, targets: Targets) -> Colour:
    """Return one colour for a gradient or a pattern (element `server`), perhaps found by links.

    A gradient has the colour of its stop that differs most from white, at the mean opacity of its stops. A pattern with
    any contents is black.
    """
    for _ in range(MAX_LINKS):
        gradient = local_name(server).endswith("Gradient")
        if parts := [part for part in server if not gradient or local_name(part) == "stop"]:
            stops = [_stop_colour(part) for part in parts] if gradient else [BLACK]
            strongest = max(stops, key=lambda stop: stop.alpha * (1.0 - min(stop[:3])))
            return strongest._replace(alpha=sum(stop.alpha for stop in stops) / len(stops))
        link = server.attrib.get("href", server.attrib.get(XLINK_HREF, ""))
        if link[:1] != "#" or link[1:] not in targets:
            break
        server = targets[link[1:]]
    return CLEAR


def _stop_colour(stop: ET.Element) -> Colour:
    """Return the colour of a stop of a gradient."""
    colour = _parse_colour(stop.attrib.get("stop-color", "black").strip(), "black")
    return colour.faded(parse_share(stop.attrib.get("stop-opacity")))


def is_hidden_by_filter(text: str, targets: Targets) -> bool:
    """Return whether a value of the property filter hides everything: an empty filter, or opacity 0."""
    if link := URL_PATTERN.match(text):
        return link[1] in targets and local_name(targets[link[1]]) == "filter" and len(targets[link[1]]) == 0
    return any(parse_share(share) == 0.0 for share in re.findall(r"opacity\(([^)]*)\)", text))


def parse_share(text: str | None) -> float:
    """Return the share from 0 to 1, such as an opacity, that a text states; 1 for other text."""
    match = SHARE_PATTERN.fullmatch(text or "")
    return min(max(float(match[1]) * (0.01 if match[2] else 1.0), 0.0), 1.0) if match else 1.0


def local_name(element: ET.Element) -> str:
    """Return the name of an element without its namespace."""
    return str(element.tag).rpartition("}")[2]
