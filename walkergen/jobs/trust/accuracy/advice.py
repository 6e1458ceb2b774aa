"""Advice from what is shipped: which model, step, runs and seconds an error takes, before anything is simulated.

For the paper's walker on its plate at a tilt and a restitution that were measured, speed, scatter and cost are those of
the cell; for any other they are scaled: read between cells, and from the plate's speed, its frequency, the walker's
own step and its number of legs. Biases by the step are the law's, of all cells together (`step_law`).
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.files import words
from walkergen.jobs.trust.accuracy import cells, step_law
from walkergen.jobs.trust.accuracy.cells import REFERENCE, Row
from walkergen.jobs.trust.accuracy.setting import Setting
from walkergen.jobs.trust.accuracy.step_law import Law
from walkergen.numerics.tails import student
from walkergen.points.tolerance import Tolerance
from walkergen.simulation import resolution
from walkergen.simulation.plan import Plan

STEPS = (1.25, 1.0, 0.5, 0.25, 0.1)
"""Steps over that which resolves the feet, of which is chosen: the next longer one was measured as well; those below
0.5 are beyond what was measured, by the law."""

RUNS, SHORTEST_S = (8, 16, 32), 1.0
"""Numbers of runs of which is chosen, and the shortest that a run is measured, s."""

SLACK = 1.2
"""Factor by which more time is bought than the scatter needs, since it is itself estimated."""

BIAS_PART = 0.7
"""Part of the error that a bias may take up."""

START_S = 1.2
"""Time in which a command starts, on an idle machine, s: imports, and kernels read from the cache."""

LANE = "lane-90hz"
"""Scene of the cells between which is read."""

SCALED_WITHIN = 1.3
"""Factor to which the scatter of what is scaled is known: the root mean square of that by which a tilt which is left
out scatters otherwise, for its speed, than is read between its neighbours."""

MEASURED_DRIVE = 90.0, 1.8
"""Frequency (Hz) and peak acceleration (g) of the plate of the cells."""


class Place(NamedTuple):
    """What the shipped data say of a walker in a scene."""

    peak: float
    """Peak speed of the plate, or of one that would move under the walker as its motor moves it, mm/s."""
    speed: float
    """Mean speed, mm/s."""
    variance_time: float
    """Squared standard error of the mean speed times measured time, (mm/s)^2 s."""
    work: Callable[[float], float]
    """Cost of a step (over what resolves the feet) of a simulated second, over that of the loop (`pace`)."""
    own_us: float
    """Step that resolves the feet, us."""
    discard_s: float
    """Start of every run that is not measured, s."""
    cell: tuple[Row, ...]
    """Rows of the cell, where this walker on this plate was measured beside a reference; else none."""

    @property
    def law(self) -> Law:
        """Biases of walkers as fast as this one."""
        laws = step_law.laws(step_law.CELLS_PEAK)
        slow = step_law.is_slow(self.speed, self.peak)
        return laws[slow] if slow in laws else next(iter(laws.values()))

    @property
    def known(self) -> str:
        """Word on where the numbers come from."""
        return "measured" if self.cell else "scaled"


class Advice(NamedTuple):
    """Setting that meets an error, and the runs that it needs."""

    setting: Setting
    runs: int
    seconds: float
    """Measured time of each run."""
    bias: float
    """Largest bias (95 %), mm/s."""
    se: float
    """Standard error that the runs will have, mm/s."""
    error: float
    """Error (95 %) that bias and runs will have together, mm/s."""
    work: float
    """CPU time of all runs over that of a simulated second of the loop."""

    def takes_s(self, pace: float, cores: int) -> float:
        """Time by the clock that the command takes on an idle machine of this pace (`pace`)."""
        return START_S + self.work / self.runs * math.ceil(self.runs / cores) * pace


def place(plan: Plan) -> Place:
    """What the shipped data say of a plan."""
    scene, design = plan.scene, plan.case.design
    every, measured = cells.read(), _measured(plan)
    tilt, restitution = abs(design.tilt_deg), scene.contact.restitution
    own_s, drive = resolution.own_step(plan), plan.shaken
    cell = tuple(row for row in every if row.cell == (measured, tilt, restitution))
    cell = cell if any(row.share == REFERENCE for row in cell) else ()
    rows = [row for row in every if row.scene == (measured if cell else LANE)]
    measured_us = _between(rows, lambda of: of[1.0].step_us, tilt, restitution)
    harder = measured_us / (1e6 * own_s) * 0.5 * len(design.limbs)
    if cell:
        harder = 1.0
    scale = drive.peak_speed / step_law.CELLS_PEAK
    slower = MEASURED_DRIVE[0] / drive.frequency

    def work(step: float) -> float:
        return harder * _between(rows, lambda of: _work(of, step), tilt, restitution, logarithmic=True)

    return Place(
        drive.peak_speed,
        scale * _between(rows, lambda of: abs(of[1.0].speed_mm_s or 0.0), tilt, restitution),
        scale**2 * slower * _between(rows, _scatter, tilt, restitution, logarithmic=True),
        work,
        1e6 * own_s,
        scene.run.discard_seconds,
        cell,
    )


def _work(steps: dict[float, Row], step: float) -> float:
    """Cost of a step in a cell: steps in contact, as many as they are short, and flights; all its rows have a say."""
    shares, works = np.array(list(steps)), np.array([row.work for row in steps.values()])
    terms = np.column_stack([np.ones_like(shares), 1.0 / shares]) / works[:, None]
    flights, contacts = np.linalg.lstsq(terms, np.ones_like(works), rcond=None)[0]
    return float(max(flights, 0.0) + contacts / step)


def _scatter(steps: dict[float, Row]) -> float:
    """Variance times time of a cell, over all its steps: the scatter of eight runs is itself known badly."""
    return float(np.mean([row.variance_time for row in steps.values()]))


def _measured(plan: Plan) -> str:
    """Name of the cells' scene that a plan has, but for its restitution; "" for others, and for another walker."""
    from walkergen.files import templates
    from walkergen.jobs.trust.accuracy.pace import WALKER
    from walkergen.scene import Scene
    from walkergen.walker.design import Design

    paper = templates.load(WALKER, "walkers", Design).variant(tilt_deg=plan.case.design.tilt_deg)
    if plan.case.design != paper:
        return ""
    for name in dict.fromkeys(row.scene for row in cells.read()):
        scene = templates.load(name, "scenes", Scene)
        contact = scene.contact.model_copy(update={"restitution": plan.scene.contact.restitution})
        if plan.scene == scene.model_copy(update={"contact": contact, "legs": plan.scene.legs, "run": plan.scene.run}):
            return name
    return ""


