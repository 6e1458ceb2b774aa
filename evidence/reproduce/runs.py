"""Simulated walkers of the reproduction: speed, impact speed and types of impacts of an ensemble."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from evidence import paper_simulation
from evidence.reproduce import impact_types
from evidence.reproduce.impact_types import Impacts, Shares
from walkergen.analysis import landings
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.scene import Scene
from walkergen.core.simulation.ensemble import format_outcomes
from walkergen.core.simulation.run import ENDED_WELL, recorded_impacts
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep import sweep_file
from walkergen.points import walkers
from walkergen.points.experiments import Results, Walker

NOISE_RATIO = 0.5
"""Noise of the noisy plate, rms velocity over the drive's peak speed, in the scene's band: chosen
since with it the speed becomes proportional to the plate's; the paper does not state its plate's.
"""

SPACE_LENGTH_RATIO, FIGURE6_LENGTH_RATIO = 0.5, 1.5
"""Length of runs in space over that of runs of the paper's model, whose speeds scatter more; of those of figure 6,
whose lags reach a quarter of it."""

PAPER_MODEL = "paper's model"
"""Series of ensembles of the paper's own model."""

NOISE_RATIOS = {"space": 0.0, "space, noisy plate": NOISE_RATIO, "space, braced": 0.0}
"""Noise of the plate of each series in space; all run on a plane."""

OUTCOMES = {
    paper_simulation.OK: "ok",
    paper_simulation.FALLEN: "toppled",
    paper_simulation.ENDLESS: "impacts without end",
}
"""Outcomes of runs of the paper's model."""


class Assumption(NamedTuple):
    """Assumption on the contact between foot and plate."""

    name: str
    scene: Scene

    @property
    def label(self) -> str:
        """Name and numbers of the assumption."""
        contact = self.scene.contact
        return f"{self.name}: e = {contact.restitution:g}, μ = {contact.friction:g}"


class Case(NamedTuple):
    """Contact, model and walker to simulate."""

    assumption: Assumption
    model: str
    """PAPER or a series of NOISE."""
    design: Design
    gamma: float | None = None
    """Peak acceleration of the plate over g at the scene's frequency; None for the scene's."""

    @property
    def scene(self) -> Scene:
        """Scene with this drive."""
        scene = self.assumption.scene
        if self.gamma is None:
            return scene
        frequency = scene.drive.frequency
        drive = {"amplitude_um": None, "peak_speed_mm_s": None, "frequency_hz": frequency, "gamma": self.gamma}
        return scene.model_copy(update={"drive": scene.drive.model_copy(update=drive)})

    def walker(self) -> Walker:
        """Return the walker in space, with every impact recorded."""
        scene = move_to_plane(self.scene, SPACE_LENGTH_RATIO, NOISE_RATIOS[self.model])
        return Walker(scene, self.design, solids.mass_of(self.design), impacts=True)


class Point(NamedTuple):
    """Results of one ensemble."""

    assumption: Assumption
    model: str
    """PAPER or a series of NOISE."""
    tilt_deg: float
    plate_speed_mm_s: float
    """Peak speed of the plate."""
    speed: Quantity
    """Mean speed, mm/s, over runs that ended well; none where these are less than half of all."""
    impact_speed: Quantity
    """Mean normal speed of landings, mm/s."""
    shares: Shares
    """Shares of impacts by counting and type; empty without impacts."""
    lost: int
    """Number of runs that ended badly, as by toppling."""
    outcomes: str


def sweep_values(name: str) -> list[list[float]]:
    """Values of the keys that one of the shipped sweeps varies."""
    space = sweep_file.read_sweep(templates.folder() / "sweeps" / f"{name}.toml").space
    return [[float(value) for value in axis.values] for axis in space.axes]


def move_to_plane(scene: Scene, longer: float, noise_ratio: float = 0.0) -> Scene:
    """Return the same drive and contact on an open plane, without walls."""
    run = {"step_us": None, "seconds": longer * scene.run.seconds}
    changes = {
        "arena": scene.arena.model_copy(update={"kind": "plane", "gap_mm": None}),
        "run": scene.run.model_copy(update=run),
        "plate": scene.plate.model_copy(update={"noise_ratio": noise_ratio}) if noise_ratio else scene.plate,
    }
    return scene.model_copy(update=changes)


def simulate_cases(cases: Sequence[Case], progress: Progress) -> Iterator[Point]:
    """Simulate every case."""
    in_space = [case for case in cases if case.model != PAPER_MODEL]
    titles = [f"{case.assumption.name}, {case.model}, {case.design.tilt_deg:g} deg" for case in in_space]
    results = walkers.simulate_each([case.walker() for case in in_space], titles, progress)
    for case in cases:
        yield _simulate_paper_model(case) if case.model == PAPER_MODEL else _measure_in_space(case, next(results))


def _simulate_paper_model(case: Case) -> Point:
    """Return the point of a case by the paper's own model."""
    runs = paper_simulation.simulate(case.scene, case.design, solids.mass_of(case.design))
    good = [run for run in runs if run.status == paper_simulation.OK]
    impacts = [impact_types.classify_impacts(run.impacts, 1) for run in good]
    outcomes = Counter(OUTCOMES[run.status] for run in runs)
    return _make_point(case, [run.speed for run in good], impacts, len(runs), outcomes)


def _measure_in_space(case: Case, results: Results) -> Point:
    """Return the point of a case from its runs in space."""
    good = [result for result in results.results if result.outcome in ENDED_WELL]
    impacts = [impact_types.classify_impacts(recorded_impacts(result), landings.CORNERS_PER_FOOT) for result in good]
    speeds = [result.speed for result in good]
    return _make_point(case, speeds, impacts, len(results.results), results.summary.outcomes)


def _make_point(
    case: Case, speeds: Sequence[float], impacts: Sequence[Impacts], runs: int, outcomes: Mapping[str, int]
) -> Point:
    """Return the point of a case from speeds and impacts of the runs that ended well, of so many."""
    landed = [one for one in impacts if one.landing.any()]
    landing_speeds = [float(one.speed[one.landing].mean()) for one in landed]
    return Point(
        case.assumption,
        case.model,
        case.design.tilt_deg,
        case.scene.drive.peak_speed,
        mean("speed", "mm_s", speeds if 2 * len(speeds) >= runs else []),
        mean("impact_speed", "mm_s", landing_speeds if len(landing_speeds) > 1 else []),
        impact_types.mean_shares(landed),
        runs - len(speeds),
        format_outcomes(dict(sorted(outcomes.items()))),
    )
