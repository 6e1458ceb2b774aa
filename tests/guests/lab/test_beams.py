"""Beams: what a printed strip's root and clamp add to Euler and Bernoulli's, by other methods."""

import math
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sparse
from numpy.polynomial import Legendre, Polynomial
from numpy.polynomial.legendre import leggauss
from scipy.sparse.linalg import spsolve

from walkergen.guests.lab import beams
from walkergen.guests.lab.beams import Strip


def root_by_elements(fine=8, block=6, stub=3, poisson=0.36):
    """Extra length of a beam 1 thick on a block, in thicknesses: plane stress, a pure moment.

    Bilinear elements with Wilson's incompatible modes, which bend exactly; the block is held at its back.
    """
    h = 1.0 / fine
    law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]]) / (1 - poisson**2)
    own, mixed, inner = np.zeros((8, 8)), np.zeros((8, 4)), np.zeros((4, 4))
    xs, ys = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
    for x in (-(3**-0.5), 3**-0.5):
        for y in (-(3**-0.5), 3**-0.5):
            slopes = np.array([xs * (1 + ys * y), ys * (1 + xs * x)]) / (2 * h)
            b, g = np.zeros((3, 8)), np.zeros((3, 4))
            b[0, ::2], b[1, 1::2], b[2, ::2], b[2, 1::2] = *slopes, slopes[1], slopes[0]
            g[0, 0] = g[2, 1] = -4 * x / h
            g[2, 2] = g[1, 3] = -4 * y / h
            area = h * h / 4
            own += b.T @ law @ b * area
            mixed += b.T @ law @ g * area
            inner += g.T @ law @ g * area
    own -= mixed @ np.linalg.solve(inner, mixed.T)
    low = fine * (block - 1) // 2
    cells = [(i, j) for i in range(-block * fine, 0) for j in range(block * fine)]
    cells += [(i, j + low) for i in range(stub * fine) for j in range(fine)]
    number = {}
    for i, j in cells:
        for corner in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
            number.setdefault(corner, len(number))
    nodes = np.array([[number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]] for i, j in cells])
    free = np.stack([2 * nodes, 2 * nodes + 1], axis=2).reshape(len(nodes), 8)
    rows, columns = np.repeat(free, 8, axis=1).ravel(), np.tile(free, 8).ravel()
    stiff = sparse.csr_matrix((np.tile(own.ravel(), len(nodes)), (rows, columns)))
    force, moment = np.zeros(2 * len(number)), 0.0
    for j in range(fine + 1):
        y, share = j * h - 0.5, h * (0.5 if j in (0, fine) else 1.0)
        force[2 * number[stub * fine, low + j]] = -12 * y * share
        moment += 12 * y * y * share
    held = {k for (i, _), k in number.items() if i == -block * fine}
    kept = np.array([2 * k + d for k in number.values() if k not in held for d in (0, 1)])
    moved = np.zeros(2 * len(number))
    moved[kept] = spsolve(stiff[kept][:, kept].tocsc(), force[kept])
    ends = (2 * number[stub * fine, low + edge] for edge in (0, fine))
    bottom, top = (moved[end] for end in ends)
    return abs(top - bottom) / moment / 12.0 - stub


def clamp_by_plate(wide, poisson, along=14, across=5):
    """Length, over the width, by which a clamped plate of length 1 is shorter than a beam.

    Ritz's method with Legendre polynomials; a load spread over the free end.
    """
    x, wx = leggauss(along + 6)
    x, wx = (x + 1) / 2, wx / 2
    y, wy = leggauss(2 * across + 4)
    wy = wy * wide / 2
    basis = [Legendre.basis(i, domain=[0, 1]).convert(kind=Polynomial) * Polynomial([0, 0, 1]) for i in range(along)]
    sides = [Legendre.basis(2 * j) for j in range(across)]
    f0, f1, f2 = (np.array([one.deriv(k)(x) for one in basis]) for k in range(3))
    g0, g1, g2 = (np.array([one.deriv(k)(y) * (2 / wide) ** k for one in sides]) for k in range(3))

    def energy(f, g, h, k):
        return np.kron((f * wx) @ g.T, (h * wy) @ k.T)

    stiff = energy(f2, f2, g0, g0) + energy(f0, f0, g2, g2)
    stiff += poisson * (energy(f2, f0, g0, g2) + energy(f0, f2, g2, g0))
    stiff += 2 * (1 - poisson) * energy(f1, f1, g1, g1)
    load = np.kron([one(1.0) for one in basis], (g0 * wy).sum(axis=1) / wide)
    sunk = load @ np.linalg.lstsq(stiff, load, rcond=1e-14)[0]
    beam = 1.0 / (3.0 * wide * (1.0 - poisson**2))
    return (1.0 - (sunk / beam) ** (1.0 / 3.0)) / wide


def test_a_root_in_a_block_is_as_soft_as_elements_say():
    coarse, fine = root_by_elements(6), root_by_elements(12)
    # The corners' singularity is resolved as the element's size
    assert 2.0 * fine - coarse == pytest.approx(beams.ROOT_FACTOR, abs=0.02)
    assert pytest.approx(16.67 / (12.0 * math.pi), abs=beams.ROOT_FACTOR_SD) == beams.ROOT_FACTOR  # half-space


def test_a_wide_strip_is_stiffer_at_its_clamp_as_plates_say():
    by = {poisson: clamp_by_plate(0.1, poisson) for poisson in (0.30, 0.36, 0.42)}
    assert by[0.36] == pytest.approx(beams.CLAMP_FACTOR, abs=0.003)
    assert by[0.30] == pytest.approx(beams.CLAMP_FACTOR - beams.CLAMP_FACTOR_SD, abs=0.009)
    assert by[0.42] == pytest.approx(beams.CLAMP_FACTOR + beams.CLAMP_FACTOR_SD, abs=0.009)
    assert clamp_by_plate(0.4, 0.36) == pytest.approx(beams.CLAMP_FACTOR, abs=0.01)


def test_a_tip_mass_slows_as_rayleigh_says_and_its_limits_are_known():
    assert beams.first_mode(0.0) == beams.FIRST_MODE
    for ratio in (10.0, 1e3, 1e5):  # a massless beam of stiffness 3 with 33/140 of its mass
        rayleigh = math.sqrt(3.0 / (ratio + 33.0 / 140.0))
        assert beams.first_mode(ratio) == pytest.approx(rayleigh, rel=1e-3 / ratio)
    modes = [beams.first_mode(ratio) for ratio in (0.0, 1e-9, 0.01, 0.1, 1.0)]
    assert all(one > other for one, other in pairwise(modes))
    assert modes[4] == pytest.approx(1.2479**2, rel=1e-4)  # Blevins, table 8-8


def test_small_bends_sink_as_the_weight_and_large_ones_less():
    strip = Strip(0.4, 5.0, 50.0)
    stiff = beams.bending_stiffness(3e9, strip)
    assert stiff == pytest.approx(3e9 * 5.0 * 0.4**3 / 12.0)
    assert beams.deflection(1e-6, 50.0, stiff) == pytest.approx(1e-6 * 9806.65 * 50.0**3 / (3.0 * stiff), rel=1e-9)
    assert beams.deflection(2.0, 50.0, stiff) < 2.0 * beams.deflection(1.0, 50.0, stiff)


def test_damping_and_decrement_are_inverse():
    for ratio in (0.001, 0.05, 0.5):
        assert beams.damping_ratio(2.0 * math.pi * ratio / math.sqrt(1.0 - ratio**2)) == pytest.approx(ratio)
