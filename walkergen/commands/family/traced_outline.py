"""Picture of the body's outline, traced from a photograph and drawn over it."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from walkergen.core.walker.design import Design
from walkergen.files.figures import style
from walkergen.readers.drawings import outlines, silhouette


def find_picture(design: Design) -> Path | None:
    """Return the picture that a body's outline is traced from; None for other bodies."""
    path = Path(design.body.outline or "")
    return path if outlines.READERS.get(path.suffix.lower()) is silhouette.read_drawing else None


@style()
def draw_outline(path: Path) -> Figure:
    """Draw the outline over its picture. Raises InputError."""
    found = silhouette.trace(path, "body.outline")
    height, width = found.image.shape
    figure = Figure(figsize=(6.0, 0.6 + 6.0 * height / width))
    axes = figure.add_subplot()
    axes.imshow(found.image, cmap="gray", vmin=0.0, vmax=1.0)
    for ring in found.contours:
        axes.plot(*np.vstack([ring, ring[:1]]).T, color="tab:red", linewidth=2.0)
    axes.set_axis_off()
    axes.set_title("; ".join(found.notes), fontsize=9, wrap=True)
    return figure
