"""Figures of a sweep: lines for one key, a map for two, small multiples for three, or clouds.

A point's number is its value of the shown quantity, usually the speed. Every figure can be read without colours, and
marks points without a number.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from walkergen.core import Mask
from walkergen.files.figures import COLUMN_INCHES, PAGE_INCHES, style, wrap_text
from walkergen.files.key_names import format_key
from walkergen.guests.sweep import panels as draw
from walkergen.guests.sweep.panels import DOUBTFUL_STYLE, LINE_STYLES, MISSING_STYLE
from walkergen.guests.sweep.panels import Columns as Columns
from walkergen.guests.sweep.scales import Scale, format_axis, format_value, make_scale

MAX_LINES, MAX_PANELS = 5, 12
"""Largest number of lines in a panel, and of panels in a figure: one for each value of a key."""

MIN_GRID_SHARE = 0.5
"""Points lie on a grid if they are more than this share of all combinations of the values."""

STYLE_CHANGES: Any = {"lines.markersize": 3.5, "errorbar.capsize": 1.5}
"""Style changes for many points."""


def draw_figure(columns: Columns, keys: Sequence[str], title: str) -> Figure:
    """Draw the shown quantity of all points against the keys that vary, as lines, a map, small multiples or clouds.

    At least one key must have two values. At least one point must have a value of the quantity.
    """
    scales = [make_scale(key, columns.keys[key]) for key in keys]
    scales = [scale for scale in scales if len(scale.values) > 1]
    combinations = math.prod(len(scale.values) for scale in scales)
    gridded = MIN_GRID_SHARE * combinations < len(columns.value) and len(scales) <= 3
    with style(), matplotlib.rc_context(STYLE_CHANGES):
        if not gridded:
            return _draw_clouds(columns, scales, title)
        if len(scales) < 3:
            return _draw_single(columns, scales, _rank_scales(scales), title)
        return _draw_multiples(columns, scales, title)


def _draw_single(columns: Columns, scales: Sequence[Scale], ranked: Sequence[Scale], title: str) -> Figure:
    """Draw one panel with lines or a map, for one or two keys. `ranked`: the same scales, that of the x axis first."""
    with _make_sheet(title, 1) as (figure, (axes,), _):
        rows = np.ones(len(columns.value), dtype=bool)
        if _has_lines(scales):
            draw.draw_lines(axes, columns, ranked[0], ranked[1] if ranked[1:] else None, rows)
            axes.set_ylabel(draw.value_label(columns))
            _draw_legend(figure, _line_handles(columns, ranked[1:]), ranked[1:])
        else:
            norm = draw.make_norm(columns.value)
            draw.draw_map(axes, columns, scales[0], scales[1], rows, norm)
            _draw_colour_bar(figure, [axes], norm, columns)
            _draw_legend(figure, _mark_handles(columns, hatched=True))
    return figure


def _rank_scales(scales: Sequence[Scale]) -> list[Scale]:
    """Return one or two scales, that of the x axis first: numbers, the most values, as far as the others are lines."""
    ranked = sorted(scales, key=lambda scale: (scale.has_words, -len(scale.values)))
    return ranked if all(len(scale.values) <= MAX_LINES for scale in ranked[1:]) else ranked[::-1]


def _has_lines(scales: Sequence[Scale]) -> bool:
    """Return whether one or two keys are drawn as lines. Two keys with more than MAX_LINES values make a map."""
    return len(scales) == 1 or min(len(scale.values) for scale in scales) <= MAX_LINES


def _draw_multiples(columns: Columns, scales: Sequence[Scale], title: str) -> Figure:
    """Draw three keys: a panel of lines, or a map, for each value of the key with the fewest values."""
    panel_scale = min(scales, key=lambda scale: len(scale.values))
    others = [scale for scale in scales if scale is not panel_scale]
    shown = _spread_numbers(len(panel_scale.values), MAX_PANELS)
    if left := len(panel_scale.values) - len(shown):
        title += f"; {left} of {len(panel_scale.values)} values of {panel_scale.key} left out"
    inside = np.isin(panel_scale.indices, shown)
    columns, panel_scale, *others = _select_rows(columns, inside, (panel_scale, *others))
    ranked = _rank_scales(others)
    with _make_sheet(title, len(shown)) as (figure, panels, in_row):
        norm = draw.make_norm(columns.value)
        for index, (number, axes) in enumerate(zip(shown, panels, strict=True)):
            rows = panel_scale.indices == number
            if _has_lines(others):
                draw.draw_lines(axes, columns, ranked[0], ranked[1], rows)
            else:
                draw.draw_map(axes, columns, others[0], others[1], rows, norm)
            axes.set_title(format_value(panel_scale, number))
            if index + in_row < len(panels):
                axes.xaxis.label.set_visible(False)
            if index % in_row:
                axes.yaxis.label.set_visible(False)
            elif _has_lines(others):
                axes.set_ylabel(draw.value_label(columns))
        if _has_lines(others):
            _draw_legend(figure, _line_handles(columns, ranked[1:]), ranked[1:])
        else:
            _draw_colour_bar(figure, panels, norm, columns)
            _draw_legend(figure, _mark_handles(columns, hatched=True))
    return figure


def _draw_clouds(columns: Columns, scales: Sequence[Scale], title: str) -> Figure:
    """Draw points that form no grid: two keys in a plane with the quantity as colour, others with a panel a key."""
    if len(scales) == 2:
        with _make_sheet(title, 1) as (figure, (axes,), _):
            norm = draw.make_norm(columns.value)
            draw.draw_scatter(axes, columns, scales[0], scales[1], norm)
            _draw_colour_bar(figure, [axes], norm, columns)
            _draw_legend(figure, _mark_handles(columns))
        return figure
    if left := len(scales) - MAX_PANELS:
        scales = scales[:MAX_PANELS]
        title += f"; {left} keys left out" if left > 0 else ""
    all_rows = np.ones(len(columns.value), dtype=bool)
    with _make_sheet(title, len(scales)) as (figure, panels, in_row):
        for index, (axes, scale) in enumerate(zip(panels, scales, strict=True)):
            draw.draw_dots(axes, columns, scale, all_rows, LINE_STYLES[0], joined=False)
            format_axis(axes, "x", scale)
            if index % in_row == 0:
                axes.set_ylabel(draw.value_label(columns, draw.MAX_CLOUD_BARS))
        _draw_legend(figure, _mark_handles(columns))
    return figure


def _spread_numbers(count: int, max_count: int) -> list[int]:
    """Return at most `max_count` evenly spread integers from 0 to count - 1, both included."""
    if count <= max_count:
        return list(range(count))
    return [round(index * (count - 1) / (max_count - 1)) for index in range(max_count)]


def _select_rows(columns: Columns, rows: Mask, scales: Sequence[Scale]) -> tuple[Any, ...]:
    """Return the columns, then each scale, reduced to the points where `rows` is True. The columns have no keys."""
    status = [status for status, inside in zip(columns.status, rows, strict=True) if inside]
    kept = Columns({}, columns.value[rows], columns.low[rows], columns.high[rows], status, columns.label)
    return (kept, *(scale._replace(indices=scale.indices[rows]) for scale in scales))


# Sheets, legends and colour bars


@contextmanager
def _make_sheet(title: str, count: int) -> Iterator[tuple[Figure, list[Axes], int]]:
    """Yield an empty figure with a title, its `count` panels, and the number of panels in a row.

    It is as wide as a column for one or two panels in a row, and as a page for more.
    """
    in_row = 1 if count == 1 else 2 if count in (2, 4) else 3 if count <= 6 else 4
    width = COLUMN_INCHES if in_row < 3 else PAGE_INCHES
    rows = -(-count // in_row)  # rounded up
    panel_height = 2.4 if count == 1 else 1.75
    figure = Figure(figsize=(width, rows * panel_height + 0.3), layout="constrained", dpi=300)
    grid = figure.subplots(rows, in_row, squeeze=False, sharey=count > 1)
    panels = list(grid.flat)
    for axes in panels[count:]:
        axes.remove()
    figure.suptitle(wrap_text(title, width - 0.1))
    yield figure, panels[:count], in_row


def _draw_colour_bar(figure: Figure, panels: Sequence[Axes], norm: Normalize, columns: Columns) -> None:
    """Draw one colour bar for all panels, limited to the range of the shown values."""
    mapped = matplotlib.cm.ScalarMappable(norm, draw.colour_map(norm))
    bar = figure.colorbar(mapped, ax=list(panels), label=columns.label, pad=0.02, aspect=25)
    if np.ptp(shown := columns.value[~columns.missing]):
        bar.ax.set_ylim(shown.min(), shown.max())


def _line_handles(columns: Columns, scales: Sequence[Scale]) -> list[Any]:
    """Return the legend entries for the lines, one for each value of these scales, and for points with problems."""
    handles: list[Any] = []
    for scale in scales:
        for number, (colour, dash, marker) in zip(range(len(scale.values)), LINE_STYLES, strict=False):
            label = format_value(scale, number, named=False)
            if columns.missing[scale.indices == number].all():
                label += f": no {columns.label.partition(' (')[0]}"
            handles.append(Line2D([], [], color=colour, linestyle=dash, marker=marker, label=label))
    return handles + _mark_handles(columns)


def _mark_handles(columns: Columns, hatched: bool = False) -> list[Any]:
    """Return the legend entries for points without a number (hatched cells or crosses), and for doubtful points."""
    name = columns.label.partition(" (")[0]
    missing, doubtful = int(columns.missing.sum()), int(columns.doubtful.sum())
    handles: list[Any] = []
    if missing:
        label = f"no {name}: {missing} of {len(columns.value)}"
        handles.append(
            Patch(**MISSING_STYLE, label=label)
            if hatched
            else Line2D([], [], color="black", linestyle="none", marker="x", label=label)
        )
    if doubtful:
        handles.append(Line2D([], [], label=f"not ok: {doubtful}, see status", **DOUBTFUL_STYLE))
    return handles


def _draw_legend(figure: Figure, handles: Sequence[Any], lines: Sequence[Scale] = ()) -> None:
    """Add a legend below the panels, as wide as fits, and make the figure taller. `lines`: scale of the lines."""
    title = format_key(lines[0].key).partition(" (")[0] if lines else None
    looks: Any = {"loc": "outside lower center", "frameon": False, "handlelength": 2.8, "title": title}
    for entries in range(len(handles), 0, -1):
        legend = figure.legend(handles=list(handles), ncols=entries, **looks)
        inches = legend.get_window_extent().width / figure.dpi
        if inches <= figure.get_figwidth() - 0.1 or entries == 1:
            rows = -(-len(handles) // entries) + bool(title)
            figure.set_figheight(figure.get_figheight() + 0.16 * rows)  # inches a row
            return
        legend.remove()
