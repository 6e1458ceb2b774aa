"""Motor: closed forms, a real mass on a hinge, energy, mirror images, and what it must refuse."""

import math

import numpy as np
import pytest
from motor_rival import carrying, concentrate_rotor, fly, fly_there, speeds_there, throwing
from space_rival import weightless

from walkergen.core.drive import Drive
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import motor
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.effects.motor import spin
from walkergen.core.simulation.effects.resolve import resolve
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import simulate
from walkergen.core.simulation.space.model import mirror_state
from walkergen.core.simulation.space.pose import update_pose
from walkergen.core.simulation.space.state import (
    HEADING,
    HEIGHT,
    LEGS,
    PHASE,
    Q_X,
    Q_Z,
    SHOWN_X,
    SHOWN_Y,
    W_X,
    W_Z,
    work_for,
)
from walkergen.core.simulation.world import OK
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import speed_prediction as speeds

OFF_CENTRE = {"along_mm": 5.0, "up_mm": 3.0, "across_mm": 2.0}
"""Place of a motor off the centre of mass."""

SHORT_RUN = {"run": {"seconds": 0.5, "discard_seconds": 0.25, "runs": 1}}


def centred_motor_plan(axis):
    """Plan of a braced, weightless walker whose motor sits in its centre of mass."""
    keys = {"eccentric_g_mm": 0.05, "axis": axis}
    plan = carrying(keys, kind="braced")
    x, y, z = -plan.world.walker.centre  # C from O at half depth
    moved = {"along_mm": x, "up_mm": y, "across_mm": z}
    shifted = carrying(keys, moved, kind="braced")
    x, y, z = np.array([x, y, z]) - shifted.world.acting.motor.position  # O from the body's middle
    moved = {"along_mm": moved["along_mm"] + x, "up_mm": moved["up_mm"] + y, "across_mm": moved["across_mm"] + z}
    plan = weightless(carrying(keys, moved, kind="braced"))
    acting = plan.world.acting
    centre = tuple((-plan.world.walker.centre).tolist())
    return plan._replace(
        world=plan.world._replace(acting=acting._replace(motor=acting.motor._replace(position=centre)))
    )


@pytest.mark.parametrize("axis", ["along", "across", "up", [0.3, 0.5, 0.8]])
def test_a_free_walker_draws_a_circle_of_the_moment_over_the_mass(axis):
    plan = centred_motor_plan(axis)
    rotor, mass = plan.world.acting.motor, plan.world.walker.mass
    state, places = plan.initial_state(500.0, 0.0, 0.3), []
    for _ in range(16):
        assert plan.advance(state, 2.0 * math.pi / rotor.omega / 16.0, record.new_tally()) == OK
        places.append([state[SHOWN_X], state[HEIGHT], -state[SHOWN_Y]])
    from_middle = np.array(places) - np.mean(places, axis=0)
    # Exact but for rounding of heights of 500 mm
    np.testing.assert_allclose(np.linalg.norm(from_middle, axis=1), rotor.moment / mass, rtol=1e-9)
    normal = np.cross(rotor.first, rotor.second)
    np.testing.assert_allclose(from_middle @ normal, 0.0, atol=1e-11)
    np.testing.assert_allclose(state[W_X : W_Z + 1], 0.0, atol=1e-12)


def test_a_motor_off_the_centre_turns_the_body_by_angular_momentum():
    """Exact in the plane: (J - S^2/M + 2 S p.e) w + S Omega p.e is kept; both p, e from C."""
    plan = weightless(carrying({"eccentric_g_mm": 0.02}, {"along_mm": 5.0}, kind="braced"))
    walker, rotor = plan.world.walker, plan.world.acting.motor
    p, J = np.array(rotor.position) + walker.centre, walker.inertia[2, 2]
    S, omega = rotor.moment, -rotor.omega  # about z: its top moves forward
    small = 2.0 * S * np.linalg.norm(p) / J
    for phase in (0.0, 0.7, 2.0, 4.0):
        state = fly(plan, 0.013, phase)
        reach = p @ (math.cos(state[PHASE]) * np.array(rotor.first) + math.sin(state[PHASE]) * np.array(rotor.second))
        start = p @ (math.cos(phase) * np.array(rotor.first) + math.sin(phase) * np.array(rotor.second))
        begun = -S * omega * start / J
        kept = (J - S**2 / walker.mass + 2.0 * S * start) * begun + S * omega * start
        exact = (kept - S * omega * reach) / (J - S**2 / walker.mass + 2.0 * S * reach)
        # What is left out is a share of 2 S |p|/J, 0.4 %, of the largest rate
        largest = abs(S * omega) * np.linalg.norm(p) / J
        assert state[W_Z] == pytest.approx(exact, abs=2.0 * small * largest)
        assert abs(state[W_Z]) > 0.02 * largest


