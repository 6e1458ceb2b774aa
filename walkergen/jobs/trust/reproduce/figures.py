"""The paper's figures 2, 3, 5, 6 with our curves and its statements on the same axes."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.files.figures import PAGE, SMALLEST, style, wrapped
from walkergen.jobs.trust.published import FACTS
from walkergen.jobs.trust.reproduce import plane_figure
from walkergen.jobs.trust.reproduce.compare import FITTED, Findings, Theory
from walkergen.jobs.trust.reproduce.curves import lively, series_of, through_zero
from walkergen.jobs.trust.reproduce.sweeps import COUNTINGS, TYPES, Assumption, Point

# Okabe and Ito's colours, each with its own line and marker: readable in grey as well.
MODELS = {
    "relaxed": ("#009E73", "-.", "^", "simulated, relaxed legs (the paper's)"),
    "compliant": ("#D55E00", "-", "o", "simulated, legs on springs"),
    "space": ("#CC79A7", "-", "D", "simulated, in space"),
    "space, noisy plate": ("#882255", "--", "v", "simulated, in space, noisy plate"),
    "rigid": ("#000000", ":", "s", "simulated, braced"),
    "space, braced": ("#000000", "--", "x", "simulated, braced, in space"),
}
THEORY = {"coulomb": ("#0072B2", "-"), "paper": ("#56B4E9", "--")}
# From dark to light in the order of TYPES; hatches where greys come close.
FILLS = (("#0072B2", ""), ("#56B4E9", ""), ("#E69F00", "//"), ("#F0E442", ".."), ("#FFFFFF", ""), ("#FFFFFF", "xx"))
STAR: Any = {"marker": "*", "color": "black", "markersize": 9, "linestyle": "none", "markerfacecolor": "white"}
LABELS = {"from rest": "from rest", "mirrored": "backward before, then stops"}
PANEL_INCHES = 2.0
"""Width of a panel of three side by side."""
ROOM = 1.15
"""Upper end of the axes over the largest simulated speed; the theory may exceed it."""


def figure2(findings: Findings) -> Figure:
    """Draw speed against tilt: a panel for each set of contact numbers."""
    with style():
        figure = Figure(figsize=(PAGE, 3.9), layout="constrained")
        figure.suptitle("Speed against tilt, as in the paper's figure 2")
        panels = figure.subplots(1, len(findings.assumptions), sharey=True)
        for axes, assumption in zip(panels, findings.assumptions, strict=True):
            for theory in findings.theories:
                if theory.assumption == assumption.name:
                    _draw_theory(axes, theory)
            _draw_points(axes, [p for p in findings.tilts if p.assumption == assumption.name], "tilt_deg")
            _mark_facts(axes)
            axes.set_xlabel("tilt of the legs (deg)")
            axes.set_title(wrapped(assumption.label, PANEL_INCHES, SMALLEST), fontsize=SMALLEST)
        panels[0].set_ylim(-0.08 * _highest(findings.tilts), _highest(findings.tilts))
        panels[0].set_ylabel("mean speed (mm/s)")
        _legend(figure, panels[0])
    return figure


def _highest(points: Sequence[Point]) -> float:
    speeds = [point.speed.mean for point in points if point.speed is not None]
    return ROOM * max([FACTS["peak speed"].high, *speeds])


def _legend(figure: Figure, axes: Axes, columns: int = 3) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)


def _draw_theory(axes: Axes, theory: Theory) -> None:
    colour, line = THEORY[theory.mode]
    tilt, speed, sd = theory.curve.tilt_deg, theory.curve.speed, theory.curve.sd
    axes.plot(tilt, speed, line, color=colour, linewidth=1.2, label=theory.label)
    axes.fill_between(tilt, speed - sd, speed + sd, color=colour, alpha=0.18, linewidth=0)


def _draw_points(axes: Axes, points: Sequence[Point], along: str, joined: bool = True) -> None:
    """Draw simulated speeds with bars of two standard errors, joined along the axis or alone."""
    for series in series_of(points):
        colour, line, marker, label = MODELS[series[0].model]
        rows = [(getattr(point, along), *point.speed) for point in series if point.speed]
        if rows:
            x, speeds, errors = (np.array(column) for column in zip(*rows, strict=True))
            axes.errorbar(
                x,
                speeds,
                2.0 * errors,
                fmt=marker,
                linestyle=line if joined else "none",
                color=colour,
                markerfacecolor="white",
                linewidth=0.8,
                capsize=2,
                label=label,
                zorder=3,
            )


def _mark_facts(axes: Axes) -> None:
    """Mark the paper's peak with its margins, and the speeds it calls not significant."""
    tilt, speed, braced = FACTS["peak tilt"], FACTS["peak speed"], FACTS["braced"]
    axes.errorbar(
        [tilt.value],
        [speed.value],
        xerr=[[tilt.value - tilt.low], [tilt.high - tilt.value]],
        yerr=[[speed.value - speed.low], [speed.high - speed.value]],
        fmt="none",
        ecolor="black",
        elinewidth=1.0,
        zorder=2,
    )
    axes.plot([tilt.value], [speed.value], label="the paper's stated peak", zorder=2, **STAR)
    axes.axhspan(
        braced.low,
        braced.high,
        color="0.8",
        linewidth=0,
        zorder=-1,
        label="the paper's braced walkers: no significant speed",
    )


