"""Forces of elastic contacts in one implicit midpoint step (docs/physics.md section 7).

Each contact has a normal spring with a damper, never adhesive, and a tangential spring whose force a Coulomb slider
cuts at friction times the normal force (tips.py). In the middle of the step f = -k (x + h u / 2) - c u with u = u_free
+ h H f / 2, so that forces obey f + b h H f / 2 = -k x - b u_free, b = c + h k / 2: one linear system for given modes
and directions of sliding, which are corrected until each contact's force agrees with its mode and slip. No order of
contacts, no iteration between them, no limit on the step from any spring.

A contact that is open when a step begins, and touches in it, acts for its last share s: the mean of its force over the
step is s times that of spring and damper at the middle of the share.

`near` lists the contacts near a surface (`NEAR_DTYPE` of state.py), of which the first m are in use. H is the inverse
mass at these contacts (1/g), A memory for the equations, h the length of a step (s).
"""

import math

from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation.space.state import MODE, OPEN, ROW_LENGTH, SHEAR, SLIDE, STICK
from walkergen.core.simulation.space.tips import response, stretch_directions

MAX_CORRECTIONS = 8
"""Largest number of corrections of the modes; then forces are cut to their limits."""

TANGENT_TOLERANCE = 0.2
"""Four times the allowed error of a tip spring's tangent, as a share of the normal force: F''/2 is k / (4 d)."""

MIN_DEPTH_RATIO = 1e-3
"""Least depth about which a tip's spring is linearised, of the depths that a contact passes in a step."""

NEAR_STEPS = 4.0
"""Steps at its speed within which a contact is tried as landing; others that land are seen by where they end."""

TOUCH_TOLERANCE, MIN_CLOSED_SHARE = 0.01, 1e-6
"""Error of a touch's time as a share of a step, and the share below which the touch is left out."""

DIRECTION_TOLERANCE_RAD = 0.06
"""Change of a sliding direction, rad, below which a step is not solved again."""

JAM_RATIO = 0.25
"""Share of its own force that sliding must leave in a contact's equation: below it friction presses a foot on
faster than the step, and the foot counts as sticking."""


@lean
def _linearise(near, i, h, depth):
    """Set the tangent of the normal spring of contact i at a depth (mm) in the middle of its share of the step.

    The force in the middle is then F(depth) + k_n (depth' - depth), at the depth' that the step finds.
    """
    contact = near[i]
    depth = max(depth, MIN_DEPTH_RATIO * (abs(contact.gap[0]) + h * abs(contact.speed[0])) + 1e-300)
    force, k_n, viscous = response(contact.spring, contact.tip, depth)
    share = contact.share
    # Eq. 7.8: the damper of the contact
    contact.about, contact.k_n, contact.c_n = depth, k_n, contact.damper * math.sqrt(viscous)
    contact.push = force
    contact.b_n = share * (contact.c_n + 0.5 * share * h * k_n)  # eq. 7.11: b = c + h k / 2


@lean
def _depth_in_middle(near, i, h):
    """Return the depth (mm) of contact i in the middle of its share of a step of h seconds."""
    return max(-near[i].gap[0], 0.0) - 0.5 * near[i].share * h * near[i].middle[0]


@lean
def _push_at_start(near, i):
    """Return contact i's linearized normal force (g mm/s^2) at the depth where its share of the step begins."""
    contact = near[i]
    return contact.share * (contact.push + contact.k_n * (max(-contact.gap[0], 0.0) - contact.about))


@lean
def _set_closed_springs(near, i, h, old_stiffness):
    """Set stiffness and resistances of near contact i, closed in the whole step of h seconds.

    Its tangential spring, so far of stiffness `old_stiffness` (g/s^2), follows the normal one (Mindlin). Pressed on it
    keeps its force, relieved it keeps its stretch, so that it never gains energy.
    """
    near[i].share = 1.0
    _linearise(near, i, h, _depth_in_middle(near, i, h))
    near[i].k_t = near[i].shear * near[i].k_n
    near[i].b_t = 0.5 * h * near[i].k_t
    e_1, e_2 = near[i].gap[1], near[i].gap[2]
    near[i].strain = 0.5 * old_stiffness * (e_1 * e_1 + e_2 * e_2)
    # After eq. 7.9: a stiffer spring keeps its force, a softer one its stretch
    if near[i].k_t > old_stiffness:
        near[i].gap[1], near[i].gap[2] = e_1 * old_stiffness / near[i].k_t, e_2 * old_stiffness / near[i].k_t


