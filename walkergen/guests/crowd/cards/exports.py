"""Inputs for other programs: a card's numbers above script templates from the assets.

The pymunk script has every number of the card. The HOOMD-blue script has no friction and one temperature. LAMMPS reads
the numbers as variables of the user's own script.
"""

import math
from collections.abc import Mapping
from pathlib import Path

from walkergen.guests.crowd.cards.card import Card

CARD_PLACEHOLDER = "#CARD#"
"""Line of a script that the numbers replace."""

SCRIPTS = {"crowd_pymunk.py": "pymunk.txt", "crowd_hoomd.py": "hoomd.txt"}
"""Scripts by the names of their files, and the assets that they are made of."""


def input_files(card: Card) -> dict[str, bytes]:
    """Write the inputs of each program, by the names of their files; equal cards give equal bytes."""
    numbers = model_parameters(card)
    lines = [f"# {card.name}, {card.scene or 'no scene'}: mm, g, s, rad"]
    lines += [f"{name} = {_format_number(value)}" for name, value in numbers.items()]
    corners = [
        "[" + ", ".join(f"({_format_number(x)}, {_format_number(y)})" for x, y in contour) + "]"
        for contour in card.outline_mm
    ]
    lines.append(f"OUTLINE = [{', '.join(corners)}]")
    head, assets = "\n".join(lines), Path(__file__).with_name("assets")
    made = {
        name: assets.joinpath(asset).read_text(encoding="utf-8").replace(CARD_PLACEHOLDER, head).encode()
        for name, asset in SCRIPTS.items()
    }
    return made | {"card.lammps": _lammps_variables(card, numbers).encode()}


def model_parameters(card: Card) -> dict[str, float]:
    """Return the parameters of a flat model by the names of the scripts; unmeasured ones are 0."""
    late, sd, aside = card.turning_relaxation_s, card.turning_sd_rad_s, card.sideways_relaxation_s
    return {
        "MASS": card.mass_g,
        "INERTIA": card.inertia_g_mm2,
        "PROPULSION": card.propulsion_mm_s,
        "RELAXATION": card.velocity_relaxation_s.number,
        "SIDEWAYS_RELAXATION": (card.velocity_relaxation_s if aside is None else aside).number,
        "DIFFUSION": card.translational_diffusion_mm2_s.number,
        "TURNING": card.turning_rad_s.number,
        "TURNING_SD": 0.0 if sd is None else sd.number,
        "TURNING_RELAXATION": 0.0 if late is None else late.number,
        "ROTATION": card.rotational_diffusion_rad2_s.number,
        "RESTITUTION": card.restitution,
        "FRICTION": card.friction,
        "WALL_RESTITUTION": card.wall_restitution,
        "WALL_FRICTION": card.wall_friction,
    }


def _lammps_variables(card: Card, numbers: Mapping[str, float]) -> str:
    """Variables of LAMMPS: `include card.lammps` in a script, then ${propulsion} and so on."""
    time = max(card.velocity_relaxation_s.number, 1e-3)
    drag, spread = card.mass_g / time, math.sqrt(numbers["DIFFUSION"] / time)
    more = {"DRAG": drag, "THRUST": drag * card.propulsion_mm_s, "VELOCITY_SD": spread}
    lines = [
        f"# {card.name}, {card.scene or 'no scene'}: numbers of a walker, mm, g, s, rad",
        "# thrust = drag * propulsion (fix propel/self), velocity_sd of each axis (fix langevin)",
        *(f"variable {name.lower()} equal {_format_number(value)}" for name, value in {**numbers, **more}.items()),
    ]
    return "\n".join(lines) + "\n"


def _format_number(value: float) -> str:
    """Format a number with every digit that distinguishes it from others."""
    return repr(float(value))
