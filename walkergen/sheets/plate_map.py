"""Plate map: every part at its position on the bed, from above, labelled with design, tilt and copy."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import manifold3d
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox

from walkergen.core.numerics import Array
from walkergen.core.printing.packing import Placement, Plate
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.files import figures

MAP_INCHES = 10.0
"""Longer side of the bed, or of its visible part, in the picture, inches."""
MARGIN_SHARE, MIN_ASPECT = 0.03, 0.3
"""Margin around the parts over the longer side of the bed. Smallest height of a map over its width."""
FULL_BED_SHARE = 0.6
"""A map shows the whole bed if the parts and their margin take more than this share of its area."""
INSET_SHARE = 0.12
"""Width of the small picture of the bed over that of the map."""
LINE_INCHES = 0.175
"""Height of a line of words below the picture, inches."""
FONT_PT = 10.0
"""Size of the words around a map, points."""


class Margins(NamedTuple):
    """Margins around a map, inches, for the axes' numbers and names, the heading and the legend."""

    left: float
    right: float
    """Without the margin for the small picture of the bed."""
    below: float
    """Without the names of designs."""
    above: float


MARGINS_INCHES = Margins(0.7, 0.4, 0.6, 0.65)
MAX_LISTED_DESIGNS = 12
"""Maximum number of designs listed below a map; the print sheet names all."""
LEGS_SHADE = 0.6
"""Brightness of legs that point up, over that of their body."""
LEG_CLEARANCE_MM = 1e-3
"""Height above the body from which on a mesh counts as legs, mm: more than the rounding errors of a mesh."""
LETTER_WIDTH_RATIO = 0.65
"""Width of a letter over the height of the font."""
ARROW_SHARE, MIN_ARROW_MM = 0.8, 0.8
"""Length of the arrow of a part's run over the gap between parts, and its smallest length, mm."""
THUMBNAIL_INCHES, THUMBNAIL_DPI = 2.56, 100


@figures.style({})
def draw_pictures(
    printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], plate: Plate, title: str
) -> tuple[bytes, bytes]:
    """Draw the map of one plate and its thumbnail: two PNG files."""
    view = printer, members, meshes, plate
    return draw_map(*view, title), draw_thumbnail(*view)


def draw_map(printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], plate: Plate, title: str) -> bytes:
    """Draw the map of one plate as PNG. The label of a part is its tilt in degrees and the copy's number.

    If `members` have several designs, labels begin with the design's letter.
    """
    letters = names.design_letters(members)
    used = [members[part].name for part in sorted({placed.part for placed in plate.placements})]
    design_lines = _legend_lines({name: letters[name] for name in used if letters})
    figure = Figure()
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    _draw_parts(axes, printer, members, meshes, plate)
    area = _map_area(axes, printer)
    scale = MAP_INCHES / max(area.width, area.height)
    labels = "design, tilt (deg) - copy" if letters else "tilt (deg) - copy"
    count = f"{len(plate.placements)} part{'s' if len(plate.placements) > 1 else ''}"
    heading = f"{title}: {count}; {labels}" + ("; ► runs this way" if any(one.run_direction for one in members) else "")
    inset_width = 0.0 if area.x0 < 0.0 else INSET_SHARE * scale * area.width
    _set_size(figure, axes, (scale * area.width, scale * area.height), inset_width, (heading, *design_lines))
    _show_area(axes, area, printer)
    _label_parts(axes, members, meshes, plate, scale)
    axes.set_xlabel("\n".join(("x (mm); front of the bed", *design_lines)), fontsize=FONT_PT)
    axes.set_ylabel("y (mm)", fontsize=FONT_PT)
    axes.set_title(heading, fontsize=FONT_PT)
    figure.legend(loc="upper right", ncols=2, frameon=False, fontsize=9, borderaxespad=0.2)
    return figures.png(figure, dpi=130)


def _set_size(figure: Figure, axes: Axes, size: tuple[float, float], inset_width: float, lines: Sequence[str]) -> None:
    """Set the size of a map (inches), and of the figure with everything around it.

    `inset_width`: width of the small picture next to the map, inches. `lines`: heading, then the names of designs,
    which are listed below the map. All are centred on the map. The layout of matplotlib would shrink the map for the
    names, and cut the last one off.
    """
    width, height = size
    overhang = max(0.0, 0.5 * (max(map(len, lines)) * LETTER_WIDTH_RATIO * FONT_PT / 72.0 - width))
    left = max(MARGINS_INCHES.left, overhang)
    right = max(MARGINS_INCHES.right + inset_width, overhang)
    below = MARGINS_INCHES.below + LINE_INCHES * (len(lines) - 1)
    whole_width, whole_height = left + width + right, below + height + MARGINS_INCHES.above
    figure.set_size_inches(whole_width, whole_height)
    axes.set_position((left / whole_width, below / whole_height, width / whole_width, height / whole_height))


