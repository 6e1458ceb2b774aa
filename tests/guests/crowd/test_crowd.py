"""Crowds in space: collisions against closed forms, balances, and the walker alone (docs/physics.md section 9). Slow:
kernels of crowds take minutes to compile; the collisions run uncompiled in test_uncompiled.py too.
"""

import math

import numpy as np
import pytest
from crowd_bodies import Pair

from walkergen.commands.selftest.scenes import STILL_DRIVE
from walkergen.core.scene import Scene
from walkergen.core.simulation import plan as plans
from walkergen.core.simulation.run import simulate
from walkergen.core.simulation.space.state import TRAJECTORY_COLUMNS, V_X, V_Z, W_X
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.crowd.space import bodies, run
from walkergen.points import trajectory

pytestmark = pytest.mark.slow


def head_on(restitution, friction=0.0, offset=0.0):
    """Two walkers nose to nose, half a millimetre apart, at 40 mm/s each, `offset` mm aside."""
    return Pair(
        [(-14.25, 0.0, 0.0), (14.25, offset, math.pi)],
        [(40.0, 0.0), (-40.0, 0.0)],
        restitution=restitution,
        friction=friction,
    )


@pytest.mark.parametrize("restitution", [0.1, 0.5, 1.0])
def test_head_on_walkers_part_with_the_restitution(restitution):
    """3 %: their noses meet 0.4 mm over C, so that both pitch a little."""
    pair = head_on(restitution)
    before, energy = pair.momentum(), pair.energy()
    pair.advance(0.02)
    speeds = [state[V_X] for _, state in pair.walkers]
    assert speeds == pytest.approx([-40.0 * restitution, 40.0 * restitution], abs=1.2)
    assert pair.momentum() == pytest.approx(before, abs=1e-9)
    assert energy - pair.energy() == pytest.approx(pair.energy_loss(), abs=1e-9 * energy)


@pytest.mark.parametrize("restitution", [0.3, 1.0])
def test_a_corner_against_a_face_turns_both_as_a_rigid_impact_does(restitution):
    """Without friction J = (1 + e) u / (K_1 + K_2), with the inverse masses K at the contact.

    4 %: two ends of an upright edge touch, 0.4 mm over C at their mean.
    """
    heading, along = math.pi / 2 - 0.4, 7.0
    # the corner (x, z) that lies farthest toward +z, of a walker whose heading is -z turned
    corners = np.array([(14.0 * a, 4.0 * b) for a in (-1, 1) for b in (-1, 1)])
    x, z = corners.T
    h_c, h_s = math.cos(heading), math.sin(heading)
    seen = np.column_stack([h_c * x + h_s * z, h_c * z - h_s * x])
    corner = seen[np.argmax(seen[:, 1])]
    middle = np.array([along, -5.0]) - corner
    pair = Pair(
        [(0.0, 0.0, 0.0), (*middle, heading)], [(0.0, -60.0), (0.0, 0.0)], restitution=restitution, friction=0.0
    )
    before, energy = pair.momentum(), pair.energy()
    book = pair.advance(0.03)
    assert book[bodies.TOUCHES] == 1
    mass, spin = pair.walker.mass, pair.walker.inverse_inertia[1, 1]
    arms = along - pair.walker.centre[0], corner[0]
    mobility = sum(1.0 / mass + spin * arm * arm for arm in arms)
    impulse = (1.0 + restitution) * 60.0 / mobility
    (_, one), (_, two) = pair.walkers
    assert one[V_Z] == pytest.approx(-60.0 + impulse / mass, abs=2.4)
    assert two[V_Z] == pytest.approx(-impulse / mass, abs=2.4)
    # Of 400 g mm^2/s: a tick is shorter than a step, and in such a one a body turns by second order
    assert pair.momentum() == pytest.approx(before, abs=1e-4)
    assert energy - pair.energy() == pytest.approx(pair.energy_loss(), abs=1e-7 * energy)


@pytest.mark.parametrize("restitution", [0.02, 0.5])
def test_energies_of_a_meeting_askew_are_those_that_its_walkers_lost(restitution):
    """Askew, and near restitution 0 so that they hold on to each other: as they meet, and later."""
    pair = Pair(
        [(-14.1, 3.0, 0.0), (14.6, 0.0, math.pi - 0.2)],
        [(40.0, 0.0), (-40.0, 15.0)],
        restitution=restitution,
        friction=0.3,
    )
    energy = pair.energy()
    for _ in range(4):
        book = pair.advance(0.004)
        assert energy - pair.energy() == pytest.approx(pair.energy_loss(), rel=1e-9)
    assert book[bodies.TOUCHES] > 0


def test_friction_of_a_glancing_blow_is_at_most_its_coefficient():
    """Noses that meet while they slide past each other: the change along the face is mu times that
    across it where they go on sliding.
    """
    for friction in (0.05, 0.1):
        pair = Pair(
            [(-14.25, 0.0, 0.0), (14.25, 0.0, math.pi)],
            [(30.0, 0.0), (-30.0, 200.0)],
            restitution=0.5,
            friction=friction,
        )
        book = pair.advance(0.012)
        (_, one), _ = pair.walkers
        gained = one[V_X] - 30.0, one[V_Z]
        assert abs(gained[1]) == pytest.approx(friction * abs(gained[0]), rel=0.02)
        assert math.hypot(book[bodies.ALONG], book[bodies.UP]) == pytest.approx(
            friction * book[bodies.PRESSED], rel=0.01
        )
        assert book[bodies.UP] < 0.2 * book[bodies.ALONG]


