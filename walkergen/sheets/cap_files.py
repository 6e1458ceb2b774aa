"""Caps of printed walkers as files: their plates, a list with the walker of each cap, and a paper sheet."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from walkergen.core.errors import InputError
from walkergen.core.files.tables import csv_text
from walkergen.core.printing import packing
from walkergen.core.printing.findings import About, Finding, make_finding, with_place
from walkergen.core.printing.packing import Part
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import mass
from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import Cap
from walkergen.readers.walkers import caps

COLUMNS = ("number", "walker", "kind", "dictionary", "marker_mm", "tile_mm", "height_mm", "mass_g")
"""Columns of caps.csv."""

MIN_CELL_LINES = 2.0
"""Smallest side of a cell of a printed marker, in printed lines. A white cell between black ones is then visible."""


class CappedWalker(NamedTuple):
    """Walker, or copy of a walker, with its cap. `item`: name of the walker or copy."""

    item: str
    cap: Cap
    density_g_cm3: float

    @property
    def grams(self) -> float:
        """Mass of the cap, g."""
        return mass.weigh(caps.build_tile(self.cap), 1e-3 * self.density_g_cm3).mass


def number_caps(designs: Sequence[Design], items: Sequence[str]) -> list[CappedWalker]:
    """Return the caps of walkers that have one, numbered consecutively from the first design's number.

    `items`: name of each walker or copy. Raises InputError for more caps than the dictionary has markers, and for caps
    that `track` could not read in one film.
    """
    with_caps = [
        (design, item, design.cap) for design, item in zip(designs, items, strict=True) if design.cap is not None
    ]
    capped: list[CappedWalker] = []
    for offset, (design, item, cap) in enumerate(with_caps):
        first = with_caps[0][2]
        number = first.number + offset
        if (cap.dictionary, cap.marker_mm) != (first.dictionary, first.marker_mm):
            raise InputError(
                f"{design.name}: cap.dictionary = {cap.dictionary!r}, cap.marker_mm = "
                f"{cap.marker_mm:g}: must be those of the other walkers, {first.dictionary!r}, "
                f"{first.marker_mm:g}: a film has markers of one kind"
            )
        if number >= cap.count:
            more = "Use '4x4_100'." if cap.count < 100 else "Make fewer copies."
            raise InputError(
                f"{design.name}: cap.dictionary = {cap.dictionary!r}: has numbers up to "
                f"{cap.count - 1}, but {len(with_caps)} caps from number {first.number} on need more. {more}"
            )
        numbered_cap = cap.model_copy(update={"number": number})
        density = cap.density(design.material.density_g_cm3)
        capped.append(CappedWalker(item, numbered_cap, density))
    return capped


def findings(capped: Sequence[CappedWalker], printer: Printer) -> list[Finding]:
    """Return the findings on printed caps whose cells are too small for the printer's lines."""
    printed = {entry.cap.model_copy(update={"number": 0}): entry for entry in capped if entry.cap.kind != "paper"}
    least = MIN_CELL_LINES * printer.line_width_mm
    what, change = "cells of the caps may close up", "raise cap.marker_mm, or print markers on paper"
    return [
        finding
        for cap, entry in printed.items()
        if cap.cell < least
        for finding in with_place(
            entry.item, [make_finding(About.CAPS, "warning", what, cap.cell, least, "mm", change)]
        )
    ]


def files(capped: Sequence[CappedWalker], printers: Sequence[Printer]) -> Iterator[tuple[str, bytes]]:
    """Yield names and bytes of the caps' files: caps.csv, caps.pdf, caps_PAGE.png, caps_PRINTER_NUMBER.3mf (or .stl).

    Caps of paper are only on the sheet, caps.pdf. Raises PlateError when a cap is too large for a printer.
    """
    from walkergen.sheets import cap_sheet  # brings matplotlib

    yield "caps.csv", csv_text(COLUMNS, map(_table_row, capped)).encode()
    pages = cap_sheet.draw_pages([entry.cap for entry in capped])
    yield "caps.pdf", cap_sheet.pdf(pages)
    for number, data in enumerate(cap_sheet.pngs(pages), start=1):
        yield f"caps_{number}.png", data
    printed = [entry.cap for entry in capped if entry.cap.kind != "paper"]
    meshes = [caps.build_tile(cap) for cap in printed]
    parts = [Part.from_mesh(f"cap_{cap.number:02d}", tile) for cap, tile in zip(printed, meshes, strict=True)]
    for printer in printers if printed else ():
        for number, plate in enumerate(packing.pack(parts, printer), start=1):
            name = f"caps_{printer.name}_{number}"
            suffix, data = packing.plate_file(plate, parts, meshes, printer, name)
            yield f"{name}{suffix}", data


def advice(capped: Sequence[CappedWalker]) -> list[str]:
    """Return the lines that explain how caps are made and glued, and what they weigh."""
    first, last = capped[0].cap, capped[-1].cap
    grams = " to ".join(dict.fromkeys(f"{limit([entry.grams for entry in capped]):.4f}" for limit in (min, max)))
    how = {
        "engraved": "print them face up and ink their pockets black",
        "raised": f"print them face up, and change to black at {first.thickness:g} mm",
        "paper": "print caps.pdf at 100 % and cut them out",
    }[first.kind]
    return [
        f"Caps have markers {first.number} to {last.number} of {first.dictionary}, "
        f"{first.marker_mm:g} mm wide: {how}. Glue each flat on the middle of the walker that "
        "caps.csv names, with its notch to the front.",
        f"A cap weighs {grams} g. Predictions of a design with this "
        "[cap] include it. Weigh walkers with their caps on.",
    ]


def _table_row(entry: CappedWalker) -> tuple[object, ...]:
    """Return the row of caps.csv for a walker's cap, with the values of COLUMNS."""
    cap = entry.cap
    height = cap.thickness + (cap.relief_mm if cap.kind == "raised" else 0.0)
    return (
        cap.number,
        entry.item,
        cap.kind,
        cap.dictionary,
        cap.marker_mm,
        round(cap.side, 6),
        round(height, 6),
        round(entry.grams, 7),
    )