@pytest.mark.parametrize("axis", ["across", "along", "up", [0.3, 0.5, 0.8]])
def test_in_flight_it_moves_as_a_real_mass_on_a_hinge(axis):
    """MuJoCo turns a mass of 5 mg at 1 mm; legs swing, and the rotor's spin tilts the body."""
    free = {"effects": {"off": ["leg_twist"]}}
    keys = {"eccentric_g_mm": 0.005, "axis": axis}
    plan, _ = concentrate_rotor(weightless(carrying(keys, OFF_CENTRE, **free)), 1.0)
    walker, rotor = plan.world.walker, plan.world.acting.motor
    seconds, phase = 2.25 * 2.0 * math.pi / rotor.omega, 0.3
    ours = fly(plan, seconds, phase)
    theirs, legs = fly_there(plan, 1.0, seconds, phase)
    begun = plan.initial_state(500.0, 0.0, phase)
    at = np.array([ours[SHOWN_X], ours[HEIGHT], -ours[SHOWN_Y]])
    from_start = np.array([begun[SHOWN_X], begun[HEIGHT], -begun[SHOWN_Y]])
    moved = np.linalg.norm(theirs[:3] - from_start)
    # 2 S |p|/J = 0.1 % of the motion is what the model leaves out, summed over some periods
    arm = np.linalg.norm(np.array(rotor.position) + walker.centre)
    share = 2.0 * rotor.moment * arm / np.linalg.eigvalsh(walker.inertia)[0]
    assert moved > 1e-3
    np.testing.assert_allclose(at, theirs[:3], rtol=0, atol=10.0 * share * rotor.moment / walker.mass)
    turned = np.linalg.norm(theirs[4:7])
    np.testing.assert_allclose(ours[Q_X : Q_Z + 1], theirs[4:7], rtol=0, atol=5.0 * share * turned)
    np.testing.assert_allclose(ours[LEGS : LEGS + 2], legs, rtol=0, atol=0.02 * abs(legs).max())


def test_spinning_it_keeps_the_angular_momentum_of_body_and_rotor():
    keys = {"eccentric_g_mm": 0.05, "axis": [0.3, 0.5, 0.8]}
    # What is left of 1e-9 at this step grows with its fourth power; feet that touch nothing would allow 56 us
    plan = weightless(carrying(keys, OFF_CENTRE, run={"step_us": 2.7}))
    walker, rotor = plan.world.walker, plan.world.acting.motor
    state = plan.initial_state(500.0, 0.0, 0.3)
    state[W_X : W_Z + 1] += 2.0, -3.0, 5.0
    kept = []
    for _ in range(6):
        work = work_for(walker, state)
        update_pose(plan.world, state, work)
        own = walker.inertia @ state[W_X : W_Z + 1]
        kept.append(work.R @ (own + spin(rotor, walker.centre, walker.mass, work.thrown)))
        assert plan.advance(state, 0.05, record.new_tally()) == OK
    assert np.linalg.norm(rotor.spin) > 0.1 * np.linalg.norm(kept[0])
    # To rounding: the top keeps it exactly
    np.testing.assert_allclose(kept, np.tile(kept[0], (6, 1)), atol=1e-9 * np.linalg.norm(kept[0]))


@pytest.mark.parametrize(("share", "stays"), [(0.97, True), (1.2, False)])
def test_below_the_weight_it_stays_down_and_beyond_it_leaves(share, stays):
    """Without friction, which else would tilt it, and with legs too stiff to bounce on."""
    plan = carrying(
        throwing(share),
        kind="braced",
        contact={"friction": 0.0, "restitution": 0.3},
        run={"seconds": 1.0, "discard_seconds": 0.5, "runs": 1},
    )
    result = simulate(plan, 0)
    in_contact = result.tally.sums[record.CONTACT_TIME] / result.measured_s
    assert (in_contact == pytest.approx(1.0, abs=1e-6)) == stays
    if not stays:
        assert in_contact < 0.99


