"""Three checks of crowds in a plane, in the order of Weber and others (arXiv 1304.4760).

Single: a card comes back from walkers alone; binary: pairs that meet; collective: a crowd. Of each
the same places, films and analysis in space and in a plane.
"""

from pathlib import Path

from evidence.crowd_checks import many, meetings, pairs, report, setting, single
from evidence.crowd_checks.compared import Row, row
from evidence.crowd_checks.setting import Size
from walkergen.analysis.values import Value
from walkergen.crowd.card import Card
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.crowd.flat import engine
from walkergen.files.output import Folder
from walkergen.files.progress import Progress, silent
from walkergen.files.report import Report
from walkergen.walker import solids

STEPS = 6


def make(size: Size, command: str, folder: Path, progress: Progress) -> Report:
    """Run the checks, and write crowd_checks.md and .csv; `command`: words that make them.

    Equal sizes give equal bytes on one machine. Ctrl-C leaves no file. Raises InputError where
    LAMMPS is absent.
    """
    engine.locate()
    result = report.of(run(size, progress), folder, notes(size, command))
    with Folder(folder, "") as target:
        result.write(target, pictures=False)
    return result


def run(size: Size, progress: Progress) -> list[Row]:
    """Rows of all three checks."""
    design = setting.walker()
    mass = solids.mass_of(design)
    progress("alone in space", 0, STEPS)
    card, alone = single.in_space(size, design, mass, silent)
    progress("alone in the plane", 1, STEPS)
    rows = _single(size, card, alone)
    progress("pairs in space", 2, STEPS)
    met = pairs.in_space(size, design, mass, card)
    progress("pairs in the plane", 3, STEPS)
    rows += _binary(met, pairs.in_plane(size, card))
    progress("a crowd in space", 4, STEPS)
    crowd = many.in_space(size, design, mass, card)
    progress("a crowd in the plane", 5, STEPS)
    rows += _collective(crowd, many.in_plane(size, card))
    progress("done", STEPS, STEPS)
    return rows


def notes(size: Size, command: str) -> list[str]:
    """How the rows were made, a sentence each."""
    walker, met = f"{setting.WALKER} in {setting.PLATE}", size.pair_runs * size.pairs
    return [
        f"made by `{command}`: {walker}, seed {size.seed}",
        f"alone: {size.alone_runs} runs of {size.alone_seconds:g} s in space, {single.SIDE**2} in the plane",
        f"pairs: up to {met} of each meeting in space, {pairs.PLANES * met} in the plane; each "
        f"walks {meetings.NEAREST:g} to {meetings.FARTHEST:g} mm until they meet",
        f"crowd: {setting.COUNT} in {setting.DISH}, {size.crowd_runs} runs in space, "
        f"{many.PLANES * size.crowd_runs} in the plane, {size.crowd_seconds:g} s each after "
        f"{size.crowd_discard_seconds:g} s",
    ]


def _single(size: Size, card: Card, alone: Measured) -> list[Row]:
    space, plane = single.numbers(alone), single.numbers(single.in_plane(size, card))
    return [
        row("single", "alone", name, unit, space[name], plane[name])
        for name, unit in single.UNITS.items()
        if name in space and name in plane
    ]


def _binary(space: pairs.Numbers, plane: pairs.Numbers) -> list[Row]:
    return [
        row("binary", case, name, meetings.QUANTITIES[name], space[case, name], plane[case, name])
        for case, name in space
        if (case, name) in plane
    ]


def _collective(space: dict[str, Value], plane: dict[str, Value]) -> list[Row]:
    case = f"{setting.COUNT} in {setting.DISH}"
    return [
        row("collective", case, name, unit, space[name], plane[name])
        for name, unit in many.QUANTITIES.items()
        if name in space and name in plane
    ]