@lean
def _set_touch_springs(near, i, h, share):
    """Set stiffness and resistances of contact i, which touches within the step and is closed for its last `share`.

    The contact's springs are relaxed at touch. Its force is the mean over the whole step.
    """
    near[i].share, near[i].strain = share, 0.0
    _linearise(near, i, h, _depth_in_middle(near, i, h))
    near[i].k_t = near[i].shear * near[i].k_n
    near[i].b_t = 0.5 * share * share * h * near[i].k_t


@lean
def _closed_share(near, i, u, h):
    """Compute the share of a step of h seconds, up to its end, with contact i closed; 0 if it stays open.

    The contact is open at the step's start and moves at the mean normal velocity u (mm/s) until it touches.
    """
    gap = near[i].gap[0]
    end = gap + h * u
    return end / (end - gap) if end < 0.0 else 0.0


@lean
def guess_modes(state, near, H, m, h, first):
    """Set first guesses of the modes of m near contacts in a step of h seconds. Return how many are closed.

    The contacts' velocities in the middle of the step are those that the forces of the previous step would give.
    `first` is the index of the first contact's row in the state.
    """
    closed = 0
    for i in range(m):
        at = first + ROW_LENGTH * near[i].number
        mode = _guess_mode(state, near, H, i, h, at)
        near[i].tried = mode
        if mode != OPEN:
            closed += 1
    return closed


@lean
def _guess_mode(state, near, H, i, h, at):
    """Guess the mode of contact i in a step of h seconds; the contact's row in the state starts at `at`."""
    gap = near[i].gap[0]
    if gap > 0.0:
        share = 0.0
        if gap < NEAR_STEPS * h * abs(near[i].speed[0]):
            share = _closed_share(near, i, near[i].middle[0], h)
        if share == 0.0:
            return OPEN
        _set_touch_springs(near, i, h, share)
    else:
        if gap + 0.5 * h * near[i].speed[0] >= 0.0:
            return OPEN
        _set_closed_springs(near, i, h, state[at + SHEAR])
    press = max(_push_at_start(near, i) - near[i].b_n * near[i].middle[0], 0.0)
    mode = int(state[at + MODE])
    if mode == OPEN:
        t_1 = near[i].k_t * near[i].gap[1] + near[i].b_t * near[i].speed[1]
        t_2 = near[i].k_t * near[i].gap[2] + near[i].b_t * near[i].speed[2]
        limit = near[i].friction * press
        mode = SLIDE if t_1 * t_1 + t_2 * t_2 > limit * limit else STICK
    if mode == STICK:
        return STICK
    set_sliding_directions(near, i, near[i].middle[1], near[i].middle[2], press, h)
    return STICK if _jams(near, H, i, h) else SLIDE


@lean
def set_sliding_directions(near, i, u_1, u_2, press, h):
    """Set the sliding directions of contact i in the middle of its share of the step, and at the step's end.

    The contact slips by (u_1, u_2), mm/s, under the normal force `press`, g mm/s^2, in a step of h seconds. Returns
    how far the direction in the middle has changed, rad.
    """
    share = near[i].share
    radius = near[i].friction * press / (share * near[i].k_t)
    # Eq. 7.10 in the middle of the share and at its end
    n_1, n_2, near[i].end[0], near[i].end[1] = stretch_directions(
        near[i].gap[1], near[i].gap[2], u_1, u_2, 0.5 * share * h, radius
    )
    turned = abs(n_1 - near[i].toward[0]) + abs(n_2 - near[i].toward[1])
    near[i].toward[0], near[i].toward[1] = n_1, n_2
    near[i].slip[0], near[i].slip[1] = u_1, u_2
    return turned


