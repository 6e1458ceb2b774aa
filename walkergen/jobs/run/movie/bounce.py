"""Slow motion: a walker bouncing on the plate, to scale, its feet magnified, impacts flashed."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from walkergen.files.animation import Draw, Pixels
from walkergen.files.canvas import BODY, INK, LIMB, PLATE, SMALL, Canvas, Place, rounded_up, to_scale
from walkergen.jobs.run.movie.footage import BACK, FRONT, Array, Footage, Impact, feet, polygons, strongest
from walkergen.jobs.run.movie.impacts import (
    AFTERGLOW_S,
    FEET,
    LONGEST_STILL,
    Course,
    Flash,
    flash_in,
    largest_impulse,
    light,
    sheet,
    so_far,
    strip,
    style_of,
)

MAIN = Place(10, 276, 780, 256)
INSETS = Place(12, 12, 234, 196), Place(256, 12, 234, 196)
STRIP = Place(536, 42, 250, 166)
"""Places of the views."""

ZOOMS = (1000, 500, 200, 100, 50, 20, 10, 5, 2, 1)

BENDS = (1000, 500, 200, 100, 50, 20, 10, 5, 2, 1)
"""Magnifications of the legs' bending in the main view."""

MOST_BENT = math.radians(13.5)
"""Largest angle by which a leg is drawn bent, rad."""


class View(NamedTuple):
    """View of the plate, to scale."""

    axes: Axes
    shapes: PolyCollection
    plate: Rectangle
    ruler: LineCollection
    """Marks on the plate, which move up and down with it."""
    spacing: float
    """Distance between the marks, mm."""
    flashes: list[Flash]
    labels: list[Text]
    """Names of the kinds of impacts."""
    contacts: Line2D
    """Points of the feet that touch the plate."""
    longest: float
    """Length of the largest impulse's arrow, mm."""


def draw_bounce(footage: Footage, every: int, slow: float, settings: str) -> Draw:
    """Make a function that draws frame k: pose k * every of the footage, `slow` times slower."""
    canvas, readout = sheet(footage.name, settings, slow)
    at_feet, relaxed = feet(footage), feet(footage, relaxed=True)
    cameras, bend = _cameras(footage), _bend(footage)
    main, scale = _main(canvas, footage, cameras, bend)
    zoom = _zoom(footage, scale)
    insets = [_inset(canvas, footage, side, scale, zoom) for side in (BACK, FRONT)]
    courses = [Course(*FEET[side], at_feet[:, side, 1]) for side in (BACK, FRONT)]
    now = strip(canvas, STRIP, footage, courses)
    canvas.move(readout)
    largest, afterglow = largest_impulse(footage), AFTERGLOW_S / slow

    def draw(frame: int) -> Pixels:
        at = min(frame * every, len(footage.times) - 1)
        limbs, body = polygons(footage, at)
        shown = [strongest(footage, footage.times[at], afterglow, side) for side in (BACK, FRONT)]
        bent, straight = polygons(footage, at, bend)[0], limbs if bend > 1 else []
        _set(main, bent, body, footage.plate[at], cameras[at], at_feet[at], straight)
        for side in (BACK, FRONT):
            _flash(main, side, shown[side], at_feet[at, side], cameras[at], largest)
            view, camera, foot = insets[side], relaxed[at, side, 0], at_feet[at, side]
            _set(view, limbs, body, footage.plate[at], camera, foot[None])
            _flash(view, 0, shown[side], foot, camera, largest)
        now.set_xdata([1e3 * footage.times[at]] * 2)
        over = f"   {footage.ended}" if at + every >= len(footage.times) else ""
        readout.set_text(so_far(footage.times[at], footage.phase[at], footage.places[at, 0]) + over)
        return canvas.pixels()

    return draw


def _cameras(footage: Footage) -> Array:
    """Centres of the main view along the plate, mm, shape (n,): 0, or the body's in long runs."""
    distances = footage.places[:, 0]
    long = np.ptp(distances) > LONGEST_STILL * np.ptp(footage.shape.body[:, 0])
    return distances if long else np.zeros_like(distances)


def _bend(footage: Footage) -> int:
    """Largest round magnification of the legs' bending that still looks like the walker."""
    largest = float(np.abs(footage.angles).max(initial=0.0))
    if largest == 0.0:
        return 1
    return next((bend for bend in BENDS if bend * largest <= MOST_BENT), BENDS[-1])


