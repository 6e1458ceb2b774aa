"""Report of simulated runs: the walker and its scene, the mean speed, and all other results."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.analysis import facts
from walkergen.analysis.motion import Motion
from walkergen.commands.simulate import quantities as numbers
from walkergen.commands.simulate import trajectories
from walkergen.commands.simulate.make import Simulation
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress, silent
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.run import ENDED_WELL, Outcome
from walkergen.core.walker.design import Design
from walkergen.files import quantity_format, report
from walkergen.files.report import Column, Report, Table
from walkergen.points.walkers import tracks_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFAULT_RATE_HZ = 1000.0
"""Samples per second of trajectories, as on the command line."""


class Line(NamedTuple):
    """Line of the printed summary: name and value of a result. A quantity is formatted when it is printed."""

    name: str
    value: str | Quantity


def _format_line(line: Line) -> str:
    """Return the text of a line's value, for a quantity with its unit."""
    number = line.value
    return (
        number if isinstance(number, str) else quantity_format.format_value(number, quantity_format.format_unit(number))
    )


LINE_COLUMNS = (report.text_column("", "name"), Column("", _format_line))

FIRST_LINE_NAMES = (
    "walker",
    "plate",
    "contact",
    "left out",
    "kept",
    "mean speed",
    "this simulation",
    "your print",
    "prints",
    "chosen",
    "error, 95 %",
    "turning bias",
    "self alignment",
    "persistence time",
    "runs",
)
"""Names of the lines that are printed unless all are requested."""


@dataclass(frozen=True, kw_only=True, repr=False)
class SimulationReport(Report):
    """Runs of one walker in a scene, with its speed and motion."""

    simulated: Simulation
    """All measured results."""

    @property
    def summary(self) -> Summary:
        """Statistics of all runs."""
        return self.simulated.results.summary

    @property
    def motion(self) -> Motion | None:
        """Motion of the walker (turning, persistence, spread); None if unknown."""
        return self.simulated.motion

    @property
    def speed(self) -> Quantity:
        """Mean speed in mm/s with its standard error from the runs. Bounds include runs and step.

        If all runs end on one orbit they have no statistical error. The bounds are then those of prints.
        """
        return _mean_speed(self.simulated)

    def trajectory(self, rate_hz: float = DEFAULT_RATE_HZ, progress: Progress | None = None) -> Table:
        """Simulate the runs again, and return their positions and angles over time, as --trajectory writes them.

        Parameters
        ----------
        rate_hz : float, default: 1000
            States per second, from 0.001 to 1e7.
        progress : Progress, optional
            Function that is called with a step's name, the number done and the total.

        Returns
        -------
        Table
            The first columns are those of `analyse` and trackpy: frame, particle (the number of the run), x, y (mm)
            and theta (rad) from above. Then follow t_s and the model's columns.

        Raises
        ------
        InputError
            If the rate is out of range, or there are more samples than can be kept.
        """
        if not 1e-3 <= rate_hz <= 1e7:
            raise InputError(f"rate_hz={rate_hz:g}: must be a number >= 0.001 and <= 1e7")
        walker = self.simulated.results.walker._replace(sample_interval=1.0 / rate_hz)
        states = trajectories.collect(walker, self.simulated.results, progress or silent)
        title = f"trajectories of {self.summary.runs} runs"
        return Table("trajectory", list(states.rows), states.columns, title=title)


def make_report(simulated: Simulation, whole: bool = False) -> SimulationReport:
    """Make the report of the runs of a walker in a scene. `whole`: True to print all lines of the summary."""
    scene, design = simulated.scene, simulated.results.walker.design
    lines = [Line(*line) for line in _lines(simulated, scene, design)]
    first = None if whole else _select_first_lines(lines, simulated)
    return SimulationReport(
        name="simulate",
        title=f"{design.name}, {design.tilt_deg:g} deg, on {scene.name}",
        tables=[_summary_table(simulated, design), Table("summary", lines, (), LINE_COLUMNS, read=first)],
        lines=[] if whole else ["‹all› also prints turning, spreading, impacts, contact and power"],
        facts=_facts(simulated, scene),
        warnings=simulated.results.warnings,
        figures=_figures(simulated, design),
        simulated=simulated,
    )


def _select_first_lines(lines: Sequence[Line], simulated: Simulation) -> list[Line]:
    """Return the lines to print: those of FIRST_LINE_NAMES with a value, and endings of runs that ended badly."""
    ended_well = set(simulated.results.summary.outcomes) == {Outcome.OK.value}
    names = {*FIRST_LINE_NAMES, *(() if ended_well else ("outcomes",))}
    return [line for line in lines if line.name in names and (isinstance(line.value, str) or line.value.known)]


def _summary_table(simulated: Simulation, design: Design) -> Table:
    """Make the table of the summary in one row. Nested tables become columns with a dot."""
    named = {"name": design.name, "tilt_deg": design.tilt_deg, "legs": design.kind, "scene": simulated.scene.name}
    values = named | _flatten(numbers.rename_motor_power(simulated.results.summary.facts, simulated.scene))
    return Table("simulation", [tuple(values.values())], tuple(values))