def _map_area(axes: Axes, printer: Printer) -> Bbox:
    """Return the area of the bed that the map shows, mm: the whole bed, or the parts' area if they are few."""
    bed = np.array([printer.bed_width_mm, printer.bed_depth_mm])
    outlines = [path.vertices for shapes in axes.collections for path in shapes.get_paths()]
    points = np.concatenate([np.asarray(outline, float) for outline in outlines])
    margin = MARGIN_SHARE * bed.max()
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    size = np.maximum(high - low, MIN_ASPECT * (high - low).max())
    low = np.clip(0.5 * (low + high - size), 0.0, np.maximum(bed - size, 0.0))
    high = np.minimum(low + size, bed)
    if (high - low).prod() > FULL_BED_SHARE * bed.prod():
        low, high = -0.01 * bed, 1.01 * bed
    return Bbox([low, high])


def _show_area(axes: Axes, shown: Bbox, printer: Printer) -> None:
    """Show the area `shown` of the bed, and mark it in a small picture of the bed if it is not the whole bed."""
    axes.set_xlim(shown.x0, shown.x1)
    axes.set_ylim(shown.y0, shown.y1)
    if shown.x0 < 0.0:
        return
    bed = printer.bed_width_mm, printer.bed_depth_mm
    high = INSET_SHARE * shown.width / shown.height * bed[1] / bed[0]
    inset = axes.inset_axes((1.02, 1.0 - high, INSET_SHARE, high))
    inset.add_patch(Rectangle((0.0, 0.0), *bed, fill=False, edgecolor="0.4"))
    inset.add_patch(Rectangle(shown.min, shown.width, shown.height, facecolor="0.85", edgecolor="0.2"))
    inset.set_xlim(-0.02 * bed[0], 1.02 * bed[0])
    inset.set_ylim(-0.02 * bed[1], 1.02 * bed[1])
    inset.set_aspect("equal")
    inset.set_axis_off()
    inset.set_title("on the bed", fontsize=8)


@figures.style({})
def draw_thumbnail(printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], plate: Plate) -> bytes:
    """Draw a small picture of the plate without words: PNG, 256 pixels wide."""
    size = THUMBNAIL_INCHES, THUMBNAIL_INCHES * printer.bed_depth_mm / printer.bed_width_mm
    figure = Figure(figsize=size)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    _draw_parts(axes, printer, members, meshes, plate)
    axes.set_axis_off()
    return figures.png(figure, dpi=THUMBNAIL_DPI)


def _draw_parts(axes: Axes, printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], plate: Plate) -> None:
    """Draw all parts of a plate from above, upright legs darker, and the bed."""
    views = {part: _top_view(members[part], meshes[part]) for part in {p.part for p in plate.placements}}
    for kind, colour in figures.LEG_COLOURS.items():
        copies = [placed for placed in plate.placements if members[placed.part].kind == kind]
        corners = [np.array((placed.x, placed.y)) for placed in copies]
        for layer, shade, label in (("walker", 1.0, f"{kind} legs"), ("legs", LEGS_SHADE, None)):
            triangles = [
                getattr(views[placed.part], layer) + corner for placed, corner in zip(copies, corners, strict=True)
            ]
            if sum(map(len, triangles)):
                tone = tuple(shade * part for part in colour)
                faces = PolyCollection(
                    list(np.concatenate(triangles)), facecolors=[tone], edgecolors=[tone], linewidths=0.3, label=label
                )
                axes.add_collection(faces)
    ways = [(placed, members[placed.part].run_direction, meshes[placed.part]) for placed in plate.placements]
    arrows = [
        _run_arrow(placed, way, mesh, max(ARROW_SHARE * printer.gap_mm, MIN_ARROW_MM))
        for placed, way, mesh in ways
        if way
    ]
    axes.add_collection(PolyCollection(arrows, facecolors="black", linewidths=0.0))
    draw_bed(axes, printer)


def _run_arrow(placed: Placement, way: int, mesh: Mesh, length: float) -> Array:
    """Return the corners of an arrow at the end of a part to which it runs, shape (3, 2). `way`: 1 to the right."""
    width, depth = np.ptp(mesh.vertices, axis=0)[:2]
    x = placed.x + (width if way > 0 else 0.0)
    triangle = np.array([[0.1 * way, -0.5], [1.1 * way, 0.0], [0.1 * way, 0.5]])
    corners: Array = length * triangle + (x, placed.y + 0.5 * depth)
    return corners


def draw_bed(axes: Axes, printer: Printer) -> None:
    """Draw the outline of a printer's bed, and show it whole."""
    bed = printer.bed_width_mm, printer.bed_depth_mm
    axes.add_patch(Rectangle((0.0, 0.0), *bed, fill=False, edgecolor="0.4"))
    axes.set_xlim(-0.01 * bed[0], 1.01 * bed[0])
    axes.set_ylim(-0.01 * bed[1], 1.01 * bed[1])
    axes.set_aspect("equal")


