"""Tables of measured motion: console, Markdown, CSV, JSON."""

import math
from collections.abc import Iterator, Sequence

from rich import box
from rich.markup import escape
from rich.table import Table

from walkergen.analysis import facts
from walkergen.analysis.estimates import (
    HEADINGS_KNOWN,
    IN_A_LANE,
    UNITS,
    Estimate,
    bounds_95,
    with_error,
)
from walkergen.analysis.facts import OF_WALKERS, scale_se
from walkergen.analysis.motion import Array, Motion
from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text

SHOWN = {"mm_s": "mm/s", "mm2_s": "mm²/s", "per_s": "1/s", "rad_s": "rad/s", "rad2_s": "rad²/s"}
"""Units as they are printed where they are not part of a key."""


MOST_WALKERS = 24
"""Largest number of walkers in a table that is printed."""


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
        cells = (*speed[:2], *facts.ends(speed), *turning[:2])
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
            *map(_cell, (one.value, one.se, scale_se(one.value, unit, motion), *facts.ends(one))),
            one.reason,
        )
        for (name, unit), one in zip(UNITS.items(), motion.estimates.values(), strict=True)
    ]
    return csv_text(("quantity", "value", "se", "scale_se", "low_95", "high_95", "refused"), lines)


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
