"""Figure of the three mechanisms: each walker's profile, and its speed by theory and simulation."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from walkergen.files.figures import PAGE, SMALLEST, style
from walkergen.jobs.trust.reproduce.figures import MODELS, THEORY
from walkergen.jobs.trust.reproduce.mechanisms import Mechanism
from walkergen.walker import profiles
from walkergen.walker.design import Design

BODY, LEG = "0.55", "0.25"
SEGMENTS = 16
"""Edges of a round foot."""

RULER_MM = 10.0
"""Length of the scale bar."""


def draw(mechanisms: Sequence[Mechanism]) -> Figure:
    """Draw a panel for each mechanism: its walker from the side above two bars, two errors long."""
    with style():
        figure = Figure(figsize=(PAGE, 3.8), layout="constrained")
        grid = figure.subplots(2, len(mechanisms), height_ratios=(1.0, 2.4), squeeze=False)
        for (above, below), mechanism in zip(grid.T, mechanisms, strict=True):
            _profile(above, mechanism.design)
            above.set_title(f"{mechanism.what}\n({mechanism.name})", fontsize=SMALLEST)
            _bars(below, mechanism)
        grid[1, 0].set_ylabel("mean speed (mm/s)")
        figure.suptitle("Three ways to run, by theory and simulated; bars: 2 SE")
    return figure


def _profile(axes: Axes, design: Design) -> None:
    """Draw a walker of a body in side view, running to the right, its feet with their friction."""
    side = design.body.shape.side
    assert side is not None  # the mechanisms' bodies are rectangles
    axes.add_collection(PolyCollection([side], facecolors=BODY))
    legs = [piece + np.array(limb.anchor) for limb in design.limbs for piece in profiles.limb(limb, SEGMENTS)]
    axes.add_collection(PolyCollection(legs, facecolors=LEG))
    ground = min(limb.foot_height for limb in design.limbs)
    axes.axhline(ground, color="black", linewidth=0.8)
    for limb in design.limbs:
        if limb.friction is not None:
            at = (limb.along, ground - 0.8)
            axes.annotate(f"μ {limb.friction:g}", at, ha="center", va="top", fontsize=SMALLEST)
    axes.annotate("", (18.0, 0.0), (14.5, 0.0), arrowprops={"arrowstyle": "->"})
    axes.plot([-18.0, -18.0 + RULER_MM], [-17.0] * 2, "|-", color="black", linewidth=0.8)
    axes.annotate(f"{RULER_MM:g} mm", (-7.0, -17.0), ha="left", va="center", fontsize=SMALLEST)
    axes.set_xlim(-19.0, 19.0)
    axes.set_ylim(-18.0, 3.0)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _bars(axes: Axes, mechanism: Mechanism) -> None:
    colours = (THEORY["coulomb"][0], MODELS[mechanism.simulated.model][0])
    values = (mechanism.theory, mechanism.simulated.speed)
    for place, (value, colour) in enumerate(zip(values, colours, strict=True)):
        if value is not None:
            axes.bar(place, value.mean, 0.6, color=colour, yerr=2.0 * value.se, capsize=4)
    model = MODELS[mechanism.simulated.model][3].replace(", ", ",\n")
    axes.set_xticks((0, 1), ("theory", model))
    axes.set_xlim(-0.7, 1.7)
    axes.axhline(0.0, color="black", linewidth=0.6)
