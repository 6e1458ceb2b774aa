"""Sweeps: mean speeds, impact speeds and types of impacts along the tilt and the plate's speed."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.simulation import engines, ensemble, record
from walkergen.simulation.effects import ModelName
from walkergen.simulation.run import Outcome, RunResult
from walkergen.walker import solids
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

TYPES = ("III", "II", "I", "IV", "from rest", "mirrored")
"""Types of impacts; from rest: v_x = 0 exactly before; mirrored: II or III of a foot that slides
backward before."""

SUMS = {"II+III": ("II", "III"), "II+III+rest": ("II", "III", "from rest"),
        "III+rest": ("III", "from rest")}  # fmt: skip
"""Shares taken together: an impact from rest is the limit of type III for v_x to 0."""

COUNTINGS = ("every impact", "landings", "by impulse")
"""What a share is taken of: all impacts, chatter included (of relaxed legs a cascade's geometric
tail counts once); landings, a foot's first impact after QUIET without one; or the normal impulse,
of relaxed legs that of a whole cascade under the type of its first impact."""

QUIET = 1e-3
"""s; a flexible leg's contact takes some 0.4 ms, a period of the paper's drive 11 ms."""

EVENTS_PER_S = 2500.0
"""First room for impacts: some 1500 per second are seen at the paper's drive."""


class Assumption(NamedTuple):
    """What is assumed of the contact between foot and plate."""

    name: str
    scene: Scene

    @property
    def label(self) -> str:
        """Name and numbers."""
        contact = self.scene.contact
        return f"{self.name}: e = {contact.restitution:g}, μ = {contact.friction:g}"


class Value(NamedTuple):
    """A mean over independent runs."""

    mean: float
    se: float
    """Standard error."""


class Point(NamedTuple):
    """One ensemble."""

    assumption: str
    model: ModelName
    tilt_deg: float
    plate_speed_mm_s: float
    """Peak speed of the plate."""
    speed: Value | None
    """mm/s, over the runs that ended well; None where that is less than half of them."""
    impact_speed: Value | None
    """Mean normal speed of landings, mm/s."""
    shares: Mapping[tuple[str, str], Value]
    """By (counting, one of TYPES or SUMS); empty without impacts."""
    lost: int
    """Runs that ended badly: toppled, for instance."""
    outcomes: str


class Case(NamedTuple):
    """What to simulate."""

    assumption: Assumption
    model: ModelName
    design: Design


def along_tilts(
    cases: Sequence[Case], tilts_deg: Sequence[float], progress: Progress
) -> list[Point]:
    """Every case at every tilt, on the drive of its scene."""
    asked = [
        case._replace(design=case.design.variant(tilt_deg=tilt))
        for case in cases
        for tilt in tilts_deg
    ]
    return list(_measured(asked, progress))


def along_drives(cases: Sequence[Case], gammas: Sequence[float], progress: Progress) -> list[Point]:
    """Every case at every peak acceleration (over g), its frequency kept."""
    asked = [
        case._replace(assumption=case.assumption._replace(scene=driven(case.assumption.scene, one)))
        for case in cases
        for one in gammas
    ]
    return list(_measured(asked, progress))


def driven(scene: Scene, gamma: float) -> Scene:
    """The scene with another amplitude of its drive, given by the peak acceleration over g."""
    cleared = {"amplitude_um": None, "peak_speed_mm_s": None}
    drive = scene.drive.model_copy(
        update=cleared | {"frequency_hz": scene.drive.frequency, "gamma": gamma}
    )
    return scene.model_copy(update={"drive": drive})


def _measured(cases: Sequence[Case], progress: Progress) -> Iterator[Point]:
    for number, case in enumerate(cases):
        what = f"{case.assumption.name}, {case.model}, {case.design.legs.tilt_deg:g} deg"

        def told(_: str, done: int, of: int, number: int = number, what: str = what) -> None:
            progress(what, number * of + done, len(cases) * of)

        yield measure(case, told)


