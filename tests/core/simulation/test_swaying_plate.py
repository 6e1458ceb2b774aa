"""Plates that move along themselves, shake unevenly or rock: friction, drift, places and energy by second ways."""

import math

import numpy as np
import pytest
from corner_rival import deepest_of

from walkergen.core.errors import InputError
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import drop_for_run
from walkergen.core.simulation.space.model import energy
from walkergen.core.simulation.space.pose import fill_points, update_pose
from walkergen.core.simulation.space.state import C_X, C_Z, PHASE, V_X, V_Y, V_Z, work_for
from walkergen.core.theory import stationary
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

PLANE = templates.load("plane-90hz", "scenes", Scene)
PAPER = templates.load("koumakis2016", "walkers", Design)
BOX = PAPER.variant(kind="braced", tilt_deg=0.0)
PERIOD, OMEGA = 1.0 / 90.0, 2.0 * math.pi * 90.0
ALL_MOTIONS = {
    "plate.horizontal_ratio": [0.5, 0.3],
    "plate.horizontal_phase_deg": [60.0, -100.0],
    "plate.gradient_percent_per_mm": [2.0 * math.cos(math.radians(30.0)), 1.0],
    "plate.rocking_percent_per_mm": [3.0 * math.cos(math.radians(130.0)), 3.0 * math.sin(math.radians(130.0))],
    "arena.length_mm": 40.0,
    "arena.width_mm": 40.0,
}


RIGID_FEET = {"feet.rigid_tips": True}
"""Feet of a block that slides as a rigid one."""


def make_plan(design, **keys):
    return prepare(PLANE.variant(**keys), design, solids.mass_of(design))


@pytest.mark.parametrize(("key", "axis", "sign"), [("along", V_X, 1.0), ("across", V_Z, -1.0)])
@pytest.mark.parametrize("phase", [0.0, 180.0])
def test_a_box_that_lands_is_pushed_as_the_plate_moves_by_friction_times_its_rebound(key, axis, sign, phase):
    """Coulomb: while it slides, what it gains along is friction times what it gains upward. Galileo: as much as one
    that is thrown against a plate that only moves up and down.
    """
    pairs = ([40.0, 0.0], [phase, 0.0]) if key == "along" else ([0.0, 40.0], [0.0, phase])
    keys = dict(zip(("plate.horizontal_ratio", "plate.horizontal_phase_deg"), pairs, strict=True))
    fastest = sign * math.cos(math.radians(phase)) * 40.0 * 0.2 * GRAVITY / OMEGA
    pushes = []
    for own, thrown in ((keys, 0.0), ({}, -fastest)):
        plan = make_plan(BOX, **RIGID_FEET | {"drive.gamma": 0.2, "contact.friction": 0.05}, **own)
        state = plan.initial_state(0.05, 0.0, 0.0)
        state[V_Y], state[axis] = -100.0, thrown
        plan.advance(state, 0.0012, record.new_tally(len(state)))
        assert abs(state[V_X + V_Z - axis]) < 1e-6
        pushes.append((state[axis] - thrown) / (state[V_Y] + 100.0 + GRAVITY * 0.0012))
    # a corner's tangential spring is stretched first: 4 % less; the plate turns over while they touch: 0.2 %
    assert pushes[0] == pytest.approx(math.copysign(0.05, fastest), rel=0.05)
    assert pushes[0] == pytest.approx(pushes[1], rel=0.003)


