"""Impacts in slow motion: a colour, a sign and a name for each kind, flashes, their course in time."""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from walkergen.core import Array
from walkergen.core.theory.impact import Kind
from walkergen.files.canvas import INK, LARGE_PT, PLATE_COLOUR, SMALL_PT, Canvas, PixelBox
from walkergen.guests.movie.shot import Impact, Shot, format_pace

Dashes = str | tuple[float, tuple[float, ...]]
"""Style of a line, as matplotlib has it."""


WIDTH_PX, HEIGHT_PX = 800, 620
"""Size of a picture of slow motion, pixels."""

AFTERGLOW_S = 0.45
"""Fading time of a flash in the movie, s."""

MAX_STILL_LENGTHS = 1.5
"""Longest run, in body lengths, with a fixed view."""


class Style(NamedTuple):
    """Colour (after Okabe and Ito) and marker of one kind of impact, and its name in numerals and in words."""

    colour: str
    marker: str
    name: str
    words: str


STYLES = {
    Kind.I: Style("#E69F00", "o", "I", "slides forward"),
    Kind.II: Style("#0072B2", "s", "II", "stops on rebound"),
    Kind.III: Style("#009E73", "^", "III", "stops in compression"),
    Kind.IV: Style("#CC3311", "v", "IV", "slides backward"),
    Kind.FROM_REST: Style("#555555", "D", "0", "from rest"),
}

FIRST_FOOT_COLOURS = ("#222222", "#AA4499")
"""Colours of the first two feet."""

FURTHER_FOOT_COLOURS = ("#0072B2", "#009E73", "#B8860B", "#CC3311", "#56B4E9", "#7A5195")
"""Colours of the third foot and all others, used again from the start if there are more feet."""


def foot_colour(foot: int) -> str:
    """Return the colour of the foot with this index, from 0."""
    return (
        FIRST_FOOT_COLOURS[foot]
        if foot < len(FIRST_FOOT_COLOURS)
        else FURTHER_FOOT_COLOURS[(foot - len(FIRST_FOOT_COLOURS)) % len(FURTHER_FOOT_COLOURS)]
    )


def movie_colours(feet: int) -> tuple[str, ...]:
    """Return the colours that the palette of a movie must contain, for a walker on `feet` feet."""
    named = max(feet, len(FIRST_FOOT_COLOURS))
    return (*(style.colour for style in STYLES.values()), *dict.fromkeys(foot_colour(foot) for foot in range(named)))


def impact_style(kind: Kind) -> Style:
    """Return the style of a kind of impact. A mirrored kind (backward) has its twin's, with a minus in the name."""
    if kind in STYLES:
        return STYLES[kind]
    twin = STYLES[Kind(-kind)]
    return twin._replace(name=f"\N{MINUS SIGN}{twin.name}")


def draw_legend(canvas: Canvas, x: float, y: float) -> None:
    """Draw the legend of the kinds of impacts in a row from (x, y), pixels."""
    axes = canvas.add_axes(0, 0, *canvas.figure.bbox.bounds[2:])
    axes.set_axis_off()
    axes.set_xlim(0, canvas.figure.bbox.width)
    axes.set_ylim(0, canvas.figure.bbox.height)
    for style in STYLES.values():
        axes.plot([x], [y], style.marker, color=style.colour, markersize=5)
        words = f"{style.name} {style.words}"
        canvas.add_text(x + 8, y, words, fontsize=SMALL_PT, va="center")
        x += 26 + 5.4 * len(words)
    canvas.add_text(x - 4, y, "\N{MINUS SIGN} moving backward", fontsize=SMALL_PT, va="center")


class Course(NamedTuple):
    """Curve of the height of one corner of a foot over time: its name, colour, dashes and values."""

    name: str
    colour: str
    line: Dashes
    heights: Array
    """Heights at the times of the shot, shape (n,), mm."""


def draw_heights(canvas: Canvas, box: PixelBox, shot: Shot, feet: list[Course]) -> Line2D:
    """Draw the heights of plate and feet over time with all impacts. Return the line that marks the current time.

    `box`: rectangle of the plot. `feet`: curve of each corner of a foot, in the order of the numbers in `Impact.foot`.
    """
    axes = canvas.add_axes(*box)
    canvas.add_text(box.left - 34, box.bottom + box.height + 8, "heights, µm", fontsize=SMALL_PT)
    times, heights = 1e3 * shot.times, 1e3 * np.array([course.heights for course in feet])
    plate = 1e3 * shot.plate_heights
    low, high = min(plate.min(), heights.min()), max(plate.max(), heights.max())
    margin = 0.08 * max(high - low, 1e-6)
    axes.set_ylim(low - margin, high + margin)
    axes.set_xlim(0.0, times[-1])
    axes.fill_between(times, plate, low - margin, color=PLATE_COLOUR, linewidth=0)
    for (name, colour, line, _), height in zip(feet, heights, strict=True):
        axes.plot(times, height, color=colour, linestyle=line, linewidth=1.2, label=name or "_")
    _draw_marks(axes, shot, feet)
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.02, 0.98),
        ncols=2,
        frameon=False,
        fontsize=SMALL_PT,
        handlelength=1.8,
        columnspacing=1.0,
        borderaxespad=0.1,
    )
    axes.tick_params(labelsize=SMALL_PT - 1, length=3, pad=2)
    axes.set_xlabel("time, ms", fontsize=SMALL_PT, labelpad=1)
    axes.spines[["top", "right"]].set_visible(False)
    (now,) = axes.plot([0.0, 0.0], [low - margin, high + margin], color=INK, linewidth=1.0)
    canvas.add_moving_artists(now)
    return now


