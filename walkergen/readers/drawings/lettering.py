"""Lettering: outlines of text, in the font DejaVu Sans that comes with matplotlib.

The font is read from matplotlib's own folder, so that every machine draws the same letters. This
module stands apart from outlines.py, which knows no pictures.
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
from walkergen.core.files import reading
from walkergen.readers.drawings.contours import FLATNESS, Shape, flatten
from walkergen.readers.drawings.outlines import Polygon, area, sound

MOST_CHARACTERS = 40

FINE = 2.0**20
"""Factor that brings letters (about 100 units) to manifold3d, which rounds them to 1e-8 units."""

ON_A_PLATE = Remedy("put a plate under it", {"body.base": True})
WITH_RAILS = Remedy("join the letters by rails 2 mm wide", {"body.rails_mm": 2.0})


def letters(
    text: str,
    height: float,
    connected: bool = True,
    source: str = "body.text",
    rails: float | None = None,
    font: Path | None = None,
) -> list[Polygon]:
    """Outline of a line of text; `height` is that of a capital without overshoot, H, in mm.

    With `rails` two bars so wide (mm), about the feet and the tops of capitals, join the letters. `font` is a file
    of one, by default DejaVu Sans.
    Where `connected`, it must be one piece, as for a body. Raises GeometryError, which begins with
    `source` = the text, for none or more than MOST_CHARACTERS, for characters that the font lacks
    or that draw nothing but blanks, for a text of several pieces, and for what `sound` refuses.
    """
    where = f"{source} = {text if len(text) <= MOST_CHARACTERS else text[:20] + '...'!r}"
    if not 1 <= len(text) <= MOST_CHARACTERS:
        raise GeometryError(f"{where}: has {len(text)} characters, allowed are 1 to {MOST_CHARACTERS}; shorten it")
    own = _font(font, where)
    _check_characters(text, where, own)
    if not text.strip():
        raise GeometryError(f"{where}: draws nothing; write a letter or digit")
    capital = _contours("H", own) or _contours(text, own)
    scale = height / float(np.ptp(np.vstack(capital)[:, 1]))
    if connected:
        _check_connected(text, where, rails, own)
    drawn = [scale * contour for contour in _contours(text, own)]
    if rails is not None:
        drawn = _railed(drawn, height, rails)
    return sound([Shape(drawn, nonzero=False)], where, connected)


def _check_characters(text: str, where: str, font: str) -> None:
    """Raise GeometryError, by name, for a character that the font lacks or that controls."""
    from matplotlib.ft2font import FT2Font

    known = FT2Font(font)
    for character in text:
        if unicodedata.category(character)[0] in "CZ" and character != " ":
            problem = "is no letter; leave it out or draw it"
        elif not known.get_char_index(ord(character)):
            problem = f"is not in the font {known.family_name}; {_advice(character)}"
        else:
            continue
        name = unicodedata.name(character, "a control character")
        raise GeometryError(f"{where}: U+{ord(character):04X} ({name}) {problem}")


def _advice(character: str) -> str:
    """Suggest what to do if a font lacks a character: a font of this machine that has it, if there is any."""
    from matplotlib.font_manager import findSystemFonts
    from matplotlib.ft2font import FT2Font

    for path in sorted(findSystemFonts()):
        try:
            if FT2Font(path).get_char_index(ord(character)):
                return f"name one that has it: body.font = {path!r}"
        except (OSError, RuntimeError):  # one that matplotlib cannot read
            continue
    return "name a font's file that has it by body.font, as one of Noto's, or leave it out"


def _railed(drawn: list[Polygon], height: float, width: float) -> list[Polygon]:
    """Contours with two bars along a text, in the middle of whose edges they lie."""
    x = np.concatenate(drawn)[:, 0]
    left, right = float(x.min()), float(x.max())
    bars = [
        np.array([(left, y - 0.5 * width), (right, y - 0.5 * width), (right, y + 0.5 * width), (left, y + 0.5 * width)])
        for y in (0.0, height)
    ]
    return _united([*drawn, *bars])


def _check_connected(text: str, where: str, rails: float | None, font: str) -> None:
    """Raise GeometryError when letters, or parts of one, do not touch; it names them."""
    if rails is not None or _pieces(text, font) == 1:  # `sound` tells what rails leave apart
        return
    broken = [letter for letter in dict.fromkeys(text) if letter != " " and _pieces(letter, font) > 1]
    if broken:
        named = ", ".join(map(repr, broken))
        raise GeometryError(
            f"{where}: {named} is drawn in several pieces, a body is one", helps=partial(tuple, [ON_A_PLATE])
        )
    gaps = (f"{left!r} and {right!r}" for left, right in pairwise(text) if _pieces(left + right, font) != 1)
    apart = next(gaps, "letters")  # beside others, letters may stand as they do not in a pair
    raise GeometryError(
        f"{where}: {apart} do not touch, a body is one piece", helps=partial(tuple, [ON_A_PLATE, WITH_RAILS])
    )


def _pieces(text: str, font: str) -> int:
    return sum(area(contour) > 0.0 for contour in _contours(text, font))


def _contours(text: str, font: str) -> list[Polygon]:
    """Contours of a text in the font's units, outer ones counter-clockwise, overlaps united."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.path import Path as Curves
    from matplotlib.textpath import text_to_path

    # The text as it stands: "$" begins no formula.
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
    return _united([np.vstack(loop) for loop in loops if loop])


def _united(rings: list[Polygon]) -> list[Polygon]:
    """Contours of what lies within rings."""
    united = manifold3d.CrossSection([FINE * ring for ring in rings], manifold3d.FillRule.NonZero)
    return [np.asarray(ring, dtype=np.float64) / FINE for ring in united.to_polygons()]


def _font(own: Path | None, where: str) -> str:
    """Path of a font. Raises InputError for a file that is none."""
    import matplotlib
    from matplotlib.ft2font import FT2Font

    if own is None:
        return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
    try:
        reading.read_bytes(own)
        FT2Font(str(own))
    except (RuntimeError, TypeError):
        raise InputError(f"{where}: {own.name!r} is no font: give a .ttf, .otf or .ttc") from None
    return str(own)
