"""Print sheet: instructions for a lab technician to print, check and weigh a batch, with its plastic and time."""

import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.files import formatting
from walkergen.core.printing import packing, slicer, walls
from walkergen.core.printing.findings import ROUNDING_MM, Finding, group_findings
from walkergen.core.printing.packing import Part, Plate
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass, names, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.sections import section_of
from walkergen.core.walker.solids import Solids

ON_SIDE_TEXT = "on its side, no supports"

LEGS_UP_TEXT = "upside down, its upper side on the bed, legs up"


def describe_orientation(design: Design, is_supported: bool) -> str:
    """Return words on how a walker lies on the bed, and whether supports are under it."""
    if solids.is_printed_on_side(design):
        return ON_SIDE_TEXT
    return f"{LEGS_UP_TEXT}, {'supports from the bed under the body' if is_supported else 'no supports'}"


RUN_DIRECTIONS = {1: "to the right, +x on the bed", -1: "to the left, -x on the bed", 0: "in no direction"}
"""Directions in which walkers run, as they lie on the bed, by the design's `run_direction`."""

OUTLINE_SPEED_MM_S, LINE_SPEED_MM_S = 20.0, 43.0
"""Time of a layer: its outline at the first speed, all its lines at the second, mm/s. Fitted to PrusaSlicer 2.5's own
times at its default speeds: the shipped walkers, 1 to 20 of them, on four printers, in layers of 0.1 to 0.3 mm."""

TIME_TOLERANCE = 0.25
"""Relative error of the time at those speeds: 14 % below to 24 % above in that fit."""


class Load(NamedTuple):
    """Plastic of one part."""

    grams: float
    """Mass as sliced, g."""
    density: float
    """Density of its material, g/cm^3."""
    sides: float
    """Area of its sides, mm^2; see `side_area`."""


class Estimate(NamedTuple):
    """Plastic and time of a plate, without skirt, brim and purge."""

    grams: float
    metres: float
    """Length of filament, m."""
    layers: int
    seconds: float
    """Time of the layers, s; see TIME_TOLERANCE."""


def side_area(mesh: Mesh) -> float:
    """Return the area of a mesh's sides, mm^2: the length of all layers' outlines times the height of a layer."""
    first, second, third = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    normals = 0.5 * np.cross(second - first, third - first)
    return float(np.hypot(normals[:, 0], normals[:, 1]).sum())


def plate_totals(plate: Plate, parts: Sequence[Part], loads: Sequence[Load], printer: Printer) -> Estimate:
    """Estimate plastic and time of a plate. `loads` are the plastic of one copy of each part, in their order."""
    placed = [placement.part for placement in plate.placements]
    copies, height = [loads[part] for part in placed], printer.layer_height_mm
    volume = sum(1e3 * load.grams / load.density for load in copies)
    lines = volume / (height * (printer.line_width_mm - walls.line_rounding(printer)))
    outlines = sum(load.sides for load in copies) / height
    tallest = max(parts[part].height for part in placed)
    return Estimate(
        grams=sum(load.grams for load in copies),
        metres=1e-3 * volume / (0.25 * math.pi * slicer.FILAMENT_DIAMETER_MM**2),
        layers=max(1, math.floor(tallest / height + 0.5 + ROUNDING_MM)),
        seconds=outlines / OUTLINE_SPEED_MM_S + lines / LINE_SPEED_MM_S,
    )


class LegWeight(NamedTuple):
    """Expected mass of a leg, or of each of several equal ones."""

    mesh_g: float
    """Mass of its mesh outside the body, with its brace, g; of several to a tenth of a microgram.
    """
    plastic: float
    """Expected plastic in it over that of its mesh."""
    tolerance: float
    """Relative uncertainty of `plastic`."""


class Weight(NamedTuple):
    """Expected masses of one walker."""

    name: str
    whole_g: float
    """Mass of the mesh of body and legs, g."""
    legs: list[tuple[LegWeight, str]]
    """Every distinct leg and its name: "leg" where all are equal, else as in "legs[1], legs[3]"."""
    load: Load
    """Plastic of the whole, its legs as sliced."""