def sliding(gamma, ratio, phase, friction, periods):
    """Mean velocity (mm/s) of a block that never leaves a plate, by small steps: the independent program."""
    steps, speed, way = 20_000, 0.0, 0.0
    dt = PERIOD / steps
    for i in range(periods * steps):
        phi = OMEGA * (i + 0.5) * dt
        press = friction * GRAVITY * (1.0 - gamma * math.sin(phi))
        plate = ratio * gamma * GRAVITY / OMEGA * math.cos(phi + phase)
        slip = speed - plate
        change = -math.copysign(min(press * dt, abs(slip)), slip)
        speed += change
        if i >= steps * (periods // 2):
            way += speed * dt
    return way / (PERIOD * (periods - periods // 2))


@pytest.mark.parametrize("phase", [0.0, 90.0, 180.0, 225.0])
def test_a_block_drifts_as_on_a_vibrating_conveyor(phase):
    """Motion along and up with a lag between them conveys what slides: its sense turns over with the phase."""
    gamma, ratio, friction = 0.6, 1.5, 0.25
    plan = make_plan(
        BOX,
        **RIGID_FEET
        | {
            "drive.gamma": gamma,
            "plate.horizontal_ratio": [ratio, 0.0],
            "plate.horizontal_phase_deg": [phase, 0.0],
            "contact.friction": friction,
        },
    )
    state = plan.initial_state(1e-4, 0.0, 0.0)
    plan.advance(state, 8 * PERIOD, record.new_tally(len(state)))
    start = state[C_X]
    plan.advance(state, 8 * PERIOD, record.new_tally(len(state)))
    expected = sliding(gamma, ratio, math.radians(phase), friction, 16)
    largest = ratio * gamma * GRAVITY / OMEGA
    assert (state[C_X] - start) / (8 * PERIOD) == pytest.approx(expected, abs=0.02 * largest)


def test_a_block_rides_along_until_friction_gives_way():
    ways = []
    for ratio in (0.4, 0.6):  # peak accelerations of 0.2 and 0.3 g along, friction holds 0.25 g less a half
        shaken = {"drive.gamma": 0.05, "plate.horizontal_ratio": [10 * ratio, 0.0], "contact.friction": 0.25}
        plan = make_plan(BOX, **RIGID_FEET | shaken)
        state = plan.initial_state(1e-4, 0.0, 0.0)
        plan.advance(state, 4 * PERIOD, record.new_tally(len(state)))
        size = 10.0 * ratio * plan.world.drive.amplitude
        slips = []
        for _ in range(20):
            plan.advance(state, PERIOD / 20, record.new_tally(len(state)))
            slips.append(state[V_X] - size * OMEGA * math.cos(state[PHASE]))
        ways.append(np.abs(slips).max() / (size * OMEGA))
    assert ways[0] < 0.02
    assert ways[1] > 0.1


@pytest.mark.parametrize("key", ["gradient", "rocking"])
@pytest.mark.parametrize("toward", [0.0, 90.0])
def test_far_from_the_start_it_is_a_plate_of_another_amplitude_and_phase(key, toward):
    """There 1 + g r, or 1 and k r a quarter of a period ahead: one sine again."""
    change, far = 0.3, 1e6
    percent = 100.0 * change / far
    keys = {f"plate.{key}_percent_per_mm": [percent, 0.0] if toward == 0.0 else [0.0, percent]}
    size, ahead = (1.0 + change, 0.0) if key == "gradient" else (math.hypot(1.0, change), math.atan(change))
    ends = []
    for gamma, phase, own in ((1.8, 0.3, keys), (1.8 * size, 0.3 + ahead, {})):
        plan = make_plan(PAPER, **{"drive.gamma": gamma, "run.step_us": 0.2, **own})
        state = plan.initial_state(0.05, 1e-3, phase, 2e-3)
        shift = far * np.array([math.cos(math.radians(toward)), -math.sin(math.radians(toward))])
        if own:
            state[[C_X, C_Z]] += shift
            rise = plan.world.drive.amplitude * change
            state[C_X + 1] += rise * (math.sin(phase) if key == "gradient" else math.cos(phase))
        plan.advance(state, 0.01, record.new_tally(len(state)))
        if own:
            state[[C_X, C_Z]] -= shift
        ends.append(state[[C_X, C_X + 1, C_Z]])
    # what steps err by, of 0.02 mm that the gradient moves the walker: they do not begin at the same times
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=5e-6)


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"arena.lid_mm": 10.7, "drive.gamma": 3.0},
        {"plate.roughness_um": 5.0, "plate.noise_ratio": 0.2},
        {"arena.kind": "lane", "arena.width_mm": None, "arena.gap_mm": 8.1},
        {"feet.rigid_tips": True},
    ],
    ids=["plane", "lid", "rough", "walls", "rigid tips"],
)
def test_energy_is_booked_and_no_corner_sinks_in(keys):
    plan, state = drop_for_run(make_plan(PAPER, **ALL_MOTIONS | keys), 0)
    walker, tally = plan.world.walker, record.new_tally(len(state))
    before, deepest = energy(plan.world, state), 0.0
    state[[C_X]] += 8.0
    for _ in range(100):
        plan.advance(state, 1e-3, tally)
        work = work_for(walker, state)
        update_pose(plan.world, state.copy(), work)
        fill_points(plan.world, state.copy(), work)
        deepest = min(deepest, float(work.points["gap"].min()))
    # all of a walker at 0.2 m/s on one corner, on a plate at 4 g
    assert -deepest < deepest_of(walker, 0, 5.0 * 9806.65 * walker.mass, 200.0)
    taken = sum(tally.sums[k] for k in (record.IMPACT_LOSS, record.FRICTION_LOSS, record.DAMPING_LOSS))
    given = tally.sums[record.PLATE_WORK]
    assert energy(plan.world, state) - before == pytest.approx(given - taken, abs=0.01 * (abs(given) + taken))


