"""Printer and filament profiles of a maker for PrusaSlicer, complete enough to print with.

Temperatures, density and codes are those of PLA on a Prusa MK3S; the bed and nozzle any printer's.
"""

from walkergen.core.printing.printers import Printer

HEATING = (
    "M104 S[first_layer_temperature]",
    "M140 S[first_layer_bed_temperature]",
    "M190 S[first_layer_bed_temperature]",
    "M109 S[first_layer_temperature]",
)

PROFILE = {
    "printer_model": "MK3S",
    "gcode_flavor": "marlin",
    "retract_length": "0.8",
    "use_relative_e_distances": "1",
    "before_layer_gcode": r";BEFORE_LAYER_CHANGE\nG92 E0.0\n",
    "machine_max_acceleration_extruding": "1250,960",
    "machine_max_acceleration_x": "1000,960",
    "machine_max_acceleration_y": "1000,960",
    "machine_max_feedrate_x": "200,100",
    "machine_max_feedrate_y": "200,100",
    "start_gcode": r'M862.3 P "MK3S"\n' + r"\n".join((*HEATING, "G28 W", "G80")),
    "end_gcode": r"M104 S0\nM140 S0\nM84",
    "filament_type": "PLA",
    "filament_diameter": "1.75",
    "filament_density": "1.24",
    "extrusion_multiplier": "1",
    "temperature": "210",
    "first_layer_temperature": "215",
    "bed_temperature": "60",
    "first_layer_bed_temperature": "60",
}


def profile(printer: Printer) -> dict[str, str]:
    """Settings by PrusaSlicer's keys, for a printer's bed and nozzle."""
    (left, front), width, depth = printer.bed_corner, printer.bed_width_mm, printer.bed_depth_mm
    corners = ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
    return PROFILE | {
        "bed_shape": ",".join(f"{left + x:g}x{front + y:g}" for x, y in corners),
        "max_print_height": f"{printer.height_mm:g}",
        "nozzle_diameter": f"{printer.nozzle_mm:g}",
    }


def ini(printer: Printer) -> str:
    """Profile as PrusaSlicer's File > Export > Export Config writes it."""
    return "".join(f"{key} = {value}\n" for key, value in profile(printer).items())
