"""Figure of measured speeds with the theory fitted to them."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from walkergen.analysis.fits import Speeds
from walkergen.files.figures import STYLES, axes_of
from walkergen.walker.design import Kind

Array = npt.NDArray[np.float64]


def fit_figure(
    tilt: Array,
    legs: Sequence[str],
    speeds: Speeds,
    curves: Mapping[Kind, tuple[Array, Array, Array]],
    title: str,
) -> Figure:
    """Draw speed against tilt: measured with error bars, fitted with a band of one standard error.

    `curves` has tilt, speed over plate speed and its standard error by kind of legs. Where plate
    speeds differ, all speeds are drawn over their own plate speed.
    """
    same = np.ptp(speeds.plate_speed) < 1e-9 * speeds.plate_speed.max()
    unit = np.ones_like(tilt) if same else speeds.plate_speed
    scale = float(speeds.plate_speed[0]) if same else 1.0
    figure, axes = axes_of(title)
    for kind, (fine, speed, error) in curves.items():
        colour, line, marker = STYLES[kind]
        axes.plot(fine, scale * speed, line, color=colour, label=f"fit, {kind} legs")
        band = scale * (speed - error), scale * (speed + error)
        axes.fill_between(fine, *band, color=colour, alpha=0.2, linewidth=0)
        chosen = np.array([one == kind for one in legs])
        bars = None if speeds.se is None else (speeds.se / unit)[chosen]
        axes.errorbar(
            tilt[chosen], (speeds.speed / unit)[chosen], bars, fmt=marker, color=colour,
            markerfacecolor="white", markersize=5, capsize=3, label=f"measured, {kind} legs",
        )  # fmt: skip
    axes.set_xlabel("tilt of the legs (deg)")
    axes.set_ylabel("speed (mm/s)" if same else "speed / plate speed")
    axes.legend(frameon=False)
    return figure
