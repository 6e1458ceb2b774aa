"""What `simulate --uncertain` prints."""

from pathlib import Path
from typing import TYPE_CHECKING

from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.jobs.simulate.uncertain import Uncertain
    from walkergen.scene import Scene
    from walkergen.walker.design import Design


def simulate(
    scene: "Scene", design: "Design", draws: int, out: Path | None, json: bool, quiet: bool
) -> None:
    """Simulate uncertain prints and print their speeds, with what to measure next."""
    from rich import box
    from rich.table import Table

    from walkergen.jobs.simulate import prints
    from walkergen.jobs.simulate import uncertain as prints_of

    with show.progress("simulate", wanted=not quiet) as progress:
        found = prints_of.measure(scene, design, draws, progress)
    title = f"{design.name}, {design.tilt_deg:g} deg, {scene.name}"
    if out is not None:
        prints.write(found, out, title)
    if json:
        show.as_json(prints.as_dict(found))
        return
    if quiet:
        return
    table = Table(title=title, box=box.SIMPLE, show_header=False, padding=(0, 1))
    for name, value in prints.rows(found):
        table.add_row(name, value)
    show.table(table)
    if found.shares:
        _show_shares(found)
    if out is not None:
        print(f"draws.csv, shares.csv, uncertain.png and .pdf in {out}/")


def _show_shares(found: "Uncertain") -> None:
    """Print where the scatter between prints comes from."""
    from walkergen.jobs.simulate import prints
    from walkergen.points import speed_table

    title = "share of the variance between prints"
    show.table(speed_table.shares("shares", found.shares, title).rich())
    rest = f"{100 * found.unexplained:.0f} ± {100 * found.unexplained_se:.0f} %"
    show.text(f"{prints.UNEXPLAINED}: {rest} (heights of its corners, and what the fit misses)")