def test_of_a_symmetric_walker_the_sense_of_rotation_is_the_direction():
    """Exactly: the mirror image, with a rotor that turns the other way, runs the other way."""
    ends = []
    for turned in (False, True):
        plan = carrying(throwing(1.8, axis=[0.0, 1.0, 0.0] if turned else "across"), tilt=0.0)
        state = plan.initial_state(0.05, 0.002, 0.3, 0.001)
        if turned:
            state = mirror_state(plan.world.walker, ends[0][0])
            state[PHASE] = 0.3
        first = state.copy()
        assert plan.advance(state, 0.05, record.new_tally()) == OK
        ends.append((first, state))
    # 50 ms hold some ten landings, over which rounding grows
    assert ends[0][1][SHOWN_X] == pytest.approx(-ends[1][1][SHOWN_X], abs=1e-6)
    assert abs(ends[0][1][SHOWN_X] - ends[0][0][SHOWN_X]) > 0.05


@pytest.mark.slow
def test_without_tilt_it_runs_against_the_rotors_top_and_back_with_the_other_sense():
    speeds = []
    for turned in (False, True):
        plan = carrying(
            throwing(1.8, axis=[0.0, 1.0, 0.0] if turned else "across"),
            tilt=0.0,
            run={"seconds": 2.0, "discard_seconds": 0.5, "runs": 1},
        )
        speeds.append(np.array([simulate(plan, number).speed for number in range(4)]))
    ahead, back = (one.mean() for one in speeds)
    error = math.hypot(*(one.std(ddof=1) / 2.0 for one in speeds))
    assert ahead < -3.0
    assert ahead == pytest.approx(-back, abs=4.0 * error + 0.02 * abs(ahead))


@pytest.mark.parametrize("axis", ["across", "along", "up"])
@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_the_work_of_the_motor_equals_the_losses_of_feet_friction_and_dampers(axis, kind):
    """Feet that rebound with 0.1: livelier ones topple at 3 g along."""
    plan = carrying(throwing(3.0, axis=axis), OFF_CENTRE, kind=kind, contact={"restitution": 0.1}, **SHORT_RUN)
    # A sixteenth of the own step: frames, which are as much shorter, err in their first order on a motor
    result = simulate(plan.coarser(1 / 16), 0)
    assert result.tally.sums[record.PLATE_WORK] > 10.0
    # 2.0e-3 is the largest of 24 runs
    assert result.energy_error < 4e-3


def test_the_plate_under_a_motor_is_still_and_blocks_are_periods_of_the_motor():
    plan = carrying(throwing(1.8, 180.0), **SHORT_RUN)
    assert plan.world.drive.amplitude == 0.0
    assert plan.world.drive.period == pytest.approx(1.0 / 180.0)
    assert plan.equivalent_drive.peak_gamma == pytest.approx(1.8)
    result = simulate(plan, 0)
    assert result.block_s == pytest.approx(4.0 / 180.0, rel=0.05)


def test_a_motor_keeps_its_moment_at_another_frequency():
    scene = Scene(drive=Drive(kind="motor", frequency_hz=180.0, eccentric_g_mm=0.7)).variant(
        **{"drive.frequency_hz": 150.0}
    )
    assert scene.drive.eccentric_moment == 0.7


def test_a_scene_changes_between_plate_and_motor_by_its_kind():
    motors = Scene().variant(**{"drive.kind": "motor", "drive.eccentric_g_mm": 0.5})
    assert (motors.drive.frequency, motors.drive.gamma) == (90.0, None)
    plates = motors.variant(**{"drive.kind": "plate", "drive.gamma": 2.0})
    assert (plates.drive.frequency, plates.drive.eccentric_g_mm) == (90.0, None)
    with pytest.raises(InputError, match="plate"):
        motors.drive.peak_speed  # noqa: B018  (it is no plate's)


MOTOR = {"kind": "motor", "frequency_hz": 180.0, "eccentric_g_mm": 0.9}


