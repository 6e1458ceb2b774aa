"""How often bounds hold the truth: random walkers, each with one hidden print that is simulated.

Shape, tilt and shake of a walker are random; what design and scene do not know exactly (contact,
thickness, modulus, damping, masses, corner heights) is drawn once and kept hidden. The truth is the
speed of one print of it, by a tenth of the step. Against it stand the bounds of

- predict: `family` and `predict`, which know design and scene alone;
- uncertain: `simulate --uncertain --draws 24`, the same by simulation;
- fit: `fit --model space` from the speeds of three other prints of it, of other tilts, filmed with
  an error of 1.5 mm/s.

A line is written for every method of every walker as soon as its bounds are computed. A second call goes on
where the first ended, and measures again what was measured with other code. On two
free cores a walker costs a minute and a half, most of it for the fit: 25 minutes for 16.

    python benchmarks/bounds.py [--designs 16] [--methods predict,uncertain,fit] [--seconds 16]
        [--draws 24] [--scene plane-90hz] [--seed 1] [--out out/bounds.csv]
"""

import argparse
import csv
import hashlib
import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

import walkergen
from walkergen.core.errors import GeometryError, InputError
from walkergen.core.files.tables import csv_text
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.theory import uncertain_inputs
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab.fit import model_fit
from walkergen.guests.lab.fit.request import FitRequest
from walkergen.guests.lab.report import Setup
from walkergen.points import print_ensemble as prints
from walkergen.points import speed_prediction as speed_of
from walkergen.points import walkers
from walkergen.points.experiments import Walker

METHODS = ("predict", "uncertain", "fit")

SHAPES = {
    "body.length_mm": (24.0, 34.0),
    "body.thickness_mm": (2.5, 4.0),
    "legs.length_mm": (5.5, 9.5),
    "legs.contact_spacing_mm": (10.0, 15.0),
    "legs.flexible_thickness_mm": (0.3, 0.6),
    "legs.tilt_deg": (5.0, 24.0),
}
SHAKES = {"drive.gamma": (1.5, 2.4), "drive.frequency_hz": (75.0, 110.0)}
"""Ranges of the random walkers and plates, inside those of the table behind `predict`."""

FILMED = (0.5, 1.4, 1.8)
"""Tilts of the prints that `fit` learns from, over that of the hidden one."""

FILM_SE = 1.5
"""Standard error of a filmed speed, mm/s."""

PRINT_S = 4.0
"""Measured time of a run of `--uncertain`, s, as on the command line."""

LEVELS = {"68": 0.68, "95": 0.95}


class Row(NamedTuple):
    """Bounds of one method and the hidden speed, mm/s; the field names are the CSV's columns."""

    code: str
    """Digest of the package's sources."""
    setting: str
    walker: int
    method: str
    speed: float
    low_95: float
    low_68: float
    high_68: float
    high_95: float
    seconds: float
    """Time that the bounds took."""
    note: str


class Hidden(NamedTuple):
    """Random walker on a random plate, and the hidden properties of its print."""

    design: Design
    scene: Scene
    values: dict[str, float]
    rng: np.random.Generator


def silent(what: str, done: int, total: int) -> None:
    """Show no progress."""


def digest() -> str:
    """Digest of everything that decides bounds: the package's sources and tables."""
    folder = Path(walkergen.__file__).parent
    files = sorted(one for one in folder.rglob("*") if one.suffix in (".py", ".json", ".toml"))
    return hashlib.sha256(b"".join(one.read_bytes() for one in files)).hexdigest()[:12]


def draw_walker(number: int, scene: Scene, seed: int) -> Hidden:
    """Random walker of a number: the first shape that can be built, and its hidden print."""
    rng = np.random.default_rng([seed, number])
    template = templates.load("koumakis2016", "walkers", Design)
    while True:
        shape, shake = (
            {key: round(float(rng.uniform(*ends)), 2) for key, ends in ranges.items()} for ranges in (SHAPES, SHAKES)
        )
        try:
            design = template.variant(**shape)
            for part in (1.0, *FILMED):
                solids.build(design.variant(tilt_deg=part * design.tilt_deg))
        except GeometryError:
            continue
        plate = scene.variant(**shake)
        known = uncertain_inputs.inputs(plate, design, "space")
        values = uncertain_inputs.sample_inputs(known, 1, int(rng.integers(2**31)))[0]
        names = [one.name for one in known]
        return Hidden(design, plate, dict(zip(names, values.tolist(), strict=True)), rng)


def speeds(hidden: Hidden, tilts: Sequence[float], seconds: float) -> list[float]:
    """Speeds of prints of a walker with these tilts (deg), a run each by a tenth of the step, mm/s.

    Raises InputError where one has no speed.
    """
    asked = []
    for tilt in tilts:
        design = hidden.design.variant(tilt_deg=tilt)
        scene, printed, mass = uncertain_inputs.apply_inputs(hidden.scene, design, hidden.values)
        keys = {"run.runs": 1, "run.seconds": seconds, "run.seed": int(hidden.rng.integers(2**31))}
        scene = scene.variant(**keys)
        step = prepare(scene, printed, mass).world.options.step
        asked.append(Walker(scene.variant(**{"run.step_us": 1e5 * step}), printed, mass))
    found = walkers.simulate_parallel(asked).values()
    told = [one.summary.speed.value for one in found]
    if None in told:
        raise InputError("a hidden print falls")
    return [float(one) for one in told if one is not None]


