"""Tracks with known numbers: walkers of many kinds, filmed with noise and gaps.

A walker runs at `speed` along its heading, and drifts aside. Its heading turns steadily and diffuses (active Brownian
motion; with a steady turn, a chiral walker). On top may come translational diffusion, inertia of the velocity or of the
turning, noise of the film, frames that are missing one by one or in blocks, and a spread between walkers. Every law
that the analysis is to find in these tracks stands here in closed form, or as an integral.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import integrate, signal

from walkergen.analysis.tracks import Track, Tracks

SUBSTEPS = 5
"""Least number of steps a frame, and of half steps a time of inertia."""

RUN_IN = 12.0
"""Length of the run before the film, in times of inertia."""


class Walker(NamedTuple):
    speed: float = 30.0  # mm/s
    rate: float = 1.0  # rotational diffusion: persistence time 1/rate, s
    turn: float = 0.2  # mean angular velocity, rad/s
    noise: float = 0.05  # of a position, each axis, mm
    heading_noise: float = 0.08  # rad
    lost: float = 0.05  # share of the frames without it
    gap: float = 0.0  # mean length of a gap, frames; 0: frames are lost one by one, at random
    drift: float = 0.0  # to the left of the heading, mm/s
    diffusion: float = 0.0  # translational, mm^2/s
    inertia: float = 0.0  # time within which the velocity follows the heading, s
    turn_memory: float = 0.0  # correlation time of the rate of turning, s
    speed_sd: float = 0.0  # between walkers, mm/s
    turn_sd: float = 0.0  # between walkers, rad/s

    def heading_correlation(self, lag):
        """Correlation of headings, but for the steady turn (Ornstein and Uhlenbeck 1930)."""
        late = self.turn_memory * -np.expm1(-lag / self.turn_memory) if self.turn_memory else 0.0
        return np.exp(-self.rate * (lag - late))

    @property
    def diffusivity(self):
        """Half the integral of the velocity's correlation, which inertia does not change."""
        return self.diffusion + 0.5 * (self.speed**2 + self.drift**2) * _integral(
            lambda lag: self.heading_correlation(lag) * math.cos(self.turn * lag), 40.0 / max(self.rate, 1e-9)
        )

    @property
    def ahead(self):
        """Mean velocity along (real part) and to the left of the present heading, mm/s."""
        if not self.inertia:
            return complex(self.speed, self.drift)
        kept, sides = [
            _integral(
                lambda lag, part=part: (
                    math.exp(-lag / self.inertia) / self.inertia * self.heading_correlation(lag) * part(self.turn * lag)
                ),
                40.0 * self.inertia,
            )
            for part in (math.cos, math.sin)
        ]
        return complex(self.speed, self.drift) * complex(kept, -sides)

    def sample_walker(self, rng):
        """One walker of a group that differ."""
        speed, turn = rng.normal(size=2) * (self.speed_sd, self.turn_sd)
        return self._replace(speed=self.speed + speed, turn=self.turn + turn)


def _integral(function, end):
    return integrate.quad(function, 0.0, end, limit=400)[0]


def _headings(rng, walker, steps, h):
    """Heading, shape (steps + 1,), rad: exact for white noise, trapezium rule with memory."""
    if not walker.turn_memory:
        turns = np.sqrt(2 * walker.rate * h) * rng.normal(size=steps)
    else:
        kept = math.exp(-h / walker.turn_memory)
        kicks = math.sqrt(walker.rate / walker.turn_memory) * rng.normal(size=steps + 1)
        kicks[1:] *= math.sqrt(1.0 - kept**2)
        rates = signal.lfilter([1.0], [1.0, -kept], kicks)
        turns = 0.5 * h * (rates[1:] + rates[:-1])
    start = rng.uniform(0, 2 * np.pi)
    return start + np.concatenate([[0.0], np.cumsum(walker.turn * h + turns)])


