"""The paper's figures 2, 5 and 6 with our curves, its statements on the same axes, and the mechanisms."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from walkergen.analysis.growth import HALFWAY
from walkergen.files.figures import PAGE, SMALLEST, style, wrapped
from walkergen.jobs.trust.published import FACTS
from walkergen.jobs.trust.reproduce.compare import LOW, Findings
from walkergen.jobs.trust.reproduce.curves import lively, series_of, through_zero
from walkergen.jobs.trust.reproduce.mechanisms import Mechanism
from walkergen.jobs.trust.reproduce.motion import Runs
from walkergen.jobs.trust.reproduce.runs import Assumption, Point
from walkergen.jobs.trust.reproduce.theory import Theory

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
TILTS = (("#0072B2", "-", "o"), ("#E69F00", "--", "s"), ("#000000", ":", "^"))
"""Colour, line and marker of the walkers of figure 6."""
STAR: Any = {"marker": "*", "color": "black", "markersize": 9, "linestyle": "none", "markerfacecolor": "white"}
BAR: Any = {"fmt": "none", "ecolor": "black", "elinewidth": 1.0, "zorder": 2}
GREY: Any = {"color": "0.55", "linewidth": 1.0, "zorder": 0}
PANEL_INCHES = 2.0
"""Width of a panel of three side by side."""
ROOM = 1.15
"""Upper end of the axes over the largest simulated speed; the theory may exceed it."""
MOST_TRACKS = 8
"""Largest number of tracks drawn for a tilt."""


@style()
def figure2(findings: Findings) -> Figure:
    """Draw speed against tilt: a panel for each set of contact numbers."""
    figure, panels = _panels(findings, findings.tilts, "Speed against tilt, as in the paper's figure 2")
    tilt, speed, braced = FACTS["peak tilt"], FACTS["peak speed"], FACTS["braced"]
    margins: Any = {
        "xerr": [[tilt.value - tilt.low], [tilt.high - tilt.value]],
        "yerr": [[speed.value - speed.low], [speed.high - speed.value]],
    }
    for axes, assumption in panels:
        for theory in findings.theories:
            if theory.assumption == assumption.name:
                colour, line = THEORY[theory.mode]
                at, height, sd, _ = theory.curve
                axes.plot(at, height, line, color=colour, linewidth=1.2, label=theory.label)
                axes.fill_between(at, height - sd, height + sd, color=colour, alpha=0.18, linewidth=0)
        _draw_points(axes, [p for p in findings.tilts if p.assumption == assumption], "tilt_deg")
        axes.errorbar([tilt.value], [speed.value], **margins, **BAR)
        axes.plot([tilt.value], [speed.value], label="the paper's stated peak", zorder=2, **STAR)
        name = "the paper's braced walkers: no significant speed"
        axes.axhspan(braced.low, braced.high, color="0.8", linewidth=0, zorder=-1, label=name)
        axes.set_xlabel("tilt of the legs (deg)")
    panels[0][0].set_ylabel("mean speed (mm/s)")
    return _with_legend(figure, panels[0][0])


@style()
def figure5(findings: Findings) -> Figure:
    """Draw speed against the plate's speed: points with errors, thin lines through zero."""
    figure, panels = _panels(findings, findings.drives, "Speed against the plate's speed, as in the paper's figure 5")
    star = f"the paper's stated peak (at {FACTS['peak tilt'].value:g} deg)"
    for axes, assumption in panels:
        points, drive = [p for p in findings.drives if p.assumption == assumption], assumption.scene.drive
        end = 1.05 * max(point.plate_speed_mm_s for point in points)
        _draw_lines(axes, points, drive.peak_speed, end)
        for theory in findings.theories:
            if theory.assumption == assumption.name and theory.mode == "coulomb":
                _draw_theory_line(axes, theory, points[0].tilt_deg, drive.peak_speed, end)
        _draw_points(axes, points, "plate_speed_mm_s", joined=False)
        axes.plot([drive.peak_speed], [FACTS["peak speed"].value], zorder=5, label=star, **STAR)
        axes.set_xlim(0.0, end)
        axes.set_xlabel("peak speed of the plate (mm/s)")
    panels[0][0].set_ylabel(f"mean speed at {findings.drives[0].tilt_deg:g} deg (mm/s)")
    return _with_legend(figure, panels[0][0])


def _panels(findings: Findings, points: Sequence[Point], title: str) -> tuple[Figure, list[tuple[Axes, Assumption]]]:
    """Figure with a panel for each assumption, as high as the largest simulated speed."""
    figure = Figure(figsize=(PAGE, 3.9), layout="constrained")
    figure.suptitle(title)
    panels = list(zip(figure.subplots(1, len(findings.assumptions), sharey=True), findings.assumptions, strict=True))
    for axes, assumption in panels:
        axes.set_title(wrapped(assumption.label, PANEL_INCHES, SMALLEST), fontsize=SMALLEST)
    highest = ROOM * max([FACTS["peak speed"].high, *(point.speed.value or 0.0 for point in points)])
    panels[0][0].set_ylim(-0.08 * highest, highest)
    return figure, panels


