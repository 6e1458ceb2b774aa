"""Names of printed walkers, and the legend that identifies them by their marks."""

import re
from collections.abc import Sequence
from string import ascii_uppercase

import numpy as np

from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import Marks

DEFAULT_STEM = "walker"
"""Beginning of the names of walkers of a single design."""


def part_name(design: Design, stem: str = DEFAULT_STEM) -> str:
    """Return the name of a walker, such as walker_t05.0_flexible_s0.40, unique within a family."""
    return f"{stem}_{tilt_name(design)}_{design.kind}_s{_format_decimal(design.limbs[0].thickness, 2)}"


def is_part_name(name: str) -> bool:
    """Return whether a text has the form of a name of `part_name`, or of a copy of it, such as NAME-3."""
    return bool(re.fullmatch(r".+_t-?\d+\.\d+_[a-z-]+_s\d+\.\d+(-[1-9]\d*)?", name))


def tilt_name(design: Design) -> str:
    """Format a walker's tilt for file names, such as t05.0, with leading zeros so that names sort."""
    whole, point, digits = _format_decimal(design.tilt_deg, 1).partition(".")
    return f"t{whole.zfill(3 if whole.startswith('-') else 2)}{point}{digits}"


def race_name(members: Sequence[Design]) -> str:
    """Return the file name for a race of several walkers of one design, such as race_t05.0-t10.0_flexible."""
    tilts = dict.fromkeys(tilt_name(design) for design in members)
    kinds = dict.fromkeys(design.kind for design in members)
    return f"race_{'-'.join(tilts)}_{'-'.join(kinds)}"


def leg_names(design: Design) -> tuple[str, ...]:
    """Return names of a walker's legs in their order: back and front for two legs, otherwise their numbers.

    Two legs side by side have numbers as well.
    """
    along = [limb.along for limb in design.limbs]
    if len(along) == 2 and along[0] != along[1]:
        return ("back", "front") if along[0] < along[1] else ("front", "back")
    return tuple(f"leg {number}" for number in range(1, len(along) + 1))


def part_names(members: Sequence[Design]) -> list[str]:
    """Return the names of walkers printed together. They begin with the design's name if there are several designs."""
    several = len(group_by_design(members)) > 1
    return [part_name(design, design.name if several else DEFAULT_STEM) for design in members]


def group_by_design(members: Sequence[Design]) -> dict[str, list[Design]]:
    """Group walkers by the names of their designs. Walkers keep their order."""
    groups: dict[str, list[Design]] = {}
    for design in members:
        groups.setdefault(design.name, []).append(design)
    return groups


def design_letters(members: Sequence[Design]) -> dict[str, str]:
    """Return the letter that pictures show for each design, by its name: A to Z, then AA. For one design, return {}."""
    designs = list(group_by_design(members))
    return {} if len(designs) == 1 else {name: _column_letters(index) for index, name in enumerate(designs)}


def legend(members: Sequence[Design]) -> str:
    """Return Markdown tables that identify printed walkers: the letter of each design, and the mark of each tilt."""
    letters = design_letters(members)
    if not letters:
        return _mark_legend(members)
    lines = [f"| {letter} | {name} |" for name, letter in letters.items()]
    sections = ["| on the map | design |\n|---|---|\n" + "\n".join(lines) + "\n"]
    for name, design_members in group_by_design(members).items():
        if marks := _mark_legend(design_members):
            sections.append(f"Marks of {name}. {marks}")
    return "\n".join(sections)


def _mark_legend(members: Sequence[Design]) -> str:
    """Return a Markdown table of the mark for each tilt of one design, or "" without marks."""
    marks: dict[float, dict[str, list[str]]] = {}
    for design in members:
        if design.mark:  # numbers count on from kind to kind
            kinds = marks.setdefault(design.tilt_deg, {})
            kinds.setdefault(design.kind, []).append(design.mark)
    if not marks:
        return ""
    lines = []
    for tilt, kinds in sorted(marks.items()):
        spans = dict.fromkeys(mark_range(marks_of_kind, "`") for marks_of_kind in kinds.values())
        lines.append(f"| {tilt:g} | {', '.join(spans)} |")
    head = "| tilt (deg) | mark |\n|-----------:|:-----|"
    return f"{reading_instructions(members[0].marks)}\n\n{head}\n" + "\n".join(lines) + "\n"


def mark_range(marks: Sequence[str], quote: str = "") -> str:
    """Format the marks of copies of a part: one mark, or "first to last" if they differ. `quote` encloses each mark."""
    ends = dict.fromkeys((marks[0], marks[-1]))
    return " to ".join(f"{quote}{mark}{quote}" for mark in ends)


def reading_instructions(marks: Marks) -> str:
    """Return the instructions for reading the marks of a printed part, or "" without marks."""
    number = "" if marks.serial is None else " The last number is the copy's own."
    if marks.kind == "none":
        return f"Digits engraved into the body.{number}" if number else ""
    if marks.kind == "digits":
        instruction = "Digits on the side that printed last: the tilt in degrees. Hold the legs down."
        return instruction + number
    if marks.kind == "text":
        return f"Letters engraved into the body: they name the design, not the tilt.{number}"
    unit = 2.0 * marks.line_mm
    return (
        f"Notches in the edge opposite the legs: read from the start, ### ({3 * unit:g} mm wide, "
        f"at one end of the body); # is narrow ({unit:g} mm), ## wide ({2 * unit:g} mm).{number}"
    )


def _column_letters(index: int) -> str:
    """Convert an index from 0 to letters, as spreadsheets name columns: A, ... Z, AA, AB, ..."""
    before, last = divmod(index, len(ascii_uppercase))
    return (_column_letters(before - 1) if before else "") + ascii_uppercase[last]


def _format_decimal(value: float, digits: int) -> str:
    """Format a number with all its digits, at least `digits` after the point, never an exponent."""
    return np.format_float_positional(value + 0.0, unique=True, min_digits=digits)
