"""Predictions for the members (walkers) of a family: masses and speeds, compared with weighed masses and runs."""

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType, SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.core.files.progress import Expect, Progress, ignore_estimate, part_progress, silent
from walkergen.core.scene import Scene
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.theory.prediction import Prediction
from walkergen.core.theory.speed import Mode
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.core.walker.solids import Solids
from walkergen.points import speed_prediction
from walkergen.points.speed_prediction import Model

if TYPE_CHECKING:
    from walkergen.core.numerics.quantity import Quantity
    from walkergen.core.walker.weighed_masses import Weighings


MAX_SIMULATED = 64
"""Maximum number of walkers that are simulated without a request, outside the surrogate: some seconds each, after a
forecast."""


class Simulated(NamedTuple):
    """Results of the simulated runs of a member, as in the table of its family."""

    speed: "Quantity"
    outcomes: str
    verdict: str
    """Agreement of the predicted speed with the simulated one."""


class Weighing(NamedTuple):
    """Weighed mass of a member and its mesh's mass; the field names are columns."""

    weighings: int
    """Number of weighings on which the row rests."""
    mass: "Quantity"
    """Mass of the whole walker used for the prediction."""
    mass_mesh_g: float
    speed_mesh_mm_s: float | None
    """Speed predicted with the mesh's masses."""


class Member(NamedTuple):
    """Walker of a design, with its mesh, masses and speeds."""

    design: Design
    name: str
    mesh: Mesh
    """Mesh of the finished walker, in the design's frame."""
    mass: MassProperties
    row: Prediction
    simulated: Simulated | None = None
    weighing: Weighing | None = None


def predict_members(
    designs: Sequence[Design],
    built: Sequence[Solids],
    scene: Scene,
    mode: Mode,
    weighed: "Mapping[str, Weighings]" = MappingProxyType({}),
    model: Model = "best",
    progress: Progress = silent,
    expect: Expect = ignore_estimate,
) -> Iterator[Member]:
    """Yield each design as a member: mesh, masses and predicted speed, with the same random numbers for all.

    `built`: solids of each design. `weighed`: masses from a balance by part name; members then also have the mass and
    speed of their mesh. With `model` "best", up to MAX_SIMULATED walkers outside the surrogate are simulated, after
    `expect` received the time that all take. Raises InputError, before the first member, for impossible masses.
    """
    named = [names.part_name(design) for design in designs]
    final = [
        _apply_weighings(design, parts, weighed, name)
        for name, design, parts in zip(named, designs, built, strict=True)
    ]
    masses = [solids.weigh(design, parts) for design, parts in zip(final, built, strict=True)]
    first: Model = "theory" if model == "theory" else "known"
    rows = [
        speed_prediction.predict(design, mass, scene, mode, first) for design, mass in zip(final, masses, strict=True)
    ]
    unknown = sum(row.speed_by == "theory" for row in rows)
    if model == "best" and unknown > MAX_SIMULATED:
        model = "known"
    if model == "best" and unknown:
        pairs = zip(final, masses, rows, strict=True)
        simulated = [(design, mass) for design, mass, row in pairs if row.speed_by == "theory"]
        expect(lambda: speed_prediction.expected_time(simulated, scene))
    done = 0
    for name, design, parts, mass, row in zip(named, final, built, masses, rows, strict=True):
        if model == "best" and row.speed_by == "theory":
            title = "its speed" if unknown == 1 else f"speeds of {unknown} walkers"
            part = part_progress(progress, done, unknown, title)
            row, done = speed_prediction.predict(design, mass, scene, mode, model, part), done + 1
        member = Member(design, name, parts.walker, mass, row)
        if weighed:
            member = member._replace(weighing=_compare_weighing(member, parts, scene, mode, weighed, model))
        yield member


def _apply_weighings(design: Design, parts: Solids, weighed: "Mapping[str, Weighings]", name: str) -> Design:
    """Return the design with masses from a balance; unchanged if neither the part `name` nor its load was weighed."""
    if not weighed:
        return design
    from walkergen.core.walker import weighed_masses

    design = weighed_masses.apply_carried_masses(design, weighed)
    if name not in weighed:
        return design
    return weighed_masses.apply_masses(design, parts, weighed[name], name)


def _compare_weighing(
    member: Member, parts: Solids, scene: Scene, mode: Mode, weighed: "Mapping[str, Weighings]", model: Model
) -> Weighing:
    """Return a member's mass from a balance, and its mass and predicted speed from the mesh alone."""
    from walkergen.core.walker import weighed_masses

    plain = weighed_masses.without_weighed_masses(member.design)
    mesh = solids.weigh(plain, parts)
    means = weighed.get(member.name, weighed_masses.Weighings())
    return Weighing(
        weighings=means.number,
        mass=weighed_masses.mass_with_error(float(member.mass.total), means, len(member.mass.legs)),
        mass_mesh_g=float(mesh.total),
        speed_mesh_mm_s=speed_prediction.predict(plain, mesh, scene, mode, model).speed.value,
    )


def columns(member: Member) -> dict[str, Any]:
    """Return all numbers of a member by column: its prediction and, if present, its runs and weighed mass."""
    found, runs = member.row.columns(), member.simulated
    if runs is not None:
        speed = runs.speed._replace(key="sim_speed").row(95, stem="sim_")
        found |= speed | {"sim_outcomes": runs.outcomes, "verdict": runs.verdict}
    if member.weighing is not None:
        from walkergen.core.numerics.quantity import column_values

        found |= column_values(member.weighing)
    return found


def row(member: Member) -> SimpleNamespace:
    """Return all numbers of a member as attributes of an object. Numbers with an error are of class Quantity."""
    found, runs, weighing = member.row._asdict(), member.simulated, member.weighing
    if runs is not None:
        found |= {"sim_speed": runs.speed, "sim_outcomes": runs.outcomes, "verdict": runs.verdict}
    return SimpleNamespace(**found, **(weighing._asdict() if weighing is not None else {}))
