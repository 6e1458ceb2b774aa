"""Walkers from above, to one scale: bodies, headings, trails, an arena for each. `pose`: index of a pose in a run."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from walkergen.core import Array
from walkergen.files.animation import Draw, Pixels
from walkergen.files.canvas import (
    BODY_COLOUR,
    INK,
    LARGE_PT,
    LIMB_COLOUR,
    PLATE_COLOUR,
    SMALL_PT,
    Canvas,
    nice_floor,
    set_scale,
)
from walkergen.guests.movie.impacts import draw_legend, impact_style, largest_impulse, strongest_impact
from walkergen.guests.movie.shot import Shot, body_outline, foot_edges, format_pace, rotate
from walkergen.readers.drawings.outlines import area

WIDTH_PX, MAX_ARENAS_PX = 900, 760
"""Width of the picture, and largest height of all its arenas, pixels."""

HEAD_PX, TITLE_PX, FOOT_PX, MARGIN_PX = 54, 28, 44, 12
"""Heights of the picture's heading, of the title of an arena and of the row with the scale bar, and margin, pixels."""

ARROW_RATIO = 0.3
"""Length of the arrow that shows the walker's direction, over that of its body."""

GROUND_COLOUR, TRAIL_COLOUR = "#f3f3f1", "#cc5a33"


class Window(NamedTuple):
    """Rectangle of the plate that a picture shows, mm."""

    left: float
    right: float
    lower: float
    upper: float


class Arena(NamedTuple):
    """Part of the picture for one walker, with the artists that change with each frame."""

    shot: Shot
    axes: Axes
    trail: Line2D
    dots: Line2D
    """Positions of the walker at round times."""
    body: PolyCollection
    feet: LineCollection
    arrow: FancyArrowPatch
    flashes: list[Line2D]
    readout: Text


def make_draw_function(
    shots: Sequence[Shot], poses_per_frame: int, slow: float, settings: str, period: float, gap: float | None
) -> Draw:
    """Return a function that draws frame k of a film: pose k * poses_per_frame of each run, or its last pose.

    Parameters
    ----------
    shots : sequence of Shot
        Runs to show, in an arena each.
    poses_per_frame : int
        Simulated poses from one frame to the next.
    slow : float
        Seconds of film per second of the run.
    settings : str
        Line of text on scene and contact.
    period : float
        Period of the drive, s. Impacts are shown if a frame is shorter.
    gap : float or None
        Distance between the walls, mm; None without walls.
    """
    windows = [_window(shot, gap) for shot in shots]
    left, right = min(window.left for window in windows), max(window.right for window in windows)
    window_heights = [window.upper - window.lower for window in windows]
    scale = min((WIDTH_PX - 2 * MARGIN_PX) / (right - left), MAX_ARENAS_PX / sum(window_heights))
    heights = [math.ceil(scale * window_height) for window_height in window_heights]
    longest = max(shots, key=lambda shot: len(shot.poses.times)).poses.times
    frame_s = poses_per_frame * float(longest[1])
    glow, footer_px = (2.0 * frame_s, FOOT_PX + 20) if frame_s < period else (0.0, FOOT_PX)
    height = HEAD_PX + sum(heights) + len(shots) * TITLE_PX + footer_px
    canvas = Canvas(WIDTH_PX, height + height % 2)
    canvas.add_text(MARGIN_PX, height - 22, _shared_name(shots), fontsize=LARGE_PT, weight="bold")
    canvas.add_caption(MARGIN_PX, height - 40, settings)
    words = f"from above, {format_pace(slow)}"
    canvas.add_text(WIDTH_PX - MARGIN_PX, height - 22, words, ha="right", weight="bold")
    clock = canvas.add_text(0.5 * WIDTH_PX, height - 22, "", family="DejaVu Sans Mono", ha="center")
    interval = nice_floor(max(float(shot.poses.times[-1]) for shot in shots) / 6.0)  # some ten dots
    arenas, top = [], height - HEAD_PX
    for shot, height_px, window in zip(shots, heights, windows, strict=True):
        top -= TITLE_PX + height_px
        middle = 0.5 * (left + right), 0.5 * (window.lower + window.upper)
        arenas.append(_make_arena(canvas, shot, top, height_px, middle, scale, gap, interval))
    _draw_scale_bar(canvas, scale, interval)
    canvas.add_moving_artists(clock)
    if glow > 0.0:
        draw_legend(canvas, 20, footer_px - 14)

    def draw(frame: int) -> Pixels:
        """Return the picture of a frame."""
        for arena in arenas:
            _show_pose(arena, min(frame * poses_per_frame, len(arena.shot.poses.times) - 1), glow)
        clock.set_text(f"{longest[min(frame * poses_per_frame, len(longest) - 1)]:7.3f} s")
        return canvas.pixels()

    return draw


