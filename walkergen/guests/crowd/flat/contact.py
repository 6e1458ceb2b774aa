"""Contacts of bodies in a plane: spring, dashpot and friction of touching discs.

LAMMPS has no impact law with a fixed restitution for bodies of any shape: its dashpot dissipates more where the struck
point has a small effective mass. The dashpot is set for a point with the mean inverse mass along the outline.
`tests/guests/crowd/test_flat_collisions.py` measures how much the restitution then varies from hit to hit.
"""

import math
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat.discs import Discs, outline_rim
from walkergen.guests.crowd.flat.motion import Motion

TYPICAL_OVERLAP = 0.06
"""Overlap of a typical head-on hit, as a share of the narrowest walker's widest disc's radius."""

STEPS_IN_TOUCH = 12
"""Steps in a contact of two typical points."""

STEPS_IN_DAMPING = 4
"""Minimum number of steps for a contact's dashpot to damp a speed: several discs touch together where faces meet.
With two, as for a restitution of 0.1, one of six dense crowds flew apart; with four none."""

STEPS_IN_MEMORY = 100
"""Minimum number of steps in a relaxation time of the velocity."""

MIN_RESTITUTION, MAX_RESTITUTION = 0.05, 0.98
"""Restitutions that a dashpot gives: below, it would need steps too short; above, it slips."""

TANGENTIAL_DAMPING = 2.0
"""Drag of a contact that sticks, over the root of stiffness and mass: stops sliding in a hit."""


class Contact(NamedTuple):
    """Contact law of two touching discs: stiffness (g/s^2), damping and grip (g/s), friction."""

    stiffness: float
    damping: float
    """Damping force along the normal over the speed of approach."""
    grip: float
    """Drag over the speed of sliding. The drag is at most friction times the normal force."""
    friction: float


class Contacts(NamedTuple):
    """Contacts of kinds of walkers, and the step that resolves them."""

    pairs: dict[tuple[int, int], Contact]
    """Contact between walkers of two kinds, by the indices of the kinds, the smaller first."""
    walls: list[Contact]
    """Contact of each kind with a wall."""
    longest_step: float
    """Longest time step that resolves all contacts, s."""


def restitution(zeta: float) -> float:
    """Return the speed after a hit over the speed before, for a spring and a dashpot that never pull.

    `zeta`: damping over its critical value 2 sqrt(k m). Bodies part when the force is zero (Schwager and Poeschel,
    Granular Matter 9, 465, 2007).
    """
    if abs(zeta - 1.0) < 1e-6:
        return math.exp(-2.0)
    if zeta < 1.0:
        return math.exp(-zeta / math.sqrt(1.0 - zeta**2) * (math.pi - 2.0 * math.asin(zeta)))
    root = math.sqrt(zeta**2 - 1.0)
    return math.exp(-zeta / root * math.log((zeta + root) / (zeta - root)))


def damping_ratio(target: float) -> float:
    """Return the damping over its critical value for a target restitution, clipped to a dashpot's range."""
    target = min(max(target, MIN_RESTITUTION), MAX_RESTITUTION)
    return float(brentq(lambda zeta: restitution(zeta) - target, 0.0, 10.0))


def typical_inverse_mass(card: Card) -> float:
    """Return the mean inverse mass (1/g) that points of a card's outline have for pushes normal to it."""
    edge = outline_rim(card)
    arms = edge.points[:, 0] * edge.inwards[:, 1] - edge.points[:, 1] * edge.inwards[:, 0]
    return float(np.mean(1.0 / card.mass_g + arms**2 / card.inertia_g_mm2))


def contact_laws(cards: Sequence[Card], motions: Sequence[Motion], discs: Sequence[Discs]) -> Contacts:
    """Compute the contacts of all kinds with each other and with walls, and the longest step that resolves them."""
    inverses = [typical_inverse_mass(card) for card in cards]
    overlap = TYPICAL_OVERLAP * min(float(body.radii.max()) for body in discs)
    speed = max(2.0 * _approach_speed(motion) for motion in motions)
    stiffness = 1.0 / min(inverses) * (max(speed, 1.0) / overlap) ** 2
    masses = {(i, j): 1.0 / (inverses[i] + inverses[j]) for i, j in combinations_with_replacement(range(len(cards)), 2)}
    pairs = {
        (i, j): _contact_law(
            stiffness,
            mass,
            math.sqrt(cards[i].restitution * cards[j].restitution),
            math.sqrt(cards[i].friction * cards[j].friction),
        )
        for (i, j), mass in masses.items()
    }
    walls = [
        _contact_law(stiffness, 1.0 / inverse, card.wall_restitution, card.wall_friction)
        for inverse, card in zip(inverses, cards, strict=True)
    ]
    contact_time = math.pi * math.sqrt(min(masses.values()) / stiffness)
    memory = min(min(motion.relaxation, motion.sideways_relaxation, motion.turning_relaxation) for motion in motions)
    damping_time = min(
        *(mass / pairs[kinds].damping for kinds, mass in masses.items()),
        *(1.0 / inverse / wall.damping for inverse, wall in zip(inverses, walls, strict=True)),
    )
    step = min(contact_time / STEPS_IN_TOUCH, damping_time / STEPS_IN_DAMPING, memory / STEPS_IN_MEMORY)
    return Contacts(pairs, walls, step)


def _approach_speed(motion: Motion) -> float:
    """Return the typical speed (mm/s) of a body's point whose distance from C is the radius of gyration."""
    speed, rate = motion.typical_speed_and_turning
    return speed + rate * math.sqrt(motion.inertia / motion.mass)


def _contact_law(stiffness: float, mass: float, target_restitution: float, friction: float) -> Contact:
    """Return the contact that has this stiffness (g/s^2), effective mass (g), restitution and friction."""
    root = math.sqrt(stiffness * mass)
    return Contact(stiffness, 2.0 * damping_ratio(target_restitution) * root, TANGENTIAL_DAMPING * root, friction)
