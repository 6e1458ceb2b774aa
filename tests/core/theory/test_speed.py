"""Stationary speeds: published values, closed forms against the impact kernel, limits."""

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq

from walkergen.commands.selftest import scenes
from walkergen.core.errors import TheoryError
from walkergen.core.theory.impact import Kind, resolve
from walkergen.core.theory.speed import factor, factors
from walkergen.core.theory.tensors import InverseMass, foot_tensors
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import LegMass, MassProperties


def ideal(tilt_deg, m_over_M=None):
    """The paper's idealised walker: thin uniform legs (physics.md section 1)."""
    design = Design().variant(tilt_deg=tilt_deg)
    return scenes.masses(design, None if m_over_M is None else m_over_M * scenes.masses(design).M)


@pytest.mark.parametrize(
    ("tilt", "mode", "back", "front"),
    [
        (5, "paper", 5.506, 4.977),
        (5, "coulomb", 5.249, 4.753),
        (10, "paper", 4.203, 3.790),
        (10, "coulomb", 4.203, 3.790),
        (20, "paper", 2.458, 2.296),
        (20, "coulomb", 2.458, 2.296),
        (35, "paper", 1.335, 1.297),
        (35, "coulomb", 1.335, 1.297),
    ],
)
def test_known_values(tilt, mode, back, front):
    """docs/physics.md section 4, e = 0.9, mu = 0.1; given to three decimals."""
    found = factors(ideal(tilt), 0.9, 0.1, mode)
    assert float(found.feet[0]) == pytest.approx(back, abs=6e-4)
    assert float(found.feet[1]) == pytest.approx(front, abs=6e-4)


@pytest.mark.parametrize(("e", "friction", "value"), [(0.9, 0.1, 5.2), (0.8, 0.25, 12.0)])
def test_equation_15_does_not_vanish_at_tilt_zero_but_coulomb_does(e, friction, value):
    """docs/physics.md section 4: eq. 15 gives 5.2 w (fitted) and 12 w (measured) there."""
    feet_at_zero = foot_tensors(ideal(0.0))
    printed = [0.5 * (1 + e) * (friction * H.xx - H.xy) / (H.yy - e * friction * H.xy) for H in feet_at_zero]
    assert np.mean(printed) == pytest.approx(value, abs=0.05 * value)
    # Mode paper takes the sign from H_xy: each foot has that size, back and front cancel.
    ours = factors(ideal(0.0), e, friction, "paper")
    assert float(ours.feet[1]) == pytest.approx(printed[1], rel=1e-12)
    assert float(ours.mean) == 0.0
    assert float(factors(ideal(0.0), e, friction).mean) == 0.0
    # Beyond 0.048 deg, where the back foot's H_xy changes sign, only coulomb stays small.
    assert float(factors(ideal(0.1), e, friction, "paper").mean) > value
    assert abs(float(factors(ideal(0.1), e, friction).mean)) < 0.2


def random_tensors(count, seed):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        a = rng.normal(size=(2, 2))
        h = a @ a.T + 1e-2 * np.eye(2)
        yield InverseMass(h[0, 0], h[0, 1], h[1, 1]), 10 ** rng.uniform(-2, 1), rng.uniform()


def test_stationary_speed_is_the_only_root():
    """Rival: bracket the sign change of F_x(v_x) of the impact kernel itself."""
    for H, mu, e in random_tensors(40, seed=2):

        def impulse(v_x, H=H, mu=mu, e=e):
            return resolve(H, (v_x, -1.0), e, mu).F_x

        bound = 1e3 * (H.xx + abs(H.xy)) * (1 + mu) / (H.yy - H.xy**2 / H.xx)
        assert brentq(impulse, -bound, bound, xtol=1e-13, rtol=1e-13) == pytest.approx(
            float(factor(H, e, mu)), rel=1e-8, abs=1e-10
        )
        grid = np.concatenate([-np.geomspace(bound, 1e-3, 50), np.geomspace(1e-3, bound, 50)])
        signs = np.sign([impulse(v_x) for v_x in grid])
        assert (np.diff(signs) <= 0).all()  # F_x opposes v_x beyond the root, on either side


