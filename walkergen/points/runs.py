"""Simulated runs as the analysis of films takes them: tracks, and the motion that they tell."""

from collections.abc import Sequence

from walkergen.analysis import motion
from walkergen.analysis.motion import Motion
from walkergen.analysis.tracks import Tracks, of_places
from walkergen.simulation import trajectory
from walkergen.simulation.run import RunResult


def tracks_of(results: Sequence[RunResult], lane: bool, interval: float | None) -> Tracks:
    """Tracks of runs, seen from above: their samples `interval` s apart, or the ends of blocks.

    In a lane only the way along it counts, as in a film of one.
    """
    if interval is None:
        return of_places([result.places for result in results], results[0].block_s, lane)
    return of_places([trajectory.sampled(result)[:, 1:4] for result in results], interval, lane)


def motion_of(results: Sequence[RunResult], lane: bool, interval: float | None = None) -> tuple[Motion | None, str]:
    """Motion of at least one run in space; None for runs too short to tell, with the reason."""
    tracks = tracks_of(results, lane, interval)
    longest = tracks.interval * max(len(track.position) - 1 for track in tracks.tracks)
    least = max(motion.LAG_S, tracks.interval)
    if longest > 1.001 * least:
        return motion.analyse(tracks), ""
    return None, f"runs of {longest:.3g} s are too short; at least {2 * least:.2g} s"
