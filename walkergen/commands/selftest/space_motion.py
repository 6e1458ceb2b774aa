"""Hard cases in space: images of a motion, its plane, and an upright walker."""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.commands.selftest.case import SPACE, Case, Check, check_fact
from walkergen.commands.selftest.scenes import advance, paper_drive, paper_plan, scaled_paper_plan
from walkergen.commands.selftest.space_scenes import (
    max_pose_difference,
    mirror_image,
    moving_start,
    quarter_turn,
    space_plan,
)
from walkergen.core.simulation import record
from walkergen.core.simulation.run import Outcome, simulate
from walkergen.core.simulation.space.state import (
    C_X,
    C_Z,
    HEADING,
    HEIGHT,
    LEGS,
    Q_0,
    Q_Z,
    ROLL,
    SHOWN_X,
    SHOWN_Y,
    V_X,
    V_Z,
    W_X,
    W_Y,
    W_Z,
)

FIRST_LANDING_S = 5e-3
"""Time (s) after which the first corners have landed in a drop from 0.05 mm."""

COMPARISON_S = 6e-3
"""Time (s) of the comparison of images. One millisecond later, overdamped feet that change between
sticking and sliding have amplified rounding by nine powers of ten."""

ROUNDING_REASON = "rounding, grown six times by each landing of a corner"

CONTACTS = (
    {"restitution": 0.9, "friction": 0.1},
    {"restitution": 0.5, "friction": 2.0},
    {"restitution": 0.02, "friction": 0.25},
)


def _check_images() -> Iterator[Check]:
    """Check that a mirrored or turned start gives the mirrored or turned motion."""
    for contact in CONTACTS:
        plan = space_plan(drive=paper_drive(1.8), contact=contact)
        title = f"e = {contact['restitution']:g}, mu = {contact['friction']:g}"
        for name, image_of in (("mirror image", mirror_image), ("quarter turn", quarter_turn)):
            state = moving_start(plan)
            image = image_of(state)
            advance(plan, state, COMPARISON_S)
            advance(plan, image, COMPARISON_S)
            yield Check(f"{title}: {name}, mm", max_pose_difference(image_of(state), image), 1e-9, ROUNDING_REASON)


def _check_planar_motion() -> Iterator[Check]:
    """Check that roll and yaw come from rounding alone, and not at all when they are off."""
    for contact in CONTACTS:
        title = f"e = {contact['restitution']:g}, mu = {contact['friction']:g}"
        for free in (True, False):
            plan = space_plan(
                drive=paper_drive(1.8), contact=contact, effects={"on" if free else "off": ["roll_and_yaw"]}
            )
            state = plan.initial_state(clearance=0.05, pitch=4e-3, phase=1.0)
            state[[V_X, W_Z]] = 12.0, 0.7
            advance(plan, state, FIRST_LANDING_S if free else 0.2)
            deviation = float(np.abs(state[[SHOWN_Y, HEADING, ROLL, C_Z]]).max())
            yield Check(
                f"{title}: out of its plane, {'free' if free else 'held'}",
                deviation,
                1e-9 if free else 0.0,
                ROUNDING_REASON if free else "exact: nothing moves it across",
            )


def _check_tiny_roll() -> Iterator[Check]:
    """Check that first landings change in proportion to a tiny roll: no rule for ties decides."""
    for contact in CONTACTS:
        plan = space_plan(drive=paper_drive(1.8), contact=contact)
        final_states = []
        for roll in (0.0, 1e-9, 2e-9):
            state = moving_start(plan, roll)
            state[W_X : W_Z + 1] = 0.0, 0.0, 0.7
            advance(plan, state, FIRST_LANDING_S)
            final_states.append(state)
        title = f"e = {contact['restitution']:g}, mu = {contact['friction']:g}"
        yield Check(
            f"{title}: answer to a roll of 1e-9 rad, mm",
            max_pose_difference(final_states[0], final_states[1]),
            1e-6,
            "4e-9 mm of a corner's height, grown six times by each landing of a corner",
        )
        yield Check(
            f"{title}: twice the roll, twice the answer, relative",
            abs(
                max_pose_difference(final_states[0], final_states[2])
                / max_pose_difference(final_states[0], final_states[1])
                - 2.0
            ),
            0.2,
            "modes of the contacts change a few steps earlier or later",
        )


def _check_heading_turns() -> Iterator[Check]:
    """Check a million turns of the heading, in the output and in the rotation itself."""
    turns = 2.0 * math.pi * 1_000_000
    for contact in CONTACTS:
        plan = space_plan(drive=paper_drive(1.8), contact=contact)
        state, counted, rotated = moving_start(plan), moving_start(plan), moving_start(plan)
        counted[HEADING] += turns
        half = 0.5 * turns  # rounded to 4e-10 rad
        q, i, j, k = state[Q_0 : Q_Z + 1]
        cos, sin = math.cos(half), math.sin(half)
        rotated[Q_0 : Q_Z + 1] = cos * q - sin * j, cos * i + sin * k, cos * j + sin * q, cos * k - sin * i
        for each in (state, counted, rotated):
            advance(plan, each, COMPARISON_S)
        title = f"e = {contact['restitution']:g}, mu = {contact['friction']:g}"
        counted[HEADING] -= turns
        deviation = abs(float(counted[HEADING] - state[HEADING]))
        yield Check(
            f"{title}: heading after {COMPARISON_S:g} s, rad",
            deviation,
            1e-8,
            "rounding of a million turns, in each frame",
        )
        counted[HEADING] = state[HEADING]
        reason = "the heading's rounding, 1e-9 rad, turns what feet hold on to; chaos makes 1 % of it in 0.1 s"
        yield Check(f"{title}: all but the heading, mm", max_pose_difference(counted, state), 1e-10, reason)
        yield Check(
            f"{title}: turned itself, mm",
            max_pose_difference(rotated, state),
            1e-6,
            f"4e-10 rad of start; {ROUNDING_REASON}",
        )


