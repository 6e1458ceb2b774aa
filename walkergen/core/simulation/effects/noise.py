"""Plate noise: a random motion of the plate over its sine, with its power in a band.

Every run draws its own: independent normal amplitudes at the frequencies of a long period, of equal
mean power in velocity over the band, scaled to its root mean square (S. O. Rice, Bell System
Technical Journal 23, 1944, 282). Heights between samples are cubic in time, with the samples'
velocities. Limit: no noise is the plain drive; the period repeats after `PERIOD_S` at most.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key

NAME, SWITCH, KEY = "plate noise", "plate_noise", "plate.noise_ratio"

SAMPLES_PER_PERIOD = 16.0
"""Samples in a period of the highest frequency: cubics between them err by 1e-3 of the velocity."""

PERIOD_S = 30.0
"""Longest period of the noise, s."""

MAX_SAMPLES = 2**20
"""Largest number of samples: higher bands repeat sooner."""

MIN_LINES = 32
"""Fewest frequencies in the band: with fewer the noise is a beat."""


class Noise(NamedTuple):
    """Random motion of the plate in one run, sampled at regular times."""

    heights: npt.NDArray[np.float64]
    """Heights at regular times, shape (n,), mm."""
    velocities: npt.NDArray[np.float64]
    """Velocities at these times, shape (n,), mm/s."""
    interval: float
    """Time between samples, s."""
    fastest: float
    """Largest velocity, mm/s."""
    strongest: float
    """Largest acceleration, mm/s^2."""


OFF = Noise(np.zeros(0), np.zeros(0), 0.0, 0.0, 0.0)
"""No noise: no samples."""


def decide(case: Case) -> Effect:
    """Return the effect "plate noise". Its number is the noise's rms velocity over the drive's peak speed."""
    ratio = case.scene.plate.noise_ratio
    on, reason = decide_from_key(case, KEY, SWITCH)
    if on:
        _frequency_grid(case)
    return Effect(NAME, on, ratio, "rms velocity over the drive's peak speed", reason, SWITCH)


RULE = Rule(decide, SWITCH, absent_values={KEY: 0.0}, typical_values={KEY: 0.3})


def _frequency_grid(case: Case) -> tuple[int, float, int, int]:
    """Return the number of samples, their interval (s), and the first and last index of frequencies in the band."""
    low, high = case.scene.plate.noise_band_hz
    interval = 1.0 / (SAMPLES_PER_PERIOD * high)
    count = int(min(PERIOD_S / interval, MAX_SAMPLES))
    first, last = math.ceil(low * count * interval), math.floor(high * count * interval)
    if last - first < MIN_LINES:
        raise InputError(
            f"plate.noise_band_hz = [{low:g}, {high:g}]: the band holds {last - first} "
            f"multiples of 1/({count * interval:.3g} s), at least {MIN_LINES} are needed. Widen it"
        )
    return count, interval, max(first, 1), last


def sample_noise(case: Case, rng: np.random.Generator) -> Noise:
    """Draw the plate noise of one run of the scene. Raises InputError for a band that is too narrow."""
    count, interval, first, last = _frequency_grid(case)
    spectrum = np.zeros(count // 2 + 1, complex)
    spectrum[first : last + 1] = rng.normal(size=(last + 1 - first, 2)) @ (1.0, 1.0j)
    rms_velocity = case.scene.plate.noise_ratio * case.equivalent_drive.peak_speed
    velocity = np.fft.irfft(spectrum, count)
    scale = rms_velocity / math.sqrt(float(np.mean(velocity**2)))
    omega = 2.0 * math.pi * np.fft.rfftfreq(count, interval)
    heights = np.fft.irfft(np.divide(scale * spectrum, 1j * omega, where=omega > 0.0, out=spectrum * 0), count)
    acceleration = np.fft.irfft(scale * spectrum * 1j * omega, count)
    velocities = scale * velocity
    return Noise(heights, velocities, interval, float(np.abs(velocities).max()), float(np.abs(acceleration).max()))


@lean
def advance_time(noise, time, t):
    """Return the time (s, within the noise's period) that is t seconds after `time`."""
    if len(noise.heights) == 0:
        return time
    return (time + t) % (len(noise.heights) * noise.interval)


@lean
def _cubic(noise, time):
    """Return the four coefficients of the cubic height at `time`, and the elapsed share of its sampling interval."""
    position = time / noise.interval
    i = int(position)
    s = position - i
    count = len(noise.heights)
    i %= count
    j = (i + 1) % count
    a, b = noise.heights[i], noise.heights[j]
    u, v = noise.interval * noise.velocities[i], noise.interval * noise.velocities[j]
    return a, u, 3.0 * (b - a) - 2.0 * u - v, 2.0 * (a - b) + u + v, s


@lean
def height(noise, time):
    """Return the height of the noise, mm, at a time in its period, s."""
    if len(noise.heights) == 0:
        return 0.0
    a, u, c, d, s = _cubic(noise, time)
    return a + s * (u + s * (c + s * d))


@lean
def velocity(noise, time):
    """Return the velocity of the noise, mm/s, at a time in its period, s."""
    if len(noise.heights) == 0:
        return 0.0
    _, u, c, d, s = _cubic(noise, time)
    return (u + s * (2.0 * c + 3.0 * s * d)) / noise.interval


@lean
def acceleration(noise, time):
    """Return the acceleration of the noise, mm/s^2, at a time in its period, s."""
    if len(noise.heights) == 0:
        return 0.0
    _, _, c, d, s = _cubic(noise, time)
    return (2.0 * c + 6.0 * s * d) / (noise.interval * noise.interval)


@lean
def bounds(noise):
    """Return the largest velocity (mm/s) and acceleration (mm/s^2) of the noise."""
    return noise.fastest, noise.strongest