def _extent(footage: Footage, cameras: Array) -> tuple[float, float, float]:
    """Left, right and top of the area that the walker covers in the main view, mm."""
    every = max(1, len(footage.times) // 500)
    covered = []
    for at in range(0, len(footage.times), every):
        limbs, body = polygons(footage, at)
        covered += [shape - (cameras[at], 0.0) for shape in (*limbs, body)]
    points = np.concatenate(covered)
    return float(points[:, 0].min()), float(points[:, 0].max()), float(points[:, 1].max())


def _main(canvas: Canvas, footage: Footage, cameras: Array, bend: int) -> tuple[View, float]:
    """Main view, with room for arrows in the plate, and its scale, pixels per mm."""
    left, right, top = _extent(footage, cameras)
    scale = min(MAIN.width / (1.06 * (right - left)), MAIN.height / (1.45 * top))
    axes, height = canvas.axes(*MAIN), MAIN.height / scale
    to_scale(axes, (0.5 * (left + right), 1.04 * top - 0.5 * height), scale)
    axes.set_axis_off()
    spacing = rounded_up(12.0 / scale)
    bending = f"legs' bending × {bend} (outlined: as it is), " if bend > 1 else ""
    words = f"{bending}all else to scale" if bending else "to scale"
    canvas.text(788, 530, f"{words}; marks {spacing:g} mm", fontsize=SMALL, ha="right")
    return _view(canvas, axes, spacing, -0.85 * axes.get_ylim()[0], feet_shown=2), scale


def _zoom(footage: Footage, scale: float) -> int:
    """Largest round magnification at which foot, plate and bounces stay in the picture."""
    foot = _foot_width(footage)
    heights = np.concatenate([feet(footage)[:, :, 1].ravel(), footage.plate])
    tall = max(1.6 * float(np.ptp(heights)), 0.5 * foot)
    _, _, width, height = INSETS[BACK]
    fitting = min(width / (1.15 * foot), height / tall) / scale
    return next((zoom for zoom in ZOOMS if zoom <= fitting), ZOOMS[-1])


def _foot_width(footage: Footage) -> float:
    """Width of a limb just above its foot, mm."""
    leg = np.concatenate(footage.shape.limbs[0])
    low = leg[leg[:, 1] < leg[:, 1].min() + 0.05 * np.ptp(leg[:, 1])]
    return float(np.ptp(low[:, 0]))


def _inset(canvas: Canvas, footage: Footage, side: int, scale: float, zoom: int) -> View:
    """Magnified view of one foot, which moves along with the foot of the unbent leg."""
    name, colour, _ = FEET[side]
    left, bottom, _, height = INSETS[side]
    axes = canvas.axes(*INSETS[side])
    for spine in axes.spines.values():
        spine.set_color(colour)
        spine.set_linewidth(1.5)
    heights = np.concatenate([feet(footage)[:, :, 1].ravel(), footage.plate])
    room = height / (zoom * scale)
    # The lowest point of the plate lies a third up: arrows below it, the leg above.
    to_scale(axes, (0.0, heights.min() + (0.5 - 0.33) * room), zoom * scale)
    spacing = rounded_up(20.0 / (zoom * scale))
    words = f"{name} × {zoom}, marks {spacing:g} mm"
    canvas.text(left, bottom + height + 8, words, fontsize=SMALL)
    return _view(canvas, axes, spacing, 0.28 * room, feet_shown=1)


def _view(canvas: Canvas, axes: Axes, spacing: float, longest: float, feet_shown: int) -> View:
    (left, right), bottom = axes.get_xlim(), axes.get_ylim()[0]
    axes.set_xticks([])
    plate = Rectangle((left, bottom), right - left, -bottom, facecolor=PLATE, edgecolor=INK)
    ruler = LineCollection([], colors=INK, linewidths=0.8)
    shapes = PolyCollection([], linewidths=0.6)
    for artist in (plate, ruler, shapes):
        axes.add_artist(artist)
    (contacts,) = axes.plot([], [], "o", color=INK, markersize=3.5)
    flashes = [flash_in(axes) for _ in range(feet_shown)]
    bold = {"weight": "bold", "va": "center", "family": "DejaVu Serif"}
    labels = [axes.text(0, 0, "", fontdict=bold) for _ in range(feet_shown)]
    bursts, arrows = [flash.burst for flash in flashes], [flash.arrow for flash in flashes]
    canvas.move(plate, ruler, *bursts, shapes, contacts, *arrows, *labels)
    return View(axes, shapes, plate, ruler, spacing, flashes, labels, contacts, longest)


def _set(
    view: View,
    limbs: list[Array],
    body: Array,
    height: float,
    camera: float,
    points: Array,
    outlined: Sequence[Array] = (),
) -> None:
    """Show limbs and body, and the plate at a height, seen from `camera` (mm along the plate)."""
    offset, hollow = np.array([camera, 0.0]), len(outlined)
    view.shapes.set_verts([shape - offset for shape in (*limbs, *outlined, body)])
    view.shapes.set(
        facecolor=[LIMB] * len(limbs) + ["none"] * hollow + [BODY], edgecolor=[LIMB] * len(limbs) + [INK] * (hollow + 1)
    )
    view.plate.set_height(height - view.plate.get_y())
    left, right = view.axes.get_xlim()
    first = math.ceil((left + camera) / view.spacing)
    last = math.floor((right + camera) / view.spacing)
    depth = 0.02 * float(np.ptp(view.axes.get_ylim()))
    at = view.spacing * np.arange(first, last + 1) - camera
    longer = np.where(np.arange(first, last + 1) % 5 == 0, 2.2, 1.0)
    view.ruler.set_segments([[(x, height), (x, height - size * depth)] for x, size in zip(at, longer, strict=True)])
    view.contacts.set_data(points[:, 0] - camera, points[:, 1])


def _flash(
    view: View, place: int, shown: tuple[Impact, float] | None, foot: Array, camera: float, largest: float
) -> None:
    """Draw the impulse on a foot: an arrow that ends at it, the name of its kind, and a burst."""
    flash, label = view.flashes[place], view.labels[place]
    for artist in (*flash, label):
        artist.set_visible(shown is not None)
    if shown is None:
        return
    hit, left = shown
    foot = foot - (camera, 0.0)
    tail = foot - view.longest * hit.impulse / largest
    light(flash, hit, left, largest, tail, foot)
    style, size = style_of(hit.kind), float(np.hypot(*hit.impulse)) / largest
    aside = 12.0 * float(np.ptp(view.axes.get_xlim())) / view.axes.bbox.width
    label.set_position((max(tail[0], foot[0]) + aside, 0.5 * (tail[1] + foot[1])))
    label.set(text=style.name, color=style.colour, alpha=left, fontsize=7.0 + 6.0 * size)
