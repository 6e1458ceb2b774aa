"""Collisions in LAMMPS against the closed form of a rigid impact with friction."""

import math

import numpy as np
import pytest
from flat_cards import DISC, silent, with_lammps
from flat_pairs import collide

from walkergen.core.dish import Dish
from walkergen.core.theory.impact import impact
from walkergen.guests.crowd.flat import contact, crowd, crowd_checks, discs, lammps_input

SPEED = 100.0


def glider(**keys):
    """A disc that glides without drag or noise."""
    return silent(outline_mm=[DISC], velocity_relaxation_s=1e6, speed_mm_s=SPEED, inertia_g_mm2=7.2, **keys)


def rates(poses, rate_hz):
    """Rates of the first and the last frame, shape (2, N, 3)."""
    return np.stack((poses[1] - poses[0], poses[-1] - poses[-2])) * rate_hz


@pytest.mark.parametrize("wanted", [0.05, 0.3, 0.8])
def test_dashpot_of_a_restitution_has_it_when_integrated(wanted):
    zeta, x, v, h = contact.damping_ratio(wanted), 0.0, 1.0, 1e-5
    while True:  # x'' = -x - 2 zeta x', until nothing pushes any more
        force = -x - 2.0 * zeta * v
        if force >= 0.0 and x > 0.0:
            break
        v += h * force
        x += h * v
    assert -v == pytest.approx(wanted, abs=2e-4)


def test_steps_resolve_the_dashpot_of_what_gives_little_back():
    steps = [lammps_input.mechanics([glider(restitution=one)]).contacts.longest_step for one in (0.5, 0.3, 0.1)]
    assert steps[0] > steps[1] > 1.9 * steps[2]


@with_lammps
def test_discs_that_meet_head_on_part_with_the_restitution_of_their_cards():
    cards = [glider(restitution=e) for e in (0.1, 0.5, 0.9)]
    kinds = [0, 0, 1, 1, 2, 2]
    rows = [(side, 40.0 * k) for k in range(3) for side in (-1, 1)]
    places = [(side * 5.0, y, 0.0 if side < 0 else math.pi) for side, y in rows]
    run = crowd.simulate(
        crowd_checks.make_crowd(
            cards, kinds, Dish("rectangle", (300.0, 200.0)), places, seconds=0.06, rate_hz=500.0, seed=1, running=True
        )
    )
    before, after = rates(run.poses, 500.0)
    restitutions = (after[1::2, 0] - after[::2, 0]) / (before[::2, 0] - before[1::2, 0])
    # Twelve steps in a touch: 0.025 by where in a step it begins, as the scheme drawn by itself has it
    assert restitutions == pytest.approx([0.1, 0.5, 0.9], abs=0.035)


@with_lammps
@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_discs_that_meet_off_centre_slide_or_stick_as_the_closed_form_has_it(friction):
    one = glider(restitution=0.5, friction=friction)
    offset = 8.0 * math.sin(math.radians(30.0))
    places = [(-9.0, offset, 0.0), (9.0, 0.0, math.pi)]
    run = crowd.simulate(
        crowd_checks.make_crowd(
            [one], [0, 0], Dish("rectangle", (300.0, 200.0)), places, seconds=0.15, rate_hz=500.0, seed=1, running=True
        )
    )
    before, after = rates(run.poses, 500.0)
    push = 0.9 * (after[0] - before[0])[:2]
    normal = np.array([-math.cos(math.radians(30.0)), math.sin(math.radians(30.0))])
    along = np.array([normal[1], -normal[0]])
    H = (2.0 / 0.9 + 2.0 * 16.0 / 7.2, 0.0, 2.0 / 0.9)
    approach = np.array([2.0 * SPEED, 0.0])
    law = impact(*H, float(approach @ along), float(approach @ normal), 0.5, friction)
    assert law.sticks or abs(law.F_x) == pytest.approx(friction * law.F_y)
    # Soft discs turn about each other by up to 0.03 rad while they touch
    assert push @ normal == pytest.approx(law.F_y, rel=0.03)
    assert push @ along == pytest.approx(law.F_x, abs=0.03 * law.F_y)
    assert after[:, 2] == pytest.approx(after[0, 2], rel=1e-3)  # both spin the same way


@with_lammps
def test_a_wall_has_its_own_restitution_and_friction():
    one = glider(wall_restitution=0.7, wall_friction=0.1, restitution=0.1, friction=0.9)
    places = [(30.0, 0.0, math.radians(45.0))]
    run = crowd.simulate(
        crowd_checks.make_crowd(
            [one], [0], Dish("rectangle", (100.0, 200.0)), places, seconds=0.3, rate_hz=500.0, seed=1, running=True
        )
    )
    before, after = rates(run.poses, 500.0)[:, 0]
    assert after[0] == pytest.approx(-0.7 * before[0], rel=0.02)
    assert after[1] - before[1] == pytest.approx(-0.1 * 1.7 * before[0], rel=0.05)


@with_lammps
@pytest.mark.parametrize(("kind", "sizes"), [("disc", (60.0,)), ("ring", (80.0, 20.0)), ("rectangle", (60.0, 50.0))])
def test_nobody_leaves_a_dish(kind, sizes):
    one, dish = glider(restitution=0.9, wall_restitution=0.9), Dish(kind, sizes)
    places = [(25.0, 0.0, 2.0), (-20.0, 0.0, 0.4), (0.0, 18.0, 3.0), (0.0, -20.0, 1.3)]
    run = crowd.simulate(
        crowd_checks.make_crowd([one], [0] * 4, dish, places, seconds=1.0, rate_hz=100.0, seed=1, running=True)
    )
    parts = discs.Discs(np.zeros((1, 2)), np.array([4.0]))
    gaps = [crowd_checks.wall_gaps(dish, frame[:, :2], parts.radii) for frame in run.poses]
    assert np.min(gaps) > -0.5
    assert np.ptp(run.poses[:, :, 0], axis=0).min() > 10.0


@with_lammps
@pytest.mark.nightly
def test_boxes_that_meet_anyhow_follow_the_closed_form_on_average_and_lose_no_momentum():
    """Any side or corner on any other: what the discs and one dashpot for all cost in accuracy."""
    hits = collide(150, 0.5, 0.3, seed=3)
    assert len(hits) > 120
    forces, laws = np.array([hit.impulse for hit in hits]), np.array([hit.law for hit in hits])
    assert np.mean(forces[:, 1] / laws[:, 1]) == pytest.approx(1.0, abs=0.05)
    restitutions = np.array([hit.restitution for hit in hits])
    assert np.median(restitutions) == pytest.approx(0.5, abs=0.05)
    low, high = np.percentile(restitutions, [10, 90])
    assert low > 0.25
    assert high < 0.75
    ratios, wanted = forces[:, 0] / forces[:, 1], laws[:, 0] / laws[:, 1]
    assert np.median(np.abs(ratios - wanted)) < 0.06
    energies = np.array([hit.energy for hit in hits]).mean(axis=0)
    assert energies[0] == pytest.approx(energies[1], rel=0.03)
    balance = np.array([hit.balance for hit in hits])
    assert balance[:, 0].max() < 1e-3
    assert balance[:, 1].max() < 0.02
