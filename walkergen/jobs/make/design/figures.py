"""Figure of the trade-off: what was surveyed and tried against every key that varies."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.files.figures import COLUMN, PAGE, style, wrapped
from walkergen.files.key_names import label
from walkergen.jobs.make.design.lab import Job
from walkergen.jobs.make.design.report import title
from walkergen.jobs.make.design.search import Search
from walkergen.jobs.make.design.verify import Verified
from walkergen.jobs.make.design.wish import UNITS, Wish
from walkergen.points.point import PREDICTION

ACROSS = 3
"""Largest number of panels side by side."""

FOUND = "#D55E00"

BESIDE = ((8, 5), (-13, -13), (8, -13))
"""Places of the numbers of designs beside their marks, points: designs often share a value."""


@style()
def trade_off(job: Job, result: Search, designs: Sequence[Verified]) -> Figure:
    """Draw the wish's quantity against each key: surveyed, tried, and the designs, numbered."""
    count = len(job.box.spans)
    wide, high = min(count, ACROSS), -(-count // ACROSS)
    width = COLUMN if wide == 1 else PAGE
    figure = Figure(figsize=(width, 2.3 * high + 0.7), layout="constrained")
    panels = figure.subplots(high, wide, sharey=True, squeeze=False).ravel()
    tried = [trial for trial in result.trials if trial.usable and trial.seen]
    levels = [trial.seen.value for trial in tried if trial.seen]
    predicted = [trial for trial in result.survey.trials if trial.usable and trial.seen]
    for span, axes in zip(job.box.spans, panels, strict=False):
        if job.wish.of == "speed":
            axes.plot(
                [trial.values[span.key] for trial in predicted],
                [trial.seen.value for trial in predicted if trial.seen],
                ".",
                color="0.75",
                markersize=3,
                label="predicted",
                rasterized=True,
            )
        if job.model != PREDICTION or job.wish.of != "speed":
            axes.plot(
                [trial.values[span.key] for trial in tried],
                levels,
                "o",
                color="0.25",
                markersize=3.5,
                label=f"tried, model {job.model}",
            )
        _wish(axes, job.wish)
        for number, design in enumerate(designs, start=1):
            shown = design.verified or design.chosen
            bars = [[0.0], [0.0]]
            if design.bounds is not None and job.simulated:
                bars = [[max(shown.value - design.bounds[0], 0.0)], [max(design.bounds[1] - shown.value, 0.0)]]
            at = design.values[span.key]
            axes.errorbar(
                at,
                shown.value,
                bars,
                fmt="s" if design.met else "X",
                color=FOUND,
                markersize=7,
                capsize=3,
                markeredgecolor="black",
                zorder=5,
                label="designs" if number == 1 else None,
            )
            axes.annotate(
                str(number),
                (at, shown.value),
                xytext=BESIDE[number - 1],
                zorder=6,
                textcoords="offset points",
                fontweight="bold",
            )
        axes.set_xlabel(label(span.key))
        if job.wish.logarithmic:
            axes.set_yscale("log")
    for axes in panels[count:]:
        axes.set_visible(False)
    for axes in panels[:count:wide]:
        axes.set_ylabel(f"{job.wish.of} ({UNITS[job.wish.of]})")
    figure.suptitle(wrapped(title(job), width - 0.2))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2 if wide == 1 else 4)
    return figure


def _wish(axes: Axes, wish: Wish) -> None:
    if wish.target is None:
        return
    error = wish.allowed(0.0)
    axes.axhspan(
        wish.target - error,
        wish.target + error,
        color="#56B4E9",
        alpha=0.35,
        linewidth=0,
        zorder=0,
        label="wished, within the error",
    )
    axes.axhline(wish.target, color="#0072B2", linewidth=0.8, zorder=1)