def _draw_marks(axes: Axes, shot: Shot, feet: list[Course]) -> None:
    """Draw a marker for every impact at the height of the plate, larger for larger impulses."""
    largest = largest_impulse(shot)
    for hit in shot.impacts:
        style, size = impact_style(hit.kind), float(np.hypot(*hit.impulse)) / largest
        height = 1e3 * np.interp(hit.time, shot.times, shot.plate_heights)
        edge = feet[hit.foot].colour
        axes.plot(
            [1e3 * hit.time],
            [height],
            style.marker,
            color=style.colour,
            markeredgecolor=edge,
            markeredgewidth=0.6,
            markersize=2.0 + 4.0 * size,
            zorder=3,
        )


class Flash(NamedTuple):
    """Marks of an impact at a foot: an arrow and a burst."""

    arrow: FancyArrowPatch
    """Arrow in the direction of the impulse. It ends at the foot."""
    burst: Line2D


def add_flash(axes: Axes) -> Flash:
    """Add the arrow and the burst of an impact to axes, to be set by `show_flash`."""
    arrow = FancyArrowPatch((0, 0), (0, 0), arrowstyle="-|>", shrinkA=0, shrinkB=0, zorder=4)
    axes.add_patch(arrow)
    (burst,) = axes.plot([], [], marker=(9, 1, 0), markeredgewidth=0)
    return Flash(arrow, burst)


def show_flash(flash: Flash, hit: Impact, brightness: float, largest: float, tail: Array, foot: Array) -> None:
    """Change the burst and the arrow of a flash to those of an impact. Their sizes grow with its impulse.

    Parameters
    ----------
    flash : Flash
        Artists to change.
    hit : Impact
        Impact to show.
    brightness : float
        Brightness, 0 to 1.
    largest : float
        Impulse for which burst and arrow are largest, g mm/s.
    tail, foot : ndarray
        Both ends of the arrow, shape (2,). The burst is at the foot.
    """
    colour, size = impact_style(hit.kind).colour, float(np.hypot(*hit.impulse)) / largest
    flash.arrow.set_positions(tuple(tail), tuple(foot))
    flash.arrow.set(color=colour, alpha=brightness, linewidth=0.5 + 3.0 * size)
    flash.arrow.set_mutation_scale(4.0 + 12.0 * size)
    flash.burst.set_data(*foot[:, None])
    flash.burst.set(color=colour, markersize=40.0 * np.sqrt(size) * brightness**3)


def make_canvas(name: str, settings: str, slow: float) -> tuple[Canvas, Text]:
    """Return a canvas with heading and legend, and its empty line of text, which each frame sets."""
    canvas = Canvas(WIDTH_PX, HEIGHT_PX)
    canvas.add_text(12, 598, f"{name} legs", fontsize=LARGE_PT, weight="bold")
    canvas.add_caption(12, 579, settings)
    canvas.add_text(788, 547, format_pace(slow), ha="right", weight="bold")
    draw_legend(canvas, 20, 253)
    return canvas, canvas.add_text(12, 547, "", family="DejaVu Sans Mono")


def format_moment(time: float, phase: float, distance: float) -> str:
    """Format time (s), phase of the drive (rad), distance covered (mm) and mean speed as a line."""
    speed = f"{distance / time:6.1f} mm/s" if time > 0 else "     - mm/s"
    turn = np.degrees(phase) % 360.0
    return f"{1e3 * time:6.1f} ms   phase {turn:3.0f}°   ran {distance:6.2f} mm   so far {speed}"


def largest_impulse(shot: Shot) -> float:
    """Return the largest impulse of all impacts, g mm/s; 1 without impacts."""
    return max((float(np.hypot(*hit.impulse)) for hit in shot.impacts), default=1.0)


def strongest_impact(shot: Shot, time: float, afterglow: float, foot: int) -> tuple[Impact, float] | None:
    """Return the impact to show at a corner of a foot at `time`, and its brightness (0 to 1); None without one.

    It has the largest impulse times brightness. The brightness falls from 1 to 0 within `afterglow` seconds.
    """
    shown = [
        (hit, 1.0 - (time - hit.time) / afterglow)
        for hit in shot.impacts
        if hit.foot == foot and time - afterglow < hit.time <= time
    ]
    if not shown:
        return None
    return max(shown, key=lambda pair: float(np.hypot(*pair[0].impulse)) * pair[1])
