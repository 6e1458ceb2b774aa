"""Simulated walkers of the reproduction: speed, impact speed and types of impacts of an ensemble."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.reproduce import impact_types
from evidence.reproduce.impact_types import TYPES, Shares
from walkergen.analysis import landings
from walkergen.files import templates
from walkergen.files.progress import Progress
from walkergen.jobs.run.sweep import sweep_file
from walkergen.numerics.quantity import Quantity, mean
from walkergen.points import walkers
from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.effects.effect import ModelName
from walkergen.simulation.ensemble import listed
from walkergen.simulation.experiments import Results, Walker
from walkergen.simulation.run import ENDED_WELL, impacts_of
from walkergen.walker import solids
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

NOISE_RATIO = 0.5
"""Noise of the noisy plate, rms velocity over the drive's peak speed, in the scene's band: chosen
since with it the speed becomes proportional to the plate's; the paper does not state its plate's.
"""

SHORTER, LONGER = 0.5, 1.5
"""Length of runs in space over that of planar runs, whose speeds scatter more; of those of figure 6,
whose lags reach a quarter of it."""


SERIES: dict[str, tuple[ModelName, float]] = {
    "relaxed": ("relaxed", 0.0),
    "compliant": ("compliant", 0.0),
    "rigid": ("rigid", 0.0),
    "space": ("space", 0.0),
    "space, noisy plate": ("space", NOISE_RATIO),
    "space, braced": ("space", 0.0),
}
"""Models and noise of series of ensembles by their names in tables; in space they run on a plane."""


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
    """One of SERIES."""
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
        """Walker of which every impact is kept."""
        model, noise_ratio = SERIES[self.model]
        legs = self.scene.legs.model_copy(update={"model": model})
        in_space = model == "space"
        scene = on_plane(self.scene, SHORTER, noise_ratio) if in_space else self.scene.model_copy(update={"legs": legs})
        return Walker(scene, self.design, solids.mass_of(self.design), impacts=True)


class Point(NamedTuple):
    """Results of one ensemble."""

    assumption: Assumption
    model: str
    """One of SERIES."""
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


def swept(name: str) -> list[list[float]]:
    """Values of the keys that one of the shipped sweeps varies."""
    space = sweep_file.read(templates.folder() / "sweeps" / f"{name}.toml").space
    return [[float(value) for value in axis.values] for axis in space.axes]


def on_plane(scene: Scene, longer: float, noise_ratio: float = 0.0) -> Scene:
    """Scene of the model in space: the same drive and contact on an open plane, without walls."""
    run = {"step_us": None, "seconds": longer * scene.run.seconds}
    changes = {
        "arena": scene.arena.model_copy(update={"kind": "plane", "gap_mm": None}),
        "legs": scene.legs.model_copy(update={"model": "space"}),
        "run": scene.run.model_copy(update=run),
        "plate": scene.plate.model_copy(update={"noise_ratio": noise_ratio}) if noise_ratio else scene.plate,
    }
    return scene.model_copy(update=changes)


def simulated(cases: Sequence[Case], progress: Progress) -> Iterator[Point]:
    """Simulate every case as it is."""
    titles = [f"{case.assumption.name}, {case.model}, {case.design.tilt_deg:g} deg" for case in cases]
    results = walkers.each([case.walker() for case in cases], titles, progress)
    for case, point in zip(cases, results, strict=True):
        yield _point(case, point)


def _point(case: Case, point: Results) -> Point:
    """Point of a case, from its simulated runs and their impacts."""
    results = point.results
    good = [result for result in results if result.outcome in ENDED_WELL]
    corners = landings.CORNERS if point.model == "space" else 1
    runs = [(impact_types.of_run(impacts_of(result), corners), result.tally.counts) for result in good]
    landed = [(impacts, counts) for impacts, counts in runs if impacts.landing.any()]
    landing_speeds = [float(impacts.speed[impacts.landing].mean()) for impacts, _ in landed]
    return Point(
        case.assumption,
        case.model,
        case.design.tilt_deg,
        case.scene.drive.peak_speed,
        mean("speed", "mm_s", [result.speed for result in good] if 2 * len(good) >= len(results) else []),
        mean("impact_speed", "mm_s", landing_speeds if len(landing_speeds) > 1 else []),
        impact_types.shares([impacts for impacts, _ in landed], [of_counts(counts) for _, counts in landed]),
        len(results) - len(good),
        listed(dict(sorted(point.summary.outcomes.items()))),
    )


def of_counts(counts: npt.NDArray[np.int64]) -> Array:
    """Shares in the order of TYPES from a tally of a run that met the plate."""
    amounts = [counts[[record.row_of(kind) for kind in kinds]].sum() for kinds in TYPES.values()]
    return np.array(amounts, dtype=np.float64) / float(counts[record.IMPACTS])
