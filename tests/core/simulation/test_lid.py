"""A lid over the walker: it rebounds as a plate does, touches nothing that it does not reach, and books its energy."""

import math

import mujoco
import numpy as np
import pytest
from corner_rival import deepest_of
from flat_cards import card

from walkergen.commands.export import mjcf
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import feet
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import drop_for_run, simulate
from walkergen.core.simulation.space.model import energy, mirror_state
from walkergen.core.simulation.space.points import mirror_order
from walkergen.core.simulation.space.pose import fill_points, update_pose
from walkergen.core.simulation.space.state import J_N, ROW_LENGTH, TRAJECTORY_COLUMNS, V_Y, W_X, first_row, work_for
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.crowd import in_plane
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.space import run as crowds
from walkergen.points import trajectory

PLANE = templates.load("plane-90hz", "scenes", Scene)
STILL = {"drive": {"frequency_hz": 90.0, "gamma": 1e-4}}
PAPER, DISC = (templates.load(name, "walkers", Design) for name in ("koumakis2016", "polar-disc"))
WALKERS = {"flexible": PAPER, "braced": PAPER.variant(kind="braced", tilt_deg=0.0), "disc": DISC}


def plan_under_lid(design, lid_mm, scene=PLANE, **keys):
    return prepare(scene.variant(**{"arena.lid_mm": lid_mm, **keys}), design, solids.mass_of(design))


def height_of(plan):
    """Height of a level walker, mm."""
    return 0.5 * plan.case.design.size.thickness - min(limb.foot_height for limb in plan.case.design.limbs)


@pytest.mark.parametrize("label", [0.1, 0.5, 1.0])
def test_a_rigid_body_rebounds_by_the_closed_form_of_its_four_corners(label):
    keys = {"arena.wall_restitution": label, "run.step_us": 5.0}
    plan = plan_under_lid(WALKERS["braced"], 15.0, Scene.model_validate(STILL), **keys)
    walker = plan.world.walker
    lid = walker.wall_distance < 0.0
    damper = math.sqrt((walker.damper[lid] ** 2).sum())  # equal ones side by side: c adds up, its stiffness too
    assert lid.sum() == 4
    state, tally = plan.initial_state(1.0, 0.0, 0.0), record.new_tally(len(plan.initial_state(1.0, 0.0, 0.0)))
    state[V_Y], room = 500.0, 14.0 - height_of(plan)
    plan.advance(state, 0.012, tally)
    approach = math.sqrt(500.0**2 - 2.0 * 9806.65 * room)
    expected = feet.restitution(damper / (2.0 * math.sqrt(walker.mass)))
    lost = tally.sums[record.IMPACT_LOSS]
    # 1 %: gravity in the time that the contact takes, and what a step errs by of so fast a landing
    assert lost == pytest.approx(
        0.5 * walker.mass * approach**2 * (1.0 - expected**2), rel=0.01, abs=1e-3 * walker.mass * approach**2
    )
    assert state[V_Y] < 0.0
    assert np.abs(state[W_X : W_X + 3]).max() < 1e-6  # all corners together: it does not turn


@pytest.mark.parametrize("name", WALKERS)
def test_under_a_lid_energy_is_booked_and_no_corner_is_far_beyond_it(name):
    room = 0.3
    lid_mm = height_of(plan_under_lid(WALKERS[name], None)) + room
    plan, state = drop_for_run(plan_under_lid(WALKERS[name], lid_mm, **{"drive.gamma": 4.0}), 0)
    walker, tally = plan.world.walker, record.new_tally(len(state))
    before, deepest, pressed = energy(plan.world, state), 0.0, False
    lid = np.flatnonzero(walker.wall_distance < 0.0)
    for _ in range(100):
        plan.advance(state, 1e-3, tally)
        work = work_for(walker, state)
        update_pose(plan.world, state.copy(), work)
        fill_points(plan.world, state.copy(), work)
        deepest = min(deepest, float(work.points["gap"][lid].min()))
        pressed |= bool((state[first_row(walker) + ROW_LENGTH * lid + J_N] > 0.0).any())
    assert pressed
    # all of a walker at 0.2 m/s on one corner, on a plate at 4 g
    assert -deepest < deepest_of(walker, int(lid[0]), 5.0 * 9806.65 * walker.mass, 200.0)
    taken = sum(tally.sums[k] for k in (record.IMPACT_LOSS, record.FRICTION_LOSS, record.DAMPING_LOSS))
    given = tally.sums[record.PLATE_WORK]
    assert energy(plan.world, state) - before == pytest.approx(given - taken, abs=0.01 * (abs(given) + taken))


def test_a_lid_that_nothing_reaches_changes_no_bit():
    def mean_speed(lid_mm, gamma):
        return simulate(
            plan_under_lid(PAPER, lid_mm, **{"run.seconds": 0.3, "run.discard_seconds": 0.1, "drive.gamma": gamma}), 0
        ).speed

    assert mean_speed(1000.0, 1.8) == mean_speed(None, 1.8)
    assert mean_speed(10.7, 3.0) != mean_speed(None, 3.0)


