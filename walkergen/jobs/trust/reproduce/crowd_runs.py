"""Runs of the crowds that stand beside published ones, as films, and their numbers."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from walkergen.analysis.crowds import CrowdFilm, measure
from walkergen.analysis.crowds.film import of_places
from walkergen.analysis.values import Value, mean
from walkergen.files.progress import Progress
from walkergen.jobs.trust.reproduce import crowd_numbers
from walkergen.jobs.trust.reproduce.crowd_cases import Case
from walkergen.simulation.crowd import run as crowds
from walkergen.simulation.crowd.placing import place
from walkergen.walker import seen_above, solids

RATE_HZ = 20.0
"""Frames a second: two in the time over which velocities are taken."""

CLEARANCE_MM = 0.2
"""Least distance of bodies at the start."""

REACH = 1.25
"""Distance up to which walkers are neighbours, in lengths of their bodies."""


def films(case: Case, progress: Progress) -> list[CrowdFilm]:
    """Films of all runs of a crowd; equal on any number of threads. Ctrl-C is raised again."""
    design, scene = case.design, case.scene
    mass = solids.mass_of(design)
    outline = tuple(seen_above.outline_of(design, mass))
    dish, seed = scene.crowd.dish, scene.run.seed
    count = max(round((scene.crowd.packing or 0.0) * dish.area / seen_above.area_of(outline)), 2)
    numbers = range(scene.run.runs)

    def placed(number: int) -> crowds.CrowdPlan:
        rng = np.random.default_rng(np.random.SeedSequence([seed, number], spawn_key=(1,)))
        places = place([outline] * count, dish, rng, CLEARANCE_MM)
        return crowds.prepare(scene, [(design, mass)], [0] * count, places)

    plans = [placed(number) for number in numbers]
    stop: list[bool] = []
    pool = ThreadPoolExecutor(os.cpu_count() or 1)
    try:
        tasks = [
            pool.submit(crowds.simulate, plans[number], number, RATE_HZ, lambda: bool(stop))
            for number in numbers
        ]
        runs = []
        for number, task in enumerate(tasks):
            progress(f"{case.series} {case.setting:g}", number, len(tasks))
            runs.append(task.result())
    finally:
        stop.append(True)
        pool.shutdown(cancel_futures=True)
    outlines = {design.name: outline}
    return [of_places(run.times, run.poses, run.kinds, outlines, dish) for run in runs]


def numbers(shown: Sequence[CrowdFilm], length: float) -> dict[str, Value]:
    """Numbers of a crowd of bodies of this length (mm), means over its runs."""
    by_run = measure(shown).by_run
    own = {
        "order": [crowd_numbers.order(film) for film in shown],
        "speed": [crowd_numbers.speed(film) for film in shown],
        "agreement": [crowd_numbers.agreement(film, REACH * length) for film in shown],
        "clustered": list(1.0 - by_run["alone"]),
        "largest": list(by_run["largest_cluster"]),
        "near": list(by_run["local_polar_order"]),
    }
    if not shown[0].dish.period:
        own["circulation"] = [crowd_numbers.circulation(film) for film in shown]
        own["at wall"] = list(by_run["wall_density"])
    return {name: mean(values) for name, values in own.items() if np.isfinite(values).all()}
