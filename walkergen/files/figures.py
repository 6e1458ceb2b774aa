"""Figures: one style for all, sizes of a journal, and PNG and PDF of equal bytes."""

import io
import math
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

COLUMN, PAGE = 86.0 / 25.4, 178.0 / 25.4
"""Widths of a journal's column and of its page, inches: figures are drawn at the size of print."""

SMALLEST, NORMAL = 7.0, 8.0
"""Sizes of fonts, points; nothing in a figure is smaller than the first."""

DPI = 200
"""Pixels per inch: a column is some 700 pixels wide, a page 1400; print takes the PDF."""

STYLE: Any = {
    "font.size": NORMAL,
    "axes.titlesize": NORMAL,
    "axes.labelsize": NORMAL,
    "figure.titlesize": NORMAL,
    "xtick.labelsize": SMALLEST,
    "ytick.labelsize": SMALLEST,
    "legend.fontsize": SMALLEST,
    "legend.title_fontsize": SMALLEST,
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

# Dark blue and orange of Okabe and Ito: told apart by the colour-blind and in grey.
STYLES: dict[str, tuple[str, str, str]] = {"flexible": ("#0072B2", "-", "o"), "braced": ("#D55E00", "--", "s")}

SERIES: tuple[tuple[str, Any, str], ...] = (
    ("#0072B2", "-", "o"),
    ("#D55E00", "--", "s"),
    ("#000000", "-.", "^"),
    ("#009E73", ":", "D"),
    ("#882255", (0, (7, 2)), "v"),
    ("#56B4E9", (0, (5, 1, 1, 1, 1, 1)), "P"),
    ("#B07900", (0, (3, 1, 1, 1)), "X"),
    ("#7F7F7F", (0, (1, 1)), "*"),
)
"""Colour, line and marker of series: the last two tell them apart where colours are lost."""

COLOURS = {"flexible": (0.35, 0.58, 0.78), "braced": (0.86, 0.55, 0.30)}
"""Red, green and blue of shaded parts by their kind of legs."""

POINTS_A_LETTER = 0.52
"""Mean width of a letter over the height of the font."""


@contextmanager
def style(settings: Any = STYLE) -> Iterator[None]:
    """Context in which figures are drawn; also a decorator of functions that draw them.

    No settings of a person, as in a matplotlibrc of the current folder, come into them.
    """
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(settings)
        yield


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """The figure as PNG: equal figures give equal bytes."""
    buffer = io.BytesIO()
    with style():  # also of what matplotlib makes as late as here, as ticks
        figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def pdf(figure: Figure) -> bytes:
    """The figure as PDF, with its title and without the date: equal figures give equal bytes."""
    buffer = io.BytesIO()
    metadata = {"CreationDate": None, "Title": words(figure)}
    with style():
        figure.savefig(buffer, format="pdf", metadata=metadata)
    return buffer.getvalue()


def words(figure: Figure) -> str:
    """Title of a figure, or of its first panel that has one, in one line; "" without any."""
    titles = [figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]
    return " ".join(next((title for title in titles if title), "").split())


def wrapped(text: str, width: float, size: float = NORMAL) -> str:
    """Text in lines that fit a width (inches) in a font of a size (points)."""
    letters = int(72.0 * width / (POINTS_A_LETTER * size))
    return textwrap.fill(text, letters, break_on_hyphens=False)


def logarithmic(axis: Axis) -> None:
    """Ticks of a logarithmic axis, set once its limits are: plain numbers that do not collide.

    Over less than two decades 1, 2 and 5 are named, over more the powers of ten alone.
    """
    low, high = sorted(axis.get_view_interval())
    decades = math.log10(high / low)
    named: tuple[float, ...] = (1.0, 2.0, 5.0) if decades < 2.0 else (1.0,)
    if decades < 0.5:
        named = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=named, numticks=8))
    axis.set_major_formatter(FuncFormatter(_power))
    axis.set_minor_formatter(NullFormatter())


def _power(value: float, _: float | None = None) -> str:
    """Number of a logarithmic axis: plain from 0.001 to 1000, beyond as a power of ten."""
    if 0.999e-3 < value < 1001.0:
        return f"{value:g}"
    power = math.floor(math.log10(value) + 1e-9)
    factor = value / 10.0**power
    front = "" if abs(factor - 1.0) < 1e-6 else rf"{factor:g} \times "
    return rf"${front}10^{{{power}}}$"


def axes_of(title: str) -> tuple[Figure, Axes]:
    """An empty figure of the size of a column, with its title."""
    figure, (axes,) = panels_of(title, (2.6,))
    return figure, axes


@style()
def panels_of(title: str, heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """An empty figure as wide as a column, with panels of these heights (inches) and one x axis."""
    figure = Figure(figsize=(COLUMN, sum(heights)), layout="constrained")
    grid = {"height_ratios": heights}
    axes = figure.subplots(len(heights), sharex=True, squeeze=False, gridspec_kw=grid)[:, 0]
    figure.suptitle(wrapped(title, COLUMN - 0.1))
    return figure, list(axes)


def shown(figure: Figure) -> Figure:
    """Figure that a notebook shows as a picture, though pyplot did not make it."""
    vars(figure)["_repr_png_"] = partial(png, figure)
    return figure
