"""A bench of numbers: readings of strips by solvers that share nothing with the package's forms."""

import math

import numpy as np
from scipy.integrate import solve_bvp
from scipy.linalg import eigh

G = 9806.65
AIR = 1.2e-6


def sunk(modulus, strip, load, at, root=0.42, clamp=0.05):
    """Depth (mm) under `load` (g) at `at` (mm): Euler's elastica on a root that turns as a spring.

    Of a strip (thickness, width, length), modulus in Pa; the weight stays vertical.
    """
    thickness, width, _ = strip
    bending = modulus * width * thickness**3 / 12.0
    length = at - clamp * width
    force = load * G

    def slopes(s, y):  # x, y, angle, moment along the strip
        return np.array([np.cos(y[2]), np.sin(y[2]), y[3] / bending, -force * np.cos(y[2])])

    def ends(a, b):
        return np.array([a[0], a[1], a[2] - root * thickness * a[3] / bending, b[3]])

    s = np.linspace(0.0, length, 21)
    bend = force * (length * s - 0.5 * s**2) / bending
    guess = np.array([s, bend * s / 2, bend, force * (length - s)])
    found = solve_bvp(slopes, ends, s, guess, tol=1e-8)
    assert found.success
    return float(found.y[1, -1])


def rings(modulus, density, strip, tip=0.0, root=0.42, clamp=0.05, elements=30):
    """First frequency (Hz) by beam elements with a spring at the root and a mass at the tip."""
    thickness, width, free = strip
    bending = modulus * width * thickness**3 / 12.0
    per_length = density * thickness * width + 0.25 * math.pi * AIR * width**2
    h = (free - clamp * width) / elements
    by_length = np.outer(both := np.array([1.0, h, 1.0, h]), both)
    k = bending / h**3 * by_length * [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
    m = per_length * h / 420 * by_length
    m = m * [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    size = 2 * elements + 2
    stiff, mass = np.zeros((size, size)), np.zeros((size, size))
    for one in range(elements):
        part = slice(2 * one, 2 * one + 4)
        stiff[part, part] += k
        mass[part, part] += m
    stiff[1, 1] += bending / max(root * thickness, 1e-9)
    mass[-2, -2] += tip
    kept = np.arange(1, size)  # the root turns and does not sink
    squares = eigh(stiff[np.ix_(kept, kept)], mass[np.ix_(kept, kept)], eigvals_only=True)
    return math.sqrt(squares[0]) / (2.0 * math.pi)
