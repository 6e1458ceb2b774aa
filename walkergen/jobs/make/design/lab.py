"""Trials: values of the keys that vary, evaluated, and what the wish makes of the numbers."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.errors import WalkergenError
from walkergen.files.config import validate
from walkergen.files.progress import Progress, stretch
from walkergen.jobs.make.design import wish as wishes
from walkergen.jobs.make.design.box import Box
from walkergen.jobs.make.design.wish import Seen, Wish
from walkergen.points.point import PREDICTION, WENT, Point, Record, Went, refused
from walkergen.points.request import changed
from walkergen.points.run import Asked, each
from walkergen.points.store import Store
from walkergen.points.tolerance import Tolerance
from walkergen.points.worker_pool import WorkerPool
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

FRICTION = "scene.contact.friction"
"""Key of the friction by which speeds are differentiated."""

FRICTION_STEP = {True: 0.2, False: 0.05}
"""Relative step to either side by which a speed is differentiated by friction: with runs, whose
errors a small step would magnify, and of predictions."""


class Effort(NamedTuple):
    """Runs of a trial."""

    runs: int
    seconds: float
    """Measured time of each, s."""


class Efforts(NamedTuple):
    """Efforts of a search."""

    spread: Effort
    """That of trials spread over the box."""
    close: Effort
    """That of trials near the wish."""
    verification: Effort
    """That of a verification that no error stops."""


IN_A_PLANE = Efforts(Effort(8, 2.0), Effort(24, 4.0), Effort(48, 4.0))

IN_SPACE = Efforts(Effort(8, 1.0), Effort(12, 3.0), Effort(16, 4.0))
"""Efforts of the model in space, a fifth as fast, whose step is a larger error than its runs."""

TURNING = Efforts(Effort(16, 6.0), Effort(24, 12.0), Effort(32, 16.0))
"""Efforts for what only longer runs tell: persistence and turning."""


class Job(NamedTuple):
    """Search for designs: what is wished, of what, where, and how."""

    wish: Wish
    design: Design
    scene: Scene
    box: Box
    printer: Printer
    model: str
    """One of `points.point.MODELS`, but not "auto"."""
    seed: int

    @property
    def simulated(self) -> bool:
        """True when runs are made."""
        return self.model != PREDICTION

    @property
    def efforts(self) -> Efforts:
        """Efforts of the search, by what is wished and the model."""
        if self.wish.asks_space:
            return TURNING
        return IN_SPACE if self.model == "space" else IN_A_PLANE


PREDICTED_S, PROPOSED_S = 0.3, 20.0
"""Time that costs as much, if simulated, as a prediction with its checks, and as designs to be proposed, s."""


class Bench(NamedTuple):
    """Where points are evaluated, and who is told."""

    store: Store
    pool: WorkerPool | None
    progress: Progress

    def at(self, begin: float, end: float) -> "Bench":
        """Bench on which a stretch of the whole job is done, from one share to another."""
        return self._replace(progress=stretch(self.progress, begin, end))


class Trial(NamedTuple):
    """Evaluated values of the keys that vary."""

    values: dict[str, float]
    record: Record
    seen: Seen | None
    """Value of the wish's quantity; None where there is none."""
    slope: Seen | None
    """Change of the speed with friction, mm/s; None unless the wish asks for it."""

    @property
    def runs(self) -> int:
        """Number of runs behind it; 0 if predicted."""
        runs = self.record.get("runs")
        return runs if isinstance(runs, int) else 0

    @property
    def buildable(self) -> bool:
        """True when it can be built."""
        return self.record[WENT] != Went.REFUSED

    @property
    def printable(self) -> bool:
        """True when it can be built, and the printer's checks find no error."""
        return self.buildable and not self.record.get("print_errors")

    @property
    def usable(self) -> bool:
        """True when it may be chosen: printable, with the numbers that the wish asks for."""
        return self.printable and wishes.ended_well(self.record) and self.seen is not None


def built(job: Job, values: Mapping[str, float]) -> tuple[Design, Scene]:
    """Design and scene at values of the keys; the design's family is itself alone.

    Raises InputError and GeometryError for what cannot be built.
    """
    design, scene = job.design, job.scene
    if design.marks.kind == "notches":  # numbered by the family, of which the first mark is one
        design = design.unmarked
    design, scene = changed(design, scene, values, "--vary")
    data = design.model_dump(exclude_unset=True)
    data["marks"] = job.design.marks.model_dump(exclude_unset=True)
    data["family"] = {"tilt_deg": [design.tilt_deg], "legs": [design.kind]}
    return validate(data, Design, "--vary"), scene


