"""The walker in space against rivals: a landing by DOP853, Keller's equation, MuJoCo (docs/physics.md section 7)."""

import math

import numpy as np
import pytest
from space_rival import Walker, keller, land, plan_of, speeds, tip_of, weightless

from evidence.validate import mujoco_walker
from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.walker import mobility
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

UNDAMPED_LEGS = {"damping_ratio": 0.0}
CORNERS = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
"""Signs of pitch and roll that let each corner land first."""


@pytest.mark.parametrize("friction", [0.0, 1e3])
@pytest.mark.parametrize("tip", [{"rigid_tips": True}, {"tip_radius_um": 5e4}], ids=["rigid", "hertz"])
@pytest.mark.parametrize(("tilt", "label"), [(10, 0.3), (10, 0.8), (35, 0.5)])
def test_corner_lands_as_by_an_independent_integration(tilt, label, friction, tip):
    """Hinge and twist move during the contact; a corner that sticks, or rubs without friction.

    Tips of 50 mm are softer than the leg, and their contact is shorter than a swing of its twist. On tips of 5 um it
    lasts some swings, whose phase at the end differs by 1 % between the rival's slanted legs and the model's.
    """
    contact = {"restitution": label, "friction": friction}
    plan = weightless(plan_of(tilt, contact=contact, legs=UNDAMPED_LEGS, feet=tip, run={"step_us": 0.1}))
    walker, rival = plan.world.walker, Walker(plan.case.design, plan.case.mass)
    velocity = 0.1 * np.array([-0.3, -1.0, 0.2])
    for pitch, roll in CORNERS:
        _, events, found = land(plan, velocity, 2e-5 * pitch, 2e-5 * roll, clearance=1e-4)
        corner = int(events[0, 1])
        expected = rival.landing(corner, tip_of(walker, corner), walker.stiffness, velocity, friction > 0.0)
        # 4e-4: a pose of 2e-5 rad changes the corner's inverse mass by 2e-4, as far as it shows
        # without friction; slanted legs' twist and steps of 0.3 % of the contact add 1e-4
        np.testing.assert_allclose(found, expected, rtol=0, atol=4e-4 * math.sqrt(expected @ expected))


def stiffen_plan(plan, times):
    """The same plan with rigid tips so many times as stiff, in steps as much shorter as they resolve them."""
    world = plan.coarser(1.0 / math.sqrt(times)).world
    assert np.isinf(world.walker.tip).all()
    return plan._replace(world=world._replace(walker=world.walker._replace(spring=times * world.walker.spring)))


def stiff_plan(tilt, label, friction):
    """Plan of one landing within which the legs do not move: loose legs on stiff feet."""
    contact, feet = {"restitution": label, "friction": friction}, {"rigid_tips": True, "tangential_ratio": 1000.0}
    plan = weightless(
        plan_of(tilt, contact=contact, legs=UNDAMPED_LEGS, feet=feet, run={"step_us": 0.02 * math.sqrt(10.0)})
    )
    plan = stiffen_plan(plan, 10.0)
    walker = plan.world.walker
    walker = walker._replace(stiffness=0.0 * walker.stiffness)
    return plan._replace(world=plan.world._replace(walker=walker))


def impulse_and_rival(plan, velocity, signs, law):
    """Impulse of a corner in the simulator, and by Keller's equation."""
    contact = plan.scene.contact
    _, events, found = land(plan, velocity, 1e-4 * signs[0], 1e-4 * signs[1])
    corner = 3 * int(events[0, 1])
    W = Walker(plan.case.design, plan.case.mass).mobility()[corner : corner + 3, corner : corner + 3]
    approach = np.array([velocity[1], velocity[0], velocity[2]])
    return found, keller(W, contact.friction, approach, contact.restitution, law)


@pytest.mark.parametrize(
    ("tilt", "friction"), [(10, 0.1), (10, 0.25), (10, 0.5), (20, 0.25), (20, 0.6), (35, 0.5), (35, 1.0)]
)
@pytest.mark.parametrize("label", [0.3, 0.8])
def test_stiff_corner_obeys_kellers_equation(tilt, friction, label):
    """Slip may turn, stop and set off again; it may jam from W_nn / |W_nt| on: 0.23, 0.42, 0.71."""
    plan, rng = stiff_plan(tilt, label, friction), np.random.default_rng([tilt, int(100 * friction)])
    for signs in CORNERS:
        velocity = np.array([rng.normal() * 30.0, -30.0, rng.normal() * 15.0])
        found, expected = impulse_and_rival(plan, velocity, signs, "viscous")
        # 2 %: slip that turns back strains a tangential spring of 1000 k_n first, which counts most
        # where friction has undone most of the impulse; 0.3 % by a pose of 1e-4 rad
        np.testing.assert_allclose(found, expected, rtol=0, atol=2e-2 * math.sqrt(expected @ expected))


