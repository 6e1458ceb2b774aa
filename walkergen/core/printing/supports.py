"""Supports and brim: whether a walker needs them, from its overhangs and its contact with the bed."""

import math
from collections.abc import Sequence

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.printing.findings import ROUNDING_MM
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import pockets, solids
from walkergen.core.walker.design import Design

MAX_OVERHANG_DEG = 45.0
"""Largest angle from the vertical at which walls print without supports, the usual rule."""

MIN_OVERHANG_MM2 = 1.0
"""Area over air above which a body prints with supports. Assumed: threads bridge that much."""

MIN_CONTACT_MM2 = 50.0
"""Area on the bed below which a part needs a brim. Assumed: the paper's walker (about 90 mm2) was printed without
mention of one."""

BRIM_MM = 5.0
"""Common width of a brim."""


def is_needed(design: Design, mesh: Mesh) -> bool:
    """Return whether a walker must print with supports from the bed. Its `mesh` is in printing orientation."""
    return not solids.is_printed_on_side(design) and overhang_area(design, mesh) > MIN_OVERHANG_MM2


def add_brim(printer: Printer, meshes: Sequence[Mesh], supported: Sequence[bool]) -> Printer:
    """Return the printer, with a brim added if a walker that prints with supports has little contact with the bed.

    Such a walker lies upside down, so that the brim does not touch its legs. A printer that has a brim is unchanged.
    """
    if printer.brim_width_mm == 0.0 and any(
        is_supported and contact_area(mesh, printer) < MIN_CONTACT_MM2
        for mesh, is_supported in zip(meshes, supported, strict=True)
    ):
        return printer.model_copy(update={"brim_width_mm": BRIM_MM})
    return printer


def contact_area(mesh: Mesh, printer: Printer) -> float:
    """Return the area of a part's first layer, by which it holds on to the bed, mm^2."""
    return section_area(mesh, 0.5 * printer.layer_height_mm)


def section_area(mesh: Mesh, height: float) -> float:
    """Return the area of a closed mesh's section at a height (mm) above its lowest point, mm^2."""
    return float(modeller.to_solid(mesh).slice(mesh.vertices[:, 2].min() + height).area())


def overhang_area(design: Design, mesh: Mesh) -> float:
    """Return the area of the body's faces over air that look down by more than MAX_OVERHANG_DEG, mm^2.

    The mesh lies upside down on z = 0. Legs, above the body, are not counted, nor are engraved
    letters, whose strokes are bridged. Pockets have a check of their own (pocket_checks).
    """
    if design.parts:
        plain_design = pockets.without_pockets(design)
        return overhang_area(plain_design, solids.orient_for_print(plain_design, solids.build(plain_design).walker))
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    downward_areas: Array = -0.5 * normals[:, 2]
    # 1e-9 more, so that rounding does not count faces of exactly that angle
    is_steep = downward_areas > (math.sin(math.radians(MAX_OVERHANG_DEG)) + 1e-9) * areas
    heights = corners[:, :, 2]
    engraving_depth = design.marks.depth_mm if design.letters else 0.0
    is_in_air = heights.max(axis=1) > mesh.vertices[:, 2].min() + engraving_depth + ROUNDING_MM
    is_body = heights.min(axis=1) < design.size.thickness - ROUNDING_MM
    return float(areas[is_steep & is_in_air & is_body].sum())
