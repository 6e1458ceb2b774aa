"""Outlines of DXF drawings compared with the drawings of ezdxf's frontend, which other programs show."""

import math

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf.addons.drawing import Frontend, RenderContext
from ezdxf.addons.drawing.recorder import PathRecord, PointsRecord, Recorder, SolidLinesRecord
from shapely import LineString, Polygon, polygonize, unary_union
from shapely.affinity import translate

from walkergen.readers.drawings.outlines import from_file

FLAT_MM = 1e-3
"""Distance of the frontend's curves from its chords."""


def frontend_polygons(doc):
    """Polygons that the lines of the frontend bound, every other one inwards a hole: their union."""
    recorder = Recorder()
    Frontend(RenderContext(doc, export_mode=True), recorder).draw_layout(doc.modelspace())
    lines = []
    for record, _ in recorder.player().recordings():
        if isinstance(record, PathRecord):
            lines.append([(v.x, v.y) for v in record.path.to_path().flattening(FLAT_MM)])
        elif isinstance(record, SolidLinesRecord):
            ends = [(v.x, v.y) for v in record.lines.vertices()]
            lines += zip(ends[::2], ends[1::2], strict=True)
        elif isinstance(record, PointsRecord):
            lines.append([(v.x, v.y) for v in record.points.vertices()])
    net = unary_union([shapely.set_precision(LineString(line), 1e-4) for line in lines if len(line) > 1])
    faces = list(polygonize([net]).geoms)
    shells = [Polygon(face.exterior) for face in faces]
    inside = [face.representative_point() for face in faces]
    depths = [sum(shell.contains(point) for shell in shells) for point in inside]
    return unary_union([face for face, depth in zip(faces, depths, strict=True) if depth % 2])


def read_polygons(path):
    """The same of what is read of a file, of polygons that turn about bodies left and about holes right."""
    contours = [Polygon(contour) for contour in from_file(path).polygons]
    return unary_union([one for one in contours if one.exterior.is_ccw]) - unary_union(
        [one for one in contours if not one.exterior.is_ccw]
    )


def in_the_middle(shape):
    """A shape with the middle of its box at the origin."""
    x, y, right, top = shape.bounds
    return translate(shape, -0.5 * (x + right), -0.5 * (y + top))


def box(space, x=0.0, y=0.0, length=28.0, width=8.0, **attributes):
    corners = [(x, y), (x + length, y), (x + length, y + width), (x, y + width)]
    return space.add_lwpolyline(corners, close=True, dxfattribs=attributes)


def stadium(space, x=0.0, y=0.0):
    """28 x 8 mm, its ends half circles by bulges."""
    points = [(x + 4, y, 0), (x + 24, y, 1), (x + 24, y + 8, 0), (x + 4, y + 8, 1)]
    return space.add_lwpolyline(points, format="xyb", close=True)


def lines(space, points, **attributes):
    for a, b in zip(points, [*points[1:], points[0]], strict=True):
        space.add_line(a, b, dxfattribs=attributes)


ELL_CORNERS = [(0, 0), (28, 0), (28, 4), (8, 4), (8, 8), (0, 8)]
EGG_CORNERS = [(0, 0), (14, -5), (28, 0), (24, 8), (14, 10), (3, 8)]


def block(doc, name="part"):
    made = doc.blocks.new(name)
    lines(made, ELL_CORNERS)
    return made


def arcs_and_lines(doc, space):
    space.add_line((4, 0), (24, 0))
    space.add_arc((24, 4), 4, -90, 90)
    space.add_line((24, 8), (4, 8))
    space.add_arc((4, 4), 4, 90, 270)


def slots(doc, space):
    box(space, -2, -4, 40, 16)
    space.add_circle((33, 4), 2)
    stadium(space)


def half_ellipse(doc, space):
    space.add_ellipse((14, 0), (14, 0), 8 / 14, 0, math.pi)
    space.add_line((0, 0), (28, 0))


