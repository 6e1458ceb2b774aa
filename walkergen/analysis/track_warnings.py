"""Reasons to doubt tracks: headings that do not fit, jumps, walkers in fragments."""

import math
from collections.abc import Sequence

import numpy as np

from walkergen.analysis import moments
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.files import formatting
from walkergen.core.numerics import Array, Whole
from walkergen.core.numerics.distributions import student_quantile

MAX_FLIP_SHARE = 0.01
"""Maximum share of steps with a turn of more than 90 deg; with more, headings look wrong."""

HEADING_P_VALUE = 1e-3
"""Probability of a doubt about headings that displacements give by chance (Student's t)."""

MIN_JUMP_RATIO, MIN_LOCAL_JUMP_RATIO, JUMP_NEIGHBOURS = 8.0, 10.0, 8
"""Ratio of a jump to what 9 of 10 steps of all walkers stay below, and to the median of as many
steps of the same walker before it and after it; diffusion alone gives up to 3."""


def find_all(tracks: Tracks) -> list[str]:
    """Return all reasons to doubt the tracks of a film, as text."""
    groups, _ = moments.independent_samples(tracks.tracks)
    headed = not tracks.lane and any(track.heading is not None for track in tracks.tracks)
    of_headings = _flip_doubts(tracks.tracks) + _rotation_doubts(groups) if headed else []
    return [*of_headings, *_jump_doubts(tracks), *_fragment_doubts(tracks.tracks)]


def describe_scale_error(share: float | None) -> str:
    """Describe the effect of the scale's relative error `share` (None: unknown). '' if it is 0, as in a simulation."""
    if share is None:
        return "the scale's error is unknown and not included: give it with the scale, as ‹mm_per_px=›0.05+-0.001"
    if not share:
        return ""
    return (
        f"the scale is off by {formatting.format_number(100.0 * share, 2)} % (standard error): all lengths and "
        "speeds together, so that more walkers or time do not help; squares of them by twice that"
    )


def _flip_doubts(tracks: Sequence[Track]) -> list[str]:
    """Return a warning, in a list, if headings often flip by half a turn; else []."""
    flips = pairs = 0
    for track in tracks:
        unit = moments.direction_vectors(track, 1)
        turned = np.abs(np.angle(unit[1:] * np.conj(unit[:-1])))
        flips += int(np.count_nonzero(turned > 0.5 * math.pi))
        pairs += int(np.count_nonzero(~np.isnan(turned)))
    if flips <= MAX_FLIP_SHARE * pairs:
        return []
    return [
        f"headings turn by more than 90 deg in {flips} of {pairs} steps: are they known only up to "
        "a half turn? Speeds along and across the body are then wrong"
    ]


def _rotation_doubts(groups: Sequence[Sequence[Track]]) -> list[str]:
    """Return a warning, in a list, if headings fit displacements only when turned or mirrored; else []."""
    sums = np.zeros((len(groups), 2), dtype=complex)
    for number, group in enumerate(groups):
        for track in group:
            unit, moved = moments.direction_vectors(track, 1)[:-1], np.diff(moments.complex_position(track))
            sums[number] += np.nansum(moved * np.conj(unit)), np.nansum(moved * unit)
    if len(groups) < 2:
        return []
    error = np.sqrt(len(groups) * (np.abs(sums - sums.mean(axis=0)) ** 2).sum(axis=0))
    along, mirrored = sums.sum(axis=0)
    least = student_quantile(len(groups) - 1, 1.0 - HEADING_P_VALUE) * error / math.sqrt(len(groups) - 1)
    if abs(mirrored) > max(2.0 * abs(along), least[1]):
        return [
            "displacements fit the headings only when these are mirrored: theta has to count from "
            "x toward y of the file's own axes"
        ]
    angle = math.degrees(np.angle(along))
    if abs(along) <= least[0] or abs(angle) < 45.0:
        return []
    if abs(angle) > 135.0:
        return ["walkers run backwards along their headings: is theta turned by 180 deg?"]
    return [f"walkers run at {angle:.0f} deg to their headings: is theta, or x and y, turned by 90?"]


def _jump_doubts(tracks: Tracks) -> list[str]:
    """Return a warning, in a list, about steps far beyond all others, as of exchanged walkers; else []."""
    jumps, steps = [], [_track_steps(track) for track in tracks.tracks]
    usual = np.concatenate([step for _, step in steps])
    if not len(usual):
        return []
    limit = MIN_JUMP_RATIO * float(np.quantile(usual, 0.9))
    for track, (at, step) in zip(tracks.tracks, steps, strict=True):
        for number in np.flatnonzero(step > limit):
            near = step[max(number - JUMP_NEIGHBOURS, 0) : number + JUMP_NEIGHBOURS + 1]
            if step[number] > MIN_LOCAL_JUMP_RATIO * np.median(near):
                first, last = at[number : number + 2]
                length = float(step[number] * (last - first))
                jumps.append((length, track.particle, (track.start + last) * tracks.interval))
    if not jumps:
        return []
    length, particle, time = max(jumps)
    return [
        f"jumps in tracks, {len(jumps)} in all, the largest of {length:.3g} mm by particle "
        f"{particle} at {time:.4g} s: were two walkers taken for one another? Cut the tracks there "
        "(give each part a new number): every number here suffers"
    ]


def _track_steps(track: Track) -> tuple[Whole, Array]:
    """Return the samples at which a walker was seen, and its steps between them, mm per sample."""
    position = moments.complex_position(track)
    samples = np.flatnonzero(~np.isnan(position))
    return samples, np.abs(np.diff(position[samples])) / np.diff(samples)


def _fragment_doubts(tracks: Sequence[Track]) -> list[str]:
    """Return a warning, in a list, if there are more tracks than walkers seen at any one time; else []."""
    plates = {track.plate_speed for track in tracks}
    most = sum(_max_simultaneous([t for t in tracks if t.plate_speed == plate]) for plate in plates)
    if most == len(tracks):
        return []
    return [
        f"{len(tracks)} tracks, but at most {most} at one time: if some are fragments of the "
        "same walkers, they are fewer independent samples than counted, and errors up to "
        f"{math.sqrt(len(tracks) / most):.2g} times as large: link them again over longer gaps"
    ]


def _max_simultaneous(tracks: Sequence[Track]) -> int:
    """Return the largest number of tracks at one time."""
    begins = np.sort([track.start for track in tracks])
    ends = np.sort([track.start + len(track.position) for track in tracks])
    return int((np.arange(1, len(begins) + 1) - np.searchsorted(ends, begins, "right")).max())
