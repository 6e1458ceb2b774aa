"""Lengths of an SVG drawing, parsed to its own units by the rules of CSS."""

import math
import re
from collections.abc import Mapping
from typing import Any

from walkergen.readers.drawings.svg_paints import NUMBER_PATTERN

LENGTH_PATTERN = re.compile(rf"\s*({NUMBER_PATTERN})([a-zA-Z]{{0,3}}|%)\s*")

PIXELS_PER_UNIT = {
    "": 1.0,
    "px": 1.0,
    "in": 96.0,
    "cm": 96 / 2.54,
    "mm": 96 / 25.4,
    "q": 96 / 101.6,
    "pt": 96 / 72,
    "pc": 16.0,
}
"""Sizes of the units of length of CSS, in the drawing's own units."""

DEFAULT_FONT_SIZE = 16.0
"""Size of a font that is not set."""

FONT_SIZES = {
    "xx-small": 9.0,
    "x-small": 10.0,
    "small": 13.0,
    "medium": DEFAULT_FONT_SIZE,
    "large": 18.0,
    "x-large": 24.0,
    "xx-large": 32.0,
}
"""Sizes that CSS gives to names of font sizes."""


def font_size(style: Mapping[str, Any]) -> float:
    """Return the font size of a style, in the drawing's units."""
    return float(style.get("font-size", DEFAULT_FONT_SIZE))


def parse_font_size(text: str | None, parent: float, root: float) -> float:
    """Parse a font size. `parent`: font size of the enclosing element; `root`: of the page. NaN for other text."""
    word = (text or "1em").strip().lower()
    if size := {**FONT_SIZES, "larger": 1.2 * parent, "smaller": parent / 1.2, "inherit": parent}.get(word):
        return size
    match, units = LENGTH_PATTERN.fullmatch(word), {**units_at(parent, root), "%": 0.01 * parent}
    return float(match[1]) * units.get(match[2], math.nan) if match else math.nan


def parse_length(text: str, font: float, root: float, whole: float) -> float:
    """Parse a length. Percentages refer to `whole`; `font`, `root`: font sizes for em and rem. NaN for other text."""
    match, units = LENGTH_PATTERN.fullmatch(text), {**units_at(font, root), "%": 0.01 * whole}
    return float(match[1]) * units.get(match[2].lower(), math.nan) if match else math.nan


def units_at(font: float, root: float) -> dict[str, float]:
    """Return the size of each unit of length. `font` and `root` are the font sizes of the element and of the page."""
    return {**PIXELS_PER_UNIT, "em": font, "ex": 0.5 * font, "ch": 0.5 * font, "rem": root}
