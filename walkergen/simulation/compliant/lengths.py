"""Lengths of time steps: how far a walker on legs may go in one, and what legs do within it."""

import math

from walkergen.numerics.kernels import kernel
from walkergen.simulation.compliant.chain import angle
from walkergen.simulation.world import ANGLE_BACK, ANGLE_FRONT, RATE_BACK, RATE_FRONT, SPIN

TURN = 0.25
"""Largest turn (rad) of body or legs in one step: in flight the kick that corrects the linear swing
is unstable far beyond it, in contact the forces are those of the pose in the middle of the step."""

PUMPED = 0.01
"""Part by which a flight in long steps may pump the legs' swing before its steps resolve it."""

DAMPED = 1.6
"""Decay times of a leg's damper in which its foot, hit at restitution 1, is back: the root of
2 (1 - exp(-x)) = x."""

SLIVER = 0.1
"""Part of h below which a step does not end at a foot's stop, nor does a step after one: the error
of second order that a stopped foot keeps would be stopped again and again."""


@kernel
def stiffening(legs, t):
    """Inertia (g mm^2) that the trapezoidal rule adds to the hinges for a step of t seconds."""
    if legs is None:
        return 0.0
    return t * (0.5 * legs.damping + 0.25 * t * legs.stiffness)


@kernel
def swings_back(legs, t):
    """True when a leg that is hit swings back within t s: by the half period of its slower mode, or
    because its damper stops it on a body that comes on towards the plate.
    """
    if legs is None:
        return False
    slower = min(legs.swing.mobility_1, legs.swing.mobility_2)
    return t * math.sqrt(legs.stiffness * slower) > math.pi or t * legs.damping * slower > DAMPED


@kernel
def longest_flight(legs, state, options, clear):
    """Longest step in the air, s: exact when braced, else neither body nor legs turn far in it.

    A kick in every half period of the legs is in resonance with them: the centrifugal stiffness of
    a turn at `spin` then pumps their swing at the rate spin^2 / omega. Where that matters within
    the time `clear`, for which no foot can land, steps are no longer than in contact, nor than a
    sixth of the legs' period.
    """
    least, longest = SLIVER * options.step, options.flight * options.step
    if legs is None:
        return longest
    square = legs.stiffness * max(legs.swing.mobility_1, legs.swing.mobility_2)
    angles = state[ANGLE_BACK] ** 2 + state[ANGLE_FRONT] ** 2
    rates = state[RATE_BACK] ** 2 + state[RATE_FRONT] ** 2
    fastest = math.sqrt(state[SPIN] ** 2 + rates + square * angles)
    if fastest * fastest * clear > PUMPED * math.sqrt(square):
        longest = min(options.step, max(least, 1.0 / math.sqrt(square)))
    return min(longest, max(least, TURN / (fastest + 1e-300)))


@kernel
def longest_contact(legs, state, step):
    """Longest step in contact, s: `step`, or less where body or legs would turn far in it.

    Not less than a part of `step`: legs too stiff for it keep the rates that an impact gave them.
    """
    turn = max(abs(state[SPIN]), abs(angle(legs, state, RATE_BACK)))
    turn = max(turn, abs(angle(legs, state, RATE_FRONT)))
    return min(step, max(SLIVER * step, TURN / (turn + 1e-300)))
