"""What a million predicted speeds cost: walkergen's arrays against the ways one would otherwise go.

A triple is a design (masses, inertias and vectors of its own), a restitution and a friction; the
answer is the mean stationary factor of its two feet. walkergen works in chunks on one core, so
that its memory does not grow with the number of triples. The rivals solve a sample, drawn the
same way, and their time is scaled to a million:

- root: the impact itself, with the speed at which it gives no horizontal impulse bracketed
  by scipy's brentq; knows no closed form;
- loop: one triple at a time as one writes it from the paper, 2x2 matrices of numpy and eq. 15,
  or the general form where feet may stick;
- calls: `theory.speed.factors` called once a triple.

    python benchmarks/predictions.py [--repeats 5] [--rivals root,loop,calls]
"""

import argparse
import os
import platform
import resource
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from walkergen.core.theory import speed, tensors
from walkergen.core.theory.impact import resolve
from walkergen.core.theory.speed import MODES, Mode
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import LegMass, MassProperties, scale_masses
from walkergen.files import templates

Array = npt.NDArray[np.float64]
Triples = tuple[MassProperties, Array, Array]
"""Designs, restitutions and frictions, each with a leading axis of the same length."""

VARYING = ("m", "j", "anchor", "c_A", "c_T")
"""What of a leg differs from walker to walker."""
SEED = 2016
AGREEMENT = 1e-9  # of a factor, relative to 1 + |factor|: what the rivals themselves resolve


def shelf() -> MassProperties:
    """181 flexible walkers of koumakis2016, 0..45 deg: solids built and weighed, then stacked."""
    paper = templates.load("koumakis2016", "walkers", Design)
    designs = [paper.variant(tilt_deg=0.25 * step, kind="flexible") for step in range(181)]
    weighed = [solids.mass_of(design) for design in designs]
    legs = [
        LegMass(*(np.array([getattr(leg, name) for leg in alike]) for name in VARYING))
        for alike in zip(*(mass.legs for mass in weighed), strict=True)
    ]
    M, J = (np.array(values) for values in zip(*((mass.M, mass.J) for mass in weighed), strict=True))
    return MassProperties(M, J, tuple(legs), rigid=False)


def pick_walkers(walkers: MassProperties, pick: int | npt.NDArray[np.int64]) -> MassProperties:
    """Walkers of the shelf at these places of the leading axis."""
    M, J = np.asarray(walkers.M)[pick], np.asarray(walkers.J)[pick]
    legs = [LegMass(*(getattr(leg, name)[pick] for name in VARYING)) for leg in walkers.legs]
    return MassProperties(M, J, tuple(legs), rigid=False)


def draw(rng: np.random.Generator, walkers: MassProperties, count: int) -> Triples:
    """Random walkers of the shelf, printed 2 % too heavy or light, on random plates."""
    pick = rng.integers(len(walkers.legs[0].anchor), size=count)
    body, leg = rng.normal(1.0, 0.02, (2, count))
    e, mu = rng.uniform(0.0, 1.0, count), rng.uniform(0.01, 0.6, count)
    return scale_masses(pick_walkers(walkers, pick), body, leg), e, mu


def chunks(walkers: MassProperties, total: int, size: int) -> Iterator[Triples]:
    rng = np.random.default_rng(SEED)
    for start in range(0, total, size):
        yield draw(rng, walkers, min(size, total - start))


def with_arrays(triples: Triples, mode: Mode) -> Array:
    return speed.factors(*triples, mode).mean


def each(triples: Triples) -> Iterator[Triples]:
    mass, e, mu = triples
    for k in range(len(e)):
        yield pick_walkers(mass, k), e[k], mu[k]


def with_calls(triples: Triples, mode: Mode) -> Array:
    return np.array([float(speed.factors(*one, mode).mean) for one in each(triples)])


def with_roots(triples: Triples, mode: Mode) -> Array | None:
    """Stationary speeds from nothing but impacts. The tensors come from walkergen's arrays."""
    from scipy.optimize import brentq

    if mode == "paper":
        return None  # eq. 15's reversal in any case is not what an impact does
    mass, e, mu = triples
    found = np.zeros((2, len(e)))
    for foot, H in enumerate(tensors.foot_tensors(mass)):
        entries = np.column_stack([H.xx, H.xy, H.yy, e, mu]).tolist()
        for k, (xx, xy, yy, restitution, friction) in enumerate(entries):

            def impulse(v_x: float, *a: float) -> float:
                return resolve((a[0], a[1], a[2]), (v_x, -1.0), a[3], a[4]).F_x

            # Beyond this speed the foot slides on throughout; at 0 friction only pushes it on.
            bound = -np.copysign(4.0 * (friction * xx + abs(xy)) / yy, xy)
            found[foot, k] = brentq(impulse, 0.0, bound, (xx, xy, yy, restitution, friction), xtol=1e-14, rtol=1e-14)
    return found.mean(axis=0)


