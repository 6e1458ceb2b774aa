"""Movies and stills of a crowd from above, which show the outline of every walker.

`scale`: pixels per mm. N: number of walkers of the film.
"""

import io
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, Patch, Rectangle, Wedge
from PIL import Image

from walkergen.core import Array, InputError, Progress, Whole
from walkergen.core.files import output
from walkergen.files import animation
from walkergen.files.animation import Draw, Pixels
from walkergen.files.canvas import INK, LARGE_PT, PLATE_COLOUR, SMALL_PT, Canvas, nice_floor, set_scale
from walkergen.files.figures import SERIES
from walkergen.guests.crowd.statistics import dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

WIDTH_PX, MAX_DISH_HEIGHT_PX = 900, 860
"""Width of the picture, and largest height of the dish in it, pixels."""

HEADER_PX, FOOTER_PX, MARGIN_PX = 46, 40, 14
"""Heights of the rows above and below the dish; margin."""

HUE_COUNT = 72
"""Colours of headings, even around the circle."""

LIGHTNESS, CHROMA = 0.72, 0.12
"""Of the headings' colours in OKLab (https://bottosson.github.io/posts/oklab/): equally bright and in sRGB."""

SIMPLIFY_PX = 0.25
"""Tolerance for simplified outlines, pixels."""

DART_SHAPE = np.array([(0.5, 0.0), (-0.35, 0.3), (-0.2, 0.0), (-0.35, -0.3)])
"""Corners of the symbol for a walker without outline, over `_walker_size`: a dart that points along the heading."""

MAX_FRAMES = 2000
"""Most frames of a movie; of longer films every second frame is shown, or every third."""

SUFFIXES = (".mp4", ".gif", ".png")

GIF_FPS = (1, 2, 4, 5, 10, 20, 25, 50)
"""Frames per second that a GIF can have: it counts in hundredths of a second."""

HOLD_S = 1.5
"""Duration of the last frame of a GIF, s."""


class _Bodies(NamedTuple):
    """Walkers of one kind (indices), one contour of that kind, and the artist that draws it for each of them."""

    walkers: Whole
    corners: Array
    """Shape (corners, 2), mm."""
    drawn: PolyCollection


def check_format(path: Path) -> None:
    """Raise InputError for a suffix that names no format, and for an MP4 without ffmpeg."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"‹movie=›{str(path)[:80]!r}: {output.describe_wrong_ending(path, SUFFIXES)}")
    if suffix == ".mp4" and animation.find_ffmpeg() is None:
        raise InputError(f"‹movie=›{str(path)[:80]!r}: {animation.NO_FFMPEG_REASON}; name a .gif instead")


def write(path: Path, film: CrowdFilm, title: str, fps: int, progress: Progress) -> int:
    """Write a movie as .mp4 or .gif, or the last frame as .png. Return the number of frames in it.

    `fps`: frames per second. A GIF has the nearest rate that the format allows. Raises InputError as `check_format`
    does, and if ffmpeg fails.
    """
    check_format(path)
    suffix = path.suffix.lower()
    if suffix == ".png":
        output.write(path, render_still(film, title))
        return 1
    stride = math.ceil(len(film.times) / MAX_FRAMES)
    shown = film.select_frames(np.arange(0, len(film.times), stride))
    if suffix == ".gif":
        fps = min(GIF_FPS, key=lambda rate: abs(math.log(rate / fps)))
    draw, count = make_draw_function(shown, title, fps), len(shown.times)
    if suffix == ".gif":
        keep = ["#" + "".join(f"{round(255 * part):02x}" for part in hue) for hue in heading_colours()]
        output.write(path, animation.encode(draw, count, fps, HOLD_S, keep, progress).gif)
        return count
    mp4, reason = animation.encode_mp4(draw, count, fps, progress)
    if mp4 is None:
        raise InputError(f"{str(path)[:80]!r}: {reason}; name a .gif instead")
    output.write(path, mp4)
    return count


def render_still(film: CrowdFilm, title: str) -> bytes:
    """Render the last frame as PNG."""
    buffer = io.BytesIO()
    Image.fromarray(make_draw_function(film, title)(len(film.times) - 1)).save(buffer, "PNG")
    return buffer.getvalue()


def make_draw_function(film: CrowdFilm, title: str, fps: int | None = None) -> Draw:
    """Return a function from the number of a frame to its picture.

    Walkers are coloured by heading, or by kind if headings are unknown.

    Parameters
    ----------
    film : CrowdFilm
        Film to draw.
    title : str
        Title of the picture.
    fps : int, optional
        Frames per second of the movie, for the ratio to real speed in the caption; None for a still.
    """
    length, width = film.dish.box
    scale = min((WIDTH_PX - 2 * MARGIN_PX) / length, MAX_DISH_HEIGHT_PX / width)
    height = HEADER_PX + math.ceil(scale * width) + FOOTER_PX
    canvas = Canvas(WIDTH_PX, height + height % 2)
    axes = canvas.add_axes(MARGIN_PX, FOOTER_PX, WIDTH_PX - 2 * MARGIN_PX, math.ceil(scale * width))
    set_scale(axes, (0.0, 0.0), scale * (1.0 - 4.0 / WIDTH_PX))  # room for the line of the wall
    axes.axis("off")
    _draw_dish(axes, film)
    bodies = _add_bodies(axes, film, scale)
    canvas.add_text(MARGIN_PX, height - 30, title, fontsize=LARGE_PT, weight="bold")
    words = {"family": "DejaVu Sans Mono", "ha": "right"}
    clock = canvas.add_text(WIDTH_PX - MARGIN_PX, height - 30, "", **words)
    _draw_footer(canvas, film, scale, fps)
    paint = _make_colour_function(film)
    canvas.add_moving_artists(*(kind.drawn for kind in bodies), clock)

    def draw(frame: int) -> Pixels:
        """Return the picture of the film's frame with this number."""
        x, y = dish_geometry.wrap_places(film.x[frame], film.y[frame], film.dish)
        theta = film.theta[frame]
        faces = paint(theta)
        for kind in bodies:
            _update_bodies(kind, x, y, theta, faces, film)
        clock.set_text(f"{film.times[frame]:8.2f} s")
        return canvas.pixels()

    return draw


