"""PrusaSlicer at work on our plates: G-code of a plate, walker by walker, leg by leg.

Tests are skipped where a program is absent, except in CI (CI=true), which installs it: .ci/run.
"""

import os
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import gcode
import maker_profile
import numpy as np
import pytest

from walkergen.core.printing import packing as plate
from walkergen.core.printing import slicer
from walkergen.core.printing.packing import Part, Placement, Plate
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb

IN_CI = os.environ.get("CI") == "true"


def program(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        reason = f"{name} is not installed (Debian: apt-get install prusa-slicer admesh)"
        if IN_CI:
            pytest.fail(reason)
        pytest.skip(reason)
    return found


def slice_model(model: Path, ini: Path) -> subprocess.CompletedProcess[str]:
    """Slice a file into G-code next to it, with the maker's own profile and our settings."""
    words = [
        program("prusa-slicer"),
        "--load",
        str(ini.with_name("yours.ini")),
        "--load",
        str(ini),
        "--dont-arrange",
        "--export-gcode",
        "--output",
        str(model.with_suffix(".gcode")),
        str(model),
    ]
    return subprocess.run(words, capture_output=True, text=True, check=False, timeout=120)


def print_of(model: Path, ini: Path) -> gcode.Printed:
    result = slice_model(model, ini)
    assert result.returncode == 0, result.stdout + result.stderr
    return gcode.read_gcode(model.with_suffix(".gcode").read_text())


def laid_out(
    designs: list[Design], printer: Printer, folder: Path, one: Plate | None = None
) -> tuple[list[Placement], Path]:
    """Write a plate of unchecked designs, with the printer's settings next to it."""
    meshes = [solids.build(design).walker for design in designs]
    parts = [Part.from_mesh(f"part{index}", mesh) for index, mesh in enumerate(meshes)]
    if one is None:
        (one,) = plate.pack(parts, printer)
    model = folder / "unchecked.3mf"
    model.write_bytes(plate.plate_3mf(one, parts, meshes, printer, "unchecked"))
    (folder / "unchecked.ini").write_bytes(slicer.prusaslicer_print(printer))
    (folder / "yours.ini").write_text(maker_profile.ini(printer))
    return list(one.placements), model


class Walker(NamedTuple):
    """One printed walker of a sliced plate."""

    name: str
    """Its label in the G-code."""
    design: Design
    printer: Printer
    lines: gcode.Lines
    """In the design's frame."""

    @property
    def limb(self) -> Limb:
        """Back leg, like which the front one is."""
        return self.design.limbs[0]

    @property
    def layers(self) -> int:
        return round(self.design.size.depth / self.printer.layer_height_mm)

    def plastic_between(self, low: float, high: float) -> np.ndarray:
        """Plastic by layer and leg (back, front) between two heights y of the design, mm^3."""
        lines, tilt, foot = self.lines, self.limb.tilt, self.foot
        start, end = (np.clip(points[:, 1], low, high) for points in (lines.start, lines.end))
        length = np.abs(lines.end[:, 1] - lines.start[:, 1])
        level = (lines.start[:, 1] > low) & (lines.start[:, 1] < high)
        share = np.where(length > 0, np.abs(end - start) / np.where(length > 0, length, 1), level)
        middle = 0.5 * (lines.start + lines.end)
        # Halfway between the back leg and the front one's brace, at any height.
        front = middle[:, 0] > 0.5 * np.tan(tilt) * (middle[:, 1] - foot)
        layer = np.rint(lines.z / self.printer.layer_height_mm).astype(int) - 1
        plastic = np.zeros((self.layers, 2))
        np.add.at(plastic, (layer, front.astype(int)), share * lines.volume)
        return plastic

    @property
    def bottom(self) -> float:
        return -0.5 * self.design.size.thickness

    @property
    def foot(self) -> float:
        return self.limb.foot_height

    @property
    def legs(self) -> np.ndarray:
        """Plastic below the body by layer and leg."""
        return self.plastic_between(self.foot - 1.0, self.bottom)


def walkers_of(
    printed: gcode.Printed, designs: list[Design], where: list[Placement], printer: Printer
) -> list[Walker | None]:
    """The labelled object that lies at each placement; None where there is none."""
    lines, corner = printed.lines, np.array(printer.bed_corner)
    highs = [
        np.maximum(lines.start, lines.end)[lines.item == item].max(axis=0) - corner
        for item in range(len(printed.items))
    ]
    found: list[Walker | None] = []
    for placed in where:
        at, design = np.array([placed.x, placed.y]), designs[placed.part]
        vertices = solids.build(design).walker.vertices[:, :2]
        size = np.ptp(vertices, axis=0)
        # By the body's upper right corner, which is there even when legs are not; the centre of a
        # line lies half a line inside the part.
        near = [
            item
            for item, high in enumerate(highs)
            if np.abs(at + size - 0.5 * printer.line_width_mm - high).max() < 0.05
        ]
        if len(near) != 1:
            found.append(None)
            continue
        shift = corner + at - vertices.min(axis=0)
        own = gcode.Lines(*(field[lines.item == near[0]] for field in lines))
        moved = own._replace(start=own.start - shift, end=own.end - shift)
        found.append(Walker(printed.items[near[0]][0], design, printer, moved))
    return found
