"""Noise of the plate as kernels know it: a random motion over the sine, by samples and cubics between.

How it is drawn: `noisy_plate`; a scene without noise imports this alone.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.numerics.kernels import lean


class Noise(NamedTuple):
    """A drawn noise."""

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


@lean
def advance_time(noise, time, t):
    """Return the time (s, within the noise's period) after t seconds."""
    if len(noise.heights) == 0:
        return time
    return (time + t) % (len(noise.heights) * noise.interval)


@lean
def _cubic(noise, time):
    """Return the coefficients of the cubic about the sample before `time`, and the part of the interval."""
    place = time / noise.interval
    i = int(place)
    s = place - i
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
    """Return the velocity of the noise, mm/s."""
    if len(noise.heights) == 0:
        return 0.0
    _, u, c, d, s = _cubic(noise, time)
    return (u + s * (2.0 * c + 3.0 * s * d)) / noise.interval


@lean
def acceleration(noise, time):
    """Return the acceleration of the noise, mm/s^2."""
    if len(noise.heights) == 0:
        return 0.0
    _, _, c, d, s = _cubic(noise, time)
    return (2.0 * c + 6.0 * s * d) / (noise.interval * noise.interval)


@lean
def bounds(noise):
    """Return the largest velocity (mm/s) and acceleration (mm/s^2) of the noise."""
    return noise.fastest, noise.strongest
