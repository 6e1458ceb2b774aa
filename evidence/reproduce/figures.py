"""The paper's figures 2, 5 and 6 with our curves, its statements on the same axes, and the mechanisms."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from evidence.published import FACTS
from evidence.reproduce.compare import LOW_RESTITUTION, Findings
from evidence.reproduce.curves import group_points, running_points, slope_through_zero
from evidence.reproduce.growth import CROSSOVER_EXPONENT
from evidence.reproduce.mechanisms import Mechanism
from evidence.reproduce.motion import Runs
from evidence.reproduce.runs import PAPER_MODEL, Point
from walkergen.core.numerics import Complex
from walkergen.core.walker.sections import section_of
from walkergen.files import figures
from walkergen.files.figures import GREY, INK, MIN_FONT_PT, PAGE_INCHES, PALE, SERIES, Look, style, wrap_text

# Each with its own line and marker: readable in grey as well.
MODELS = {
    PAPER_MODEL: (Look("#009E73", "-.", "^"), "simulated, the paper's own model"),
    "space": (Look("#CC79A7", "-", "D"), "simulated, in space"),
    "space, noisy plate": (Look("#882255", "--", "v"), "simulated, in space, noisy plate"),
    "space, braced": (Look("#000000", "--", "x"), "simulated, braced, in space"),
}
THEORY_LOOKS = {"coulomb": Look("#0072B2"), "paper": Look("#56B4E9", "--")}
STATED_LOOK = Look("#000000", "none", "*")
HEADROOM = 1.15
"""Upper end of the axes over the largest simulated speed; the theory may exceed it."""
MAX_TRACKS = 8
"""Largest number of tracks drawn for a tilt."""


@style()
def figure2(findings: Findings) -> Figure:
    """Draw speed against tilt: a panel for each set of contact numbers."""
    figure, panels = _make_panels(findings, findings.tilts, "Speed against tilt, as in the paper's figure 2")
    tilt, speed, braced = FACTS["peak tilt"], FACTS["peak speed"], FACTS["braced"]
    for axes, assumption in zip(panels, findings.assumptions, strict=True):
        for theory in findings.theories:
            if theory.assumption == assumption.name:
                figures.draw_curve(axes, theory.curve[:3], THEORY_LOOKS[theory.mode], theory.label)
        _draw_points(axes, [p for p in findings.tilts if p.assumption == assumption], "tilt_deg", joined=True)
        peak = [tilt.value], [speed.value], [[speed.value - speed.low], [speed.high - speed.value]]
        figures.draw_points(axes, peak, STATED_LOOK, "the paper's stated peak", hollow=True)
        axes.plot([tilt.low, tilt.high], [speed.value] * 2, color=STATED_LOOK.colour, linewidth=0.8)
        name = "the paper's braced walkers: no significant speed"
        axes.axhspan(braced.low, braced.high, color=PALE, linewidth=0, zorder=-1, label=name)
        figures.label_axes(axes, "tilt of the legs (deg)")
    figures.label_axes(panels[0], y="mean speed (mm/s)")
    figures.add_legend_below(figure, 3)
    return figure


@style()
def figure5(findings: Findings) -> Figure:
    """Draw speed against the plate's speed: points with errors, thin lines through zero."""
    figure, panels = _make_panels(
        findings, findings.drives, "Speed against the plate's speed, as in the paper's figure 5"
    )
    for axes, assumption in zip(panels, findings.assumptions, strict=True):
        points, drive = [p for p in findings.drives if p.assumption == assumption], assumption.scene.drive.peak_speed
        end = 1.05 * max(point.plate_speed_mm_s for point in points)
        _draw_lines(axes, points, drive, end)
        for theory in findings.theories:
            if theory.assumption == assumption.name and theory.mode == "coulomb":  # proportional by construction
                speed = np.interp(points[0].tilt_deg, theory.curve.tilt_deg, theory.curve.speed)
                line = [0.0, end], [0.0, speed * end / drive], [0.0, 0.0]
                figures.draw_curve(axes, line, THEORY_LOOKS["coulomb"], theory.label)
        _draw_points(axes, points, "plate_speed_mm_s", joined=False)
        star = f"the paper's stated peak (at {FACTS['peak tilt'].value:g} deg)"
        figures.draw_points(axes, ([drive], [FACTS["peak speed"].value], None), STATED_LOOK, star, hollow=True)
        axes.set_xlim(0.0, end)
        figures.label_axes(axes, "peak speed of the plate (mm/s)")
    figures.label_axes(panels[0], y=f"mean speed at {findings.drives[0].tilt_deg:g} deg (mm/s)")
    figures.add_legend_below(figure, 3)
    return figure


