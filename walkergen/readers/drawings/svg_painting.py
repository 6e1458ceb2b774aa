"""The painter's rule of an SVG drawing: coats in their order, over paper, become areas of one colour each."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.readers.drawings.overlaps import Region, unite
from walkergen.readers.drawings.svg_elements import Layer
from walkergen.readers.drawings.svg_paints import BLACK, Colour


class Coat(NamedTuple):
    """Area painted in one colour."""

    area: Region
    colour: Colour
    layers: tuple[Layer, ...] = ()
    """Layers in which it lies, from outside."""


Painted = list[tuple[Region, Colour]]
"""Areas without overlaps, and the colour that each shows."""


def paint(coats: Sequence[Coat], paper: Colour | None = None, depth: int = 0) -> Painted:
    """Paint coats in their order, lowest first. Return areas without overlaps and the colour that each shows.

    With `paper`, opaque colours that visibly differ from the paper may all become black, where no clear coat follows.
    `depth` is the number of layers around the coats.
    """
    clear = [index for index, coat in enumerate(coats) if coat.colour.alpha < 1.0 or coat.layers[depth:]]
    opaque = coats[max(clear, default=-1) + 1 :]
    if paper:
        opaque = [coat._replace(colour=BLACK if coat.colour.differs(paper) else paper) for coat in opaque]
    if not clear and len(opaque) <= 2:
        return _paint_in_turn(opaque, depth)
    # In halves: each opaque coat on all that is below it would take quadratic time.
    half = 0 if clear else len(opaque) // 2
    below = coats[: len(coats) - len(opaque)] if clear else opaque[:half]
    painted = (_paint_in_turn if clear else paint)(below, depth=depth)
    for area, colour in paint(opaque[half:], depth=depth):
        painted = _add_coat(painted, area, colour)
    return painted


def _paint_in_turn(coats: Sequence[Coat], depth: int) -> Painted:
    """Paint coats one after the other. `depth`: number of layers around the coats."""
    painted: Painted = []

    def group_key(coat: Coat) -> tuple[Layer | None, Colour | None]:
        """Return the key by which coats are grouped: their layer, or else their colour."""
        layer = coat.layers[depth] if coat.layers[depth:] else None
        return layer, None if layer else coat.colour

    for (layer, colour), group in itertools.groupby(coats, group_key):
        if layer:
            below = paint([*group], None, depth + 1)
            for area, shown in below:
                painted = _add_coat(painted, area, shown.faded(layer.opacity))
        elif colour and colour.alpha == 1.0:
            painted = _add_coat(painted, unite([coat.area for coat in group]), colour)
        else:
            for coat in group:
                painted = _add_coat(painted, coat.area, coat.colour)
    return painted


def _add_coat(painted: Painted, area: Region, colour: Colour) -> Painted:
    """Return areas and their colours after one more coat on `painted`."""
    shown: dict[Colour, list[Region]] = {}
    bare = area
    for below, under in painted:
        common = below ^ area
        if common.is_empty():
            shown.setdefault(under, []).append(below)
            continue
        shown.setdefault(under, []).append(below - area)
        if colour.alpha < 1.0:
            shown.setdefault(colour.over(under), []).append(common)
            bare = bare - below
    shown.setdefault(colour, []).append(bare)
    united = ((unite(areas) if len(areas) > 1 else areas[0], one) for one, areas in shown.items())
    return [(region, one) for region, one in united if not region.is_empty()]
