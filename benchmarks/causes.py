"""Which single cause would bring what the paper saw and the model in space does not show?

Four facts of the paper stay open (docs/causes.md): a walker of 35 deg turns from superdiffusive to
diffusive at about 1 s; the speed at 15 deg is proportional to the plate's; more than 95 % of impacts
are of type II or III (that is of the paper's own simulation); and walkers that bounce with a
restitution of 0.8 run at 60 mm/s at 10 deg. Each row of SETTINGS changes one thing of the scene
`plane-90hz` or of the walker `koumakis2016`, and all four are measured again, at the label of the
feet that the speeds speak for and at the one that the paper measured.

    python benchmarks/causes.py [--only walls,plate noise] [--out out/causes.csv] [--table]

A line is written for every quantity as soon as it is measured; a second call goes on where the first
ended, and measures again what was measured with other kernels. On one core a row takes 40 to 90 s, all
of them an hour. --table prints what is known as Markdown, and measures nothing. A plate that rocks moves
to and fro along x as well: its walkers get the velocity that it loses, 32 times a period, which is
exact but for that grid (a constant kick gives the speed of a slope within its error).
"""

import argparse
import csv
import math
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.errors import InputError
from walkergen.exploring import drops, still
from walkergen.files import templates
from walkergen.files.tables import csv_text
from walkergen.jobs.paper import plane
from walkergen.jobs.validate.ensembles import landings, mean
from walkergen.numerics import kernels
from walkergen.scene import PAPER_CONTACT, Scene
from walkergen.simulation import ensemble
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.record import Tally
from walkergen.simulation.run import ENDED_WELL, RunResult, impacts_of
from walkergen.simulation.space.state import PHASE, V_X
from walkergen.simulation.world import OK, State, World
from walkergen.theory.impact import Kind
from walkergen.walker import solids
from walkergen.walker.design import Design

LABELS = (PAPER_CONTACT.restitution, 0.5, 0.8)
"""Labels of the feet: of the shipped scenes, between, and as the paper measured."""

SLOW_S = 14.0
"""Measured time of a run at 35 deg, s: exponents reach a quarter of it."""

KICKS = 32
"""Kicks that a rocking plate gives in a period."""

GAMMAS = (1.2, 1.4, 1.8, 2.2)
"""Peak accelerations over g of the speeds at 15 deg; the line through zero is that of the last."""

SPEED, REBOUND = (55.0, 65.0), 0.7
"""Speed at 10 deg (mm/s) and least rebound that count as the paper's."""

CROSSOVER, SHARE_OF_LINE, TYPES = (0.5, 2.0), 0.8, 0.95
"""Lag (s) at which the exponent falls to 1.5, share of the line and of types that count as its own."""


class Setting(NamedTuple):
    """One cause at one size."""

    cause: str
    size: str
    keys: dict[str, object] = {}
    """Keys of the scene; those that begin with "walker." are the design's."""
    likely: bool = False
    """Whether the paper's set-up may well have had that."""
    rocks: tuple[float, float] | None = None
    """Amplitude of a plate's horizontal motion over that of the vertical one, and its phase, rad."""
    stronger: float = 1.0
    """Factor of every acceleration."""


def along(cause: str, key: str, unit: str, likely: Sequence[float], far: Sequence[float]) -> list[Setting]:
    """Settings of one key, at values that a set-up may have and at others."""
    values = sorted([(one, True) for one in likely] + [(one, False) for one in far])
    return [Setting(cause, f"{one:g}{unit}", {key: one}, near) for one, near in values]


def lane(gap_mm: float, friction: float, likely: bool) -> Setting:
    keys = {"arena.kind": "lane", "arena.gap_mm": gap_mm, "arena.wall_friction": friction}
    return Setting("walls", f"{gap_mm - 8.0:g} mm of play, friction {friction:g}", keys, likely)


def rough(height_um: float, length_mm: float, likely: bool) -> Setting:
    keys = {"plate.roughness_um": height_um, "plate.roughness_length_mm": length_mm}
    return Setting("rough plate", f"{height_um:g} um by {length_mm:g} mm", keys, likely)