def _make_panels(findings: Findings, points: Sequence[Point], title: str) -> tuple[Figure, list[Axes]]:
    """Figure with a panel for each assumption, as high as the largest simulated speed."""
    count = len(findings.assumptions)
    figure, panels = figures.new_grid(title, count, count, 3.9, share_y=True)
    for axes, assumption in zip(panels, findings.assumptions, strict=True):
        axes.set_title(wrap_text(assumption.label, 2.0, MIN_FONT_PT), fontsize=MIN_FONT_PT)
    highest = HEADROOM * max([FACTS["peak speed"].high, *(point.speed.value or 0.0 for point in points)])
    panels[0].set_ylim(-0.08 * highest, highest)
    return figure, panels


def _draw_points(axes: Axes, points: Sequence[Point], along: str, joined: bool) -> None:
    """Draw simulated speeds with bars of two standard errors, joined along the axis or alone."""
    for series in group_points(points):
        look, label = MODELS[series[0].model]
        known = [(getattr(p, along), p.speed.value, 2.0 * (p.speed.se or 0.0)) for p in series if p.speed.known]
        if known:
            figures.draw_points(axes, list(zip(*known, strict=True)), look, label, hollow=True, joined=joined)


def _draw_lines(axes: Axes, points: Sequence[Point], drive: float, end: float) -> None:
    """Draw lines through zero, of walkers in space through the points from figure 2's drive up.

    A band shows two standard errors of the slope; lines say no more than their points.
    """
    name = "through zero, ± 2 SE (in space: of those that run)"
    for series in group_points(points):
        look, in_space = MODELS[series[0].model][0], series[0].model == "space"
        slope = slope_through_zero(running_points(series, drive) if in_space else series)
        if slope.value is not None and slope.se is not None:
            x = np.array([drive if in_space else 0.0, end])
            figures.draw_curve(axes, (x, slope.value * x, 2.0 * slope.se * x), look, name, 0.15)
            name = ""


@style()
def figure6(findings: Findings) -> Figure:
    """Draw motion on a plane, with the low restitution: displacements, exponents, tracks, densities."""
    plane = [runs for runs in findings.plane if runs.assumption == LOW_RESTITUTION]
    (low,) = (assumption for assumption in findings.assumptions if assumption.name == LOW_RESTITUTION)
    figure, panels = figures.new_grid(f"Motion on a plane, {low.label}", 4, 2, 2.8)
    squares, slopes, tracks, densities = panels
    for place, (runs, look) in enumerate(zip(plane, SERIES, strict=False)):
        for axes, curve in ((squares, runs.motion.msd), (slopes, runs.growth.exponents)):
            shown = curve.value > 0.0
            drawn = curve.at[shown], curve.value[shown], 2.0 * curve.se[shown]
            figures.draw_points(axes, drawn, look, f"{runs.tilt_deg:g} deg", hollow=True, joined=True)
        for width, curve in ((1.4, runs.motion.parallel), (0.7, runs.motion.orthogonal)):
            densities.step(curve.at, curve.value, look.line, color=look.colour, where="mid", linewidth=width)
        for path in _star_of_tracks(runs, place):
            tracks.plot(path.real, path.imag, color=look.colour, linewidth=0.9)
    _draw_guides(squares, slopes, plane)
    tracks.set_aspect("equal", adjustable="datalim")
    figures.label_axes(tracks, "x (mm)", "y (mm)")
    figures.label_axes(densities, "along and across the heading (mm)", "density over 40 ms (1/mm)")
    for axes, letter in zip(panels, "abcd", strict=True):
        axes.set_title(f"({letter})", loc="left")
    figures.add_legend_below(figure, 5)
    return figure


