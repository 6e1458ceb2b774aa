"""Picture of a body without space for legs, with the missing space in red and the span that legs would need."""

import numpy as np
from matplotlib.figure import Figure

from walkergen.files.figures import style
from walkergen.readers.walkers import leg_placement
from walkergen.readers.walkers.leg_placement import UnplacedError

FAULT_COLOUR = "tab:red"


@style()
def draw_unsupported_body(error: UnplacedError) -> Figure:
    """Draw a body from above. Raises GeometryError for a body without a shape."""
    import shapely

    space = leg_placement.available_space(error.body, error.legs)
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    axes = figure.add_subplot()
    for part, colour in ((space.ground, FAULT_COLOUR), (space.free, "0.75")):
        for polygon in shapely.get_parts(part):
            for ring, ring_colour in ((polygon.exterior, colour), *((hole, "white") for hole in polygon.interiors)):
                axes.fill(*np.asarray(ring.coords).T, color=ring_colour)
    angles = np.linspace(0.0, 2.0 * np.pi, 91)
    circle = np.array(space.centre)[:, None] + space.radius * np.stack([np.cos(angles), np.sin(angles)])
    axes.plot(*circle, "--", color=FAULT_COLOUR, label="feet must surround this circle, or the body tips over")
    axes.plot(*space.centre, "+", color="black", label="centre of mass, from above")
    axes.set_aspect("equal")
    axes.set_xlabel("along the run, mm, forward to the right")
    axes.set_title("this body has no space for legs: red areas are missing")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    return figure