def test_walkers_and_moments_without_a_motor_are_refused_by_name():
    case = carrying(MOTOR | {"eccentric_g_mm": 0.01}).case
    with pytest.raises(InputError, match="has no motor"):
        resolve(Case(case.scene, Design(), solids.mass_of(Design())))
    for moment, told in ((1e3, "its length"), (5.0, "times the walker's weight")):
        with pytest.raises(InputError, match=told):
            resolve(case._replace(scene=case.scene.variant(**{"drive.eccentric_g_mm": moment})))


def test_the_gyroscopic_torque_is_judged_by_the_rotor_and_can_be_forced():
    case = carrying(MOTOR | {"eccentric_g_mm": 0.01}).case
    for wanted, on in ((None, True), (False, False), (True, True)):
        effects = case.scene.effects.force("gyroscopic_torque", wanted)
        resolved = resolve(case._replace(scene=case.scene.model_copy(update={"effects": effects})))
        assert resolved.is_on(motor.GYROSCOPIC) == on
        assert any(resolved.acting.motor.spin) == on


PLASTIC = {
    "contact": {"restitution": 0.02, "friction": 0.25},
    "feet": {"rigid_tips": True},
    "effects": {"off": ["leg_twist"]},
}
"""Nearly plastic feet, as those of MuJoCo, whose tree of rigid bodies has no twist."""


@pytest.mark.parametrize(
    ("tilt", "push", "turned", "share"),
    [
        pytest.param(0.0, 1.8, False, 0.05, marks=pytest.mark.nightly),
        pytest.param(10.0, 3.0, True, 0.2, marks=pytest.mark.nightly),
    ],
)
def test_on_the_plate_it_runs_as_with_a_real_mass_on_a_hinge(tilt, push, turned, share):
    """Nearly plastic feet; -15.5 for MuJoCo's -15.5 +- 0.1, and 48.9 for 44.9 +- 1.1 mm/s."""
    drive = throwing(push, axis=[0.0, 1.0, 0.0] if turned else "across")
    run = {"seconds": 2.0, "discard_seconds": 0.5, "runs": 4}
    plan = carrying(drive, tilt=tilt, run=run, **PLASTIC)
    ours = np.array([simulate(plan, number).speed for number in range(4)])
    theirs = speeds_there(plan, 1.0, 1.5, range(3))
    error = math.hypot(ours.std(ddof=1) / 2.0, theirs.std(ddof=1) / math.sqrt(3.0))
    # Friction at the end of a step, and what plastic feet give back, change speeds by 5 to 30 %
    # (test_space_rivals.py); upright legs, which do not slide as they land, hardly
    near = 3.0 * error + share * abs(theirs.mean())
    assert ours.mean() == pytest.approx(theirs.mean(), abs=near)


def test_a_weak_motor_comes_with_its_uncertain_inputs():
    plan = carrying(throwing(1.8))
    assert plan.scene.drive.push_ratio(plan.case.mass.total) == pytest.approx(1.8)
    assert "pushes with 1.8 weights" in speeds._push_warning(1.8)
    assert speeds._push_warning(3.5) == ""


def test_held_in_its_plane_a_walker_does_not_move_across():
    held = {"effects": {"off": ["roll_and_yaw"]}, "run": SHORT_RUN["run"]}
    for axis in ("along", [0.3, 0.5, 0.8]):
        plan = carrying(throwing(1.8, axis=axis), OFF_CENTRE, **held)
        result = simulate(plan, 0)
        np.testing.assert_array_equal(result.places[:, 1:], 0.0)
        assert result.energy_error < 1e-2


def test_a_motor_at_the_other_side_circles_the_other_way():
    """The template's comment: 1.8 rad/s to the left."""
    spinner, scene = templates.load("spinner", "walkers", Design), templates.load("table-motor", "scenes", Scene)
    image = spinner.variant(**{"motor.across_mm": -spinner.motor.across_mm})
    scene = scene.variant(**{"run.seconds": 0.8, "run.discard_seconds": 0.2, "run.runs": 3})
    rates = []
    for design in (spinner, image):
        plan = prepare(scene, design, solids.mass_of(design))
        for number in range(3):
            result = simulate(plan, number, sample_interval=0.02, sample_size=HEADING + 1)
            samples = result.tally.samples
            times, *_, heading = samples.rows[: samples.cursor[0]].T
            rates.append((heading[-1] - heading[0]) / (times[-1] - times[0]))
    left, right = np.reshape(rates, (2, 3))
    assert left.mean() > 0.5
    assert right.mean() < -0.5
