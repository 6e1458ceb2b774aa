"""Figures: as PNG and PDF of equal bytes, and the colours by which kinds of legs are known."""

import io

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
    with matplotlib.rc_context({"axes.spines.top": False, "axes.spines.right": False}):
        figure = Figure(figsize=(5.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
    axes.set_title(title, fontsize=10)
    return figure, axes