def measure(case: Case, progress: Progress) -> Point:
    """One ensemble as the scene's [run] says, with its impacts; Ctrl-C raises."""
    scene, model = case.assumption.scene, case.model
    scene = scene.model_copy(update={"legs": scene.legs.model_copy(update={"model": model})})
    mass = solids.mass_of(case.design)
    engine = engines.prepare(scene, case.design, mass).engine
    room, full = math.ceil(EVENTS_PER_S * scene.run.seconds), True
    while full:  # runs are deterministic: the same again, with room for all their impacts
        summary, results = ensemble.measure(engine, scene, progress, event_room=room)
        if summary.runs < scene.run.runs:
            raise KeyboardInterrupt
        full = any(len(_rows(result)) == room for result in results)
        room *= 2
    good = [result for result in results if result.outcome in (Outcome.OK, Outcome.STUCK)]
    impacts = [_impacts(result) for result in good]
    speeds = [float(one.speed[one.landing].mean()) for one in impacts if one.landing.any()]
    return Point(
        case.assumption.name,
        model,
        case.design.legs.tilt_deg,
        scene.drive.peak_speed,
        mean([result.speed for result in good]) if 2 * len(good) >= len(results) else None,
        mean(speeds) if len(speeds) > 1 else None,
        _shares(good, impacts),
        len(results) - len(good),
        ", ".join(f"{count} {name}" for name, count in sorted(summary.outcomes.items())),
    )


def mean(values: Sequence[float]) -> Value:
    """Mean and standard error of at least two independent values."""
    return Value(float(np.mean(values)), float(np.std(values, ddof=1) / math.sqrt(len(values))))


class _Impacts(NamedTuple):
    """The events of one run."""

    kind: npt.NDArray[np.int64]
    impulse: Array
    speed: Array
    """Normal speed before, mm/s."""
    landing: npt.NDArray[np.bool_]


def _impacts(result: RunResult) -> _Impacts:
    rows = _rows(result)
    landing = np.zeros(len(rows), dtype=bool)
    for foot in (0, 1):
        (own,) = np.nonzero(rows[:, 1] == foot)
        landing[own] = np.diff(rows[own, 0], prepend=-math.inf) > QUIET
    return _Impacts(rows[:, 6].astype(np.int64), rows[:, 3], -rows[:, 5], landing)


def _rows(result: RunResult) -> Array:
    events = result.tally.events
    assert events is not None
    return np.asarray(events.rows[: events.cursor[0]])


def _shares(
    results: Sequence[RunResult], impacts: Sequence[_Impacts]
) -> dict[tuple[str, str], Value]:
    """Mean over the runs that have impacts, which has to be two at least."""
    rows = [
        (_of_counts(result.tally.counts), _of_events(one.kind, one.landing.astype(float)),
         _of_events(one.kind, one.impulse))
        for result, one in zip(results, impacts, strict=True)
        if one.landing.any()
    ]  # fmt: skip
    if len(rows) < 2:
        return {}
    table = np.array(rows)
    places = {kind: [TYPES.index(kind)] for kind in TYPES}
    places |= {name: [TYPES.index(kind) for kind in kinds] for name, kinds in SUMS.items()}
    return {
        (counting, name): mean(list(table[:, row, columns].sum(axis=1)))
        for row, counting in enumerate(COUNTINGS)
        for name, columns in places.items()
    }


def _of_counts(counts: npt.NDArray[np.int64]) -> Array:
    """Shares in the order of TYPES from a tally."""
    first, second, third, fourth, rest = counts[1:6]
    mirrored = counts[6 : record.STICKING].sum()
    listed = np.array([third, second, first, fourth, rest, mirrored], dtype=np.float64)
    return listed / float(counts[record.IMPACTS])


def _of_events(kind: npt.NDArray[np.int64], weights: Array) -> Array:
    of_types = ((3,), (2,), (1,), (4,), (5,), (-2, -3))
    sums = [float(weights[np.isin(kind, numbers)].sum()) for numbers in of_types]
    return np.array(sums) / float(weights.sum())