def _draw_guides(squares: Axes, slopes: Axes, plane: Sequence[Runs]) -> None:
    """Draw guides of slopes 2 and 1, and the paper's crossover of the slow walker."""
    fact = FACTS["crossover at 35"]
    slow = plane[-1].motion.msd if plane else None
    for power, line, name in ((2, "--", "∝ t²"), (1, "-.", "∝ t")):
        slopes.axhline(power, linestyle=line, color=GREY, linewidth=1.0, zorder=0)
        if slow is not None and (slow.value > 0.0).any():
            time = slow.at[[0, -1]]
            height = 2.5 * float(np.interp(fact.value, slow.at, slow.value))
            squares.plot(time, height * (time / fact.value) ** power, line, color=GREY, label=name, linewidth=1.0)
    figures.draw_points(slopes, ([fact.value], [CROSSOVER_EXPONENT], None), STATED_LOOK, hollow=True)
    slopes.plot([fact.low, fact.high], [CROSSOVER_EXPONENT] * 2, color=STATED_LOOK.colour, linewidth=0.8)
    slopes.set_ylim(0.8, 2.1)
    figures.label_axes(slopes, "lag t (s)", "local exponent of the MSD", log="x")
    figures.label_axes(squares, "lag t (s)", "mean squared displacement (mm²)", log="xy" if plane else "")


def _star_of_tracks(runs: Runs, place: int) -> list[Complex]:
    """Tracks x + i y (mm) every 40 ms from one start, each turned by its own angle."""
    stride, paths = round(runs.motion.lag_s / runs.tracks.interval), []
    count = min(len(runs.tracks.tracks), MAX_TRACKS)
    for number, track in enumerate(runs.tracks.tracks[:count]):
        assert track.heading is not None
        turn = 2.0 * math.pi * (number + place / 3) / count - track.heading[0]
        at = track.position[::stride] @ np.array([1.0, 1.0j])
        paths.append((at - at[0]) * np.exp(1j * turn))
    return paths


@style()
def mechanism_figure(findings: Findings) -> Figure:
    """Draw a panel for each mechanism: its walker from the side above two bars, two errors long."""
    figure = Figure(figsize=(PAGE_INCHES, 3.8), layout="constrained")
    figure.suptitle("Three ways to run, by theory and simulated; bars: 2 SE")
    grid = figure.subplots(2, len(findings.mechanisms), height_ratios=(1.0, 2.4), squeeze=False)
    for (above, below), mechanism in zip(grid.T, findings.mechanisms, strict=True):
        _draw_profile(above, mechanism)
        look, name = MODELS[mechanism.simulated.model]
        speeds = (mechanism.theory, THEORY_LOOKS["coulomb"]), (mechanism.simulated.speed, look)
        for place, (speed, own) in enumerate(speeds):
            if speed.value is not None:
                below.bar(place, speed.value, 0.6, color=own.colour, yerr=2.0 * (speed.se or 0.0), capsize=4)
        below.set_xticks((0, 1), ("theory", name.replace(", ", ",\n")))
        below.set_xlim(-0.7, 1.7)
        figures.draw_level(below)
    figures.label_axes(grid[1, 0], y="mean speed (mm/s)")
    return figure


def _draw_profile(axes: Axes, mechanism: Mechanism) -> None:
    """Draw a walker of a body in side view, running to the right, its feet with their friction."""
    design = mechanism.design
    side, ground = design.shape.side, min(limb.foot_height for limb in design.limbs)
    assert side is not None  # the mechanisms' bodies are rectangles
    legs = [piece + np.array(limb.anchor) for limb in design.limbs for piece in section_of(limb).profile(limb, 16)]
    axes.add_collection(PolyCollection([side], facecolors=GREY))
    axes.add_collection(PolyCollection(legs, facecolors=INK))
    axes.axhline(ground, color="black", linewidth=0.8)
    small: Any = {"fontsize": MIN_FONT_PT}
    for limb in design.limbs:
        if limb.friction is not None:
            axes.annotate(f"μ {limb.friction:g}", (limb.along, ground - 0.8), ha="center", va="top", **small)
    axes.annotate("", (18.0, 0.0), (14.5, 0.0), arrowprops={"arrowstyle": "->"})
    axes.plot([-18.0, -8.0], [-17.0, -17.0], "|-", color="black", linewidth=0.8)
    axes.annotate("10 mm", (-7.0, -17.0), ha="left", va="center", **small)
    axes.set(xlim=(-19.0, 19.0), ylim=(-18.0, 3.0), aspect="equal")
    axes.set_axis_off()
    axes.set_title(f"{mechanism.what}\n({design.name})", **small)


FIGURES: dict[str, Callable[[Findings], Figure]] = {
    "figure2": figure2,
    "figure5": figure5,
    "figure6": figure6,
    "mechanisms": mechanism_figure,
}
