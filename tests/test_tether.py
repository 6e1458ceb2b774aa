"""Tether: closed forms, an independent rigid body, energy, and what slackness leaves alone."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from space_rival import plan_of, weightless

from walkergen.errors import InputError
from walkergen.lab import resting
from walkergen.scene import GRAVITY, Scene
from walkergen.simulation import record
from walkergen.simulation.effects import acting, tether
from walkergen.simulation.effects.resolve import resolve, without_space
from walkergen.simulation.space.state import C_X, C_Y, LEGS, Q_0, Q_Z, V_X, V_Y, W_X, W_Z
from walkergen.simulation.world import OK
from walkergen.theory import surrogate
from walkergen.theory.surrogate import UnknownError
from walkergen.walker import solids
from walkergen.walker.design import Design

HIGH = {"height_mm": 500.0, "length_mm": 1e-3}
"""A tether whose end is far above a plate that nothing reaches."""

STEP_US = 2.7
"""Step of which the longest flight is 128, 0.35 ms: feet that touch nothing would allow 20 times more."""

TIED = {"tether": {"stiffness_n_per_m": 1.0}, "legs": {"model": "compliant"}}

OFF = {"forward_mm": 9.0, "up_mm": 3.0, "left_mm": 1.0}
"""A point of the body off its centre of mass."""


def hung(kind="flexible", drop=30.0, **keys):
    """Plan of a walker on a tether, without damping, and a state at rest under its end."""
    tables = {"run": {"step_us": STEP_US}} | ({"legs": {"damping_ratio": 0.0}} if kind == "flexible" else {})
    plan = plan_of(10.0, kind, tether={**HIGH, "stiffness_n_per_m": 10.0, **keys}, **tables)
    state = plan.start(1.0, 0.0, 0.0)
    state[C_Y] = 500.0 - drop
    return plan, state


def moved(plan, state, seconds):
    """State after so many seconds in flight."""
    end = state.copy()
    tally = record.new()
    assert plan.advance(end, seconds, tally) == OK
    assert tally.sums[record.CONTACT_TIME] == 0.0
    return end


def test_on_a_spring_it_swings_as_a_mass_does():
    plan, state = hung(drop=1.0)
    mass = plan.world.walker.mass
    omega = math.sqrt(1e4 / mass)
    middle = 500.0 - 1e-3 - mass * GRAVITY / 1e4
    t = 3.3 * math.pi / omega
    end = moved(plan, state, t)
    # The spring's length, and second order in the longest flight: (0.35 ms * omega)^2
    assert end[C_Y] == pytest.approx(middle + (state[C_Y] - middle) * math.cos(omega * t), abs=1e-3)
    np.testing.assert_array_equal(end[W_X : W_Z + 1], 0.0)
    np.testing.assert_allclose(end[LEGS : LEGS + 4], 0.0, atol=1e-15)


def test_off_the_centre_it_turns_as_an_independent_rigid_body_does():
    plan, state = hung("braced", 12.0, forward_mm=9.0, up_mm=3.0)
    walker, k = plan.world.walker, 1e4
    place, inertia = np.array([9.0, 3.0]), walker.inertia[2, 2]

    def slopes(t, z):
        angle = z[2]
        c, s = math.cos(angle), math.sin(angle)
        arm = np.array([c * place[0] - s * place[1], s * place[0] + c * place[1]])
        line = np.array([0.0, 500.0]) - z[:2] - arm
        distance = math.hypot(*line)
        force = k * max(distance - 1e-3, 0.0) * line / distance
        torque = arm[0] * force[1] - arm[1] * force[0]
        push = force / walker.mass
        return [*z[3:], push[0], push[1] - GRAVITY, torque / inertia]

    seconds = 0.05
    start = [state[C_X], state[C_Y], 0.0, 0.0, 0.0, 0.0]
    rival = solve_ivp(slopes, (0.0, seconds), start, "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    errors = []
    for coarser in (0.25, 0.125):  # finer than what the body's turn allows
        world = plan.model.coarser(plan.world, coarser)
        end = moved(plan._replace(world=world), state, seconds)
        angle = 2.0 * math.atan2(end[Q_Z], end[Q_0])
        found = np.array([end[C_X], end[C_Y], angle, end[V_X], end[V_Y], end[W_Z]])
        turn = rival.copy()
        turn[2] = math.remainder(rival[2] - angle, 2.0 * math.pi) + angle
        errors.append(np.abs(found - turn) / (1.0, 1.0, 0.1, 1e3, 1e3, 1e2))
    assert abs(rival[2]) > 0.5
    assert errors[0].max() < 1e-3
    assert errors[0].max() / errors[1].max() == pytest.approx(4.0, abs=0.8)


def drift(kind, finer):
    """Largest share of its energy that a weightless walker gains or loses in 50 ms."""
    plan, state = hung(kind, drop=12.0, **OFF)
    plan = weightless(plan)
    plan = plan._replace(world=plan.model.coarser(plan.world, 1.0 / finer))
    before, now, worst = plan.energy(state), state, 0.0
    for _ in range(20):
        now = moved(plan, now, 2.5e-3)
        worst = max(worst, abs(plan.energy(now) - before) / before)
    return worst


def test_taut_and_undamped_it_keeps_energy_to_second_order():
    coarse, fine = drift("braced", 4.0), drift("braced", 8.0)
    assert coarse < 2e-4
    assert coarse / fine == pytest.approx(4.0, abs=0.3)
    # What remains whatever the step is the legs' centrifugal force, which the model leaves out
    assert drift("flexible", 16.0) < 2e-5


def test_slack_it_is_bitwise_as_if_there_were_none():
    lane = {"drive": {"frequency_hz": 90.0, "gamma": 1.8}}
    slack = {"stiffness_n_per_m": 10.0, "length_mm": 200.0, "height_mm": 100.0, **OFF}
    ends = []
    for tables in ({}, {"tether": slack}):
        plan = plan_of(10.0, **lane, **tables)
        state = plan.start(0.05, 0.002, 0.3, 0.001)
        assert plan.advance(state, 0.2, record.new()) == OK
        ends.append(state)
    np.testing.assert_array_equal(ends[0], ends[1])


def test_force_and_torque_are_what_the_potential_loses():
    """By central differences, over poses that no direction favours."""
    rng = np.random.default_rng(3)
    spring = tether.Spring(1e4, 3.0, (5.0, 40.0, -2.0), (9.0, 3.0, -1.0))
    on = acting.Acting(None, tether=spring)
    for _ in range(20):
        C = rng.normal(size=3) * 5.0
        R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        R *= np.sign(np.linalg.det(R))
        pull = np.array(acting.pull(on, *C, R))
        for i, e in enumerate(np.eye(3)):
            lost = [acting.potential(on, *(C + s * 1e-4 * R @ e), R) for s in (1.0, -1.0)]
            assert pull[i] == pytest.approx((lost[1] - lost[0]) / 2e-4, rel=1e-6, abs=1e-2)
            cross = np.cross(np.eye(3), e)
            turns = [acting.potential(on, *C, R @ (np.eye(3) + s * 1e-5 * cross)) for s in (1.0, -1.0)]
            assert pull[3 + i] == pytest.approx((turns[1] - turns[0]) / 2e-5, rel=1e-5, abs=1.0)


def test_a_bound_holds_wherever_the_body_may_move():
    rng = np.random.default_rng(5)
    on = acting.Acting(None, tether=tether.Spring(1e4, 3.0, (5.0, 40.0, -2.0), (9.0, 3.0, -1.0)))
    force, torque = acting.strongest(on, 0.0, 0.0, 0.0, np.eye(3), 2.0)
    for _ in range(50):
        way = rng.normal(size=3)
        pull = acting.pull(on, *(2.0 * way / np.linalg.norm(way)), np.eye(3))
        assert np.linalg.norm(pull[:3]) <= force
        assert np.linalg.norm(pull[3:]) <= torque


def test_pulled_sideways_a_walker_at_rest_slides_where_friction_gives_way():
    """Level tether at the height of the centre of mass; friction 0.25 of the weight holds."""
    weight = 1.0e-3 * plan_of(10.0).world.walker.mass * GRAVITY  # N/m at 1 mm
    for share, slides in ((0.15, False), (0.5, True)):
        tied = {"stiffness_n_per_m": share * weight / 100.0, "length_mm": 1.0, "x_mm": 101.0}
        plan = plan_of(10.0, tether=tied | {"height_mm": 10.0})
        state = plan.start(1e-4, 0.0, 0.0)
        plan.advance(state, 0.1, record.new())
        assert (state[C_X] > 1.0) == slides


def test_planar_models_refuse_it_and_benches_and_ladders_leave_it_out():
    scene, design = Scene.model_validate(TIED), Design()
    mass = solids.mass_of(design)
    with pytest.raises(InputError, match=r"tether\.stiffness_n_per_m = 1: only the model 'space'"):
        resolve(scene, design, mass)
    assert not resolve(without_space(scene), design, mass).on(tether.NAME)
    assert resting.resting(scene).tether == Scene().tether
    with pytest.raises(UnknownError, match=r"tether\.stiffness_n_per_m = 1"):
        surrogate.of(scene.variant(**{"legs.model": "space"}), design, mass)