def test_the_mirror_image_runs_the_mirrored_way():
    """x -> -x, with all that points along x."""
    ends = []
    for sign, design in ((1.0, PAPER), (-1.0, PAPER.variant(tilt_deg=-PAPER.tilt_deg))):
        turned = {"plate.gradient_percent_per_mm": [sign * 2.0, 0.0]}
        turned |= {"plate.rocking_percent_per_mm": [sign * 3.0, 0.0]}
        turned |= {"plate.horizontal_phase_deg": [60.0 if sign > 0.0 else 240.0, -100.0]}
        plan = make_plan(design, **ALL_MOTIONS | turned)
        state = plan.initial_state(0.05, sign * 1e-3, 0.3)
        plan.advance(state, 0.006, record.new_tally(len(state)))
        ends.append(state[[C_X, C_X + 1, C_Z, V_X, V_Y, V_Z]] * (sign, 1.0, 1.0, sign, 1.0, 1.0))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-7)


def test_switched_off_it_is_as_if_it_were_not_there():
    off = {"effects.off": ["plate_along", "plate_gradient", "plate_rocking"]}
    ends = []
    for keys in (ALL_MOTIONS | off, {}):
        plan, state = drop_for_run(make_plan(PAPER, **keys), 0)
        plan.advance(state, 0.05, record.new_tally(len(state)))
        ends.append(state)
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        (
            {"plate.gradient_percent_per_mm": [0.5, 0.0], "run.seconds": 60.0},
            "a walker may get .* far.*arena.length_mm",
        ),
        (
            {"plate.rocking_percent_per_mm": [-5.0, 0.0], "arena.length_mm": 60.0, "arena.width_mm": 60.0},
            "by 212 %. At most 100 %",
        ),
    ],
)
def test_impossible_scenes_are_refused_in_one_line(keys, words):
    with pytest.raises(InputError, match=words) as caught:
        make_plan(PAPER, **keys)
    assert "\n" not in str(caught.value)


def test_a_motor_and_a_crowd_refuse_a_swaying_plate():
    from walkergen.guests.crowd.space import run as crowds

    swayed = {"plate.horizontal_ratio": [0.0, 0.1]}
    coinbot = templates.load("coinbot", "walkers", Design)
    scene = templates.load("table-motor", "scenes", Scene).variant(**swayed)
    with pytest.raises(InputError, match=r"plate.horizontal_ratio = \[0, 0.1\]: the plate under a motor is still"):
        prepare(scene, coinbot, solids.mass_of(coinbot))
    with pytest.raises(InputError, match=r"plate.horizontal_ratio = \[0, 0.1\]: a crowd needs a plate"):
        crowds.plane_scene(PLANE.variant(**swayed))


def test_a_plate_that_throws_nothing_up_may_still_convey():
    scene = PLANE.variant(**{"drive.gamma": 0.5})
    mass = solids.mass_of(PAPER)
    assert stationary.standing_reason(scene, PAPER, mass)
    assert not stationary.standing_reason(scene.variant(**{"plate.horizontal_ratio": [1.0, 0.0]}), PAPER, mass)