def tried(
    job: Job,
    bench: Bench,
    rows: Sequence[Mapping[str, float]],
    effort: Effort | None,
    what: str,
    seed: int | None = None,
) -> list[Trial]:
    """Trials of values, predicted unless an effort is given, in their order.

    Runs have the seed of the job, the same for all, unless another is given.
    """
    requests: list[Asked] = []
    for row in rows:
        try:
            design, scene = built(job, row)
        except WalkergenError as error:
            requests += [refused(error)] * parts(job, effort)
            continue
        requests += points(job, design, scene, effort, None, job.seed if seed is None else seed)
    return read(job, bench, rows, requests, effort, what)


def read(
    job: Job,
    bench: Bench,
    rows: Sequence[Mapping[str, float]],
    requests: Sequence[Asked],
    effort: Effort | None,
    what: str,
) -> list[Trial]:
    """Trials of values whose points are already made, `parts` of them a row."""
    records, size = [], parts(job, effort)
    bench.progress(what, 0, len(rows))
    for number, done in enumerate(each(requests, bench.store, bench.pool), start=1):
        records.append(done.record)
        bench.progress(what, number // size, len(rows))
    return [_trial(job, dict(row), records[size * place : size * (place + 1)]) for place, row in enumerate(rows)]


def parts(job: Job, effort: Effort | None) -> int:
    """Number of points of a trial: with the slope in friction, one to either side as well."""
    return 3 if job.wish.calm and (effort is not None or not job.simulated) else 1


def cost(job: Job, effort: Effort | None) -> float:
    """Simulated time that costs as much as a trial, s."""
    each = PREDICTED_S if effort is None else effort.runs * min(effort.seconds, job.scene.run.seconds)
    return parts(job, effort) * each


def points(
    job: Job, design: Design, scene: Scene, effort: Effort | None, wanted: Tolerance | None, seed: int
) -> list[Point]:
    """Points of a trial: of the design in the scene and, if asked, at less and more friction."""
    simulated = effort is not None
    keep: tuple[str, ...] = ("speed", "printability")
    if effort is not None:
        seconds = min(effort.seconds, scene.run.seconds)
        run = scene.run.model_copy(update={"runs": effort.runs, "seconds": seconds, "seed": seed})
        legs = scene.legs.model_copy(update={"model": job.model})
        scene = scene.model_copy(update={"run": run, "legs": legs})
    if simulated and job.wish.asks_space:
        keep = (*keep, "persistence" if job.wish.way is None else "alignment")
    first = Point(design, scene, simulated, keep, wanted, job.printer)
    if parts(job, effort) == 1:
        return [first]
    sides = [first._replace(scene=_rubbing(scene, factor), keep=("speed",), printer=None) for factor in _factors(job)]
    return [first, *sides]


def _factors(job: Job) -> tuple[float, float]:
    step = FRICTION_STEP[job.simulated]
    return 1.0 - step, 1.0 + step


def _rubbing(scene: Scene, factor: float) -> Scene:
    """Scene with another friction."""
    friction = {"friction": scene.contact.friction * factor}
    return scene.model_copy(update={"contact": scene.contact.model_copy(update=friction)})


def _trial(job: Job, values: dict[str, float], records: Sequence[Record]) -> Trial:
    record = records[0]
    predicted = "runs" not in record  # of which the speed alone is known
    seen = wishes.seen(record, "speed" if predicted else job.wish.of)
    if len(records) == 1:
        return Trial(values, record, seen, None)
    low, high = (wishes.seen(other, "speed") for other in records[1:])
    if low is None or high is None:
        return Trial(values, record, None, None)
    below, above = _factors(job)
    span = (above - below) * values.get(FRICTION, job.scene.contact.friction)
    slope = Seen((high.value - low.value) / span, math.hypot(low.se, high.se) / span)
    return Trial(values, record, seen, slope)


def fresh_seed(seed: int) -> int:
    """Seed of verifications, drawn from that of the runs that chose."""
    return int(np.random.SeedSequence([seed, 1]).generate_state(1)[0])
