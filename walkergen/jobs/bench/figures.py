"""Figures of the bench tests: curves from what the model needs to what is seen."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.files.figures import STYLES, axes_of
from walkergen.jobs.bench.drop import Dropped
from walkergen.jobs.bench.inverse import Measured

BLUE, ORANGE = STYLES["flexible"][0], STYLES["braced"][0]
GREY = "0.45"


def of_drop(found: Dropped, title: str, turn_deg: float, measured: Measured | None) -> Figure:
    """Draw the rebound against the feet's restitution, let go flat and from the hand."""
    figure, axes = axes_of(title)
    axes.plot((0, 1), (0, 1), ":", color=GREY, linewidth=0.9, label="a ball")
    flat, hand = found.curve(flat=True), found.curve(flat=False)
    if flat is not None:
        axes.plot(flat.at, flat.seen, "o-", color=BLUE, markersize=4, label="let go flat")
    if hand is not None and turn_deg > 0.0:
        axes.plot(hand.at, hand.seen, "s--", color=ORANGE, markersize=4,
                  label=f"from the hand, pitch and roll ± {turn_deg:g}°")  # fmt: skip
        band = hand.seen - hand.spread, hand.seen + hand.spread
        axes.fill_between(hand.at, *band, color=ORANGE, alpha=0.2, linewidth=0)
    _draw_measured(axes, measured)
    axes.set_xlabel("restitution of the feet (contact.restitution)")
    axes.set_ylabel("rebound of the whole walker")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.legend(fontsize=8, loc="upper left", framealpha=0.9, edgecolor="none")
    return figure


def _draw_measured(axes: Axes, measured: Measured | None) -> None:
    if measured is None:
        return
    low, high = measured.value - measured.sd, measured.value + measured.sd
    axes.axhspan(low, high, color=GREY, alpha=0.2, linewidth=0, label="measured")
    axes.axhline(measured.value, color=GREY, linewidth=0.9)
