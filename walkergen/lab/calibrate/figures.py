"""Figure of a calibration: Young's modulus by strip and method, and what all agree on."""

import numpy as np
from matplotlib.figure import Figure

from walkergen.files.figures import STYLES, axes_of
from walkergen.lab.calibrate.result import Bent
from walkergen.lab.calibrate.specimens import BENDS, RINGS

LOOKS = {
    BENDS: (STYLES["flexible"][0], "o", "full", -1.0, "under weights"),
    RINGS: (STYLES["braced"][0], "s", "none", 1.0, "by its ring"),
}
"""Colour, marker, filling, side and words of each method."""

NAMES = {"both": "all", BENDS: "all weights", RINGS: "all rings"}
"""Words for what the line is fitted to."""

HEADROOM = 0.3
"""Height that is left to the words above the points, over theirs."""

APART = 0.008
"""Distance of the two methods from their strip's thickness, over the largest, so that bars show."""


def of_strips(bent: Bent, title: str) -> Figure:
    """Draw the modulus against thickness: creep parts the methods, a wrong caliper the strips."""
    figure, axes = axes_of(title)
    fit = bent.fit
    axes.axhspan(fit.modulus - fit.sd, fit.modulus + fit.sd, color="0.85", linewidth=0)
    quality = "" if fit.probability is None else f", chi² {fit.chi2:.1f} for {fit.dof}"
    label = f"{NAMES[bent.by]}: {fit.modulus:.2f} ± {fit.sd:.2f} GPa{quality}"
    axes.axhline(fit.modulus, color="0.35", linewidth=0.9, label=label)
    step = APART * max(point.thickness for point in bent.points)
    for method, (colour, marker, filled, side, words) in LOOKS.items():
        own = [point for point in bent.points if point.method == method]
        if own:
            at = np.array([point.thickness for point in own]) + side * step
            axes.errorbar(
                at,
                [point.modulus for point in own],
                [point.sd for point in own],
                fmt=marker,
                color=colour,
                fillstyle="full" if filled == "full" else "none",
                markersize=6,
                capsize=3,
                label=words,
            )
    for point in {point.strip: point for point in bent.points}.values():
        axes.annotate(
            point.strip.replace("_", " "),
            (point.thickness, 0.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
            color="0.3",
        )
    axes.set_xlim(left=0.0)
    axes.margins(y=0.15)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + HEADROOM * (high - low))
    axes.set_xlabel("measured thickness of the strip (mm)")
    axes.set_ylabel("Young's modulus (GPa)")
    axes.legend(fontsize=8, loc="upper left", framealpha=0.9, edgecolor="none")
    return figure
