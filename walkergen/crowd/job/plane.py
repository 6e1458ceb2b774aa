"""A crowd in a plane: walkers by their cards, placed, moved by LAMMPS, and measured."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from walkergen.crowd import members
from walkergen.crowd import runs as jobs
from walkergen.crowd.card import Card
from walkergen.crowd.flat import crowd as flat
from walkergen.crowd.runs import Array, Job, Kind, Simulated
from walkergen.crowd.statistics import CrowdFilm, measure
from walkergen.crowd.statistics.film import of_places
from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.walker import seen_above

CONTACT = ("restitution", "friction")
"""Keys of a scene's [crowd] that replace a card's own where they are set."""


def asked(scene: Scene, cards: Sequence[Card], counts: Sequence[int] | None, rate_hz: float) -> Job:
    """Crowd of so many walkers of each card; without counts of one, as many as the scene says.

    Raises InputError for too many walkers or frames.
    """
    crowd = scene.crowd
    own = {key: getattr(crowd, key) for key in CONTACT if key in crowd.model_fields_set}
    kinds = []
    for number, card in enumerate(cards):
        outline = tuple(np.array(contour) for contour in card.outline_mm)
        area = seen_above.area_of(outline)
        walkers = members.number_of(scene, area) if counts is None else counts[number]
        kinds.append(Kind(card.name, walkers, outline, card=card.model_copy(update=own)))
    return jobs.checked(Job(scene, tuple(kinds), rate_hz, "flat"))


def simulate(job: Job, threads: int | None, progress: Progress) -> Simulated:
    """Place and simulate every run, a LAMMPS on each of `threads` threads, and measure them.

    Any number of threads gives equal bits. Ctrl-C gives the runs that were done, without any it is
    raised again. Raises InputError where a crowd has no room, and where LAMMPS is absent.
    """
    progress("placing", 0, 100)
    started, whole = time.perf_counter(), _seconds(job)

    def one(number: int, stopped: Callable[[], bool], told: Callable[[float], None]) -> CrowdFilm:
        def tell(what: str, frames: int, total: int) -> None:
            if stopped():
                raise KeyboardInterrupt  # ends LAMMPS, on this thread
            told(job.scene.run.seconds * frames / total)

        run = flat.simulate(**_arguments(job, number), progress=tell)
        kept = run.times >= job.scene.run.discard_seconds - 1e-9 * whole
        times = run.times[kept] - run.times[kept][0]
        return _film(job, times, run.poses[kept])

    films = tuple(jobs.on_threads(one, job, threads, progress))
    progress("measuring", 99, 100)
    return Simulated(job, films, (), measure(films), time.perf_counter() - started)


def inputs(job: Job) -> dict[str, bytes]:
    """Input of LAMMPS for every run, by names of files: run-N/crowd.in and what it reads."""
    return {
        f"run-{number}/{name}": data
        for number in range(job.scene.run.runs)
        for name, data in flat.files(**_arguments(job, number)).items()
    }


def _seconds(job: Job) -> float:
    """Time of a run with its start, s."""
    return job.scene.run.seconds + job.scene.run.discard_seconds


def _arguments(job: Job, number: int) -> dict[str, Any]:
    """What a run in a plane is asked for."""
    seed = int(np.random.SeedSequence([job.scene.run.seed, number]).generate_state(1)[0])
    places = jobs.placed(job, [kind.outline for kind in job.kinds], number)
    return {
        "cards": [kind.card for kind in job.kinds],
        "kinds": np.array(job.numbers),
        "dish": job.scene.crowd.dish,
        "places": places,
        "seconds": _seconds(job),
        "rate_hz": job.rate_hz,
        "seed": seed,
    }


def _film(job: Job, times: Array, poses: Array) -> CrowdFilm:
    """Film of a run, seen from above."""
    outlines = {kind.name: kind.outline for kind in job.kinds}
    names = [job.kinds[number].name for number in job.numbers]
    return of_places(times, poses, names, outlines, job.scene.crowd.dish)
