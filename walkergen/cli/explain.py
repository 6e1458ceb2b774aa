"""The command `explain`."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt

if TYPE_CHECKING:
    from walkergen.scene import Scene
    from walkergen.simulation.costs import Explained
    from walkergen.simulation.model import Plan
    from walkergen.walker.design import Design


def explain(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    model: opt.Model = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    keys: opt.Values = None,
    cost: Annotated[
        bool, typer.Option(show_default=False, help="Measure the CPU time that each effect costs.")
    ] = True,
    json: opt.AsJson = False,
) -> None:
    """Say which effects a scene calls for, why, how large they are and what they cost."""
    from walkergen.simulation import costs
    from walkergen.simulation.plan import prepare
    from walkergen.walker import solids

    inputs = loading.inputs(
        keys, "design scene",
        friction=friction, gamma=gamma, frequency=frequency, model=model,
    )  # fmt: skip
    resolved_scene, chosen = inputs.scene(scene), inputs.one(design, tilt, legs)
    mass = solids.mass_of(chosen)
    plan = prepare(resolved_scene, chosen, mass)
    with show.progress("explain", wanted=True) as progress:
        rows = costs.explain(plan, chosen, mass, measured=cost, progress=progress)
    if json:
        show.rows_as_json(rows)
    else:
        _show_effects(plan, rows, resolved_scene, chosen)


def _show_effects(
    plan: "Plan", rows: "Sequence[Explained]", scene: "Scene", design: "Design"
) -> None:
    """Print which effects are on, why, how large they are and what they cost."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("effect", "", "size", "cost", "why"):
        table.add_column(heading, justify="right" if heading in ("size", "cost") else "left")
    for row in rows:
        cost = "-" if row.cost is None else f"x {row.cost:.2f}"
        why = f"{row.reason} ({row.meaning})" + (f"; {row.switch}" if row.switch else "")
        table.add_row(row.effect, "on" if row.on else "off", f"{row.number:.3g}", cost, why)
    print(f"{design.name}, tilt {design.tilt_deg:g} deg, on {scene.name}:")
    print(f"model {plan.resolved.model}")
    show.table(table)
    show.text("cost: CPU time over that of the scene without the effect, whose motion differs too")
