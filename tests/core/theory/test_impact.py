"""Laws of the frictional impact, and its rival: an event loop along the impulse in 50 digits."""

import math

import mpmath as mp
import numpy as np
import pytest

from walkergen.core.errors import TheoryError
from walkergen.core.theory.impact import Kind, resolve

mp.mp.dps = 50


def random_cases(count, seed=1, speed=10.0):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        a = rng.normal(size=(2, 2))
        h = a @ a.T + 10 ** rng.uniform(-6, 0) * np.eye(2)
        v_x = rng.choice([0.0, rng.normal(0, speed), rng.normal(0, 0.1 * speed)])
        e = rng.choice([0.0, 1.0, rng.uniform()])
        mu = rng.choice([0.0, 10 ** rng.uniform(-2, 1), 1e3])
        yield (h[0, 0], h[0, 1], h[1, 1]), (v_x, -abs(rng.normal(0, speed))), e, mu


def reference(H, velocity, e, mu):
    """Follow velocities along the normal impulse event by event; all numbers in 50 digits."""
    xx, xy, yy = (mp.mpf(float(h)) for h in H)
    v_x, v_y = (mp.mpf(float(v)) for v in velocity)
    e, mu = mp.mpf(float(e)), mp.mpf(float(mu))
    p = F_x = mp.mpf(0)
    p_c = None
    while True:
        if v_x != 0:
            ratio = -mu * mp.sign(v_x)
        elif abs(xy) <= mu * xx:
            ratio = -xy / xx
        else:
            ratio = -mu * mp.sign(xy)
        stuck = v_x == 0 and abs(xy) <= mu * xx
        s_x, s_y = 0 if stuck else xy + ratio * xx, yy + ratio * xy
        steps = []
        if v_x != 0 and s_x * v_x < 0:
            steps.append((-v_x / s_x, "stop"))
        if p_c is None:
            if s_y > 0:
                steps.append((-v_y / s_y, "compressed"))
        else:
            steps.append(((1 + e) * p_c - p, "end"))
        dp, event = min(steps)
        F_x += ratio * dp
        p += dp
        v_y += s_y * dp
        v_x = mp.mpf(0) if event == "stop" else v_x + s_x * dp
        if event == "compressed":
            p_c, v_y = p, mp.mpf(0)
        if event == "end":
            return F_x, p, v_x, v_y


def test_impact_agrees_with_50_digits():
    for H, velocity, e, mu in random_cases(300):
        outcome = resolve(H, velocity, e, mu)
        expected = [float(value) for value in reference(H, velocity, e, mu)]
        # A tensor of condition up to 1e7 amplifies rounding by about that.
        scale = max(abs(outcome.F_y), abs(outcome.F_x))
        np.testing.assert_allclose(outcome[:2], expected[:2], rtol=1e-9, atol=1e-9 * scale)
        speed = np.hypot(*velocity)
        np.testing.assert_allclose(outcome[2:4], expected[2:], rtol=1e-8, atol=1e-8 * speed)


def test_impulse_in_friction_cone_and_velocity_consistent():
    for H, velocity, e, mu in random_cases(500, seed=2):
        out = resolve(H, velocity, e, mu)
        assert out.F_y > 0
        assert abs(out.F_x) <= mu * out.F_y * (1 + 1e-12)
        assert out.v_y >= -1e-12 * np.hypot(*velocity)
        dv_x = H[0] * out.F_x + H[1] * out.F_y
        dv_y = H[1] * out.F_x + H[2] * out.F_y
        size = (H[0] + H[2]) * max(out.F_y, abs(out.F_x))
        assert out.v_x - velocity[0] == pytest.approx(dv_x, abs=1e-12 * size)
        assert out.v_y - velocity[1] == pytest.approx(dv_y, abs=1e-12 * size)


def test_without_friction_the_restitution_is_that_of_the_speed():
    for H, velocity, e, _ in random_cases(100, seed=5):
        out = resolve(H, velocity, e, 0.0)
        assert out.F_x == 0.0
        assert out.v_y == pytest.approx(-e * velocity[1], rel=1e-12, abs=1e-14)


H = (2.0, -0.5, 1.0)


def test_a_slow_approach_with_a_fast_slide_keeps_its_restitution():
    """No squares of the approach underflow."""
    for v_x in (1.0, -3.0, 1e90):
        for v_y in (-1e-150, -1e-200, -1e-300):
            out = resolve((1.3, 0.4, 0.9), (v_x, v_y), 0.8, 0.25)
            assert out.v_y == pytest.approx(-0.8 * v_y, rel=1e-12, abs=0.0)
            assert out.v_x == v_x


@pytest.mark.parametrize(
    ("v_x", "friction", "kind", "sticks"),
    [
        (50.0, 0.1, Kind.I, False),
        (-5.0, 0.1, Kind.IV, False),
        (1.0, 0.1, Kind.II, False),
        (0.2, 0.1, Kind.III, False),
        (0.2, 0.3, Kind.III, True),
        (1.4, 0.3, Kind.II, True),
        (0.0, 0.1, Kind.FROM_REST, False),
        (0.0, 0.3, Kind.FROM_REST, True),
    ],
)
def test_types_of_figure_3(v_x, friction, kind, sticks):
    out = resolve(H, (v_x, -1.0), 0.8, friction)
    assert (Kind(out.kind), out.sticks) == (kind, sticks)
    mirrored = resolve((H[0], -H[1], H[2]), (-v_x, -1.0), 0.8, friction)
    expected = {
        Kind.I: Kind.IV,
        Kind.IV: Kind.I,
        Kind.II: Kind.II_MIRRORED,
        Kind.III: Kind.III_MIRRORED,
        Kind.FROM_REST: Kind.FROM_REST,
    }
    assert Kind(mirrored.kind) == expected[kind]


def test_no_impulse_when_not_approaching():
    assert resolve(H, (3.0, 0.0), 0.8, 0.25) == (0.0, 0.0, 3.0, 0.0, Kind.NONE, False)
    assert resolve(H, (3.0, 2.0), 0.8, 0.25).F_y == 0.0


@pytest.mark.parametrize(
    ("H", "velocity", "e", "mu"),
    [
        ((1.0, 1.0, 1.0), (0.0, -1.0), 0.5, 0.1),
        ((-1.0, 0.0, 1.0), (0.0, -1.0), 0.5, 0.1),
        ((math.nan, 0.0, 1.0), (0.0, -1.0), 0.5, 0.1),
        ((1.0, 0.0, 1.0), (math.inf, -1.0), 0.5, 0.1),
        ((1.0, 0.0, 1.0), (0.0, -1.0), 1.1, 0.1),
        ((1.0, 0.0, 1.0), (0.0, -1.0), math.nan, 0.1),
        ((1.0, 0.0, 1.0), (0.0, -1.0), 0.5, -0.1),
    ],
)
def test_unusable_numbers_are_refused(H, velocity, e, mu):
    with pytest.raises(TheoryError):
        resolve(H, velocity, e, mu)
