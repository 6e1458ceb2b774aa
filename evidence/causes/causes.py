"""Which single cause would bring what the paper saw and the model in space does not show?

Four facts stay open (docs/causes.md): (a) a walker of 35 deg turns from superdiffusive to diffusive
at about 1 s; (b) the speed at 15 deg is proportional to the plate's; (c) more than 95 % of impacts
are of type II or III, in the paper's own simulation; (d) walkers bounce with a restitution of 0.8
and run at 60 mm/s at 10 deg. Each of SETTINGS changes one thing of the scene `plane-90hz` or of the
walker `koumakis2016`, and all four are measured again: (a) and (b) at the label of the feet that
the speeds speak for, (c) and (d) at larger ones too, up to the one that the paper measured.

    python -m evidence.causes.causes [--only walls,"plate noise"] [--out out/causes.csv] [--table]

Lines are written for every measure as soon as it is done; a second call goes on where the first
ended, and measures again what was measured with other kernels. A setting takes 40 s of one core,
all of them 40 minutes, and half a minute more for each kind of plate that is compiled. --table
prints what is known as Markdown, and measures nothing. cause_measures.py has the measures.
"""

import argparse
import csv
import math
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from evidence.causes.cause_measures import GAMMAS, MEASURES, Setting
from walkergen.files.tables import csv_text
from walkergen.numerics import kernels
from walkergen.numerics.quantity import Quantity
from walkergen.scene import PAPER_CONTACT

LABELS = (PAPER_CONTACT.restitution, 0.5, 0.8)
"""Labels of the feet: of the shipped scenes, between, and as the paper measured."""

ENDS = (LABELS[0], LABELS[-1])

SPEED, REBOUND, TIMES = (55.0, 65.0), 0.7, 2.0
"""Speed at 10 deg (mm/s) and least rebound that count as the paper's; errors that are allowed."""

CROSSOVER, SHARE_OF_LINE, TYPES = (0.5, 2.0), 0.8, 0.95
"""Lag (s) at which the exponent falls to 1.5, share of the line, and of types, that count so."""


def some(cause: str, key: str, unit: str, likely: Sequence[float], far: Sequence[float]) -> list[Setting]:
    """Settings of one key, at values that a set-up may have and at others."""
    values = sorted([(one, True) for one in likely] + [(one, False) for one in far])
    return [Setting(cause, f"{one:g}{unit}", near, {key: one}) for one, near in values]


def lane(play_mm: float, friction: float, likely: bool) -> Setting:
    keys = {"arena.kind": "lane", "arena.gap_mm": 8.0 + play_mm, "arena.wall_friction": friction}
    return Setting("walls", f"{play_mm:g} mm of play, friction {friction:g}", likely, keys)


def rough(height_um: float, length_mm: float, likely: bool) -> Setting:
    keys = {"plate.roughness_um": height_um, "plate.roughness_length_mm": length_mm}
    return Setting("rough plate", f"{height_um:g} um by {length_mm:g} mm", likely, keys)


def distorted(ratio: float, phase_deg: float, likely: bool) -> Setting:
    keys = {"drive.second_harmonic_ratio": ratio, "drive.second_harmonic_phase_deg": phase_deg}
    return Setting("second harmonic", f"{ratio:g} at {phase_deg:g} deg", likely, keys)


def rocking(ratio: float, lag_deg: float, likely: bool) -> Setting:
    keys = {"run.energy_tolerance": 1.0}  # the kicks' work is in no account
    motion = ratio, -math.radians(lag_deg)
    return Setting("rocking plate", f"{ratio:g}, {lag_deg:g} deg later", likely, keys, motion)