def _with_legend(figure: Figure, axes: Axes, columns: int = 3) -> Figure:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns)
    return figure


def _draw_points(axes: Axes, points: Sequence[Point], along: str, joined: bool = True) -> None:
    """Draw simulated speeds with bars of two standard errors, joined along the axis or alone."""
    for series in series_of(points):
        colour, line, marker, label = MODELS[series[0].model]
        known = [point for point in series if point.speed.value is not None]
        if known:
            x = [getattr(point, along) for point in known]
            heights, errors = np.array([(p.speed.value, 2.0 * (p.speed.se or 0.0)) for p in known]).T
            look: Any = {"markerfacecolor": "white", "linewidth": 0.8, "capsize": 2, "zorder": 3, "fmt": marker}
            linestyle = line if joined else "none"
            axes.errorbar(x, heights, errors, linestyle=linestyle, color=colour, label=label, **look)


def _draw_lines(axes: Axes, points: Sequence[Point], drive: float, end: float) -> None:
    """Draw lines through zero, of walkers in space through the points from figure 2's drive up.

    A band shows two standard errors of the slope; lines say no more than their points.
    """
    name: str | None = "through zero, ± 2 SE (in space: of those that run)"
    for series in series_of(points):
        colour, line, *_ = MODELS[series[0].model]
        in_space = series[0].model == "space"
        slope = through_zero(lively(series, drive) if in_space else series)
        if slope.value is not None and slope.se is not None:
            x = np.array([drive if in_space else 0.0, end])
            axes.plot(x, slope.value * x, line, color=colour, linewidth=0.7, zorder=2, label=name)
            low, high = ((slope.value + sign * 2.0 * slope.se) * x for sign in (-1.0, 1.0))
            axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0, zorder=1)
            name = None


def _draw_theory_line(axes: Axes, theory: Theory, tilt_deg: float, drive: float, end: float) -> None:
    """Draw the theory's line: proportional to the plate's speed by construction."""
    colour, line = THEORY[theory.mode]
    speed = np.interp(tilt_deg, theory.curve.tilt_deg, theory.curve.speed)
    axes.plot([0.0, end], [0.0, speed * end / drive], line, color=colour, linewidth=1.2, label=theory.label)


@style()
def figure6(findings: Findings) -> Figure:
    """Draw motion on a plane, with the low restitution: displacements, exponents, tracks, densities."""
    plane = [runs for runs in findings.plane if runs.assumption == LOW]
    (low,) = (assumption for assumption in findings.assumptions if assumption.name == LOW)
    figure = Figure(figsize=(PAGE, 5.6), layout="constrained")
    figure.suptitle(f"Motion on a plane, {low.label}")
    (squares, slopes), (tracks, densities) = figure.subplots(2, 2)
    for runs, (colour, line, marker) in zip(plane, TILTS, strict=False):
        look: Any = {"fmt": marker, "linestyle": line, "color": colour, "markersize": 3.5, "markerfacecolor": "white"}
        look |= {"linewidth": 0.9, "elinewidth": 0.8}
        for axes, curve in ((squares, runs.motion.msd), (slopes, runs.growth.exponents)):
            shown = curve.value > 0.0
            errors = 2.0 * np.nan_to_num(curve.se)
            axes.errorbar(curve.at[shown], curve.value[shown], errors[shown], label=f"{runs.tilt_deg:g} deg", **look)
        for width, curve in ((1.4, runs.motion.parallel), (0.7, runs.motion.orthogonal)):
            densities.plot(curve.at, curve.value, line, color=colour, drawstyle="steps-mid", linewidth=width)
        for path in _star(runs, TILTS.index((colour, line, marker))):
            tracks.plot(path.real, path.imag, color=colour, linewidth=0.9)
    _dress_slopes(squares, slopes, plane)
    tracks.set_aspect("equal", adjustable="datalim")
    tracks.set(xlabel="x (mm)", ylabel="y (mm)")
    densities.set(xlabel="along and across the heading (mm)", ylabel="density over 40 ms (1/mm)")
    densities.set_ylim(bottom=0.0)
    for axes, letter in zip((squares, slopes, tracks, densities), "abcd", strict=True):
        axes.set_title(f"({letter})", loc="left")
    return _with_legend(figure, squares, columns=5)


