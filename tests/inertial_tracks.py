"""Tracks of active Brownian particles with inertia and known numbers.

m dv/dt = gamma (v0 e - v) + noise and J dw/dt = gamma_R (W - w) + noise, in steps of a fraction of
the shorter time of relaxation, exact for the noise.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy import signal

from walkergen.analysis.tracks import Track, Tracks

RUN_IN = 8.0
"""Length of the run before the film, in the longer of the times of relaxation."""


class Inertial(NamedTuple):
    speed: float = 60.0  # v0, mm/s
    relaxation: float = 0.06  # m / gamma, s
    diffusion: float = 2.5  # translational, mm^2/s
    turn: float = 0.0  # mean angular velocity, rad/s
    turn_sd: float = 0.0  # between walkers, rad/s
    turn_relaxation: float = 0.04  # J / gamma_R, s
    rotation: float = 0.3  # D_R, rad^2/s
    noise: float = 0.0  # of places, mm
    heading_noise: float = 0.0  # rad


def tracks(seed, one=Inertial(), walkers=16, seconds=10.0, interval=1.0 / 90.0):  # noqa: B008
    rng = np.random.default_rng(seed)
    frames = round(seconds / interval) + 1
    made = [_track(rng, one, frames, interval, number) for number in range(walkers)]
    return Tracks(tuple(made), interval, 0, "")


def _ornstein_uhlenbeck(rng, steps, h, time, diffusion):
    """Ornstein-Uhlenbeck process of this diffusion, stationary, shape (steps,)."""
    kept = math.exp(-h / time)
    kicks = math.sqrt(diffusion / time) * rng.normal(size=steps)
    kicks[1:] *= math.sqrt(1.0 - kept**2)
    return signal.lfilter([1.0], [1.0, -kept], kicks)


def _track(rng, one, frames, interval, number):
    fine = math.ceil(8.0 * interval / min(one.relaxation, one.turn_relaxation))
    h = interval / fine
    early = fine * math.ceil(RUN_IN * max(one.relaxation, one.turn_relaxation) / interval)
    steps = early + (frames - 1) * fine
    turn = one.turn + one.turn_sd * rng.normal()
    rate = turn + _ornstein_uhlenbeck(rng, steps + 1, h, one.turn_relaxation, one.rotation)
    turned = 0.5 * h * (rate[1:] + rate[:-1])
    heading = rng.uniform(0, 2 * np.pi) + np.concatenate([[0.0], np.cumsum(turned)])
    unit = one.speed * np.exp(1j * heading)
    kept = math.exp(-h / one.relaxation)
    half = [0.5 * (1.0 - kept)] * 2
    follows, _ = signal.lfilter(half, [1.0, -kept], unit, zi=signal.lfiltic(half, [1.0, -kept], unit[:1], unit[:1]))
    pushed = [_ornstein_uhlenbeck(rng, steps + 1, h, one.relaxation, one.diffusion) for _ in range(2)]
    velocity = follows + pushed[0] + 1j * pushed[1]
    place = np.concatenate([[0.0], np.cumsum(0.5 * h * (velocity[1:] + velocity[:-1]))])
    place, heading = place[early::fine], heading[early::fine]
    noise = one.noise * rng.normal(size=(frames, 2))
    position = np.stack([place.real, place.imag], axis=1) + noise
    return Track(number, position, heading + one.heading_noise * rng.normal(size=frames))
