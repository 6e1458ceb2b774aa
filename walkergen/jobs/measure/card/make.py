"""Card of a walker: measured, judged, and written as JSON, a page and inputs for other programs."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from walkergen import card as cards
from walkergen.analysis.estimates import Estimate
from walkergen.analysis.tracks import Units
from walkergen.card import Card, Known
from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.jobs.measure.card import inputs, measured, overdamped, page, report, walled
from walkergen.jobs.measure.card.measured import Measured
from walkergen.jobs.measure.card.report import CardReport
from walkergen.jobs.measure.card.walled import Walled
from walkergen.scene import Scene
from walkergen.walker import names, seen_above, solids
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

FILE = "card.json"


def folder_of(design: Design) -> Path:
    """Folder of a card by default: below out/ and the walker's name."""
    return Path("out") / design.name / f"card_{names.part(design)}"


def of_design(scene: Scene, design: Design, walls: bool, progress: Progress) -> CardReport:
    """Card of simulated runs of a walker alone, and if wanted against the wall of the scene's dish.

    Raises InputError before or after they run.
    """
    mass = solids.mass_of(design)
    if walls:
        walled.check(scene.crowd.dish)
    numbers = measured.simulated(scene, design, mass, progress)
    card = card_of(scene, design, mass, numbers)
    if not walls:
        return report.of(card, numbers)
    against = walled.simulated(scene, design, mass, card.speed_mm_s, progress)
    return report.of(with_walls(card, against, numbers), numbers, against)


def of_film(path: Path, units: Units, scene: Scene, design: Design) -> CardReport:
    """Card of filmed walkers of a design, on the plate of a scene. Raises InputError."""
    mass = solids.mass_of(design)
    numbers = measured.filmed(path, units, scene)
    return report.of(card_of(scene, design, mass, numbers), numbers)


def of_file(path: Path) -> CardReport:
    """Card that was written before, or by hand. Raises InputError for what is none."""
    return report.of(cards.read(path), None)


def card_of(scene: Scene, design: Design, mass: MassProperties, numbers: Measured) -> Card:
    """Card of a walker whose motion was measured.

    Raises InputError where one of the numbers that every card has is not known.
    """
    found = numbers.motion.estimates
    speed = _known("speed", found["speed"], numbers.runs)
    turning = _known("mean turning", found["turning_bias"], numbers.runs)
    rotation = _known("rotational diffusion", found["rotational_diffusion"], numbers.runs)
    away = measured.centre(mass)
    outline = [contour - away for contour in seen_above.outline_of(design, mass)]
    length = float(np.ptp(np.concatenate(outline)[:, 0]))
    return Card(
        name=design.name, scene=scene.name,
        mass_g=float(mass.total), inertia_g_mm2=measured.inertia(mass),
        outline_mm=[[[float(x), float(y)] for x, y in contour] for contour in outline],
        speed_mm_s=speed,
        velocity_relaxation_s=_known("relaxation", numbers.velocity.time, numbers.runs),
        turning_rad_s=turning,
        turning_sd_rad_s=_or_none(found["turning_scatter"], numbers.runs),
        turning_relaxation_s=_or_none(numbers.turning.time, numbers.runs),
        rotational_diffusion_rad2_s=rotation,
        translational_diffusion_mm2_s=_known(
            "translational diffusion", numbers.translation, numbers.runs
        ),
        delay_s=_or_none(numbers.delay.mean, numbers.runs),
        sideways_mm_s=_or_none(found["sideways_speed"], numbers.runs),
        restitution=scene.crowd.restitution, friction=scene.crowd.friction,
        wall_restitution=scene.arena.wall_restitution, wall_friction=scene.arena.wall_friction,
        overdamped=overdamped.judge(speed, turning, rotation, numbers.velocity, length),
    )  # fmt: skip


def with_walls(card: Card, against: Walled, numbers: Measured) -> Card:
    """Card that says how walls turn the walker."""
    by_wall, runs = against.by_wall, against.runs
    torque = walled.torque(by_wall.turning, numbers.turning.time, card.inertia_g_mm2)
    return card.model_copy(update={
        "wall_alignment": _or_none(by_wall.alignment, runs),
        "wall_turning_rad_s": _or_none(by_wall.turning, runs),
        "wall_torque_g_mm2_s2": _or_none(torque, runs),
    })  # fmt: skip


def write(result: CardReport, asked: Mapping[str, Any], folder: Path, pictures: bool) -> CardReport:
    """Write card.json, tables, page, figure and inputs for other programs into a folder."""
    result = replace(result, folder=folder)
    with Folder(folder) as target:
        target.write(FILE, cards.to_json(result.card))
        result.write(target, pictures)
        target.write("card.html", page.html(result, pictures))
        for name, text in inputs.all_of(result.card).items():
            target.write(name, text)
        target.finish(dict(asked))
    return result


def _known(what: str, estimate: Estimate, runs: int) -> Known:
    """Number of a card. Raises InputError where it is not known, with the reason."""
    if (known := _or_none(estimate, runs)) is None:
        raise InputError(f"the {what} is not known: {estimate.reason}; --runs 16, or more tracks")
    return known


def _or_none(estimate: Estimate, runs: int) -> Known | None:
    """Number of a card; None where it is not known."""
    if estimate.value is None:
        return None
    se = None if estimate.se is None else float(estimate.se)
    return Known(value=float(estimate.value), se=se, runs=runs)
