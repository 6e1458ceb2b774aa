"""Speed of a walker on unlike feet: both balances, limits, a walk by single impacts, simulation."""

import math

import numpy as np
import pytest
from scipy.optimize import nnls

from walkergen.commands.selftest.scenes import masses
from walkergen.core.errors import TheoryError
from walkergen.core.numerics.kernels import kernel
from walkergen.core.theory.balance import Foot, solve_balance
from walkergen.core.theory.impact import impact
from walkergen.core.theory.speed import factor, factors
from walkergen.core.theory.tensors import InverseMass, foot_tensors, rigid_tensor
from walkergen.core.walker.design import Design

M, J = 1.0, 68.0  # about the paper's braced walker


def rigid_foot(x, y, friction=0.25, restitution=0.8):
    """Foot of a rigid walker at (x, y) from its centre of mass."""
    return Foot(rigid_tensor(M, J, np.array((x, y))), (x, y), restitution, friction)


def walker_feet(tilt, e, mu):
    """Feet of the paper's walker, with levers from the body's centre of mass as in the paper."""
    mass = masses(Design().variant(tilt_deg=float(tilt)))
    both = zip(foot_tensors(mass), mass.legs, strict=True)
    return mass, [Foot(H, tuple(leg.foot), e, mu) for H, leg in both]


def random_feet(count, seed, drop=0.0):
    """Feet at alternate sides of O with any tensor and contact; heights differ by up to `drop`."""
    rng = np.random.default_rng(seed)
    found = []
    for i in range(count):
        a = rng.normal(size=(2, 2))
        h = a @ a.T + 1e-2 * np.eye(2)
        lever = ((-1) ** (i + 1) * rng.uniform(3, 9), -8.0 + drop * rng.uniform())
        H = InverseMass(h[0, 0], h[0, 1], h[1, 1])
        found.append(Foot(H, lever, rng.uniform(), 10 ** rng.uniform(-2, 0)))
    return found


def hit_foot(foot, speed):
    return impact(*foot.H, speed, -1.0, foot.restitution, foot.friction)


@pytest.mark.parametrize(("count", "drop"), [(2, 0.0), (2, 2.0), (3, 0.0), (5, 1.0)])
def test_both_momenta_balance(count, drop):
    for seed in range(25):
        every = random_feet(count, seed, drop)
        found = solve_balance(every)
        hits = [hit_foot(foot, float(found.factor)) for foot in every]
        F_x, F_y = np.array([hit[:2] for hit in hits]).T
        x, y = np.array([foot.lever for foot in every]).T
        scale = found.shares @ F_y
        # The steepest force ratio here is of the order 1e3, times the rounding of the speed.
        assert abs(found.shares @ F_x) <= 1e-11 * scale
        assert abs(found.shares @ (x * F_y - y * F_x)) <= 1e-10 * scale
        assert found.shares.sum() == pytest.approx(1.0, rel=1e-14)
        np.testing.assert_allclose(found.loads, found.shares * F_y / scale, rtol=1e-12, atol=0)
        own = [float(factor(f.H, f.restitution, f.friction)) for f in every]
        assert min(own) <= found.factor <= max(own)


def test_force_ratio_never_rises_with_speed():
    """So that the root is the only one, and no two feet are flat about it: see section 4b."""
    for foot in random_feet(20, seed=4):
        bound = 50.0 * (foot.H.xx + abs(foot.H.xy))
        speeds = np.concatenate([-np.geomspace(bound, 1e-3, 100), np.geomspace(1e-3, bound, 100)])
        hits = [hit_foot(foot, speed) for speed in speeds]
        ratios = np.array([hit.F_x / hit.F_y for hit in hits])
        assert (np.diff(ratios) <= 1e-14).all()
        flat = np.abs(ratios) >= foot.friction * (1 - 1e-12)
        assert (ratios[flat] * speeds[flat] <= 0).all()


