"""Air drag: off by default because it is small; forced on, a plate falls at its terminal speed."""

import math

import numpy as np
import pytest

from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import air_drag
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import Outcome, simulate
from walkergen.core.simulation.space.state import C_X, V_X, V_Y, W_Z
from walkergen.core.simulation.world import OK
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

DESIGN = Design().variant(tilt_deg=0.0)
"""Upright: a tilted walker turns as it falls, since its legs hang off the body's centre."""


def plan_of(air=True, **tables):
    effects = {"on": ["air_drag"] if air else []}
    scene = Scene.model_validate(tables | {"arena": {"kind": "plane"}, "effects": effects})
    return prepare(scene, DESIGN, solids.mass_of(DESIGN))


def let_fall(plan, seconds, height=1e6, v_x=0.0):
    """A walker let go level, high over the plate: its state after a fall, and the tally."""
    state = plan.initial_state(height, 0.0, 0.5 * math.pi)
    state[V_X] = v_x
    tally = record.new_tally(len(state))
    assert plan.advance(state, seconds, tally) == OK
    return state, tally


def test_drag_is_off_by_default_and_its_number_gives_the_reason():
    plan = plan_of(air=None)
    assert plan.world.acting.air == air_drag.OFF
    (drag,) = [effect for effect in plan.resolved.effects if effect.name == air_drag.NAME]
    assert not drag.on
    assert drag.reason == "small"
    # 0.5 x 1.2 x 1.2e-6 x sqrt[(24 x 93.6^2)^2 + (224 x 31.2^2)^2] over 0.25 x 0.833 x 9806
    assert drag.number == pytest.approx(1.06e-4, rel=0.02)


def test_a_fast_drive_warns_that_drag_is_not_small():
    plan = plan_of(air=None, drive={"frequency_hz": 5.0, "gamma": 20.0})
    (drag,) = [effect for effect in plan.resolved.effects if effect.name == air_drag.NAME]
    assert drag.number > air_drag.SMALL_DRAG_RATIO
    assert "NOT small" in drag.reason


@pytest.mark.slow
def test_a_falling_plate_approaches_its_terminal_speed():
    """v = v_t tanh(g t / v_t), v_t^2 = 2 M g / (C rho A): the legs' drag is left out."""
    plan = plan_of()
    area = DESIGN.body.length_mm * DESIGN.body.depth_mm
    push = air_drag.COEFFICIENT * air_drag.DENSITY * area
    terminal = math.sqrt(2.0 * plan.world.walker.mass * GRAVITY / push)
    seconds = 3.0
    state, _ = let_fall(plan, seconds, height=1e5)
    expected = terminal * math.tanh(GRAVITY * seconds / terminal)
    # Flights of 1.5 ms, of second order: (1.5 ms x g / v_t)^2 = 4e-6; rounding pitches nothing.
    assert -state[V_Y] == pytest.approx(expected, rel=1e-5)
    assert expected > 0.99 * terminal


@pytest.mark.slow
def test_flight_slows_along_the_plate_and_every_energy_is_accounted_for():
    plan, still = plan_of(), plan_of(air=False)
    seconds = 5e-3
    state, tally = let_fall(plan, seconds, v_x=5000.0)
    free, _ = let_fall(still, seconds, v_x=5000.0)
    slowed = plan.world.acting.air.ends * 5000.0**2 / plan.world.walker.mass * seconds
    assert free[V_X] - state[V_X] == pytest.approx(slowed, rel=0.02)  # the speed falls by 1 %
    assert state[C_X] < free[C_X]
    start = plan.initial_state(1e6, 0.0, 0.5 * math.pi)
    start[V_X] = 5000.0
    gained = plan.energy(state) - plan.energy(start)
    lost = tally.sums[record.DAMPING_LOSS]
    assert lost > 0.0
    # 2e-3: drag is held for a flight, while the speed falls by 0.2 %
    assert -gained == pytest.approx(lost, rel=5e-3)


def test_a_run_balances_with_drag_on():
    plan = plan_of(run={"seconds": 0.5, "discard_seconds": 0.0})
    result = simulate(plan, 0)
    assert result.outcome is Outcome.OK
    assert result.energy_error < 0.02


def test_no_air_is_the_limit_of_thin_air():
    """Drag falls in proportion to the density, and without any nothing is left of it."""
    plan, none = plan_of(), plan_of(air=False)
    still, _ = let_fall(none, 0.1, v_x=2000.0)
    changes = []
    for factor in (1.0, 1e-2):
        air = air_drag.Air(*(factor * value for value in plan.world.acting.air))
        acting = plan.world.acting._replace(air=air)
        thin = plan._replace(world=plan.world._replace(acting=acting))
        state, _ = let_fall(thin, 0.1, v_x=2000.0)
        changes.append(np.abs(state - still)[[V_X, V_Y]])
    assert changes[0] == pytest.approx(100.0 * changes[1], rel=0.03)
    assert abs(still[W_Z]) < 1e-15


def test_drag_is_against_the_motion_of_each_face():
    air = air_drag.Air(1e-5, 1e-4, 2e-5)
    for velocity in ((30.0, 0.0, 0.0), (-10.0, 20.0, 5.0), (3.0, -40.0, -7.0)):
        force = np.array(air_drag.force_in_space(air, np.array(velocity)))
        np.testing.assert_allclose(force, -np.array(air) * velocity * np.abs(velocity), rtol=1e-15)
