"""Bookkeeping of contacts in a step: springs, energies, and landings with their types.

A landing lasts from the first force to the last. Its type is that of an impact (docs/physics.md
section 3): whether the slip along the heading goes on (I, IV), or stops in compression (III) or in
restitution (II).
"""

from walkergen.numerics.kernels import lean
from walkergen.simulation import record
from walkergen.simulation.space.state import (
    ACROSS,
    ALONG,
    C_N,
    FORCE,
    GAP,
    IN_COMPRESSION,
    IN_RESTITUTION,
    J_A,
    J_C,
    J_N,
    K_N,
    K_T,
    LANDED,
    MIDDLE,
    MODE,
    OFFSET,
    OPEN,
    SET,
    SLIDING,
    SPEED,
    STICK,
    STOP,
    TRIED,
    U_A,
    U_C,
    U_N,
)
from walkergen.theory.impact import II_MIRRORED, III_MIRRORED, TYPE_I, TYPE_II, TYPE_III, TYPE_IV

TYPES_FORWARD = (TYPE_I, TYPE_II, TYPE_III)
TYPES_BACKWARD = (TYPE_IV, II_MIRRORED, III_MIRRORED)
"""Types of landings by the values of STOP, for feet that land sliding forward, and backward."""


@lean
def _land(state, at, t, u_n, u_a, u_c):
    state[at + LANDED], state[at + STOP] = t, SLIDING
    state[at + U_N], state[at + U_A], state[at + U_C] = u_n, u_a, u_c
    state[at + J_N] = state[at + J_A] = state[at + J_C] = 0.0


@lean
def leave(state, at, k, on_plate, tally):
    """Count the landing of contact k that has ended; `at` is the place of its row in the state.

    Impulses are added up for landings `on_plate`, not for touches of a lane's walls.
    """
    stop = int(state[at + STOP])
    kind = TYPES_FORWARD[stop] if state[at + U_A] >= 0.0 else TYPES_BACKWARD[stop]
    record.tally_impact(tally.counts, kind, state[at + MODE] == STICK)
    state[at + MODE] = OPEN
    if on_plate:
        record.add_impulse(tally.sums, kind, state[at + J_N])
    record.note_event(
        tally.events, state[at + LANDED], k, state[at + J_A], state[at + J_N],
        state[at + U_A], state[at + U_N], kind,
    )  # fmt: skip


@lean
def _released(contacts, i, state, at, unloading):
    """Energies (normal, tangential) of the springs of near contact i, which its force leaves."""
    depth = max(-contacts[i, GAP] - state[at + SET], 0.0)
    stretch = state[at + ALONG] * state[at + ALONG] + state[at + ACROSS] * state[at + ACROSS]
    return (0.5 * unloading * contacts[i, K_N] * depth * depth, 0.5 * contacts[i, K_T] * stretch)


@lean
def settle(state, contacts, i, at, unloading, t, h, sums):
    """Move the springs of near contact i over a step of h seconds that ends at t, and book it.

    Its row in the state starts at `at`. Returns True when a landing has ended.
    """
    gap, u_n = contacts[i, GAP], contacts[i, MIDDLE]
    before, mode = int(state[at + MODE]), int(contacts[i, TRIED])
    if mode == OPEN:
        if before != OPEN:
            normal, tangential = _released(contacts, i, state, at, unloading)
            sums[record.IMPACT_LOSS] += normal
            sums[record.FRICTION_LOSS] += tangential
            state[at + ALONG] = state[at + ACROSS] = 0.0
            contacts[i, GAP + 1] = contacts[i, GAP + 2] = 0.0
        contacts[i, GAP] = gap + h * u_n
        if contacts[i, GAP] >= 0.0:
            state[at + SET] = 0.0
        return before != OPEN
    if before == OPEN:
        _land(state, at, t - h, contacts[i, SPEED], contacts[i, SPEED + 1], contacts[i, SPEED + 2])
        normal, _ = _released(contacts, i, state, at, unloading)
        sums[record.IMPACT_LOSS] -= normal
    contacts[i, GAP] = gap + h * u_n
    for axis in range(3):
        state[at + J_N + axis] += h * contacts[i, FORCE + axis]
    if state[at + STOP] == SLIDING and contacts[i, MIDDLE + 1] * state[at + U_A] <= 0.0:
        state[at + STOP] = IN_COMPRESSION if u_n < 0.0 else IN_RESTITUTION
    sums[record.IMPACT_LOSS] += h * contacts[i, C_N] * u_n * u_n
    if unloading > 1.0:
        state[at + SET], lost = _pressed(contacts, i, unloading, state[at + SET])
        sums[record.IMPACT_LOSS] += lost
    sums[record.FRICTION_LOSS] += _rub(contacts, i, h)
    state[at + ALONG], state[at + ACROSS] = contacts[i, GAP + 1], contacts[i, GAP + 2]
    state[at + MODE] = mode
    return False


@lean
def _pressed(contacts, i, unloading, lasting):
    """Lasting compression (mm) of a hysteretic foot after a step, and the energy that it took."""
    lost, after = 1.0 - 1.0 / unloading, contacts[i, GAP]
    if contacts[i, OFFSET] != 0.0 or -after * lost <= lasting:
        return lasting, 0.0
    deepest = lasting / lost
    return -after * lost, 0.5 * lost * contacts[i, K_N] * (after * after - deepest * deepest)


@lean
def _rub(contacts, i, h):
    """Move the tangential springs of a contact; returns the energy that the slider takes."""
    taken = 0.0
    for axis in (1, 2):
        stretch, u = contacts[i, GAP + axis], contacts[i, MIDDLE + axis]
        if contacts[i, TRIED] == STICK:
            contacts[i, GAP + axis] = stretch + h * u
        else:
            # The spring carries the slider's force
            force = contacts[i, FORCE + axis]
            moved = -force / contacts[i, K_T]
            taken -= h * force * u + 0.5 * contacts[i, K_T] * (moved * moved - stretch * stretch)
            contacts[i, GAP + axis] = moved
    return taken
