"""Forces of elastic contacts in one implicit midpoint step (docs/physics.md section 7).

Each contact has a normal spring with a damper, never adhesive, and a tangential spring whose force
a Coulomb slider cuts at friction times the normal force (slider.py). In the middle of the
step f = -k (x + h u / 2) - c u with u = u_free + h H f / 2, so that forces obey
f / b + h H f / 2 = -k x / b - u_free, b = c + h k / 2: one linear system for given modes and
directions of sliding, which are corrected until each contact's force agrees with its mode and
slip. No order of contacts, no iteration between them, no limit on the step from any spring.

A contact that is open when a step begins, and touches in it, acts for its last share s: the mean of
its force over the step is s times that of spring and damper at the middle of the share.
"""

import math

from walkergen.numerics.kernels import lean
from walkergen.simulation.space.slider import dragged
from walkergen.simulation.space.state import (
    B_N,
    B_T,
    C_N,
    END_1,
    END_2,
    FORCE,
    FREE,
    FRICTION,
    GAP,
    K_N,
    K_T,
    MIDDLE,
    MODE,
    NUMBER,
    OFFSET,
    OPEN,
    ROW,
    SET,
    SHARE,
    SLIDE,
    SLIP_1,
    SLIP_2,
    SPEED,
    STICK,
    STIFF,
    TOWARD_1,
    TOWARD_2,
    TRIED,
    UNKNOWN,
)

PASSES = 8
"""Corrections of the modes after which forces are cut to their limits as they are."""

NEAR = 4.0
"""Steps at its speed within which a contact is tried as landing; others that land are seen by
where they end."""

LOCATED, SHORTEST = 0.01, 1e-6
"""Share of a step to which a touch is located, and the share below which it is left out."""

TURNED = 0.02
"""Change of a sliding direction, rad, below which a step is not solved anew."""

JAMMED = 0.25
"""Part of its own compliance 1 / b to which sliding may reduce the equation of a contact: below it
friction presses a foot on faster than the step, and the foot is taken to stick."""


@lean
def resist(contacts, i, h, k_n):
    """Set the normal stiffness of near contact i, and its resistances in a step of h seconds."""
    contacts[i, STIFF], contacts[i, OFFSET], contacts[i, SHARE] = k_n, 0.0, 1.0
    contacts[i, B_N] = contacts[i, C_N] + 0.5 * h * k_n
    contacts[i, B_T] = 0.5 * h * contacts[i, K_T]


@lean
def _touch(contacts, i, h, share):
    """Set the same for contact i, which touches within the step and is closed for its last `share`.

    Its springs are relaxed at touch. Its force is the mean over the whole step.
    """
    contacts[i, STIFF], contacts[i, OFFSET] = share * contacts[i, K_N], -contacts[i, GAP]
    contacts[i, SHARE] = share
    contacts[i, B_N] = share * (contacts[i, C_N] + 0.5 * share * h * contacts[i, K_N])
    contacts[i, B_T] = 0.5 * share * share * h * contacts[i, K_T]


@lean
def _closed_share(contacts, i, u, h):
    """Share of a step of h seconds, up to its end, in which contact i is closed; 0 if it is not.

    It is open at its start and moves at the mean normal velocity u (mm/s) until it touches.
    """
    gap = contacts[i, GAP]
    end = gap + h * u
    return end / (end - gap) if end < 0.0 else 0.0


@lean
def guess(state, contacts, H, m, h, unloading, first):
    """Set first guesses of the modes of m near contacts; returns how many are closed.

    Their velocities in the middle of the step are those expected by the forces of the last one.
    `unloading` is the stiffness of unloading over that of loading, `first` the state's first row.
    """
    closed = 0
    for i in range(m):
        at = first + ROW * int(contacts[i, NUMBER])
        mode = _guess_of(state, contacts, H, i, h, unloading, at)
        contacts[i, TRIED] = mode
        if mode != OPEN:
            closed += 1
    return closed


@lean
def _guess_of(state, contacts, H, i, h, unloading, at):
    """First guess of the mode of contact i, whose row in the state is at `at`."""
    gap = contacts[i, GAP]
    if gap > 0.0:
        share = 0.0
        if gap < NEAR * h * abs(contacts[i, SPEED]):
            share = _closed_share(contacts, i, contacts[i, MIDDLE], h)
        if share == 0.0:
            return OPEN
        _touch(contacts, i, h, share)
    else:
        middle = gap + 0.5 * h * contacts[i, SPEED]
        if middle >= 0.0:
            return OPEN
        if contacts[i, SHARE] != 1.0:
            resist(contacts, i, h, contacts[i, K_N])
        if unloading > 1.0:
            stiff, offset = unloading * contacts[i, K_N], state[at + SET]
            if stiff * (-middle - offset) < -contacts[i, K_N] * middle:
                resist(contacts, i, h, stiff)
                contacts[i, OFFSET] = offset
            else:
                resist(contacts, i, h, contacts[i, K_N])
    press = -contacts[i, STIFF] * (gap + contacts[i, OFFSET])
    press = max(press - contacts[i, B_N] * contacts[i, MIDDLE], 0.0)
    mode = int(state[at + MODE])
    if mode == OPEN:
        t_1 = contacts[i, K_T] * contacts[i, GAP + 1] + contacts[i, B_T] * contacts[i, SPEED + 1]
        t_2 = contacts[i, K_T] * contacts[i, GAP + 2] + contacts[i, B_T] * contacts[i, SPEED + 2]
        limit = contacts[i, FRICTION] * press
        mode = SLIDE if t_1 * t_1 + t_2 * t_2 > limit * limit else STICK
    if mode == STICK:
        return STICK
    aim(contacts, i, contacts[i, MIDDLE + 1], contacts[i, MIDDLE + 2], press, h)
    return STICK if _jams(contacts, H, i, h) else SLIDE


