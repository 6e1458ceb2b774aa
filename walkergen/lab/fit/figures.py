"""Figures of measured speeds with the theory fitted to them, or with what a model makes of them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from walkergen.analysis.fits import Speeds
from walkergen.analysis.speeds import Measured
from walkergen.files.figures import STYLES, axes_of, style
from walkergen.walker.limbs import Kind

if TYPE_CHECKING:
    from walkergen.lab.fit.learn import Band

Array = npt.NDArray[np.float64]


@style()
def fit_figure(
    tilt: Array, legs: Sequence[str], speeds: Speeds, curves: Mapping[Kind, tuple[Array, Array, Array]], title: str
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
        chosen = np.array([own == kind for own in legs])
        bars = None if speeds.se is None else (speeds.se / unit)[chosen]
        axes.errorbar(
            tilt[chosen],
            (speeds.speed / unit)[chosen],
            bars,
            fmt=marker,
            color=colour,
            markerfacecolor="white",
            markersize=5,
            capsize=3,
            label=f"measured, {kind} legs",
        )
    axes.set_xlabel("tilt of the legs (deg)")
    axes.set_ylabel("speed (mm/s)" if same else "speed / plate speed")
    axes.legend()
    return figure


@style()
def bands_figure(bands: "Sequence[Band]", seen: Measured, title: str) -> Figure:
    """Draw speeds against tilt on the plate that is predicted: measured, and bands of one more.

    Bands are computed at the dots alone; between them they are joined by straight lines.
    """
    plates = [band.plate_speed_mm_s for band in bands if not band.measured]
    plate = plates[0] if plates else bands[0].plate_speed_mm_s
    chosen = [band for band in bands if band.plate_speed_mm_s == plate]
    tilt = np.array([band.tilt_deg for band in chosen])
    figure, axes = axes_of(title)
    colour, line, marker = STYLES["flexible"]
    for level, shade in ((95, 0.15), (90, 0.28), (68, 0.5)):
        low, high = (np.array([getattr(band, f"{end}_{level}") for band in chosen]) for end in ("low", "high"))
        paler = 1.0 - shade * (1.0 - np.array(to_rgb(colour)))
        axes.fill_between(tilt, low, high, color=paler, linewidth=0, label=f"one more print, {level} %")
    middle = np.array([band.speed_mm_s for band in chosen])
    axes.plot(tilt, middle, line, color=colour, linewidth=1)
    axes.plot(tilt, middle, ".", color=colour, label="median")
    shown = seen.plate_speed == plate
    bars = None if seen.se is None else seen.se[shown]
    axes.errorbar(
        seen.tilt[shown],
        seen.speed[shown],
        bars,
        fmt=marker,
        color="black",
        markerfacecolor="white",
        markersize=5,
        capsize=3,
        label="measured",
        zorder=3,
    )
    axes.set_xlabel("tilt of the legs (deg)")
    axes.set_ylabel(f"speed (mm/s) on a plate of {plate:.1f} mm/s")
    axes.legend()
    return figure