@lean
def _jams(near, H, i, h):
    """Return whether the friction of sliding contact i would press it on faster than a step can follow."""
    b = 3 * i
    turned = near[i].toward[0] * H[b, b + 1] + near[i].toward[1] * H[b, b + 2]
    return 1.0 + 0.5 * h * near[i].b_n * (H[b, b] - near[i].friction * turned) < JAM_RATIO


@lean
def _assemble(near, H, A, m, h):
    """Fill A with the equations of the forces of m contacts in their modes `tried`. Return the number of equations.

    A's first `count` columns are the matrix, the next one is the right-hand side. A contact has three equations if it
    sticks, one (the normal force) if it slides, none if it is open.
    """
    count = 0
    for i in range(m):
        near[i].unknown = count
        if near[i].tried != OPEN:
            count += 3 if near[i].tried == STICK else 1
    for i in range(m):
        if near[i].tried == OPEN:
            continue
        for p in range(3 if near[i].tried == STICK else 1):
            r, a = 3 * i + p, near[i].unknown + p
            if p == 0:
                b, pull = near[i].b_n, -_push_at_start(near, i)
            else:
                b, pull = near[i].b_t, near[i].k_t * near[i].gap[p]
            half = 0.5 * h * b  # eq. 7.11: (1 + b h W / 2) f = F_0 - b u_free
            for j in range(m):
                c, column = 3 * j, near[j].unknown
                if near[j].tried == STICK:
                    A[a, column] = half * H[r, c]
                    A[a, column + 1] = half * H[r, c + 1]
                    A[a, column + 2] = half * H[r, c + 2]
                elif near[j].tried == SLIDE:
                    turned = near[j].toward[0] * H[r, c + 1] + near[j].toward[1] * H[r, c + 2]
                    A[a, column] = half * (H[r, c] - near[j].friction * turned)
            A[a, a] += 1.0
            A[a, count] = -pull - b * near[i].free[p]
    return count


@lean
def _eliminate(A, count):
    """Solve `count` equations in place by Gauss' elimination. The last column of A then holds the unknowns."""
    for i in range(count):
        inverse = A[i, i] = 1.0 / A[i, i]
        for j in range(i + 1, count):
            factor = A[j, i] * inverse
            if factor != 0.0:
                for c in range(i + 1, count + 1):
                    A[j, c] -= factor * A[i, c]
    for i in range(count - 1, -1, -1):
        total = A[i, count]
        for c in range(i + 1, count):
            total -= A[i, c] * A[c, count]
        A[i, count] = total * A[i, i]


@lean
def _set_forces(near, A, m, count):
    """Set the forces of m contacts from the `count` unknowns in A. Open those that would pull and return how many."""
    pulling = 0
    for i in range(m):
        near[i].force[0] = near[i].force[1] = near[i].force[2] = 0.0
        if near[i].tried == OPEN:
            continue
        c = near[i].unknown
        press = A[c, count]
        if not press > 0.0:
            near[i].tried = OPEN
            pulling += 1
            continue
        near[i].force[0] = press
        if near[i].tried == STICK:
            near[i].force[1], near[i].force[2] = A[c + 1, count], A[c + 2, count]
        else:
            rub = near[i].friction * press
            near[i].force[1], near[i].force[2] = (-rub * near[i].toward[0], -rub * near[i].toward[1])
    return pulling


@lean
def _set_velocities(near, H, m, h):
    """Set the velocities (`middle`) of m contacts in the middle of the step, from their forces."""
    for j in range(m):
        for p in range(3):
            total, r = 0.0, 3 * j + p
            for i in range(m):
                if near[i].tried != OPEN:
                    c = 3 * i
                    total += (
                        H[r, c] * near[i].force[0] + H[r, c + 1] * near[i].force[1] + H[r, c + 2] * near[i].force[2]
                    )
            near[j].middle[p] = near[j].free[p] + 0.5 * h * total  # implicit midpoint: u = u_free + h W f / 2


