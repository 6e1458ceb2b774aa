"""Two walkers that collide: the kernel, closed forms of contacts, and MuJoCo's bodies agree.

Bodies have the masses and tensors of the paper's braced walker. Contacts take 0.2 ms and give by some micrometres.
"""

import math

import numpy as np
import pytest
from crowd_bodies import Pair
from crowd_rival import Box, Law, Motion, collide, flush, inverse_mass, meet, still, struck
from nightly_cases import mostly_nightly

from walkergen.core.simulation.effects.slope import Gravity
from walkergen.core.simulation.space.pose import update_pose
from walkergen.core.simulation.space.state import C_X, V_X, W_X, work_for
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.guests.crowd.space import bodies, run

SPRING, STEP = (math.pi / 2e-4) ** 2, 4e-7
"""Of an upright edge, 1/s^2: contacts of 0.2 ms; and of MuJoCo, s: a five-hundredth of one."""

GAP = 1e-3
"""Between the bodies at the start, mm."""

SPEED = 100.0
"""At which walkers meet, mm/s: two of the paper's fastest, head on."""

LENGTH, DEPTH, RADIUS = 28.0, 8.0, 0.2
"""Of the paper's body, and of its upright edges, mm."""

TO_EDGE = -math.atan2(DEPTH - 2.0 * RADIUS, LENGTH - 2.0 * RADIUS)
"""Turn that brings an edge of a box to the front, on the line through its C."""

TO_SECOND = 0.5 * math.hypot(DEPTH - 2.0 * RADIUS, LENGTH - 2.0 * RADIUS) + RADIUS
"""Distance of C from the tip of a box so turned, mm."""

ARMS = np.array([1.5, 10.0, 1.5])
"""Arms at which rates are compared, mm: half a body's height, and what lies along it."""

AHEAD = np.array([-1.0, 0.0, 0.0])
"""From the second box into the first."""


@pytest.fixture(scope="module")
def boxes():
    mass = solids.mass_of(Design().variant(tilt_deg=10.0, kind="braced"))
    half = np.array([0.5 * LENGTH, 1.5, 0.5 * DEPTH])
    box = Box(float(mass.M), mass.spatial.body, half, radius=RADIUS)
    return box, box


def meeting(across, slide):
    """Boxes of which the first runs its front onto an edge of the second, and where they touch.

    `across`: place of the edge beside the first's axis, mm, when they meet; `slide`: sideways speed of the first, mm/s.
    """
    start = -slide / SPEED * GAP
    first = still(-0.5 * LENGTH - GAP, start, velocity=(SPEED, slide))
    return (first, still(TO_SECOND, across, TO_EDGE)), np.array([0.0, 0.0, across])


def when_met(motions):
    first, second = motions
    return first._replace(place=first.place + GAP / SPEED * first.velocity), second


def velocities(motions):
    """Velocities of all boxes, and those that their rates give their faces, mm/s, in one row."""
    return np.concatenate([np.concatenate([m.velocity, ARMS * m.rate]) for m in motions])


CASES = {
    "head-on": (0.0, 0.0, 0.0),
    "head-on, rough": (0.0, 0.0, 0.3),
    "off-centre": (2.0, 0.0, 0.0),
    "off-centre, sticking": (2.0, 0.0, 0.9),
    "off-centre, sliding": (3.0, 0.0, 0.1),
    "glancing, smooth": (-2.0, 60.0, 0.0),
    "glancing, sliding": (2.0, 200.0, 0.3),
    "glancing, turned round": (-3.0, 60.0, 0.4),
    "glancing, stopped": (1.0, 50.0, 0.8),
}
"""Places beside the axis (mm), sideways speeds (mm/s) and frictions."""


@pytest.mark.parametrize("label", mostly_nightly([0.3, 1.0], 0.3))
@pytest.mark.parametrize("case", CASES)
def test_one_contact_is_the_closed_form_with_bodies_of_mujoco(boxes, case, label):
    across, slide, friction = CASES[case]
    motions, point = meeting(across, slide)
    met, law = when_met(motions), Law(SPRING, label, friction)
    expected = velocities(struck(boxes, met, point, AHEAD, law))
    found, deepest, _ = collide(boxes, motions, law, 8e-4, STEP)
    # 0.6 %: bodies roll, and the place of an edge slides on by 0.05 of its arm meanwhile
    np.testing.assert_allclose(velocities(found), expected, rtol=0, atol=6e-3 * (SPEED + slide))
    given = SPEED / math.sqrt(SPRING)
    assert deepest == pytest.approx(given, rel=0.01 if friction == 0.0 else 0.3)