def _path(rng, walker, frames, interval):
    """True place (complex, mm) and heading of a walker in every frame."""
    times = [one for one in (walker.inertia, walker.turn_memory) if one]
    fine = max(SUBSTEPS, *(math.ceil(2 * SUBSTEPS * interval / one) for one in times), 1)
    h, early = interval / fine, fine * math.ceil(RUN_IN * walker.inertia / interval)
    heading = _headings(rng, walker, early + (frames - 1) * fine, h)
    velocity = complex(walker.speed, walker.drift) * np.exp(1j * heading)
    if walker.inertia:
        kept = math.exp(-h / walker.inertia)
        half = 0.5 * (1.0 - kept)
        start = signal.lfiltic([half, half], [1.0, -kept], velocity[:1], velocity[:1])
        velocity, _ = signal.lfilter([half, half], [1.0, -kept], velocity, zi=start)
    moved = 0.5 * h * (velocity[1:] + velocity[:-1])
    if walker.diffusion:
        moved = moved + math.sqrt(2 * walker.diffusion * h) * _plane(rng, len(moved))
    place = np.concatenate([[0.0], np.cumsum(moved)])
    return place[early::fine], heading[early::fine]


def _plane(rng, count):
    return rng.normal(size=2 * count).view(complex)


def lost_frames(rng, walker, frames):
    """Frames without a walker, shape (frames,): at random, or in blocks."""
    if not walker.gap or not walker.lost:
        return rng.random(frames) < walker.lost
    ends = 1.0 / walker.gap
    begins = ends * walker.lost / (1.0 - walker.lost)
    # Lengths of what is seen and of what is lost take turns: more than enough of both.
    lengths = rng.geometric([begins, ends], size=(frames + 1, 2)).ravel()
    first = int(rng.random() < walker.lost)
    lengths = lengths[first : first + np.searchsorted(np.cumsum(lengths[first:]), frames) + 1]
    return (np.repeat(first + np.arange(len(lengths)), lengths)[:frames] % 2).astype(bool)


def track(rng, walker, frames, interval, number=0, headed=True):
    place, heading = _path(rng, walker, frames, interval)
    position = np.stack([place.real, place.imag], axis=1)
    position = position + walker.noise * rng.normal(size=position.shape)
    heading = heading + walker.heading_noise * rng.normal(size=frames)
    lost = lost_frames(rng, walker, frames)
    position[lost], heading[lost] = np.nan, np.nan
    return Track(number, position, heading if headed else None)


def film(seed, particles, seconds, walker=Walker(), interval=0.01, headed=True):  # noqa: B008
    """Tracks of several walkers that differ as `walker` says."""
    rng = np.random.default_rng(seed)
    return film_of(rng, [walker.sample_walker(rng) for _ in range(particles)], seconds, interval, headed)


def film_of(rng, walkers: Sequence[Walker], seconds, interval=0.01, headed=True):
    """Tracks of these walkers, one each."""
    frames = round(seconds / interval) + 1
    made = (track(rng, one, frames, interval, n, headed) for n, one in enumerate(walkers))
    return Tracks(tuple(made), interval, 0, "")


def lane(seed, speeds, frames, plate=None, interval=0.01, memory=5.0, sd=30.0):
    """Walkers in a lane, one a speed (mm/s), which fluctuates by `sd` and lasts some frames."""
    rng, kept = np.random.default_rng(seed), math.exp(-1 / memory)
    kicks = rng.normal(size=(len(speeds), frames))
    kicks[:, 1:] *= math.sqrt(1.0 - kept**2)
    changing = sd * signal.lfilter([1.0], [1.0, -kept], kicks)
    paths = np.cumsum(np.asarray(speeds)[:, None] + changing, axis=1) * interval
    made = (Track(number, path[:, None], None, plate) for number, path in enumerate(paths))
    return Tracks(tuple(made), interval, 0, "")
