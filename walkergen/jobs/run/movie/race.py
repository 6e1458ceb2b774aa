"""Several walkers running side by side, each in its lane, to scale."""

from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.collections import PolyCollection
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from walkergen.files.animation import Draw, Pixels
from walkergen.files.canvas import BODY, INK, LARGE, LIMB, PLATE, SMALL, Canvas, to_scale
from walkergen.jobs.run.movie.footage import Footage, pace, polygons

WIDTH, HEAD, LANE, FOOT = 900, 64, 66, 40
"""Sizes in pixels: width of the picture, heights of its head, of a lane and of the ruler below."""

MARGIN = 12

BESIDE = 172
"""Width of the column of words to the left of the lanes, pixels."""

LONG = WIDTH - BESIDE - MARGIN
"""Length of a lane, pixels."""


class Lane(NamedTuple):
    """Lane of one walker."""

    footage: Footage
    shapes: PolyCollection
    readout: Text


def draw_race(runs: Sequence[Footage], slow: float, settings: str) -> Draw:
    """Make a function that draws frame k: pose k of every run; ended runs stay where they are."""
    height = HEAD + LANE * len(runs) + FOOT
    canvas = Canvas(WIDTH, height + height % 2)
    canvas.text(MARGIN, height - 22, runs[0].title.design, fontsize=LARGE, weight="bold")
    canvas.line(MARGIN, height - 40, settings)
    canvas.text(WIDTH - MARGIN, height - 22, f"to scale, {pace(slow)}", ha="right", weight="bold")
    clock = canvas.text(0.5 * WIDTH, height - 22, "", family="DejaVu Sans Mono", ha="center")
    left, scale = _window(runs)
    lanes = [
        _lane(canvas, footage, FOOT + LANE * (len(runs) - 1 - place), left, scale) for place, footage in enumerate(runs)
    ]
    _ruler(canvas, left, scale)
    canvas.move(clock)
    longest = max(runs, key=lambda footage: len(footage.times))

    def draw(frame: int) -> Pixels:
        for lane in lanes:
            _set(lane, min(frame, len(lane.footage.times) - 1))
        clock.set_text(f"{longest.times[frame]:6.2f} s")
        return canvas.pixels()

    return draw


def _window(runs: Sequence[Footage]) -> tuple[float, float]:
    """Left end (mm) and scale (pixels per mm) at which all runs fit, in width and in height."""
    left = min(float(run.places[:, 0].min() + run.shape.body[:, 0].min()) for run in runs)
    right = max(float(run.places[:, 0].max() + run.shape.body[:, 0].max()) for run in runs)
    top = max(float(run.places[:, 1].max() + run.shape.body[:, 1].max()) for run in runs)
    scale = min(LONG / (1.02 * (right - left)), 0.75 * LANE / top)
    return left - 0.01 * (right - left), scale


def _lane(canvas: Canvas, footage: Footage, bottom: float, left: float, scale: float) -> Lane:
    axes = canvas.axes(BESIDE, bottom, LONG, LANE)
    middle = left + 0.5 * LONG / scale
    to_scale(axes, (middle, (0.5 * LANE - 10) / scale), scale)
    axes.set_axis_off()
    (low, high), floor = axes.get_xlim(), axes.get_ylim()[0]
    axes.add_patch(Rectangle((low, 0.4 * floor), high - low, -0.4 * floor, color=PLATE))
    axes.axvline(0.0, ymin=10 / LANE, ymax=0.9, color=INK, linewidth=0.8, linestyle=(0, (2, 2)))
    canvas.text(MARGIN, bottom + LANE - 15, footage.title.legs, weight="bold")
    readout = canvas.text(
        MARGIN, bottom + LANE - 20, "", family="DejaVu Sans Mono", fontsize=SMALL, va="top", linespacing=1.3
    )
    shapes = PolyCollection([], linewidths=0.4)
    axes.add_collection(shapes, autolim=False)
    canvas.move(shapes, readout)
    return Lane(footage, shapes, readout)


def _set(lane: Lane, at: int) -> None:
    limbs, body = polygons(lane.footage, at)
    lane.shapes.set_verts([*limbs, body])
    lane.shapes.set(facecolor=[LIMB] * len(limbs) + [BODY], edgecolor=[LIMB] * len(limbs) + [INK])
    time, distance = lane.footage.times[at], lane.footage.places[at, 0]
    words = f"{distance:7.1f} mm"
    if time > 0:
        words += f"\n{distance / time:7.1f} mm/s so far"
    if at == len(lane.footage.times) - 1 and lane.footage.ended:
        words += f"\n{lane.footage.ended} at {time:.2f} s"
    lane.readout.set_text(words)


def _ruler(canvas: Canvas, left: float, scale: float) -> None:
    """Draw a ruler of the distance run by the middle of the body along the bottom."""
    axes = canvas.axes(BESIDE, FOOT - 4, LONG, 1)
    axes.set_xlim(left, left + LONG / scale)
    axes.set_yticks([])
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.tick_params(labelsize=SMALL, length=4, pad=2)
    axes.set_xlabel("mm along the plate, from where the middles of the bodies start", fontsize=SMALL, labelpad=1)
    axes.xaxis.set_major_locator(MaxNLocator(10, steps=[1, 2, 5, 10]))
