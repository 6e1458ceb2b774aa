"""Effects of a scene: which are on, why, how large they are, and what they cost."""

from walkergen.files import report
from walkergen.files.progress import Progress
from walkergen.files.report import Column, Report
from walkergen.scene import Scene
from walkergen.simulation import costs
from walkergen.simulation.costs import Explained
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design


def _why(row: Explained) -> str:
    return f"{row.reason} ({row.meaning})" + (f"; {row.switch}" if row.switch else "")


COLUMNS = (
    report.text("effect", "effect"),
    Column("", lambda row: "on" if row.on else "off"),
    report.number("size", "number", 3),
    Column("cost", lambda row: "-" if row.cost is None else f"x {row.cost:.2f}", True),
    Column("why", _why),
)


def explain(scene: Scene, design: Design, measured: bool, progress: Progress) -> Report:
    """Say which effects a scene calls for; `measured` times those that are on and can be off.

    Raises InputError for a scene that no model can simulate.
    """
    mass = solids.mass_of(design)
    plan = prepare(scene, design, mass)
    rows = costs.explain(plan, design, mass, measured=measured, progress=progress)
    return Report(
        name="explain",
        title="Effects",
        caption=f"{design.name}, tilt {design.tilt_deg:g} deg, on {scene.name}: model {plan.resolved.model}",
        tables=[report.table("effects", rows, COLUMNS)],
        facts={"rows": [row._asdict() for row in rows]},
        lines=["cost: CPU time over that of the scene without the effect, whose motion differs too"],
    )