@lean
def aim(contacts, i, u_1, u_2, press, h):
    """Point contact i along its stretch in the middle of its share of the step, and at its end.

    It slips by (u_1, u_2), mm/s, under the normal force `press`. Returns how far the direction in
    the middle has changed.
    """
    share = contacts[i, SHARE]
    radius = contacts[i, FRICTION] * press / (share * contacts[i, K_T])
    n_1, n_2, contacts[i, END_1], contacts[i, END_2] = dragged(
        contacts[i, GAP + 1], contacts[i, GAP + 2], u_1, u_2, 0.5 * share * h, radius
    )
    turned = abs(n_1 - contacts[i, TOWARD_1]) + abs(n_2 - contacts[i, TOWARD_2])
    contacts[i, TOWARD_1], contacts[i, TOWARD_2] = n_1, n_2
    contacts[i, SLIP_1], contacts[i, SLIP_2] = u_1, u_2
    return turned


@lean
def _jams(contacts, H, i, h):
    """True when sliding in the contact's direction would press it on faster than the step."""
    b = 3 * i
    turned = contacts[i, TOWARD_1] * H[b, b + 1] + contacts[i, TOWARD_2] * H[b, b + 2]
    own = 1.0 / contacts[i, B_N]
    return own + 0.5 * h * (H[b, b] - contacts[i, FRICTION] * turned) < JAMMED * own


@lean
def _assemble(contacts, H, A, m, h):
    """Fill the equations of the forces for the modes tried; returns their number."""
    half, count = 0.5 * h, 0
    for i in range(m):
        contacts[i, UNKNOWN] = count
        if contacts[i, TRIED] != OPEN:
            count += 3 if contacts[i, TRIED] == STICK else 1
    for i in range(m):
        if contacts[i, TRIED] == OPEN:
            continue
        for p in range(3 if contacts[i, TRIED] == STICK else 1):
            r, a = 3 * i + p, int(contacts[i, UNKNOWN]) + p
            for j in range(m):
                c, column = 3 * j, int(contacts[j, UNKNOWN])
                if contacts[j, TRIED] == STICK:
                    A[a, column] = half * H[r, c]
                    A[a, column + 1] = half * H[r, c + 1]
                    A[a, column + 2] = half * H[r, c + 2]
                elif contacts[j, TRIED] == SLIDE:
                    turned = (
                        contacts[j, TOWARD_1] * H[r, c + 1] + contacts[j, TOWARD_2] * H[r, c + 2]
                    )
                    A[a, column] = half * (H[r, c] - contacts[j, FRICTION] * turned)
            if p == 0:
                own, pull = (
                    1.0 / contacts[i, B_N],
                    contacts[i, STIFF] * (contacts[i, GAP] + contacts[i, OFFSET]),
                )
            else:
                own, pull = 1.0 / contacts[i, B_T], contacts[i, K_T] * contacts[i, GAP + p]
            A[a, a] += own
            A[a, count] = -pull * own - contacts[i, FREE + p]
    return count


@lean
def _eliminate(A, count):
    """Solve the equations in place by Gauss' elimination; the last column holds the unknowns."""
    for i in range(count):
        inverse = 1.0 / A[i, i]
        for j in range(i + 1, count):
            factor = A[j, i] * inverse
            if factor != 0.0:
                for c in range(i + 1, count + 1):
                    A[j, c] -= factor * A[i, c]
    for i in range(count - 1, -1, -1):
        total = A[i, count]
        for c in range(i + 1, count):
            total -= A[i, c] * A[c, count]
        A[i, count] = total / A[i, i]


@lean
def _spread(contacts, A, m, count):
    """Set the forces from the unknowns; contacts that would pull are opened: their number."""
    pulling = 0
    for i in range(m):
        contacts[i, FORCE] = contacts[i, FORCE + 1] = contacts[i, FORCE + 2] = 0.0
        if contacts[i, TRIED] == OPEN:
            continue
        c = int(contacts[i, UNKNOWN])
        press = A[c, count]
        if not press > 0.0:
            contacts[i, TRIED] = OPEN
            pulling += 1
            continue
        contacts[i, FORCE] = press
        if contacts[i, TRIED] == STICK:
            contacts[i, FORCE + 1], contacts[i, FORCE + 2] = A[c + 1, count], A[c + 2, count]
        else:
            rub = contacts[i, FRICTION] * press
            contacts[i, FORCE + 1], contacts[i, FORCE + 2] = (
                -rub * contacts[i, TOWARD_1],
                -rub * contacts[i, TOWARD_2],
            )
    return pulling


