"""Crowds in a plane: what a simulated second costs against the number of walkers.

Walkers of the paper's outline stand at random in a periodic square, 30 % of it covered, and run
freely. The time between a shorter and a longer run counts, so that starting LAMMPS does not: of
the processors, which other load hardly changes, and of the clock.

    python benchmarks/crowds.py [--counts 100 300 1000 3000 5000]

Needs the extra `crowd`. Compare on an idle machine only.
"""

import argparse
import math
import os
import time

import numpy as np

from walkergen.core.dish import Dish
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import crowd, crowd_checks, lammps_input
from walkergen.guests.crowd.space.placing import place_outlines

LENGTH, WIDTH = 28.0, 8.0
PACKING = 0.3
SHORT_S, LONG_S = 0.02, 0.06
"""Simulated times whose difference is measured."""


def card() -> Card:
    """Create a card of the paper's walker with numbers of typical size."""
    x, y = 0.5 * LENGTH, 0.5 * WIDTH
    measured = {
        "speed_mm_s": 56.0,
        "velocity_relaxation_s": 0.02,
        "turning_rad_s": 0.0,
        "rotational_diffusion_rad2_s": 0.5,
        "translational_diffusion_mm2_s": 5.0,
    }
    known = {key: {"value": value} for key, value in measured.items()}
    box = [[-x, -y], [x, -y], [x, y], [-x, y]]
    return Card.model_validate({"name": "box", "mass_g": 0.9, "inertia_g_mm2": 63.6, "outline_mm": [box], **known})


def time_crowd(one: Card, dish: Dish, places: np.ndarray, simulated: float) -> tuple[float, float]:
    """Time of the processors and of the clock in a run, s."""
    started, before = time.perf_counter(), os.times().children_user
    asked = crowd_checks.make_crowd([one], np.zeros(len(places), int), dish, places, simulated, rate_hz=50.0, seed=1)
    crowd.simulate(asked)
    return os.times().children_user - before, time.perf_counter() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--counts", type=int, nargs="+", default=[100, 300, 1000, 3000, 5000])
    arguments = parser.parse_args()
    one = card()
    parts = lammps_input.mechanics([one])
    step = parts.contacts.longest_step
    print(f"{len(parts.discs[0].radii)} discs a body, {1e6 * step:.0f} us a step")
    print(f"{'walkers':>8} {'cpu_s_per_s':>12} {'wall_s_per_s':>13} {'cpu_us_per_walker_step':>23}")
    for count in arguments.counts:
        side = math.sqrt(count * LENGTH * WIDTH / PACKING)
        dish = Dish("periodic", (side,))
        outline = tuple(np.array(contour) for contour in one.outline_mm)
        places = place_outlines([outline] * count, dish, np.random.default_rng(1), 0.3)
        short = time_crowd(one, dish, places, SHORT_S)
        long = time_crowd(one, dish, places, LONG_S)
        cpu, wall = ((b - a) / (LONG_S - SHORT_S) for a, b in zip(short, long, strict=True))
        print(f"{count:8d} {cpu:12.1f} {wall:13.1f} {1e6 * cpu * step / count:23.2f}", flush=True)
    if hasattr(os, "getloadavg"):
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


if __name__ == "__main__":
    main()