def test_equal_feet_have_the_speed_of_one():
    H = InverseMass(2.0, -0.5, 1.0)
    pair = [Foot(H, (x, -9.0), 0.7, 0.2) for x in (-4.0, 7.0)]
    assert solve_balance(pair).factor == factor(H, 0.7, 0.2)


@pytest.mark.parametrize(("e", "mu"), [(0.9, 0.1), (0.8, 0.25)])
def test_paper_walker_keeps_its_mean(e, mu):
    """docs/physics.md section 4b: at most 1.1 % apart, where the feet's speeds are 7 to 15 %."""
    for tilt in (1, 3, 5, 8, 10, 15, 20, 30, 45):
        mass, pair = walker_feet(tilt, e, mu)
        mean = float(factors(mass, e, mu).mean)
        assert float(solve_balance(pair).factor) == pytest.approx(mean, rel=0.011)
    assert float(solve_balance(walker_feet(0, e, mu)[1]).factor) == pytest.approx(0, abs=1e-13)


def test_mirror_image_runs_backwards_exactly():
    for count in (2, 4):
        every = random_feet(count, 7, drop=1.0)
        image = [
            foot._replace(H=foot.H._replace(xy=-foot.H.xy), lever=(-foot.lever[0], foot.lever[1])) for foot in every
        ]
        one, other = solve_balance(every), solve_balance(image)
        assert other.factor == -one.factor
        np.testing.assert_array_equal(other.shares, one.shares)


def test_one_foot_without_friction_leaves_the_speed_to_the_other():
    """Its impulse is vertical for all shares, so the other's must vanish alone."""
    back, front = rigid_foot(-4.0, -9.0), rigid_foot(9.0, -9.0, friction=0.0)
    own = float(factor(back.H, 0.8, 0.25))
    found = solve_balance([back, front])
    assert float(found.factor) == pytest.approx(own, rel=1e-10)
    assert found.loads == pytest.approx([9 / 13, 4 / 13], rel=1e-12)


def test_friction_zero_is_the_limit():
    pairs = [[rigid_foot(-5.0, -9.0, mu), rigid_foot(8.0, -9.0, mu)] for mu in (0.0, 1e-9)]
    assert float(solve_balance(pairs[0]).factor) == pytest.approx(float(solve_balance(pairs[1]).factor), 1e-7)


def test_two_materials_run_with_the_smoother_foot_ahead():
    """Each foot pulls the body to the other's side; at rest the rougher one pulls harder."""
    assert solve_balance([rigid_foot(-6.5, -9.0), rigid_foot(6.5, -9.0)]).factor == 0.0
    forward = solve_balance([rigid_foot(-6.5, -9.0, 0.6), rigid_foot(6.5, -9.0, 0.1)])
    assert float(forward.factor) == pytest.approx(0.6646, abs=1e-4)
    # Where both can stick (|H_xy| / H_xx = 0.39) neither slides at rest, and the forces are equal.
    assert abs(solve_balance([rigid_foot(-6.5, -9.0, 0.8), rigid_foot(6.5, -9.0, 0.5)]).factor) < 1e-15


def net_at_rest(pair):
    """Net force over net normal force at no speed, with shares that balance angular momentum."""
    hits = [hit_foot(foot, 0.0) for foot in pair]
    turn = [f.lever[0] * h.F_y - f.lever[1] * h.F_x for f, h in zip(pair, hits, strict=True)]
    s_back, s_front = turn[1], -turn[0]
    return (s_back * hits[0].F_x + s_front * hits[1].F_x) / (s_back * hits[0].F_y + s_front * hits[1].F_y)