def bounds(method: str, hidden: Hidden, filmed: Sequence[tuple[float, float]], draws: int) -> Sequence[float | None]:
    """Compute the lower and upper ends of 95 % and 68 % by a method, mm/s, in ascending order.

    `filmed` holds the tilts (deg) and speeds (mm/s) that the fit uses.
    """
    design, scene = hidden.design, hidden.scene
    if method == "predict":
        row = speed_of.predict(design, solids.mass_of(design), hidden.scene)
        return row.speed.ends or [None] * 4
    if method == "uncertain":
        short = scene.variant(**{"run.seconds": PRINT_S})
        return prints.measure(short, design, draws, silent).speed.ends or [None] * 4
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "speeds.csv")
        path.write_text(csv_text(("tilt_deg", "speed_mm_s", "speed_se_mm_s"), [(*film, FILM_SE) for film in filmed]))
        request = FitRequest(speeds=path, model="space", prior="flat", predict=[design.tilt_deg])
        learned = model_fit.fit(request, Setup(design, scene), {}, silent)
    (band,) = [one for one in learned.bands if not one.measured]
    return band.low_95, band.low_68, band.high_68, band.high_95


def rows(hidden: Hidden, methods: Sequence[str], options: argparse.Namespace) -> Iterator[Row]:
    """Rows of one walker, a method each; without the name of code, setting and walker."""
    tilts = [hidden.design.tilt_deg] + [part * hidden.design.tilt_deg for part in FILMED]
    try:
        speed, *others = speeds(hidden, tilts, options.seconds)
    except InputError as error:
        yield from (Row("", "", 0, one, *[math.nan] * 5, 0.0, str(error)) for one in methods)
        return
    film = (one + FILM_SE * hidden.rng.normal() for one in others)
    filmed = list(zip(tilts[1:], film, strict=True))
    for method in methods:
        started, note = time.perf_counter(), ""
        try:
            ends = bounds(method, hidden, filmed, options.draws)
        except InputError as error:
            ends, note = [None] * 4, str(error)
        known = [math.nan if one is None else one for one in ends]
        yield Row("", "", 0, method, speed, *known, time.perf_counter() - started, note)


def read_rows(path: Path, code: str, setting: str) -> list[Row]:
    """Rows of earlier calls with the same code and setting."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        lines = [
            Row(
                one["code"],
                one["setting"],
                int(one["walker"]),
                one["method"],
                *(float(one[name]) for name in Row._fields[4:10]),
                one["note"],
            )
            for one in csv.DictReader(stream)
        ]
    return [row for row in lines if (row.code, row.setting) == (code, setting)]


def describe_coverage(found: Sequence[Row], method: str) -> str:
    """Share of truths inside the bounds of a method, with the error of so few walkers."""
    known = [row for row in found if row.method == method and math.isfinite(row.low_95 + row.speed)]
    if not known:
        return f"{method}: no bounds"
    parts = []
    for name, level in LEVELS.items():
        ends = [(getattr(row, f"low_{name}"), getattr(row, f"high_{name}")) for row in known]
        inside = sum(low <= row.speed <= high for row, (low, high) in zip(known, ends, strict=True))
        error = math.sqrt(level * (1.0 - level) / len(known))
        width = float(np.median([high - low for low, high in ends]))
        parts.append(
            f"{name} %: {inside} of {len(known)}, {100 * inside / len(known):.0f} ± "
            f"{100 * error:.0f} %, width {width:.1f} mm/s"
        )
    refused = sum(row.method == method for row in found) - len(known)
    seconds = np.median([row.seconds for row in known])
    return f"{method}: {'; '.join(parts)}; {refused} without bounds; {seconds:.2g} s each"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--designs", type=int, default=16)
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--seconds", type=float, default=16.0, help="of the hidden print's run")
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--scene", default="plane-90hz")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/bounds.csv"))
    options = parser.parse_args()
    methods = options.methods.split(",")
    if unknown := set(methods) - set(METHODS):
        parser.error(f"--methods {','.join(unknown)}: must be among {', '.join(METHODS)}")
    code = digest()
    setting = f"{options.scene} {options.seed} {options.seconds:g} {options.draws}"
    found = read_rows(options.out, code, setting)
    scene = templates.load(options.scene, "scenes", Scene)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    for number in range(options.designs):
        done = {row.method for row in found if row.walker == number}
        missing = [one for one in methods if one not in done]
        if not missing:
            continue
        for row in rows(draw_walker(number, scene, options.seed), missing, options):
            mine = row._replace(code=code, setting=setting, walker=number)
            found.append(mine)
            new = not options.out.exists()
            with options.out.open("a", encoding="utf-8", newline="") as stream:
                text = csv_text(Row._fields, [mine])
                stream.write(text if new else text.partition("\n")[2])
            print(
                f"{number} {mine.method}: {mine.speed:.1f} in {mine.low_95:.1f} to "
                f"{mine.high_95:.1f} ({mine.low_68:.1f} to {mine.high_68:.1f}) {mine.note}"
            )
    for method in methods:
        print(describe_coverage([row for row in found if row.walker < options.designs], method))


if __name__ == "__main__":
    main()