def with_loop(triples: Triples, mode: Mode) -> Array:
    """One triple after the other with the paper's matrices (eqs 8-12) and closed forms."""
    found = []
    for mass, e, mu in each(triples):
        both = 0.0
        for leg in mass.legs:
            H = paper_tensor(mass, leg)
            both += closed_form(H[0, 0], H[0, 1], H[1, 1], e, mu, mode)
        found.append(0.5 * both)
    return np.array(found)


def paper_tensor(mass: MassProperties, leg: LegMass) -> Array:
    """H = I/m + P(c_T)/j - R^T K^-1 R, as published (docs/physics.md section 2)."""

    def perp(u: Array) -> Array:
        return np.array([-u[1], u[0]])

    a, c_A, c_T, identity = perp(leg.anchor), perp(leg.c_A), perp(leg.c_T), np.eye(2)
    body = identity / mass.M + np.outer(a, a) / mass.J
    K = body + identity / leg.m + np.outer(c_A, c_A) / leg.j
    R = identity / leg.m - np.outer(c_A, c_T) / leg.j
    H: Array = identity / leg.m + np.outer(c_T, c_T) / leg.j - R.T @ np.linalg.solve(K, R)
    return H


def closed_form(xx: float, xy: float, yy: float, e: float, mu: float, mode: Mode) -> float:
    """Compute the stationary factor (docs/physics.md section 4)."""
    ratio = mu if mode == "paper" else min(mu, abs(xy) / xx)
    top = (1 + e) * ratio / (mu + ratio) * (mu * xx + abs(xy))
    return float(-np.sign(xy) * top / (yy + e * ratio * abs(xy)))


Way = Callable[[Triples, Mode], Array | None]
RIVALS: dict[str, tuple[Way, int]] = {
    "root": (with_roots, 2000),
    "loop": (with_loop, 2000),
    "calls": (with_calls, 2000),
}


def measure(walkers: MassProperties, mode: Mode, total: int, size: int) -> float:
    """Seconds for all triples in chunks; drawing them is not counted."""
    seconds = 0.0
    for triples in chunks(walkers, total, size):
        started = time.perf_counter()
        with_arrays(triples, mode)
        seconds += time.perf_counter() - started
    return seconds


def peak_memory() -> float:
    """Largest resident set of this process so far, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)


def machine() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    cpu = names[0] if names else platform.processor()
    return (
        f"{cpu}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}, "
        f"Python {platform.python_version()}, numpy {np.__version__}"
    )


def compare(walkers: MassProperties, rivals: list[str], options: argparse.Namespace) -> bool:
    """Print a row for every mode and way; True when all ways gave the same factors."""
    per_million = 1e6 / options.triples
    print(f"{'mode':<9}{'way':<11}{'triples':>9}{'s/million':>11}{'least..most':>18}{'ratio':>9}{'difference':>12}")
    agree = True
    for mode in MODES:
        times = [per_million * measure(walkers, mode, options.triples, options.chunk) for _ in range(options.repeats)]
        reference = statistics.median(times)
        print(row(mode, "walkergen", options.triples, times, 1.0))
        for name in rivals:
            way, count = RIVALS[name]
            sample = draw(np.random.default_rng(SEED), walkers, count)
            if way(draw(np.random.default_rng(0), walkers, 10), mode) is None:
                continue
            times = []
            for _ in range(options.repeats):
                started = time.perf_counter()
                found = way(sample, mode)
                times.append(1e6 / count * (time.perf_counter() - started))
            known = with_arrays(sample, mode)
            apart = float(np.max(np.abs(found - known) / (1.0 + np.abs(known))))
            agree &= apart <= AGREEMENT
            ratio = statistics.median(times) / reference
            print(f"{row(mode, name, count, times, ratio)}{apart:>12.1e}")
    return agree


def row(mode: str, way: str, count: int, times: list[float], ratio: float) -> str:
    spread = f"{min(times):.3g}..{max(times):.3g}"
    median = statistics.median(times)
    return f"{mode:<9}{way:<11}{count:>9}{median:>11.4g}{spread:>18}{ratio:>9.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=5, help="medians of this many runs")
    parser.add_argument("--triples", type=int, default=1_000_000)
    parser.add_argument("--chunk", type=int, default=8192, help="triples at a time")
    parser.add_argument("--rivals", default=",".join(RIVALS), help="comma-separated")
    options = parser.parse_args()
    rivals = [name for name in options.rivals.split(",") if name]
    for name in rivals:
        if name not in RIVALS:
            parser.error(f"--rivals {name!r}: choose from {', '.join(RIVALS)}")
    if hasattr(os, "sched_setaffinity"):  # Linux: one core for certain
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    print(machine())
    walkers = shelf()
    measure(walkers, "coulomb", options.chunk, options.chunk)
    before = peak_memory()
    measure(walkers, "coulomb", options.triples, options.chunk)
    grown = peak_memory() - before
    print(
        f"memory: peak {before:.1f} MB after the first {options.chunk} triples, "
        f"{grown:.1f} MB more after {options.triples}"
    )
    if not compare(walkers, rivals, options):
        raise SystemExit(f"the ways disagree: a factor is more than {AGREEMENT:g} apart")


if __name__ == "__main__":
    main()
