"""Figure of a calibration: Young's modulus by strip and method, and the common value."""

import numpy as np
from matplotlib.figure import Figure

from walkergen.files.figures import INK, LEG_STYLES, MIN_FONT_PT, draw_points, label_axes, new_axes, style
from walkergen.guests.lab.calibrate.modulus import Moduli
from walkergen.guests.lab.calibrate.specimens import BEND_METHOD, RING_METHOD

METHOD_LOOKS = {
    BEND_METHOD: (LEG_STYLES["flexible"], False, -1.0, "under weights"),
    RING_METHOD: (LEG_STYLES["braced"], True, 1.0, "by its ring"),
}
"""Look of each method's points, whether they are hollow, the side of their offset, and their label."""

FIT_LABELS = {"both": "all", BEND_METHOD: "all weights", RING_METHOD: "all rings"}
"""Labels of the data behind the fitted line."""

HEADROOM = 0.3
"""Height of the space for the legend above the points, over the height of the points."""

METHOD_OFFSET = 0.008
"""Offset of each method's points from the strip's thickness, over the largest thickness: bars do not overlap."""


@style()
def draw_strips(moduli: Moduli, title: str) -> Figure:
    """Draw the modulus by each strip and method against thickness, and the fitted modulus."""
    figure, axes = new_axes(title)
    fit = moduli.fit
    modulus, sd = fit.number.pair
    axes.axhspan(modulus - sd, modulus + sd, color="0.85", linewidth=0)
    quality = "" if fit.probability is None else f", chi² {fit.chi2:.1f} for {fit.dof}"
    axes.axhline(
        modulus, color="0.35", linewidth=0.9, label=f"{FIT_LABELS[moduli.by]}: {modulus:.2f} ± {sd:.2f} GPa{quality}"
    )
    thicknesses = {point.strip: point.thickness.pair[0] for point in moduli.points}
    step = METHOD_OFFSET * max(thicknesses.values())
    for method, (look, hollow, side, label) in METHOD_LOOKS.items():
        points = [point for point in moduli.points if point.method == method]
        if points:
            x = np.array([thicknesses[point.strip] for point in points]) + side * step
            values, errors = np.array([point.modulus.pair for point in points]).T
            draw_points(axes, (x, values, errors), look, label, hollow)
    for strip, thickness in thicknesses.items():
        axes.annotate(
            strip.replace("_", " "),
            (thickness, 0.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=MIN_FONT_PT,
            color=INK,
        )
    axes.set_xlim(left=0.0)
    axes.margins(y=0.15)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + HEADROOM * (high - low))
    label_axes(axes, "measured thickness of the strip (mm)", "Young's modulus (GPa)")
    axes.legend(loc="upper left", framealpha=0.9, edgecolor="none")
    return figure
