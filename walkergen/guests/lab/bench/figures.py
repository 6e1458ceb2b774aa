"""Figure of a drop: the rebound by the restitution of the feet."""

from matplotlib.figure import Figure

from walkergen.files.figures import BLUE, GREY, ORANGE, label_axes, new_axes, style
from walkergen.guests.lab.bench.drop import Dropped
from walkergen.guests.lab.inverse import Measured


@style()
def draw_drop(dropped: Dropped, title: str, turn_deg: float, measured: Measured | None) -> Figure:
    """Draw the rebound against the feet's restitution, for flat drops and drops from the hand."""
    figure, axes = new_axes(title)
    axes.plot((0, 1), (0, 1), ":", color=GREY, linewidth=0.9, label="a ball")
    flat, hand = dropped.curve(flat=True), dropped.curve(flat=False)
    if flat is not None:
        axes.plot(flat.at, flat.seen, "o-", color=BLUE, label="let go flat")
    if hand is not None and turn_deg > 0.0:
        words = f"from the hand, pitch and roll ± {turn_deg:g}°"
        axes.plot(hand.at, hand.seen, "s--", color=ORANGE, label=words)
        axes.fill_between(
            hand.at, hand.seen - hand.spread, hand.seen + hand.spread, color=ORANGE, alpha=0.2, linewidth=0
        )
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    if measured is not None:
        value, sd = measured.number.pair
        axes.axhspan(value - sd, value + sd, color=GREY, alpha=0.2, linewidth=0, label="measured")
        axes.axhline(value, color=GREY, linewidth=0.9)
    label_axes(axes, "restitution of the feet", "rebound of the whole walker")
    axes.legend(loc="upper left", frameon=True, framealpha=0.9, edgecolor="none")
    return figure