@lean
def _correct(near, H, m, h):
    """Correct modes, directions and linearized springs that contradict the forces. Return the number of corrections."""
    changed = 0
    for i in range(m):
        if near[i].gap[0] > 0.0 and _landing_changes(near, H, i, h):
            changed += 1
            continue
        if near[i].tried != OPEN and near[i].tip != math.inf:
            depth = _depth_in_middle(near, i, h)
            depth_error = depth - near[i].about
            if near[i].k_n * depth_error * depth_error > TANGENT_TOLERANCE * near[i].about * near[i].force[0]:
                _linearise(near, i, h, depth)
                changed += 1
        press = near[i].force[0]
        limit = near[i].friction * press  # Coulomb's cone
        if near[i].tried == STICK:
            size = math.sqrt(near[i].force[1] ** 2 + near[i].force[2] ** 2)
            if size > limit:
                set_sliding_directions(near, i, near[i].middle[1], near[i].middle[2], press, h)
                if not _jams(near, H, i, h):
                    near[i].tried = SLIDE
                    changed += 1
        elif near[i].tried == SLIDE:
            u_1, u_2 = near[i].middle[1], near[i].middle[2]
            # where its own stretch, moved along, is short of the limit, it sticks
            share = near[i].share
            t_1 = share * near[i].k_t * near[i].gap[1] + near[i].b_t * u_1
            t_2 = share * near[i].k_t * near[i].gap[2] + near[i].b_t * u_2
            if t_1 * t_1 + t_2 * t_2 < limit * limit:
                near[i].tried = STICK
                changed += 1
            elif (
                abs(u_1 - near[i].slip[0]) + abs(u_2 - near[i].slip[1])
                > DIRECTION_TOLERANCE_RAD * (abs(u_1) + abs(u_2))
                and set_sliding_directions(near, i, u_1, u_2, press, h) > DIRECTION_TOLERANCE_RAD
            ):
                changed += 1
    return changed


@lean
def _landing_changes(near, H, i, h):
    """Correct when contact i, open at the start of the step, touches. Return whether its mode or share changes."""
    r, u = 3 * i, near[i].middle[0]
    if near[i].tried == OPEN:
        share = _closed_share(near, i, u, h)
        if share < MIN_CLOSED_SHARE:
            return False
        _set_touch_springs(near, i, h, share)
        near[i].tried = STICK
        return True
    # the velocity until it touches: without its own force
    for p in range(3):
        u -= 0.5 * h * H[r, r + p] * near[i].force[p]
    share = _closed_share(near, i, u, h)
    if share < MIN_CLOSED_SHARE:
        near[i].tried = OPEN
        return True
    if abs(share - near[i].share) < TOUCH_TOLERANCE:
        return False
    _set_touch_springs(near, i, h, share)
    return True


@lean
def _limit_to_cone(near, m, h):
    """Limit forces of sticking contacts to the friction cone if corrections failed. Return whether any was limited."""
    cut = False
    for i in range(m):
        limit = near[i].friction * near[i].force[0]
        if near[i].tried == STICK:
            size = math.sqrt(near[i].force[1] ** 2 + near[i].force[2] ** 2)
            if size > limit:
                cut = True
                near[i].tried = SLIDE
                u_1, u_2 = near[i].middle[1], near[i].middle[2]
                set_sliding_directions(near, i, u_1, u_2, near[i].force[0], h)
                near[i].force[1] *= limit / size
                near[i].force[2] *= limit / size
    return cut


@lean
def solve(near, H, A, m, h):
    """Set the forces and mid-step velocities of the m contacts in `near` for a step of h seconds.

    H is their inverse mass, A memory for the linear system.
    """
    for _ in range(MAX_CORRECTIONS):
        count = _assemble(near, H, A, m, h)
        _eliminate(A, count)
        if _set_forces(near, A, m, count) > 0:
            continue
        _set_velocities(near, H, m, h)
        if _correct(near, H, m, h) == 0:
            break
    if _limit_to_cone(near, m, h):
        _set_velocities(near, H, m, h)
