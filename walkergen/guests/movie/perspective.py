"""Slow motion in perspective: the printed mesh to scale, feet magnified, landings flashed.

Corners of the feet are numbered leg by leg, the left before the right: corner k belongs to foot k // 2. Axes of the
simulation: x along the lane, y up, z to the right of a walker that heads along x. `pose`: index of a pose in a run.
"""

import math
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.image import FigureImage
from matplotlib.lines import Line2D
from matplotlib.text import Text

from walkergen.core import Array
from walkergen.files.animation import Draw, Pixels
from walkergen.files.canvas import BODY_COLOUR, INK, PLATE_COLOUR, SMALL_PT, Canvas, PixelBox, nice_ceil
from walkergen.guests.movie import raster
from walkergen.guests.movie.impacts import (
    AFTERGLOW_S,
    MAX_STILL_LENGTHS,
    Course,
    Flash,
    add_flash,
    draw_heights,
    foot_colour,
    format_moment,
    largest_impulse,
    make_canvas,
    show_flash,
    strongest_impact,
)
from walkergen.guests.movie.raster import Camera
from walkergen.guests.movie.shot import Impact, Shot

MAIN_BOX = PixelBox(10, 272, 780, 262)
CLOSE_BOX = PixelBox(12, 12, 484, 214)
HEIGHTS_BOX = PixelBox(544, 42, 242, 166)
"""Rectangles, in the picture, of the view of the walker, the view of its feet and the plot of their heights."""

ZOOMS = (2000, 1000, 500, 200, 100, 50, 20, 10, 5, 2, 1)  # possible magnifications of heights

MAX_GAP_RATIO = 0.35
"""Largest gap under a foot in the magnified view, over the distance between the feet."""

MAX_BEND_RATIO = 0.3
"""Largest bending of a leg in the magnified view, over the largest gap."""

MAX_LABELS = 8
"""Largest number of corners that are labelled with their heights."""

GROUND_COLOUR, LINE_COLOUR = "#e4e4e1", "#c9c9c5"


class Seen(NamedTuple):
    """What views show of one pose of a run."""

    pose: int
    centre: Array
    """Centre of the views, shape (3,), mm."""
    corners: Array
    """Corners of the feet from the centre, shape (c, 3), mm."""
    glows: list[tuple[Impact, float] | None]
    """For each corner the impact to show and its brightness (0 to 1), or None."""


class View(NamedTuple):
    """View of the walker on the plate in perspective: its camera and the artists that change with each frame."""

    axes: Axes
    camera: Camera
    area: tuple[tuple[float, float], tuple[float, float]]
    """Range of x and range of z of the visible plate, from the centre of the view, mm."""
    ground: PolyCollection
    lines: LineCollection
    flashes: list[Flash]
    dots: list[Line2D]
    """Dot of each corner, shown while the corner presses on the plate."""
    longest: float
    """Length of the arrow of the largest impulse, mm."""


class CloseView(NamedTuple):
    """View of the feet, with their heights over the plate magnified."""

    view: View
    zoom: int
    """Magnification of heights over the plate."""
    bend: int
    """Magnification of depths below the plate: the depth of a pressed foot is the bending of its leg."""
    edges: list[Line2D]
    drops: LineCollection
    labels: list[Text]


