"""Leaps: steps that are taken as one where feet fly or slide on (docs/physics.md section 7)."""

import math

import numpy as np
import pytest
from space_rival import plan_of

from walkergen.files.progress import silent
from walkergen.simulation import ensemble, record
from walkergen.simulation.space.state import C_X, C_Z, QUIET, V_X
from walkergen.simulation.space.walker import LONGEST_LEAP, MOST_LEAPT

SHAKEN = {"drive": {"frequency_hz": 90.0, "gamma": 1.8}}
"""The paper's plate."""

HARD = SHAKEN | {
    "contact": {"restitution": 0.02},
    "feet": {"stiffness_ratio": 10.0, "tangential_ratio": 8.0},
    "effects": {"leg_twist": False},
}
"""Stiff feet that hardly rebound, whose steps are short."""

WEAK = {"contact": {"restitution": 0.8}, "drive": {"frequency_hz": 90.0, "gamma": 1.4}}
"""A plate that hardly throws a walker at 15 deg: its feet slide by less than their springs give."""


def with_leap(plan, leap):
    """The same plan with so many steps in a leap."""
    return plan._replace(world=plan.world._replace(options=plan.world.options._replace(leap=leap)))


def moved(plan, state, seconds):
    """State so many seconds later."""
    later = state.copy()
    plan.advance(later, seconds, record.new(len(later)))
    return later


def test_a_leap_is_a_part_of_a_period_and_of_a_frame():
    own = plan_of(10)
    period, step, leap = own.world.drive.period, own.world.options.step, own.world.options.leap
    assert leap == int(LONGEST_LEAP * period / step) > 1
    # finer steps have as much shorter leaps, so that both errors fall; coarser ones no longer leap
    assert plan_of(10, run={"step_us": 0.5e6 * step}).world.options.leap == leap
    assert plan_of(10, run={"step_us": 1.25e6 * step}).world.options.leap == int(LONGEST_LEAP * period / (1.25 * step))
    plastic = plan_of(30, contact={"restitution": 0.02}).world.options
    assert plastic.leap == MOST_LEAPT < plastic.frame
    assert plan_of(10, feet={"damping": "hysteretic"}).world.options.leap == 1


def test_a_walker_that_slides_to_rest_goes_as_far_in_leaps():
    plan = plan_of(10)
    start = moved(plan, plan.start(1e-3, 0.0, 0.0), 0.05)
    start[V_X], start[QUIET] = start[V_X] + 100.0, 0.0
    single, leaping = (moved(with_leap(plan, leap), start, 0.03) for leap in (1, plan.world.options.leap))
    assert (single != leaping).any()
    way = single[C_X] - start[C_X]
    assert way > 1.0
    # 1e-3: legs that swing on after a jerk and feet that skip, at ten times the step
    assert leaping[C_X] - start[C_X] == pytest.approx(way, rel=1e-3)
    assert leaping[C_Z] - start[C_Z] == pytest.approx(single[C_Z] - start[C_Z], abs=1e-3 * way)


def test_a_walker_that_stands_takes_no_leap():
    plan = plan_of(10)
    start = moved(plan, plan.start(1e-3, 0.0, 0.0), 0.05)
    np.testing.assert_array_equal(moved(with_leap(plan, 1), start, 0.002), moved(plan, start, 0.002))


@pytest.mark.slow
@pytest.mark.parametrize(("tilt", "tables"), [(10, SHAKEN), (15, WEAK), (15, HARD)])
def test_speed_and_energies_are_those_of_single_steps(tilt, tables):
    """Without the rule of how far feet slide, the second ran at 0.98 for 1.26 ± 0.02 mm/s; in leaps of 24 steps the
    third at 39.8 for 37.1 ± 0.2.
    """
    plan = plan_of(tilt, run={"seconds": 1.5 if tables is HARD else 4.0, "runs": 16}, **tables)
    single, leaping = (ensemble.measure(with_leap(plan, leap), silent)[0] for leap in (1, plan.world.options.leap))
    noise = math.hypot(single.speed_se_mm_s, leaping.speed_se_mm_s)
    assert abs(single.speed_mm_s - leaping.speed_mm_s) < 3.0 * noise
    for name, power in single.energies_per_s.items():
        error = math.hypot(*(one.errors[f"energies_per_s.{name}"] for one in (single, leaping)))
        assert abs(power - leaping.energies_per_s[name]) < 4.0 * error + 0.01 * single.energies_per_s["from_plate"], (
            name
        )
