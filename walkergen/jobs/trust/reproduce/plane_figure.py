"""The paper's figure 6, motion on a plane: squared displacements, tracks, densities at 40 ms."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.motion import Curve
from walkergen.files.figures import SMALLEST
from walkergen.jobs.trust.published import FACTS
from walkergen.jobs.trust.reproduce.compare import LOW, Findings
from walkergen.jobs.trust.reproduce.plane import HALFWAY, SHORTEST, TILTS, Runs

# Okabe and Ito's colours for the tilts, of three greys, each with its own line and marker.
STYLES = dict(zip(TILTS, (("#0072B2", "-", "o"), ("#E69F00", "--", "s"), ("#000000", ":", "^")), strict=True))

GREY: Any = {"color": "0.55", "linewidth": 1.0, "zorder": 0}

MOST_TRACKS = 8
"""Largest number of tracks drawn for a tilt."""


def draw(figure: Figure, findings: Findings) -> None:
    """Draw what is known of the walkers with the low restitution into an empty figure."""
    plane = [runs for runs in findings.plane if runs.assumption == LOW]
    (low,) = (assumption for assumption in findings.assumptions if assumption.name == LOW)
    grid = figure.add_gridspec(2, 4)
    squares, slopes = (figure.add_subplot(grid[0, 2 * n : 2 * n + 2]) for n in range(2))
    fast, slow, along, across = (figure.add_subplot(grid[1, n]) for n in range(4))
    _squares(squares, plane)
    _slopes(slopes, plane)
    _tracks(fast, [runs for runs in plane if runs.tilt_deg != TILTS[-1]])
    _tracks(slow, [runs for runs in plane if runs.tilt_deg == TILTS[-1]])
    for axes, name in ((along, "parallel"), (across, "orthogonal")):
        _densities(axes, plane, name)
    for axes, letter in zip((squares, fast, along), "abc", strict=True):
        axes.set_title(f"({letter})", loc="left")
    figure.suptitle(f"Motion on a plane, {low.label}")
    figure.legend(*squares.get_legend_handles_labels(), loc="outside lower center", ncols=5)


def _curve(axes: Axes, curve: Curve, tilt: float, **more: Any) -> None:
    colour, line, marker = STYLES[tilt]
    errors = 2.0 * np.nan_to_num(curve.se)
    axes.errorbar(
        curve.at,
        curve.value,
        errors,
        fmt=marker,
        linestyle=line,
        color=colour,
        markersize=3.5,
        markerfacecolor="white",
        linewidth=0.9,
        elinewidth=0.8,
        **more,
    )


def _squares(axes: Axes, shown: Sequence[Runs]) -> None:
    """Draw mean squared displacements, and guides of slopes 2 and 1 through one point."""
    for runs in shown:
        positive = runs.motion.msd.value > 0.0
        curve = Curve(*(column[positive] for column in runs.motion.msd))
        _curve(axes, curve, runs.tilt_deg, label=f"{runs.tilt_deg:g} deg")
    axes.set_xscale("log")
    axes.set_yscale("log")
    limits = axes.get_xlim(), axes.get_ylim()
    time = np.geomspace(SHORTEST, limits[0][1], 2)
    slow = shown[-1].motion.msd if shown else None
    if slow is not None and (slow.value > 0.0).any():
        # Of the slow walker at the paper's crossover: both guides then show which way it turns.
        crossing = FACTS["crossover at 35"].value
        height = 2.5 * float(np.interp(crossing, slow.at, slow.value))
        for power, line in ((2, "--"), (1, "-.")):
            axes.plot(time, height * (time / crossing) ** power, line, **GREY, label=f"∝ t{'²' if power == 2 else ''}")
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    axes.set_xlabel("lag t (s)")
    axes.set_ylabel("mean squared displacement (mm²)")


def _slopes(axes: Axes, shown: Sequence[Runs]) -> None:
    """Draw local exponents, and the paper's crossover of the slow walker."""
    for runs in shown:
        _curve(axes, runs.growth.exponents, runs.tilt_deg)
    for power, line in ((2.0, "--"), (1.0, "-.")):
        axes.axhline(power, linestyle=line, **GREY)
    fact = FACTS["crossover at 35"]
    axes.errorbar(
        [fact.value],
        [HALFWAY],
        xerr=[[fact.value - fact.low], [fact.high - fact.value]],
        fmt="*",
        color="black",
        markersize=10,
        elinewidth=1.0,
    )
    axes.annotate(
        "the paper's crossover, 35 deg",
        (fact.value, HALFWAY),
        (0, 8),
        textcoords="offset points",
        ha="center",
        fontsize=SMALLEST,
    )
    axes.set_xscale("log")
    axes.set_ylim(0.8, 2.1)
    axes.set_xlabel("lag t (s)")
    axes.set_ylabel("local exponent of the MSD")


def _tracks(axes: Axes, shown: Sequence[Runs]) -> None:
    """Draw tracks from one start, each turned by its own angle."""
    for runs in shown:
        _star(axes, runs)
    axes.plot(0.0, 0.0, "+", color="0.4", markersize=6)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")


def _star(axes: Axes, runs: Runs) -> None:
    colour, _, _ = STYLES[runs.tilt_deg]
    paths = [_path(runs, number) for number in range(min(len(runs.tracks.tracks), MOST_TRACKS))]
    for number, path in enumerate(paths):
        turned = path * np.exp(2j * math.pi * (number + TILTS.index(runs.tilt_deg) / 3) / len(paths))
        axes.plot(turned.real, turned.imag, color=colour, linewidth=0.9)


def _path(runs: Runs, number: int) -> npt.NDArray[np.complex128]:
    """Track x + i y (mm) from its start, its heading there along x, every 40 ms."""
    track = runs.tracks.tracks[number]
    assert track.heading is not None
    place = track.position @ np.array([1.0, 1.0j])
    stride = round(runs.motion.lag_s / runs.tracks.interval)
    path: npt.NDArray[np.complex128] = (place - place[0]) * np.exp(-1j * track.heading[0])
    return path[::stride]


def _densities(axes: Axes, shown: Sequence[Runs], name: str) -> None:
    """Draw densities of displacements along or across the heading over 40 ms."""
    for runs in shown:
        curve: Curve = getattr(runs.motion, name)
        colour, line, _ = STYLES[runs.tilt_deg]
        axes.plot(curve.at, curve.value, line, color=colour, drawstyle="steps-mid", linewidth=1.1)
        errors = 2.0 * np.nan_to_num(curve.se)
        axes.fill_between(
            curve.at,
            np.maximum(curve.value - errors, 0.0),
            curve.value + errors,
            step="mid",
            color=colour,
            alpha=0.2,
            linewidth=0,
        )
    way = {"parallel": "along", "orthogonal": "across"}[name]
    axes.set_xlabel(f"{way} heading (mm)")  # as wide as the panel, at most
    axes.set_ylabel("density over 40 ms (1/mm)")
    axes.set_ylim(bottom=0.0)
