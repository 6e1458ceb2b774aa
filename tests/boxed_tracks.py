"""Tracks of active particles between walls, many films together, with known numbers.

A particle runs at a constant speed along a heading that diffuses (active Brownian motion). At a wall it
slides, or is turned along it, or is mirrored. Nothing here is the package's own.
"""

from typing import NamedTuple

import numpy as np

from walkergen.analysis.tracks import Track, Tracks

SUBSTEPS = 4
TURNED = 10.0
"""Rate at which a wall turns a heading away from itself, rad/s."""


class Boxed(NamedTuple):
    speed: float = 60.0  # mm/s, or px/s
    persistence: float = 2.0  # s
    box: tuple[float, float] = (150.0, 150.0)
    wall: str = "slide"  # slide, turn or mirror
    fps: float = 30.0
    noise: float = 0.1  # of a place, each axis
    heading_noise: float = 0.05  # rad
    lost: float = 0.05  # share of the frames without it
    turn: float = 0.0  # mean rate of turning, rad/s


def films(seed, count, seconds, boxed=Boxed(), headed=False):  # noqa: B008
    """Films of one particle each, `seconds` long."""
    rng, h = np.random.default_rng(seed), 1.0 / boxed.fps / SUBSTEPS
    place, heading = rng.uniform(0.0, boxed.box, (count, 2)), rng.uniform(-np.pi, np.pi, count)
    rows = np.empty((round(seconds * boxed.fps) + 1, count, 3))
    for row in rows:
        row[:, :2], row[:, 2] = place, heading
        for _ in range(SUBSTEPS):
            place = place + boxed.speed * h * np.stack([np.cos(heading), np.sin(heading)], axis=1)
            heading = _reflect_headings(place, heading, boxed, TURNED * h)
            heading = heading + boxed.turn * h + np.sqrt(2.0 * h / boxed.persistence) * rng.normal(size=count)
            place = np.clip(place, 0.0, boxed.box)
    rows[..., :2] += boxed.noise * rng.normal(size=rows[..., :2].shape)
    rows[..., 2] += boxed.heading_noise * rng.normal(size=rows.shape[:2])
    rows[rng.random(rows.shape[:2]) < boxed.lost] = np.nan
    return [_film(np.moveaxis(rows, 1, 0)[number], boxed, headed) for number in range(count)]


def _film(rows, boxed, headed):
    return Tracks((Track(0, rows[:, :2], rows[:, 2] if headed else None),), 1.0 / boxed.fps, 0, "")


def _reflect_headings(place, heading, boxed, turn):
    """Return the headings after contacts with walls."""
    for axis, normal in ((0, 0.0), (1, 0.5 * np.pi)):
        beyond = place[:, axis] > boxed.box[axis], place[:, axis] < 0.0
        for met, outward in zip(beyond, (normal, normal + np.pi), strict=True):
            angle = np.angle(np.exp(1j * (heading - outward)))
            met = met & (np.abs(angle) < 0.5 * np.pi)
            if boxed.wall == "mirror":
                heading = np.where(met, outward + np.pi - angle, heading)
            elif boxed.wall == "turn":
                heading = np.where(met, heading + np.where(angle < 0.0, -turn, turn), heading)
    return heading
