"""Panels of the figures of a sweep: lines, a map or a cloud of points in given axes.

A point's number is its value of the shown quantity, usually the speed. Points without a number are crosses below the
axis, or hatched cells. Points in doubt have open symbols.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import CenteredNorm, Normalize
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from walkergen.core import Array, Mask
from walkergen.guests.sweep.scales import Scale, cell_edges, format_axis
from walkergen.points.point import PointStatus

MAX_BARS = 40
"""Largest number of points in a line with error bars; longer lines have a band."""

MAX_CLOUD_BARS = 1000
"""Largest number of points in a cloud with visible error bars."""

MIN_CONTOUR_VALUES, MIN_CONTOUR_SHARE = 4, 0.75
"""A map has contours if both keys have this many values, and if this share of the points has a number."""

LABEL_DISTANCE, CONTOUR_DISTANCE = 0.18, 0.05
"""Smallest distance of a contour's label from other labels, and from other contours, as shares of the panel's width
and height."""

ROW_PT = 6.0
"""Distance below the axis of the row of crosses for points without a number, in points of 1/72 inch."""

MAX_SMALL_SHARE = 0.05
"""Colours are not centred on zero if the negative numbers are below this share of the largest number."""

MAX_CORNERS = 200
"""Largest number of corners of a contour that are compared as positions of its label."""

# Okabe and Ito's colours; dash and marker distinguish them in grey.
LINE_STYLES: tuple[tuple[str, Any, str], ...] = (
    ("#000000", "-", "o"),
    ("#0072B2", "--", "s"),
    ("#D55E00", "-.", "^"),
    ("#009E73", ":", "D"),
    ("#CC79A7", (0, (6, 1.5, 1, 1.5, 1, 1.5)), "v"),
)

DOUBTFUL_STYLE: Any = {
    "linestyle": "none",
    "marker": "o",
    "markerfacecolor": "white",
    "markeredgecolor": "black",
    "markeredgewidth": 0.6,
    "markersize": 3.0,
}
"""Look of the open symbols of points whose number is in doubt."""

MISSING_STYLE: Any = {"facecolor": "0.92", "edgecolor": "0.35", "hatch": "xxxx", "linewidth": 0.0}
"""Look of the cells of points that have no number."""


class Columns(NamedTuple):
    """Columns of a table with a row for each point."""

    keys: Mapping[str, Sequence[Any]]
    """Values of each key, numbers or words."""
    value: Array
    """Shown quantity, usually the speed; NaN for points without it."""
    low: Array
    high: Array
    """Bounds of 95 % of the numbers; NaN where they are unknown."""
    status: Sequence[str]
    """"ok", or the problem of a point."""
    label: str = "speed (mm/s)"
    """Name of the number, with its unit."""

    @property
    def missing(self) -> Mask:
        """True for points without the shown quantity, shape (n,)."""
        missing: Mask = np.isnan(self.value)
        return missing

    @property
    def doubtful(self) -> Mask:
        """True for points with the shown quantity, but a status other than "ok", shape (n,)."""
        doubtful: Mask = np.array([status != PointStatus.OK for status in self.status], dtype=bool)
        return doubtful & ~self.missing


def make_norm(value: Array) -> Normalize:
    """Return the colour scale for all values in a figure, centred on zero if clearly both signs occur."""
    low, high = float(np.nanmin(value)), float(np.nanmax(value))
    if low < -MAX_SMALL_SHARE * high < 0.0:
        return CenteredNorm(0.0, max(-low, high))
    return Normalize(low, high) if low < high else Normalize(low - 0.5, high + 0.5)


def colour_map(norm: Normalize) -> str:
    """Return the name of a colour map that is safe for colour blindness: diverging if `norm` is centred on zero."""
    return "PuOr" if isinstance(norm, CenteredNorm) else "cividis"


def _line_colour(norm: Normalize, value: float) -> str:
    """Return the colour, black or white, of a contour that is visible on the map's colour at its value."""
    share = float(norm(value))
    dark = abs(share - 0.5) > 0.3 if isinstance(norm, CenteredNorm) else share < 0.5
    return "white" if dark else "black"


# Lines


