"""How far the models of a walker lie apart, and what each costs: speed against tilt.

    python benchmarks/models.py [--seconds 10] [--runs 8] [--restitution 0.3] [--friction 0.25]

Every model simulates the paper's walker on the paper's plate (90 Hz, 1.8 g). The table gives mean
speeds with their standard errors, impacts per CPU second, and simulated seconds per CPU second.
"""

import argparse
import platform

from walkergen.scene import Scene
from walkergen.simulation import ensemble
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

CASES = (("flexible", "relaxed"), ("flexible", "compliant"), ("braced", "rigid"))
TILTS = (0.0, 5.0, 10.0, 15.0, 20.0, 35.0)


def silent(what: str, done: int, total: int) -> None:
    """Show no progress."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--runs", type=int, default=8)
    parser.add_argument("--restitution", type=float, default=0.3)
    parser.add_argument("--friction", type=float, default=0.25)
    chosen = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    print(f"restitution {chosen.restitution:g}, friction {chosen.friction:g}, law poisson")
    print("tilt  legs      model      speed +- se mm/s  impacts/CPU s  s/CPU s  outcomes")
    for kind, model in CASES:
        for tilt in TILTS:
            design = Design().variant(tilt_deg=tilt, kind=kind)
            mass = solids.mass_of(design)
            scene = Scene.model_validate(
                {
                    "contact": {"restitution": chosen.restitution, "friction": chosen.friction},
                    "legs": {"model": model},
                    "run": {"seconds": chosen.seconds, "runs": chosen.runs},
                }
            )
            plan = prepare(scene, design, mass)
            found, _ = ensemble.measure(plan, silent, threads=1)
            speed = "none" if found.speed_mm_s is None else f"{found.speed_mm_s:8.2f}"
            error = "?" if found.speed_se_mm_s is None else f"{found.speed_se_mm_s:.2f}"
            rate = found.simulated_s / found.cpu_s
            print(
                f"{tilt:4g}  {kind:8s}  {model:9s}  {speed:>9s} +- {error:5s}"
                f"  {found.impacts_per_s * rate:13.3g}  {rate:7.0f}  {found.outcomes}",
                flush=True,
            )


if __name__ == "__main__":
    main()
