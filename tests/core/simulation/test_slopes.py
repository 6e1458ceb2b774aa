"""Walkers on a slope, from the command's function: sliding, sticking and tipping as by Coulomb and by statics.

Gravity is 9806.65 mm/s^2. Down a slope s with friction mu the normal force is m g cos(s) on average, whichever feet
carry it. So any walker that slides gains a = g (sin(s) - mu cos(s)), and does not start below tan(s) = mu (Coulomb
1785). A rigid body tips over a foot that lies d down the slope of its centre of mass, at the height h, beyond
tan(s) = d/h.
"""

import math

import numpy as np
import pytest

import walkergen as wg
from walkergen.core.scene import GRAVITY, Scene, still_plate_drive
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.state import QUIET
from walkergen.core.simulation.world import OK, TOPPLED
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

BRACED = Design().variant(tilt_deg=10.0, kind="braced")
FLEXIBLE = Design().variant(tilt_deg=10.0)
MODELS = pytest.mark.parametrize(
    ("design", "feet"),
    [(BRACED, {}), (BRACED, {"rigid_tips": True}), (FLEXIBLE, {}), (FLEXIBLE, {"rigid_tips": True})],
    ids=["braced", "braced, rigid tips", "flexible", "flexible, rigid tips"],
)


def slope_of(slope_deg, friction, feet=None, **run):
    """Scene of a still plate that slopes; the walker stays in its plane."""
    return Scene.model_validate(
        {
            "drive": still_plate_drive(90.0),
            "arena": {"kind": "plane"},
            "plate": {"slope_deg": slope_deg},
            "contact": {"friction": friction, "restitution": 0.1},
            "feet": feet or {},
            "run": {"seconds": 1.0, "discard_seconds": 1.0, "runs": 1} | run,
            "effects": {"off": ["air_drag", "roll_and_yaw"]},
        }
    )


@MODELS
@pytest.mark.parametrize(("slope", "friction", "mean"), [(30, 0.25, 4170.18), (20, 0.25, 1575.39), (30, 0.1, 6081.07)])
def test_a_walker_slides_down_as_coulomb_says(design, feet, slope, friction, mean):
    """Mean over one second after one second from rest: 1.5 s times a."""
    s = math.radians(slope)
    assert 1.5 * GRAVITY * (math.sin(s) - friction * math.cos(s)) == pytest.approx(mean, abs=0.005)
    found = wg.simulate(design, scene=slope_of(slope, friction, feet)).speed.value
    # It is dropped at a pitch of up to 1 mrad: its other foot is 13 um high, and lands and bounces for 2 ms. Until then
    # feet stick or slip back, which at most turns friction round
    assert abs(found - mean) < 2.0 * friction * GRAVITY * math.cos(s) * 2e-3


def check_flutter(angle, friction, feet):
    """Check that a walker whose legs flutter rests 2 deg below the angle of friction, and slides above it."""
    scenes = [slope_of(angle + off, friction, feet) for off in (-2.0, 0.1)]
    below, above = (wg.simulate(FLEXIBLE, scene=scene).speed.value for scene in scenes)
    assert below == 0.0 < above


@MODELS
@pytest.mark.parametrize(("friction", "angle"), [(0.25, 14.036), (0.6, 30.964)])
def test_a_walker_sticks_below_the_angle_of_friction_and_slides_above(design, feet, friction, angle):
    """Within 0.1 deg of atan(mu), which is g cos(s) (1 + mu^2) 0.1 deg of acceleration: 18 and 20 mm/s^2.

    Flexible legs on rigid tips flutter at mu = 0.6 once they slide, with 1400 landings a second. They then creep at
    13.7 mm/s (the same at 1/4 and 1/16 of the step), and stop 2 deg below.
    """
    if design is FLEXIBLE and feet and friction > 0.5:
        check_flutter(angle, friction, feet)
        return
    assert math.degrees(math.atan(friction)) == pytest.approx(angle, abs=5e-4)
    # Setting it down gives it at most 40 mm/s, which 2 s and more take away again
    scenes = [slope_of(angle + off, friction, feet, discard_seconds=4.0) for off in (-0.1, 0.1)]
    below, above = (wg.simulate(design, scene=scene).speed.value for scene in scenes)
    expected = 4.5 * GRAVITY * math.cos(math.radians(angle)) * (1.0 + friction**2) * math.radians(0.1)
    assert abs(below) < 0.01 * expected
    assert expected < above < expected + 40.0


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["front", "back"])
def test_a_rigid_walker_tips_over_its_foot_as_by_statics(side):
    """The plate is tilted in steps of 0.02 deg, with friction 2, until the walker tips over."""
    mass = solids.mass_of(BRACED)
    masses = np.array([mass.M, *(leg.m for leg in mass.legs)])
    places = np.array([np.zeros(2), *(leg.anchor + leg.c_A for leg in mass.legs)])
    feet = [leg.anchor + leg.c_A + leg.c_T for leg in mass.legs]
    centre = masses @ places / masses.sum()
    foot = max(feet, key=lambda place: side * place[0])
    expected = math.degrees(math.atan2(side * (foot[0] - centre[0]), centre[1] - foot[1]))
    state, status, slope = None, OK, expected - 0.4
    while status == OK and slope < expected + 1.0:
        slope += 0.02
        plan = prepare(slope_of(side * slope, 2.0), BRACED, mass)
        state = plan.initial_state(0.0, 0.0, 0.0) if state is None else state
        state[QUIET] = 0.0  # it does not ride on: the plate has been tilted
        status = plan.advance(state, 0.1, record.new_tally(len(state)))
    assert status == TOPPLED
    assert slope == pytest.approx(expected, abs=0.1)


def test_the_error_by_the_step_is_measured_where_runs_hardly_scatter():
    """3 % of the speed, the bound of all walkers, is 47 mm/s; the mean itself is known to 9 (see above)."""
    scene = slope_of(20.0, 0.25, runs=4)
    found = wg.simulate(BRACED, scene=scene).speed
    assert found.bias < 2.0
    step_us = 0.1e6 * prepare(scene, BRACED, solids.mass_of(BRACED)).world.options.step
    exact = wg.simulate(BRACED, scene=slope_of(20.0, 0.25, runs=4, step_us=step_us)).speed.value
    assert abs(found.value - exact) < found.bias
