"""Marks that tell printed parts apart: notches or digits, as rectangles on the body's profile.

Frame: the middle of the body at the origin, x to the front, y up. Both kinds print without
supports, because the part lies on its side: notches are grooves of the profile and run through the
whole print, digits are engraved into the flat side that prints last.

Notches count in base two. Every binary digit has a notch, narrow for 0 and wide for 1, so that no
digit has to be guessed from an empty stretch; and the mass hardly depends on the number, as it would
with a tally. The start notch, wider than both, is the
frontmost: notches are read from there towards the back, highest digit first, with the legs down; a
part seen from its other side has its start on the left and is not misread.

In all functions `tilts_deg` are the tilts of the family, and `tilt_deg` is the tilt of the part.
"""

from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

from walkergen.core.walker.fittings import Marks

NARROW_NOTCH, WIDE_NOTCH, START_NOTCH = 1, 2, 3
"""Widths of notches, in units of two lines; one unit of body stands between two notches."""

LIT_SEGMENTS = {
    "0": "abcdef",
    "1": "bc",
    "2": "abdeg",
    "3": "abcdg",
    "4": "bcfg",
    "5": "acdfg",
    "6": "acdefg",
    "7": "abc",
    "8": "abcdefg",
    "9": "abcdfg",
    "-": "g",
    ".": "h",
}
"""Lit segments of a seven-segment display: a to f clockwise from the top, g middle, h a point."""

MIN_DIGIT_LINES = 5.0
"""Least height of a digit, in lines: three strokes and two gaps; a lower digit closes up."""


class Rectangle(NamedTuple):
    """Axis-parallel rectangle in the x-y plane, mm."""

    left: float
    bottom: float
    right: float
    top: float


def format_mark(marks: Marks, tilts_deg: Sequence[float], tilt_deg: float) -> str:
    """Format the mark of the part with this tilt: "", its tilt in digits, its text, or its notches as #.

    A serial number follows the mark, or is the whole mark.

    A drawing such as "### # ## ##" shows the notches from the start on, one # per unit of width.
    """
    if marks.kind == "text":
        return marks.letters
    if marks.kind != "notches":
        return _engraved_digits(marks, tilt_deg)
    notches_drawn = " ".join("#" * width for width in _notch_widths(tilts_deg, tilt_deg))
    return notches_drawn if marks.serial is None else f"{notches_drawn} {marks.serial}"


def _engraved_digits(marks: Marks, tilt_deg: float) -> str:
    """Return the engraved digits: the tilt's, the serial number, or both as in 10-7, or "" without any."""
    numbers = [format_tilt(tilt_deg)] if marks.kind == "digits" else []
    if marks.serial is not None and marks.kind != "text":
        numbers.append(str(marks.serial))
    return "-".join(numbers)


def format_tilt(tilt_deg: float) -> str:
    """Return the tilt with all its digits and without an exponent: 10, -7.5."""
    return format(Decimal(repr(tilt_deg + 0.0)).normalize(), "f")


def notches(
    marks: Marks, tilts_deg: Sequence[float], tilt_deg: float, length: float, thickness: float
) -> list[Rectangle]:
    """Return the grooves in the upper edge of a body, from front to back, none unless the marks are notches.

    The start lies one unit from the front end. Valid if `mark_problems` returns none.
    """
    if marks.kind != "notches":
        return []
    unit, top = 2.0 * marks.line_mm, 0.5 * thickness
    grooves, right = [], 0.5 * length - unit
    for width in _notch_widths(tilts_deg, tilt_deg):
        grooves.append(Rectangle(right - width * unit, top - marks.depth_mm, right, top))
        right -= (width + 1) * unit
    return grooves


def digit_strokes(marks: Marks, tilt_deg: float, thickness: float) -> list[Rectangle]:
    """Return the strokes of tilt and serial number around the middle of the body, overlapping where they meet.

    Strokes are a line wide. Digits leave a line free above and below, and are 0.6 as wide as high.
    Under notches they are lower by half the depth of the notches.
    """
    line, text = marks.line_mm, _engraved_digits(marks, tilt_deg)
    if not text:
        return []
    free_height = thickness - _notch_depth(marks)
    height = free_height - 2.0 * line
    width = 0.6 * height
    left = -0.5 * _text_length(text, height, line)
    bars = []
    for glyph in text:
        segments = _glyph_segments(left, height, width, line)
        bars += [segments[segment] for segment in LIT_SEGMENTS[glyph]]
        left += _glyph_advance(glyph, height, line)
    down = 0.5 * _notch_depth(marks)
    return [bar._replace(bottom=bar.bottom - down, top=bar.top - down) for bar in bars]


def _notch_depth(marks: Marks) -> float:
    """Return the depth of the notches below the upper edge, mm, or 0 for marks without notches."""
    return marks.depth_mm if marks.kind == "notches" else 0.0


