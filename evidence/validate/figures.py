"""Figure of the claims: how far off each is, by group, and the names of those that disagree."""

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.validate.claim import FITTED, TITLE, TITLES, Claim
from walkergen.core.numerics.quantity import Verdict
from walkergen.files import figures
from walkergen.files.figures import BLUE, FAINT, GREY, MIN_FONT_PT, ORANGE, PAGE_INCHES, Look, style, wrap_text

LOOKS = {
    Verdict.AGREE.value: Look(BLUE, marker="o"),
    Verdict.UNDECIDED.value: Look("#009E73", marker="^"),
    FITTED: Look(GREY, marker="D"),
    Verdict.DISAGREE.value: Look(ORANGE, marker="s"),
}

MAX_DEVIATION, DECADE_LENGTH = 1e3, 0.42
"""End of the axis, where what lies beyond stands; length of a decade beyond 1, where the axis is
logarithmic: up to there it is linear."""

DOT_WIDTH, MAX_STACK = 0.05, 4
"""Width of a dot on the axis, and most dots in a stack at 0. Further stacks begin left of it."""

LINE_INCHES, LABEL_INCHES = 0.15, 3.0
"""Height of a line, and width of the names on the left."""

TICKS = (0.0, 0.5, 1.0, 10.0, 100.0, 1000.0)


@style()
def draw_claims(claims: Sequence[Claim]) -> Figure:
    """Picture of the claims: dots by group where they do not disagree, named lines where they do."""
    figure = Figure(layout="constrained")
    axes, names, top, left = figure.add_subplot(), dict[float, str](), 0.0, 0.0
    for group, title in TITLES.items():
        own = [claim for claim in claims if claim.group == group]
        dots = [claim for claim in own if claim.word in LOOKS and claim.verdict is not Verdict.DISAGREE]
        places = _stack_dots(dots)
        left = min([left, *(at for at, _ in places)])
        height = max(0.7 * max((level for _, level in places), default=0) + 1.2, 2.2)
        if own:
            agree = sum(claim.word == Verdict.AGREE.value for claim in own)
            names[top + 0.5 * height] = f"{title}:\n{agree} of {len(own)} agree"
        for claim, (at, level) in zip(dots, places, strict=True):
            _draw_claim(axes, claim, at, top + height - 0.55 - 0.7 * level)
        top += height if own else 0.0
        for reason in dict.fromkeys(claim.why for claim in own if claim.verdict is Verdict.DISAGREE):
            same = [claim for claim in own if claim.verdict is Verdict.DISAGREE and claim.why == reason]
            names[top + 0.5] = _common_name(same)
            for claim in same:
                _draw_claim(axes, claim, _claim_place(claim), top + 0.5)
            top += 1.0
        axes.axhline(top, color=FAINT, linewidth=0.6)
    figure.set_size_inches(PAGE_INCHES, 1.1 + LINE_INCHES * top)
    figure.suptitle(TITLE)
    axes.set_xlim(left - DOT_WIDTH, _axis_place(MAX_DEVIATION))
    axes.axvspan(left - DOT_WIDTH, 1.0, color=BLUE, alpha=0.07, linewidth=0, zorder=0)
    axes.set_xticks([_axis_place(tick) for tick in TICKS], [f"{tick:g}" for tick in TICKS])
    axes.set_yticks(list(names), list(names.values()))
    axes.set_ylim(top, 0.0)
    axes.tick_params(axis="y", length=0)
    for word, look in LOOKS.items():
        number = sum(claim.word == word for claim in claims)
        axes.plot([], [], look.marker, color=look.colour, markersize=4, label=f"{number} {word}")
    figures.label_axes(axes, "gap over what is allowed: beyond 1 it disagrees")
    figures.add_legend_below(figure, 4)
    return figure


def _draw_claim(axes: Axes, claim: Claim, x: float, y: float) -> None:
    look = LOOKS[claim.word]
    axes.plot([x], [y], look.marker, color=look.colour, markersize=4, clip_on=False, zorder=3)


def _common_name(claims: Sequence[Claim]) -> str:
    """Name of claims with one reason: the words that all have, or what stands before the colon of one."""
    if len(claims) > 1:
        words = zip(*(claim.quantity.partition(":")[0].split() for claim in claims), strict=False)
        return " ".join(own[0] if len({*own}) == 1 else "…" for own in words) + f" ({len(claims)})"
    name, *more = wrap_text(claims[0].quantity.partition(":")[0], LABEL_INCHES, MIN_FONT_PT).splitlines()
    return f"{name} …" if more else name


def _claim_place(claim: Claim) -> float:
    """Place of a claim on the axis."""
    return _axis_place(abs(claim.gap_over_allowed or 0.0))


def _axis_place(size: float) -> float:
    """Place on the axis: linear up to what is allowed, beyond logarithmic up to LARGEST."""
    return size if size <= 1.0 else 1.0 + DECADE_LENGTH * math.log10(min(size, MAX_DEVIATION))


def _stack_dots(claims: Sequence[Claim]) -> list[tuple[float, int]]:
    """Places of claims, and how many lie below each at about the same place."""
    below, places = dict[int, int](), []
    for claim in claims:
        cell = round(_claim_place(claim) / DOT_WIDTH)
        level = below.get(cell, 0)
        below[cell] = level + 1
        places.append(
            (-DOT_WIDTH * (level // MAX_STACK), level % MAX_STACK) if cell == 0 else (DOT_WIDTH * cell, level)
        )
    return places