def test_type_at_the_stationary_speed():
    kinds = set()
    for H, mu, e in random_tensors(200, seed=3):
        v_x = float(factor(H, e, mu))
        kinds.add(abs(resolve(H, (v_x, -1.0), e, mu).kind))
    assert kinds == {Kind.III}


def test_sticking_speed_does_not_depend_on_friction():
    H = InverseMass(2.0, -0.5, 1.0)
    expected = 1.7 * 0.5 / (1.0 + 0.7 * 0.25 / 2.0)
    for mu in (0.25, 0.3, 1.0, 1e3):
        assert float(factor(H, 0.7, mu)) == pytest.approx(expected, rel=1e-12)


def test_friction_zero_is_the_limit():
    H = InverseMass(2.0, -0.5, 1.0)
    for e in (0.0, 0.5, 1.0):
        limit = float(factor(H, e, 0.0))
        assert limit == pytest.approx(float(factor(H, e, 1e-9)), rel=1e-7)
        assert limit > 0


def test_always_finite_over_the_corners():
    tilts, ratios = (0.0, 1e-12, -1e-12, 0.048, 10.0, 59.0), (1e-9, 1e-6, 1e-3, 1.0, 1e3)
    corners = itertools.product(tilts, ratios, (0.0, 0.5, 1.0), (0.0, 1e-12, 0.1, 5.0, 1e3))
    for tilt, ratio, e, mu in corners:
        found = factors(ideal(tilt, ratio), e, mu)
        assert np.isfinite([found.feet[0], found.feet[1]]).all()
        if tilt == 0.0:
            assert float(found.mean) == 0.0
        elif abs(tilt) == 1e-12:
            # The speed grows like tilt / (m/M), at most: 1.7e-14 rad, times 7.3 with our lengths.
            assert abs(float(found.mean)) < 2e-13 / min(ratio, 1.0) * (1 + mu)


def test_mirror_image_runs_backwards():
    for tilt in (3.0, 10.0, 40.0):
        forward, backward = factors(ideal(tilt), 0.8, 0.25), factors(ideal(-tilt), 0.8, 0.25)
        assert float(backward.mean) == pytest.approx(-float(forward.mean), rel=1e-12)
        assert float(backward.feet[0]) == pytest.approx(-float(forward.feet[1]), rel=1e-12)


def test_speed_does_not_depend_on_scale_or_density():
    one = ideal(12.0)
    for length, mass in ((1e-3, 1.0), (1e3, 1.0), (1.0, 1e6)):
        legs = tuple(
            LegMass(
                leg.m * mass, leg.j * mass * length**2, *(length * vector for vector in (leg.anchor, leg.c_A, leg.c_T))
            )
            for leg in one.legs
        )
        scaled = MassProperties(one.M * mass, one.J * mass * length**2, legs, False)
        expected, found = factors(one, 0.8, 0.25), factors(scaled, 0.8, 0.25)
        assert float(found.mean) == pytest.approx(float(expected.mean), rel=1e-12)


def test_vectorised_equals_one_by_one():
    e, mu = np.meshgrid([0.0, 0.4, 1.0], [0.0, 0.1, 3.0])
    many = factors(ideal(10.0), e, mu).mean
    single = [
        [float(factors(ideal(10.0), *pair).mean) for pair in zip(*row, strict=True)] for row in zip(e, mu, strict=True)
    ]
    np.testing.assert_allclose(many, single, rtol=1e-15)


@pytest.mark.parametrize(
    ("e", "mu", "mode"),
    [
        (-0.1, 0.1, "coulomb"),
        (1.1, 0.1, "coulomb"),
        (np.nan, 0.1, "coulomb"),
        (0.5, -1.0, "coulomb"),
        (0.5, np.inf, "coulomb"),
        (0.5, 0.1, "exact"),
    ],
)
def test_unusable_numbers_are_refused(e, mu, mode):
    with pytest.raises(TheoryError):
        factor(InverseMass(1.0, -0.1, 1.0), e, mu, mode)
