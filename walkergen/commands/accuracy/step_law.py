"""Law of the step's bias: the error of the speed against the step, fitted to all cells together.

Within each cell the speeds are a straight line in a power of the step. Its slope over the speed is the cell's result.
Slopes of cells scatter by more than their errors. The excess is estimated as between studies of a meta-analysis (R.
DerSimonian and N. Laird, Control. Clin. Trials 7, 177, 1986). Landings err by the first power of the step, flight and
sliding by the second (docs/physics.md section 5). Both powers are fitted, and the larger bound counts.
"""

import math
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import groupby
from typing import NamedTuple

import numpy as np

from walkergen.commands.accuracy import cells
from walkergen.commands.accuracy.cells import REFERENCE_STEP_SHARE, Row
from walkergen.core.numerics.quantity import Quantity
from walkergen.points.walkers import MIN_SPEED_RATIO

CELLS_PEAK_SPEED_MM_S = 31.2
"""Peak speed of the plate of the cells, mm/s: 90 Hz and 1.8 g."""

STEP_POWERS = (1, 2)
"""Powers of the step in the fitted laws of the bias."""


class Slope(NamedTuple):
    """Bias at the step that resolves the feet, as a share of the speed, with its errors."""

    power: int
    share: Quantity
    between: float
    """Standard deviation between walkers."""
    misfit: float
    """Chi-square of the lines over its degrees of freedom: about 1 where the law holds."""

    def bias_bound(self, step: float) -> float:
        """Return the largest bias (95 %), as a share. `step` is relative to the step that resolves the feet."""
        share, se = self.share.pair
        se *= math.sqrt(max(self.misfit, 1.0))  # a misfit of the line widens its error
        return float((abs(share) + 2.0 * math.hypot(se, self.between)) * step**self.power)


class Law(NamedTuple):
    """Biases of a group of similar walkers: as fast as the plate, or slow compared with it."""

    slopes: tuple[Slope, ...]
    """One a power."""
    floor: float
    """Error (95 %) of all references together, as a share. No smaller bias can be measured."""
    cells: int
    """Number of cells behind it."""

    def bias_bound(self, step: float) -> float:
        """Return the largest bias (95 %), as a share, over both powers."""
        return max(slope.bias_bound(step) for slope in self.slopes)


def speed_scale(speed: float, peak: float) -> float:
    """Return the speed that relative errors refer to: the walker's, or a fifth of the plate's if it is slower."""
    return max(abs(speed), MIN_SPEED_RATIO * peak)


def rows_by_cell(rows: Iterable[Row]) -> list[list[Row]]:
    """Group the rows that have a speed and its error by cell, finest step first."""
    known = [row for row in rows if row.speed_mm_s is not None and row.se_mm_s]
    return [list(cell) for _, cell in groupby(known, key=lambda row: row.cell)]


@cache
def fit_laws(peak: float, rows: tuple[Row, ...] | None = None) -> dict[bool, Law]:
    """Fit the laws of the bias to cells, for slow walkers (True) and others; plate's `peak` speed, mm/s."""
    referenced = [
        cell
        for cell in rows_by_cell(cells.read_rows() if rows is None else rows)
        if cell[0].share == REFERENCE_STEP_SHARE
    ]
    by_slowness: dict[bool, list[list[Row]]] = {True: [], False: []}
    for cell in referenced:
        by_slowness[is_slow(cell[0].speed_mm_s or 0.0, peak)].append(cell)
    return {key: _fit_law(group, peak) for key, group in by_slowness.items() if group}


def is_slow(speed: float, peak: float) -> bool:
    """Return whether a walker is so slow that its errors are shares of the plate's peak speed."""
    return abs(speed) < MIN_SPEED_RATIO * peak


def _fit_law(group: Sequence[Sequence[Row]], peak: float) -> Law:
    """Fit the speed's bias, by powers of the time step, to cells: one walker in one scene at several steps each.

    `group`: rows of each cell, the finest step first. `peak`: peak speed of the plate, mm/s.
    """
    finest = [(row.se_mm_s or 0.0) / speed_scale(row.speed_mm_s or 0.0, peak) for row in (cell[0] for cell in group)]
    floor = 2.0 / math.sqrt(sum(se**-2 for se in finest))
    return Law(tuple(_fit_slope(group, peak, power) for power in STEP_POWERS), floor, len(group))


def _fit_slope(group: Sequence[Sequence[Row]], peak: float, power: int) -> Slope:
    """Average the slopes of a group of cells for a power of the step, with the scatter between cells."""
    lines = [_fit_line(cell, peak, power) for cell in group]
    share, se = (np.array(column) for column in zip(*(line[:2] for line in lines), strict=True))
    weights, freedom = se**-2.0, len(lines) - 1
    mean = float(np.sum(weights * share) / np.sum(weights))
    excess = float(np.sum(weights * (share - mean) ** 2)) - freedom
    weight_scale = float(np.sum(weights) - np.sum(weights**2) / np.sum(weights))
    between = math.sqrt(max(excess / weight_scale, 0.0)) if freedom else 0.0
    weights = 1.0 / (se**2 + between**2)
    mean = float(np.sum(weights * share) / np.sum(weights))
    misfit = sum(line[2] for line in lines) / max(sum(line[3] for line in lines), 1)  # chi-square over freedom
    return Slope(power, Quantity("bias", "", mean, float(np.sum(weights) ** -0.5)), between, misfit)


def _fit_line(cell: Sequence[Row], peak: float, power: int) -> tuple[float, float, float, int]:
    """Fit a line to the speeds of a cell (one walker at several time steps) against a power of the step.

    The step is the share of the default step. `peak` is the plate's peak speed, mm/s. Return the slope over the speed,
    its standard error, chi-square and its degrees of freedom.
    """
    steps = np.array([row.share for row in cell]) ** power
    speeds, errors = (np.array([getattr(row, name) for row in cell]) for name in ("speed_mm_s", "se_mm_s"))
    design = np.column_stack([np.ones_like(steps), steps]) / errors[:, None]
    covariance = np.linalg.inv(design.T @ design)
    offset, slope = covariance @ design.T @ (speeds / errors)
    chi2 = float(np.sum(((speeds - offset - slope * steps) / errors) ** 2))
    size = speed_scale(float(offset), peak)
    return float(slope) / size, math.sqrt(float(covariance[1, 1])) / size, chi2, len(cell) - 2
