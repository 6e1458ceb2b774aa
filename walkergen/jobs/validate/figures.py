"""Figure of the claims: every gap over what is allowed, grouped."""

import math
from collections.abc import Sequence

from matplotlib.figure import Figure

from walkergen.files import figures
from walkergen.jobs.validate.claim import Claim

COLOURS = {"agree": "#0072B2", "fitted": "#8c8c8c", "disagree": "#D55E00", "not run": "#8c8c8c"}
MARKERS = {"agree": "o", "fitted": "D", "disagree": "s", "not run": "x"}

LINE_IN = 0.155
"""Height of a claim's line, inches."""

SMALLEST, LARGEST = 1e-3, 1e3
"""Ends of the axis, gaps over those allowed; what lies beyond is drawn at its end."""


def deviations(claims: Sequence[Claim]) -> bytes:
    """Picture of the claims, a line each: agreement left of 1, disagreement right of it (PNG)."""
    figure = Figure(figsize=(9.0, 1.3 + LINE_IN * len(claims)), layout="constrained")
    axes = figure.subplots()
    groups = list(dict.fromkeys(one.group for one in claims))
    for word, colour in COLOURS.items():
        own = [(line, one) for line, one in enumerate(claims) if one.verdict == word]
        x = [_place(one) for _, one in own]
        y = [line for line, _ in own]
        axes.plot(x, y, MARKERS[word], color=colour, markersize=4, label=word, linestyle="none")
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.axvspan(SMALLEST / 2.0, 1.0, color="#0072B2", alpha=0.06, linewidth=0)
    for group in groups:
        line = next(line for line, one in enumerate(claims) if one.group == group)
        axes.axhline(line - 0.5, color="grey", linewidth=0.6)
        axes.text(1.9 * LARGEST, line - 0.3, group, ha="right", va="top", fontsize=8, weight="bold")
    axes.set_yticks(range(len(claims)), [one.quantity for one in claims], fontsize=6)
    axes.set_ylim(len(claims) - 0.4, -0.6)
    axes.set_xscale("log")
    axes.set_xlim(SMALLEST / 2.0, 2.0 * LARGEST)
    axes.set_xlabel("|gap| over what errors and margin allow (ends: beyond)", fontsize=8)
    axes.tick_params(axis="x", labelsize=7)
    axes.grid(axis="x", linewidth=0.3)
    figure.legend(loc="outside upper center", ncols=4, fontsize=8, frameon=False)
    return figures.png(figure, dpi=110)


def _place(one: Claim) -> float:
    """Place on the axis; a claim that was not run stands at 1."""
    if one.deviation is None:
        return 1.0
    size = abs(one.deviation)
    return min(max(size, SMALLEST), LARGEST) if math.isfinite(size) else LARGEST
