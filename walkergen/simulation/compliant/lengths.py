"""Lengths of time steps: how far a walker on legs may go in one, and what legs do within it."""

import math
from typing import Any

from walkergen.numerics.kernels import inlined, kernel
from walkergen.simulation.world import ANGLE_BACK, ANGLE_FRONT, RATE_BACK, RATE_FRONT, SPIN

TURN = 0.25
"""Largest turn (rad) of body or legs in one step: in flight the kick that corrects the linear swing
is unstable far beyond it, in contact the forces are those of the pose in the middle of the step."""

PUMPED = 0.01
"""Part by which a flight in long steps may pump the legs' swing before its steps resolve it."""

DAMPED = 1.6
"""Decay times of a leg's damper in which its foot, hit at restitution 1, is back: the root of
2 (1 - exp(-x)) = x."""

MOST, OWN = 0.0027, 0.4
"""Own step of a walker: its most, of the plate's period (30 us at 90 Hz), and its share of the longest:
ten in a period of the legs."""

SLIVER = 0.1
"""Part of h below which a step does not end at a foot's stop, nor does a step after one: the error
of second order that a stopped foot keeps would be stopped again and again."""


@kernel
def stiffening(legs, t):
    """Inertia (g mm^2) that the trapezoidal rule adds to either hinge for a step of t seconds."""
    back, front = legs
    return (
        t * (0.5 * back.damping + 0.25 * t * back.stiffness),
        t * (0.5 * front.damping + 0.25 * t * front.stiffness),
    )


@kernel
def swings_back(walker, t):
    """True when legs that are hit swing back within t s: by the half period of their slower mode,
    or because their dampers stop them on a body that comes on towards the plate.
    """
    return _swings_back(walker.legs, walker.swing, t)


@inlined
def _swings_back(legs, swing, t):
    rate, decay = slower_mode(legs[0], swing)
    return t * rate > math.pi or t * decay > DAMPED


@kernel
def slower_mode(leg, swing):
    """Frequency (rad/s) and damping (twice its decay, 1/s) of the slower mode; `leg`: the back."""
    slower = min(swing.mobility_1, swing.mobility_2)
    part = swing.sin if swing.mobility_1 <= swing.mobility_2 else swing.cos
    return (math.sqrt(leg.stiffness * slower), leg.damping * (1.0 + swing.excess * (part * part)) * slower)


def longest_step(walker: Any) -> float:
    """Step (s) beyond which legs that are hit swing back within two, so that no foot rebounds."""
    rate, decay = slower_mode(walker.legs[0], walker.swing)
    return 0.5 * min(math.pi / rate, DAMPED / decay if decay > 0.0 else math.inf)


def own_step(walker: Any, period: float) -> float:
    """Step (s) of a walker unless its scene gives one: it resolves the swing of the legs.

    `period`: of the plate, s.
    """
    return min(MOST * period, OWN * longest_step(walker))


@inlined
def longest_flight(walker, state, options, clear):
    """Longest step in the air, s: neither body nor legs turn far in it.

    A kick in every half period of the legs is in resonance with them: the centrifugal stiffness of
    a turn at `spin` then pumps their swing at the rate spin^2 / omega. Where that matters within
    the time `clear`, for which no foot can land, steps are no longer than in contact, nor than a
    sixth of the legs' period. What couples the legs' modes, unlike dampers, is in the kick too.
    """
    return _longest_flight(walker.legs, walker.swing, state, options, clear)


@inlined
def _longest_flight(legs, swing, state, options, clear):
    least, longest = SLIVER * options.step, options.flight * options.step
    faster = max(swing.mobility_1, swing.mobility_2)
    square = legs[0].stiffness * faster
    angles = state[ANGLE_BACK] ** 2 + state[ANGLE_FRONT] ** 2
    rates = state[RATE_BACK] ** 2 + state[RATE_FRONT] ** 2
    fastest = math.sqrt(state[SPIN] ** 2 + rates + square * angles)
    if fastest * fastest * clear > PUMPED * math.sqrt(square):
        longest = min(options.step, max(least, 1.0 / math.sqrt(square)))
    coupling = legs[0].damping * faster * abs(swing.excess * swing.cos * swing.sin)
    longest = min(longest, max(least, TURN / (coupling + 1e-300)))
    return min(longest, max(least, TURN / (fastest + 1e-300)))


@kernel
def longest_contact(state, step):
    """Longest step in contact, s: `step`, or less where body or legs would turn far in it.

    Not less than a part of `step`: legs too stiff for it keep the rates that an impact gave them.
    """
    turn = max(abs(state[SPIN]), abs(state[RATE_BACK]))
    turn = max(turn, abs(state[RATE_FRONT]))
    return min(step, max(SLIVER * step, TURN / (turn + 1e-300)))