def _dress_slopes(squares: Axes, slopes: Axes, plane: Sequence[Runs]) -> None:
    """Draw guides of slopes 2 and 1, and the paper's crossover of the slow walker."""
    fact = FACTS["crossover at 35"]
    for axes in (squares, slopes):
        axes.set_xscale("log")
        axes.set_xlabel("lag t (s)")
    squares.set_yscale("log")
    limits = squares.get_xlim(), squares.get_ylim()
    slow = plane[-1].motion.msd if plane else None
    for power, line, name in ((2, "--", "∝ t²"), (1, "-.", "∝ t")):
        slopes.axhline(power, linestyle=line, **GREY)
        if slow is not None and (slow.value > 0.0).any():
            height = 2.5 * float(np.interp(fact.value, slow.at, slow.value))
            time = np.geomspace(*limits[0], 2)
            squares.plot(time, height * (time / fact.value) ** power, line, label=name, **GREY)
    squares.set(xlim=limits[0], ylim=limits[1], ylabel="mean squared displacement (mm²)")
    slopes.errorbar([fact.value], [HALFWAY], xerr=[[fact.value - fact.low], [fact.high - fact.value]], **BAR)
    slopes.plot([fact.value], [HALFWAY], **STAR)
    slopes.set(ylim=(0.8, 2.1), ylabel="local exponent of the MSD")


def _star(runs: Runs, place: int) -> list[npt.NDArray[np.complex128]]:
    """Tracks x + i y (mm) every 40 ms from one start, each turned by its own angle."""
    stride, paths = round(runs.motion.lag_s / runs.tracks.interval), []
    count = min(len(runs.tracks.tracks), MOST_TRACKS)
    for number, track in enumerate(runs.tracks.tracks[:count]):
        assert track.heading is not None
        turn = 2.0 * math.pi * (number + place / 3) / count - track.heading[0]
        at = track.position[::stride] @ np.array([1.0, 1.0j])
        paths.append((at - at[0]) * np.exp(1j * turn))
    return paths


@style()
def mechanisms(findings: Findings) -> Figure:
    """Draw a panel for each mechanism: its walker from the side above two bars, two errors long."""
    figure = Figure(figsize=(PAGE, 3.8), layout="constrained")
    figure.suptitle("Three ways to run, by theory and simulated; bars: 2 SE")
    grid = figure.subplots(2, len(findings.mechanisms), height_ratios=(1.0, 2.4), squeeze=False)
    for (above, below), mechanism in zip(grid.T, findings.mechanisms, strict=True):
        _profile(above, mechanism)
        colour, *_, name = MODELS[mechanism.simulated.model]
        for place, speed in enumerate((mechanism.theory, mechanism.simulated.speed)):
            if speed.value is not None:
                fill = (THEORY["coulomb"][0], colour)[place]
                below.bar(place, speed.value, 0.6, color=fill, yerr=2.0 * (speed.se or 0.0), capsize=4)
        below.set_xticks((0, 1), ("theory", name.replace(", ", ",\n")))
        below.set_xlim(-0.7, 1.7)
        below.axhline(0.0, color="black", linewidth=0.6)
    grid[1, 0].set_ylabel("mean speed (mm/s)")
    return figure


def _profile(axes: Axes, mechanism: Mechanism) -> None:
    """Draw a walker of a body in side view, running to the right, its feet with their friction."""
    design = mechanism.design
    side, ground = design.body.shape.side, min(limb.foot_height for limb in design.limbs)
    assert side is not None  # the mechanisms' bodies are rectangles
    legs = [piece + np.array(limb.anchor) for limb in design.limbs for piece in limb.section.profile(limb, 16)]
    axes.add_collection(PolyCollection([side], facecolors="0.55"))
    axes.add_collection(PolyCollection(legs, facecolors="0.25"))
    axes.axhline(ground, color="black", linewidth=0.8)
    for limb in design.limbs:
        if limb.friction is not None:
            at = (limb.along, ground - 0.8)
            axes.annotate(f"μ {limb.friction:g}", at, ha="center", va="top", fontsize=SMALLEST)
    axes.annotate("", (18.0, 0.0), (14.5, 0.0), arrowprops={"arrowstyle": "->"})
    axes.plot([-18.0, -8.0], [-17.0, -17.0], "|-", color="black", linewidth=0.8)
    axes.annotate("10 mm", (-7.0, -17.0), ha="left", va="center", fontsize=SMALLEST)
    axes.set(xlim=(-19.0, 19.0), ylim=(-18.0, 3.0), aspect="equal")
    axes.set_axis_off()
    axes.set_title(f"{mechanism.what}\n({design.name})", fontsize=SMALLEST)


FIGURES: dict[str, Callable[[Findings], Figure]] = {
    "figure2": figure2,
    "figure5": figure5,
    "figure6": figure6,
    "mechanisms": mechanisms,
}