def test_unequal_lengths_act_in_second_order_of_friction():
    """The paper's remark: a level body on legs of unequal length, O midway between the feet."""
    frictions = np.array([1e-4, 1e-3, 1e-2])
    pairs = [[rigid_foot(-6.5, -9.0, mu), rigid_foot(6.5, -7.0, mu)] for mu in frictions]
    forces = np.array([net_at_rest(pair) for pair in pairs])
    # N_back - N_front = mu (difference of heights) / (span), and each foot pulls with mu N.
    np.testing.assert_allclose(forces, frictions**2 * 2.0 / 13.0, rtol=0.02)
    assert np.polyfit(np.log(frictions), np.log(forces), 1)[0] == pytest.approx(2.0, abs=0.01)
    # What opposes the motion is of first order, so the speed is too.
    speeds = np.array([float(solve_balance(pair).factor) for pair in pairs])
    H = pairs[0][0].H
    expected = 2.0 / 13.0 * 1.8 * abs(H.xy) / H.yy
    np.testing.assert_allclose(speeds / frictions, expected, rtol=0.05)


def test_unequal_levers_act_in_first_order_and_the_shorter_one_pushes():
    """The paper on its reference 7: more impacts at the foot that is nearer to O."""
    frictions = np.array([1e-4, 1e-3, 1e-2])
    pairs = [[rigid_foot(-4.0, -9.0, mu), rigid_foot(9.0, -9.0, mu)] for mu in frictions]
    forces = np.array([net_at_rest(pair) for pair in pairs])
    # N_back - N_front = 5/13; the net force itself turns the walker in the next order.
    np.testing.assert_allclose(forces, frictions * 5.0 / 13.0, rtol=0.02)
    assert np.polyfit(np.log(frictions), np.log(forces), 1)[0] == pytest.approx(1.0, abs=0.01)
    found = solve_balance(pairs[0])
    assert found.shares[0] > 0.5
    # The back foot's force vanishes with the rest: p_1 / p = (N_b - N_f) / (2 N_b) = 5/18.
    H = pairs[0][0].H
    assert float(found.factor) == pytest.approx(5 / 18 * 1.8 * abs(H.xy) / H.yy, rel=1e-3)


def test_unequal_lengths_of_feet_on_the_plate_act_through_levers_alone():
    """With both feet down heights are equal: a leg of double length matters through the height of O."""
    assert solve_balance([rigid_foot(-6.5, -7.0), rigid_foot(6.5, -7.0)]).factor == 0.0
    long, short = np.array((-6.5, -9.0)), np.array((6.5, -4.5))
    pitch = math.atan((long[1] - short[1]) / (short[0] - long[0]))
    turned = np.array(((math.cos(pitch), -math.sin(pitch)), (math.sin(pitch), math.cos(pitch))))
    back, front = turned @ long, turned @ short
    assert back[1] == pytest.approx(front[1])
    assert -back[0] > front[0]
    found = solve_balance([rigid_foot(*back), rigid_foot(*front)])
    assert found.factor < 0.0
    # The body held level, as the paper has it, would run the other way and more slowly.
    level = solve_balance([rigid_foot(*long), rigid_foot(*short)])
    assert 0.0 < level.factor < -found.factor


def test_a_walk_by_single_impacts_ends_at_the_balance():
    """Rival: a foot at random, or the one that turns the walker back; each pushes a heavy body."""
    pair = [rigid_foot(-4.0, -9.0, 0.3, 0.5), rigid_foot(9.0, -8.0, 0.1, 0.8)]
    rng = np.random.default_rng(1)
    speed, spin, total, hits = 0.0, 0.0, 0.0, np.zeros(2)
    for step in range(9000):
        # Counter-clockwise spin calls for the foot behind O, number 0.
        i = int(spin < 0.0) if abs(spin) > 30.0 else int(rng.integers(2))
        hit, (x, y) = hit_foot(pair[i], speed), pair[i].lever
        spin += x * hit.F_y - y * hit.F_x
        speed += 0.01 * hit.F_x
        if step >= 3000:
            total += speed
            hits[i] += 1
    found = solve_balance(pair)
    # Speeds swing by 0.01 over a few hundred impacts; 6000 of them leave a tenth of that.
    assert total / 6000 == pytest.approx(float(found.factor), abs=0.003)
    np.testing.assert_allclose(hits / 6000, found.shares, atol=0.003)


