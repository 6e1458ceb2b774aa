"""Ensembles that claims need: the paper's walker on its plate, at tilts, contacts and drives."""

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from evidence import landings, paper_simulation
from evidence.validate.claim import Effort
from walkergen.analysis import lag_sums
from walkergen.analysis.landings import CORNERS_PER_FOOT
from walkergen.core.files.progress import silent
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.scene import GRAVITY, Scene, still_plate_drive
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import recorded_impacts
from walkergen.core.simulation.space.state import C_Y, SHOWN_X, SHOWN_Y
from walkergen.core.theory.impact import Kind
from walkergen.core.walker import limbs, solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import experiments, trajectory, walkers

SEED = 2016
"""Seed of the attitudes of drops."""

FRAME_S = 0.01
"""Time between samples of a run, s."""

MAX_DROP_ANGLE = 1e-3
"""Largest pitch and roll of a drop that counts as level, rad."""

DISCARDED_S = 0.5
"""Discarded start of a run, s: some hundred impacts."""


class Measured(NamedTuple):
    """Mean over the runs of an ensemble."""

    speed: Quantity
    """Mean speed, mm/s."""
    types: Quantity
    """Share of types II and III among landings, per cent."""
    landing_speed: float
    """Mean normal speed of landings over the plate's peak speed."""


def paper_design(tilt_deg: float, kind: limbs.Kind = "flexible") -> Design:
    """Design of the paper's walker at a tilt."""
    design = templates.load("koumakis2016", "walkers", Design)
    return design.variant(tilt_deg=tilt_deg, kind=kind)


@cache
def measure_in_space(
    tilt_deg: float, effort: Effort, gamma: float = 1.8, frequency_hz: float = 90.0, kind: limbs.Kind = "flexible"
) -> Measured:
    """Measure a walker on the plane of `plane-90hz`, in space, with the contact as the paper measured it."""
    keys = {"drive.gamma": gamma, "drive.frequency_hz": frequency_hz}
    return _measure_scene(_load_scene("plane-90hz", effort, keys), paper_design(tilt_deg, kind))


@cache
def measure_paper_types(tilt_deg: float, effort: Effort) -> Quantity:
    """Return the share of types II and III among landings of the paper's own model, with the contact that it fitted."""
    design, scene = paper_design(tilt_deg), _load_scene("lane-90hz-fitted", effort, {})
    runs = paper_simulation.simulate(scene, design, solids.mass_of(design))
    return _share_of_types([_select_landings(run.impacts, 1) for run in runs])


def _load_scene(name: str, effort: Effort, keys: Mapping[str, object]) -> Scene:
    """Return a shipped scene with some keys replaced, and the runs of an effort."""
    runs = {"run.seconds": effort.seconds, "run.discard_seconds": DISCARDED_S, "run.runs": effort.runs}
    return templates.load(name, "scenes", Scene).variant(**runs, **keys)


def _measure_scene(scene: Scene, design: Design) -> Measured:
    point = simulate_runs(experiments.Walker(scene, design, solids.mass_of(design), impacts=True))
    landed = [_select_landings(recorded_impacts(result), CORNERS_PER_FOOT) for result in point.results]
    approach = float(-np.concatenate([run.v_y for run in landed]).mean()) / scene.drive.peak_speed
    return Measured(mean_speed(point), _share_of_types(landed), approach)


def _select_landings(rows: Array, corners: int) -> landings.Impacts:
    """Return the landings among the impacts of a run, whose events count so many corners to a foot."""
    impacts = landings.impacts_in(rows)
    landed = landings.find_landings(impacts.time, impacts.foot // corners)
    return landings.Impacts._make(of[landed] for of in impacts)


def _share_of_types(landed: Sequence[landings.Impacts]) -> Quantity:
    """Return the share of types II and III among the landings of runs, %."""
    shares = [100.0 * float(np.isin(run.kind, (Kind.II, Kind.III)).mean()) for run in landed]
    return mean("types", "percent", shares)


def simulate_runs(experiment: experiments.Walker) -> experiments.Results:
    """Results of all runs. Raises KeyboardInterrupt when Ctrl-C left some out."""
    (point,) = walkers.simulate_each([experiment], [""], silent)
    return point


def mean_speed(point: experiments.Results) -> Quantity:
    """Mean speed of the runs, mm/s."""
    return mean("speed", "mm_s", [result.speed for result in point.results])


def exponent(tilt_deg: float, effort: Effort, lag_s: float) -> Quantity:
    """Exponent of the mean square displacement between a lag and twice it, and its error.

    2: a straight run; 1: diffusion. The error is the jackknife's, over runs.
    """
    squares = _squared_displacements(tilt_deg, effort, lag_s)
    total = squares.sum(axis=0)
    without = np.log2((total[1] - squares[:, 1]) / (total[0] - squares[:, 0]))
    n = len(squares)
    error = math.sqrt((n - 1) / n * n * without.var())
    return Quantity("exponent", "", float(np.log2(total[1] / total[0])), error, n - 1)


def _squared_displacements(tilt_deg: float, effort: Effort, lag_s: float) -> Array:
    """Mean square displacement of every run at a lag and at twice it, shape (runs, 2), mm^2."""
    design, scene = paper_design(tilt_deg), _load_scene("plane-90hz", effort, {})
    experiment = experiments.Walker(scene, design, solids.mass_of(design), sample_interval=FRAME_S)
    point = simulate_runs(experiment)
    lags = np.array([1, 2]) * round(lag_s / FRAME_S)
    squares = []
    for result in point.results:
        places = trajectory.sample_rows(result)[:, [1 + SHOWN_X, 1 + SHOWN_Y]]
        total, pairs = lag_sums.sum_squares(np.ascontiguousarray(places), lags)
        squares.append(total / pairs)
    return np.array(squares)


def rebound(tilt_deg: float, drops: int) -> Quantity:
    """Speed after over before the first bounce of walkers dropped level by 1 mm on a plate at rest.

    Mean, and its standard error over the drops, whose pitch and roll differ by up to TOUCH.
    """
    tables = {"drive": still_plate_drive(90.0), "arena": {"kind": "plane"}}
    design = paper_design(tilt_deg)
    plan = prepare(Scene.model_validate(tables), design, solids.mass_of(design))
    fall, rebounds = math.sqrt(2.0 / GRAVITY), []
    for number in range(drops):
        rng = np.random.default_rng([SEED, number])
        pitch, roll = rng.uniform(-MAX_DROP_ANGLE, MAX_DROP_ANGLE, 2)
        state = plan.initial_state(1.0, pitch, 0.0, roll)
        ground = float(state[C_Y]) - 1.0
        heights = []
        plan.advance(state, 1.05 * fall, record.new_tally(len(state)))
        for _ in range(100):
            plan.advance(state, fall / 50.0, record.new_tally(len(state)))
            heights.append(float(state[C_Y]) - ground)
        rebounds.append(math.sqrt(max(*heights, 0.0)))
    return mean("rebound", "", rebounds)
