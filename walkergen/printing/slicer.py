"""Slicer: the settings on which the predicted masses rest, for PrusaSlicer and in words."""

from collections.abc import Sequence
from typing import NamedTuple

from walkergen.printing import walls
from walkergen.printing.printers import Printer

FILAMENT_MM = 1.75

INFILL_OVERLAP_PERCENT = 7
"""Overlap at which PrusaSlicer 2.5 puts as much plastic into a body as its mesh holds, within 1 %;
its own 25 % puts 4 to 5 % more (28 x 3 mm body, lines of 0.40 and 0.45 mm)."""

WIDTHS = ("", "external_perimeter_", "perimeter_", "infill_", "solid_infill_", "top_infill_",
          "first_layer_")  # fmt: skip


class Setting(NamedTuple):
    """Setting of a slicer as a line of the print sheet."""

    name: str
    value: str
    reason: str


def sheet_settings(printer: Printer, orientations: Sequence[Setting]) -> list[Setting]:
    """List the settings for any slicer, and why the prediction depends on each.

    `orientations` are the lines that say how parts lie.
    """
    thin = "" if printer.wall_generator == "arachne" else (
        ", thin walls detected" if printer.thin_walls else ", thin walls NOT detected"
    )  # fmt: skip
    skirt = f"{printer.skirt_loops} loops, {printer.skirt_distance_mm:g} mm away"
    height = f"{printer.layer_height_mm:g} mm"
    return [
        *orientations,
        Setting("scale", "100 %, no XY or shrinkage compensation", "tilt and masses are as drawn"),
        Setting("nozzle", f"{printer.nozzle_mm:g} mm", ""),
        Setting("layer height", f"{height}, the first layer too", "whole layers make the depth"),
        Setting("line width", f"{printer.line_width_mm:g} mm, everywhere", "legs are few lines"),
        Setting("wall generator", printer.wall_generator + thin, "decides the leg's plastic"),
        Setting("walls", f"{walls.PERIMETERS}", ""),
        Setting("infill", "100 %, rectilinear", "the masses M and m are those of solid parts"),
        Setting("infill overlap", f"{INFILL_OVERLAP_PERCENT} %", "more makes the body heavier"),
        Setting("flow", "100 %", "masses"),
        Setting("brim", f"{printer.brim_width_mm:g} mm", "what stays on a leg adds to m"),
        Setting("skirt", skirt if printer.skirt_loops else "none", ""),
        Setting("supports, raft, elephant foot compensation", "none", "legs keep their thickness"),
    ]


def prusaslicer_settings(printer: Printer) -> dict[str, str]:
    """Settings by PrusaSlicer's keys; all others are left to its defaults."""
    width, depth = printer.bed_width_mm, printer.bed_depth_mm
    left, front = printer.bed_corner
    corners = [(left, front), (left + width, front), (left + width, front + depth),
               (left, front + depth)]  # fmt: skip
    return {
        "bed_shape": ",".join(f"{x:g}x{y:g}" for x, y in corners),
        "max_print_height": f"{printer.height_mm:g}",
        "nozzle_diameter": f"{printer.nozzle_mm:g}",
        "filament_diameter": f"{FILAMENT_MM:g}",
        "extrusion_multiplier": "1",
        "layer_height": f"{printer.layer_height_mm:g}",
        "first_layer_height": f"{printer.layer_height_mm:g}",
        **{f"{part}extrusion_width": f"{printer.line_width_mm:g}" for part in WIDTHS},
        "perimeter_generator": printer.wall_generator,
        "thin_walls": f"{printer.thin_walls:d}",
        "min_bead_width": f"{100 * walls.LEAST_BEAD:g}%",
        "min_feature_size": f"{100 * walls.LEAST_FEATURE:g}%",
        "gap_fill_enabled": "1",
        "perimeters": f"{walls.PERIMETERS}",
        "fill_density": "100%",
        "fill_pattern": "rectilinear",
        "infill_overlap": f"{INFILL_OVERLAP_PERCENT}%",
        "brim_type": "outer_only",
        "brim_width": f"{printer.brim_width_mm:g}",
        "skirts": f"{printer.skirt_loops}",
        "skirt_distance": f"{printer.skirt_distance_mm:g}",
        "skirt_height": "1",
        "min_skirt_length": "0",
        "elefant_foot_compensation": "0",
        "xy_size_compensation": "0",
        "raft_layers": "0",
        "support_material": "0",
        "complete_objects": "0",
        "gcode_label_objects": "1",
    }


def prusaslicer_ini(printer: Printer) -> bytes:
    """Configuration file that PrusaSlicer imports, or loads with --load."""
    lines = [f"# {printer.name}, for PrusaSlicer 2.5 and later: File > Import > Import Config"]
    lines += [f"{key} = {value}" for key, value in prusaslicer_settings(printer).items()]
    return ("\n".join(lines) + "\n").encode()
