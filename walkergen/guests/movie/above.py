"""Walkers from above, to one scale: bodies, headings and trails, an arena for each."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from walkergen.files.animation import Draw, Pixels
from walkergen.files.canvas import BODY, INK, LARGE, LIMB, PLATE, SMALL, Canvas, rounded_down, to_scale
from walkergen.guests.movie.impacts import largest_impulse, legend, strongest, style_of
from walkergen.guests.movie.shot import Array, Shot, feet, outline, pace, turned
from walkergen.readers.drawings.outlines import area

WIDTH, TALLEST = 900, 760
"""Width of the picture, and largest height of all its arenas, pixels."""

HEAD, TITLE, FOOT, MARGIN = 54, 28, 44, 12
"""Heights of the picture's head, of an arena's title and of the scale bar's row; margin."""

ARROW = 0.3
"""Length of the heading's arrow over that of the body."""

GROUND, TRAIL = "#f3f3f1", "#cc5a33"


class Window(NamedTuple):
    """Rectangle of the plate that a picture shows, mm."""

    left: float
    right: float
    lower: float
    upper: float


class Arena(NamedTuple):
    """Arena of one walker."""

    shot: Shot
    axes: Axes
    trail: Line2D
    dots: Line2D
    """Places at round times."""
    body: PolyCollection
    feet: LineCollection
    arrow: FancyArrowPatch
    flashes: list[Line2D]
    readout: Text


def draw_above(shots: Sequence[Shot], every: int, slow: float, settings: str, period: float, gap: float | None) -> Draw:
    """Make a function that draws frame k: pose k * every of every run; ended runs stay.

    `period` of the drive, s; `gap`: distance of a lane's walls, mm. Corners flash where a frame
    lasts less than a period: in real time they would never stop.
    """
    windows = [_window(shot, gap) for shot in shots]
    left, right = min(window.left for window in windows), max(window.right for window in windows)
    talls = [window.upper - window.lower for window in windows]
    scale = min((WIDTH - 2 * MARGIN) / (right - left), TALLEST / sum(talls))
    heights = [math.ceil(scale * tall) for tall in talls]
    longest = max(shots, key=lambda shot: len(shot.poses.times)).poses.times
    span = every * float(longest[1])
    glow, below = (2.0 * span, FOOT + 20) if span < period else (0.0, FOOT)
    height = HEAD + sum(heights) + len(shots) * TITLE + below
    canvas = Canvas(WIDTH, height + height % 2)
    canvas.text(MARGIN, height - 22, _names(shots), fontsize=LARGE, weight="bold")
    canvas.line(MARGIN, height - 40, settings)
    words = f"from above, {pace(slow)}"
    canvas.text(WIDTH - MARGIN, height - 22, words, ha="right", weight="bold")
    clock = canvas.text(0.5 * WIDTH, height - 22, "", family="DejaVu Sans Mono", ha="center")
    interval = rounded_down(max(float(shot.poses.times[-1]) for shot in shots) / 6.0)  # some ten dots
    arenas, top = [], height - HEAD
    for shot, tall, window in zip(shots, heights, windows, strict=True):
        top -= TITLE + tall
        middle = 0.5 * (left + right), 0.5 * (window.lower + window.upper)
        arenas.append(_arena(canvas, shot, top, tall, middle, scale, gap, interval))
    _bar(canvas, scale, interval)
    canvas.move(clock)
    if glow > 0.0:
        legend(canvas, 20, below - 14)

    def draw(frame: int) -> Pixels:
        for arena in arenas:
            _set(arena, min(frame * every, len(arena.shot.poses.times) - 1), glow)
        clock.set_text(f"{longest[min(frame * every, len(longest) - 1)]:7.3f} s")
        return canvas.pixels()

    return draw


def _names(shots: Sequence[Shot]) -> str:
    """Name of a single walker, or what several have in common."""
    return f"{shots[0].name} legs" if len(shots) == 1 else shots[0].title.design


