"""Many at once in LAMMPS: discs without drive are the fluid of hard discs."""

import math

import numpy as np
import pytest
from flat_cards import DISC, card, with_lammps

from walkergen.core.dish import Dish
from walkergen.guests.crowd.flat import crowd, crowd_checks, lammps_input
from walkergen.guests.crowd.space.placing import place_outlines

WIDTH = 8.0
NUMBER = 200


def shells(run, side, edges):
    """Pair distribution g in shells between distances, a mean for each part of the run, (P, S)."""
    areas = math.pi * np.diff(np.square(edges))
    ideal = 0.5 * NUMBER * (NUMBER - 1) * areas / side**2
    first, second = np.triu_indices(NUMBER, 1)
    counts = []
    for frame in run.poses[:, :, :2]:
        apart = frame[first] - frame[second]
        apart -= side * np.round(apart / side)
        counts.append(np.histogram(np.hypot(*apart.T), edges)[0])
    return np.array([np.mean(part, axis=0) for part in np.array_split(counts[50:], 10)]) / ideal


@with_lammps
@pytest.mark.nightly
@pytest.mark.parametrize("packing", [0.2, 0.45])
def test_discs_that_only_diffuse_touch_as_often_as_hard_discs_do(packing):
    """g at contact by Henderson's equation of state of hard discs: (1 - 7 phi/16)/(1 - phi)^2."""
    one = card(
        outline_mm=[DISC],
        speed_mm_s=0.0,
        restitution=0.98,
        friction=0.0,
        inertia_g_mm2=7.2,
        rotational_diffusion_rad2_s=0.0,
        translational_diffusion_mm2_s=50.0,
        velocity_relaxation_s=0.05,
    )
    side = WIDTH * math.sqrt(0.25 * math.pi * NUMBER / packing)
    outlines = [(np.array(DISC),)] * NUMBER
    dish = Dish("periodic", (side,))
    places = place_outlines(outlines, dish, np.random.default_rng(1), 0.2)
    run = crowd.simulate(crowd_checks.make_crowd([one], [0] * NUMBER, dish, places, seconds=12.0, rate_hz=50.0, seed=1))
    # Soft discs are hard ones of the diameter of Barker and Henderson: the mean overlap less
    parts = lammps_input.mechanics([one])
    soft = math.sqrt(0.5 * math.pi * parts.motions[0].heat / parts.contacts.pairs[0, 0].stiffness)
    hard = WIDTH - soft
    filled = packing * (hard / WIDTH) ** 2
    edges = WIDTH * np.linspace(1.0, 1.15, 6)
    middles = 0.5 * (edges[1:] + edges[:-1])
    contact = np.array([np.polyval(np.polyfit(middles - hard, part, 2), 0.0) for part in shells(run, side, edges)])
    error = contact.std(ddof=1) / math.sqrt(len(contact))
    expected = (1.0 - 7.0 * filled / 16.0) / (1.0 - filled) ** 2
    assert error < 0.04 * expected
    assert abs(contact.mean() - expected) < 4.0 * error + 0.01 * expected
