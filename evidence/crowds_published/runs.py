"""Runs of the crowds that stand beside published ones, as films, and their numbers."""

import numpy as np

from evidence.crowds_published import numbers as crowd_numbers
from evidence.crowds_published.cases import Case
from walkergen.analysis.values import Value, mean
from walkergen.crowd import in_space as crowd_space
from walkergen.crowd.runs import Simulated
from walkergen.files.progress import Progress

RATE_HZ = 20.0
"""Frames a second: two in the time over which velocities are taken."""

REACH = 1.25
"""Distance up to which walkers are neighbours, in lengths of their bodies."""


def simulated(case: Case, progress: Progress) -> Simulated:
    """All runs of a crowd; equal on any number of threads. Ctrl-C is raised again."""

    def told(_: str, done: int, of: int) -> None:
        progress(f"{case.series} {case.setting:g}", done, of)

    job = crowd_space.asked(case.scene, [case.design], None, RATE_HZ)
    crowd = crowd_space.simulate(job, None, told)
    if len(crowd.runs) < case.scene.run.runs:  # those that Ctrl-C left would be another sample
        raise KeyboardInterrupt
    return crowd


def numbers(crowd: Simulated, length: float) -> dict[str, Value]:
    """Numbers of a crowd of bodies of this length (mm), means over its runs."""
    shown, by_run = crowd.films, crowd.statistics.by_run
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
