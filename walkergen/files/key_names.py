"""Names of keys as text with their units, for axes."""

import re

UNITS_BY_SUFFIX = {
    "_g_cm3": "g/cm³",
    "_mm_s": "mm/s",
    "_percent": "%",
    "_seconds": "s",
    "_gpa": "GPa",
    "_deg": "deg",
    "_mm": "mm",
    "_um": "µm",
    "_us": "µs",
    "_hz": "Hz",
    "_g": "g",
    "_s": "s",
}
"""Units by the suffixes of keys. A longer suffix comes before a suffix that it ends in."""

SPECIAL_NAMES = {
    "drive.gamma": "peak acceleration of the plate (g)",
    "drive.eccentric_g_mm": "eccentric moment of the motor (g mm)",
    "drive.axis": "axis of the motor",
    "run.discard_seconds": "discarded time (s)",
    "run.seconds": "measured time (s)",
    "run.step_us": "step (µs)",
}
"""Names of keys that cannot be made from the parts of the key."""

TABLE_SUBJECTS = {"drive": "the plate", "contact": "", "run": "a run", "weighed": ""}
"""Subjects of the tables of keys, if different from their names; "" for none."""

LEG_PATTERN = re.compile(r"legs\[(\d+)\]")


def format_key(key: str) -> str:
    """Return the name of a key as text with its unit, such as "tilt of the legs (deg)" for legs.tilt_deg."""
    short_key = key.removeprefix("scene.")
    if short_key in SPECIAL_NAMES:
        return SPECIAL_NAMES[short_key]
    end = next((end for end in UNITS_BY_SUFFIX if short_key.endswith(end)), "")
    *tables, name = short_key.removesuffix(end).split(".")
    words = name.replace("_", " ").replace("youngs", "Young's")
    subject = _table_subject(tables[-1]) if tables else ""
    return (f"{words} of {subject}" if subject else words) + (f" ({UNITS_BY_SUFFIX[end]})" if end else "")


def _table_subject(table: str) -> str:
    """Return the noun for a table of keys, such as "the legs", or "leg 2" for legs[2]."""
    numbered = LEG_PATTERN.fullmatch(table)
    if numbered:
        return f"leg {numbered[1]}"
    return TABLE_SUBJECTS.get(table, f"the {table.replace('_', ' ')}")