def _between(
    rows: Sequence[Row],
    of: Callable[[dict[float, Row]], float],
    tilt: float,
    restitution: float,
    logarithmic: bool = False,
) -> float:
    """Number of a cell, linear in the tilt and the logarithm of the restitution between cells, constant beyond them."""
    by_cell = {cell[0][1:3]: {row.share: row for row in cell} for cell in step_law.known_rows(rows)}
    tilts, restitutions = (sorted({key[at] for key in by_cell}) for at in (0, 1))

    def number(own_tilt: float, own_restitution: float) -> float:
        found = of(by_cell[own_tilt, own_restitution])
        return math.log(found) if logarithmic else found

    by_tilt = [
        float(
            np.interp(
                math.log(max(restitution, 1e-3)), np.log(restitutions), [number(own, one) for one in restitutions]
            )
        )
        for own in tilts
    ]
    found = float(np.interp(tilt, tilts, by_tilt))
    return math.exp(found) if logarithmic else found


def advise(at: Place, wanted: Tolerance) -> Advice | str:
    """Cheapest setting that meets an error; the reason in a line where none does."""
    size = step_law.unit(at.speed, at.peak)
    allowed = wanted.value * size if wanted.relative else wanted.value
    found = list(_offers(at, allowed))
    if not found:
        least = words.number(100.0 * at.law.bound(STEPS[-1]) / BIAS_PART, 2)
        return f"below {least} % the shipped cells know no step: simulate --error {wanted} finds its own"
    return min(found, key=lambda one: one.work)


def _offers(at: Place, allowed: float) -> Iterator[Advice]:
    """Offers of all steps whose bias is within an error."""
    for step in STEPS:
        bias = at.law.bound(step) * step_law.unit(at.speed, at.peak)
        if bias <= BIAS_PART * allowed:
            us = None if step == 1.0 else float(f"{step * at.own_us:.3g}")
            yield _offer(at, Setting(us), allowed, bias, at.variance_time, at.work(step))


def _offer(at: Place, setting: Setting, allowed: float, bias: float, variance_time: float, work: float) -> Advice:
    """Offer of a setting: the number of runs that costs least."""
    offers = [_runs(at, setting, allowed, bias, variance_time, work, runs) for runs in RUNS]
    return min(offers, key=lambda one: one.work)


def _runs(
    at: Place, setting: Setting, allowed: float, bias: float, variance_time: float, work: float, runs: int
) -> Advice:
    """Offer of a setting with a number of runs: half-widths of bias and scatter add in squares, as bounds do."""
    wide = student(runs - 1.0, 0.975)
    variance = (allowed**2 - bias**2) / wide**2
    seconds = _up(max(SLACK * variance_time / variance / runs, SHORTEST_S))
    se = math.sqrt(variance_time / (runs * seconds))
    total = runs * (seconds + at.discard_s)
    return Advice(setting, runs, seconds, bias, se, math.hypot(bias, wide * se), total * work)


def _up(seconds: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return float(f"{math.ceil(seconds / digit - 1e-9) * digit:.2g}")
