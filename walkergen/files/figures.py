"""Figures: one style for all, sizes of a journal, and PNG and PDF of equal bytes.

A function that draws a figure is decorated by `style()` and contains only the drawing:

    figure, axes = new_axes(title)  # or new_panels, new_grid: several panels
    draw_points(axes, (lag, speed, se), MEASURED, "measured")  # symbols with bars, or
    draw_curve(axes, (lag, speed, se), SERIES[1], "of turning")  # a line with its error as a band
    axes.plot(lag, fit, color=FITTED.colour, label="fit")
    draw_level(axes, 0.0)  # a thin line at a value to compare with
    label_axes(axes, "lag (s)", "speed (mm/s)", log="x")  # names with units; logarithmic axes
    axes.legend()  # or add_legend_below(figure)

A colour shows a role: blue was measured, orange was fitted or is expected, grey is for comparison.
Series without a role take the looks of SERIES in turn, with different lines and markers too.
"""

import io
import math
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

COLUMN_INCHES, PAGE_INCHES = 86.0 / 25.4, 178.0 / 25.4
"""Widths of a column and of a page of a journal, inches. Figures are drawn in the size in which they are printed."""

MIN_FONT_PT, FONT_PT = 7.0, 8.0
"""Smallest and normal size of letters in a figure, points."""

DPI = 200
"""Pixels per inch of PNG files: a column is about 700 pixels wide, a page 1400. Use the PDF for printing."""

DEFAULT_STYLE: Any = {
    "font.size": FONT_PT,
    "axes.titlesize": FONT_PT,
    "axes.labelsize": FONT_PT,
    "figure.titlesize": FONT_PT,
    "xtick.labelsize": MIN_FONT_PT,
    "ytick.labelsize": MIN_FONT_PT,
    "legend.fontsize": MIN_FONT_PT,
    "legend.title_fontsize": MIN_FONT_PT,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "lines.linewidth": 1.1,
    "lines.markersize": 4.0,
    "hatch.linewidth": 0.6,
    "pdf.fonttype": 42,
}
"""Sizes of letters and lines, in matplotlib's keys; letters of a PDF stay letters (TrueType)."""

BLUE, ORANGE, BLACK, GREEN = "#0072B2", "#D55E00", "#000000", "#009E73"
"""Colours of Okabe and Ito: distinct for the colour-blind, the first two in grey too."""

INK, GREY, FAINT, PALE = "0.3", "0.45", "0.7", "0.9"
"""Greys of words in a panel, of lines of a theory, of levels to compare with, and of areas."""


class Look(NamedTuple):
    """Colour, line and marker of a series."""

    colour: str
    line: Any = "-"
    marker: str = "o"


LEG_STYLES: dict[str, Look] = {"flexible": Look(BLUE, "-", "o"), "braced": Look(ORANGE, "--", "s")}
"""Looks of walkers by their kind of legs."""

MEASURED, FITTED = Look(BLUE, "-", "o"), Look(ORANGE, "--", "s")
"""Looks of measured values, and of values that are fitted to them or expected."""

SERIES: tuple[Look, ...] = (
    Look(BLUE, "-", "o"),
    Look(ORANGE, "--", "s"),
    Look(BLACK, "-.", "^"),
    Look(GREEN, ":", "D"),
    Look("#882255", (0, (7, 2)), "v"),
    Look("#56B4E9", (0, (5, 1, 1, 1, 1, 1)), "P"),
    Look("#B07900", (0, (3, 1, 1, 1)), "X"),
    Look("#7F7F7F", (0, (1, 1)), "*"),
)
"""Looks of series without a role: line and marker distinguish them without colours."""

MAX_LARGE_POINTS = 12
"""Maximum number of points of a series with large symbols and bars with ends."""

BAND_OPACITY = 0.2
"""Opacity of a band of errors."""

LEG_COLOURS = {"flexible": (0.35, 0.58, 0.78), "braced": (0.86, 0.55, 0.30)}
"""Red, green and blue of shaded parts by their kind of legs."""

LETTER_WIDTH_RATIO = 0.52
"""Mean width of a letter over the height of the font."""