def crowd_under_lid(design, lid_mm, places, scene=PLANE, **keys):
    scene = scene.variant(**{"arena.lid_mm": lid_mm, "crowd.arena_mm": "disc:80", **keys})
    kinds = [0] * len(places)
    return crowds.prepare(scene, [(design, solids.mass_of(design))], kinds, places, endless=len(places) == 1)


def test_a_walker_alone_under_the_lid_of_a_crowd_is_the_one_that_simulate_runs():
    plan = plan_under_lid(DISC, height_of(plan_under_lid(DISC, None)) + 0.3, **{"drive.gamma": 4.0, "run.seconds": 0.2})
    centre = plan.world.walker.centre
    scene = plan.case.scene
    alone = crowd_under_lid(DISC, scene.arena.lid_mm, np.array([[centre[0], -centre[2], 0.0]]), scene)
    sampled = trajectory.sample_rows(simulate(plan, 3, sample_interval=0.01, sample_size=len(TRAJECTORY_COLUMNS)))
    assert np.array_equal(crowds.simulate(alone, 3, 100.0).poses[:, 0], sampled[:, 1:])


def test_discs_that_topple_in_the_open_stay_up_under_a_lid_and_push_each_other():
    """At 115 Hz and 6 g."""
    shaken = {"drive.frequency_hz": 115.0, "drive.gamma": 6.0, "run.seconds": 0.6, "run.discard_seconds": 0.2}
    places = np.array([(x, y, 0.7 * (x - y)) for x in (-22.0, 0.0, 22.0) for y in (-11.0, 11.0)])
    open_, closed = (
        crowds.simulate(crowd_under_lid(DISC, lid_mm, places, **shaken), 0, 50.0)
        for lid_mm in (None, height_of(plan_under_lid(DISC, None)) + 0.8)
    )
    assert set(closed.outcomes) == {"ok"}
    assert set(open_.outcomes) != {"ok"}
    assert closed.touches > 5
    assert closed.energy_error < 0.01


def test_a_card_accepts_only_its_own_lid():
    with pytest.raises(InputError, match=r"arena.lid_mm = 12: the card fixes the lid"):
        in_plane.make_population(CrowdRequest(), PLANE.variant(**{"arena.lid_mm": 12.0}), [card()], [2])


def mirror_image(design):
    """Mirror image of a design, x -> -x, legs listed the other way round."""
    legs = [
        leg.model_copy(update={"along_mm": -leg.along_mm, "tilt_deg": -leg.tilt_deg}) for leg in reversed(DISC.legs)
    ]
    return design.variant(legs=legs) if design is DISC else design.variant(tilt_deg=-design.tilt_deg)


@pytest.mark.parametrize("name", WALKERS)
def test_the_mirror_image_has_mirrored_points_and_runs_the_mirrored_way(name):
    ends = []
    for sign, design in ((1.0, WALKERS[name]), (-1.0, mirror_image(WALKERS[name]))):
        plan = plan_under_lid(design, height_of(plan_under_lid(design, None)) + 0.3, **{"drive.gamma": 4.0})
        state = plan.initial_state(0.05, sign * 1e-3, 0.3, 0.0)
        plan.advance(state, 0.003, record.new_tally(len(state)))
        ends.append((plan.world.walker, state))
    (walker, state), (image, other) = ends
    np.testing.assert_array_equal(walker.root[mirror_order(walker)] * (-1.0, 1.0, 1.0), image.root)
    # rounding, grown by landings: later the order of summation over many corners shows
    np.testing.assert_allclose(mirror_state(walker, state)[:9], other[:9], rtol=0, atol=1e-9)


def test_mujoco_has_the_same_lid(tmp_path):
    lid_mm = height_of(plan_under_lid(DISC, None)) + 0.3
    for name, data in mjcf.files(DISC, PLANE.variant(**{"arena.lid_mm": lid_mm})):
        (tmp_path / name).write_bytes(data)
    model = mujoco.MjModel.from_xml_path(str(next(tmp_path.glob("*.xml"))))
    data = mujoco.MjData(model)
    plan = plan_under_lid(DISC, lid_mm, **{"effects.off": ["leg_twist"]})
    walker = plan.world.walker
    lid = np.flatnonzero(walker.wall_distance < 0.0)
    depth, rise = 2e-4, 5.0
    data.qpos[3] += 0.3 - plan.equivalent_drive.amplitude + depth  # it begins an amplitude over the plate
    data.qvel[3] = rise
    mujoco.mj_forward(model, data)
    pressed = np.zeros((data.ncon, 6))
    for number in range(data.ncon):
        mujoco.mj_contactForce(model, data, number, pressed[number])
    assert data.ncon == len(lid)
    # MuJoCo's impedance is not quite 0, so that corners have a little mass: 16 of them, 0.2 %
    spring = mjcf.linear_springs(plan)[lid]
    expected = spring * -data.contact.dist + walker.damper[lid] * np.sqrt(spring) * rise
    assert -data.contact.dist == pytest.approx(depth, abs=5e-5)
    assert pressed[:, 0] == pytest.approx(expected, rel=3e-3)
