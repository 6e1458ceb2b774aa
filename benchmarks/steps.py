"""Error of the automatic step: speeds with it and with a tenth of it.

The paper's walker over tilts, restitution and friction, on the plane and in the lane, and the templates
of other mechanisms, each in random runs of its own. A row is written as soon as it is measured. A
second call goes on where the first ended. Its rows, in Markdown; docs/validation.md shows some.

    python benchmarks/steps.py [--finer 10] [--runs 16] [--seconds 3] [--out out/steps.csv]

Twelve minutes on a core.
"""

import argparse
import csv
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from walkergen.core.files.tables import csv_text
from walkergen.core.numerics import kernels
from walkergen.core.scene import Scene
from walkergen.core.simulation import observables
from walkergen.core.simulation.plan import prepare
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import step_errors, walkers
from walkergen.points.experiments import Walker

NOTHING: Mapping[str, object] = MappingProxyType({})


class Setting(NamedTuple):
    """A walker in a scene."""

    tilt_deg: float | None
    """None: that of the template."""
    restitution: float | None = None
    """None: that of the scene."""
    friction: float | None = None
    walker: str = "koumakis2016"
    scene: str = "plane-90hz"
    keys: Mapping[str, object] = NOTHING
    """Other keys of the scene."""


class Row(NamedTuple):
    """Speeds of a setting, mm/s; the field names are the CSV's columns."""

    code: str
    setting: str
    own: float
    own_se: float
    fine: float
    fine_se: float
    stated: float
    """Largest error (95 %) that is stated of the own step."""


SETTINGS = (
    Setting(2.0),
    Setting(5.0),
    Setting(10.0),
    Setting(15.0),
    Setting(20.0),
    Setting(35.0),
    Setting(2.0, 0.3, 0.25),
    Setting(2.0, 0.5, 0.1),
    Setting(5.0, 0.05, 0.25),
    Setting(5.0, 0.2, 0.1),
    Setting(5.0, 0.3, 0.05),
    Setting(5.0, 0.3, 0.1),
    Setting(5.0, 0.5, 0.5),
    Setting(8.0, 0.3, 0.25),
    Setting(10.0, 0.05, 0.1),
    Setting(10.0, 0.3, 0.25),
    Setting(10.0, 0.3, 0.5),
    Setting(10.0, 0.8, 0.1),
    Setting(10.0, 0.5, 0.25, keys={"feet.rigid_tips": True}),
    Setting(12.0, 0.5, 0.05),
    Setting(15.0, 0.3, 0.25, keys={"drive.gamma": 2.6}),
    Setting(15.0, 0.8, 0.25),
    Setting(20.0, 0.05, 0.5),
    Setting(20.0, 0.5, 0.25),
    Setting(35.0, 0.3, 0.25),
    Setting(10.0, 0.02, 0.25),
    Setting(5.0, 0.02, 0.25),
    Setting(15.0, 0.02, 0.25),
    Setting(10.0, scene="lane-90hz"),
    *(Setting(None, 0.3, None, one) for one in ("two-materials", "unequal-legs", "polar-disc", "rotator")),
)


def silent(what: str, done: int, total: int) -> None:
    """Show no progress."""


def name(one: Setting) -> str:
    """Describe a setting in words: walker, tilt, restitution, friction, and changed keys of the scene."""
    walker = "" if one.walker == "koumakis2016" else one.walker
    tilt = "" if one.tilt_deg is None else f"{one.tilt_deg:g} deg"
    restitution = "" if one.restitution is None else f"restitution {one.restitution:g}"
    friction = "" if one.friction is None else f"μ {one.friction:g}"
    scene = "" if one.scene == "plane-90hz" else one.scene
    keys = (f"{key.partition('.')[2]} {value}" for key, value in one.keys.items())
    return ", ".join(word for word in (walker, tilt, restitution, friction, scene, *keys) if word)


def walker_of(one: Setting) -> tuple[Scene, Design]:
    """Scene and design of a setting."""
    design = templates.load(one.walker, "walkers", Design)
    if one.tilt_deg is not None:
        design = design.variant(tilt_deg=one.tilt_deg)
    keys = {"contact.restitution": one.restitution, "contact.friction": one.friction} | dict(one.keys)
    keys = {key: value for key, value in keys.items() if value is not None}
    return templates.load(one.scene, "scenes", Scene).variant(**keys), design


def measure_setting(one: Setting, code: str, options: argparse.Namespace) -> Row:
    """Speeds of a setting by its own step and by a finer one, from other random starts."""
    scene, design = walker_of(one)
    mass = solids.mass_of(design)
    run = {"run.runs": options.runs, "run.seconds": options.seconds}
    own = scene.variant(**run)
    plan = prepare(own, design, mass)
    fine = {"run.seed": 2, "run.step_us": 1e6 * plan.world.options.step / options.finer}
    pair = [Walker(own, design, mass), Walker(own.variant(**fine), design, mass)]
    coarse, finer = (one.summary for one in walkers.simulate_parallel(pair).values())
    stated = step_errors.step_bias(step_errors.add_step_bias(plan, coarse.numbers)[observables.SPEED])
    speeds = (coarse.speed.value, coarse.speed.se, finer.speed.value, finer.speed.se)
    known = [math.nan if value is None else value for value in (*speeds, stated)]
    return Row(code, name(one), *known)


def read_rows(path: Path, code: str) -> dict[str, Row]:
    """Rows of earlier calls with the same code, by their settings."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as stream:
        rows = [
            Row(line["code"], line["setting"], *(float(line[key]) for key in Row._fields[2:]))
            for line in csv.DictReader(stream)
        ]
    return {row.setting: row for row in rows if row.code == code}


def line(row: Row) -> str:
    """Row of the Markdown table."""
    error = math.hypot(row.own_se, row.fine_se)
    stated = "none" if math.isnan(row.stated) else f"{row.stated:.1f}"
    return (
        f"| {row.setting} | {row.own:.1f} ± {row.own_se:.1f} | {row.fine:.1f} ± {row.fine_se:.1f} "
        f"| {row.own - row.fine:+.1f} ± {error:.1f} | {stated} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--finer", type=float, default=10.0, help="divisor of the own step")
    parser.add_argument("--runs", type=int, default=16)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--out", type=Path, default=Path("out/steps.csv"))
    options = parser.parse_args()
    code = f"{kernels.source_digest()} {options.finer:g} {options.runs} {options.seconds:g}"
    rows = read_rows(options.out, code)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    print(f"| setting | own step | step / {options.finer:g} | difference | stated |")
    print("|---|--:|--:|--:|--:|")
    for one in SETTINGS:
        row = rows.get(name(one)) or measure_setting(one, code, options)
        if name(one) not in rows:
            new = not options.out.exists()
            with options.out.open("a", encoding="utf-8", newline="") as stream:
                text = csv_text(Row._fields, [row])
                stream.write(text if new else text.partition("\n")[2])
        print(line(row), flush=True)


if __name__ == "__main__":
    main()
