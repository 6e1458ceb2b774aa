"""Lettering: outlines of text, in the font DejaVu Sans that comes with matplotlib.

The font is read from matplotlib's own folder, so that every machine draws the same letters. This
module is separate from outlines.py, which does not depend on matplotlib.
"""

import unicodedata
from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np

from walkergen.core.errors import GeometryError, InputError, Remedy
from walkergen.core.files import file_reading
from walkergen.readers.drawings.contours import FLATNESS, area, flatten
from walkergen.readers.drawings.outlines import Polygon, from_contours

MAX_CHARACTERS = 40

MANIFOLD_SCALE = 2.0**20
"""Factor that brings letters (about 100 units) to manifold3d, which rounds them to 1e-8 units."""

BASE_PLATE_REMEDY = Remedy("put a plate under it", {"body.base": True})
RAILS_REMEDY = Remedy("join the letters by rails 2 mm wide", {"body.rails_mm": 2.0})


def text_outline(
    text: str,
    height: float,
    connected: bool = True,
    source: str = "body.text",
    rails: float | None = None,
    font: Path | None = None,
) -> list[Polygon]:
    """Return the outline of a line of text. `height`: of the capital H, in mm.

    With `rails`, two bars of this width (mm) join the letters along the feet and the tops of capitals. `font` is a
    font's file, by default DejaVu Sans. If `connected`, the outline must be one piece, as for a body. Raises
    GeometryError, which begins with `source` and the text: for no characters or more than MAX_CHARACTERS, for
    characters that the font lacks or that draw only blanks, for a text of several pieces, and for what `from_contours`
    refuses.
    """
    where = f"{source} = {text if len(text) <= MAX_CHARACTERS else text[:20] + '...'!r}"
    if not 1 <= len(text) <= MAX_CHARACTERS:
        raise GeometryError(f"{where}: has {len(text)} characters, allowed are 1 to {MAX_CHARACTERS}. Shorten it.")
    font_path = _font_path(font, where)
    _check_characters(text, where, font_path)
    if not text.strip():
        raise GeometryError(f"{where}: draws nothing. Write a letter or digit.")
    capital = _text_contours("H", font_path) or _text_contours(text, font_path)
    scale = height / float(np.ptp(np.vstack(capital)[:, 1]))
    if connected:
        _check_connected(text, where, rails, font_path)
    contours = [scale * contour for contour in _text_contours(text, font_path)]
    if rails is not None:
        contours = _add_rails(contours, height, rails)
    return from_contours(contours, where, connected)


def _check_characters(text: str, where: str, font: str) -> None:
    """Raise GeometryError, which begins with `where`, for a control character or one that the font file lacks."""
    from matplotlib.ft2font import FT2Font

    loaded_font = FT2Font(font)
    for character in text:
        if unicodedata.category(character)[0] in "CZ" and character != " ":
            problem = "is not a letter. Remove it, or draw it."
        elif not loaded_font.get_char_index(ord(character)):
            problem = f"is not in the font {loaded_font.family_name}; {_suggest_font(character)}"
        else:
            continue
        name = unicodedata.name(character, "a control character")
        raise GeometryError(f"{where}: U+{ord(character):04X} ({name}) {problem}")


def _suggest_font(character: str) -> str:
    """Suggest what to do if a font lacks a character: name a font of this machine that has it, if there is one."""
    from matplotlib.font_manager import findSystemFonts
    from matplotlib.ft2font import FT2Font

    for path in sorted(findSystemFonts()):
        try:
            if FT2Font(path).get_char_index(ord(character)):
                return f"name one that has it: body.font = {path!r}"
        except (OSError, RuntimeError):  # one that matplotlib cannot read
            continue
    return "name a font's file that has it by body.font, as one of Noto's, or leave it out"


def _add_rails(contours: list[Polygon], height: float, width: float) -> list[Polygon]:
    """Unite the contours of a text with two bars of this width, mm: at its foot (y = 0) and at `height`."""
    x = np.concatenate(contours)[:, 0]
    left, right = float(x.min()), float(x.max())
    bars = [
        np.array([(left, y - 0.5 * width), (right, y - 0.5 * width), (right, y + 0.5 * width), (left, y + 0.5 * width)])
        for y in (0.0, height)
    ]
    return _unite_rings([*contours, *bars])


def _check_connected(text: str, where: str, rails: float | None, font: str) -> None:
    """Raise GeometryError, which begins with `where` and names the letters, if letters or their parts do not touch."""
    if rails is not None or _count_pieces(text, font) == 1:  # `from_contours` reports what rails leave apart
        return
    broken = [letter for letter in dict.fromkeys(text) if letter != " " and _count_pieces(letter, font) > 1]
    if broken:
        named = ", ".join(map(repr, broken))
        raise GeometryError(
            f"{where}: {named} is drawn in several pieces, a body is one", helps=partial(tuple, [BASE_PLATE_REMEDY])
        )
    gaps = (f"{left!r} and {right!r}" for left, right in pairwise(text) if _count_pieces(left + right, font) != 1)
    apart = next(gaps, "letters")  # next to other letters, a letter may be placed differently than in a pair
    raise GeometryError(
        f"{where}: {apart} do not touch, a body is one piece", helps=partial(tuple, [BASE_PLATE_REMEDY, RAILS_REMEDY])
    )


def _count_pieces(text: str, font: str) -> int:
    """Return the number of separate pieces of a text in a font file."""
    return sum(area(contour) > 0.0 for contour in _text_contours(text, font))


def _text_contours(text: str, font: str) -> list[Polygon]:
    """Return the contours of a text in units of the font file, outer ones counter-clockwise, overlaps united."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.path import Path as Curves
    from matplotlib.textpath import text_to_path

    # The text unchanged: "$" begins no formula.
    properties = FontProperties(fname=font)
    vertices, codes = text_to_path.get_text_path(properties, text, ismath=False)
    if not len(vertices):
        return []
    tolerance = FLATNESS * float(np.ptp(np.asarray(vertices), axis=0).max())
    loops: list[list[Any]] = []
    curves: Iterator[tuple[Any, int]] = Curves(vertices, codes).iter_bezier()  # type: ignore[assignment]
    for curve, code in curves:
        if code == Curves.MOVETO:
            loops.append([])
        elif len(curve.control_points) == 2:
            loops[-1].append(curve.control_points[:1])
        else:
            loops[-1].append(flatten(curve, tolerance)[:-1])
    return _unite_rings([np.vstack(loop) for loop in loops if loop])


def _unite_rings(rings: list[Polygon]) -> list[Polygon]:
    """Return the contours of the union of rings, shape (n, 2) each."""
    united = manifold3d.CrossSection([MANIFOLD_SCALE * ring for ring in rings], manifold3d.FillRule.NonZero)
    return [np.asarray(ring, dtype=np.float64) / MANIFOLD_SCALE for ring in united.to_polygons()]


def _font_path(font: Path | None, where: str) -> str:
    """Return the path of a font's file, by default that of DejaVu Sans. Raises InputError if it is not a font."""
    import matplotlib
    from matplotlib.ft2font import FT2Font

    if font is None:
        return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
    try:
        file_reading.read_bytes(font)
        FT2Font(str(font))
    except (RuntimeError, TypeError):
        raise InputError(f"{where}: {font.name!r} is not a font. Use a .ttf, .otf or .ttc.") from None
    return str(font)
