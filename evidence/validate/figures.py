"""Figure of the claims: how far off each is, by group, and the names of those that disagree."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.validate.claim import Claim
from evidence.validate.report import TITLES
from walkergen.files.figures import PAGE, SMALLEST, style, wrapped

COLOURS: dict[str, str] = {"agree": "#0072B2", "undecided": "#009E73", "fitted": "#8c8c8c", "disagree": "#D55E00"}
MARKERS: dict[str, str] = {"agree": "o", "undecided": "^", "fitted": "D", "disagree": "s"}

EXACT = 0.01
"""Gap over the allowed one below which a claim stands in the block of those without a gap."""

LARGEST = 1e3
"""End of the axis; what lies beyond stands there."""

DECADE = 0.42
"""Length of a decade beyond 1, where the axis is logarithmic; up to there it is linear."""

DOT = 0.05
"""Width of a dot on the axis, where one stands above another."""

BLOCK, PITCH = 4, 0.7
"""Dots above one another in the block of claims without a gap, and lines from one to the next."""

LINE = 0.15
"""Height of a line, inches."""

LABEL_INCHES = 3.0
"""Width of the names on the left."""

TICKS = (0.0, 0.5, 1.0, 10.0, 100.0, 1000.0)


class Row(NamedTuple):
    """Line of the figure: claims that disagree for one reason."""

    name: str
    claims: Sequence[Claim]


@style()
def deviations(claims: Sequence[Claim]) -> Figure:
    """Picture of the claims: dots by group where they agree, named lines where they do not."""
    groups = {title: [claim for claim in claims if claim.group == group] for group, title in TITLES.items()}
    groups = {title: own for title, own in groups.items() if own}
    heights = {title: max(0.5 + PITCH * _tallest(own), 2.2) for title, own in groups.items()}
    rows = {title: _rows(own) for title, own in groups.items()}
    lines = sum(heights.values()) + sum(len(own) for own in rows.values())
    figure = Figure(figsize=(PAGE, 1.1 + LINE * lines), layout="constrained")
    figure.suptitle("What walkergen predicts, beside what is known outside it")
    axes = figure.add_subplot()
    ticks, names, top = list[float](), list[str](), 0.0
    for title, own in groups.items():
        ticks.append(top + 0.5 * heights[title])
        names.append(f"{title}:\n{_count(own)}")
        _draw_dots(axes, own, top + heights[title] - 0.55)
        top += heights[title]
        for row in rows[title]:
            ticks.append(top + 0.5)
            names.append(row.name)
            places = [_place(claim) for claim in row.claims]
            axes.plot([1.0, max(places)], [top + 0.5] * 2, color="0.85", linewidth=0.8, zorder=1)
            _mark(axes, "disagree", places, [top + 0.5] * len(places))
            top += 1.0
        axes.axhline(top, color="0.8", linewidth=0.6)
    left = min((at for own in groups.values() for _, at, _ in _swarm(own)), default=0.0)
    _dress(axes, min(left, 0.0) - DOT, ticks, names, top)
    for word, colour in COLOURS.items():
        number = sum(claim.word == word for claim in claims)
        axes.plot([], [], MARKERS[word], color=colour, markersize=4, label=f"{number} {word}")
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _rows(claims: Sequence[Claim]) -> list[Row]:
    """Claims that disagree, a row for each reason, named by what they are about."""
    by_reason = dict[str, list[Claim]]()
    for claim in claims:
        if claim.word == "disagree":
            by_reason.setdefault(claim.why, []).append(claim)
    return [Row(_subject(own), own) for own in by_reason.values()]


def _subject(claims: Sequence[Claim]) -> str:
    """Name of claims with one reason, without the words in which they differ.

    Of one with a long name it is what stands before the colon.
    """
    first = claims[0].quantity
    if len(claims) > 1:
        words = zip(*(claim.quantity.partition(":")[0].split() for claim in claims), strict=False)
        name = " ".join(own[0] if len({*own}) == 1 else "…" for own in words)
        return f"{name} ({len(claims)})"
    for name in (first, first.partition(":")[0]):
        lines = wrapped(name, LABEL_INCHES, SMALLEST).splitlines()
        if len(lines) == 1:
            return name
    return f"{lines[0]} …"


def _count(claims: Sequence[Claim]) -> str:
    """Number of claims by verdict: "21 of 30 agree, 2 fitted"."""
    number = {word: sum(claim.word == word for claim in claims) for word in ("agree", "undecided", "fitted", "missing")}
    more = [f", {number[word]} {word}" for word in ("undecided", "fitted", "missing") if number[word]]
    return f"{number['agree']} of {len(claims)} agree" + "".join(more)


def _place(claim: Claim) -> float:
    """Place on the axis: linear up to what is allowed, beyond logarithmic up to LARGEST."""
    assert claim.gap_over_allowed is not None
    return _at(abs(claim.gap_over_allowed))


def _at(size: float) -> float:
    if size <= 1.0:
        return size
    return 1.0 + DECADE * math.log10(min(size, LARGEST))


def _swarm(claims: Sequence[Claim]) -> list[tuple[Claim, float, int]]:
    """Agreeing claims with their places, and how many lie below each at about the same place.

    Those without a gap fill a block left of the axis.
    """
    shown = [claim for claim in claims if claim.word in ("agree", "undecided", "fitted")]
    exact = [claim for claim in shown if abs(claim.gap_over_allowed or 0.0) < EXACT]
    places = [(claim, -DOT * (1.5 + number // BLOCK), number % BLOCK) for number, claim in enumerate(exact)]
    below = dict[int, int]()
    for claim in sorted((claim for claim in shown if claim not in exact), key=_place):
        cell = round(_place(claim) / DOT)
        places.append((claim, DOT * cell, below.get(cell, 0)))
        below[cell] = below.get(cell, 0) + 1
    return places


def _tallest(claims: Sequence[Claim]) -> int:
    return 1 + max((level for _, _, level in _swarm(claims)), default=0)


def _draw_dots(axes: Axes, claims: Sequence[Claim], ground: float) -> None:
    """Draw the agreeing claims of a group, one above another, from a line upward."""
    for word in ("agree", "undecided", "fitted"):
        places = [(at, ground - PITCH * level) for claim, at, level in _swarm(claims) if claim.word == word]
        if places:
            _mark(axes, word, *np.array(places).T.tolist())


def _mark(axes: Axes, word: str, x: Sequence[float], y: Sequence[float]) -> None:
    axes.plot(x, y, MARKERS[word], color=COLOURS[word], markersize=4, linestyle="none", clip_on=False, zorder=3)


def _dress(axes: Axes, left: float, ticks: Sequence[float], names: Sequence[str], bottom: float) -> None:
    """Name both axes, which end at `left` and at the `bottom`; what is allowed is shaded."""
    axes.set_xlim(left, _at(LARGEST))
    axes.axvspan(left, 1.0, color="#0072B2", alpha=0.07, linewidth=0, zorder=0)
    axes.axvline(1.0, color="black", linewidth=0.8, zorder=2)
    axes.axvline(0.0, color="0.8", linewidth=0.6, zorder=1)
    axes.set_xticks([_at(tick) for tick in TICKS], [f"{tick:g}" for tick in TICKS])
    axes.set_xlabel(f"gap over what errors and margin allow (left of 0: less than {EXACT:g})")
    axes.set_yticks(ticks, names)
    for tick in axes.get_yticklabels():
        if "\n" in tick.get_text():  # of a group
            tick.set_fontweight("bold")
    axes.set_ylim(bottom, 0.0)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