@kernel
def shake_walker(feet, duration, step, seed):
    """Rigid walker (M, J) from impact to impact on a plate at 90 Hz, 1.8 g; e = 0.8, Poisson.

    Feet of shape (2, 3): vector from O, friction. Returns the mean speed, the mean speed of
    approach by normal impulse, and the feet's normal impulses; the first second is left out.
    """
    gravity, omega = 9806.65, 2.0 * math.pi * 90.0
    amplitude = 1.8 * gravity / omega**2
    np.random.seed(seed)
    x, y, pitch = 0.0, 2.0 * amplitude - feet[0, 1], 1e-3 * np.random.uniform(-1.0, 1.0)
    v_x, v_y, spin, phase = 0.0, 0.0, 0.0, 2.0 * math.pi * np.random.random()
    normal, approach, start = np.zeros(2), 0.0, 0.0
    for number in range(int((1.0 + duration) / step)):
        t = number * step
        x, y, pitch = x + v_x * step, y + (v_y - 0.5 * gravity * step) * step, pitch + spin * step
        v_y -= gravity * step
        if t < 1.0:
            start = x
        height, rising = amplitude * math.sin(phase + omega * t), math.cos(phase + omega * t)
        for i in range(2):
            r_x = feet[i, 0] * math.cos(pitch) - feet[i, 1] * math.sin(pitch)
            r_y = feet[i, 1] * math.cos(pitch) + feet[i, 0] * math.sin(pitch)
            u_x, u_y = v_x - spin * r_y, v_y + spin * r_x - amplitude * omega * rising
            if y + r_y < height and u_y < 0.0:
                H_xx, H_xy, H_yy = 1 / M + r_y * r_y / J, -r_x * r_y / J, 1 / M + r_x * r_x / J
                hit = impact(H_xx, H_xy, H_yy, u_x, u_y, 0.8, feet[i, 2])
                v_x, v_y = v_x + hit.F_x / M, v_y + hit.F_y / M
                spin += (r_x * hit.F_y - r_y * hit.F_x) / J
                if t >= 1.0:
                    normal[i] += hit.F_y
                    approach -= u_y * hit.F_y
    return (x - start) / duration, approach / normal.sum(), normal


@pytest.mark.parametrize(
    "pair",
    [
        [rigid_foot(-4.0, -9.0), rigid_foot(9.0, -9.0)],
        [rigid_foot(-6.5, -9.0, 0.1), rigid_foot(6.5, -9.0, 0.6)],
        [rigid_foot(-5.0, -9.0, 0.1), rigid_foot(8.0, -9.0, 0.6)],
    ],
    ids=["levers", "materials", "both"],
)
def test_shaken_rigid_walker_has_the_direction_and_the_loads(pair):
    """Spin, which the theory leaves out, brings the speed to half to two thirds (section 4b)."""
    numbers = np.array([(*foot.lever, foot.friction) for foot in pair])
    runs = [shake_walker(numbers, 6.0, 1e-5, seed) for seed in range(2)]
    found = solve_balance(pair)
    loads = np.mean([normal / normal.sum() for *_, normal in runs], axis=0)
    np.testing.assert_allclose(loads, found.loads, atol=0.03)
    ratio = np.mean([speed / approach for speed, approach, _ in runs]) / float(found.factor)
    assert 0.4 < ratio < 0.85  # 0.50, 0.63, 0.72 over 8 runs of 10 s, +- 0.02


