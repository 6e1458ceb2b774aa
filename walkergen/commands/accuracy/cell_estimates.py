"""Estimates of a walker's speed, scatter and cost from cells, before any simulation.

A cell is a stored measurement of the paper's walker at one tilt and restitution, part of the package (`cells`).

For the paper's walker on its plate at a measured tilt and restitution, the values are those of the cell. For any other
walker they are interpolated between cells and scaled by the plate's speed and frequency, and the walker's own step and
number of legs. A simulated second gives its own speed and cost. Biases follow the law fitted to all cells (`step_law`).
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.commands.accuracy import cells, machine_speed, step_law
from walkergen.commands.accuracy.cells import REFERENCE_STEP_SHARE, Row
from walkergen.commands.accuracy.choice import Candidate
from walkergen.commands.accuracy.step_law import Law
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.run import ENDED_WELL, compile_kernels, simulate
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import run_time, step_errors

STEP_SHARES = (1.25, 1.0, 0.5, 0.25, 0.1)
"""Candidate steps, relative to the step that resolves the feet. Biases below 0.5 are extrapolated from the law."""

LANE_SCENE = "lane-90hz"
"""Scene of the cells that are interpolated."""

SCALED_SCATTER_FACTOR = 1.3
"""Factor of uncertainty of a scaled scatter: root mean square of cross-validation, in which each tilt is left out in
turn."""

CELLS_FREQUENCY_HZ = 90.0
"""Frequency of the plate of the cells, Hz."""

DISCARD_S = 0.4
"""Discarded start of the simulated second of a scaled walker, s."""


class Estimate(NamedTuple):
    """Speed, scatter and cost of a walker in a scene."""

    peak: float
    """Peak speed of the plate, mm/s. For a motor: of a plate that would move under the walker as the motor moves it."""
    speed: float
    """Mean speed, mm/s."""
    variance_time: float
    """Squared standard error of the mean speed times measured time, (mm/s)^2 s."""
    work: Callable[[float], float]
    """Cost of a simulated second, relative to the loop's (`machine_speed`), by the step relative to `own_us`."""
    own_us: float
    """Step that resolves the feet, us."""
    discard_s: float
    """Discarded start of every run, s."""
    cell: tuple[Row, ...]
    """Rows of the cell if this walker on this plate was measured with a reference; otherwise empty."""

    @property
    def unit(self) -> float:
        """Speed that relative errors refer to, mm/s."""
        return step_law.speed_scale(self.speed, self.peak)

    @property
    def law(self) -> Law:
        """Biases of walkers as fast as this one."""
        laws = step_law.fit_laws(step_law.CELLS_PEAK_SPEED_MM_S)
        slow = step_law.is_slow(self.speed, self.peak)
        return laws[slow] if slow in laws else next(iter(laws.values()))

    @property
    def known(self) -> str:
        """Source of the numbers, as one word."""
        return "measured" if self.cell else "scaled"

    def candidates(self, loop_s: float) -> list[Candidate]:
        """Return all candidate steps; `loop_s`: CPU time per simulated second of the benchmark walker here."""
        return [
            Candidate(
                None if step == 1.0 else float(f"{step * self.own_us:.3g}"),
                self.law.bias_bound(step),
                self.variance_time / self.unit**2,
                self.work(step) * loop_s,
                self.discard_s,
            )
            for step in STEP_SHARES
        ]


def estimate(design: Design, scene: Scene) -> Estimate:
    """Estimate speed, scatter and cost of a walker in a scene. One second of a scaled walker is simulated.

    Raises InputError if the scene contradicts itself or the walker.
    """
    run = scene.run.model_copy(update={"step_us": None})
    plan = prepare(scene.model_copy(update={"run": run}), design, solids.mass_of(design))
    found = _estimate_from_cells(plan)
    return found if found.cell else _refine_with_short_run(found, plan)


def _refine_with_short_run(found: Estimate, plan: Plan) -> Estimate:
    """Return the estimate with the walker's own speed and cost, from a simulated second.

    The ratio of scatter to speed is unchanged; so is the estimate if the run takes long or does not end well.
    """
    if run_time.rate_from_steps(plan) > run_time.MAX_START_S:
        return found
    compile_kernels(plan)
    run = simulate(plan.with_run_settings(seconds=machine_speed.LOOP_S, discard_seconds=DISCARD_S), 0)
    if run.outcome not in ENDED_WELL:
        return found
    cost_ratio = run.cpu_s / (machine_speed.LOOP_S + DISCARD_S) / (machine_speed.cpu_per_s() * found.work(1.0))
    speed_ratio = step_law.speed_scale(run.speed, found.peak) / found.unit
    return found._replace(
        speed=abs(run.speed),
        variance_time=speed_ratio**2 * found.variance_time,
        work=lambda step: cost_ratio * found.work(step),
    )


