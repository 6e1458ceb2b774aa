"""Three checks of crowds in a plane, in the order of Weber and others (arXiv 1304.4760).

Single: a card comes back from walkers alone; binary: pairs that meet; collective: crowds, and the
densest of them with one thing changed, which says why it differs. Of each the same places, films and
analysis in space and in a plane, all from rest.
"""

from functools import partial
from pathlib import Path

from evidence.crowd_checks import checks, crowds, meetings, reasons, report, setting
from evidence.crowd_checks.parts import Parts
from evidence.crowd_checks.report import Checked, compare_cases
from evidence.crowd_checks.setting import Size
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.walker import solids
from walkergen.files.report import Report
from walkergen.guests.crowd.flat import lammps_engine

STEPS = 7


def compare_crowds(size: Size, command: str, folder: Path, progress: Progress) -> Report:
    """Run the checks, and write crowd_checks.md and .csv; `command`: words that make them.

    Equal sizes give equal bytes on one machine. What ends it loses one part, of some minutes: the same
    command goes on. Raises InputError where LAMMPS is absent.
    """
    lammps_engine.find_lammps()
    parts = Parts(folder, size)
    result = report.make_report(run_checks(size, parts, progress), folder, describe_runs(size, command))
    with Folder(folder, "") as target:
        result.write(target, pictures=False)
    parts.remove()
    return result


def run_checks(size: Size, parts: Parts, progress: Progress) -> Checked:
    """Rows of all three checks, and what they say of friction and of the stationary state."""
    design = setting.load_walker()
    mass = solids.mass_of(design)
    progress("alone in space", 0, STEPS)
    assumed, alone = parts.load_or_make("alone", lambda: checks.simulate_alone_in_space(size, design, mass))
    progress("pairs in space", 1, STEPS)
    met, rubbed = parts.load_or_make("pairs", lambda: checks.simulate_pairs_in_space(size, design, mass, assumed))
    card = checks.set_friction(assumed, rubbed)
    progress("alone in the plane", 2, STEPS)
    rows = [*compare_cases("single", alone, checks.simulate_alone_in_plane(size, card))]
    progress("pairs in the plane", 3, STEPS)
    rows += compare_cases("binary", met, checks.simulate_pairs_in_plane(size, card))
    progress("crowds in space", 4, STEPS)
    named = {f"packing {packing:g}": packing for packing in setting.PACKINGS}
    space = {
        case: parts.load_or_make(
            f"space {case}", partial(crowds.simulate_in_space, size, design, mass, card, at, size.crowd_runs)
        )
        for case, at in named.items()
    }
    progress("crowds in the plane", 5, STEPS)
    more = setting.PLANE_RUNS_PER_RUN * size.crowd_runs
    plane = {
        case: parts.load_or_make(f"plane {case}", partial(crowds.simulate_in_plane, size, card, at, more))
        for case, at in named.items()
    }
    numbers = [{case: one.numbers for case, one in of.items()} for of in (space, plane)]
    rows += compare_cases("collective", *numbers)
    gained = {case: (one.gained, plane[case].gained) for case, one in space.items()}
    progress("crowds changed in one thing", 6, STEPS)
    changed = reasons.measure_changes(size, parts, design, mass, card)
    progress("done", STEPS, STEPS)
    return Checked(rows, assumed.friction, card.friction, rubbed, gained, changed)


def describe_runs(size: Size, command: str) -> list[str]:
    """How the rows were made, a sentence each."""
    met = size.pair_runs * size.pairs
    packings = ", ".join(f"{packing:g}" for packing in setting.PACKINGS)
    return [
        f"made by `{command}`: {setting.WALKER} in {setting.PLATE}, seed {size.seed}",
        f"alone: {size.alone_runs} runs of {size.alone_seconds:g} s in space, {checks.ALONE_PER_SIDE**2} in the plane",
        f"pairs: up to {met} of each meeting in space, {setting.PLANE_RUNS_PER_RUN * met} in the plane; each "
        f"walks {meetings.MIN_WAY_MM:g} to {meetings.MAX_WAY_MM:g} mm until they meet",
        f"crowds: packings {packings} of {setting.DISH}, {size.crowd_runs} runs in space, "
        f"{setting.PLANE_RUNS_PER_RUN * size.crowd_runs} in the plane, {size.crowd_seconds:g} s each after "
        f"{size.crowd_discard_seconds:g} s from rest; changed in one thing, {size.changed_runs} in space and "
        f"{setting.PLANE_RUNS_PER_RUN * size.changed_runs} in the plane",
    ]
