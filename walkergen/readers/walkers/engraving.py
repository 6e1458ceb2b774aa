"""Engraving: the marks of a design as notches, strokes and letters of its body."""

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.shapes.modeller import extrude
from walkergen.core.walker.body import lay_down
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Polygon
from walkergen.readers.drawings.lettering import text_outline
from walkergen.readers.walkers import marks


def add_notches(design: Design, corners: Polygon) -> Polygon:
    """Return a rectangle with notches in its upper edge. `corners`: from the lower left counter-clockwise."""
    length, thickness = design.size.length, design.size.thickness
    y = 0.5 * thickness
    edge = [
        corner
        for notch in marks.notches(design.marks, design.family.tilt_deg, design.tilt_deg, length, thickness)
        for corner in ((notch.right, y), (notch.right, notch.bottom), (notch.left, notch.bottom), (notch.left, y))
    ]
    return np.array([*corners[:3], *edge, corners[3]])


def engraved_profiles(design: Design) -> list[Polygon]:
    """Return the outlines of the digits or the text to engrave into a body's side, mm from the body's middle."""
    if design.letters:
        return _text_polygons(design, design.size.length, design.size.thickness)
    strokes = marks.digit_strokes(design.marks, design.tilt_deg, design.size.thickness)
    return [np.array([(s.left, s.bottom), (s.right, s.bottom), (s.right, s.top), (s.left, s.top)]) for s in strokes]


def cut_letters(body: Mesh, design: Design) -> Mesh:
    """Return the mesh of a body in plan view with the marks' text cut into its upper side. Raises GeometryError."""
    text = _text_polygons(design, design.size.length, design.size.depth)
    depth, size = design.marks.depth_mm, design.size
    cutter = lay_down(extrude(text, 2.0 * depth, pieces=True), size)
    raised = cutter.vertices + np.array([0.0, size.thickness - depth, 0.0])
    solid, letters = modeller.to_solid(body), modeller.to_solid(Mesh(raised, cutter.triangles))
    cut = modeller.check_solid(solid - letters)
    # Half of the tool is above the body, the other half makes the pockets
    lost = 2.0 * (solid.volume() - cut.volume())
    if lost < letters.volume() * (1.0 - 1e-6) or len(modeller.split_bodies(cut)) != 1:
        raise GeometryError(
            f"{_format_mark(design)}: the letters leave the outline. Make text_height_mm smaller.", _mark_key(design)
        )
    return modeller.to_mesh(cut)


def _text_polygons(design: Design, length: float, height: float) -> list[Polygon]:
    """Return the outlines of the marks' text. Raises GeometryError if it does not fit a face of this size, mm."""
    mark, source = design.marks, _mark_key(design)
    polygons = text_outline(design.letters, mark.text_height_mm or 0.5 * height, connected=False, source=source)
    low = np.min([polygon.min(axis=0) for polygon in polygons], axis=0)
    high = np.max([polygon.max(axis=0) for polygon in polygons], axis=0)
    wide, tall = high - low
    if wide > length - 2.0 * mark.line_mm or tall > height - 2.0 * mark.line_mm:
        raise GeometryError(
            f"{_format_mark(design)}: is {wide:.2f} x {tall:.2f} mm, but its face is only "
            f"{length:g} x {height:g} mm, with a free line at the edge. Make text_height_mm smaller.",
            _mark_key(design),
        )
    return polygons


def _format_mark(design: Design) -> str:
    """Return the key and value of the engraved letters, for messages, such as marks.text = 'A1'."""
    return f"{_mark_key(design)} = {design.letters!r}"


def _mark_key(design: Design) -> str:
    """Return the key that defines the engraved letters."""
    return "marks.text" if design.marks.kind == "text" else "marks.serial"