def _check_far_origin() -> Iterator[Check]:
    """Check a start 2^30 mm along the plate. Only the position may depend on it."""
    for contact in CONTACTS:
        plan = space_plan(drive=paper_drive(1.8), contact=contact)
        state, far = moving_start(plan), moving_start(plan)
        far[[SHOWN_X, C_X]] += 2.0**30
        for each in (state, far):
            advance(plan, each, 0.02)
        title = f"e = {contact['restitution']:g}, mu = {contact['friction']:g}"
        deviation = float(np.abs(far[[SHOWN_X, C_X]] - 2.0**30 - state[[SHOWN_X, C_X]]).max())
        yield Check(
            f"{title}: way in 0.02 s, mm", deviation, 1e-3, "rounding of 1e9 mm, 1.2e-7 mm, in each of 2000 steps"
        )
        far[[SHOWN_X, C_X]] = state[[SHOWN_X, C_X]]
        yield check_fact(f"{title}: all else to the bit", bool(np.array_equal(far, state)))


def _check_scaling() -> Iterator[Check]:
    """Check lengths x 4^n and times x 2^n: the scaled problem has the scaled result to the last bit.

    Every length of the code, of steps and tolerances too, must then be in units of walker and plate.
    """
    start = None
    for power in (0, -5, -4, -1, 1, 4, 5):
        length, seconds = 4.0**power, 2.0**power
        # A given step: its own follows from powers of 0.4 and 2/3, which scale to rounding only
        plan = scaled_paper_plan(length, {"step_us": 16.0 * seconds}, arena={"kind": "plane"})
        state = plan.initial_state(clearance=0.0625 * length, pitch=4e-3, phase=1.0, roll=1e-3)
        state[[V_X, V_Z]] = 12.0 * seconds, 3.0 * seconds
        state[W_Y] = 0.25 / seconds
        outcome, tally = advance(plan, state, 0.25 * seconds)
        legs = len(plan.world.walker.stiffness)
        state[[SHOWN_X, SHOWN_Y, HEIGHT, *range(C_X, C_Z + 1)]] /= length
        state[V_X : V_Z + 1] /= seconds
        state[[*range(W_X, W_Z + 1), *range(LEGS + legs, LEGS + 2 * legs)]] *= seconds
        state = state[: LEGS + 2 * legs]
        if start is None:
            start = state
            yield check_fact("it runs and lands", outcome is Outcome.OK and tally.counts[record.IMPACTS] > 25)
        else:
            deviation = float(np.abs(state - start).max())
            yield Check(f"lengths x 4^{power}: state after 0.25 s x 2^{power}", deviation, 0.0, "exact: powers of two")


def _check_upright_walker() -> Iterator[Check]:
    """Check that the mean speed of an upright walker is 0 within its error."""
    runs = {"seconds": 2.0, "discard_seconds": 0.5}
    plan = paper_plan(0.0, drive=paper_drive(1.8), arena={"kind": "plane"}, contact={"friction": 0.25}, run=runs)
    results = [simulate(plan, number) for number in range(8)]
    yield check_fact("all runs end well", all(result.outcome is Outcome.OK for result in results))
    speeds = np.array([result.speed for result in results])
    error = float(speeds.std(ddof=1) / math.sqrt(len(speeds)))
    yield Check(
        f"mean speed of 8 runs, over its error of {error:.2g} mm/s",
        abs(float(speeds.mean())) / error,
        4.0,
        "four standard errors of eight runs",
    )
    yield Check("its error, mm/s", error, 5.0, "a twelfth of the speed of a leg tilted by 10 deg")


CASES = [
    Case("space: mirror image and quarter turn", "7", "mirror symmetry; isotropy of the plane", SPACE, _check_images),
    Case("space: a symmetric start stays in its plane", "7", "mirror symmetry", SPACE, _check_planar_motion),
    Case(
        "space: a roll of 1e-9 rad changes nothing at once",
        "7",
        "Cauchy: a motion is continuous in its start",
        SPACE,
        _check_tiny_roll,
    ),
    Case("space: a million turns of the heading", "7", "isotropy of the plane", SPACE, _check_heading_turns),
    Case("space: 1e9 mm from the origin", "7", "translation along the plate", SPACE, _check_far_origin),
    Case("space: lengths x 4^n, times x 2^n", "7", "dimensional analysis", SPACE, _check_scaling),
    Case("space: upright walker goes nowhere", "7", "mirror symmetry", SPACE, _check_upright_walker),
]
