"""Leaps: several steps taken as one while contacts stay as they are, and move as they did.

Between landings and leavings feet are pressed on gently and slide: a step that resolves the feet's own oscillation
is then shorter than what happens. A leap is tried where the step before was calm, and taken again by single steps
where a contact touches, opens or sticks in it, or where a velocity changes by more than `STIRRED`. Feet that stick
swing on their tangential springs, faster than all else: they take every step by itself.
"""

from walkergen.numerics.kernels import lean
from walkergen.simulation.space.state import MODE, OPEN, ROW, STICK

STIRRED = 0.1
"""Change of a contact's velocity in a leap beyond which it is not calm, of what gravity gives in the plate's period:
11 mm/s at 90 Hz."""

SLIDES_ON = 4.0
"""Way in half a leap below which a foot that slides is not calm, of the stretch of its tangential spring."""


@lean
def changes(state, near, m, first):
    """True when one of m near contacts is tried in another mode than it is in, or sticks."""
    for i in range(m):
        mode = near[i].tried
        if mode == STICK or mode != int(state[first + ROW * near[i].number + MODE]):
            return True
    return False


@lean
def is_calm(state, near, m, first, h, part, stir):
    """True when no contact changes in a step of h seconds, a part of a leap, nor opens at its end; when its velocity
    does not change by more than `stir` (mm/s) in a leap, and when feet slide on for much longer than their stretch.
    """
    if changes(state, near, m, first):
        return False
    for i in range(m):
        for p in range(3):
            if 2.0 * abs(near[i].middle[p] - near[i].speed[p]) > part * stir:
                return False
        if near[i].tried != OPEN:
            gap, speed = near[i].gap[0] + h * near[i].middle[0], 2.0 * near[i].middle[0] - near[i].speed[0]
            if near[i].stiff * gap + near[i].c_n * speed >= 0.0:
                return False
            slip = near[i].middle[1] * near[i].middle[1] + near[i].middle[2] * near[i].middle[2]
            least = part * SLIDES_ON * near[i].friction * near[i].force[0] / near[i].b_t
            if slip < least * least:
                return False
    return True