def expected_masses(name: str, design: Design, built: Solids, printer: Printer) -> Weight:
    """Compute the expected masses of a walker from its solids, `built`, and from the plastic that the slicer lays."""
    density, is_on_side = 1e-3 * design.material.density_g_cm3, solids.is_printed_on_side(design)
    distinct = {id(mesh): mesh for mesh in built.legs}  # equal legs share theirs
    grams = {key: round(mass.weigh(mesh, density).mass, 7) for key, mesh in distinct.items()}
    leg_weights = {}
    for limb, mesh in zip(design.limbs, built.legs, strict=True):
        tolerance = section_of(limb).PLASTIC_TOLERANCE if is_on_side else walls.UPRIGHT_TOLERANCE
        leg_weights[limb] = LegWeight(grams[id(mesh)], walls.leg_plastic_ratio(limb, printer, is_on_side), tolerance)
    whole_g = mass.weigh(built.walker, density).mass
    sliced = whole_g + sum(leg_weights[limb].mesh_g * (leg_weights[limb].plastic - 1.0) for limb in design.limbs)
    lying = solids.orient_for_print(design, built.walker)
    load = Load(float(sliced), design.material.density_g_cm3, side_area(lying))
    return Weight(name, whole_g, walls.group_legs(design, leg_weights.__getitem__), load)


class Batch(NamedTuple):
    """Plates printed from files whose names begin with `stem`."""

    stem: str
    printer: Printer
    members: Sequence[Design]
    plates: Sequence[Plate]
    parts: Sequence[Part]
    form: str
    """Name of the file for weighed masses."""
    supported: Sequence[bool]
    """Whether each member prints with supports, in their order."""


def to_markdown(batch: Batch, weights: Sequence[Weight], findings: Sequence[Finding], legend: str) -> str:
    """Format the print sheet as Markdown. `weights` are in the order of parts. `legend` identifies printed parts."""
    printing = format_print_section(batch, [weight.load for weight in weights], findings, legend)
    paired = all(len(design.limbs) == 2 for design in batch.members)
    share = "half of that is a leg" if paired else "that over their number is leg_g, the mean leg"
    weighing = _read_asset("weighing.md").format(form=batch.form, share=share, weights=_weights_table(weights))
    return f"{printing}\n\n{weighing}"


def format_print_section(batch: Batch, loads: Sequence[Load], findings: Sequence[Finding], legend: str) -> str:
    """Format the print sheet as Markdown, without the section on weighing. `loads` are the plastic of each part."""
    printer, stem, ending, material = batch.printer, batch.stem, packing.plate_suffix(), batch.members[0].material
    supported = [
        name
        for name, is_supported in zip(names.part_names(batch.members), batch.supported, strict=True)
        if is_supported
    ]
    settings = slicer.sheet_settings(printer, orientation_settings(batch.members, batch.supported), supported)
    lines = [f"- **{finding.level}** {finding.line}" for finding in group_findings(findings)]
    return (
        _read_asset("sheet.md")
        .format(
            stem=stem,
            printer=printer.description or printer.name,
            preset=slicer.preset_name(printer),
            profile=printer.name,
            ENDING=ending[1:].upper(),
            put_in=_insertion_step(batch),
            slicing=f"--dont-arrange --export-gcode --output {stem}_1.gcode {stem}_1{ending}",
            nozzle=material.nozzle_deg_c,
            bed=material.bed_deg_c,
            settings=markdown_table(("setting", "value", "because"), settings),
            contents=_contents_table(batch),
            plastic=_plastic_table(batch, loads),
            legend=f"## Which part is which\n\n{legend.strip()}\n\n" if legend else "",
            findings="\n".join(lines) or "Nothing found.",
        )
        .rstrip("\n")
    )


def _read_asset(name: str) -> str:
    """Return the text of the template `name` of the print sheet."""
    return Path(__file__).with_name("assets").joinpath(name).read_text(encoding="utf-8")


def manifest_facts(printer: Printer, findings: Sequence[Finding], has_supports: bool) -> dict[str, Any]:
    """Return facts on a print for the manifest, by name: PrusaSlicer's settings and every finding."""
    return {
        "prusaslicer": slicer.prusaslicer_settings(printer, has_supports),
        "findings": [finding._asdict() for finding in group_findings(findings)],
    }


