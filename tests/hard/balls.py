"""Hard cases of one bouncing ball on a shaken plate: a level walker on smooth feet, by its map."""

import math
from collections.abc import Iterator

from hard import RIGID
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import Array, advance, plan_of, shaken
from walkergen.scene import GRAVITY
from walkergen.simulation.model import Plan
from walkergen.simulation.world import PITCH, V_Y, Y

CLOSE = 1e-4
"""Part of the threshold below and above it."""

SETTLED = 50_000
"""Periods after which a disturbance has died, or grown to its end: e-folds by 0.6 to 0.9 in 1000."""


def threshold(restitution: float) -> tuple[float, float]:
    """Peak acceleration (over g) at which one bounce a period becomes two, and that of the plate at
    the bounce: the map's determinant is e^2, so its trace is -(1 + e^2) where an eigenvalue is -1.
    """
    e = restitution
    along = math.pi * (1.0 - e) / (1.0 + e)
    return math.hypot(along, 2.0 * (1.0 + e * e) / (1.0 + e) ** 2), along


def _bouncing(gamma: float, restitution: float, along: float) -> tuple[Plan, Array]:
    """Plan and state on the orbit of one bounce a period, but for a thousandth of its speed."""
    contact = {"restitution": restitution, "friction": 0.0}
    plan = plan_of("rigid", 0.0, drive=shaken(gamma), contact=contact)
    drive = plan.world.drive
    state = plan.start(0.0, 0.0, math.acos(along / gamma))
    state[V_Y] = 1.001 * math.pi * GRAVITY / drive.omega
    advance(plan, state, 0.5 * drive.period)
    return plan, state


def _doubling(model: str) -> Iterator[Check]:
    for restitution in (0.2, 0.5, 0.8):
        gamma, along = threshold(restitution)
        sizes = []
        for part in (-CLOSE, CLOSE, 4.0 * CLOSE):
            plan, state = _bouncing((1.0 + part) * gamma, restitution, along)
            drive, heights = plan.world.drive, []
            advance(plan, state, SETTLED * drive.period)
            for _ in range(3):
                heights.append(float(state[Y]))
                advance(plan, state, drive.period)
            sizes.append(abs(heights[1] - heights[0]) / drive.amplitude)
            again = abs(heights[2] - heights[0]) / drive.amplitude
            title = f"e = {restitution:g}, {gamma:.6f} g x {1.0 + part:g}"
            yield Check(f"{title}: height two periods later, amplitudes", again, 1e-9, "rounding of a height")
            yield exactly(f"{title}: no pitch", state[PITCH] == 0.0)
        title = f"e = {restitution:g}"
        yield Check(f"{title}: bounces differ below it, amplitudes", sizes[0], 1e-6, "what is left after 50 000")
        yield Check(
            f"{title}: how far they differ over the root of the distance beyond it, against 2 at 4 times it",
            abs(sizes[2] / sizes[1] - 2.0),
            0.01,
            "the next order of the pitchfork, and the threshold to 1e-6 of itself",
        )


CASES = [
    Case(
        "one bounce a period becomes two",
        "6.4",
        "Holmes, J. Sound Vib. 84, 173 (1982); Luck and Mehta, Phys. Rev. E 48, 3988 (1993)",
        RIGID,
        _doubling,
    )
]
"""Hard cases of one bouncing ball."""
