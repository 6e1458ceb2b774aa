"""Motion on a plane, as in figure 6: tracks of runs in space, and how their squared displacement grows."""

from collections.abc import Sequence
from typing import NamedTuple

from evidence.reproduce import growth
from evidence.reproduce.growth import Growth
from evidence.reproduce.runs import FIGURE6_LENGTH_RATIO, Assumption, move_to_plane
from walkergen.analysis import motion
from walkergen.analysis.motion import Motion
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity, mean
from walkergen.core.simulation.run import ENDED_WELL, RunResult
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import walkers
from walkergen.points.experiments import Walker
from walkergen.points.trajectory import sample_rows

SAMPLE_INTERVAL_S = 4e-3
"""Time between samples of a track, s: a tenth of the lag of figure 6c."""


class Runs(NamedTuple):
    """Runs of one walker on a plane, over those that ended well."""

    assumption: str
    tilt_deg: float
    tracks: Tracks
    motion: Motion
    """Statistics by the analysis that films go through."""
    growth: Growth
    speed: Quantity
    """Mean speed along the heading, mm/s."""
    lost: int
    """Number of runs that ended badly."""


def simulate_plane(assumptions: Sequence[Assumption], designs: Sequence[Design], progress: Progress) -> list[Runs]:
    """Simulate walkers on a plane under every assumption; ensembles without two good runs are left out."""
    cases = [(assumption, design) for assumption in assumptions for design in designs]
    wanted = [
        Walker(
            move_to_plane(assumption.scene, FIGURE6_LENGTH_RATIO),
            design,
            solids.mass_of(design),
            sample_interval=SAMPLE_INTERVAL_S,
        )
        for assumption, design in cases
    ]
    titles = [f"{assumption.name}, on a plane, {design.tilt_deg:g} deg" for assumption, design in cases]
    points = walkers.simulate_each(wanted, titles, progress)
    every = [
        analyse_runs(case[0].name, case[1].tilt_deg, point.results) for case, point in zip(cases, points, strict=True)
    ]
    return [runs for runs in every if runs is not None]


def analyse_runs(assumption: str, tilt_deg: float, results: Sequence[RunResult]) -> Runs | None:
    """Statistics of runs with their samples; None when fewer than two ended well."""
    good = [result for result in results if result.outcome in ENDED_WELL]
    if len(good) < 2:
        return None
    rows = [sample_rows(result) for result in good]
    whole = (Track(result.number, row[:, 1:3].copy(), row[:, 3].copy()) for result, row in zip(good, rows, strict=True))
    tracks = Tracks(tuple(whole), SAMPLE_INTERVAL_S, 0, "")
    speed = mean("speed", "mm_s", [result.speed for result in good])
    return Runs(
        assumption,
        tilt_deg,
        tracks,
        motion.analyse(tracks),
        growth.measure_growth(tracks),
        speed,
        len(results) - len(good),
    )