def _window(shot: Shot, gap: float | None) -> Window:
    """Window on all that a run and its arrow cover, with a margin."""
    shown = range(0, len(shot.poses.times), max(1, len(shot.poses.times) // 500))
    covered = np.concatenate([np.vstack([*outline(shot, at), *_arrow(shot, at)]) for at in shown])
    margin = 0.08 * float(shot.size[0])
    low, high = covered.min(axis=0) - margin, covered.max(axis=0) + margin
    side = 0.0 if gap is None else 0.5 * gap + margin
    return Window(low[0], high[0], min(low[1], -side), max(high[1], side))


def _arrow(shot: Shot, at: int) -> Array:
    """Tail and tip of the heading's arrow at pose `at`, shape (2, 2), mm."""
    front, long = shot.base[0] + 0.5 * shot.size[0], ARROW * shot.size[0]
    ends = np.array([(front, 0.0), (front + long, 0.0)])
    place: Array = shot.track[at]
    return place + turned(ends, shot.poses.heading[at])


def _arena(
    canvas: Canvas,
    shot: Shot,
    bottom: float,
    height: float,
    middle: tuple[float, float],
    scale: float,
    gap: float | None,
    interval: float,
) -> Arena:
    axes = canvas.axes(MARGIN, bottom, WIDTH - 2 * MARGIN, height)
    to_scale(axes, middle, scale)
    axes.set_facecolor(GROUND)
    for spine in axes.spines.values():
        spine.set_color(PLATE)
    for wall in () if gap is None else (-0.5 * gap, 0.5 * gap):
        axes.axhline(wall, color=INK, linewidth=1.5)
    axes.plot(*shot.track[0], "+", color=INK, markersize=7, markeredgewidth=0.8)
    canvas.text(MARGIN, bottom + height + 6, shot.title.legs, weight="bold")
    readout = canvas.text(WIDTH - MARGIN, bottom + height + 6, "", family="DejaVu Sans Mono", ha="right")
    (trail,) = axes.plot([], [], color=TRAIL, linewidth=1.4)
    every = max(1, round(interval / float(shot.poses.times[1])))
    (dots,) = axes.plot([], [], "o", color=TRAIL, markersize=3.5, markevery=every)
    holes = [area(contour) < 0.0 for contour in shot.contours]
    colours = [GROUND if hole else BODY for hole in holes]
    body = PolyCollection([], facecolor=colours, edgecolor=INK, linewidths=0.8, alpha=0.9)
    edges = LineCollection([], colors=LIMB, linewidths=1.6)
    arrow = FancyArrowPatch(
        (0, 0), (0, 0), arrowstyle="-|>", shrinkA=0, shrinkB=0, color=INK, linewidth=1.2, mutation_scale=11, zorder=4
    )
    for artist in (body, edges, arrow):
        axes.add_artist(artist)
    flashes = [axes.plot([], [], marker=(9, 1, 0), markeredgewidth=0)[0] for _ in shot.poses.names]
    # The trail runs over the body, which would hide where O has been.
    canvas.move(body, edges, trail, dots, *flashes, arrow, readout)
    return Arena(shot, axes, trail, dots, body, edges, arrow, flashes, readout)


def _set(arena: Arena, at: int, glow: float) -> None:
    """Show pose `at`, and the landings of the last `glow` seconds."""
    shot = arena.shot
    arena.body.set_verts(outline(shot, at))
    arena.feet.set_segments(list(feet(shot, at)))
    for line in (arena.trail, arena.dots):
        line.set_data(*shot.track[: at + 1].T)
    tail, tip = _arrow(shot, at)
    arena.arrow.set_positions(tuple(tail), tuple(tip))
    _flash(arena, at, glow)
    arena.readout.set_text(_readout(shot, at))


def _flash(arena: Arena, at: int, glow: float) -> None:
    shot, largest = arena.shot, largest_impulse(arena.shot)
    ends: Array = feet(shot, at).reshape(-1, 2)
    for corner, flash in enumerate(arena.flashes):
        shown = strongest(shot, shot.poses.times[at], glow, corner) if glow > 0.0 else None
        flash.set_visible(shown is not None)
        if shown is not None:
            hit, left = shown
            flash.set_data(*ends[corner][:, None])
            size = float(np.hypot(*hit.impulse)) / largest
            flash.set(color=style_of(hit.kind).colour, markersize=26.0 * math.sqrt(size) * left)


def _readout(shot: Shot, at: int) -> str:
    time, distance = float(shot.poses.times[at]), float(shot.advance[at])
    words = f"heading {np.degrees(shot.poses.heading[at]):+6.1f}°  ran {distance:7.1f} mm"
    if time > 0:
        words += f"  {distance / time:6.1f} mm/s so far"
    if at == len(shot.poses.times) - 1 and shot.ended:
        words = f"{shot.ended} at {time:.2f} s  {words}"
    return words


def _bar(canvas: Canvas, scale: float, interval: float) -> None:
    """Draw a scale bar of a round length along the bottom, and say what the marks are."""
    length = rounded_down(200.0 / scale)
    axes = canvas.axes(MARGIN, 18, length * scale, 6)
    axes.set_xlim(0, 1)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[["top"]].set_visible(False)
    canvas.text(MARGIN + length * scale + 8, 16, f"{length:g} mm", fontsize=SMALL)
    words = f"line: trail of the body's centre of mass, a dot every {interval:g} s; arrow: heading"
    canvas.text(WIDTH - MARGIN, 16, words, fontsize=SMALL, ha="right")
