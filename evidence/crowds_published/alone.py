"""Walkers alone, beside which their crowds stand: how fast they run, and how much they spin."""

import math
from collections.abc import Sequence

import numpy as np

from evidence.crowds_published.cases import Case
from walkergen.analysis.values import Value, mean
from walkergen.simulation import experiments
from walkergen.simulation.run import ENDED_WELL, RunResult
from walkergen.simulation.trajectory import sampled
from walkergen.walker import solids

INTERVAL = 0.02
"""Time between samples, s."""

LAG = 5
"""Samples over which a speed is taken, as that of a crowd's walkers (`crowd_numbers`)."""


def asked(cases: Sequence[Case]) -> list[experiments.Experiment]:
    """Experiments of walkers alone, on an open plane."""
    return [
        experiments.Experiment(case.scene, case.design, solids.mass_of(case.design), sample_interval=INTERVAL)
        for case in cases
    ]


def numbers(case: Case, results: Sequence[RunResult]) -> dict[str, Value]:
    """Speed and its spread between prints (mm/s), and the spin: turning x half length / speed."""
    good = [result for result in results if result.outcome in ENDED_WELL]
    if len(good) < 2:
        return {}
    forward, paths, turns = [], [], []
    for result in good:
        rows = sampled(result)
        place = rows[:, 1] + 1j * rows[:, 2]
        seconds = float(rows[LAG, 0] - rows[0, 0])
        paths.append(float(np.abs(place[LAG:] - place[:-LAG]).mean() / seconds))
        turns.append(abs(float(rows[-1, 3] - rows[0, 3])) / float(rows[-1, 0] - rows[0, 0]))
        forward.append(result.speed)
    half = 0.5 * case.design.size.length
    spins = [half * turn / path for turn, path in zip(turns, paths, strict=True)]
    sd = float(np.std(forward, ddof=1))
    return {
        "forward": mean(forward),
        "between prints": Value(sd, sd / math.sqrt(2 * len(good) - 2)),
        "speed": mean(paths),
        "spin": mean(spins),
    }