def tilted_ellipse(doc, space):
    space.add_ellipse((14, 0), (12, 7), 0.4)


def moved_block(**attributes):
    def draw(doc, space):
        block(doc)
        space.add_blockref("part", (5, 7), dxfattribs=attributes)

    return draw


def nested_blocks(doc, space):
    block(doc, "inner")
    outer = doc.blocks.new("outer")
    outer.add_blockref("inner", (1, 2), dxfattribs={"rotation": 90.0})
    space.add_blockref("outer", (0, 0), dxfattribs={"rotation": 45.0, "xscale": 1.5, "yscale": 1.5})


def stretched_circle(doc, space):
    doc.layers.add("Off").off()
    made = doc.blocks.new("disc")
    made.add_circle((0, 0), 5)
    made.add_line((-1, 0), (1, 0), dxfattribs={"layer": "Off"})
    space.add_blockref("disc", (0, 0), dxfattribs={"xscale": 2.8, "yscale": 0.8, "rotation": 20.0})


def rows_of_blocks(doc, space):
    made = doc.blocks.new("dot")
    made.add_circle((0, 0), 1)
    box(space)
    space.add_blockref("dot", (4, 4), dxfattribs={"column_count": 4, "column_spacing": 6.0})


def hidden_layers(doc, space):
    doc.layers.add("Off").off()
    doc.layers.add("Frozen").freeze()
    doc.layers.add("Sketch").dxf.plot = 0
    for layer in ("Off", "Frozen", "Sketch"):
        box(space, 2, 2, 24, 4, layer=layer)
    box(space)


def seen_from_below(doc, space):
    points = [(x, y) for x, y in ELL_CORNERS]
    space.add_lwpolyline(points, close=True, dxfattribs={"extrusion": (0, 0, -1)})


def arc_from_below(doc, space):
    """A mirrored part, as AutoCAD's MIRROR3D leaves it."""
    below = {"extrusion": (0, 0, -1)}
    space.add_arc((-24, 4), 4, 90, 270, dxfattribs=below)
    space.add_arc((-4, 4), 4, -90, 90, dxfattribs=below)
    space.add_line((4, 0), (24, 0))
    space.add_line((24, 8), (4, 8))


def old_polyline(doc, space):
    points = [(4, 0, 0), (24, 0, 1), (24, 8, 0), (4, 8, 1)]
    space.add_polyline2d(points, format="xyb", close=True)


def fit_spline(doc, space):
    space.add_spline([*EGG_CORNERS, EGG_CORNERS[0]])


def open_spline_and_line(doc, space):
    space.add_spline().set_open_uniform([(0, 0), (7, 12), (21, 12), (28, 0)])
    space.add_line((0, 0), (28, 0))


def box_with_notes(doc, space):
    box(space)
    space.add_text("28", height=3).set_placement((10, 12))
    space.add_linear_dim((0, -5), (0, 0), (28, 0)).render()
    space.add_point((14, 4))


def lines_in_any_order(doc, space):
    for k in (3, 0, 5, 1, 4, 2):
        a, b = ELL_CORNERS[k], ELL_CORNERS[(k + 1) % 6]
        space.add_line(*((a, b) if k % 2 else (b, a)))


def lifted_lines(doc, space):
    lines(space, [(x, y, 5.0) for x, y in ELL_CORNERS])


def many_bulges(doc, space):
    space.add_lwpolyline(
        [(x, y, 0.3 if k % 2 else -0.2) for k, (x, y) in enumerate(EGG_CORNERS)], format="xyb", close=True
    )


def closed_by_its_end(doc, space):
    space.add_lwpolyline([*ELL_CORNERS, ELL_CORNERS[0]])


def polyline_in_space(doc, space):
    space.add_polyline3d([(x, y, 1.0) for x, y in ELL_CORNERS], close=True)


