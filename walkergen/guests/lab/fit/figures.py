"""Figures of measured speeds with the fitted theory, or with a model's prediction."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from walkergen.analysis.speeds import Measured
from walkergen.core.numerics import Array
from walkergen.core.walker.limbs import Kind
from walkergen.files.figures import BLACK, LEG_STYLES, Look, draw_curve, draw_points, label_axes, new_axes, style

if TYPE_CHECKING:
    from walkergen.guests.lab.fit.model_fit import Band


@style()
def draw_fit(seen: Measured, curves: Mapping[Kind, tuple[Array, Array, Array]], title: str) -> Figure:
    """Draw speed against tilt: measured with error bars, fitted with a band of one standard error.

    `curves` has, by kind of legs, arrays of tilt, speed over plate speed and standard error of the latter. Where plate
    speeds differ, all speeds are divided by their own plate speed.
    """
    plate = seen.plate_speed
    same = np.ptp(plate) < 1e-9 * plate.max()
    unit, scale = (1.0, float(plate[0])) if same else (plate, 1.0)
    figure, axes = new_axes(title)
    speeds, errors = seen.speed / unit, None if seen.se is None else seen.se / unit
    for kind, (fine, speed, error) in curves.items():
        draw_curve(axes, (fine, scale * speed, scale * error), LEG_STYLES[kind], f"fit, {kind} legs")
        shown = np.array([legs == kind for legs in seen.legs])
        data = (seen.tilt[shown], speeds[shown], None if errors is None else errors[shown])
        draw_points(axes, data, LEG_STYLES[kind], f"measured, {kind} legs", hollow=True)
    label_axes(axes, "tilt of the legs (deg)", "speed (mm/s)" if same else "speed / plate speed")
    axes.legend()
    return figure


@style()
def draw_bands(bands: "Sequence[Band]", seen: Measured, title: str) -> Figure:
    """Draw speeds against tilt at one plate speed: measured speeds, and predicted bands for one more printed walker.

    The plate speed is that of the settings that were not measured. Bands are interpolated between the dots.
    """
    plate = next((band for band in bands if not band.measured), bands[0]).plate_speed_mm_s
    chosen = [band for band in bands if band.plate_speed_mm_s == plate]
    tilt = [band.tilt_deg for band in chosen]
    figure, axes = new_axes(title)
    colour, line, _ = LEG_STYLES["flexible"]
    for level, shade in ((95, 0.15), (90, 0.28), (68, 0.5)):
        low, high = ([getattr(band, f"{end}_{level}") for band in chosen] for end in ("low", "high"))
        paler = 1.0 - shade * (1.0 - np.array(to_rgb(colour)))
        axes.fill_between(tilt, low, high, color=paler, linewidth=0, label=f"one more print, {level} %")
    axes.plot(tilt, [band.speed_mm_s for band in chosen], line, marker=".", color=colour, label="median")
    shown = seen.plate_speed == plate
    bars = None if seen.se is None else seen.se[shown]
    draw_points(axes, (seen.tilt[shown], seen.speed[shown], bars), Look(BLACK), "measured", hollow=True)
    label_axes(axes, "tilt of the legs (deg)", f"speed (mm/s) on a plate of {plate:.1f} mm/s")
    axes.legend()
    return figure