def _insertion_step(batch: Batch) -> str:
    """Return the print sheet's step 7, to insert motor and battery into pockets, or "" if no walker has them."""
    carried = dict.fromkeys(name for design in batch.members for name in design.parts)
    if not carried:
        return ""
    return (
        f"7. Weigh the bare part, then push the {' and the '.join(carried)} into the pockets, "
        "wires in the channel, and fix them with a drop of glue, none on the legs.\n"
    )


def body_facts(design: Design) -> dict[str, Any]:
    """Return facts on a body for the manifest, by name: hash of its file ("" without one), and repairs to its shape."""
    shape = design.shape
    return {"sha256": shape.sha256, "changes": list(shape.changes)}


def orientation_settings(members: Sequence[Design], supported: Sequence[bool]) -> list[slicer.Setting]:
    """Return the print sheet's lines on how walkers lie. If designs differ, each line names its designs.

    `supported` states whether each member prints with supports. A design does if one of its members does.
    """
    with_supports = {design.name for design, is_supported in zip(members, supported, strict=True) if is_supported}
    groups: dict[str, list[str]] = {}
    for name, design_members in names.group_by_design(members).items():
        groups.setdefault(describe_orientation(design_members[0], name in with_supports), []).append(name)
    return [
        slicer.Setting(
            "orientation" if len(groups) == 1 else f"orientation of {', '.join(designs)}",
            f"as in the file: {text}",
            "layers run across the leg's width"
            if text == ON_SIDE_TEXT
            else "layers lie across the leg: weaker, softer",
        )
        for text, designs in groups.items()
    ]


def _contents_table(batch: Batch) -> str:
    """Return a Markdown table of the parts and copies in the file of each plate."""
    rows = []
    for number, plate in enumerate(batch.plates, start=1):
        # Copies with serial numbers are parts of their own, under one name
        placed = [batch.parts[placement.part] for placement in plate.placements]
        for (name, direction), copies in Counter((part.name, part.run_direction) for part in placed).items():
            way = "" if direction is None else RUN_DIRECTIONS[direction]
            rows.append((f"`{batch.stem}_{number}{packing.plate_suffix()}`", f"`{name}`", str(copies), way))
    return markdown_table(("file", "part", "copies", "legs lean for a run"), rows)


def _plastic_table(batch: Batch, loads: Sequence[Load]) -> str:
    """Return a Markdown table of the plastic, filament, layers and time of each plate."""
    rows = []
    for number, plate in enumerate(batch.plates, start=1):
        amounts = plate_totals(plate, batch.parts, loads, batch.printer)
        rows.append(
            (
                f"`{batch.stem}_{number}{packing.plate_suffix()}`",
                f"{amounts.grams:.2f}",
                f"{amounts.metres:.2f}",
                str(amounts.layers),
                formatting.format_duration(amounts.seconds / amounts.layers),
                formatting.format_duration(amounts.seconds),
            )
        )
    error = f"{100 * TIME_TOLERANCE:g} %"
    headings = (
        "file",
        "plastic, g",
        f"filament {slicer.FILAMENT_DIAMETER_MM:g} mm, m",
        "layers",
        "mean layer",
        f"all, ± {error}",
    )
    return markdown_table(headings, rows)


def _weights_table(weights: Sequence[Weight]) -> str:
    """Return a Markdown table of the expected masses (g) of walkers and legs, with a blank column for weighed ones."""
    rows = [
        (
            f"`{weight.name}`",
            f"{weight.whole_g:.4f}",
            ("" if name == "leg" else f"{name}: ") + f"{leg.mesh_g:.4f}",
            f"{leg.mesh_g * leg.plastic:.4f} ± {leg.mesh_g * leg.tolerance:.4f}",
            "",
        )
        for weight in {weight.name: weight for weight in weights}.values()
        for leg, name in weight.legs
    ]
    return markdown_table(("part", "whole by mesh, g", "leg by mesh, g", "leg as sliced, g", "weighed, g"), rows)


def markdown_table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Format headings and rows of cells as a Markdown table."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
