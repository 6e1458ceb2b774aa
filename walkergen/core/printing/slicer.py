"""Settings of slicers that the predicted masses assume, as files for slicers and as lines of the print sheet.

Print settings alone leave a user's profiles of printer (bed, nozzle, start code) and filament (temperatures,
density, flow) unchanged. A user without profiles loads the bundle alone. It takes bed and nozzle from the printer, and
the filament from the design's material.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from walkergen.core.printing import supports, walls
from walkergen.core.printing.printers import Printer
from walkergen.core.walker.spec import Material

FILAMENT_DIAMETER_MM = 1.75

INFILL_OVERLAP_PERCENT = 7
"""Overlap at which PrusaSlicer 2.5 puts as much plastic into a body as its mesh holds, within 1 %;
its own 25 % puts 4 to 5 % more (28 x 3 mm body, lines of 0.40 and 0.45 mm)."""

SUPPORT_SLOPE_DEG = f"{90.0 - supports.MAX_OVERHANG_DEG:g}"
"""Slope from the bed below which slicers put supports under an area."""

WIDTH_PREFIXES = ("", "external_perimeter_", "perimeter_", "infill_", "solid_infill_", "top_infill_", "first_layer_")

ORCA_WIDTH_PREFIXES = (
    "",
    "outer_wall_",
    "inner_wall_",
    "sparse_infill_",
    "internal_solid_infill_",
    "top_surface_",
    "initial_layer_",
)


class Setting(NamedTuple):
    """Setting of a slicer as a line of the print sheet."""

    name: str
    value: str
    reason: str


def sheet_settings(printer: Printer, orientations: Sequence[Setting], supported: Sequence[str]) -> list[Setting]:
    """Return the print sheet's settings for any slicer, and why the prediction depends on each.

    `orientations` are the settings on how parts lie. `supported` has the names of parts that need supports.
    """
    thin = (
        ""
        if printer.wall_generator == "arachne"
        else (", thin walls detected" if printer.thin_walls else ", thin walls NOT detected")
    )
    skirt = f"{printer.skirt_loops} loops, {printer.skirt_distance_mm:g} mm away"
    height = f"{printer.layer_height_mm:g} mm"
    return [
        *orientations,
        Setting("scale", "100 %, no XY or shrinkage compensation", "tilt and masses are as drawn"),
        Setting("nozzle", f"{printer.nozzle_mm:g} mm", "of your own printer profile"),
        Setting("layer height", f"{height}, the first layer too", "whole layers make the depth"),
        Setting("line width", f"{printer.line_width_mm:g} mm, everywhere", "legs are few lines"),
        Setting("wall generator", printer.wall_generator + thin, "decides the leg's plastic"),
        Setting("walls", f"{walls.PERIMETER_COUNT}", ""),
        Setting("infill", "100 %, rectilinear", "the masses M and m are those of solid parts"),
        Setting("infill overlap", f"{INFILL_OVERLAP_PERCENT} %", "more makes the body heavier"),
        Setting("flow", "100 %", "masses; extrusion multiplier of your own filament profile"),
        Setting("brim", f"{printer.brim_width_mm:g} mm", "what stays on a leg adds to m"),
        Setting("skirt", skirt if printer.skirt_loops else "none", ""),
        Setting("supports", f"on, from the bed only: under {', '.join(supported)}", "the body hangs over air there")
        if supported
        else Setting("supports", "none", ""),
        Setting("raft, elephant foot compensation", "none", "legs keep their thickness"),
    ]


def settings_files(printer: Printer, material: Material, start: str, has_supports: bool) -> Iterator[tuple[str, bytes]]:
    """Yield the name and bytes of each file of settings for a slicer. Names begin with `start`."""
    yield f"{start}.ini", prusaslicer_bundle(printer, material, has_supports)
    yield f"{start}_print.ini", prusaslicer_print(printer, has_supports)
    yield f"{start}_orca.json", orca_json(printer, has_supports)


def preset_name(printer: Printer) -> str:
    """Return the name under which slicers list the print settings."""
    return f"walkergen {printer.name}"


def prusaslicer_settings(printer: Printer, has_supports: bool = False) -> dict[str, str]:
    """Return values of print settings by PrusaSlicer's keys. Settings without a key here keep their defaults."""
    return {
        "layer_height": f"{printer.layer_height_mm:g}",
        "first_layer_height": f"{printer.layer_height_mm:g}",
        **{f"{part}extrusion_width": f"{printer.line_width_mm:g}" for part in WIDTH_PREFIXES},
        "perimeter_generator": printer.wall_generator,
        "thin_walls": f"{printer.thin_walls:d}",
        "min_bead_width": f"{100 * walls.MIN_BEAD_RATIO:g}%",
        "min_feature_size": f"{100 * walls.MIN_FEATURE_RATIO:g}%",
        "gap_fill_enabled": "1",
        "perimeters": f"{walls.PERIMETER_COUNT}",
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
        "support_material": f"{has_supports:d}",
        "support_material_buildplate_only": "1",
        "support_material_threshold": SUPPORT_SLOPE_DEG,
        "complete_objects": "0",
        "gcode_label_objects": "1",
    }