def make_draw_function(shot: Shot, poses_per_frame: int, slow: float, settings: str) -> Draw:
    """Return a function that draws frame k: pose k * poses_per_frame. `slow`: seconds of film per second of the run."""
    canvas, readout = make_canvas(shot.name, settings, slow)
    centres, model = _view_centres(shot), raster.make_model(shot.mesh)
    main = _make_main_view(canvas, shot, centres)
    picture = FigureImage(canvas.figure)
    picture.set_data(np.zeros((1, 1, 4), np.uint8))
    canvas.figure.images.append(picture)
    canvas.add_moving_artists(main.ground, main.lines, picture)
    _add_moving_signs(canvas, main)
    close = _make_close_view(canvas, shot, centres)
    now = draw_heights(canvas, HEIGHTS_BOX, shot, _corner_courses(shot))
    canvas.add_moving_artists(readout)
    afterglow, R = AFTERGLOW_S / slow, shot.poses.rotations

    def draw(frame: int) -> Pixels:
        """Return the picture of a frame."""
        pose = min(frame * poses_per_frame, len(shot.times) - 1)
        shift = shot.poses.places[pose] - centres[pose]
        pixels, left, low = raster.render(model, R[pose], shift, main.camera, BODY_COLOUR, INK)
        picture.set_data(pixels)
        picture.ox, picture.oy = left + MAIN_BOX.left, low + MAIN_BOX.bottom
        glows = [
            strongest_impact(shot, float(shot.times[pose]), afterglow, corner)
            for corner in range(len(shot.poses.names))
        ]
        corners = shot.poses.corners[pose] - centres[pose]
        seen = Seen(pose, centres[pose], corners, glows)
        _update_view(main, shot, seen)
        _update_close_view(close, shot, seen)
        now.set_xdata([1e3 * shot.times[pose]] * 2)
        over = f"   {shot.end_reason}" if pose + poses_per_frame >= len(shot.times) else ""
        heading = f"   heading {np.degrees(shot.poses.heading[pose]):+.1f}°"
        moment = float(shot.times[pose]), float(shot.poses.phase[pose]), float(shot.distances[pose])
        readout.set_text(format_moment(*moment) + heading + over)
        return canvas.pixels()

    return draw


def _view_centres(shot: Shot) -> Array:
    """Return the centre of the view at each pose, shape (n, 3), mm: the origin or, in long runs, the walker."""
    flat = shot.poses.places * (1.0, 0.0, 1.0)
    return flat if np.ptp(flat, axis=0).max() > MAX_STILL_LENGTHS * shot.size[0] else 0.0 * flat