class _View(NamedTuple):
    """Triangles of a walker on the bed seen from above, shape (k, 3, 2) each, mm, from its bounding box's corner."""

    walker: Array
    legs: Array
    """Triangles of legs that point up, drawn on top of the walker; none for a walker on its side."""


def _top_view(design: Design, mesh: Mesh) -> _View:
    """Return the triangles of a walker on the bed seen from above, and those of its legs if they point up."""
    if solids.is_printed_on_side(design):
        return _View(_underside(mesh), np.empty((0, 3, 2)))
    whole, legs = (triangulate(section) for section in _silhouettes(design, mesh))
    return _View(whole, legs)


def _silhouettes(design: Design, mesh: Mesh) -> tuple[manifold3d.CrossSection, manifold3d.CrossSection]:
    """Return the outline, seen from above, of a walker with its legs up, and the outline of its legs."""
    solid = modeller.to_solid(mesh.shift(-mesh.vertices.min(axis=0)))
    legs = solid.trim_by_plane((0.0, 0.0, 1.0), design.size.thickness + LEG_CLEARANCE_MM)
    return solid.project(), legs.project()


def triangulate(section: manifold3d.CrossSection) -> Array:
    """Return the triangles of a flat section, shape (k, 3, 2), mm."""
    polygons = section.to_polygons()
    if not polygons:
        return np.empty((0, 3, 2))
    corners: Array = np.concatenate(polygons)[manifold3d.triangulate(polygons)]
    return corners


def _underside(mesh: Mesh) -> Array:
    """Return a mesh's triangles that lie on the bed, shape (k, 3, 2), mm, from the corner of its bounding box."""
    corners = (mesh.vertices - mesh.vertices.min(axis=0))[mesh.triangles]
    lying: Array = corners[(corners[:, :, 2] == 0.0).all(axis=1)][:, :, :2]
    return lying


def _legend_lines(letters: Mapping[str, str]) -> list[str]:
    """Return lines that list the letter of each design. `letters`: letters by the names of designs."""
    listed = [f"{letter}: {name}" for name, letter in letters.items()]
    more = len(listed) - MAX_LISTED_DESIGNS
    return listed[:MAX_LISTED_DESIGNS] + ([f"and {more} more: see the print sheet"] if more > 0 else [])


def _label_parts(axes: Axes, members: Sequence[Design], meshes: Sequence[Mesh], plate: Plate, scale: float) -> None:
    """Write a label for each part, as large as fits; `scale`: inches per mm."""
    letters = names.design_letters(members)
    fitted: dict[tuple[int, int], tuple[float, float, float]] = {}
    for placed in plate.placements:
        design = members[placed.part]
        label = f"{letters.get(design.name, '')}{design.tilt_deg:g}-{placed.copy}"
        key = placed.part, len(label)
        if key not in fitted:
            on_side = design.has_legs_table and solids.is_printed_on_side(design)
            fit_label = _fit_between_legs if on_side else _fit_on_part
            fitted[key] = fit_label(design, meshes[placed.part], len(label))
        x, y, height = fitted[key]
        axes.text(placed.x + x, placed.y + y, label, ha="center", va="center", fontsize=min(72.0 * scale * height, 9.0))


def _fit_between_legs(design: Design, mesh: Mesh, letters: int) -> tuple[float, float, float]:
    """Return x, y and font height (mm) of a label in the middle between two equal legs, from the box's corner."""
    left, bottom = mesh.vertices[:, :2].min(axis=0)
    below = 0.5 * (-bottom - 0.5 * design.size.thickness)
    middle = below * math.tan(design.limbs[0].tilt) - left
    return middle, below, min(below, 0.8 * design.foot_span / (LETTER_WIDTH_RATIO * letters))


def _fit_on_part(design: Design, mesh: Mesh, letters: int) -> tuple[float, float, float]:
    """Return x, y and font height (mm) of a label on a part next to its legs, from the corner of its bounding box.

    Dividing x by the label's width over its height turns the label into a square. The square in the largest circle
    within the free area is almost the largest label.
    """
    import shapely

    if solids.is_printed_on_side(design):
        free = shapely.union_all([shapely.Polygon(corners) for corners in _underside(mesh)])
    else:
        whole, legs = (
            shapely.union_all([shapely.Polygon(corners) for corners in triangulate(section)])
            for section in _silhouettes(design, mesh)
        )
        free = whole.difference(legs)
    squeeze = LETTER_WIDTH_RATIO * letters
    narrow = shapely.transform(free, lambda points: points / (squeeze, 1.0))
    circle = shapely.maximum_inscribed_circle(narrow, 0.01 * math.sqrt(narrow.area))
    (x, y), _ = circle.coords
    return squeeze * x, y, math.sqrt(2.0) * circle.length
