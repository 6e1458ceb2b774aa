"""Evaluation of a point: its masses, its predicted speed, and what a simulation says of it."""

import math
from collections.abc import Sequence

from walkergen.analysis.estimates import UNITS
from walkergen.errors import WalkergenError
from walkergen.points.point import OK, STATUS, Point, Record
from walkergen.points.runs import motion_of
from walkergen.points.wanted import Wanted
from walkergen.printing import checks
from walkergen.scene import Scene
from walkergen.simulation import ensemble, observables, resolution
from walkergen.simulation.ensemble import Summary, listed
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import ENDED_WELL, Outcome, RunResult
from walkergen.theory import prediction
from walkergen.walker import solids
from walkergen.walker.mass import MassProperties

FIRST_RUNS, MOST_RUNS = 8, 512
"""Numbers of runs of a point that must meet an error: at first, and at most."""

SLACK = 1.2
"""Factor by which more runs are made than the estimated error needs, since it fluctuates."""

STEPS_PART = 0.8
"""Largest share of the allowed error that the time step in space may cause; beyond it the step is
halved."""

FINEST_US = 0.05
"""Shortest step, us: none is halved to less."""

LONGEST_S = 4.0
"""Measured time of a run of such a point, at most: more runs tell more than longer ones."""

FEWEST_AT_ALL = 0.2
"""Least speed (over the plate's peak speed) of which a relative error is taken: a walker that
stands still would never meet a share of its own."""

MOTION = ("persistence_time", "persistence_length", "rotational_diffusion", "turning_bias")
"""Estimates of the group "persistence", by the names of `estimates.UNITS`."""


def evaluate(point: Point) -> Record:
    """Numbers of a point; one that cannot be built, or simulated, says so in its status."""
    try:
        return _evaluated(point)
    except WalkergenError as error:
        return refused(error)


def refused(error: WalkergenError) -> Record:
    """Record of a point that cannot be."""
    return {STATUS: f"refused: {' '.join(str(error).split())[:300]}"}


def _evaluated(point: Point) -> Record:
    design, scene, keep = point.design, point.scene, point.keep
    mass = solids.mass_of(design)
    record: Record = _simulated(point, mass) if point.simulated else {STATUS: OK}
    if point.predicted:
        row = prediction.predict(design, mass, scene)
        if point.simulated:
            record["predicted_mm_s"] = row.speed_mm_s
        else:
            record |= {"speed_mm_s": row.speed_mm_s, "model": row.speed_by}
        record["theory_mm_s"] = row.theory_mm_s
        if "spread" in keep:
            ends = [f"speed_{side}_{level}_mm_s" for level in (95, 68) for side in ("low", "high")]
            record |= {end.replace("speed", "predicted"): getattr(row, end) for end in ends}
    if "masses" in keep:
        leg = next((leg for leg in mass.legs if leg.m > 0.0), None)
        record |= {
            "total_g": float(mass.total), "M_g": float(mass.M), "J_g_mm2": float(mass.J),
            "m_g": None if leg is None else float(leg.m),
            "j_g_mm2": None if leg is None else float(leg.j),
        }  # fmt: skip
    if "printability" in keep:
        assert point.printer is not None
        lying = solids.as_printed(design, solids.build(design).walker)
        findings = checks.of_part(design.name, design, lying, point.printer)
        record |= {f"print_{level}s": sum(finding.level == level for finding in findings)
                  for level in ("error", "warning")}  # fmt: skip
        worst = checks.grouped([finding for finding in findings if finding.level != "advice"])
        record["print_told"] = checks.line(worst[0]).partition(": ")[2] if worst else None
    return record


