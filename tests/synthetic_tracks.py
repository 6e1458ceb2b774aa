"""Tracks of which everything is known: active Brownian walkers, filmed with noise and gaps."""

from typing import NamedTuple

import numpy as np

from walkergen.analysis.tracks import Track, Tracks

SUBSTEPS = 5


class Walker(NamedTuple):
    speed: float = 30.0  # mm/s
    rate: float = 1.0  # rotational diffusion: persistence time 1/rate, s
    turn: float = 0.2  # mean angular velocity, rad/s
    noise: float = 0.05  # of a position, each axis, mm
    heading_noise: float = 0.08  # rad
    lost: float = 0.05  # share of the frames in which it is not seen

    @property
    def diffusivity(self):
        return self.speed**2 * self.rate / (2 * (self.rate**2 + self.turn**2))


def track(rng, walker, frames, interval, number=0, headed=True):
    steps, h = (frames - 1) * SUBSTEPS, interval / SUBSTEPS
    turns = walker.turn * h + np.sqrt(2 * walker.rate * h) * rng.normal(size=steps)
    heading = rng.uniform(0, 2 * np.pi) + np.concatenate([[0.0], np.cumsum(turns)])
    unit = np.exp(1j * heading)
    path = np.concatenate([[0.0], np.cumsum(walker.speed * h * 0.5 * (unit[1:] + unit[:-1]))])
    path, heading = path[::SUBSTEPS], heading[::SUBSTEPS]
    position = np.stack([path.real, path.imag], axis=1)
    position = position + walker.noise * rng.normal(size=position.shape)
    heading = heading + walker.heading_noise * rng.normal(size=frames)
    lost = rng.random(frames) < walker.lost
    position[lost], heading[lost] = np.nan, np.nan
    return Track(number, position, heading if headed else None)


def film(seed, particles, seconds, walker=Walker(), interval=0.01, headed=True):  # noqa: B008
    rng = np.random.default_rng(seed)
    frames = round(seconds / interval) + 1
    made = (track(rng, walker, frames, interval, n, headed) for n in range(particles))
    return Tracks(tuple(made), interval, 0, "")
