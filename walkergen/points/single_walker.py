"""Points of the kind ALONE (see `model_kinds`), a walker alone: masses, predicted speed, results of a simulation."""

import time
from collections.abc import Sequence

from walkergen.analysis.estimates import ALIGNMENT_NAMES, UNITS
from walkergen.core.errors import InputError
from walkergen.core.printing import checks
from walkergen.core.printing.findings import group_findings as in_order
from walkergen.core.printing.printers import Printer
from walkergen.core.simulation import observables
from walkergen.core.simulation.ensemble import Summary, format_outcomes
from walkergen.core.simulation.run import ENDED_WELL, Outcome
from walkergen.core.theory.prediction import Prediction
from walkergen.core.walker import solids, weighed_masses
from walkergen.core.walker.mass import MassProperties
from walkergen.points import run_time, short_simulation, speed_prediction, step_errors, walkers
from walkergen.points.effect_selection import find_simplest
from walkergen.points.experiments import Results, Walker
from walkergen.points.model_kinds import Picture
from walkergen.points.point import PREDICTION, SPACE, Point, PointStatus, Record, status_record
from walkergen.points.walkers import ErrorResult

GROUPS = ("speed", "spread", "persistence", "alignment", "impacts", "masses", "printability")
KEPT, SCENE, RUNS, MEETS_ERRORS = ("speed",), "lane-90hz", None, True

MOTION_GROUPS: dict[str, tuple[str, ...]] = {
    "persistence": ("persistence_time", "persistence_length", "rotational_diffusion", "turning_bias"),
    "alignment": ALIGNMENT_NAMES,
}
"""Groups of numbers from tracks, with their estimates by the names of `estimates.UNITS`."""

PREDICTED_COLUMNS = "speed_mm_s", "low_95_mm_s", "high_95_mm_s", "theory_mm_s", "model"
SIMULATED_COLUMNS = (
    "speed_mm_s",
    "se_mm_s",
    "low_95_mm_s",
    "high_95_mm_s",
    "step_error_mm_s",
    "predicted_mm_s",
    "theory_mm_s",
    "runs",
    "seconds",
    "model",
)
"""Columns of a predicted speed, and of a simulated one."""

GROUP_COLUMNS = {
    "spread": tuple(f"predicted_{side}_{level}_mm_s" for level in (95, 68) for side in ("low", "high")),
    **{
        group: tuple(f"{name}{se}_{UNITS[name]}" for name in names for se in ("", "_se"))
        for group, names in MOTION_GROUPS.items()
    },
    "impacts": ("impacts_per_s", "impacts_per_s_se", "contact_fraction", "contact_fraction_se"),
    "masses": ("total_g", "M_g", "J_g_mm2", "m_g", "j_g_mm2"),
    "printability": ("print_errors", "print_warnings", "print_told"),
}
"""Columns of the other groups of numbers."""


def check(keep: Sequence[str], model: str, printer: Printer | None) -> None:
    """Raise InputError if a group of numbers in `keep` needs a simulation or a printer, and there is none."""
    for name in ("persistence", "alignment", "impacts"):
        if name in keep and model == PREDICTION:
            raise InputError(f"‹keep=›{name}: needs a simulation: ‹model=›space")
    if "printability" in keep and printer is None:
        raise InputError("‹keep=›printability: needs a printer: ‹printer=›prusa-mk3s")


def title(model: str) -> str:
    """Return words for a table's title: whether its numbers were predicted, or by which model simulated."""
    return "predicted" if model == PREDICTION else f"model {model}"