def draw_lines(axes: Axes, columns: Columns, x: Scale, line_scale: Scale | None, rows: Mask) -> None:
    """Draw the points where `rows` is True against the key `x`, with a line for each value of the key `line_scale`."""
    count = 1 if line_scale is None else len(line_scale.values)
    for number in range(count):
        chosen = rows if line_scale is None else rows & (line_scale.indices == number)
        shift = 0.14 * (number - 0.5 * (count - 1)) if x.has_words else 0.0
        draw_dots(axes, columns, x, chosen, LINE_STYLES[number], joined=not x.has_words, shift=shift)
    format_axis(axes, "x", x)
    shown = columns.value[~columns.missing]
    if x.has_words:
        axes.set_xlim(-0.6, len(x.values) - 0.4)
    if shown.min() < 0 < shown.max():
        axes.axhline(0.0, color="0.6", linewidth=0.7, zorder=0)


def draw_dots(
    axes: Axes, columns: Columns, x: Scale, rows: Mask, style: tuple[str, Any, str], joined: bool, shift: float = 0.0
) -> None:
    """Draw points, with their bounds, over the key of a scale. Points without a number are crosses at the bottom.

    Parameters
    ----------
    axes : Axes
        Axes to draw in.
    columns : Columns
        Points of a sweep.
    x : Scale
        Scale of the x axis.
    rows : ndarray of bool
        True for points to draw, shape (n,).
    style : tuple
        Colour, dash and marker.
    joined : bool
        Whether to join the points by a line.
    shift : float
        Distance by which all points are moved along x.
    """
    colour, dash, marker = style
    order = np.flatnonzero(rows)[np.argsort(x.row_positions[rows], kind="stable")]
    positions, value = x.row_positions[order] + shift, columns.value[order]
    low, high = columns.low[order], columns.high[order]
    bounded = np.isfinite(low) & np.isfinite(high) & np.isfinite(value)
    crowded = len(order) > MAX_BARS
    if joined:
        axes.plot(positions, value, linestyle=dash, color=colour)
    if crowded and joined and bounded.any():
        axes.fill_between(positions, low, high, color=colour, alpha=0.2, linewidth=0)
    elif bounded.any() and len(order) <= MAX_CLOUD_BARS:
        lengths = np.abs([value[bounded] - low[bounded], high[bounded] - value[bounded]])
        looks: Any = {"fmt": "none", "ecolor": colour, "elinewidth": 0.8, "alpha": 0.5 if crowded else 1.0}
        axes.errorbar(positions[bounded], value[bounded], lengths, **looks)
    doubtful = columns.doubtful[order]
    plain = np.flatnonzero(~doubtful & np.isfinite(value))
    if crowded and joined:  # about 12 markers are enough to distinguish the lines
        plain = plain[:: max(1, len(plain) // 12)]
    dots: Any = {"linestyle": "none", "marker": marker, "color": colour, "zorder": 3}
    dots["rasterized"] = len(order) > MAX_CLOUD_BARS
    axes.plot(positions[plain], value[plain], **dots)
    axes.plot(positions[doubtful], value[doubtful], markerfacecolor="white", **dots)
    missing = positions[np.isnan(value)]
    axes.update_datalim(np.column_stack([x.positions, x.positions]), updatey=False)  # crosses do not widen the axis
    if len(missing):  # in one row between the axis and its numbers: on the axis they would read as speeds
        row = axes.get_xaxis_transform() + ScaledTranslation(0.0, -ROW_PT / 72.0, axes.figure.dpi_scale_trans)
        axes.plot(missing, np.zeros(len(missing)), "x", color="black", transform=row, clip_on=False)
        axes.tick_params(axis="x", pad=3.5 + ROW_PT)


def value_label(columns: Columns, max_points: int | None = None) -> str:
    """Return the label of the shown quantity's axis. It mentions bounds if at most `max_points` points have them."""
    bounded = np.isfinite(columns.low).any() and (max_points is None or len(columns.low) <= max_points)
    return f"{columns.label}, bounds of 95 %" if bounded else columns.label


# Maps


def draw_map(axes: Axes, columns: Columns, x: Scale, y: Scale, rows: Mask, norm: Normalize) -> None:
    """Draw a map of the shown quantity over two keys: a coloured cell for each chosen point, and contours.

    Contours need numeric keys and few missing values. `rows`: True for points to draw, shape (n,).
    """
    value = np.full((len(y.values), len(x.values)), np.nan)
    value[y.indices[rows], x.indices[rows]] = columns.value[rows]
    mesh = axes.pcolormesh(cell_edges(x), cell_edges(y), value, cmap=colour_map(norm), norm=norm, rasterized=True)
    format_axis(axes, "x", x)
    format_axis(axes, "y", y)
    missing, doubtful = rows & columns.missing, rows & columns.doubtful
    if missing.any():
        _hatch_cells(axes, x, y, missing)
    if doubtful.any():
        axes.plot(x.row_positions[doubtful], y.row_positions[doubtful], **DOUBTFUL_STYLE, zorder=4)
    smooth = not x.has_words and not y.has_words and min(len(x.values), len(y.values)) >= MIN_CONTOUR_VALUES
    smooth = smooth and bool(np.isfinite(value).mean() >= MIN_CONTOUR_SHARE)
    if smooth and np.nanmin(value, initial=np.inf) < np.nanmax(value, initial=-np.inf):
        _draw_contours(axes, x, y, np.ma.masked_invalid(value), norm)
    mesh.set_edgecolor("none")


def _hatch_cells(axes: Axes, x: Scale, y: Scale, missing: Mask) -> None:
    """Hatch the cells of points for which `missing`, shape (n,), is True."""
    across, up = cell_edges(x), cell_edges(y)
    cells = [
        [(across[i], up[j]), (across[i + 1], up[j]), (across[i + 1], up[j + 1]), (across[i], up[j + 1])]
        for i, j in zip(x.indices[missing], y.indices[missing], strict=True)
    ]
    axes.add_collection(PolyCollection(cells, **MISSING_STYLE))


def _draw_contours(axes: Axes, x: Scale, y: Scale, value: Array, norm: Normalize) -> None:
    """Draw labelled contours of `value`, shape (y values, x values), dashed below zero."""
    levels = MaxNLocator(7).tick_values(value.min(), value.max())
    levels = levels[(levels > value.min()) & (levels < value.max())]
    if not len(levels):
        return
    looks: Any = {
        "colors": [_line_colour(norm, level) for level in levels],
        "linestyles": ["--" if level < 0 else "-" for level in levels],
    }
    lines = axes.contour(x.positions, y.positions, value, levels=levels, linewidths=0.8, **looks)
    segments = [np.concatenate(parts) for parts in lines.allsegs if len(parts)]
    segments = [segment for segment in segments if len(segment)]  # a level between unknown cells has none
    axes.clabel(lines, fmt="%g", fontsize=7, manual=_label_positions(axes, segments))


def _label_positions(axes: Axes, lines: Sequence[Array]) -> list[Array]:
    """Return positions of labels, shape (2,) each: on each line where others are farthest, none if they are near.

    `lines`: contours, shape (n, 2) each, in data units. Distances are measured in widths and heights of the panel.
    """
    axes.autoscale_view()
    to_panel = axes.transScale + axes.transLimits
    lines = [line[:: 1 + len(line) // MAX_CORNERS] for line in lines]
    shares = [to_panel.transform(line) for line in lines]
    chosen: list[Array] = []
    positions: list[Array] = []
    for number, share in enumerate(shares):
        others = np.concatenate([*shares[:number], *shares[number + 1 :], np.full((1, 2), 9.0)])  # 9: far outside
        distance = np.abs(share[:, None] - others).max(axis=2).min(axis=1)
        distance = np.minimum(distance, np.minimum(share, 1 - share).min(axis=1))
        for position in chosen:
            distance = np.where(np.abs(share - position).max(axis=1) < LABEL_DISTANCE, 0.0, distance)
        best = int(distance.argmax())
        if distance[best] > CONTOUR_DISTANCE:
            chosen.append(share[best])
            positions.append(lines[number][best])
    return positions


# Clouds


def draw_scatter(axes: Axes, columns: Columns, x: Scale, y: Scale, norm: Normalize) -> None:
    """Draw each row in the plane of two keys, coloured by its value: doubtful values as rings, missing as crosses."""
    good = ~columns.missing & ~columns.doubtful
    look: Any = {"cmap": colour_map(norm), "norm": norm, "s": 14, "rasterized": len(good) > 5000}
    across, up, doubtful = x.row_positions, y.row_positions, columns.doubtful
    axes.scatter(across[good], up[good], c=columns.value[good], edgecolors="black", linewidths=0.3, **look)
    if doubtful.any():
        ring = axes.scatter(across[doubtful], up[doubtful], c=columns.value[doubtful], linewidths=1.2, **look)
        ring.set_facecolor("none")
    axes.plot(across[columns.missing], up[columns.missing], "x", color="black")
    format_axis(axes, "x", x)
    format_axis(axes, "y", y)