def test_many_feet_bear_loads_as_springs_that_cannot_pull():
    """Rival: constrained least squares by an active-set solver."""
    rng = np.random.default_rng(5)
    released = 0
    for _ in range(60):
        x = rng.uniform(-3.0, 10.0, int(rng.integers(3, 9)))
        x[:2] = -abs(x[0]), abs(x[1])
        found = solve_balance([rigid_foot(place, -9.0) for place in x]).loads
        n, heavy = len(x), 1e5
        rows = np.vstack([np.eye(n), np.full(n, heavy), heavy * x])
        expected, _ = nnls(rows, np.concatenate([np.full(n, 1 / n), [heavy, 0.0]]))
        np.testing.assert_allclose(found, expected, atol=1e-8)  # 1/heavy^2, and its condition
        released += (found == 0.0).any()
    assert 10 < released < 50


def test_pairs_of_feet_side_by_side_count_as_one():
    one = solve_balance([rigid_foot(-4.0, -9.0), rigid_foot(9.0, -9.0, 0.1)])
    four = solve_balance([rigid_foot(-4.0, -9.0), rigid_foot(9.0, -9.0, 0.1)] * 2)
    assert float(four.factor) == pytest.approx(float(one.factor), rel=1e-13)
    np.testing.assert_allclose(four.shares, np.tile(one.shares, 2) / 2, rtol=1e-12)
    assert "both feet" in one.note
    assert "4 feet" in four.note


def test_arrays_equal_one_by_one():
    e, mu = np.meshgrid([0.0, 0.4, 1.0], [0.0, 0.1, 3.0])
    pair = [rigid_foot(-4.0, -9.0, mu, e), rigid_foot(9.0, -9.0, 0.2, 0.5)]
    many = solve_balance(pair)
    assert many.shares.shape == many.loads.shape == (2, 3, 3)
    for place in np.ndindex(3, 3):
        single = [rigid_foot(-4.0, -9.0, mu[place], e[place]), pair[1]]
        one = solve_balance(single)
        assert many.factor[place] == one.factor
        np.testing.assert_array_equal(many.shares[:, *place], one.shares)


@pytest.mark.parametrize(
    ("every", "mode", "message"),
    [
        ([rigid_foot(-4.0, -9.0)], "coulomb", r"\(-4, -9\) mm .* tips"),
        ([rigid_foot(3.0, -9.0), rigid_foot(5.0, -9.0)], "coulomb", r"\(3, -9\), \(5, -9\) mm .* tips"),
        ([rigid_foot(0.0, -9.0), rigid_foot(5.0, -9.0)], "coulomb", "tips"),
        ([rigid_foot(-4.0, -9.0), rigid_foot(5.0, -9.0)], "paper", "mode = 'paper'"),
        ([rigid_foot(-4.0, -9.0, -0.1), rigid_foot(5.0, -9.0)], "coulomb", "friction"),
        ([rigid_foot(-4.0, -9.0, 0.1, 1.2), rigid_foot(5.0, -9.0)], "coulomb", "restitution"),
        ([rigid_foot(-4.0, -9.0), rigid_foot(5.0, -9.0)._replace(lever=(np.nan, 0.0))], "coulomb", "finite"),
        (
            [rigid_foot(-4.0, -9.0), rigid_foot(5.0, -9.0)._replace(H=InverseMass(1.0, 2.0, 1.0))],
            "coulomb",
            "positive definite",
        ),
        (
            # Lines of action at 22 deg that cross behind O.
            [
                Foot(InverseMass(1.0, -0.5, 1.0), (-1.0, -9.0), 0.5, 0.4),
                Foot(InverseMass(1.0, 0.5, 1.0), (1.0, -2.0), 0.5, 0.4),
            ],
            "coulomb",
            "Level the feet",
        ),
    ],
)
def test_cases_without_a_stationary_state_are_refused(every, mode, message):
    with pytest.raises(TheoryError, match=message):
        solve_balance(every, mode)


def test_no_feet_are_refused():
    with pytest.raises(TheoryError, match="without feet"):
        solve_balance([])
