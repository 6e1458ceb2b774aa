"""Report of simulated runs: what was simulated, the mean speed, and all that came with it."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from walkergen.analysis import facts
from walkergen.files import report, words
from walkergen.files.report import Report
from walkergen.jobs.simulate import tables
from walkergen.jobs.simulate.make import Simulated
from walkergen.scene import Scene
from walkergen.walker.design import Design


class Line(NamedTuple):
    """Name and value in words."""

    name: str
    value: str


LINES = (report.text("", "name"), report.text("", "value"))


def of(simulated: Simulated, design: Design) -> Report:
    """Report of the runs of a walker in a scene, and of what an error that was asked for took."""
    scene = simulated.scene
    lines = [Line(*line) for line in _lines(simulated, scene, design)]
    title = f"{design.name}, {design.tilt_deg:g} deg, on {scene.name}"
    return Report(
        name="simulate", title=title, tables=[report.table("summary", lines, LINES)],
        facts=_facts(simulated, scene),
    )  # fmt: skip


def _facts(simulated: Simulated, scene: Scene) -> Mapping[str, Any]:
    """Summary of the runs for JSON; it is partial when Ctrl-C left some out."""
    data = tables.model_as_dict(simulated, scene) | simulated.point.summary._asdict()
    data["partial"] = simulated.point.summary.runs < scene.run.runs
    if simulated.motion is not None:
        data["motion"] = facts.of(simulated.motion)
    if simulated.untold:
        data["motion"] = {"refused": simulated.untold}
    if simulated.landings:
        data["landings"] = tables.landings_as_dict(simulated)
    data["step"] = tables.step_as_dict(simulated)
    orbit = simulated.orbit
    data["orbit"] = None if orbit is None else tables.orbit_as_dict(orbit)
    chosen = simulated.chosen
    return data if chosen is None else data | {"chosen": chosen.facts}


def _lines(simulated: Simulated, scene: Scene, design: Design) -> Iterator[tuple[str, str]]:
    summary, drive = simulated.point.summary, scene.drive
    yield "walker", f"{design.name}, {design.kind} legs, tilt {design.tilt_deg:g} deg"
    plate = f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g, {drive.peak_speed:.1f} mm/s"
    yield "plate", plate
    yield "model", tables.model_in_words(simulated, scene)
    yield "mean speed", _speed(simulated, scene)
    yield from tables.bound_rows(simulated)
    if simulated.chosen is not None:
        yield from simulated.chosen.lines
    yield from tables.motion_rows(simulated)
    yield "runs", f"{summary.runs}, {summary.simulated_s:.1f} s simulated in all"
    correlation = summary.correlation_time_s
    yield "correlation time", "unknown" if correlation is None else f"{1e3 * correlation:.0f} ms"
    yield from tables.statistic_rows(simulated)
    yield "largest pitch", f"{summary.max_pitch_deg:.2f} deg, an extreme: the more, the longer"
    outcomes = (f"{count} x {name}" for name, count in summary.outcomes.items())
    yield "outcomes", ", ".join(outcomes)
    rate = summary.simulated_s / summary.cpu_s if summary.cpu_s else 0.0
    yield "time", f"{summary.wall_s:.1f} s, {rate:.0f} simulated s per CPU s"


def _speed(simulated: Simulated, scene: Scene) -> str:
    """Mean speed with the error of the runs and that of the step, or why it has none."""
    summary = simulated.point.summary
    se = summary.speed_se_mm_s
    if summary.speed_mm_s is None:
        return "none: no run ended well"
    error = "" if se is None else f" ± {words.number(se, 2)}"
    speed = f"{summary.speed_mm_s:.2f}{error} mm/s"
    if simulated.point.model == "space":
        speed += " along the " + ("heading" if scene.arena.kind == "plane" else "lane")
    speed += tables.speed_by_step(simulated)
    if simulated.orbit is not None:
        return f"{speed}; {simulated.orbit.kind}: all runs end so, and tell no error"
    return speed if se is not None else f"{speed}; standard error unknown: needs 4 runs"