SETTINGS = [
    Setting("none", "", {}, True),
    *along("uneven corners", "feet.unevenness_um", " um", (2, 5, 10, 20), (50, 100)),
    *along("plate noise", "plate.noise_ratio", " of the drive", (0.03, 0.1), (0.2, 0.3, 0.5, 1.0)),
    Setting("second harmonic", "0.03", {"drive.second_harmonic_ratio": 0.03}, True),
    Setting("second harmonic", "0.1", {"drive.second_harmonic_ratio": 0.1}),
    Setting("second harmonic", "0.1, half a turn later",
            {"drive.second_harmonic_ratio": 0.1, "drive.second_harmonic_phase_deg": 180.0}),
    Setting("second harmonic", "0.3", {"drive.second_harmonic_ratio": 0.3}),
    lane(8.5, 0.25, True), lane(8.2, 0.25, True), lane(8.1, 0.25, True), lane(8.2, 1.0, False),
    *along("slope of the plate", "plate.slope_deg", " deg", (0.1, 0.3), (1, 3)),
    *[Setting("rocking plate", f"{size:g} {words}", {"run.energy_tolerance": 1.0}, size <= 0.05, (size, at))
      for size in (0.05, 0.2, 0.5) for words, at in (("in phase", 0.0), ("a quarter later", -0.5 * math.pi))],
    Setting("rocking plate", "0.5 against it", {"run.energy_tolerance": 1.0}, False, (0.5, math.pi)),
    *[Setting("bent plate: stronger under the walker", f"x {one:g}", {}, one < 1.2, None, one)
      for one in (1.1, 1.25, 1.5)],
    rough(1.0, 1.0, True), rough(20.0, 20.0, True), rough(3.0, 1.0, False), rough(10.0, 1.0, False),
    rough(30.0, 2.0, False),
    *along("soft layer", "feet.local_stiffness_ratio", " of the leg's stiffness", (3, 1, 0.3),
           (0.1, 0.03, 0.01, 0.003)),
    Setting("hysteretic feet", "", {"feet.damping": "hysteretic"}, True),
    *along("friction", "contact.friction", "", (0.2, 0.3), (0.05, 0.1, 0.15, 0.4, 0.5)),
    *along("leg damping", "legs.damping_ratio", "", (0.02, 0.1), (0.3, 1.0)),
    *along("leg thickness", "walker.legs.flexible_thickness_mm", " mm", (0.35, 0.45), (0.3, 0.6, 0.8)),
    Setting("square feet", "", {"walker.legs.foot": "square"}, True),
]  # fmt: skip


class Row(NamedTuple):
    """One quantity of one setting at one label; the field names are the CSV's columns."""

    code: str
    """Digest of the kernels' sources."""
    cause: str
    size: str
    label: float
    quantity: str
    value: float
    se: float


def plan_of(one: Setting, label: float, tilt: float, runs: int, seconds: float, gamma: float = 1.8) -> Plan:
    """Plan of the paper's walker with one cause, on its plane unless the cause is a lane."""
    scene = templates.load("plane-90hz", "scenes", Scene)
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=tilt)
    walker = {key[7:]: value for key, value in one.keys.items() if key.startswith("walker.")}
    keys = {key: value for key, value in one.keys.items() if not key.startswith("walker.")}
    run = {"run.runs": runs, "run.seconds": seconds, "run.discard_seconds": 0.5, "legs.model": "space",
           "contact.restitution": label, "drive.gamma": one.stronger * gamma}  # fmt: skip
    design = design.variant(**walker) if walker else design
    plan = prepare(scene.variant(**(run | keys)), design, solids.mass_of(design))
    if one.rocks is None:
        return plan
    return plan._replace(model=plan.model._replace(advance=rocking(plan, *one.rocks)))


def rocking(plan: Plan, ratio: float, shift: float) -> Callable[[World, State, float, Tally], int]:
    """What advances a state on a plate that moves along x by ratio A sin(phase + shift) as well.

    In the plate's frame that is a uniform acceleration, which the walker gets as kicks.
    """
    code, drive = plan.model.advance, plan.world.drive
    speed = ratio * drive.amplitude * drive.omega

    def advance(world: World, state: State, seconds: float, tally: Tally) -> int:
        slices = max(round(KICKS * seconds / drive.period), 1)
        step = seconds / slices
        for _ in range(slices):
            before = math.cos(state[PHASE] + shift)
            middle = math.cos(state[PHASE] + 0.5 * drive.omega * step + shift)
            after = math.cos(state[PHASE] + drive.omega * step + shift)
            state[V_X] -= speed * (middle - before)
            status = entered(world, state, step, tally)
            if status != OK:
                return status
            state[V_X] -= speed * (after - middle)
        return OK

    def entered(*arguments: object) -> int:
        if not ready:
            ready.append(kernels.entry(code, *arguments))
        return int(ready[0](*arguments))

    ready: list[Callable[..., int]] = []
    return advance


def runs_of(plan: Plan, impacts: bool = False, interval: float | None = None) -> list[RunResult]:
    """Runs that ended well, one after another on one core."""
    found = ensemble.run(plan, lambda *_: None, 1, impacts, interval)
    return [one for one in found if one.outcome in ENDED_WELL]


def fast(one: Setting, label: float) -> Iterator[tuple[str, float, float]]:
    """Speed at 10 deg, mm/s, and share of types II and III among its landings."""
    found = runs_of(plan_of(one, label, 10.0, 12, 3.0), impacts=True)
    yield "speed", *mean([result.speed for result in found])
    landed = [landings(impacts_of(result), 2) for result in found]
    yield "types", *mean([float(np.isin(rows[:, 6], (Kind.II, Kind.III)).mean()) for rows in landed])


