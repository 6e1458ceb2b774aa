"""Report of a family: a row a walker, as `predict` has, with runs, marks, and the figure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from walkergen.commands.family import chart_data
from walkergen.commands.family.chart_data import ChartData
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.walker import names
from walkergen.core.walker.design import Design
from walkergen.files.report import Report
from walkergen.points import speed_table
from walkergen.points.members import Member

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from walkergen.files.viewer import Part


@dataclass(frozen=True, kw_only=True, repr=False)
class FamilyReport(Report):
    """Members of a family, with their speeds and the folder of their files."""

    members: Sequence[Member]

    def markdown(self) -> str:
        """Return the page of the tables and lines, and of the marks that distinguish parts.

        Returns
        -------
        str
            Text in Markdown.
        """
        marks = names.legend([member.design for member in self.members])
        return super().markdown() + (f"\n## Marks\n\n{marks}" if marks else "")

    def _repr_html_(self) -> str:
        from walkergen.files import viewer

        return viewer.render_frame(view_parts(self.members), str(self.folder)) + super()._repr_html_()


def view_parts(walkers: Sequence[Member], speeds: bool = True) -> "list[Part]":
    """Return the walkers for a 3D view, each with its speed in words if `speeds`."""
    from walkergen.files.viewer import Part

    return [
        Part(
            names.part_name(one.design),
            one.design.kind,
            *one.mesh,
            prediction.describe_briefly(one.row) if speeds else "",
        )
        for one in walkers
    ]


def make_report(
    design: Design,
    scene: Scene,
    mode: str,
    walkers: Sequence[Member],
    folder: Path,
    shown: ChartData | None = None,
    why: bool = True,
) -> FamilyReport:
    """Make the report of a design's walkers, and of the figure's additional speeds, if it is drawn.

    `why`: whether the sources of the speeds are explained.
    """
    with_notes = why or speed_table.needs_notes(walkers, scene)
    tables = speed_table.tables("family", design.name, walkers, with_notes)
    facts = {"rows": list(tables[0])}
    if shown is not None:
        tables.append(chart_data.table(shown))
    return FamilyReport(
        name="family",
        title=design.name,
        headline=speed_table.headline(design.name, walkers),
        caption=speed_table.caption(design, scene, mode) if why else "",
        tables=tables,
        facts=facts,
        lines=speed_table.note_lines(walkers, with_notes),
        folder=folder,
        members=walkers,
        figures={} if shown is None else {"speed": _figure(design, scene, walkers, shown)},
    )


def make_parts_report(design: Design, walkers: Sequence[Member], folder: Path) -> FamilyReport:
    """Make the report of a design's walkers without speeds."""
    table = speed_table.masses_table("family", design.name, walkers)
    return FamilyReport(
        name="family",
        title=design.name,
        headline=speed_table.count_walkers(design.name, walkers),
        tables=[table],
        facts={"rows": list(table)},
        folder=folder,
        members=walkers,
    )


def _figure(design: Design, scene: Scene, walkers: Sequence[Member], shown: ChartData) -> "Callable[[], Figure]":
    """Return a function that draws speed against tilt."""
    drive, contact = scene.drive, scene.contact
    shaken = drive.motor_in_words or f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g"
    others = {"simulated": any(one.simulated for one in walkers), "measured": shown.measured is not None}
    kinds = " and ".join(["predicted", *(kind for kind, drawn in others.items() if drawn)])
    kinds = f", {kinds}" if any(others.values()) else ""
    title = f"{design.name} on {scene.name} ({shaken}){kinds}: {speed_table.describe_fastest(walkers)}"
    title = title.replace(" %", "\N{NO-BREAK SPACE}%")
    note = (
        f"{contact.origin}: restitution {contact.restitution:g} ± {contact.restitution_sd:g}, "
        f"friction {contact.friction:g} ± {contact.friction_sd:g}"
    )
    simulated = [member.simulated for member in walkers if member.simulated is not None]

    def draw() -> "Figure":
        from walkergen.commands.family import figures

        rows = [member.row for member in walkers]
        return figures.speed_figure(rows, shown, title, simulated, not design.has_family_tilt, note)

    return draw
