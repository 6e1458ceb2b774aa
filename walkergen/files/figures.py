"""Figures: as PNG and PDF of equal bytes, and the colours by which kinds of legs are known."""

import io
from collections.abc import Sequence

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Dark blue and orange of Okabe and Ito: told apart by the colour-blind and in grey.
STYLES: dict[str, tuple[str, str, str]] = {
    "flexible": ("#0072B2", "-", "o"),
    "braced": ("#D55E00", "--", "s"),
}

COLOURS = {"flexible": (0.35, 0.58, 0.78), "braced": (0.86, 0.55, 0.30)}
"""Red, green and blue of shaded parts by their kind of legs."""


def png(figure: Figure, dpi: int = 150) -> bytes:
    """The figure as PNG: equal figures give equal bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def pdf(figure: Figure) -> bytes:
    """The figure as PDF, without the date: equal figures give equal bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="pdf", metadata={"CreationDate": None})
    return buffer.getvalue()


def axes_of(title: str) -> tuple[Figure, Axes]:
    """An empty figure of the size of a column, with its title."""
    figure, (axes,) = panels_of(title, (4.2,))
    return figure, axes


def panels_of(title: str, heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """An empty figure as wide as a column, with panels of these heights (inches) and one x axis."""
    with matplotlib.rc_context({"axes.spines.top": False, "axes.spines.right": False}):
        figure = Figure(figsize=(5.6, sum(heights)), layout="constrained")
        grid = {"height_ratios": heights}
        axes = figure.subplots(len(heights), sharex=True, squeeze=False, gridspec_kw=grid)[:, 0]
    axes[0].set_title(title, fontsize=10)
    return figure, list(axes)