def _shared_name(shots: Sequence[Shot]) -> str:
    """Return the heading of the picture: the name of a single walker, or the design of several."""
    return f"{shots[0].name} legs" if len(shots) == 1 else shots[0].title.design


def _window(shot: Shot, gap: float | None) -> Window:
    """Return the window that contains the walker and its arrow during a whole run, and walls `gap` mm apart, if any."""
    shown = range(0, len(shot.poses.times), max(1, len(shot.poses.times) // 500))
    covered = np.concatenate([np.vstack([*body_outline(shot, pose), *_arrow_ends(shot, pose)]) for pose in shown])
    margin = 0.08 * float(shot.size[0])
    low, high = covered.min(axis=0) - margin, covered.max(axis=0) + margin
    side = 0.0 if gap is None else 0.5 * gap + margin
    return Window(low[0], high[0], min(low[1], -side), max(high[1], side))


def _arrow_ends(shot: Shot, pose: int) -> Array:
    """Return tail and tip of the arrow that shows the walker's direction at a pose, shape (2, 2), mm."""
    front, long = shot.base[0] + 0.5 * shot.size[0], ARROW_RATIO * shot.size[0]
    ends = np.array([(front, 0.0), (front + long, 0.0)])
    place: Array = shot.track[pose]
    return place + rotate(ends, shot.poses.heading[pose])


def _make_arena(
    canvas: Canvas,
    shot: Shot,
    bottom: float,
    height: float,
    middle: tuple[float, float],
    scale: float,
    gap: float | None,
    interval: float,
) -> Arena:
    """Add a walker's arena to the canvas.

    Parameters
    ----------
    canvas : Canvas
        Picture of all arenas.
    shot : Shot
        Run to show.
    bottom, height : float
        Lower edge and height of the arena, pixels.
    middle : tuple
        Point of the plate in its middle (x, y), mm.
    scale : float
        Pixels per mm.
    gap : float or None
        Distance between the walls, mm; None without walls.
    interval : float
        Time between dots on the trail, s.
    """
    axes = canvas.add_axes(MARGIN_PX, bottom, WIDTH_PX - 2 * MARGIN_PX, height)
    set_scale(axes, middle, scale)
    axes.set_facecolor(GROUND_COLOUR)
    for spine in axes.spines.values():
        spine.set_color(PLATE_COLOUR)
    for wall in () if gap is None else (-0.5 * gap, 0.5 * gap):
        axes.axhline(wall, color=INK, linewidth=1.5)
    axes.plot(*shot.track[0], "+", color=INK, markersize=7, markeredgewidth=0.8)
    canvas.add_text(MARGIN_PX, bottom + height + 6, shot.title.legs, weight="bold")
    readout = canvas.add_text(WIDTH_PX - MARGIN_PX, bottom + height + 6, "", family="DejaVu Sans Mono", ha="right")
    (trail,) = axes.plot([], [], color=TRAIL_COLOUR, linewidth=1.4)
    poses_per_dot = max(1, round(interval / float(shot.poses.times[1])))
    (dots,) = axes.plot([], [], "o", color=TRAIL_COLOUR, markersize=3.5, markevery=poses_per_dot)
    holes = [area(contour) < 0.0 for contour in shot.contours]
    colours = [GROUND_COLOUR if hole else BODY_COLOUR for hole in holes]
    body = PolyCollection([], facecolor=colours, edgecolor=INK, linewidths=0.8, alpha=0.9)
    edges = LineCollection([], colors=LIMB_COLOUR, linewidths=1.6)
    arrow = FancyArrowPatch(
        (0, 0), (0, 0), arrowstyle="-|>", shrinkA=0, shrinkB=0, color=INK, linewidth=1.2, mutation_scale=11, zorder=4
    )
    for artist in (body, edges, arrow):
        axes.add_artist(artist)
    flashes = [axes.plot([], [], marker=(9, 1, 0), markeredgewidth=0)[0] for _ in shot.poses.names]
    # The trail runs over the body, which would hide where O has been.
    canvas.add_moving_artists(body, edges, trail, dots, *flashes, arrow, readout)
    return Arena(shot, axes, trail, dots, body, edges, arrow, flashes, readout)


def _show_pose(arena: Arena, pose: int, glow: float) -> None:
    """Show the pose with index `pose` in an arena, and the impacts of the last `glow` seconds."""
    shot = arena.shot
    arena.body.set_verts(body_outline(shot, pose))
    arena.feet.set_segments(list(foot_edges(shot, pose)))
    for line in (arena.trail, arena.dots):
        line.set_data(*shot.track[: pose + 1].T)
    tail, tip = _arrow_ends(shot, pose)
    arena.arrow.set_positions(tuple(tail), tuple(tip))
    _show_flashes(arena, pose, glow)
    arena.readout.set_text(_format_readout(shot, pose))


def _show_flashes(arena: Arena, pose: int, glow: float) -> None:
    """Show the impacts of the last `glow` seconds before a pose; none if `glow` is 0."""
    shot, largest = arena.shot, largest_impulse(arena.shot)
    ends: Array = foot_edges(shot, pose).reshape(-1, 2)
    for corner, flash in enumerate(arena.flashes):
        shown = strongest_impact(shot, shot.poses.times[pose], glow, corner) if glow > 0.0 else None
        flash.set_visible(shown is not None)
        if shown is not None:
            hit, brightness = shown
            flash.set_data(*ends[corner][:, None])
            size = float(np.hypot(*hit.impulse)) / largest
            flash.set(color=impact_style(hit.kind).colour, markersize=26.0 * math.sqrt(size) * brightness)


def _format_readout(shot: Shot, pose: int) -> str:
    """Format heading, distance and mean speed at a pose and, at the last one, why the run ended."""
    time, distance = float(shot.poses.times[pose]), float(shot.distances[pose])
    words = f"heading {np.degrees(shot.poses.heading[pose]):+6.1f}°  ran {distance:7.1f} mm"
    if time > 0:
        words += f"  {distance / time:6.1f} mm/s so far"
    if pose == len(shot.poses.times) - 1 and shot.end_reason:
        words = f"{shot.end_reason} at {time:.2f} s  {words}"
    return words


def _draw_scale_bar(canvas: Canvas, scale: float, interval: float) -> None:
    """Draw a scale bar and explain the marks. `scale`: pixels per mm. `interval`: time between dots, s."""
    length = nice_floor(200.0 / scale)
    axes = canvas.add_axes(MARGIN_PX, 18, length * scale, 6)
    axes.set_xlim(0, 1)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[["top"]].set_visible(False)
    canvas.add_text(MARGIN_PX + length * scale + 8, 16, f"{length:g} mm", fontsize=SMALL_PT)
    words = f"line: trail of the body's centre of mass, a dot every {interval:g} s; arrow: heading"
    canvas.add_text(WIDTH_PX - MARGIN_PX, 16, words, fontsize=SMALL_PT, ha="right")