@pytest.mark.parametrize("across", [0.0, 2.0, -3.5])
def test_contact_of_mujoco_itself_ends_as_ours_where_it_is_elastic(boxes, across):
    """MuJoCo finds the edge and solves the contact: nothing of it is ours but the masses."""
    sharp = [box._replace(radius=0.0) for box in boxes]
    first, _ = meeting(across, 0.0)[0]
    second = still(0.5 * math.hypot(LENGTH, DEPTH), across, -math.atan2(DEPTH, LENGTH))
    point, law = np.array([0.0, 0.0, across]), Law(SPRING, 1.0, 0.0)
    expected = velocities(struck(boxes, when_met((first, second)), point, AHEAD, law))
    found = meet(sharp, (first, second), 5e-4, STEP, SPRING)
    np.testing.assert_allclose(velocities(found), expected, rtol=0, atol=2e-3 * SPEED)


def facing(shift):
    """Boxes that run at each other flush, beside each other by a shift, and what touches."""
    first = still(-0.5 * LENGTH - 0.5 * GAP, -0.5 * shift, velocity=(0.5 * SPEED, 0.0))
    second = still(0.5 * LENGTH + 0.5 * GAP, 0.5 * shift, math.pi, (-0.5 * SPEED, 0.0))
    edge = 0.5 * DEPTH - RADIUS - 0.5 * shift
    return (first, second), [np.array([0.0, 0.0, z]) for z in (edge, -edge)]


@pytest.mark.parametrize("label", [0.3, 1.0])
@pytest.mark.parametrize("shift", [0.5, 3.0])
def test_edge_on_edge_two_edges_press_at_once(boxes, shift, label):
    motions, points = facing(shift)
    law = Law(SPRING, label, 0.0)
    expected = flush(boxes, motions, points, AHEAD, law)
    found, _, _ = collide(boxes, motions, law, 8e-4, STEP)
    np.testing.assert_allclose(velocities(found), velocities(expected), rtol=0, atol=2e-3 * SPEED)


@pytest.mark.slow
def test_pushed_box_bears_its_share_of_the_push(boxes):
    motions, points = facing(0.5)
    rest = [
        m._replace(place=m.place + 0.5 * GAP * toward * AHEAD, velocity=np.zeros(3))
        for m, toward in zip(motions, (-1.0, 1.0), strict=True)
    ]
    force, law = 2e4, Law(SPRING, 0.3, 0.0)
    found, deepest, mean = collide(boxes, rest, law, 3e-3, STEP, push=np.array([force, 0.0, 0.0]))
    share = boxes[1].mass / (boxes[0].mass + boxes[1].mass)
    assert mean[0] == pytest.approx(share * force, rel=0.03)
    both = [m.velocity[0] for m in found]
    expected = force * 3e-3 / (boxes[0].mass + boxes[1].mass)
    assert both == pytest.approx([expected, expected], rel=0.03)
    softness = float(AHEAD @ inverse_mass(boxes, rest, points[0]) @ AHEAD)
    assert deepest == pytest.approx(share * force * softness / SPRING, rel=0.1)  # twice at rest


def simulated(motions, seconds, push=None, **keys):
    """Pair of the kernel with these motions, in touch for 0.2 ms, advanced; and its motions then.

    `push`: acceleration of the first, mm/s^2 along x.
    """
    pair = Pair(
        [(m.place[0], m.place[2], math.atan2(m.turn[0, 2], m.turn[0, 0])) for m in motions],
        [(m.velocity[0], m.velocity[2]) for m in motions],
        shorter=3.0,
        **keys,
    )
    if push is not None:
        (world, state), second = pair.walkers
        world = world._replace(acting=world.acting._replace(gravity=Gravity(push, 1e-9, push)))
        pair.crowd, pair.walkers = run.make_crowd(pair.plan, [(world, state), second])
    pair.advance(seconds)
    found = []
    for world, state in pair.walkers:
        work = work_for(world.walker, state)
        update_pose(world, state, work)
        at, v, w = (state[first : first + 3].copy() for first in (C_X, V_X, W_X))
        found.append(Motion(at, work.R.copy(), v, work.R @ w))
    return pair, found