def test_elastic_feet_restore_energy_not_impulse():
    """Where slip changes in a landing, Stronge's law and Poisson's differ: undamped feet obey Stronge's."""
    plan, velocity = stiff_plan(20, 1.0, 0.25), np.array([48.8, -30.0, -21.2])
    found, stronge = impulse_and_rival(plan, velocity, (1.0, -1.0), "stronge")
    _, poisson = impulse_and_rival(plan, velocity, (1.0, -1.0), "poisson")
    size = math.sqrt(stronge @ stronge)
    assert np.abs(found - stronge).max() < 0.01 * size  # step and tangential spring as above
    assert np.abs(found - poisson).max() > 0.05 * size


IN_PLANE = {"effects": {"off": ["roll_and_yaw"]}}
"""Tables of a scene that holds the walker in its plane."""


def mean_speed(tilt, label, seconds, finer=1.0, **tables):
    """Mean speed and its standard error (mm/s) on the paper's plate: eight runs by steps `finer` than the own."""
    design = Design().variant(tilt_deg=float(tilt))
    contact = {"restitution": label, "friction": 0.25} | tables.pop("contact", {})
    run = {"seconds": seconds, "discard_seconds": 0.5, "runs": 8}
    scene = Scene.model_validate({"contact": contact, "run": run} | tables)
    plan = prepare(scene, design, solids.mass_of(design))
    if finer > 1.0:
        plan = plan.coarser(1.0 / finer)
    results = batch.run_all(ensemble.runner(plan), plan.scene.run.runs, threads=1)
    return ensemble.summarise(results, plan.equivalent_drive.peak_speed, 0.0).speed.pair


RIGID = {"rigid_tips": True}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tilt", "label", "expected"), [(5, 0.3, 40.0), (10, 0.5, 111.0), (15, 0.3, 55.0), (20, 0.5, 22.0), (35, 0.3, 3.0)]
)
def test_elastic_feet_in_the_plane_run_as_in_another_integrator(tilt, label, expected):
    found, error = mean_speed(tilt, label, 3.0, feet=RIGID, **IN_PLANE)
    # 1.5 mm/s: errors of the other's speeds. 10 %: its tangential dampers are not known; without
    # any the speeds here are 11 and 3 % lower at 10 deg, 18 % at 15 deg (labels 0.3, 0.5; 0.5)
    assert found == pytest.approx(expected, abs=3.0 * error + 0.1 * expected + 1.5)


@pytest.mark.parametrize(
    ("tilt", "gamma"),
    [
        pytest.param(10, 1.8, marks=pytest.mark.slow),
        *(pytest.param(tilt, 1.8, marks=pytest.mark.nightly) for tilt in (5, 15, 20, 35)),
        *(pytest.param(15, gamma, marks=pytest.mark.nightly) for gamma in (1.4, 2.2, 2.6)),
    ],
)
def test_compliant_tips_run_as_in_a_second_program(tilt, gamma):
    """Free to roll, turn and twist, default contact. At 5 deg and 1.8 g 40.0 +- 0.3 for the other's 39.9 +- 1.1."""
    scene = {"arena": {"kind": "plane"}, "drive": {"frequency_hz": 90.0, "gamma": gamma}}
    friction = Scene().contact.friction
    found, error = mean_speed(tilt, Scene().contact.restitution, 4.0, contact={"friction": friction}, **scene)
    runs = speeds(plan_of(tilt, **scene), 3.0, range(6), 3e-6)
    other = runs.std(ddof=1) / math.sqrt(len(runs))
    # 3 %: explicit steps of the other, first order in the damper, and its errors of six runs, known to a third
    assert found == pytest.approx(runs.mean(), abs=3.0 * math.hypot(error, other) + 0.03 * runs.mean())


@pytest.mark.parametrize("tilt", [0, 10, 35])
def test_inverse_mass_at_the_corners_is_that_of_mujoco(tilt):
    """Without twist, which MuJoCo's tree of rigid bodies has no joint for."""
    plan = plan_of(tilt, effects={"off": ["leg_twist"]})
    W = mujoco_walker.compute_mobility(plan.case.design, plan.case.mass)
    # 1e-12: rounding of two factorisations
    np.testing.assert_allclose(mobility(plan.world.walker), W, rtol=0, atol=1e-12 * abs(W).max())


@pytest.mark.nightly
@pytest.mark.parametrize("feet", [{}, RIGID], ids=["hertz", "rigid"])
@pytest.mark.parametrize("tilt", [10, 15])
def test_feet_that_hardly_rebound_run_as_by_a_tenth_of_their_step(tilt, feet):
    """Undivided by the damping ratio, the step gave 11 mm/s for 20 at 10 deg on rigid tips."""
    plane = {"arena": {"kind": "plane"}, "feet": feet}
    found, error = mean_speed(tilt, 0.02, 4.0, **plane)
    expected, other = mean_speed(tilt, 0.02, 4.0, finer=10.0, **plane)
    # 3 % and 1 % of the plate's 31.2 mm/s: what is stated of the own step
    assert found == pytest.approx(expected, abs=3.0 * math.hypot(error, other) + 0.03 * expected + 0.31)
