"""Figures that a notebook shows without any set-up of matplotlib."""

from functools import partial

from matplotlib.figure import Figure

from walkergen.files.figures import png


def shown(figure: Figure) -> Figure:
    """Figure that a notebook shows as a picture, though pyplot did not make it."""
    vars(figure)["_repr_png_"] = partial(png, figure)
    return figure