def _flatten(values: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Flatten nested tables to values by names with dots."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            flat |= _flatten(value, f"{before}{name}.")
        else:
            flat[f"{before}{name}"] = value
    return flat


def _mean_speed(simulated: Simulation) -> Quantity:
    """Return the mean speed of the runs. For runs on one orbit, its name is the reason for the missing error."""
    speed = simulated.results.summary.speed
    return speed if simulated.orbit is None else speed._replace(refused=simulated.orbit.kind)


def _figures(simulated: Simulation, design: Design) -> "dict[str, Callable[[], Figure]]":
    """Return the functions that draw the runs: distance against time in a lane, the view from above on a plane.

    The result is empty if no run ended well.
    """
    good = [result for result in simulated.results.results if result.outcome in ENDED_WELL]

    def draw() -> "Figure":
        from walkergen.points.track_figure import draw_tracks

        tracks = tracks_of(good, simulated.scene.arena.kind == "lane", None)
        title = f"{design.name}, {design.tilt_deg:g} deg: {_mean_speed(simulated)}"
        return draw_tracks(tracks, title)

    return {"runs": draw} if good else {}


def _facts(simulated: Simulation, scene: Scene) -> dict[str, Any]:
    """Return the summary of the runs for JSON. It is partial if Ctrl-C left some out."""
    data: dict[str, Any]
    data = numbers.contact_as_dict(scene) | simulated.results.summary.facts
    data["partial"] = simulated.results.partial
    if simulated.motion is not None:
        data["motion"] = facts.from_motion(simulated.motion)
    if simulated.no_motion_reason:
        data["motion"] = {"refused": simulated.no_motion_reason}
    if simulated.landings:
        data["landings"] = numbers.landings_as_dict(simulated)
    data["step"] = numbers.step_errors_as_dict(simulated)
    data = numbers.rename_motor_power(data, scene)
    orbit = simulated.orbit
    data["orbit"] = None if orbit is None else numbers.orbit_as_dict(orbit)
    if simulated.simplest is not None:
        data |= simulated.simplest.facts
    chosen = simulated.chosen
    return data if chosen is None else data | {"chosen": chosen.facts}


def _lines(simulated: Simulation, scene: Scene, design: Design) -> Iterator[tuple[str, str | Quantity]]:
    """Yield the name and value of each line of the summary."""
    summary = simulated.results.summary
    yield "walker", f"{design.name}, {design.kind} legs, tilt {design.tilt_deg:g} deg"
    yield scene.drive.kind, numbers.format_drive(scene)
    yield "contact", numbers.format_contact(scene)
    if simulated.simplest is not None:
        yield from simulated.simplest.lines
    yield "mean speed", _format_speed(simulated, scene)
    yield from numbers.bound_rows(simulated)
    if simulated.chosen is not None:
        yield from simulated.chosen.lines
    if simulated.no_motion_reason:
        yield "motion", f"unknown: {simulated.no_motion_reason}"
    found = [numbers.motion_numbers(simulated), numbers.observed_numbers(simulated), numbers.landing_numbers(simulated)]
    rest, marks = quantity_format.mark_reasons(chain(*found))
    yield from ((quantity_format.format_name(number), number) for number in rest)
    yield from marks.items()
    yield from (("note", note) for note in numbers.notes(simulated))
    yield "runs", f"{summary.runs}, {summary.simulated_s:.1f} s simulated in all"
    correlation = summary.correlation_time_s
    yield "correlation time", "unknown" if correlation is None else f"{1e3 * correlation:.0f} ms"
    yield "largest pitch", f"{summary.max_pitch_deg:.2f} deg (an extreme, which grows with time)"
    outcomes = (f"{count} x {name}" for name, count in summary.outcomes.items())
    yield "outcomes", ", ".join(outcomes)
    rate = summary.simulated_s / summary.cpu_s if summary.cpu_s else 0.0
    yield "time", f"{summary.wall_s:.1f} s, {rate:.0f} simulated s per CPU s"


def _format_speed(simulated: Simulation, scene: Scene) -> str:
    """Format the mean speed with the errors of runs and step, or the reason why it has none."""
    _, _, mean, se, *_ = simulated.results.summary.speed
    if mean is None:
        return "none: no run ended well"
    speed = f"{formatting.format_fixed(mean, 2) if se is None else formatting.format_with_error(mean, se)} mm/s"
    speed += " along the " + ("heading" if scene.arena.kind == "plane" else "lane")
    speed += numbers.format_step_error(simulated)
    if simulated.orbit is not None:
        return f"{speed}; {simulated.orbit.kind}: all runs end this way, so there is no statistical error"
    good = simulated.results.summary.outcomes.get(Outcome.TOO_FEW.value, 0)
    few = "one run is" if good == 1 else f"{good} runs are"
    return speed if se is not None else f"{speed}; {few} too few for bounds"