def columns(model: str, keep: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the columns of records with the groups of numbers in `keep`, without the status."""
    more = [name for group in GROUP_COLUMNS if group in keep for name in GROUP_COLUMNS[group]]
    return (*(PREDICTED_COLUMNS if model == PREDICTION else SIMULATED_COLUMNS), *more)


def pictures(keep: Sequence[str]) -> tuple[Picture, ...]:
    """Return the number of a table of points that pictures show: the speed, for any groups of numbers `keep`."""
    return (Picture("sweep", "speed_mm_s", "low_95_mm_s", "high_95_mm_s", "speed (mm/s)"),)


def cost(point: Point) -> float:
    """Estimate the CPU seconds to evaluate a point, from short runs; for a prediction, time it instead."""
    if point.simulated:
        found = find_simplest(Walker(point.scene, point.design, solids.mass_of(point.design)), threads=1)
        walker, wanted = found.walker, point.wanted
        runs = walker.scene.run.runs
        left = run_time.run_cpu_s(walker) * runs if wanted is None else walkers.cost_to_error(walker, wanted)
        return found.cpu_s + left
    mass = solids.mass_of(point.design)
    # The first prediction is not timed: it loads what all points share.
    speed_prediction.predict(point.design, mass, point.scene, model="known")
    started = time.thread_time()
    speed_prediction.predict(point.design, mass, point.scene, model="known")
    return time.thread_time() - started + short_simulation.expected_cpu_s(Walker(point.scene, point.design, mass))


def evaluate(point: Point) -> Record:
    """Return the numbers of a point by column. Raises WalkergenError if it cannot be built or simulated."""
    design, keep = point.design, point.keep
    weighed_masses.check_stated_masses(design)
    mass = solids.mass_of(design)
    record = _simulate_point(point, mass) if point.simulated else status_record(PointStatus.OK)
    if point.predicted:
        row, reason = _predict_point(point, mass)
        if point.simulated:
            record["predicted_mm_s"] = row.speed.value
        else:
            numbers = row.speed.row(95, stem="") | {"model": row.speed_by}
            record |= {name: value for name, value in numbers.items() if name in PREDICTED_COLUMNS}
            if row.speed.value is None:
                record |= status_record(PointStatus.NO_SPEED, f"{PointStatus.NO_SPEED}: {reason}")
        record["theory_mm_s"] = row.theory_mm_s
        if "spread" in keep:
            columns = row.columns()
            record |= {name: columns[name.replace("predicted", "speed")] for name in GROUP_COLUMNS["spread"]}
    if "masses" in keep:
        leg = next((leg for leg in mass.legs if leg.m > 0.0), None)
        record |= {
            "total_g": float(mass.total),
            "M_g": float(mass.M),
            "J_g_mm2": float(mass.J),
            "m_g": None if leg is None else float(leg.m),
            "j_g_mm2": None if leg is None else float(leg.j),
        }
    if "printability" in keep:
        assert point.printer is not None
        lying = solids.orient_for_print(design, solids.build(design).walker)
        findings = checks.check_part(design.name, design, lying, point.printer)
        record |= {
            f"print_{level}s": sum(finding.level == level for finding in findings) for level in ("error", "warning")
        }
        worst = in_order(findings, {"error", "warning"})
        record["print_told"] = worst[0].text if worst else None
    return record


def _predict_point(point: Point, mass: MassProperties) -> tuple[Prediction, str]:
    """Return the prediction for a point, if needed by a short simulation, and the reason in case it has no speed."""
    reason = ""
    if not point.simulated:
        try:
            row = speed_prediction.predict(point.design, mass, point.scene)
            return row, "falls over" if row.falls else row.note
        except InputError as error:  # the simulation would take minutes
            reason = error.text
    return speed_prediction.predict(point.design, mass, point.scene, model="known"), reason


def _simulate_point(point: Point, mass: MassProperties) -> Record:
    """Simulate a point, until the error that it requests, if any, is met. Return the numbers of its runs by column."""
    simple, met = find_simplest(Walker(point.scene, point.design, mass), threads=1), None
    walker = simple.walker
    if point.wanted is None:
        results = walkers.simulate(walker, threads=1)
    else:
        met = walkers.simulate_to_error(walker, point.wanted, threads=1)
        results = met.results
    if results.partial:
        raise KeyboardInterrupt
    summary, scene = simple.widen(results.summary), results.walker.scene
    record = _status_record(summary, met) | {
        **summary.speed.row(95, stem=""),
        "step_error_mm_s": step_errors.step_bias(summary.speed),
        "runs": summary.runs,
        "seconds": scene.run.seconds,
        "model": SPACE,
    }
    if "impacts" in point.keep:
        for name in (observables.IMPACTS, observables.CONTACT):
            record |= summary.numbers[name].row()
    if names := [name for group, names in MOTION_GROUPS.items() if group in point.keep for name in names]:
        record |= _motion_record(results, names)
    return record


def _motion_record(results: Results, names: Sequence[str]) -> Record:
    """Return the estimates `names` from the tracks of runs, with standard errors, by column; None for unknown ones."""
    good = [result for result in results.results if result.outcome in ENDED_WELL]
    moved = None
    if good:
        moved, _ = walkers.motion_of(good, results.walker.scene)
    record: Record = {}
    for name in names:
        estimate = None if moved is None else moved.estimates.get(name)
        record[f"{name}_{UNITS[name]}"] = None if estimate is None else estimate.value
        record[f"{name}_se_{UNITS[name]}"] = None if estimate is None else estimate.se
    return record


def _status_record(summary: Summary, met: ErrorResult | None) -> Record:
    """Return the status of a point after its runs, and a text. `met`: result for a requested error, or None."""
    valid = [outcome.value for outcome in (*ENDED_WELL, Outcome.TOO_FEW, Outcome.ORBIT)]
    bad = {name: count for name, count in summary.outcomes.items() if name not in valid}
    if summary.speed.value is None:
        return status_record(PointStatus.NO_SPEED, f"{PointStatus.NO_SPEED}: {format_outcomes(summary.outcomes)}")
    if bad:
        return status_record(PointStatus.RUNS_ENDED_BADLY, f"{PointStatus.RUNS_ENDED_BADLY}: {format_outcomes(bad)}")
    if Outcome.TOO_FEW.value in summary.outcomes:
        return status_record(PointStatus.NOT_MET, "error unknown: too few data; take more runs, or longer ones")
    if Outcome.ORBIT.value in summary.outcomes:
        return status_record(
            PointStatus.NOT_MET, f"error unknown: all runs are {Outcome.ORBIT.value}; other prints need not be"
        )
    if met is not None and met.error > met.allowed:
        return status_record(PointStatus.NOT_MET, f"error {met.error:.3g} mm/s, above the {met.allowed:.3g} requested")
    return status_record(PointStatus.OK)
