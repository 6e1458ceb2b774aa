"""Measurement of cells.csv: `python -m evidence.accuracy.measure [--out FILE]`, about five minutes of one core.

The paper's walker on the shipped plates of 90 Hz and 1.8 g, at the tilts and restitutions of CELLS: every step
next to a reference with a tenth of the finest step. Each has runs of its own random numbers (SEEDS), so that errors of
two settings are independent; the loop of `pace` is timed before each, so that costs are those of the machine at that
moment. Rows are added one by one; a second call goes on after the last.
"""

import argparse
from collections.abc import Iterable, Iterator
from itertools import product
from pathlib import Path
from typing import NamedTuple

from walkergen import __version__
from walkergen.cli import console
from walkergen.commands.accuracy import cells, machine_speed
from walkergen.commands.accuracy.cells import REFERENCE_STEP_SHARE, Row
from walkergen.core.numerics import kernels
from walkergen.core.scene import Scene
from walkergen.core.simulation.ensemble import format_outcomes
from walkergen.core.simulation.run import ENDED_WELL, compile_kernels
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import walkers
from walkergen.points.experiments import Walker

LANE, PLANE = "lane-90hz", "plane-90hz"
"""Scenes of the cells."""

CELLS = (
    (LANE, (5.0, 15.0, 1.0, 30.0), (0.8, 0.9, 0.5)),
    (LANE, (10.0,), (0.8, 0.9, 0.5)),
    (LANE, (20.0,), (0.8, 0.9, 0.5)),
    (PLANE, (10.0, 5.0), (0.8,)),
)
"""Scenes, tilts and restitutions of the feet. The later ones were measured later."""

STEP_SHARES = (REFERENCE_STEP_SHARE, 0.5, 1.0, 1.25, 1.6)
"""Steps over that which resolves the feet; the first is the reference's."""

RUNS, DISCARD_S, SECONDS, REFERENCE_S = 8, 0.4, 5.0, 1.5
"""Runs of a setting, the start of each that is not measured, and the measured time of each, s: of the reference less,
since it is twenty times as dear."""

CALM_DEG, CALM_SHARE = 1.0, 0.2
"""Tilt at which speeds scatter by little, and share of the time that is enough there."""

MAIN_RESTITUTION, ELSEWHERE_SHARE = 0.8, 0.5
"""Restitution of the shipped scenes, and share of the time of the cells of others."""

FULLY_MEASURED = ((LANE, 5.0, 0.5),)
"""Cells (scene, tilt, restitution) of another restitution with all settings; the others have only the automatic
step, which gives their speed, scatter and cost."""

PACE_LOOPS = 3
"""Loops of `pace` before each setting."""


class Setting(NamedTuple):
    """Step of a cell."""

    scene: str
    tilt_deg: float
    restitution: float
    share: float
    """Step over that which resolves the feet."""


def list_settings() -> list[Setting]:
    """All settings of all cells; within a cell the dear one first."""
    every = [
        Setting(scene, tilt, restitution, share)
        for scene, tilts, restitutions in CELLS
        for restitution, tilt, share in product(restitutions, tilts, STEP_SHARES)
    ]
    return [
        one for one in every if one.share == 1.0 or one.restitution == MAIN_RESTITUTION or one[:3] in FULLY_MEASURED
    ]


def build_walker(setting: Setting, seed: int) -> Walker:
    """Build the paper's walker in a shipped scene with the tilt, restitution and step of a setting."""
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=setting.tilt_deg)
    scene = templates.load(setting.scene, "scenes", Scene)
    contact = scene.contact.model_copy(update={"restitution": setting.restitution})
    seconds = REFERENCE_S if setting.share == REFERENCE_STEP_SHARE else SECONDS
    seconds *= CALM_SHARE if setting.tilt_deg <= CALM_DEG else 1.0
    seconds *= 1.0 if setting.restitution == MAIN_RESTITUTION else ELSEWHERE_SHARE
    timing = {"runs": RUNS, "seconds": seconds, "discard_seconds": DISCARD_S, "seed": seed}
    run = scene.run.model_copy(update=timing)
    asked = scene.model_copy(update={"contact": contact, "run": run})
    made = Walker(asked, design, solids.mass_of(design))
    return made.with_run_settings(step_us=1e6 * setting.share * made.plan().world.options.step)


def measure_row(setting: Setting, seed: int) -> Row:
    """Row of a setting."""
    one = build_walker(setting, seed)
    step_us = one.scene.run.step_us
    assert step_us is not None
    compile_kernels(one.plan())
    loop_s = machine_speed.measure_cpu_per_s(PACE_LOOPS)
    results = walkers.simulate(one, threads=1)
    summary = results.summary
    well = set(summary.outcomes) <= {"on one periodic orbit", *(outcome.value for outcome in ENDED_WELL)}
    simulated_s = summary.runs * (one.scene.run.seconds + DISCARD_S)
    return Row(
        *setting[:3],
        setting.share,
        step_us,
        summary.speed.value if well else None,
        summary.speed.se if well else None,
        summary.runs,
        one.scene.run.seconds,
        summary.cpu_s / simulated_s / loop_s,
        format_outcomes(summary.outcomes).replace(",", ";"),
    )


def missing_settings(path: Path) -> Iterator[tuple[int, Setting]]:
    """Yield the settings without a row in a file, each after its seed."""
    rows = cells.read_rows(path) if path.exists() else ()
    known = {(*row.cell, row.share) for row in rows}
    yield from ((seed, setting) for seed, setting in enumerate(list_settings(), 1) if setting not in known)


def format_rows(rows: Iterable[Row]) -> str:
    """Lines of the file, with numbers of five digits."""
    lines = [",".join(Row._fields)]
    for row in rows:
        numbers = ("" if cell is None else f"{cell:.5g}" if isinstance(cell, float) else str(cell) for cell in row)
        lines.append(",".join(numbers))
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure what a file lacks, and add it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=cells.CELLS_PATH)
    path = parser.parse_args().out
    todo = list(missing_settings(path))
    if not path.exists():
        stamp = f"# walkergen {__version__}, kernels {kernels.source_digest()}: python -m evidence.accuracy.measure\n"
        path.write_text(stamp + format_rows([]), encoding="utf-8")
    with console.progress("cells", wanted=True) as progress:
        for number, (seed, setting) in enumerate(todo, 1):
            row = measure_row(setting, seed)
            with path.open("a", encoding="utf-8") as stream:
                stream.write(format_rows([row]).split("\n", 1)[1])
            progress("cells", number, len(todo))


if __name__ == "__main__":
    main()
