"""Frames without a new position: lost walkers stored at a fixed one, such as (0, 0), and copies of earlier frames."""

from collections.abc import Sequence

import numpy as np

from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.files import formatting
from walkergen.core.numerics import Array, Mask

MIN_JUMP_RATIO, MIN_RETURNS = 8.0, 3
"""Ratio of a jump to the largest usual step, and least number of returns to a place other than (0, 0) by jumps."""

MIN_STEP_QUANTA, MAX_COPIES = 10.0, 3
"""Least usual step over the resolution of places for copies to be none by chance, and most copies in a row."""

MIN_CATCH_UP = 1.5
"""Median step after one copy, over the usual one, above which the camera went on: 2 if it did, 1 if not."""


def drop(tracks: Tracks) -> Tracks:
    """Return tracks with NaN for lost walkers and repeated frames. Their note counts both and warns of copies."""
    place, cleaned, notes = _lost_place(tracks.tracks), list(tracks.tracks), []
    if place is not None:
        lost = [_is_lost(track.position, place) for track in cleaned]
        cleaned = [_without(track, each) for track, each in zip(cleaned, lost, strict=True)]
        where = ", ".join(formatting.format_number(float(value), 3) for value in place)
        count = sum(map(np.count_nonzero, lost))
        notes.append(f"{count} places at ({where}), far from those before and after, are lost frames: left out")
    repeated = _repeated_frames(cleaned)
    total = max(track.start + len(track.position) for track in cleaned)
    if repeated.any():
        catch_up = _catch_up(cleaned, repeated)
        words = f"{int(repeated.sum())} of {total} frames repeat the one before"
        if catch_up > MIN_CATCH_UP:
            cleaned = [_without(each, repeated[each.start : each.start + len(each.position)]) for each in cleaned]
            notes.append(f"{words}, and walkers catch up afterwards: lost frames, left out")
        else:
            share = 100.0 * float(repeated.sum()) / total
            notes.append(f"{words}: if the film holds these twice, speeds are {share:.2g} % too low: remove them")
    lines = [*notes, tracks.note]
    return tracks._replace(tracks=tuple(cleaned), note="; ".join(line for line in lines if line))


def _without(track: Track, lost: Mask) -> Track:
    """Return a track whose places and headings are unknown where they are lost."""
    if not lost.any():
        return track
    heading = None if track.heading is None else np.where(lost, np.nan, track.heading)
    return track._replace(position=np.where(lost[:, None], np.nan, track.position), heading=heading)


def _lost_place(tracks: Sequence[Track]) -> Array | None:
    """Return the exact place that walkers jump to and from: (0, 0), or another with MIN_RETURNS; None without one."""
    if tracks[0].position.shape[1] < 2:
        return None
    places = np.concatenate([track.position for track in tracks])
    unique, counts = np.unique(places[~np.isnan(places).any(axis=1)] @ np.array([1.0, 1.0j]), return_counts=True)
    frequent = unique[np.argsort(-counts)[: int(counts.max(initial=0) >= MIN_RETURNS)]]
    for place, least in ((np.zeros(2), 1), *((np.array([each.real, each.imag]), MIN_RETURNS) for each in frequent)):
        lost = [_is_lost(track.position, place) for track in tracks]
        if sum(int(np.count_nonzero(each[1:] & ~each[:-1])) + int(each[0]) for each in lost) >= least:
            return np.asarray(place)
    return None


def _is_lost(position: Array, place: Array) -> Mask:
    """Return whether each place is exactly `place`, and far from the places before and after, shape (times,)."""
    at = (position == place).all(axis=1)
    seen = np.flatnonzero(~np.isnan(position).any(axis=1) & ~at)
    if not at.any() or len(seen) < 3:
        return np.zeros(len(position), dtype=bool)
    steps = np.hypot(*np.diff(position[seen], axis=0).T) / np.diff(seen)
    usual = MIN_JUMP_RATIO * float(np.quantile(steps, 0.9))
    after = np.searchsorted(seen, np.arange(len(position)))
    near = np.minimum(
        np.hypot(*(position[seen[np.maximum(after - 1, 0)]] - place).T),
        np.hypot(*(position[seen[np.minimum(after, len(seen) - 1)]] - place).T),
    )
    return np.asarray(at & (near > usual))


def _repeated_frames(tracks: Sequence[Track]) -> Mask:
    """Return the frames, of all tracks together, in which every walker is exactly where it was in the frame before."""
    total = max(track.start + len(track.position) for track in tracks)
    same, pairs = np.zeros(total, dtype=int), np.zeros(total, dtype=int)
    moved = [np.diff(track.position, axis=0) for track in tracks]
    for track, steps in zip(tracks, moved, strict=True):
        known = ~np.isnan(steps).any(axis=1)
        at = slice(track.start + 1, track.start + len(track.position))
        pairs[at] += known
        same[at] += known & (steps == 0.0).all(axis=1)
    changes = np.abs(np.concatenate(moved))
    changes = changes[changes > 0.0]
    repeated = (same == pairs) & (pairs > 0)
    if not len(changes) or np.median(changes) < MIN_STEP_QUANTA * changes.min():
        return np.zeros(total, dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], repeated, [False]]).astype(int)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if last - first > MAX_COPIES:  # walkers at rest
            repeated[first:last] = False
    return np.asarray(repeated)


def _catch_up(tracks: Sequence[Track], repeated: Mask) -> float:
    """Return the median step after a single copy, over the median of all other steps."""
    after, others = [], []
    alone = repeated[1:] & ~np.append(repeated[2:], True) & ~repeated[:-1]
    follows = np.concatenate([[False, False], alone[:-1]])
    for track in tracks:
        steps = np.linalg.norm(np.diff(track.position, axis=0), axis=1)
        here = slice(track.start + 1, track.start + len(track.position))
        after.append(steps[follows[here] & (steps > 0.0)])
        others.append(steps[~follows[here] & ~repeated[here] & (steps > 0.0)])
    late, usual = np.concatenate(after), np.concatenate(others)
    return float(np.median(late) / np.median(usual)) if len(late) and len(usual) else 0.0
