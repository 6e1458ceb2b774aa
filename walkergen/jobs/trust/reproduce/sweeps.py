"""Sweeps: mean speeds, impact speeds and types of impacts along the tilt and the plate's speed."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import landings
from walkergen.analysis.values import Value, mean
from walkergen.files.progress import Progress
from walkergen.points import walkers
from walkergen.scene import Scene
from walkergen.simulation import experiments, record
from walkergen.simulation.effects.effect import ModelName
from walkergen.simulation.ensemble import listed
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import ENDED_WELL, RunResult, impacts_of
from walkergen.theory.impact import Kind
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

TYPES = {
    "III": (Kind.III,),
    "II": (Kind.II,),
    "I": (Kind.I,),
    "IV": (Kind.IV,),
    "from rest": (Kind.FROM_REST,),
    "mirrored": (Kind.II_MIRRORED, Kind.III_MIRRORED),
}
"""Types of impacts; from rest: v_x = 0 exactly before; mirrored: II or III of a foot that slides
backward before."""

SUMS = {"II+III": ("II", "III"), "II+III+rest": ("II", "III", "from rest"), "III+rest": ("III", "from rest")}
"""Shares taken together: an impact from rest is the limit of type III for v_x to 0."""

COUNTINGS = ("every impact", "landings", "by impulse")
"""Ways to take a share: of all impacts, chatter included (of relaxed legs a cascade's geometric
tail counts once; in space every contact of a corner, from the first force to the last); of
landings, a foot's first impact after a time without any (`landings.QUIET_S`); or of the normal
impulse, of relaxed legs that of a whole cascade under the type of its first impact."""

NOISE_RATIO = 0.5
"""Noise of the noisy plate, rms velocity over the drive's peak speed, in the scene's band: chosen
since with it the speed becomes proportional to the plate's; the paper does not state its plate's.
"""

SHORTER = 0.5
"""Length of runs in space over that of planar runs: their speeds scatter less."""


class Series(NamedTuple):
    """What the ensembles of a series have in common."""

    model: ModelName
    noise_ratio: float = 0.0


SERIES = {
    "relaxed": Series("relaxed"),
    "compliant": Series("compliant"),
    "rigid": Series("rigid"),
    "space": Series("space"),
    "space, noisy plate": Series("space", NOISE_RATIO),
    "space, braced": Series("space"),
}
"""Series of ensembles by their names in tables; the model in space runs on a plane."""


class Assumption(NamedTuple):
    """Assumption on the contact between foot and plate."""

    name: str
    scene: Scene

    @property
    def label(self) -> str:
        """Name and numbers of the assumption."""
        contact = self.scene.contact
        return f"{self.name}: e = {contact.restitution:g}, μ = {contact.friction:g}"


class Point(NamedTuple):
    """Results of one ensemble."""

    assumption: str
    model: str
    """One of SERIES."""
    tilt_deg: float
    plate_speed_mm_s: float
    """Peak speed of the plate."""
    speed: Value | None
    """Mean speed, mm/s, over runs that ended well; None where these are less than half of all."""
    impact_speed: Value | None
    """Mean normal speed of landings, mm/s."""
    shares: Mapping[tuple[str, str], Value]
    """Shares of impacts by (counting, one of TYPES or SUMS); empty without impacts."""
    lost: int
    """Number of runs that ended badly, as by toppling."""
    outcomes: str


def on_plane(scene: Scene, noise_ratio: float = 0.0) -> Scene:
    """Scene of the model in space: the same drive and contact on an open plane, without walls."""
    arena = scene.arena.model_copy(update={"kind": "plane", "gap_mm": None})
    legs = scene.legs.model_copy(update={"model": "space"})
    run = scene.run.model_copy(update={"step_us": None})
    plate = scene.plate
    if noise_ratio:
        plate = plate.model_copy(update={"noise_ratio": noise_ratio})
    changes = {"arena": arena, "legs": legs, "run": run, "plate": plate}
    return scene.model_copy(update=changes)


class Case(NamedTuple):
    """Contact, model and walker to simulate."""

    assumption: Assumption
    model: str
    """One of SERIES."""
    design: Design


def along_tilts(cases: Sequence[Case], tilts_deg: Sequence[float], progress: Progress) -> list[Point]:
    """Simulate every case at every tilt, on the drive of its scene."""
    tilted = [case._replace(design=case.design.variant(tilt_deg=tilt)) for case in cases for tilt in tilts_deg]
    return list(measured(tilted, progress))


def along_drives(cases: Sequence[Case], gammas: Sequence[float], progress: Progress) -> list[Point]:
    """Simulate every case at every peak acceleration (over g), keeping its frequency."""
    shaken = [
        case._replace(assumption=case.assumption._replace(scene=driven(case.assumption.scene, gamma)))
        for case in cases
        for gamma in gammas
    ]
    return list(measured(shaken, progress))


def driven(scene: Scene, gamma: float) -> Scene:
    """Scene with another amplitude of its drive, given by the peak acceleration over g."""
    cleared = {"amplitude_um": None, "peak_speed_mm_s": None}
    drive = scene.drive.model_copy(update=cleared | {"frequency_hz": scene.drive.frequency, "gamma": gamma})
    return scene.model_copy(update={"drive": drive})


def measured(cases: Sequence[Case], progress: Progress) -> Iterator[Point]:
    """Simulate every case as it is."""
    requests = [experiments.Walker(*_asked(case), impacts=True) for case in cases]
    titles = [f"{case.assumption.name}, {case.model}, {case.design.tilt_deg:g} deg" for case in cases]
    for case, point in zip(cases, walkers.each(requests, titles, progress), strict=True):
        yield _point(case, point)


def _asked(case: Case) -> tuple[Scene, Design, MassProperties]:
    scene, series = case.assumption.scene, SERIES[case.model]
    if series.model == "space":
        scene = on_plane(scene, series.noise_ratio)
        shorter = {"seconds": SHORTER * scene.run.seconds}
        scene = scene.model_copy(update={"run": scene.run.model_copy(update=shorter)})
    else:
        legs = scene.legs.model_copy(update={"model": series.model})
        scene = scene.model_copy(update={"legs": legs})
    return scene, case.design, solids.mass_of(case.design)


def check(case: Case) -> None:
    """Refuse a case that cannot be simulated. Raises InputError."""
    prepare(*_asked(case))


def _point(case: Case, point: experiments.Results) -> Point:
    """Point of a case, from its simulated runs and their impacts."""
    results = point.results
    good = [result for result in results if result.outcome in ENDED_WELL]
    corners = 2 if point.model == "space" else 1
    impacts = [_impacts(result, corners) for result in good]
    speeds = [float(of_run.speed[of_run.landing].mean()) for of_run in impacts if of_run.landing.any()]
    return Point(
        case.assumption.name,
        case.model,
        case.design.tilt_deg,
        case.assumption.scene.drive.peak_speed,
        mean([result.speed for result in good]) if 2 * len(good) >= len(results) else None,
        mean(speeds) if len(speeds) > 1 else None,
        _shares(good, impacts),
        len(results) - len(good),
        listed(dict(sorted(point.summary.outcomes.items()))),
    )


class _Impacts(NamedTuple):
    """Impacts of one run, arrays with an entry for each."""

    kind: npt.NDArray[np.int64]
    impulse: Array
    speed: Array
    """Normal speed before the impact, mm/s."""
    landing: npt.NDArray[np.bool_]


def _impacts(result: RunResult, corners: int = 1) -> _Impacts:
    """Impacts of a run whose events count so many corners to a foot."""
    impacts = landings.impacts_in(impacts_of(result))
    landing = landings.of_feet(impacts.time, impacts.foot // corners)
    return _Impacts(impacts.kind, impacts.F_y, -impacts.v_y, landing)


def _shares(results: Sequence[RunResult], impacts: Sequence[_Impacts]) -> dict[tuple[str, str], Value]:
    """Mean shares over the runs that have impacts; empty if fewer than two have."""
    rows = [
        (
            _of_counts(result.tally.counts),
            _of_events(of_run.kind, of_run.landing.astype(float)),
            _of_events(of_run.kind, of_run.impulse),
        )
        for result, of_run in zip(results, impacts, strict=True)
        if of_run.landing.any()
    ]
    if len(rows) < 2:
        return {}
    table = np.array(rows)
    row_of = {name: row for row, name in enumerate(TYPES)}
    places = {name: [row] for name, row in row_of.items()}
    places |= {name: [row_of[kind] for kind in kinds] for name, kinds in SUMS.items()}
    return {
        (counting, name): mean(list(table[:, row, columns].sum(axis=1)))
        for row, counting in enumerate(COUNTINGS)
        for name, columns in places.items()
    }


def _of_counts(counts: npt.NDArray[np.int64]) -> Array:
    """Shares in the order of TYPES from a tally."""
    rows = ([record.row_of(kind) for kind in kinds] for kinds in TYPES.values())
    amounts = [counts[own].sum() for own in rows]
    return np.array(amounts, dtype=np.float64) / float(counts[record.IMPACTS])


def _of_events(kind: npt.NDArray[np.int64], weights: Array) -> Array:
    """Shares in the order of TYPES from impacts with weights."""
    amounts = [float(weights[np.isin(kind, kinds)].sum()) for kinds in TYPES.values()]
    return np.array(amounts) / float(weights.sum())
