"""Card of a walker: measured, judged, and written as JSON, a page and inputs for other programs."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from walkergen.analysis.tracks import Units
from walkergen.crowd import card as cards
from walkergen.crowd.card import Card
from walkergen.crowd.cards import inputs, page, report, walker_card, walled
from walkergen.crowd.cards import walker_motion as measured
from walkergen.crowd.cards.report import CardReport
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.crowd.cards.walled import Walled
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.walker import names, solids
from walkergen.walker.design import Design

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
    card = walker_card.of(scene, design, mass, numbers)
    if not walls:
        return report.of(card, numbers)
    against = walled.simulated(scene, design, mass, card.speed_mm_s, progress)
    return report.of(with_walls(card, against, numbers), numbers, against)


def of_film(path: Path, units: Units, scene: Scene, design: Design) -> CardReport:
    """Card of filmed walkers of a design, on the plate of a scene. Raises InputError."""
    mass = solids.mass_of(design)
    numbers = measured.filmed(path, units, scene)
    return report.of(walker_card.of(scene, design, mass, numbers), numbers)


def of_file(path: Path) -> CardReport:
    """Card that was written before, or by hand. Raises InputError for what is none."""
    return report.of(cards.read(path), None)


def with_walls(card: Card, against: Walled, numbers: Measured) -> Card:
    """Card that says how walls turn the walker."""
    by_wall, runs = against.by_wall, against.runs
    torque = walled.torque(by_wall.turning, numbers.turning.time, card.inertia_g_mm2)
    return card.model_copy(
        update={
            "wall_alignment": walker_card.known(by_wall.alignment, runs),
            "wall_turning_rad_s": walker_card.known(by_wall.turning, runs),
            "wall_torque_g_mm2_s2": walker_card.known(torque, runs),
        }
    )


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