def mark_problems(
    marks: Marks, tilts_deg: Sequence[float], tilt_deg: float, body: tuple[float, float, float]
) -> list[str]:
    """Return the reasons why a body of length, thickness, depth (mm) has no room for its marks, one line each."""
    length, thickness, depth = body
    if marks.kind == "text" and marks.depth_mm > 0.5 * depth:
        return [f"marks.depth_mm = {marks.depth_mm:g}: must be at most half of the body's {depth:.4g} mm"]
    reasons = []
    if marks.kind == "notches":
        reasons += _notch_problems(marks, tilts_deg, tilt_deg, length, thickness)
    if text := _engraved_digits(marks, tilt_deg):
        reasons += _digit_problems(marks, text, length, thickness - _notch_depth(marks), depth)
    return reasons


def _notch_problems(
    marks: Marks, tilts_deg: Sequence[float], tilt_deg: float, length: float, thickness: float
) -> list[str]:
    """Return the reasons why notches do not fit the edge of a body of this length and thickness, mm."""
    if tilt_deg not in tilts_deg:
        return [
            f"marks.kind = 'notches': they count the tilts in family.tilt_deg, which lack "
            f"{tilt_deg:g}: add it there, so that its notches never mean another tilt"
        ]
    reasons = []
    widths = [START_NOTCH] + [WIDE_NOTCH] * _bit_count(tilts_deg)
    needed = 2.0 * marks.line_mm * (sum(widths) + len(widths) + 1)
    if needed > length:
        reasons.append(
            f"marks.line_mm = {marks.line_mm:g}: notches for {len(tilts_deg)} tilts need "
            f"{needed:.2f} mm, but the body is {length:g} mm long. Make the line at most "
            f"{marks.line_mm * length / needed:.3f} mm, the family smaller, or use kind = 'digits'"
        )
    if marks.depth_mm > thickness / 3.0:
        reasons.append(
            f"marks.depth_mm = {marks.depth_mm:g}: must be at most a third of the body's "
            f"thickness, {thickness / 3.0:.3f} mm, for notches"
        )
    return reasons


def _digit_problems(marks: Marks, text: str, length: float, thickness: float, depth: float) -> list[str]:
    """Return the reasons why digits do not fit onto a face of length and thickness, mm."""
    reasons = []
    serial = marks.serial is not None
    below_notches = "" if marks.kind != "notches" else ", below the notches"
    alternative = "leave out the serial numbers" if serial else "use kind = 'notches'"
    line, height = marks.line_mm, thickness - 2.0 * marks.line_mm
    if height < MIN_DIGIT_LINES * line:
        reasons.append(
            f"marks.line_mm = {line:g}: digits are at least {MIN_DIGIT_LINES:g} lines high with "
            f"one free above and below, {(MIN_DIGIT_LINES + 2) * line:.2f} mm. The body is "
            f"{thickness:g} mm thick{below_notches}. Make the line at most "
            f"{thickness / (MIN_DIGIT_LINES + 2):.3f} mm or {alternative}"
        )
    else:
        needed = _text_length(text, height, line) + 2.0 * line
        if needed > length:
            key = f"marks.serial = {marks.serial}" if serial else "marks.kind = 'digits'"
            last_remedy = f"or {alternative}" if serial else "or use 'notches'"
            reasons.append(
                f"{key}: {text[:40]!r} needs {needed:.2f} mm, the body is "
                f"{length:g} mm long: round the tilt, lengthen the body, {last_remedy}"
            )
    if marks.depth_mm > depth / 2.0:
        reasons.append(
            f"marks.depth_mm = {marks.depth_mm:g}: must be at most half of the body's depth, "
            f"{depth / 2.0:g} mm, for digits"
        )
    return reasons


def _bit_count(tilts_deg: Sequence[float]) -> int:
    """Return how many binary digits number all tilts from 1."""
    return len(tilts_deg).bit_length()


def _notch_widths(tilts_deg: Sequence[float], tilt_deg: float) -> list[int]:
    """Return the widths of a tilt's notches, from the start on, in units."""
    number = list(tilts_deg).index(tilt_deg) + 1
    return [START_NOTCH] + [WIDE_NOTCH if bit == "1" else NARROW_NOTCH for bit in f"{number:0{_bit_count(tilts_deg)}b}"]


def _glyph_advance(glyph: str, height: float, line: float) -> float:
    """Return the distance between the left ends of a glyph and of the next, two lines after it, mm."""
    return (line if glyph == "." else 0.6 * height) + 2.0 * line


def _text_length(text: str, height: float, line: float) -> float:
    """Return the length of engraved digits of this height, in strokes of width `line`, mm."""
    return sum(_glyph_advance(glyph, height, line) for glyph in text) - 2.0 * line


def _glyph_segments(left: float, height: float, width: float, line: float) -> dict[str, Rectangle]:
    """Return the rectangles of a glyph's seven possible strokes and its point, by the letters of `LIT_SEGMENTS`."""
    right, low, high, half = left + width, -0.5 * height, 0.5 * height, 0.5 * line
    return {
        "a": Rectangle(left, high - line, right, high),
        "b": Rectangle(right - line, -half, right, high),
        "c": Rectangle(right - line, low, right, half),
        "d": Rectangle(left, low, right, low + line),
        "e": Rectangle(left, low, left + line, half),
        "f": Rectangle(left, -half, left + line, high),
        "g": Rectangle(left, -half, right, half),
        "h": Rectangle(left, low, left + line, low + line),
    }