def printer_and_filament_settings(printer: Printer, material: Material) -> dict[str, str]:
    """Return values of printer and filament settings by PrusaSlicer's keys, for users without profiles of them.

    PrusaSlicer's defaults are a bed of 200 x 200 mm at 0 deg C and a filament of 0 g/cm3. Its end code leaves the bed
    hot. Start code, speeds and retraction keep its defaults.
    """
    (left, front), width, depth = printer.bed_corner, printer.bed_width_mm, printer.bed_depth_mm
    corners = ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
    nozzle, bed = f"{material.nozzle_deg_c}", f"{material.bed_deg_c}"
    return {
        "bed_shape": ",".join(f"{left + x:g}x{front + y:g}" for x, y in corners),
        "max_print_height": f"{printer.height_mm:g}",
        "nozzle_diameter": f"{printer.nozzle_mm:g}",
        "filament_diameter": f"{FILAMENT_DIAMETER_MM:g}",
        "filament_density": f"{material.density_g_cm3:g}",
        "first_layer_temperature": nozzle,
        "temperature": nozzle,
        "first_layer_bed_temperature": bed,
        "bed_temperature": bed,
        "end_gcode": r"M104 S0\nM140 S0\nG28 X0\nM84",
    }


def prusaslicer_bundle(printer: Printer, material: Material, has_supports: bool = False) -> bytes:
    """Return the bytes of a config bundle of PrusaSlicer, which its option --load reads too.

    The import of a bundle adds its section as a print preset. It inherits nothing, since presets whose parent a user
    lacks are dropped. The selected printer and filament stay. --load reads only the lines above the section, and needs
    no other file.
    """
    name, settings = preset_name(printer), prusaslicer_settings(printer, has_supports)
    lines = [
        f"# Print settings {name}, for PrusaSlicer 2.5 and later.",
        "# File > Import > Import Config Bundle (not Import Config, which changes the printer).",
        "# --load reads these first lines, and then needs no other file: bed and nozzle are those",
        "# of the printer, temperatures and density those of the design's material.",
        *_ini_lines(printer_and_filament_settings(printer, material)),
        *_ini_lines(settings),
        "",
        f"[print:{name}]",
        *_ini_lines(settings),
    ]
    return ("\n".join(lines) + "\n").encode()


def prusaslicer_print(printer: Printer, has_supports: bool = False) -> bytes:
    """Return the bytes of an .ini file with print settings only, to --load after profiles of printer and filament."""
    lines = [
        f"# Print settings {preset_name(printer)}, for PrusaSlicer 2.5 and later.",
        "# With --load after your own printer and filament, which they leave alone.",
        *_ini_lines(prusaslicer_settings(printer, has_supports)),
    ]
    return ("\n".join(lines) + "\n").encode()


def orca_settings(printer: Printer, has_supports: bool = False) -> dict[str, str]:
    """Return values of print settings by the keys of OrcaSlicer and Bambu Studio. Other settings keep their defaults.

    Each program ignores keys of the other: OrcaSlicer's `only_one_wall_top` is Bambu Studio's
    `top_one_wall_type`, and `top_bottom_infill_wall_overlap` is OrcaSlicer's alone. "zig-zag" is
    Bambu Studio's rectilinear, and OrcaSlicer translates it.
    """
    height, width = f"{printer.layer_height_mm:g}", f"{printer.line_width_mm:g}"
    overlap = f"{INFILL_OVERLAP_PERCENT}%"
    return {
        "layer_height": height,
        "initial_layer_print_height": height,
        **{f"{part}line_width": width for part in ORCA_WIDTH_PREFIXES},
        "wall_generator": printer.wall_generator,
        "detect_thin_wall": f"{printer.thin_walls:d}",
        "min_bead_width": f"{100 * walls.MIN_BEAD_RATIO:g}%",
        "min_feature_size": f"{100 * walls.MIN_FEATURE_RATIO:g}%",
        "wall_loops": f"{walls.PERIMETER_COUNT}",
        "only_one_wall_top": "0",
        "top_one_wall_type": "not apply",
        "sparse_infill_density": "100%",
        "sparse_infill_pattern": "zig-zag",
        "infill_wall_overlap": overlap,
        "top_bottom_infill_wall_overlap": overlap,
        "brim_type": "outer_only" if printer.brim_width_mm else "no_brim",
        "brim_width": f"{printer.brim_width_mm:g}",
        "skirt_loops": f"{printer.skirt_loops}",
        "skirt_distance": f"{printer.skirt_distance_mm:g}",
        "skirt_height": "1",
        "elefant_foot_compensation": "0",
        "xy_contour_compensation": "0",
        "xy_hole_compensation": "0",
        "raft_layers": "0",
        "enable_support": f"{has_supports:d}",
        "support_on_build_plate_only": "1",
        "support_threshold_angle": SUPPORT_SLOPE_DEG,
        "enable_prime_tower": "0",
        "print_sequence": "by layer",
    }


def orca_json(printer: Printer, has_supports: bool = False) -> bytes:
    """Return the bytes of a JSON file with print settings, a "process preset" of OrcaSlicer and Bambu Studio.

    The preset inherits nothing and so fits every printer: the import silently drops a preset whose
    parent is not installed. Both programs identify a process by `print_settings_id`. Bambu Studio
    skips a preset whose version begins with a number above its own.
    """
    name = preset_name(printer)
    preset = {
        "type": "process",
        "name": name,
        "print_settings_id": name,
        "inherits": "",
        "from": "User",
        "version": "1.10.0.0",
        **orca_settings(printer, has_supports),
    }
    return (json.dumps(preset, indent=4) + "\n").encode()


def _ini_lines(settings: Mapping[str, str]) -> list[str]:
    return [f"{key} = {value}" for key, value in settings.items()]