def test_rough_noses_stop_sliding():
    """Friction without limit: what slips along the faces stops, up to the ticks."""
    pair = Pair(
        [(-14.25, 0.0, 0.0), (14.25, 0.0, math.pi)], [(30.0, 0.0), (-30.0, 4.0)], restitution=0.5, friction=10.0
    )
    pair.advance(0.012)
    (_, one), (_, two) = pair.walkers
    along = [state[V_Z] + s * 14.0 * state[W_X + 1] for (_, state), s in zip(pair.walkers, (-1.0, 1.0), strict=True)]
    assert abs(along[0] - along[1]) < 0.4
    assert one[V_X] < 0.0 < two[V_X]


def scene_of(seconds, **keys):
    """The template plane-90hz for so many seconds."""
    scene = templates.load("plane-90hz", "scenes", Scene)
    return scene.variant(**{"run.seconds": seconds, "run.discard_seconds": 0.2} | keys)


def lattice(count, pitch, rng):
    """Places of walkers on a square lattice, turned at random."""
    side = math.ceil(math.sqrt(count))
    at = pitch * (np.arange(side) - 0.5 * (side - 1))
    x, y = np.meshgrid(at, at)
    places = np.column_stack([x.ravel(), y.ravel()])[:count]
    return np.column_stack([places, rng.uniform(0.0, 2.0 * math.pi, count)])


def walkers(name):
    """A template's design and masses."""
    design = templates.load(name, "walkers", Design)
    return design, solids.mass_of(design)


def test_a_walker_alone_is_the_walker_that_simulate_runs():
    """To the bit, on a plane without walls."""
    scene, own = scene_of(1.0), walkers("koumakis2016")
    plan = plans.prepare(run.plane_scene(scene), *own)
    centre = plan.world.walker.centre
    at = np.array([[centre[0], -centre[2], 0.0]])  # with its C where simulate lets it go
    crowd = run.simulate(run.prepare(scene, [own], [0], at, endless=True), 3, 100.0)
    rows = trajectory.sample_rows(simulate(plan, 3, sample_interval=0.01, sample_size=len(TRAJECTORY_COLUMNS)))
    assert np.array_equal(crowd.times, rows[:, 0])
    assert np.array_equal(crowd.poses[:, 0], rows[:, 1:])


@pytest.mark.parametrize("arena", ["disc:90", "ring:120,40", "rectangle:100x90", "periodic:90"])
def test_no_crowd_overlaps_or_leaves_its_dish_and_its_energy_balances(arena):
    """Two kinds in every dish: gives below what the fastest point explains, energies to 1 %,
    restitution's share of what contacts take to 15 %.
    """
    rng = np.random.default_rng(5)
    scene = scene_of(0.6, **{"crowd.arena_mm": arena})
    kinds = [walkers("koumakis2016"), walkers("polar-disc")]
    dish = scene.crowd.dish
    places = [row for row in lattice(9, 30.0, rng) if _inside(dish, row)]
    plan = run.prepare(scene, kinds, [i % 2 for i in range(len(places))], np.array(places))
    crowd = run.simulate(plan, 0, 50.0)
    assert set(crowd.outcomes) == {"ok"}
    assert crowd.touches > 10
    assert crowd.deepest < 0.1
    assert crowd.energy_error < 0.01
    assert crowd.contact_error < 0.15  # of eight starts in two dishes 0.001 to 0.094, root mean square 0.035
    again = run.simulate(plan, 0, 50.0)
    assert np.array_equal(crowd.poses, again.poses)
    if arena.startswith("disc"):
        assert np.hypot(*crowd.poses[:, :, :2].transpose(2, 0, 1)).max() < 45.0


def _inside(dish, row):
    """True where a walker of 16 mm about `row` is in the dish."""
    if dish.kind == "periodic":
        return True
    far, reach = math.hypot(row[0], row[1]), 16.0
    if dish.kind in ("disc", "ring"):
        inner = 0.5 * dish.sizes[1] if dish.kind == "ring" else -99.0
        return inner + reach < far < 0.5 * dish.sizes[0] - reach
    return all(abs(at) < 0.5 * side - reach for at, side in zip(row, dish.box, strict=False))


def test_a_crowd_on_a_still_plate_comes_to_rest():
    data = {"drive": STILL_DRIVE, "run": {"seconds": 0.5, "discard_seconds": 0.2}}
    scene = Scene.model_validate(data | {"crowd": {"arena_mm": "disc:100"}})
    plan = run.prepare(scene, [walkers("koumakis2016")], [0] * 4, lattice(4, 34.0, np.random.default_rng(1)))
    poses = run.simulate(plan, 0, 20.0).poses
    assert np.abs(poses[-1] - poses[-2]).max() < 1e-4