@lean
def _move(contacts, H, m, h):
    """Set the velocities in the middle of the step, from the forces."""
    for j in range(m):
        for p in range(3):
            total, r = 0.0, 3 * j + p
            for i in range(m):
                if contacts[i, TRIED] != OPEN:
                    c = 3 * i
                    total += (
                        H[r, c] * contacts[i, FORCE]
                        + H[r, c + 1] * contacts[i, FORCE + 1]
                        + H[r, c + 2] * contacts[i, FORCE + 2]
                    )
            contacts[j, MIDDLE + p] = contacts[j, FREE + p] + 0.5 * h * total


@lean
def _correct(contacts, H, m, h):
    """Change modes and directions that the forces contradict; returns how many."""
    changed = 0
    for i in range(m):
        if contacts[i, GAP] > 0.0 and _landing_changes(contacts, H, i, h):
            changed += 1
            continue
        press = contacts[i, FORCE]
        limit = contacts[i, FRICTION] * press
        if contacts[i, TRIED] == STICK:
            size = math.sqrt(contacts[i, FORCE + 1] ** 2 + contacts[i, FORCE + 2] ** 2)
            if size > limit:
                aim(contacts, i, contacts[i, MIDDLE + 1], contacts[i, MIDDLE + 2], press, h)
                if not _jams(contacts, H, i, h):
                    contacts[i, TRIED] = SLIDE
                    changed += 1
        elif contacts[i, TRIED] == SLIDE:
            u_1, u_2 = contacts[i, MIDDLE + 1], contacts[i, MIDDLE + 2]
            # where its own stretch, moved along, is short of the limit, it sticks
            share = contacts[i, SHARE]
            t_1 = share * contacts[i, K_T] * contacts[i, GAP + 1] + contacts[i, B_T] * u_1
            t_2 = share * contacts[i, K_T] * contacts[i, GAP + 2] + contacts[i, B_T] * u_2
            if t_1 * t_1 + t_2 * t_2 < limit * limit:
                contacts[i, TRIED] = STICK
                changed += 1
            elif (
                abs(u_1 - contacts[i, SLIP_1]) + abs(u_2 - contacts[i, SLIP_2])
                > TURNED * (abs(u_1) + abs(u_2))
                and aim(contacts, i, u_1, u_2, press, h) > TURNED
            ):
                changed += 1
    return changed


@lean
def _landing_changes(contacts, H, i, h):
    """Locate the touch of contact i, open when the step began, anew; True if that changes it."""
    r, u = 3 * i, contacts[i, MIDDLE]
    if contacts[i, TRIED] == OPEN:
        share = _closed_share(contacts, i, u, h)
        if share < SHORTEST:
            return False
        _touch(contacts, i, h, share)
        contacts[i, TRIED] = STICK
        return True
    # the velocity until it touches: without its own force
    for p in range(3):
        u -= 0.5 * h * H[r, r + p] * contacts[i, FORCE + p]
    share = _closed_share(contacts, i, u, h)
    if share < SHORTEST:
        contacts[i, TRIED] = OPEN
        return True
    if abs(share - contacts[i, SHARE]) < LOCATED:
        return False
    _touch(contacts, i, h, share)
    return True


@lean
def _cut(contacts, m, h):
    """Cut forces to the friction cone, where modes found no agreement or a foot jams."""
    cut = False
    for i in range(m):
        limit = contacts[i, FRICTION] * contacts[i, FORCE]
        if contacts[i, TRIED] == STICK:
            size = math.sqrt(contacts[i, FORCE + 1] ** 2 + contacts[i, FORCE + 2] ** 2)
            if size > limit:
                cut = True
                contacts[i, TRIED] = SLIDE
                u_1, u_2 = contacts[i, MIDDLE + 1], contacts[i, MIDDLE + 2]
                aim(contacts, i, u_1, u_2, contacts[i, FORCE], h)
                contacts[i, FORCE + 1] *= limit / size
                contacts[i, FORCE + 2] *= limit / size
    return cut


@lean
def solve(contacts, H, A, m, h):
    """Set forces and mid-step velocities of m near contacts for a step of h seconds."""
    for _ in range(PASSES):
        count = _assemble(contacts, H, A, m, h)
        _eliminate(A, count)
        if _spread(contacts, A, m, count) > 0:
            continue
        _move(contacts, H, m, h)
        if _correct(contacts, H, m, h) == 0:
            break
    if _cut(contacts, m, h):
        _move(contacts, H, m, h)