SETTINGS = (
    Setting("none", "", True),
    *some("uneven corners", "feet.unevenness_um", " um", (2, 5, 10, 20), (50, 100)),
    *some("plate noise", "plate.noise_ratio", " of the drive", (0.03, 0.1), (0.2, 0.3, 0.5, 1)),
    distorted(0.03, 0, True),
    distorted(0.1, 0, False),
    distorted(0.1, 180, False),
    distorted(0.3, 0, False),
    lane(0.5, 0.25, True),
    lane(0.2, 0.25, True),
    lane(0.1, 0.25, True),
    lane(0.2, 1.0, False),
    *some("slope of the plate", "plate.slope_deg", " deg", (0.1, 0.3), (1, 3)),
    rocking(0.05, 0, True),
    rocking(0.05, 90, True),
    rocking(0.2, 0, False),
    rocking(0.2, 90, False),
    rocking(0.5, 0, False),
    rocking(0.5, 90, False),
    rocking(0.5, 180, False),
    *[Setting("bent plate", f"x {one:g}", 0.9 < one < 1.11, shake=one) for one in (0.9, 0.92, 0.95, 1.1, 1.25, 1.5)],
    *some("soft layer", "feet.local_stiffness_ratio", " of the leg's", (1, 0.3, 0.1, 0.03, 0.025, 0.02), (0.01,)),
    rough(20, 20, True),
    rough(3, 1, False),
    rough(10, 1, False),
    *some("friction", "contact.friction", "", (), (0.1, 0.15, 0.4, 0.5)),
    Setting("hysteretic feet", "", True, {"feet.damping": "hysteretic"}),
    *some("leg damping", "legs.damping_ratio", "", (0.1,), (0.3,)),
    *some("leg thickness", "walker.legs.flexible_thickness_mm", " mm", (), (0.3, 0.6)),
    Setting("square feet", "", True, {"walker.legs.foot": "square"}),
)

STILL = {"plate noise", "second harmonic", "slope of the plate", "rocking plate", "walls", "bent plate"}
"""Causes without a part in a drop on a level plate at rest."""

AT_BOTH = {"none", "soft layer"}
"""Causes of which (a) and (b) are measured at the largest label too: what they do depends on it."""

NO_PLANE = {"walls", "hysteretic feet", "leg damping", "leg thickness", "square feet"}
"""Causes whose walkers of 35 deg are not followed, since they run in a lane or to save time."""


DROPS = ("level", "rebound")
"""Quantities of such drops."""


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

    @classmethod
    def of(cls, one: Setting, label: float, quantity: Quantity) -> "Row":
        """Row of a quantity; NaN where there is none."""
        numbers = (math.nan if number is None else number for number in (quantity.value, quantity.se))
        return cls(kernels.digest(), one.cause, one.size, label, quantity.key, *numbers)


def wanted(one: Setting) -> list[tuple[str, float]]:
    """Measures of a setting and their labels."""
    later = [] if one.cause in NO_PLANE else ["slow"]
    names = ["fast", *([] if one.cause in STILL else ["bounce"])]
    labels = ENDS if one.cause in AT_BOTH else LABELS[:1]
    return [(name, label) for label in LABELS for name in names] + [
        (name, label) for label in labels for name in ("onset", *later)
    ]


def measured(one: Setting, known: Sequence[Row], path: Path) -> Iterator[Row]:
    """Measure what is not known of a setting, and write it as soon as it is."""
    have = {(row.label, row.quantity) for row in known if (row.cause, row.size) == one[:2]}
    for name, label in wanted(one):
        measure, last = MEASURES[name]
        if (label, last) in have:
            continue
        started = time.perf_counter()
        rows = [Row.of(one, label, quantity) for quantity in measure(one, label)]
        text = csv_text(Row._fields, rows)
        with path.open("a", encoding="utf-8", newline="") as stream:
            stream.write(text.partition("\n")[2] if stream.tell() else text)
        words = ", ".join(f"{row.quantity} {row.value:.3g} ± {row.se:.2g}" for row in rows)
        took = time.perf_counter() - started
        print(f"{one.cause} {one.size}, label {label:g}: {words} ({took:.0f} s)", flush=True)
        yield from rows