def heading_colours() -> Array:
    """Return the colours of headings from 0 on, counter-clockwise, shape (HUE_COUNT, 3), 0 to 1."""
    angle = 2.0 * np.pi * np.arange(HUE_COUNT) / HUE_COUNT
    a, b = CHROMA * np.cos(angle), CHROMA * np.sin(angle)
    roots = np.stack(
        [
            LIGHTNESS + 0.3963377774 * a + 0.2158037573 * b,
            LIGHTNESS - 0.1055613458 * a - 0.0638541728 * b,
            LIGHTNESS - 0.0894841775 * a - 1.2914855480 * b,
        ]
    )
    to_linear = np.array(
        [
            (4.0767416621, -3.3077115913, 0.2309699292),
            (-1.2684380046, 2.6097574011, -0.3413193965),
            (-0.0041960863, -0.7034186147, 1.7076147010),
        ]
    )
    linear = np.clip(to_linear @ roots**3, 0.0, 1.0).T
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _make_colour_function(film: CrowdFilm) -> Callable[[Array], Array]:
    """Return a function from headings (rad, shape (N,)) to the colour of each walker, shape (N, 3)."""
    if film.has_headings:
        wheel = np.vstack([heading_colours(), to_rgb(PLATE_COLOUR)])

        def colours_of_headings(theta: Array) -> Array:
            """Return the nearest of the hues for each heading; grey for NaN."""
            turn = np.nan_to_num(theta) / (2.0 * np.pi)
            hue = np.rint(turn * HUE_COUNT).astype(np.int64) % HUE_COUNT
            return np.asarray(wheel[np.where(np.isnan(theta), HUE_COUNT, hue)])

        return colours_of_headings
    kinds = list(dict.fromkeys(film.kinds))
    fixed_colours = np.array([to_rgb(_kind_colour(kinds.index(kind))) for kind in film.kinds])
    return lambda theta: fixed_colours


def _kind_colour(number: int) -> str:
    return SERIES[number % len(SERIES)][0]


def _add_bodies(axes: Axes, film: CrowdFilm, scale: float) -> list[_Bodies]:
    """Create the artists that draw the walkers, one for each contour of each kind. `scale`: pixels per mm."""
    made = []
    edge = "face" if scale * _walker_size(film) < 12.0 else INK  # so small that an edge would hide their colour
    for kind in dict.fromkeys(film.kinds):
        walkers = np.flatnonzero([name == kind for name in film.kinds])
        for contour in film.outlines.get(kind, (_symbol_outline(film),)):
            simple = shapely.simplify(shapely.Polygon(contour), SIMPLIFY_PX / scale)
            corners = shapely.get_coordinates(shapely.get_exterior_ring(simple))[:-1]
            drawn = PolyCollection([], linewidths=0.0 if edge == "face" else 0.5, edgecolors=edge)
            axes.add_collection(drawn)
            made.append(_Bodies(walkers, corners, drawn))
    return made


def _walker_size(film: CrowdFilm) -> float:
    """Return the mean outer diameter of the walkers, mm. If sizes are unknown, return half the mean spacing."""
    if film.has_sizes:
        return 2.0 * float(film.radii.mean())
    return 0.5 * math.sqrt(film.dish.area / film.x.shape[1])


def _symbol_outline(film: CrowdFilm) -> Array:
    """Return the symbol of a walker without an outline: a dart along the heading, or a disc."""
    angle = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    shape = DART_SHAPE if film.has_headings else 0.35 * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.asarray(_walker_size(film) * shape)