def _estimate_from_cells(plan: Plan) -> Estimate:
    """Estimate speed, scatter and cost of a 3D simulation from the cells, without running it.

    In functions of `steps`, these are a cell's rows by relative step: 1.0 is the step that resolves the feet.
    """
    scene, design = plan.scene, plan.case.design
    all_rows, scene_name = cells.read_rows(), _find_scene(plan)
    tilt, restitution = abs(design.tilt_deg), scene.contact.restitution
    step_s, drive = step_errors.resolving_step(plan), plan.equivalent_drive
    cell = tuple(row for row in all_rows if row.cell == (scene_name, tilt, restitution))
    cell = cell if any(row.share == REFERENCE_STEP_SHARE for row in cell) else ()
    rows = [row for row in all_rows if row.scene == (scene_name if cell else LANE_SCENE)]
    measured_us = _interpolate(rows, lambda steps: steps[1.0].step_us, tilt, restitution)
    relative_work = 1.0 if cell else measured_us / (1e6 * step_s) * 0.5 * len(design.limbs)
    scale = drive.peak_speed / step_law.CELLS_PEAK_SPEED_MM_S
    period_ratio = CELLS_FREQUENCY_HZ / drive.frequency

    def work(step: float) -> float:
        """Return the cost of a simulated second at a step, relative to the benchmark's."""
        return relative_work * _interpolate(
            rows, lambda steps: _fit_work(steps, step), tilt, restitution, logarithmic=True
        )

    return Estimate(
        drive.peak_speed,
        scale * _interpolate(rows, lambda steps: abs(steps[1.0].speed_mm_s or 0.0), tilt, restitution),
        scale**2 * period_ratio * _interpolate(rows, _mean_variance_time, tilt, restitution, logarithmic=True),
        work,
        1e6 * step_s,
        scene.run.discard_seconds,
        cell,
    )


def _fit_work(steps: dict[float, Row], step: float) -> float:
    """Return the cost at a step, from a cell's rows by step: contacts scale with 1/step, flights are constant."""
    shares, works = np.array(list(steps)), np.array([row.work for row in steps.values()])
    terms = np.column_stack([np.ones_like(shares), 1.0 / shares]) / works[:, None]
    flights, contacts = np.linalg.lstsq(terms, np.ones_like(works), rcond=None)[0]
    return float(max(flights, 0.0) + contacts / step)


def _mean_variance_time(steps: dict[float, Row]) -> float:
    """Return the variance times time averaged over a cell's rows, because that of a single row is uncertain."""
    return float(np.mean([row.variance_time for row in steps.values()]))


def _find_scene(plan: Plan) -> str:
    """Return the name of the cells' scene that a plan has, with any restitution; "" without one, or another walker."""
    paper = templates.load(machine_speed.BENCHMARK_WALKER, "walkers", Design).variant(
        tilt_deg=plan.case.design.tilt_deg
    )
    if plan.case.design != paper:
        return ""
    for name in dict.fromkeys(row.scene for row in cells.read_rows()):
        scene = templates.load(name, "scenes", Scene)
        contact = scene.contact.model_copy(update={"restitution": plan.scene.contact.restitution})
        if plan.scene == scene.model_copy(update={"contact": contact, "legs": plan.scene.legs, "run": plan.scene.run}):
            return name
    return ""


def _interpolate(
    rows: Sequence[Row],
    value_of: Callable[[dict[float, Row]], float],
    tilt: float,
    restitution: float,
    logarithmic: bool = False,
) -> float:
    """Interpolate between cells, linearly in tilt and the logarithm of restitution; constant beyond them.

    `value_of` computes the value from a cell's rows by step. `logarithmic`: its logarithm is interpolated.
    """
    cells_rows = step_law.rows_by_cell(rows)
    by_cell = {(cell[0].tilt_deg, cell[0].restitution): {row.share: row for row in cell} for cell in cells_rows}
    tilts, restitutions = (sorted({key[axis] for key in by_cell}) for axis in (0, 1))

    def value_at(tilt_deg: float, feet_restitution: float) -> float:
        """Return the value, or its logarithm, of the cell at a tilt and restitution."""
        value = value_of(by_cell[tilt_deg, feet_restitution])
        return math.log(value) if logarithmic else value

    log_restitution = math.log(max(restitution, 1e-3))
    logs = np.log(restitutions)
    by_tilt = [
        float(np.interp(log_restitution, logs, [value_at(cell_tilt, other) for other in restitutions]))
        for cell_tilt in tilts
    ]
    value = float(np.interp(tilt, tilts, by_tilt))
    return math.exp(value) if logarithmic else value
