"""Inverse-mass tensors against the published form in 50 digits, limits, and the hinged chain."""

import mpmath as mp
import numpy as np
import pytest

from walkergen.core.theory.tensors import flexible_tensor, rigid_tensor

mp.mp.dps = 50


def perp(u):
    return mp.matrix([-u[1], u[0]])


def outer(u, v):
    return mp.matrix([[u[0] * v[0], u[0] * v[1]], [u[1] * v[0], u[1] * v[1]]])


def published_tensor(M, J, m, j, a, c_A, c_T):
    """docs/physics.md section 2 (for c_A = c_T the paper's eq. 12), literally, in 50 digits."""
    one = mp.eye(2)
    M, J, m, j = (mp.mpf(float(value)) for value in (M, J, m, j))
    a, c_A, c_T = (mp.matrix([float(v) for v in u]) for u in (a, c_A, c_T))
    P = [outer(perp(u), perp(u)) for u in (a, c_A, c_T)]
    K = one / M + P[0] / J + one / m + P[1] / j
    R = one / m - outer(perp(c_A), perp(c_T)) / j
    return one / m + P[2] / j - R.T * (K**-1) * R


def hinged_chain(M, J, m, j, a, b, c_A, c_T):
    """Inverse-mass at the back foot of the whole chain: body and both legs on free hinges.

    Coordinates x, y, pitch, and the absolute angle of each leg.
    """

    def point(*levers):  # velocity of a point: columns for the five coordinates
        rows = np.zeros((2, 5))
        rows[:, :2] = np.eye(2)
        for column, lever in levers:
            rows[:, column] = [-lever[1], lever[0]]
        return rows

    mass = np.diag([M, M, J, j, j]).astype(float)
    for anchor, column in ((a, 3), (b, 4)):
        centre = point((2, anchor), (column, c_A))
        mass += m * centre.T @ centre
    foot = point((2, a), (3, c_A + c_T))
    return foot @ np.linalg.solve(mass, foot.T)


def random_walker(rng, ratio):
    M, J = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(0, 2)
    m = ratio * M
    a, c_A, c_T = rng.normal(0, 4, (3, 2))
    return M, J, m, m * 10 ** rng.uniform(-1, 1), a, c_A, c_T


@pytest.mark.parametrize("ratio", [1e-9, 1e-6, 1e-3, 0.0357, 1.0, 1e3])
def test_flexible_tensor_agrees_with_50_digits(ratio):
    rng = np.random.default_rng(3)
    for _ in range(50):
        walker = random_walker(rng, ratio)
        H = flexible_tensor(*walker)
        exact = published_tensor(*walker)
        # Entries may cancel against each other's terms: compare with the largest.
        size = float(max(abs(value) for value in exact))
        for entry, (row, column) in zip(H, [(0, 0), (0, 1), (1, 1)], strict=True):
            assert entry == pytest.approx(float(exact[row, column]), abs=2e-14 * size, rel=1e-12)


def test_light_upright_leg_keeps_the_digits_of_its_small_entries():
    # At tilt 0, H_yy is of order 1/M while H_xx is of order 1/m, 1e9 times larger.
    a, c = np.array([-6.5, -1.5]), np.array([0.0, -3.75])
    m = 1e-9
    walker = (0.833, 55.0, m, m * 7.5**2 / 12, a, c, c)
    H, exact = flexible_tensor(*walker), published_tensor(*walker)
    assert H.yy == pytest.approx(float(exact[1, 1]), rel=1e-13)
    assert H.xy == pytest.approx(float(exact[0, 1]), rel=1e-12)


@pytest.mark.parametrize("tilt", [5.0, 20.0, 45.0])
def test_thin_light_leg_limit(tilt):
    phi, m, length = np.radians(tilt), 1e-7, 7.5
    c = 0.5 * length * np.array([-np.sin(phi), -np.cos(phi)])
    H = flexible_tensor(0.8, 50.0, m, m * length**2 / 12, np.array([-5.0, -1.5]), c, c)
    expected = 3 / m * np.array([np.cos(phi) ** 2, -np.sin(phi) * np.cos(phi), np.sin(phi) ** 2])
    # The next order is 1/M: smaller by m/M / sin^2(tilt).
    np.testing.assert_allclose([H.xx, H.xy, H.yy], expected, rtol=1e-4)


def test_rigid_tensor_is_equation_4():
    H = rigid_tensor(2.0, 8.0, np.array([-3.0, -5.0]))
    assert H == (0.5 + 25 / 8, -15 / 8, 0.5 + 9 / 8)


def test_other_leg_changes_the_tensor_by_the_order_of_m_over_M():
    b = np.array([7.0, -1.5])
    errors = []
    for ratio in (1e-2, 1e-3, 1e-4):
        M, J, m, j, a, c_A, c_T = random_walker(np.random.default_rng(8), ratio)
        H = flexible_tensor(M, J, m, j, a, c_A, c_T)
        chain = hinged_chain(M, J, m, j, a, b, c_A, c_T)
        errors.append(abs(H.yy - chain[1, 1]) * M)
    assert errors[0] > 0
    # First order: ten times lighter legs, ten times smaller error (within its second order).
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 10.0, rtol=0.2)


def test_one_call_serves_many_draws():
    rng = np.random.default_rng(0)
    walkers = [random_walker(rng, 0.05) for _ in range(20)]
    stacked = flexible_tensor(*(np.array(column) for column in zip(*walkers, strict=True)))
    single = np.array([flexible_tensor(*walker) for walker in walkers]).T
    np.testing.assert_array_equal(np.array(stacked), single)