def _simulated(point: Point, mass: MassProperties) -> Record:
    """Numbers of the runs of a point, more and more of them until its error is met."""
    design, scene, wanted = point.design, point.scene, point.wanted
    if wanted is not None:
        seconds = min(scene.run.seconds, LONGEST_S)
        scene = with_runs(scene, runs=FIRST_RUNS, seconds=seconds)
    while True:
        plan = prepare(scene, design, mass)
        summary, results = ensemble.measure(plan, _silent, threads=1)
        if summary.runs < scene.run.runs:
            raise KeyboardInterrupt
        step = resolution.judge(plan, summary)[observables.SPEED].error
        low, high = _bounds(summary, step)
        half = math.inf if low is None or high is None else 0.5 * (high - low)
        most = math.inf if wanted is None else allowed(wanted, summary.speed_mm_s, scene)
        if half <= most or summary.speed_mm_s is None or Outcome.ORBIT.value in summary.outcomes:
            break
        own = getattr(plan.world.options, "step", None)
        finer = _refined(scene, half, most, step or 0.0, own)
        if finer is None:
            break
        scene = finer
    model = plan.resolved.model
    record: Record = {
        STATUS: _status(summary, half, most),
        "speed_mm_s": summary.speed_mm_s, "se_mm_s": summary.speed_se_mm_s,
        "low_95_mm_s": low, "high_95_mm_s": high, "step_error_mm_s": step,
        "runs": summary.runs, "seconds": scene.run.seconds, "model": model,
    }  # fmt: skip
    if "impacts" in point.keep:
        for name in (observables.IMPACTS, observables.CONTACT):
            record |= {name: getattr(summary, name), f"{name}_se": summary.errors[name]}
    if "persistence" in point.keep:
        record |= _motion(results, model, scene)
    return record


def _refined(
    scene: Scene, half: float, most: float, step: float, own: float | None
) -> Scene | None:
    """Scene with more runs, or half the step, for half-widths (mm/s) that exceed `most`.

    `step` is the error that the time step causes (mm/s), `own` that time step (s), None where it
    cannot be set. None is returned where neither would help.
    """
    run = scene.run
    if step > STEPS_PART * most:
        finest = own is None or 1e6 * own < 2.0 * FINEST_US
        return None if finest or own is None else with_runs(scene, step_us=0.5e6 * own)
    if run.runs >= MOST_RUNS:
        return None
    # Variances fall as runs are added; the scatter of few runs is itself known badly.
    short = (half**2 - step**2) / (most**2 - step**2) if math.isfinite(half) else 2.0
    more = math.ceil(run.runs * min(max(SLACK * short, 1.5), 8.0))
    return with_runs(scene, runs=min(MOST_RUNS, more))


def _motion(results: Sequence[RunResult], model: str, scene: Scene) -> Record:
    """Persistence and turning of runs in space; None where they are not known."""
    good = [result for result in results if result.outcome in ENDED_WELL]
    moved = None
    if good and model == "space":
        moved, _ = motion_of(good, scene.arena.kind == "lane")
    record: Record = {}
    for name in MOTION:
        estimate = None if moved is None else moved.estimates.get(name)
        record[f"{name}_{UNITS[name]}"] = None if estimate is None else estimate.value
        record[f"{name}_se_{UNITS[name]}"] = None if estimate is None else estimate.se
    return record


def allowed(wanted: Wanted, speed: float | None, scene: Scene) -> float:
    """Error that a point may have, mm/s: a share counts of the speed, or of FEWEST_AT_ALL."""
    if not wanted.relative:
        return wanted.value
    return wanted.value * max(abs(speed or 0.0), FEWEST_AT_ALL * scene.drive.peak_speed)


def _bounds(summary: Summary, step: float | None) -> tuple[float | None, float | None]:
    """Bounds of 95 % of the runs, and of the step where its error is known (mm/s)."""
    speed, low, high = summary.speed_mm_s, summary.speed_low_95_mm_s, summary.speed_high_95_mm_s
    if speed is None or low is None or high is None:
        return None, None
    half = math.hypot(0.5 * (high - low), step or 0.0)
    return speed - half, speed + half


def _status(summary: Summary, half: float, most: float) -> str:
    """How the runs of a point went."""
    fine = [outcome.value for outcome in (*ENDED_WELL, Outcome.TOO_FEW, Outcome.ORBIT)]
    bad = {name: count for name, count in summary.outcomes.items() if name not in fine}
    if summary.speed_mm_s is None:
        return f"no speed: {listed(summary.outcomes)}"
    if bad:
        return f"some runs ended badly: {listed(bad)}"
    if Outcome.TOO_FEW.value in summary.outcomes:
        return "error unknown: too few data; take more runs, or longer ones"
    if Outcome.ORBIT.value in summary.outcomes:
        return f"error unknown: all runs are {Outcome.ORBIT.value}, which other prints are not"
    if half > most:
        return f"error {half:.3g} mm/s, not within the {most:.3g} asked"
    return OK


def with_runs(scene: Scene, **run: float) -> Scene:
    """Scene with other settings of its runs."""
    return scene.model_copy(update={"run": scene.run.model_copy(update=run)})


def _silent(what: str, done: int, total: int) -> None:
    """Progress that reports nothing."""
