"""Tables of measured motion: console, Markdown, CSV, JSON."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

from walkergen.analysis.estimates import (
    HEADINGS_KNOWN,
    IN_A_LANE,
    UNITS,
    Estimate,
    bounds_95,
    with_error,
)
from walkergen.analysis.motion import Array, Motion
from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text

SHOWN = {"mm_s": "mm/s", "mm2_s": "mm²/s", "per_s": "1/s", "rad_s": "rad/s", "rad2_s": "rad²/s"}
"""Units as they are printed where they are not part of a key."""


MOST_WALKERS = 24
"""Largest number of walkers in a table that is printed."""

OF_WALKERS = ("speed", "turning_bias")
"""Estimates of each walker by itself, by the names of UNITS."""


def scale_se(value: float | None, unit: str, motion: Motion) -> float | None:
    """Error of a value by the scale of the film, which all lengths share; 0 without a length.

    To first order: a length to a power is off by so many times the scale's share. None when value
    or scale's error is not known.
    """
    power = 2 if unit.startswith("mm2") else 1 if unit.startswith("mm") else 0
    if value is None or (power and motion.scale_se is None):
        return None
    return abs(value) * power * (motion.scale_se or 0.0)


def scale_errors(motion: Motion) -> Array:
    """Errors of the mean squared displacement by the scale, mm^2; NaN when it is not known."""
    share = math.nan if motion.scale_se is None else motion.scale_se
    return np.asarray(2.0 * share * np.abs(motion.msd.value))


def scale_told(motion: Motion) -> str:
    """What the scale means for the numbers; '' where it is exact, as in a simulation."""
    share = motion.scale_se
    if share is None:
        return (
            "the scale's error is not known and in no number: give the scale with its error, as "
            "--mm-per-px 0.05+-0.001"
        )
    if not share:
        return ""
    return (
        f"the scale is off by {words.number(100.0 * share, 2)} % (standard error): all lengths and "
        "speeds together, so that more walkers or time do not help; squares of them by twice that"
    )


def _in_words(one: Estimate, unit: str, motion: Motion) -> str:
    """Value with its error and, where the scale has one, that of the scale beside it."""
    scale = scale_se(one.value, unit, motion)
    return with_error(one) + (f" ± {words.number(scale, 2)} (scale)" if scale else "")


def rows(motion: Motion) -> Iterator[tuple[str, str, str, str]]:
    """Name, unit, value and bounds in words of every estimate that tracks of this kind can have."""
    for name, unit in UNITS.items():
        one = motion.estimates[name]
        if one.reason not in (IN_A_LANE, HEADINGS_KNOWN):
            value = _in_words(one, unit, motion)
            yield name.replace("_", " "), SHOWN.get(unit, unit), value, bounds_95(one)


def to_table(motion: Motion, title: str, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of the estimates."""
    table = Table(title=escape(title) or None, box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("", "", "value ± standard error", "95 %"):
        table.add_column(heading, min_width=len(heading))
    for row in rows(motion):
        table.add_row(*row)
    return table


def plate_table(motion: Motion, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of the speed at each plate speed."""
    table = Table(box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("plate speed (mm/s)", "speed (mm/s)"):
        table.add_column(heading)
    for plate, one in motion.by_plate_speed:
        table.add_row(f"{plate:g}", _in_words(one, "mm_s", motion))
    return table


def walkers_table(motion: Motion, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of each walker by itself, of many of the first."""
    headings = ["walker", "seen (s)", "speed (mm/s)"]
    turning = any("turning_bias" in one.estimates for one in motion.walkers)
    table = Table(box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in (*headings, "turning (rad/s)")[: 3 + turning]:
        table.add_column(heading)
    for one in motion.walkers[:MOST_WALKERS]:
        values = (_or_alone(one.of(name)) for name in OF_WALKERS[: 1 + turning])
        table.add_row(str(one.particle), words.number(one.seconds), *values)
    if len(motion.walkers) > MOST_WALKERS:
        table.caption = f"and {len(motion.walkers) - MOST_WALKERS} more in walkers.csv"
    return table


def _or_alone(one: Estimate) -> str:
    """Value with its error, or by itself with the reason why that is not known."""
    if one.value is None or one.se is not None:
        return with_error(one)
    return f"{words.number(one.value, 3)} ± ?: {one.reason}"


def walkers_csv(motion: Motion) -> str:
    """Format as CSV, a line for each walker by itself."""
    lines = []
    for one in motion.walkers:
        speed, turning = (one.of(name) for name in OF_WALKERS)
        cells = (*speed[:2], *_ends(speed), *turning[:2])
        lines.append((one.particle, one.seconds, *map(_cell, cells), speed.reason))
    return csv_text(
        ("particle", "seen_s", "speed_mm_s", "speed_se_mm_s", "speed_low_95_mm_s",
         "speed_high_95_mm_s", "turning_rad_s", "turning_se_rad_s", "refused"), lines,
    )  # fmt: skip


def line_told(motion: Motion) -> str:
    """Description of the line through the origin; '' without a line."""
    line = motion.line
    if line is None:
        return ""
    scale = scale_se(line.slope, "mm_s", motion)
    apart = f" ± {words.number(scale, 2)} by the scale" if scale else ""
    return (
        f"speed = ({line.slope:.4g} ± {line.slope_se:.2g}{apart}) x plate speed, a line through "
        f"the origin; chi² {line.chi2:.3g} for {line.points - 1} degrees of freedom, "
        f"probability {line.p_value:.2g}"
    )


def to_markdown(motion: Motion, title: str, notes: Sequence[str]) -> str:
    """Format a Markdown page with the estimates and what they rest on."""
    several = bool(motion.by_plate_speed)
    table = plate_table(motion, box.MARKDOWN) if several else to_table(motion, "", box.MARKDOWN)
    walkers = as_markdown(walkers_table(motion, box.MARKDOWN))
    parts = (f"# {title}", *notes, as_markdown(table), line_told(motion), walkers)
    return "\n\n".join(part for part in parts if part) + "\n"


def to_csv(motion: Motion) -> str:
    """Format as CSV, a line for each estimate: key with unit, value, errors, bounds, refusal."""
    lines = [
        (
            f"{name}_{unit}",
            *map(_cell, (one.value, one.se, scale_se(one.value, unit, motion), *_ends(one))),
            one.reason,
        )
        for (name, unit), one in zip(UNITS.items(), motion.estimates.values(), strict=True)
    ]
    return csv_text(("quantity", "value", "se", "scale_se", "low_95", "high_95", "refused"), lines)


def _ends(one: Estimate) -> tuple[float | None, float | None]:
    return one.interval(0.95) or (None, None)


def curve_to_csv(columns: Sequence[str], curves: Sequence[tuple[str, Sequence[Array]]]) -> str:
    """Format curves one below the other as CSV; names of curves lead lines if there are several."""
    lines = [
        (*((name,) if name else ()), *(_cell(float(value)) for value in point))
        for name, curve in curves
        for point in zip(*curve, strict=True)
    ]
    return csv_text(columns, lines)


def _cell(value: float | None) -> float | str:
    return "" if value is None or math.isnan(value) else value


def as_dict(motion: Motion) -> dict[str, Any]:
    """All results for JSON: values, errors and reasons by keys that carry their unit."""
    found: dict[str, Any] = {}
    for name, unit in UNITS.items():
        one = motion.estimates[name]
        found |= _keyed(name, one)
        found[f"{name}_scale_se_{unit}"] = scale_se(one.value, unit, motion)
    found |= {
        "refused": {
            f"{name}_{unit}": motion.estimates[name].reason
            for name, unit in UNITS.items()
            if motion.estimates[name].reason
        },
        "walkers": [
            {"particle": one.particle, "seen_s": one.seconds}
            | {
                key: value
                for name in OF_WALKERS
                for key, value in _keyed(name, one.of(name)).items()
            }
            | ({"refused": one.estimates["speed"].reason} if one.estimates["speed"].reason else {})
            for one in motion.walkers
        ],
        "particles": motion.particles,
        "samples": motion.samples,
        "scale_se_share": motion.scale_se,
        "tracked_s": motion.tracked_s,
        "lag_s": motion.lag_s,
        "method": motion.method,
        "msd_fit": _fit(motion),
        "msd": _points(
            (*motion.msd, scale_errors(motion), *motion.exponent[1:]),
            "lag_s",
            "msd_mm2",
            "msd_se_mm2",
            "msd_scale_se_mm2",
            "exponent",
            "exponent_se",
        ),
        "correlation": _points(motion.correlation, "lag_s", "value", "se"),
        "parallel": _points(motion.parallel, "mm", "density_per_mm", "density_se_per_mm"),
        "orthogonal": _points(motion.orthogonal, "mm", "density_per_mm", "density_se_per_mm"),
    }
    if motion.by_plate_speed:
        found["by_plate_speed"] = [
            {
                "plate_speed_mm_s": plate,
                "speed_mm_s": one.value,
                "speed_se_mm_s": one.se,
                "speed_scale_se_mm_s": scale_se(one.value, "mm_s", motion),
            }
            | ({"refused": one.reason} if one.reason else {})
            for plate, one in motion.by_plate_speed
        ]
        found["speed_over_plate_speed"] = motion.line._asdict() if motion.line else None
    return found


def _keyed(name: str, one: Estimate) -> dict[str, float | None]:
    """An estimate by keys that carry its unit."""
    low, high = _ends(one)
    ends = {f"{name}_low_95_{UNITS[name]}": low, f"{name}_high_95_{UNITS[name]}": high}
    return {f"{name}_{UNITS[name]}": one.value, f"{name}_se_{UNITS[name]}": one.se} | ends


def _fit(motion: Motion) -> dict[str, float | None] | None:
    """Parameters of the fit of the squared displacement, and its goodness."""
    fit = motion.msd_fit
    if fit is None:
        return None
    units = ("mm2_s2", "per_s", "mm2_s", "mm2", "rad_s", "mm2_s2", "per_s")
    spread = zip(fit.spreads[0]._asdict().items(), units, strict=True)
    values = {f"{name}_{unit}": value for (name, value), unit in spread}
    values |= {"misfit": fit.misfit, "p_value": fit.p_value}
    return {name: None if math.isnan(value) else value for name, value in values.items()}


def _points(curve: Sequence[Array], *names: str) -> list[dict[str, float | None]]:
    return [
        {name: None if math.isnan(value) else float(value)
         for name, value in zip(names, point, strict=True)}
        for point in zip(*curve, strict=True)
    ]  # fmt: skip
