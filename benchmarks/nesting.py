"""Rows of walkers against dense nesting by spyrrow: how many more fit on each shipped printer.

    pip install spyrrow
    python benchmarks/nesting.py --seconds 10

spyrrow packs outlines into a strip as deep as the bed, half a turn allowed, within a time limit; a
number fits when its strip is no longer than the bed. It also says whether equal seeds give equal
strips, without which equal input would not give equal files.
"""

import argparse

import manifold3d
import numpy as np
import spyrrow

from walkergen.core.printing import packing as plate
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

MOST, STEP = 1.5, 0.05
"""Most copies tried, and the steps down from them, over those in rows."""


def outline(mesh: Mesh) -> list[tuple[float, float]]:
    solid = manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices.copy(), mesh.triangles.astype(np.uint64)))
    (polygon,) = solid.project().to_polygons()
    return [(float(x), float(y)) for x, y in polygon]


def strip(shape: list[tuple[float, float]], count: int, printer: Printer, seconds: int) -> float:
    """Length of the shortest strip found for `count` copies, mm."""
    depth = printer.bed_depth_mm - 2.0 * plate.border_width(printer)
    item = spyrrow.Item("walker", shape, count, [0.0, 180.0])
    config = spyrrow.StripPackingConfig(
        total_computation_time=seconds, seed=1, num_workers=1, min_items_separation=plate.spacing(printer)
    )
    return float(spyrrow.StripPackingInstance("plate", depth, [item]).solve(config).width)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=10, help="for each strip")
    parser.add_argument("--tilt", type=float, default=10.0, help="deg")
    words = parser.parse_args()
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=words.tilt)
    mesh = solids.build(design).walker
    part, shape = plate.Part.from_mesh("walker", mesh), outline(mesh)
    print(f"{'printer':14s}{'rows':>6s}{'nested':>8s}{'gain':>7s}   strip twice, same seed (mm)")
    for name in templates.names("printers"):
        printer = templates.load(name, "printers", Printer)
        rows, room = plate.capacity(part, printer), printer.bed_width_mm
        room -= 2.0 * plate.border_width(printer)
        ladder = [int(rows * share) for share in np.arange(MOST, 1.0, -STEP)]
        nested = next((n for n in ladder if strip(shape, n, printer, words.seconds) <= room), rows)
        twice = [strip(shape, 40, printer, words.seconds) for _ in range(2)]
        gain = 100.0 * (nested / rows - 1.0)
        print(f"{name:14s}{rows:6d}{nested:8d}{gain:6.0f} %   {twice[0]:.3f} {twice[1]:.3f}")


if __name__ == "__main__":
    main()