def bounce(one: Setting, label: float) -> Iterator[tuple[str, float, float]]:
    """Rebound of drops by 1 mm at 10 deg: level, and turned by up to 1 mrad, a print a drop."""
    plan = plan_of(one, label, 10.0, 1, 1.0)
    plan = still.plan_of(plan.scene, plan.case.design)
    turns = np.random.default_rng(2016).uniform(-1e-3, 1e-3, (16, 2))
    level = [drops.rebound(plan, drops.Let(1.0, number=number)).ratio for number in range(4)]
    found = [drops.rebound(plan, drops.Let(1.0, *turn, n)).ratio for n, turn in enumerate(turns)]
    yield "level", *mean([ratio for ratio in level if ratio is not None])
    yield "rebound", *mean([ratio for ratio in found if ratio is not None])


def onset(one: Setting, label: float) -> Iterator[tuple[str, float, float]]:
    """Speed at 15 deg over the plate's, over that at the largest acceleration: 1 on a line."""
    pairs = [mean([result.speed for result in runs_of(plan_of(one, label, 15.0, 8, 3.0, gamma))])
             for gamma in GAMMAS]  # fmt: skip
    top, top_se = pairs[-1]
    for gamma, (speed, se) in zip(GAMMAS[:-1], pairs[:-1], strict=True):
        scale = GAMMAS[-1] / gamma / top
        yield f"line {gamma:g}", scale * speed, abs(scale) * math.hypot(se, speed / top * top_se)


def slow(one: Setting, label: float) -> Iterator[tuple[str, float, float]]:
    """Speed at 35 deg, crossover (s), exponents of the squared displacement at 1 s and beyond."""
    results = runs_of(plan_of(one, label, 35.0, 12, SLOW_S), interval=plane.INTERVAL)
    found = plane.measured("", 35.0, results)
    if found is None:
        return
    growth, curve = found.growth, found.growth.exponents
    yield "slow speed", *found.speed
    yield "crossover", *(growth.crossover or (math.nan, math.nan))
    near = int(np.abs(np.log(curve.at / 1.0)).argmin())
    yield "exponent at 1 s", float(curve.value[near]), float(curve.se[near])
    turns = [abs(float(one.heading[-1] - one.heading[0])) for one in found.tracks.tracks]
    yield "turning", *mean([turn / SLOW_S for turn in turns])


MEASURES = {"fast": fast, "bounce": bounce, "onset": onset, "slow": slow}
LAST = {"fast": "types", "bounce": "rebound", "onset": f"line {GAMMAS[-2]:g}", "slow": "turning"}
"""Last quantity of each measure: what was cut short is measured again."""

UNCHANGED = {"plate noise", "second harmonic", "slope of the plate", "rocking plate", "walls",
             "bent plate: stronger under the walker"}  # fmt: skip
"""Causes without a part in a drop on a level plate at rest."""


def wanted(one: Setting) -> Iterator[tuple[str, float]]:
    """Measures of a setting and their labels."""
    for label in LABELS:
        yield "fast", label
        if one.cause not in UNCHANGED:
            yield "bounce", label
    for label in (LABELS[0], LABELS[-1])[: 1 if one.cause != "none" else 2]:
        yield "onset", label
        if one.cause != "walls":
            yield "slow", label


def kept(path: Path) -> list[Row]:
    """Rows of earlier calls with these kernels."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        rows = [
            Row(line["code"], line["cause"], line["size"], float(line["label"]), line["quantity"],
                float(line["value"]), float(line["se"]))
            for line in csv.DictReader(stream)
        ]  # fmt: skip
    return [row for row in rows if row.code == kernels.digest()]


def measured(one: Setting, known: Sequence[Row], path: Path) -> Iterator[Row]:
    """Measure what is not known of a setting, and write each row as soon as it is."""
    have = {(row.label, row.quantity) for row in known if (row.cause, row.size) == one[:2]}
    for name, label in wanted(one):
        if (label, LAST[name]) in have:
            continue
        started = time.perf_counter()
        try:
            found = list(MEASURES[name](one, label))
        except InputError as error:
            print(f"{one.cause} {one.size}, {name}: {error}")
            continue
        rows = [Row(kernels.digest(), *one[:2], label, *quantity) for quantity in found]
        new = not path.exists()
        with path.open("a", encoding="utf-8", newline="") as stream:
            text = csv_text(Row._fields, rows)
            stream.write(text if new else text.partition("\n")[2])
        told = ", ".join(f"{row.quantity} {row.value:.3g} ± {row.se:.2g}" for row in rows)
        took = time.perf_counter() - started
        print(f"{one.cause} {one.size}, label {label:g}: {told} ({took:.0f} s)", flush=True)
        yield from rows


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", default="", help="causes, comma-separated")
    parser.add_argument("--out", type=Path, default=Path("out/causes.csv"))
    parser.add_argument("--table", action="store_true", help="print the table of what is known")
    options = parser.parse_args()
    names = {one.cause for one in SETTINGS}
    only = set(filter(None, options.only.split(","))) or names
    if only - names:
        parser.error(f"--only {','.join(sorted(only - names))}: must be among {', '.join(names)}")
    known = kept(options.out)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    for one in SETTINGS:
        if one.cause in only and not options.table:
            known += measured(one, known, options.out)


if __name__ == "__main__":
    main()
