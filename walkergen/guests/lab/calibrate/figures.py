"""Figure of a calibration: Young's modulus by strip and method, and what all agree on."""

import numpy as np
from matplotlib.figure import Figure

from walkergen.files.figures import INK, SMALLEST, STYLES, axes_of, name, points, style
from walkergen.guests.lab.calibrate.modulus import Bent
from walkergen.guests.lab.calibrate.specimens import BENDS, RINGS

LOOKS = {BENDS: (STYLES["flexible"], False, -1.0, "under weights"), RINGS: (STYLES["braced"], True, 1.0, "by its ring")}
"""Look, whether it is hollow, side and words of each method."""

NAMES = {"both": "all", BENDS: "all weights", RINGS: "all rings"}
"""Words for what the line is fitted to."""

HEADROOM = 0.3
"""Height that is left to the words above the points, over theirs."""

APART = 0.008
"""Distance of the two methods from their strip's thickness, over the largest, so that bars show."""


@style()
def of_strips(bent: Bent, title: str) -> Figure:
    """Draw the modulus against thickness: creep parts the methods, a wrong caliper the strips."""
    figure, axes = axes_of(title)
    fit = bent.fit
    modulus, sd = fit.number.pair
    axes.axhspan(modulus - sd, modulus + sd, color="0.85", linewidth=0)
    quality = "" if fit.probability is None else f", chi² {fit.chi2:.1f} for {fit.dof}"
    axes.axhline(modulus, color="0.35", linewidth=0.9, label=f"{NAMES[bent.by]}: {modulus:.2f} ± {sd:.2f} GPa{quality}")
    thicknesses = {point.strip: point.thickness.pair[0] for point in bent.points}
    step = APART * max(thicknesses.values())
    for method, (look, hollow, side, words) in LOOKS.items():
        own = [point for point in bent.points if point.method == method]
        if own:
            at = np.array([thicknesses[point.strip] for point in own]) + side * step
            values, errors = np.array([point.modulus.pair for point in own]).T
            points(axes, (at, values, errors), look, words, hollow)
    for strip, thickness in thicknesses.items():
        axes.annotate(
            strip.replace("_", " "),
            (thickness, 0.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=SMALLEST,
            color=INK,
        )
    axes.set_xlim(left=0.0)
    axes.margins(y=0.15)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + HEADROOM * (high - low))
    name(axes, "measured thickness of the strip (mm)", "Young's modulus (GPa)")
    axes.legend(loc="upper left", framealpha=0.9, edgecolor="none")
    return figure