def kept(path: Path) -> list[Row]:
    """Rows of earlier calls with these kernels."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        lines = [list(line.values()) for line in csv.DictReader(stream)]
    return [
        Row(code, cause, size, float(label), quantity, float(value), float(se))
        for code, cause, size, label, quantity, value, se in lines
        if code == kernels.digest()
    ]


Known = dict[tuple[float, str], tuple[float, float]]
"""Value and error of each quantity of a setting, by label and name."""


def rebound_beside(known: Known) -> tuple[float, float] | None:
    """Rebounds, level and turned, at the largest label that gives SPEED; None where none does.

    Speed and rebound are taken to be linear between labels, and speed not to fall with the label.
    """
    speeds = np.maximum.accumulate([known[label, "speed"][0] for label in LABELS])
    if speeds[0] > SPEED[1] or speeds[-1] < SPEED[0]:
        return None
    largest = min(SPEED[1], speeds[-1])
    level, turned = (float(np.interp(largest, speeds, [known[label, name][0] for label in LABELS])) for name in DROPS)
    return level, turned


def brought(known: Known) -> str:
    """Letters of the facts that a setting brings, within errors."""

    def reach(label: float, name: str) -> float:
        value, se = known.get((label, name), (math.nan, math.nan))
        return value + TIMES * se

    facts = []
    for label in ENDS:
        lag, se = known.get((label, "crossover"), (math.nan, math.nan))
        in_time = CROSSOVER[0] - TIMES * se <= lag <= CROSSOVER[1] + TIMES * se
        facts += [f"a at {label:g}"] if in_time else []
        runs = [gamma for gamma in GAMMAS[:2] if reach(label, f"line {gamma:g}") >= SHARE_OF_LINE]
        facts += [f"b from {runs[0]:g} g at {label:g}"] if runs else []
    facts += [f"c at {one:g}" for one in LABELS if reach(one, "types") >= TYPES]
    facts += ["d"] if max(rebound_beside(known) or (0.0,)) >= REBOUND else []
    return ", ".join(facts) or "none"


def cell(known: Known, name: str, labels: Sequence[float], digits: int, times: float = 1.0) -> str:
    """Values with their errors at some labels."""
    pairs = [known[label, name] for label in labels if (label, name) in known]
    return ", ".join(
        "never" if math.isnan(value) else f"{times * value:.{digits}f} ± {times * se:.{digits}f}" for value, se in pairs
    )


def table(rows: Sequence[Row]) -> str:
    """Table of the settings that are measured, as Markdown."""
    each: dict[tuple[str, str], Known] = {}
    for row in rows:
        each.setdefault((row.cause, row.size), {})[row.label, row.quantity] = row.value, row.se
    still_plate = {key: pair for key, pair in each.get(("none", ""), {}).items() if key[1] in DROPS}
    lines = [
        "| cause | size | a: crossover, s | exponent at 1 s | b: share of the line at 1.2 g | "
        "at 1.4 g | c: II + III, % | d: speed, mm/s | rebound beside 55 to 65 mm/s | brings |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in SETTINGS:
        known = still_plate | each.get(one[:2], {})
        if (LABELS[-1], "types") not in known:
            continue
        pair = rebound_beside(known)
        shares = [cell(known, f"line {gamma:g}", ENDS, 2) for gamma in GAMMAS[:2]]
        cells = (
            one.cause,
            one.size + ("" if one.likely else " *"),
            cell(known, "crossover", ENDS, 2),
            cell(known, "exponent", ENDS, 2),
            *shares,
            cell(known, "types", ENDS, 0, 100.0),
            cell(known, "speed", LABELS, 0),
            "/".join(f"{ratio:.2f}" for ratio in pair) if pair else "no label",
            brought(known),
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", default="", help="causes, comma-separated")
    parser.add_argument("--out", type=Path, default=Path("out/causes.csv"))
    parser.add_argument("--table", action="store_true", help="print the table of what is known")
    options = parser.parse_args()
    names = {one.cause for one in SETTINGS}
    only = set(filter(None, options.only.split(","))) or names
    if unknown := only - names:
        parser.error(f"--only {','.join(unknown)}: must be among {', '.join(sorted(names))}")
    known = kept(options.out)
    if options.table:
        print(table(known))
        return
    options.out.parent.mkdir(parents=True, exist_ok=True)
    for one in SETTINGS:
        if one.cause in only:
            known += measured(one, known, options.out)


if __name__ == "__main__":
    main()