def figure3(findings: Findings) -> Figure:
    """Draw types of impacts against tilt, fitted contact: models by rows, countings by columns.

    Types II and III lie at the bottom, so that their common edge meets the paper's 95 %.
    """
    fitted = next(assumption for assumption in findings.assumptions if assumption.name == FITTED)
    models = ("relaxed", "compliant", "space")
    with style():
        figure = Figure(figsize=(PAGE, 6.4), layout="constrained")
        grid = figure.subplots(len(models), len(COUNTINGS), sharex=True, sharey=True)
        for row, model in zip(grid, models, strict=True):
            series = [p for p in findings.tilts if (p.assumption, p.model) == (fitted.name, model)]
            for axes, counting in zip(row, COUNTINGS, strict=True):
                _stack(axes, [point for point in series if point.shares], counting)
                name = f"{MODELS[model][3].removeprefix('simulated, ')}: {counting}"
                axes.set_title(wrapped(name, PANEL_INCHES, SMALLEST), fontsize=SMALLEST)
            row[0].set_ylabel("share (%)")
        for axes in grid[-1]:
            axes.set_xlabel("tilt of the legs (deg)")
        figure.suptitle(f"Types of impacts, {fitted.label}")
        _legend(figure, grid[0, 0], columns=4)
    return figure


def _stack(axes: Axes, series: Sequence[Point], counting: str) -> None:
    places, ground = np.arange(len(series)), np.zeros(len(series))
    for kind, (colour, hatch) in zip(TYPES, FILLS, strict=True):
        shares = np.array([100.0 * point.shares[counting, kind].mean for point in series])
        axes.bar(
            places,
            shares,
            0.9,
            bottom=ground,
            color=colour,
            hatch=hatch,
            edgecolor="0.25",
            linewidth=0.4,
            label=LABELS.get(kind, f"type {kind}"),
        )
        ground += shares
    bound = FACTS["types II and III"].value
    axes.axhline(
        bound,
        color="black",
        linestyle="--",
        linewidth=1.2,
        label=f"the paper: types II and III make more than {bound:g} %",
    )
    axes.set_ylim(0.0, 100.0)
    axes.set_xticks(places, [f"{point.tilt_deg:g}" for point in series], fontsize=SMALLEST)


def figure5(findings: Findings) -> Figure:
    """Draw speed against the plate's speed: points with errors, thin lines through zero."""
    with style():
        figure = Figure(figsize=(PAGE, 3.9), layout="constrained")
        figure.suptitle("Speed against the plate's speed, as in the paper's figure 5")
        panels = figure.subplots(1, len(findings.assumptions), sharey=True)
        for axes, assumption in zip(panels, findings.assumptions, strict=True):
            points = [point for point in findings.drives if point.assumption == assumption.name]
            _draw_lines(axes, points, assumption)
            for theory in findings.theories:
                if theory.assumption == assumption.name and theory.mode == "coulomb":
                    _draw_theory_line(axes, theory, assumption, points)
            _draw_points(axes, points, "plate_speed_mm_s", joined=False)
            _mark_drive(axes, assumption)
            axes.set_xlim(0.0, 1.05 * max(point.plate_speed_mm_s for point in points))
            axes.set_xlabel("peak speed of the plate (mm/s)")
            axes.set_title(wrapped(assumption.label, PANEL_INCHES, SMALLEST), fontsize=SMALLEST)
        panels[0].set_ylim(-0.08 * _highest(findings.drives), _highest(findings.drives))
        panels[0].set_ylabel(f"mean speed at {findings.drives[0].tilt_deg:g} deg (mm/s)")
        _legend(figure, panels[0])
    return figure


def _draw_lines(axes: Axes, points: Sequence[Point], assumption: Assumption) -> None:
    """Draw lines through zero, of walkers in space through the points from figure 2's drive up.

    A band shows two standard errors of the slope; lines say no more than their points.
    """
    end = 1.05 * max(point.plate_speed_mm_s for point in points)
    labelled = False
    for series in series_of(points):
        colour, line, *_ = MODELS[series[0].model]
        fitted, start = series, 0.0
        if series[0].model == "space":
            fitted, start = (lively(series, assumption.scene.drive.peak_speed), assumption.scene.drive.peak_speed)
        slope = through_zero(fitted)
        if slope is None:
            continue
        x = np.array([start, end])
        name = None if labelled else "through zero, ± 2 SE (in space: of those that run)"
        axes.plot(x, slope.mean * x, line, color=colour, linewidth=0.7, zorder=2, label=name)
        low, high = ((slope.mean + sign * 2.0 * slope.se) * x for sign in (-1.0, 1.0))
        axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0, zorder=1)
        labelled = True


def _draw_theory_line(axes: Axes, theory: Theory, assumption: Assumption, points: Sequence[Point]) -> None:
    """Draw the theory's line: proportional to the plate's speed by construction."""
    colour, line = THEORY[theory.mode]
    speed = np.interp(points[0].tilt_deg, theory.curve.tilt_deg, theory.curve.speed)
    peak, end = assumption.scene.drive.peak_speed, 1.05 * max(p.plate_speed_mm_s for p in points)
    axes.plot([0.0, end], [0.0, speed * end / peak], line, color=colour, linewidth=1.2, label=theory.label)


def _mark_drive(axes: Axes, assumption: Assumption) -> None:
    """Mark the speed that the paper states for this drive, at its best tilt."""
    peak, tilt = FACTS["peak speed"], FACTS["peak tilt"]
    axes.plot(
        [assumption.scene.drive.peak_speed],
        [peak.value],
        zorder=5,
        label=f"the paper's stated peak (at {tilt.value:g} deg)",
        **STAR,
    )


def figure6(findings: Findings) -> Figure:
    """Draw motion on a plane: squared displacements with exponents, tracks, densities."""
    with style():
        figure = Figure(figsize=(PAGE, 5.6), layout="constrained")
        plane_figure.draw(figure, findings)
    return figure


FIGURES: dict[str, Callable[[Findings], Figure]] = {
    "figure2": figure2,
    "figure3": figure3,
    "figure5": figure5,
    "figure6": figure6,
}