def _make_main_view(canvas: Canvas, shot: Shot, centres: Array) -> View:
    """Return the view of the whole walker, to scale. `centres`: centre of the view at each pose, shape (n, 3), mm."""
    poses = shot.poses
    shown = range(0, len(shot.times), max(1, len(shot.times) // 100))
    covered = np.concatenate(
        [shot.mesh.vertices @ poses.rotations[pose].T + poses.places[pose] - centres[pose] for pose in shown]
    )
    margin = 0.14 * float(shot.size[0])
    (left, _, near), (right, top, far) = covered.min(axis=0), covered.max(axis=0)
    x, z = (left - 1.2 * margin, right + 1.2 * margin), (near - margin, far + margin)
    points = np.array([(a, b, c) for a in x for c in z for b in (0.0,)])
    fitted = np.vstack([points, covered, [(right, top + 0.1, far)]])
    spacing = nice_ceil(0.05 * float(shot.size[0]))
    canvas.add_text(788, 530, f"to scale; lines {spacing:g} mm apart", fontsize=SMALL_PT, ha="right")
    count = len(poses.names)
    return _make_view(canvas, MAIN_BOX, fitted, (x, z), 0.16 * float(shot.size[0]), count)


def _make_view(
    canvas: Canvas,
    box: PixelBox,
    points: Array,
    area: tuple[tuple[float, float], tuple[float, float]],
    longest: float,
    corners: int,
) -> View:
    """Return a view in the rectangle `box` of the canvas, with a camera that shows all `points`, shape (n, 3), mm.

    Parameters
    ----------
    canvas : Canvas
        Picture to draw in.
    box : PixelBox
        Rectangle of the picture.
    points : ndarray
        Points that must be visible, shape (n, 3), mm.
    area : tuple
        Range of x and range of z of the visible plate, mm.
    longest : float
        Length of the longest arrow, mm.
    corners : int
        Number of corners of feet.
    """
    axes = canvas.add_axes(*box)
    axes.set_axis_off()
    axes.set_xlim(0, box.width)
    axes.set_ylim(0, box.height)
    camera = raster.fit_camera(points, (box.width, box.height))
    (left, right), (near, far) = area
    rim = np.array([(left, 0, near), (right, 0, near), (right, 0, far), (left, 0, far)])
    ground = PolyCollection(
        [camera.project(rim)[:, :2]], facecolor=GROUND_COLOUR, edgecolor=PLATE_COLOUR, linewidths=1.0
    )
    lines = LineCollection([], colors=LINE_COLOUR, linewidths=0.7)
    for artist in (ground, lines):
        axes.add_artist(artist)
    flashes = [add_flash(axes) for _ in range(corners)]
    dots = [axes.plot([], [], "o", color=INK, markersize=4.5)[0] for _ in range(corners)]
    return View(axes, camera, area, ground, lines, flashes, dots, longest)


def _add_moving_signs(canvas: Canvas, view: View) -> None:
    """Mark the bursts, dots and arrows of a view as moving parts of the canvas, redrawn in each frame."""
    for flash, dot in zip(view.flashes, view.dots, strict=True):
        canvas.add_moving_artists(flash.burst, dot, flash.arrow)


def _make_close_view(canvas: Canvas, shot: Shot, centres: Array) -> CloseView:
    """Return the view of the feet, heights magnified. `centres`: centre of the view at each pose, shape (n, 3), mm."""
    corners = shot.poses.corners - centres[:, None]
    flat = corners[..., [0, 2]].reshape(-1, 2)
    (left, near), (right, far) = flat.min(axis=0), flat.max(axis=0)
    largest = max(float(shot.poses.gaps.max()), 1e-6)
    room = MAX_GAP_RATIO * (right - left)
    zoom = next((zoom for zoom in ZOOMS if zoom * largest <= room), ZOOMS[-1])
    pressed = max(-float(shot.poses.gaps.min()), 0.0)
    bend = next((bend for bend in ZOOMS if bend * pressed <= MAX_BEND_RATIO * room), ZOOMS[-1])
    margin = 0.12 * (right - left)
    x, z = (left - margin, right + margin), (near - margin, far + margin)
    rim = np.array([(a, b, c) for a in x for c in z for b in (-bend * pressed, zoom * largest)])
    names = shot.poses.names
    view = _make_view(canvas, CLOSE_BOX, rim, (x, z), 0.22 * (right - left), len(names))
    bent = f", bending of legs (below it) × {bend}" if pressed > 0.0 else ""
    words = f"feet, heights over the plate × {zoom}{bent}; numbers: µm"
    canvas.add_text(CLOSE_BOX.left, CLOSE_BOX.bottom + CLOSE_BOX.height + 4, words, fontsize=SMALL_PT)
    drops = LineCollection([], colors=INK, linewidths=0.8, linestyles=[(0, (2, 2))])
    view.axes.add_artist(drops)
    edges = [view.axes.plot([], [], color=foot_colour(k), linewidth=3.0)[0] for k in range(len(names) // 2)]
    # Names stand outside: of the left corners, which are farther away, above; of the right below
    labels = [
        view.axes.text(
            0,
            0,
            "",
            fontsize=SMALL_PT,
            ha="center",
            va="bottom" if k % 2 == 0 else "top",
            visible=len(names) <= MAX_LABELS,
        )
        for k in range(len(names))
    ]
    canvas.add_moving_artists(view.ground, view.lines, drops, *edges)
    _add_moving_signs(canvas, view)
    canvas.add_moving_artists(*labels)
    return CloseView(view, zoom, bend, edges, drops, labels)


def _corner_courses(shot: Shot) -> list[Course]:
    """Return the height curve of each corner, in the colour of its foot: solid for left corners, dashed for right.

    The legend names the corners of two feet, more feet only by leg, and many feet not at all.
    """
    heights, names = shot.poses.corners[:, :, 1], shot.poses.names
    if len(names) > 4:
        several = len(names) > MAX_LABELS
        names = tuple("" if several or k % 2 else shot.poses.legs[k // 2] for k in range(len(names)))
    return [
        Course(name, foot_colour(k // 2), ("-", (0, (3, 1.5)))[k % 2], heights[:, k]) for k, name in enumerate(names)
    ]


def _update_view(view: View, shot: Shot, seen: Seen) -> None:
    """Change the plate's lines, the dots and the flashes of a view to those of one pose."""
    view.lines.set_segments(_plate_lines(view, shot, seen.centre))
    dots = view.camera.project(seen.corners)[:, :2]
    heading, largest = shot.poses.heading[seen.pose], largest_impulse(shot)
    for k, flash in enumerate(view.flashes):
        view.dots[k].set_data(*dots[k][:, None])
        view.dots[k].set_visible(bool(shot.poses.closed[seen.pose, k]))
        for artist in flash:
            artist.set_visible(seen.glows[k] is not None)
        if (glow := seen.glows[k]) is not None:
            hit, brightness = glow
            along, up = hit.impulse / largest * view.longest
            push = np.array([along * math.cos(heading), up, -along * math.sin(heading)])
            tail = view.camera.project(seen.corners[k] - push)[:2]
            show_flash(flash, hit, brightness, largest, tail, dots[k])


def _plate_lines(view: View, shot: Shot, centre: Array) -> list[Array]:
    """Return the two ends of each visible grid line of the plate, shape (2, 2), pixels. `centre`: of the view, mm."""
    spacing = nice_ceil(0.05 * float(shot.size[0]))
    (left, right), (near, far) = view.area
    segments = []
    for low, high, axis in ((left, right, 0), (near, far, 2)):
        first = math.ceil((low + centre[axis]) / spacing)
        count = math.floor((high + centre[axis]) / spacing) - first + 1
        for at in spacing * (first + np.arange(count)) - centre[axis]:
            segments.append([(at, 0, near), (at, 0, far)] if axis == 0 else [(left, 0, at), (right, 0, at)])
    return list(view.camera.project(np.array(segments, float))[..., :2])


def _update_close_view(close: CloseView, shot: Shot, seen: Seen) -> None:
    """Change the view of the feet to one pose, with heights and bending magnified."""
    gaps = shot.poses.gaps[seen.pose]
    on_plate = seen.corners * (1.0, 0.0, 1.0)
    magnified = np.where(gaps < 0.0, close.bend, close.zoom) * gaps
    raised = on_plate + np.outer(magnified, (0.0, 1.0, 0.0))
    _update_view(close.view, shot, seen._replace(corners=raised))
    project = close.view.camera.project
    tips, feet = project(raised)[:, :2], project(on_plate)[:, :2]
    for side, edge in enumerate(close.edges):
        edge.set_data(*tips[2 * side : 2 * side + 2].T)
    close.drops.set_segments([*np.stack([feet, tips], axis=1), *feet.reshape(-1, 2, 2)])
    for k, label in enumerate(close.labels):
        # Numbers keep away from the foot: above the left corner, under the plate's right one
        outer = max(tips[k][1], feet[k][1]) + 7.0, min(tips[k][1], feet[k][1]) - 7.0
        x, y = tips[k][0], outer[k % 2]
        label.set_position((x, y))
        label.set_text(_format_micrometres(gaps[k]))


def _format_micrometres(length: float) -> str:
    """Format a length in mm as whole µm; negative lengths, where legs bend, with one decimal."""
    micrometres = round(1e3 * length, 1 if length < 0.0 else 0) + 0.0
    text = f"{micrometres:.1f}" if micrometres < 0.0 else f"{micrometres:.0f}"
    return text.replace("-", "\N{MINUS SIGN}")
