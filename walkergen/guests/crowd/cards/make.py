"""Card of a walker: measure it from runs or films, and write it as JSON and as a page."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from walkergen import film_fields
from walkergen.analysis.track_files import Units
from walkergen.core import (
    Design,
    Folder,
    InputError,
    MassProperties,
    Progress,
    Quantity,
    Scene,
    mass_of,
    part_name,
    result_folder,
)
from walkergen.files import web_page
from walkergen.guests.crowd.cards import card as cards
from walkergen.guests.crowd.cards import overdamped, report, walker_motion
from walkergen.guests.crowd.cards.card import Card, field_quantity
from walkergen.guests.crowd.cards.report import CardReport
from walkergen.guests.crowd.cards.walker_motion import Measured
from walkergen.guests.crowd.read_population import is_card
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.readers.walkers import top_outline
from walkergen.request import PAPER_WALKER, PLANE_SCENE, choose_scene

CARD_FILE = "card.json"


def run(request: CrowdRequest, progress: Progress) -> CardReport:
    """Measure a single walker, from runs or from the tracks of a film. Write its card and return the report."""
    source = request.design or PAPER_WALKER
    given = request.inputs()
    if is_card(source):
        raise InputError("‹design›: is a card already. Give it with ‹count›, and leave ‹card› out.", "card")
    walker = given.single_member(source, request.tilt, request.legs)
    scene = given.scene(choose_scene(request.scene, [walker], PLANE_SCENE))
    inputs: dict[str, Any] = {"design": walker.model_dump(mode="json"), "scene": scene.model_dump(mode="json")}
    if request.tracks is None:
        request.check_unset("is only for ‹tracks›", "fps", "mm_per_px", "unit", "y_down")
        result = from_design(scene, walker, progress)
        return write(result, inputs, request.out or default_folder(walker), request.pictures)
    request.check_unset("is for simulated runs, not for ‹tracks›", "seconds", "runs", "seed")
    units = film_fields.units(request.fps, request.mm_per_px, request.y_down, request.unit)
    folder = result_folder(request.tracks, request.out, "card")
    result = from_film(request.tracks, units, scene, walker)
    return write(result, {"file": request.tracks.name, **units._asdict(), **inputs}, folder, request.pictures)


def default_folder(design: Design) -> Path:
    """Return the default folder of a design's card: out/NAME/card_PART."""
    return Path("out") / design.name / f"card_{part_name(design)}"


def from_design(scene: Scene, design: Design, progress: Progress) -> CardReport:
    """Return the report of a card, measured from simulated runs of one walker. Raises InputError on failure."""
    mass = mass_of(design)
    motion = walker_motion.simulate_walker(scene, design, mass, progress)
    return report.make_report(make_card(scene, design, mass, motion), motion)


def from_film(path: Path, units: Units, scene: Scene, design: Design) -> CardReport:
    """Return the report of a card, measured from tracks of a design's filmed walkers. Raises InputError on failure."""
    motion = walker_motion.measure_film(path, units, scene)
    return report.make_report(make_card(scene, design, mass_of(design), motion), motion)


def make_card(scene: Scene, design: Design, mass: MassProperties, motion: Measured) -> Card:
    """Make the card of a design from a measured motion. Raises InputError if a number that it needs is unknown."""
    estimates = motion.motion.estimates
    needed = {
        "speed_mm_s": ("speed", estimates["speed"]),
        "velocity_relaxation_s": ("relaxation", motion.velocity.time),
        "turning_rad_s": ("mean turning", estimates["turning_bias"]),
        "rotational_diffusion_rad2_s": ("rotational diffusion", estimates["rotational_diffusion"]),
        "translational_diffusion_mm2_s": ("translational diffusion", motion.translation),
    }
    other = {
        "turning_sd_rad_s": estimates["turning_scatter"],
        "sideways_relaxation_s": motion.sideways,
        "turning_relaxation_s": motion.turning.time,
        "delay_s": motion.delay.mean,
        "sideways_mm_s": estimates["sideways_speed"],
        "self_alignment_per_mm": motion.aligning,
    }
    for what, number in needed.values():
        if number.value is None:
            raise InputError(f"the {what} is unknown: {number.refused}. Use ‹runs=›16, or more tracks.")
    numbers: dict[str, Any] = {
        field: _optional_quantity(field, number, motion.runs)
        for field, number in [*((field, number) for field, (_, number) in needed.items()), *other.items()]
    }
    centre = walker_motion.centre_of_mass(mass)
    outline = [contour - centre for contour in top_outline.outline_of(design, mass)]
    length = float(np.ptp(np.concatenate(outline)[:, 0]))
    speed, turning, rotation = (estimates[key] for key in ("speed", "turning_bias", "rotational_diffusion"))
    return Card(
        name=design.name,
        scene=scene.name,
        mass_g=float(mass.total),
        inertia_g_mm2=walker_motion.yaw_inertia(mass),
        outline_mm=[[[float(x), float(y)] for x, y in contour] for contour in outline],
        restitution=scene.crowd.restitution,
        friction=scene.crowd.friction,
        wall_restitution=scene.arena.wall_restitution,
        wall_friction=scene.arena.wall_friction,
        overdamped=overdamped.assess_inertia(speed, turning, rotation, motion.velocity, length),
        **numbers,
    )


def _optional_quantity(field: str, number: Quantity, runs: int) -> Quantity | None:
    """Return a measured number as the quantity of a card's `field`; None if it has no value."""
    if number.value is None:
        return None
    return field_quantity(field, float(number.value), None if number.se is None else float(number.se), runs)


def write(result: CardReport, inputs: Mapping[str, Any], folder: Path, pictures: bool) -> CardReport:
    """Write card.json, tables, page, figure, and a manifest with `inputs`, into a folder. Return the report."""
    result = replace(result, folder=folder)
    with Folder(folder) as target:
        target.write(CARD_FILE, cards.to_json(result.card))
        result.write(target, pictures)
        target.write("card.html", render_page(result, pictures))
        target.finish(dict(inputs))
    return result


def render_page(result: CardReport, pictures: bool) -> bytes:
    """Return one HTML file with tables and notes, and figures if `pictures` are wanted."""
    parts = [web_page.from_markdown(result.markdown())]
    if pictures:
        from walkergen.files import figures  # brings matplotlib

        for draw in result.figures.values():
            address = web_page.data_url("image/png", figures.png(draw()))
            parts.append(Markup('<img alt="{}: figure" src="{}">').format(result.title, address))
    return web_page.render(result.title, Markup("\n").join(parts), ("part.css", "page.css")).encode()