def _update_bodies(kind: _Bodies, x: Array, y: Array, theta: Array, colours: Array, film: CrowdFilm) -> None:
    """Set the artist of a kind to the walkers seen in a frame. A periodic square also shows their images.

    `x`, `y` (mm), `theta` (rad), shape (N,), and `colours`, shape (N, 3), are those of all walkers of the film.
    """
    walkers = kind.walkers[np.isfinite(x[kind.walkers])]
    places = np.column_stack([x[walkers], y[walkers]])
    if film.dish.period:
        places, walkers = _add_periodic_images(places, walkers, film.dish.period, float(np.abs(kind.corners).max()))
    angle = np.nan_to_num(theta[walkers])[:, None]
    c, s = np.cos(angle), np.sin(angle)
    along, across = kind.corners.T
    corners = np.stack([c * along - s * across, s * along + c * across], axis=2)
    kind.drawn.set_verts(list(corners + places[:, None]))
    kind.drawn.set_facecolor(list(map(tuple, colours[walkers])))


def _add_periodic_images(places: Array, walkers: Whole, period: float, reach: float) -> tuple[Array, Whole]:
    """Return `places` (n, 2) and `walkers` (n,) with images across the edges of a periodic square appended.

    Parameters
    ----------
    places, walkers : ndarray
        Position (mm) and index of each walker.
    period : float
        Side of the square, mm.
    reach : float
        Largest coordinate of a corner of the body, from its position, mm.
    """
    for axis in (0, 1):
        over = np.abs(places[:, axis]) > 0.5 * period - 1.5 * reach
        other = places[over]
        other[:, axis] -= period * np.sign(other[:, axis])
        places, walkers = np.concatenate([places, other]), np.concatenate([walkers, walkers[over]])
    return places, walkers


def _draw_dish(axes: Axes, film: CrowdFilm) -> None:
    """Draw the ground and the walls; a periodic square has a dashed edge."""
    style: dict[str, Any] = {"facecolor": "#f6f6f4", "edgecolor": INK, "linewidth": 1.5}
    length, width = film.dish.box
    if film.dish.kind in ("disc", "ring"):
        axes.add_patch(Circle((0, 0), 0.5 * length, **style))
    else:
        dashed = "--" if film.dish.period else "-"
        corner = (-0.5 * length, -0.5 * width)
        axes.add_patch(Rectangle(corner, length, width, linestyle=dashed, **style))
    if film.dish.kind == "ring":
        axes.add_patch(Circle((0, 0), 0.5 * film.dish.sizes[1], **style | {"facecolor": "white"}))


def _draw_footer(canvas: Canvas, film: CrowdFilm, scale: float, fps: int | None) -> None:
    """Draw the caption, a scale bar of a round length, and the legend of the colours. `scale`: pixels per mm."""
    length = nice_floor(160.0 / scale)
    bar = canvas.add_axes(MARGIN_PX, 14, length * scale, 5)
    bar.set(xlim=(0, 1), xticks=[], yticks=[])
    bar.spines[["top"]].set_visible(False)
    canvas.add_text(MARGIN_PX + length * scale + 8, 12, f"{length:g} mm", fontsize=SMALL_PT)
    pace = ""
    if fps is not None and len(film.times) > 1:
        pace = f", {fps * film.interval:.3g} of real speed"
    walkers = film.x.shape[1]
    words = f"{walkers} walker{'s' * (walkers != 1)}, {film.dish.words}{pace}"
    canvas.add_text(0.5 * WIDTH_PX, 12, words, fontsize=SMALL_PT, ha="center")
    if film.has_headings:
        wheel = canvas.add_axes(WIDTH_PX - MARGIN_PX - 32, 4, 32, 32)
        for number, hue in enumerate(heading_colours()):
            angles_deg = (360.0 * (number - 0.5) / HUE_COUNT, 360.0 * (number + 0.5) / HUE_COUNT)
            wheel.add_patch(Wedge((0, 0), 1.0, *angles_deg, width=0.45, facecolor=hue, linewidth=0))
        wheel.set(xlim=(-1.05, 1.05), ylim=(-1.05, 1.05))
        wheel.axis("off")
        canvas.add_text(WIDTH_PX - MARGIN_PX - 38, 12, "heading", fontsize=SMALL_PT, ha="right")
    elif len(kinds := list(dict.fromkeys(film.kinds))) > 1:
        _draw_legend(canvas, kinds)


def _draw_legend(canvas: Canvas, kinds: Sequence[str]) -> None:
    """Draw a legend of the kinds' colours."""
    colours = [Patch(color=_kind_colour(at), label=kind) for at, kind in enumerate(kinds)]
    place = (1.0 - MARGIN_PX / WIDTH_PX, 0.0)
    canvas.figure.legend(
        handles=colours, loc="lower right", bbox_to_anchor=place, ncols=len(kinds), fontsize=SMALL_PT, frameon=False
    )