@contextmanager
def style(settings: Any = DEFAULT_STYLE) -> Iterator[None]:
    """Draw figures in this context with these settings, without the user's. It is also a decorator."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(settings)
        yield


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """Render the figure as PNG; equal figures give equal bytes."""
    buffer = io.BytesIO()
    with style():  # also for objects that matplotlib makes as late as here, such as ticks
        figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def pdf(figure: Figure) -> bytes:
    """Render the figure as PDF, with its title and without the date; equal figures give equal bytes."""
    buffer = io.BytesIO()
    metadata = {"CreationDate": None, "Title": figure_title(figure)}
    with style():
        figure.savefig(buffer, format="pdf", metadata=metadata)
    return buffer.getvalue()


def figure_title(figure: Figure) -> str:
    """Return the title of a figure, or of its first panel with a title, in one line; "" without any."""
    titles = [figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]
    return " ".join(next((title for title in titles if title), "").split())


def wrap_text(text: str, width: float, size: float = FONT_PT) -> str:
    """Break the text into lines that fit a width (inches) in a font of a size (points)."""
    letters = int(72.0 * width / (LETTER_WIDTH_RATIO * size))
    return textwrap.fill(text, letters, break_on_hyphens=False)


def set_log_ticks(axis: Axis) -> None:
    """Set the ticks of a logarithmic axis, whose limits are set, to plain numbers that do not collide.

    Over less than two decades 1, 2 and 5 have labels, over more only powers of ten.
    """
    low, high = sorted(axis.get_view_interval())
    decades = math.log10(high / low)
    named: tuple[float, ...] = (1.0, 2.0, 5.0) if decades < 2.0 else (1.0,)
    if decades < 0.5:
        named = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=named, numticks=8))
    axis.set_major_formatter(FuncFormatter(_format_power))
    axis.set_minor_formatter(NullFormatter())


def _format_power(value: float, _: float | None = None) -> str:
    """Format a number of a logarithmic axis: plain from 0.001 to 1000, beyond as a power of ten."""
    if 0.999e-3 < value < 1001.0:
        return f"{value:g}"
    power = math.floor(math.log10(value) + 1e-9)
    factor = value / 10.0**power
    front = "" if abs(factor - 1.0) < 1e-6 else rf"{factor:g} \times "
    return rf"${front}10^{{{power}}}$"


def new_axes(title: str) -> tuple[Figure, Axes]:
    """Create an empty figure of the size of a column, with its title."""
    figure, (axes,) = new_panels(title, (2.6,))
    return figure, axes


@style()
def new_panels(title: str, heights: Sequence[float], width: float = COLUMN_INCHES) -> tuple[Figure, list[Axes]]:
    """Create an empty figure of this width, with panels of these heights (inches) that share one x axis."""
    figure = Figure(figsize=(width, sum(heights)), layout="constrained")
    grid = {"height_ratios": heights}
    axes = figure.subplots(len(heights), sharex=True, squeeze=False, gridspec_kw=grid)[:, 0]
    figure.suptitle(wrap_text(title, width - 0.1))
    return figure, list(axes)


@style()
def new_grid(
    title: str, count: int, across: int, height: float, width: float = PAGE_INCHES, share_y: bool = False
) -> tuple[Figure, list[Axes]]:
    """Create an empty figure of `count` panels, `across` of them side by side; `height` of a row, inches."""
    rows = -(-count // across)
    figure = Figure(figsize=(width, rows * height), layout="constrained")
    panels = list(figure.subplots(rows, across, squeeze=False, sharey=share_y).flat)
    for axes in panels[count:]:
        axes.remove()
    figure.suptitle(wrap_text(title, width - 0.1))
    return figure, panels[:count]


def label_axes(axes: Axes, x: str = "", y: str = "", log: str = "") -> None:
    """Name the axes, with units; those in `log` ("x", "y", "xy") are logarithmic.

    Call it last: ticks of logarithmic axes depend on their limits.
    """
    if x:
        axes.set_xlabel(x)
    if y:
        axes.set_ylabel(y)
    if "x" in log:
        axes.set_xscale("log")
        set_log_ticks(axes.xaxis)
    if "y" in log:
        axes.set_yscale("log")
        set_log_ticks(axes.yaxis)


SeriesData = Sequence[Any]
"""Positions, values and errors of points. Errors are None, one a point, or lengths below and above, shape (2, n)."""


def draw_points(
    axes: Axes, data: SeriesData, look: Look = MEASURED, label: str = "", hollow: bool = False, joined: bool = False
) -> Any:
    """Draw symbols with error bars, and a line between them if `joined`. `data`: positions, values, errors."""
    at, value, error = data
    few = len(at) <= MAX_LARGE_POINTS
    return axes.errorbar(
        at,
        value,
        None if error is None else np.nan_to_num(np.asarray(error, dtype=float)),
        fmt=look.marker,
        linestyle=look.line if joined else "none",
        color=look.colour,
        markersize=(5.0 if hollow else 4.0) if few else 3.0,
        capsize=2.0 if few else 0.0,
        markerfacecolor="white" if hollow else look.colour,
        linewidth=0.9,
        elinewidth=0.8,
        label=label or None,
        zorder=3 if hollow else 2.2,
    )


def draw_curve(axes: Axes, data: SeriesData, look: Look = FITTED, label: str = "", shade: float = BAND_OPACITY) -> None:
    """Draw a line and a band of its errors with opacity `shade`; `data`: positions, values and errors."""
    at, value, error = (np.asarray(part, dtype=float) for part in data)
    axes.plot(at, value, color=look.colour, linestyle=look.line, label=label or None)
    axes.fill_between(at, value - error, value + error, color=look.colour, alpha=shade, linewidth=0)


def draw_level(axes: Axes, value: float = 0.0, upright: bool = False) -> None:
    """Draw a thin line at a value to compare with, behind everything; vertical if `upright`."""
    draw = axes.axvline if upright else axes.axhline
    draw(value, color=FAINT, linewidth=0.7, zorder=0)


def add_legend_below(figure: Figure, columns: int = 2) -> None:
    """Draw one legend for all panels, below them, with the labels of the first panel."""
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=columns)


def show_in_notebook(figure: Figure) -> Figure:
    """Return the figure, changed so that a notebook shows it although pyplot did not make it."""
    vars(figure)["_repr_png_"] = partial(png, figure)
    return figure
