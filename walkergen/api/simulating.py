"""Simulated runs, as the command `simulate` makes them."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from walkergen.analysis.motion import Motion
from walkergen.api.loading import Ground, Walker, one_of, scene_of
from walkergen.api.predicting import SCENE
from walkergen.api.speed import Speed, speed_of
from walkergen.api.table import Result, Table
from walkergen.errors import InputError, WalkergenError
from walkergen.files.progress import Progress, silent
from walkergen.jobs.simulate import make, report, trajectories
from walkergen.points.runs import tracks_of
from walkergen.points.wanted import parse
from walkergen.scene import Scene
from walkergen.simulation.ensemble import Summary
from walkergen.simulation.points import Asked
from walkergen.simulation.run import ENDED_WELL
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RATE_HZ = 1000.0
"""Samples per second of trajectories, as on the command line."""


class Simulation(Result):
    """Runs of one walker in a scene, and what they say of its speed and motion."""

    def __init__(self, asked: Asked, found: make.Simulated) -> None:
        self._asked = asked
        self.found = found
        """Everything that was measured, as the command `simulate` prints it."""

    @property
    def design(self) -> Design:
        """Walker that ran."""
        return self._asked.design

    @property
    def scene(self) -> Scene:
        """Scene that it ran in, with the runs that were asked for."""
        return self._asked.scene

    @property
    def summary(self) -> Summary:
        """Statistics of all runs, with units in the names."""
        return self.found.point.summary

    @property
    def motion(self) -> Motion | None:
        """Motion of a walker in space: turning, persistence, spread; None where it is not known."""
        return self.found.motion

    @property
    def speed(self) -> Speed:
        """Mean speed in mm/s with its standard error by the runs; bounds by runs and step.

        Where all runs end on one orbit they tell no error, and bounds are those of prints.
        """
        one = self.summary
        kind = "" if self.found.orbit is None else self.found.orbit.kind
        return speed_of(
            one.speed_mm_s, one.speed_se_mm_s, one.speed_low_95_mm_s, one.speed_high_95_mm_s, kind
        )

    @property
    def table(self) -> Table:
        """Numbers of the summary in one row; tables within it become columns with a dot."""
        told = {"name": self.design.name, "tilt_deg": self.design.tilt_deg,
                "legs": self.design.kind, "scene": self.scene.name,
                "model": self.found.point.model, "method": self.found.point.method}  # fmt: skip
        return Table(
            {key: [value] for key, value in (told | _flat(self.summary._asdict())).items()}
        )

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words, as the command prints them, and warnings."""
        made = report.of(self.found, self.design)
        yield from ((line["name"], line["value"]) for line in made.table)
        yield from (("warning", warning) for warning in self.found.point.warnings)

    def trajectory(self, rate_hz: float = RATE_HZ, progress: Progress | None = None) -> Table:
        """States of all runs, `rate_hz` a second, as `simulate --trajectory` writes them.

        What `analyse` and trackpy take: frame, particle (the number of the run), x, y (mm) and
        theta (rad) from above, then t_s and the model's own. The runs are simulated again. Raises
        InputError for more samples than can be kept.
        """
        one = self._asked._replace(sample_interval=_interval(rate_hz))
        found = trajectories.of(one, self.found.point, progress or silent)
        title = f"trajectories of {self.summary.runs} runs"
        return Table(dict(zip(found.columns, found.rows.T, strict=True)), title)

    def plot(self) -> "Figure":
        """Draw the runs: way against time in a lane, on a plane as seen from above.

        Raises WalkergenError where no run ended well.
        """
        from walkergen.files.figures import shown
        from walkergen.jobs.analyse.figures import tracks_figure

        results = self.found.point.results
        good = [result for result in results if result.outcome in ENDED_WELL]
        if not good:
            raise WalkergenError("plot: no run ended well, so that there is nothing to draw")
        found = tracks_of(good, self.scene.arena.kind == "lane", None)
        title = f"{self.design.name}, {self.design.tilt_deg:g} deg: {self.speed}"
        return shown(tracks_figure(found, title))


def simulate(
    design: Walker, scene: Ground = SCENE, *, tilt: float | None = None, legs: Kind | None = None,
    seconds: float | None = None, runs: int | None = None, model: str | None = None,
    seed: int | None = None, error: str | None = None, progress: Progress | None = None,
) -> Simulation:  # fmt: skip
    """Bounce a walker on the plate and measure its speed; in space also how it turns.

    Measured `seconds` of each of `runs` runs, `model` and `seed` are by default the scene's, tilt
    (deg) and legs the design's. The first call of a model compiles it.

    With an `error` of the mean speed, "5%" or "3mm/s" with 95 % confidence, as many runs are made
    as it needs, by a step that is fine enough; seconds and runs are then left out, and
    `.found.chosen` says what was taken. A share counts of the speed, or of a fifth of the plate's
    peak speed where the walker is slower. Raises InputError.
    """
    for name, value in {"seconds": seconds, "runs": runs}.items():
        if error is not None and value is not None:
            raise InputError(f"{name}={value!r}: error={error!r} chooses it; leave one of them out")
    given = {"run.seconds": seconds, "run.runs": runs, "legs.model": model, "run.seed": seed}
    keys = {key: value for key, value in given.items() if value is not None}
    ground, member = scene_of(scene).variant(**keys), one_of(design, tilt, legs)
    one = make.asked(ground, member, solids.mass_of(member))
    wanted = None if error is None else parse(error)
    found = make.measure(one, progress or silent, wanted)
    return Simulation(one._replace(scene=found.scene), found)


def _interval(rate_hz: float) -> float:
    """Time between samples, s. Raises InputError."""
    if not 1e-3 <= rate_hz <= 1e7:
        raise InputError(f"rate_hz={rate_hz:g}: must be a number >= 0.001 and <= 1e7")
    return 1.0 / rate_hz


def _flat(values: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Values of tables within tables, by names with dots."""
    found: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{before}{name}.")
        else:
            found[f"{before}{name}"] = value
    return found
