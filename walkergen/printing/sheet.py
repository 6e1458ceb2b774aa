"""Print sheet: instructions for a lab technician to print, check and weigh a batch."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

from walkergen.printing import checks, slicer, walls
from walkergen.printing.checks import Finding
from walkergen.printing.packing import Part, Plate
from walkergen.printing.printers import Printer
from walkergen.walker import mass
from walkergen.walker.design import Design
from walkergen.walker.solids import Solids


class Weight(NamedTuple):
    """Expected masses of one walker, g."""

    name: str
    whole_g: float
    """Mass of the mesh of body and both legs."""
    leg_g: float
    """Mass of the mesh of one leg outside the body, with its brace."""
    plastic: float
    """Expected plastic in a leg over that of its mesh."""
    tolerance: float
    """Relative uncertainty of `plastic`."""


def weigh(name: str, design: Design, built: Solids, printer: Printer) -> Weight:
    """Weigh a walker by its meshes and the density of its material."""
    density = 1e-3 * design.material.density_g_cm3
    whole, leg = (mass.weigh(mesh, density).mass for mesh in (built.walker, built.legs[0]))
    tolerance = walls.TOLERANCE[design.kind]
    return Weight(name, whole, leg, walls.leg_plastic(design.limbs[0], printer), tolerance)


class Batch(NamedTuple):
    """Plates printed from files whose names begin with `stem`."""

    stem: str
    printer: Printer
    plates: Sequence[Plate]
    parts: Sequence[Part]
    form: str
    """Name of the file for weighed masses."""


def to_markdown(
    batch: Batch, weights: Sequence[Weight], findings: Sequence[Finding], legend: str
) -> str:
    """Format the sheet as Markdown; `legend` tells printed parts apart, and may be empty."""
    printer = batch.printer
    sections = [
        f"# Print sheet: {batch.stem}, {printer.description or printer.name}",
        _steps(batch.stem),
        _settings(printer, batch.stem),
        _contents(batch),
        *([f"## Which part is which\n\n{legend.strip()}"] if legend else []),
        _findings(findings),
        _weighing(weights, batch.form),
    ]
    return "\n\n".join(sections) + "\n"


def facts(printer: Printer, findings: Sequence[Finding]) -> dict[str, Any]:
    """Facts of the sheet for the manifest: PrusaSlicer's settings and every finding."""
    return {
        "prusaslicer": slicer.prusaslicer_settings(printer),
        "findings": [finding._asdict() for finding in checks.grouped(findings)],
    }


def _steps(stem: str) -> str:
    return (
        "## Print\n\n"
        f"1. PrusaSlicer: File > Import > Import Config, `{stem}.ini`. Another slicer: enter the "
        "settings below.\n"
        "2. Choose your filament's temperatures; change nothing else.\n"
        "3. Open a plate's 3MF. Keep names and places: do not arrange, turn, scale or merge. "
        "(PrusaSlicer shows copies under one name; a plate of one kind alone under the file's, "
        "unless it was made with --prusaslicer.)\n"
        "4. Slice. In the preview every leg must show plastic in every layer.\n"
        "5. Print; take the parts off cold, by the body; cut off any brim.\n\n"
        f"Without a window: `prusa-slicer --load {stem}.ini --dont-arrange --export-gcode "
        f"--output {stem}_1.gcode {stem}_1.3mf` (without --output the file takes a part's name, "
        "and the next plate overwrites it)."
    )


def _settings(printer: Printer, stem: str) -> str:
    rows = [(one.name, one.value, one.reason) for one in slicer.sheet_settings(printer)]
    return (
        "## Settings on which the prediction rests\n\n"
        f"Printer profile {printer.name}; exact keys in `{stem}.ini`.\n\n"
        + _table(("setting", "value", "because"), rows)
    )


def _contents(batch: Batch) -> str:
    rows = []
    for number, one in enumerate(batch.plates, start=1):
        counts = Counter(placement.part for placement in one.placements)
        for part, copies in sorted(counts.items()):
            name = batch.parts[part].name
            rows.append((f"`{batch.stem}_{number}.3mf`", name, str(copies)))
    told = f"`{batch.stem}.csv` and the pictures beside it show which copy lies where.\n\n"
    return "## What is on which plate\n\n" + told + _table(("file", "part", "copies"), rows)


def _findings(findings: Sequence[Finding]) -> str:
    told = [f"- **{one.level}** {checks.line(one)}" for one in checks.grouped(findings)]
    return "## Checks before the print\n\n" + ("\n".join(told) or "Nothing found.")


def _weighing(weights: Sequence[Weight], form: str) -> str:
    rows = [
        (one.name, f"{one.whole_g:.4f}", f"{one.leg_g:.4f}",
         f"{one.leg_g * one.plastic:.4f} ± {one.leg_g * one.tolerance:.4f}", "")
        for one in weights
    ]  # fmt: skip
    return (
        "## After the print: weigh\n\n"
        f"Weigh every part, without its brim, to 1 mg or better, and write it into `{form}`; "
        "`walkergen predict` takes it by `--weights`. Cut the legs "
        "off one spare part of each kind, flush with the body, and weigh them together: half of "
        "that is a leg. Speeds rest on both masses.\n\n"
        + _table(
            ("part", "whole by mesh, g", "leg by mesh, g", "leg as sliced, g", "weighed, g"), rows
        )
    )


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