DRAWINGS = {
    "box": lambda doc, space: box(space),
    "stadium": lambda doc, space: stadium(space),
    "circle": lambda doc, space: space.add_circle((0, 0), 10),
    "mirrored": moved_block(xscale=-1.0),
    "scaled": moved_block(xscale=2.0, yscale=0.5, rotation=30.0),
    **{
        draw.__name__: draw
        for draw in (
            box_with_notes,
            arc_from_below,
            arcs_and_lines,
            closed_by_its_end,
            fit_spline,
            half_ellipse,
            hidden_layers,
            lines_in_any_order,
            many_bulges,
            nested_blocks,
            old_polyline,
            lifted_lines,
            open_spline_and_line,
            polyline_in_space,
            rows_of_blocks,
            seen_from_below,
            slots,
            stretched_circle,
            tilted_ellipse,
        )
    },
}


@pytest.mark.parametrize("name", DRAWINGS)
def test_outlines_equal_the_drawings_of_the_frontend(name, tmp_path):
    doc = ezdxf.new("R2010", units=4)
    DRAWINGS[name](doc, doc.modelspace())
    path = tmp_path / "drawing.dxf"
    doc.saveas(path)
    theirs, outline = in_the_middle(frontend_polygons(ezdxf.readfile(path))), in_the_middle(read_polygons(path))
    assert outline.area == pytest.approx(theirs.area, rel=1e-3)
    assert outline.hausdorff_distance(theirs) < 0.01
    assert outline.boundary.hausdorff_distance(theirs.boundary) < 0.01


BASIS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0
"""Powers of the parameter in a span of a uniform cubic spline, of four control points."""


def round_points(points, weights):
    """Closed uniform cubic spline through no control point, span by span, by its matrix."""
    held = np.column_stack([points, np.ones(len(points))]) * np.array(weights, float)[:, None]
    powers = np.linspace(0.0, 1.0, 200, endpoint=False)[:, None] ** np.arange(4)
    spans = [powers @ BASIS @ held[np.arange(k, k + 4) % len(held)] for k in range(len(held))]
    curve = np.vstack(spans)
    return Polygon(curve[:, :2] / curve[:, 2:])


@pytest.mark.parametrize("weights", [[1] * 6, [1, 4, 1, 2, 1, 3]])
def test_a_closed_spline_spans_its_inner_knots_alone(weights, tmp_path):
    """As the format defines it; the frontend draws its outer knots too, from the origin on."""
    doc = ezdxf.new("R2010", units=4)
    spline, points = doc.modelspace().add_spline(), [(x, y, 0) for x, y in EGG_CORNERS]
    if set(weights) == {1}:
        spline.set_closed(points)
    else:
        spline.set_closed_rational(points, weights)
    doc.saveas(tmp_path / "egg.dxf")
    expected, outline = (
        in_the_middle(round_points(EGG_CORNERS, weights)),
        in_the_middle(read_polygons(tmp_path / "egg.dxf")),
    )
    assert outline.area == pytest.approx(expected.area, rel=1e-3)
    assert outline.hausdorff_distance(expected) < 0.01


def test_control_corners_of_a_smoothed_polyline_are_no_line(tmp_path):
    """As PEDIT writes them, before those of the curve; the frontend draws a line through both."""
    doc = ezdxf.new("R2000", units=4)
    polyline = doc.modelspace().add_polyline2d(ELL_CORNERS, close=True)
    polyline.dxf.flags |= 4
    for vertex in polyline.vertices:
        vertex.dxf.flags = 16
    turns = math.tau * np.arange(90) / 90
    polyline.append_vertices(list(zip(14 * np.cos(turns), 6 * np.sin(turns), strict=True)))
    doc.saveas(tmp_path / "smooth.dxf")
    assert read_polygons(tmp_path / "smooth.dxf").area == pytest.approx(math.pi * 14 * 6, rel=2e-3)