@pytest.fixture(scope="module")
def own():
    """Boxes of the shape that the kernel gives the same walker, C not in their middle."""
    pair = Pair([(-20.0, 0.0, 0.0), (20.0, 0.0, 0.0)], [(0.0, 0.0)] * 2)
    low, high = pair.shape.corners[:, 0].min(), pair.shape.corners[:, 0].max()
    half = np.array([0.5 * (high - low) + pair.shape.radius, 1.5, 0.5 * DEPTH])
    walker, shape = pair.walker, pair.shape
    box = Box(
        float(walker.mass), np.array(walker.inertia), half, 0.5 * (low + high), shape.radius, (shape.bottom, shape.top)
    )
    return box, box


def onto_edge(box, across, slide):
    """The kernel's walkers as those of `meeting`: C of neither is in the middle of its body."""
    ahead, core = box.ahead, box.half - box.radius
    turned = still(0.0, 0.0, TO_EDGE)
    edges = [turned.turn @ (ahead + a * core[0], 0.0, b * core[2]) for a in (-1, 1) for b in (-1, 1)]
    tip = min(edges, key=lambda edge: edge[0])
    first = still(-box.half[0] - ahead - GAP, -slide / SPEED * GAP, 0.0, (SPEED, slide))
    return first, still(box.radius - tip[0], across - tip[2], TO_EDGE)


@pytest.mark.slow
@pytest.mark.parametrize("label", [0.3, 1.0])
@pytest.mark.parametrize("case", CASES)
def test_kernel_collides_as_mujoco_and_as_the_closed_form(own, case, label):
    across, slide, friction = CASES[case]
    motions = onto_edge(own[0], across, slide)
    pair, found = simulated(motions, 8e-4, restitution=label, friction=friction)
    law = Law(2.0 * pair.plan.law.spring, label, friction)
    rival, deepest, _ = collide(own, motions, law, 8e-4, STEP)
    assert pair.crowd.book[bodies.TOUCHES] == 1
    assert pair.crowd.book[bodies.DEEPEST] == pytest.approx(deepest, rel=0.05)
    # 0.5 %: ticks of a thirteenth of a contact
    size = SPEED + slide
    np.testing.assert_allclose(velocities(found), velocities(rival), rtol=0, atol=5e-3 * size)
    point = np.array([0.0, own[0].heights[0] + 1.5, across])
    flat = velocities(struck(own, when_met(motions), point, AHEAD, law))
    np.testing.assert_allclose(velocities(found), flat, rtol=0, atol=0.02 * size)


@pytest.mark.slow
@pytest.mark.parametrize("shift", [0.5, 3.0])
def test_kernel_collides_edge_on_edge_as_mujoco(own, shift):
    front = own[0].half[0] + own[0].ahead + 0.5 * GAP
    motions = (
        still(-front, -0.5 * shift, velocity=(0.5 * SPEED, 0.0)),
        still(front, 0.5 * shift, math.pi, (-0.5 * SPEED, 0.0)),
    )
    pair, found = simulated(motions, 8e-4, restitution=0.5, friction=0.3)
    law = Law(2.0 * pair.plan.law.spring, 0.5, 0.3)
    rival, _, _ = collide(own, motions, law, 8e-4, STEP)
    np.testing.assert_allclose(velocities(found), velocities(rival), rtol=0, atol=6e-3 * SPEED)


@pytest.mark.slow
def test_kernel_pushes_as_mujoco(own):
    """Flush, given from the start by as much as springs alone would."""
    push, apart = 2e5, own[0].half[0] + own[0].ahead
    pair, _ = simulated((still(-apart - 1.0, 0.0), still(apart + 1.0, 0.0, math.pi)), 1e-6)
    spring, middle = 2.0 * pair.plan.law.spring, np.array([0.0, 0.0, 0.5 * DEPTH])
    flush_boxes = (still(-apart, 0.0), still(apart, 0.0, math.pi))
    softness = float(AHEAD @ inverse_mass(own, flush_boxes, middle) @ AHEAD)
    given = 0.5 * own[0].mass * push / (2.0 * spring / softness)
    motions = (still(0.5 * given - apart, -0.25), still(apart - 0.5 * given, 0.25, math.pi))
    pair, found = simulated(motions, 2e-3, push, restitution=0.3, friction=0.3)
    force = np.array([own[0].mass * push, 0.0, 0.0])
    rival, deepest, mean = collide(own, motions, Law(spring, 0.3, 0.3), 2e-3, STEP, push=force)
    assert mean[0] == pytest.approx(0.5 * force[0], rel=0.02)
    np.testing.assert_allclose(velocities(found), velocities(rival), rtol=0, atol=0.01 * 200.0)
    # A contact let go a little gives back less than it bore: gives stay some times a spring's
    assert given < deepest < 4.0 * given
    assert given < pair.crowd.book[bodies.DEEPEST] < 4.0 * given
