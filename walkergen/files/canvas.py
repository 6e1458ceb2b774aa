"""Canvas: a picture with moving parts. Fixed parts are drawn once, moving parts on top of them in each frame."""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import IdentityTransform

from walkergen.files.animation import Pixels

DPI = 100

INK, PLATE_COLOUR, BODY_COLOUR, LIMB_COLOUR = "#222222", "#c4c4c4", "#a9c7e4", "#2f6c9f"
SMALL_PT, NORMAL_PT, LARGE_PT = 8.0, 9.5, 11.0
"""Sizes of fonts, points."""


class PixelBox(NamedTuple):
    """Rectangle of a picture, pixels from its lower left corner."""

    left: float
    bottom: float
    width: float
    height: float


class Canvas:
    """Figure of fixed size. Positions are in pixels from its lower left corner."""

    def __init__(self, width: int, height: int) -> None:
        self.figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
        self._agg: Any = FigureCanvasAgg(self.figure)  # matplotlib leaves it untyped
        self._moving: list[Artist] = []
        self._still: Any = None

    def add_axes(self, left: float, bottom: float, width: float, height: float) -> Axes:
        """Add axes in a rectangle, pixels."""
        _, _, whole_width, whole_height = self.figure.bbox.bounds
        return self.figure.add_axes(
            (left / whole_width, bottom / whole_height, width / whole_width, height / whole_height)
        )

    def add_text(self, x: float, y: float, words: str, **style: Any) -> Text:
        """Write words at a point, pixels; `style` overrides matplotlib's settings of text."""
        style = {"color": INK, "fontsize": NORMAL_PT, "transform": IdentityTransform(), **style}
        return self.figure.text(x, y, words, **style)

    def add_caption(self, x: float, y: float, words: str) -> None:
        """Write a line of small text that stays inside the picture, in smaller letters if it is long."""
        max_letters = (self.figure.bbox.width - 2 * x) / 5.5  # pixels a letter of size SMALL_PT
        self.add_text(x, y, words, fontsize=SMALL_PT * min(1.0, max_letters / len(words)))

    def add_moving_artists(self, *artists: Artist) -> None:
        """Mark artists as moving parts: `pixels` draws them again on each call, in the order given."""
        for artist in artists:
            artist.set_animated(True)
            self._moving.append(artist)

    def pixels(self) -> Pixels:
        """Return the picture with its moving parts as they are now, shape (height, width, 3)."""
        if self._still is None:
            self._agg.draw()
            self._still = self._agg.copy_from_bbox(self.figure.bbox)
        self._agg.restore_region(self._still)
        for artist in self._moving:
            (artist.axes or self.figure).draw_artist(artist)
        return np.asarray(self._agg.buffer_rgba())[..., :3].copy()


def set_scale(axes: Axes, centre: tuple[float, float], pixels_per_mm: float) -> None:
    """Show the surroundings of a point (mm) at the same scale on both axes, without frame or ticks."""
    _, _, width, height = axes.bbox.bounds
    half_x, half_y = 0.5 * width / pixels_per_mm, 0.5 * height / pixels_per_mm
    axes.set_xlim(centre[0] - half_x, centre[0] + half_x)
    axes.set_ylim(centre[1] - half_y, centre[1] + half_y)
    axes.set_xticks([])
    axes.set_yticks([])


def nice_ceil(least: float) -> float:
    """Return the least number that is 1, 2 or 5 times a power of ten and not less than `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * step for step in (1, 2, 5, 10) if power * step >= least * (1 - 1e-9))


def nice_floor(most: float) -> float:
    """Return the largest number that is 1, 2 or 5 times a power of ten and not more than `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(power * step for step in (1, 2, 5) if power * step <= most * (1 + 1e-9))
