"""Sheet on how to measure a calibration plate with a ruler, a scale and a phone, step by step."""

from collections.abc import Sequence
from pathlib import Path

from walkergen.core import Design, Printer
from walkergen.core.printing.print_sheet import markdown_table
from walkergen.guests.lab import beams
from walkergen.guests.lab.calibrate import form, parts
from walkergen.guests.lab.calibrate.parts import DrawnStrip

HOUSEHOLD_WEIGHTS = (
    ("1 cm of office paper, 80 g/m2, as wide as A4 (21 cm)", 0.168),
    ("nut M3", 0.38),
    ("nut M4", 0.81),
    ("nut M5", 1.23),
    ("1 euro cent", 2.30),
    ("dime (US)", 2.268),
    ("cent (US)", 2.50),
    ("nut M6", 2.5),
    ("2 euro cents", 3.06),
    ("5 euro cents", 3.92),
    ("10 euro cents", 4.10),
    ("nickel (US)", 5.00),
    ("nut M8", 5.2),
    ("quarter (US)", 5.67),
    ("20 euro cents", 5.74),
    ("1 euro", 7.50),
    ("50 euro cents", 7.80),
    ("2 euros", 8.50),
    ("nut M10", 11.6),
    ("nut M12", 17.3),
)
"""Everyday objects and their weights (g): coins from their mints, steel nuts from DIN 934, paper from its grammage."""

MAX_WEIGHT_DIFFERENCE = 0.35
"""Largest relative difference between a computed weight and the everyday object named for it."""


def nearest_weight(grams: float) -> str:
    """Return the everyday object whose weight is nearest to `grams`, with its weight, or "" if none is near."""
    name, weight = min(HOUSEHOLD_WEIGHTS, key=lambda pair: abs(pair[1] - grams))
    return f"{name} ({weight:g})" if abs(weight - grams) <= MAX_WEIGHT_DIFFERENCE * grams else ""


def to_markdown(strips: Sequence[DrawnStrip], design: Design, printer: Printer) -> str:
    """Return the sheet's part on measuring as Markdown: the text in the assets, with tables of the strips."""
    words = Path(__file__).with_name("assets").joinpath("measuring.md").read_text(encoding="utf-8")
    return words.format(
        form=form.FORM_FILE,
        bend=f"{beams.MAX_BEND:.0%}",
        parts=_parts_table(strips, design, printer),
        weights=_weights_table(strips),
        rings=_rings_table(strips),
    )


def _parts_table(strips: Sequence[DrawnStrip], design: Design, printer: Printer) -> str:
    rows = [
        (part.name, f"{part.strip.thickness:g} x {part.strip.width:g}", f"{part.strip.length:g}", _number_label(part))
        for part in strips
    ]
    long, wide, high = parts.block_size(printer)
    walker = f"{design.name}, {design.tilt_deg:g} deg, {design.kind} legs"
    rows += [("block", f"{long:g} x {wide:g} x {high:g}", "", "the plain block"), ("walker", walker, "", "the walker")]
    return markdown_table(("part", "drawn, mm", "free length, mm", "which"), rows)


def _number_label(part: DrawnStrip) -> str:
    return f"number {part.name.rpartition('_')[2]} on its block"


def _weights_table(strips: Sequence[DrawnStrip]) -> str:
    """Return the table of weights that bend each strip a little and much, with everyday objects of that weight."""
    rows = []
    for part in strips:
        light, heavy = ((f"{grams:.2g}", nearest_weight(grams)) for grams in (part.light_g, part.heavy_g))
        rows.append((part.name, *light, *heavy, f"{parts.HEAVY_BEND_RATIO * part.strip.length:.1f}"))
    return markdown_table(("strip", "light, g", "as", "heavy, g", "as", "sinks by about, mm"), rows)


def _rings_table(strips: Sequence[DrawnStrip]) -> str:
    rows = [
        (part.name, f"{part.ring_hz:.0f}", f"{20.0 / part.ring_hz:.2f}", f"{part.ring_hz * 4.0:.0f}") for part in strips
    ]
    return markdown_table(("strip", "rings at about, Hz", "20 swings, s", "half as long, Hz"), rows)
