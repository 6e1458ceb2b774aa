"""What a G-code file of PrusaSlicer lays down: straight lines of plastic, by object and layer.

Understands what PrusaSlicer writes with labelled objects, without arcs: absolute positions in mm,
absolute or relative extrusion (M82, M83, G92), and its comments for layers, types and objects.
Anything else that moves is an error rather than a guess.
"""

import math
import re
from typing import NamedTuple

import numpy as np

OBJECT = re.compile(r"; printing object (.+) id:(\d+) copy (\d+)")


class Lines(NamedTuple):
    """Extruded lines in the order printed; every field has one entry a line."""

    start: np.ndarray
    """Shape (n, 2), mm."""
    end: np.ndarray
    """Shape (n, 2), mm."""
    volume: np.ndarray
    """mm^3"""
    z: np.ndarray
    """Top of the layer, mm."""
    item: np.ndarray
    """Index into Printed.items; -1 for what belongs to none (skirt, brim, purge)."""


class Printed(NamedTuple):
    """A sliced file."""

    items: list[tuple[str, str]]
    """Name and number of every labelled object, in the order of their first appearance."""
    lines: Lines
    settings: dict[str, str]
    """What PrusaSlicer says that it sliced with."""


def read_gcode(text: str, filament_diameter: float = 1.75) -> Printed:
    """Every line of plastic. Raises ValueError at a command that moves in an unknown way."""
    area = 0.25 * math.pi * filament_diameter**2
    place = {"X": math.nan, "Y": math.nan, "E": 0.0}
    items: dict[tuple[str, str], int] = {}
    rows, relative, layer, item = [], False, math.nan, -1
    for line in text.splitlines():
        if line.startswith(";"):
            if line.startswith(";Z:"):
                layer = float(line[3:])
            elif found := OBJECT.match(line):
                item = items.setdefault((found[1], f"{found[2]}.{found[3]}"), len(items))
            elif line.startswith("; stop printing object"):
                item = -1
            continue
        words = line.split(";")[0].split()
        if not words:
            continue
        if words[0] in ("M82", "M83"):
            relative = words[0] == "M83"
        elif words[0] in ("G2", "G3", "G20", "G91"):
            raise ValueError(f"{line!r}: arcs, inches and relative moves are not read")
        elif words[0] == "G92":
            place |= _numbers(words)
        elif words[0] in ("G0", "G1"):
            moved = place | _numbers(words)
            push = moved["E"] if relative and "E" in _numbers(words) else moved["E"] - place["E"]
            if push > 0 and (moved["X"], moved["Y"]) != (place["X"], place["Y"]):
                rows.append((place["X"], place["Y"], moved["X"], moved["Y"], push * area, layer, item))
            place = moved
    settings = dict(re.findall(r"^; (\w+) = (.*)$", text, re.MULTILINE))
    table = np.array(rows, dtype=float).reshape(-1, 7)
    return Printed(
        list(items), Lines(table[:, :2], table[:, 2:4], table[:, 4], table[:, 5], table[:, 6].astype(int)), settings
    )


def _numbers(words: list[str]) -> dict[str, float]:
    return {word[0]: float(word[1:]) for word in words[1:] if word[0] in "XYE"}
