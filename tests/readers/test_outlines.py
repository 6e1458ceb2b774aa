"""Outlines of bodies: areas compared with closed forms, holes, orientation, refused drawings."""

import gzip
import itertools
import math
from functools import partial

import ezdxf
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walkergen.core.errors import GeometryError, InputError
from walkergen.readers.drawings import outlines
from walkergen.readers.drawings.contours import FLATNESS, MAX_POINTS
from walkergen.readers.drawings.lettering import text_outline
from walkergen.readers.drawings.outlines import ELLIPSE_SEGMENTS, area, disc, ellipse, polygon

PAGE = 'width="100mm" height="100mm" viewBox="0 0 100 100"'
SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]


def from_file(*source):
    return outlines.from_file(*source).polygons


def svg(folder, body, page=PAGE, before=""):
    path = folder / "shape.svg"
    names = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    path.write_text(f"{before}<svg {names} {page}>{body}</svg>")
    return path


def dxf(folder, draw, units=4):
    document = ezdxf.new("R2000", units=units)
    draw(document.modelspace(), document)
    path = folder / "shape.dxf"
    document.saveas(path)
    return path


def total(outline):
    """Area without the holes; fails where an outline is not as promised."""
    assert all(part.dtype == np.float64 and part.shape[1:] == (2,) for part in outline)
    every = np.vstack(outline)
    # Half a sum of two coordinates, subtracted: an ulp of each.
    np.testing.assert_allclose(every.min(axis=0), -every.max(axis=0), atol=1e-12)
    assert area(outline[0]) > 0.0
    return sum(map(area, outline))


def check_refusal(error, *words, of):
    with pytest.raises(error) as caught:
        of()
    text = str(caught.value)
    assert "\n" not in text
    assert all(word in text for word in words), text
    return text


def test_ellipse_and_disc_lack_the_area_they_state():
    step = 2 * math.pi / ELLIPSE_SEGMENTS
    share = math.sin(step) / step
    assert total(disc(28.0)) == pytest.approx(share * math.pi * 14**2, rel=1e-13)
    assert total(ellipse(28.0, 8.0)) == pytest.approx(share * math.pi * 14 * 4, rel=1e-13)
    assert 1.0 - share == pytest.approx(5.1e-5, rel=0.01)
    (points,) = ellipse(28.0, 8.0)
    assert len(points) == ELLIPSE_SEGMENTS
    np.testing.assert_array_equal(np.ptp(points, axis=0), (28.0, 8.0))
    for mirror in ((-1, 1), (1, -1)):
        assert set(map(tuple, points * mirror + 0.0)) == set(map(tuple, points + 0.0))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(st.floats(0.5, 20.0), min_size=3, max_size=40),
    st.booleans(),
    st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
)
def test_either_sense_and_any_place_give_the_same_star(radii, reverse, place):
    angles = np.linspace(0, 2 * math.pi, len(radii), endpoint=False)
    star = np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    following = np.roll(np.array(radii), -1)
    expected = 0.5 * math.sin(2 * math.pi / len(radii)) * float(np.array(radii) @ following)
    given_points = (star + place)[:: -1 if reverse else 1]
    # Coordinates of a thousand keep 1e-13 of themselves, over a star's size of ten.
    assert total(polygon(given_points)) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (SQUARE[:2], ("2 points", "three")),
        ("abc", ("three",)),
        ([(0, 0), (1, 2, 3), (4, 5)], ("three",)),
        ([*SQUARE, (0, 0)], ("(0, 0)", "twice")),
        ([(0, 0), (10, 10), (10, 0), (0, 10)], ("crosses", "(5, 5)")),
        ([(0, 0), (10, 0), (5, 0.0), (5, 8)], ("touches itself",)),
        ([(0, 0), (1, 1), (2, 2)], ("on a line",)),
        ([(0, 0), (math.nan, 1), (2, 0)], ("point 2", "nan")),
        ([(0, 0), (math.inf, 1), (2, 0)], ("point 2", "inf")),
        ([(0, 0), (28000, 0), (0, 8000)], ("28000 mm", "micrometres")),
        ([(0, 0), (0.028, 0), (0, 0.008)], ("0.028 mm", "metres")),
    ],
)
def test_points_that_are_no_outline(points, words):
    text = check_refusal(GeometryError, *words, of=lambda: polygon(points))
    assert text.startswith("body.points_mm = ")


def test_too_many_points():
    angles = np.linspace(0, 2 * math.pi, MAX_POINTS + 1, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    check_refusal(GeometryError, "100001 points", "Simplify", of=lambda: polygon(circle))


def test_letters_have_their_height_and_holes():
    assert [len(text_outline(text, 10.0)) for text in "LA8"] == [1, 2, 3]
    assert np.ptp(text_outline("H", 10.0)[0][:, 1]) == pytest.approx(10.0, rel=1e-12)
    # Two bars of 10 mm and the bar between them, from the font's own numbers.
    assert total(text_outline("H", 7.0)) == pytest.approx(0.49 * total(text_outline("H", 10.0)), rel=1e-9)
    pieces = text_outline("i 8%", 10.0, connected=False)
    assert sum(area(part) > 0 for part in pieces) == 2 + 1 + 3
    first, again = text_outline("$8$", 5.0, connected=False), text_outline("$8$", 5.0, connected=False)
    assert len(first) == 3 * 3  # a formula would drop the dollars
    assert all(np.array_equal(one, two) for one, two in zip(first, again, strict=True))


def test_rails_join_letters_to_one_part_of_their_area():
    outer, *holes = text_outline("IT", 10.0, rails=2.0)
    pieces = text_outline("IT", 10.0, connected=False)
    length = np.ptp(np.concatenate(pieces)[:, 0])
    assert np.ptp(outer, axis=0) == pytest.approx([length, 12.0], rel=1e-6)
    assert len(holes) == 1  # between the letters
    # each bar covers what it shares with strokes: less than letters and bars together
    assert total(pieces) < total([outer, *holes]) < total(pieces) + 2 * 2.0 * length
    check_refusal(GeometryError, "pieces", of=lambda: text_outline("i", 10.0, rails=1.0))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("0 characters",)),
        ("a" * 300, ("300 characters", "1 to 40")),
        ("   ", ("draws nothing",)),
        ("a\x07", ("U+0007",)),
        ("a\nb", ("U+000A",)),
        ("a\u200b", ("U+200B", "ZERO WIDTH SPACE")),
        ("漢", ("U+6F22", "not in the font")),
        ("Aij", ("'i', 'j'", "several pieces")),
        ("LA", ("'L' and 'A'", "do not touch", "rails_mm")),
    ],
)
def test_texts_that_are_no_body(text, words):
    started = check_refusal(GeometryError, *words, of=lambda: text_outline(text, 10.0))
    assert started.startswith("body.text = ")


SVG_SHAPES = [
    ('<circle cx="50" cy="50" r="10"/>', 100 * math.pi, 1),
    ('<circle cx="50" cy="50" r="10" transform="skewX(40) rotate(7)"/>', 100 * math.pi, 1),
    ('<ellipse rx="20" ry="5" transform="rotate(30) scale(2)"/>', 400 * math.pi, 1),
    ('<rect width="20" height="20" rx="3"/>', 400 - 9 * (4 - math.pi), 1),
    ('<polygon points="0,0 10,0 10,30"/>', 150.0, 1),
    # Two arches, one up and one down, of equal area: the rectangle below them is left.
    ('<path d="M0 0 C0 20 30 20 30 0 S60 -20 60 0 V-40 H0z"/>', 2400.0, 1),
    ('<path d="M0 0 Q10 20 20 0z"/>', 2 / 3 * 20 * 10, 1),
    ('<path d="M0 0h20v20h-20zM5 5h10v10h-10z"/>', 400.0, 1),  # nonzero: no hole
    ('<path d="M0 0h20v20h-20zM5 5v10h10v-10z"/>', 300.0, 2),
    ('<g style="fill-rule:evenodd"><path d="M0 0h20v20h-20zM5 5h10v10h-10z"/></g>', 300.0, 2),
    ('<rect width="20" height="20"/><circle cx="10" cy="10" r="5" fill="#fff"/>', 400 - 25 * math.pi, 2),
    ('<rect width="20" height="20"/><circle cx="10" cy="10" r="5"/>', 400.0, 1),  # in its own colour
    ('<rect width="9" height="9"/><rect width="9" height="9"/>', 81.0, 1),
    ('<rect width="9" height="9"/><rect x="5" width="9" height="9"/>', 126.0, 1),
    ('<defs><rect id="a" width="5" height="4"/></defs><use href="#a" y="2"/>', 20.0, 1),
    ('<rect width="9" height="9"/><g display="none"><circle r="99"/></g>', 81.0, 1),
]


@pytest.mark.parametrize(("body", "expected", "parts"), SVG_SHAPES)
def test_svg_shapes(tmp_path, body, expected, parts):
    outline = from_file(svg(tmp_path, body))
    size = np.ptp(np.vstack(outline), axis=0).max()
    # Two thirds of the sag along a perimeter of at most 4 sizes and as much in holes.
    assert total(outline) == pytest.approx(expected, abs=2 / 3 * 8 * FLATNESS * size**2)
    assert len(outline) == parts


@pytest.mark.parametrize(
    ("page", "scale", "length"),
    [
        (PAGE, None, 20.0),
        (PAGE, 0.5, 10.0),
        ('width="2in" height="2in" viewBox="0 0 100 100"', None, 20 * 50.8 / 100),
        ('width="2cm" height="1cm" viewBox="5 5 100 100"', None, 2.0),
        ('width="96pt" height="96pt"', None, 20 * 25.4 / 96),
        ('width="100" height="100" viewBox="0 0 7 7"', 2.0, 40.0),
    ],
)
def test_units_of_svg(tmp_path, page, scale, length):
    path = svg(tmp_path, '<rect width="20" height="10"/>', page)
    assert np.ptp(from_file(path, scale)[0][:, 0]) == pytest.approx(length, rel=1e-12)


def test_svgz_is_unpacked(tmp_path):
    drawing = svg(tmp_path, '<path d="M0 0h20v10h-20z"/>').read_bytes()
    for data in (gzip.compress(drawing), drawing):  # some programs only name it so
        (tmp_path / "shape.svgz").write_bytes(data)
        assert area(from_file(tmp_path / "shape.svgz")[0]) == pytest.approx(200.0)
    (tmp_path / "shape.svgz").write_bytes(gzip.compress(drawing)[:-40])
    with pytest.raises(InputError):
        from_file(tmp_path / "shape.svgz")


def test_an_svg_is_upright_as_on_screen(tmp_path):
    (flag,) = from_file(svg(tmp_path, '<path d="M0 0 h10 v30 z"/>'))  # its tip points down
    assert flag[flag[:, 1].argmin()] == pytest.approx((5.0, -15.0), abs=1e-12)


LINES = 'fill="none" stroke="red" stroke-width=".1"'
ENTITIES = '<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;&a;"><!ENTITY c SYSTEM "file:///etc/hostname">]>'


def test_svg_pages_and_entities(tmp_path):
    square = '<rect width="9" height="9"/>'
    for page in ("", 'width="9" height="9"', 'width="100%" height="9mm"'):
        check_refusal(InputError, "scale_mm", of=lambda page=page: from_file(svg(tmp_path, square, page)))
    bad = 'width="9mm" height="9mm" viewBox="0 0 0 9"'
    check_refusal(InputError, "viewBox", of=lambda: from_file(svg(tmp_path, square, bad)))
    check_refusal(InputError, "entity", of=lambda: from_file(svg(tmp_path, square, before=ENTITIES)))
    known = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://example.com/svg11.dtd">'
    assert total(from_file(svg(tmp_path, square, before=known))) == pytest.approx(81.0)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("", ("no closed path",)),
        ('<path d="M0 0L10 10 10 0 0 10z"/>', ("2 pieces, that touch only in a point, at (5, -5) mm", "body.repair")),
        ('<path d="M0 0L10 10 10 0 0 10z" fill="none" stroke="red" stroke-width=".1"/>', ("crosses",)),
        (f'<g {LINES}><rect width="9" height="9"/><circle cx="9" cy="5" r="3"/></g>', ("two paths", "unite")),
        (f'<g {LINES}><rect width="9" height="9"/><rect width="9" height="9"/></g>', ("twice",)),
        ('<rect width="9" height="9"/><circle cx="50" cy="5" r="3"/>', ("2 pieces",)),
    ],
)
def test_svg_shapes_that_are_no_outline(tmp_path, body, words):
    check_refusal(GeometryError, *words, of=lambda: from_file(svg(tmp_path, body)))


@pytest.mark.parametrize("data", [b"", b"hello", bytes(range(256)), b"<html></html>", b"<svg><g"])
@pytest.mark.parametrize("ending", ["svg", "dxf"])
def test_files_of_another_kind(tmp_path, data, ending):
    path = tmp_path / f"shape.{ending}"
    path.write_bytes(data)
    check_refusal(InputError, f"body.outline = 'shape.{ending}'", of=lambda: from_file(path))
    check_refusal(InputError, "no such file", of=lambda: from_file(tmp_path / f"none.{ending}"))
    check_refusal(InputError, ".svg or .dxf", of=lambda: from_file(tmp_path / "shape.gif"))
    check_refusal(InputError, "scale_mm = 0", of=lambda: from_file(path, 0.0))


def stadium(space, _):
    space.add_line((0, 0), (10, 0))
    space.add_arc((0, 5), 5, 90, 270)
    space.add_line((0, 10), (10, 10 + 1e-7))  # as programs write it
    space.add_arc((10, 5), 5, -90, 90)


def with_hole(space, document):
    stadium(space, document)
    space.add_circle((5, 5), 2)
    space.add_text("a note")


def block(space, document):
    document.blocks.new("B").add_lwpolyline([(0, 0), (1, 0), (0, 1)], close=True)
    space.add_blockref("B", (5, 5), dxfattribs={"xscale": -10, "yscale": 10, "rotation": 30})


def hidden(space, document):
    document.layers.add("aux").off()
    space.add_circle((0, 0), 5)
    space.add_circle((0, 0), 50, dxfattribs={"layer": "aux"})


@pytest.mark.parametrize(
    ("draw", "expected", "parts"),
    [
        (lambda space, _: space.add_circle((3, 4), 10), 100 * math.pi, 1),
        (lambda space, _: space.add_ellipse((0, 0), (10, 0), 0.5), 50 * math.pi, 1),
        (lambda space, _: space.add_lwpolyline([(0, 0, 1), (10, 0, 1)], format="xyb", close=True), 25 * math.pi, 1),
        (stadium, 100 + 25 * math.pi, 1),
        (with_hole, 100 + 21 * math.pi, 2),
        (block, 50.0, 1),
        (hidden, 25 * math.pi, 1),
    ],
)
def test_dxf_shapes(tmp_path, draw, expected, parts):
    outline = from_file(dxf(tmp_path, draw))
    size = np.ptp(np.vstack(outline), axis=0).max()
    assert total(outline) == pytest.approx(expected, abs=2 / 3 * 8 * FLATNESS * size**2)
    assert len(outline) == parts


def closed_spline(space, _):
    space.add_spline(degree=2).control_points = [(0, 0), (28, 0), (28, 8), (0, 8)]
    space[0].closed = True


def fitted_spline(space, _):
    angles = np.linspace(0, 2 * math.pi, 24, endpoint=False)
    space.add_spline(fit_points=[(14 * math.cos(angle), 4 * math.sin(angle)) for angle in angles])
    space[0].closed = True


def twice(space, _):
    corners = [*SQUARE, SQUARE[0]]
    for start, end in itertools.pairwise(corners):
        space.add_line(start, end)
    space.add_line(SQUARE[1], SQUARE[0])
    space.add_circle((5, 5), 2)
    space.add_circle((5, 5), 2)


def gap(space, _):
    for start, end in (((0, 0), (28, 0)), ((28.002, 0), (28, 8)), ((28, 8), (0, 8)), ((0, 8), (0, 0.001))):
        space.add_line(start, end)


def frame(space, _):
    space.add_lwpolyline([(0, 0), (28, 0), (28, 8), (0, 8)], close=True)
    space.add_lwpolyline([(-20, -20), (277, -20), (277, 190), (-20, 190)], close=True)


def dots(space, _):
    space.add_circle((5, 5), 5)
    space.add_line((1, 1), (1, 1))
    space.add_line((1, 1), (1, 1 + 1e-9))


def circle_on_plotted_layer(space, document):
    document.layers.add("frame").dxf.plot = 0
    space.add_circle((0, 0), 5)
    space.add_circle((0, 0), 50, dxfattribs={"layer": "frame"})
    space.add_circle((0, 0), 50, dxfattribs={"layer": "Defpoints"})


def bar(space, *_, x=0.0, y=0.0, long=28.0, wide=8.0, **attributes):
    space.add_lwpolyline(
        [(x, y), (x + long, y), (x + long, y + wide), (x, y + wide)], close=True, dxfattribs=attributes
    )


def border(space, _):
    """Sheet of paper, its border, and the part."""
    bar(space)
    bar(space, x=-20, y=-20, long=297, wide=210)
    bar(space, x=-15, y=-15, long=287, wide=200)


def own_frame(space, _):
    bar(space)
    bar(space, x=-20, y=-20, long=300, wide=200)


def construction(space, _):
    bar(space)
    space.add_xline((0, 4), (1, 0))
    space.add_ray((0, 0), (1, 1))


def hidden(space, document):
    """Layers that are off, frozen, not plotted, in blocks too: of them only what a block has on a layer of its own."""
    document.layers.add("off").off()
    document.layers.add("frozen").freeze()
    document.layers.add("dumb").dxf.plot = 0
    for layer in ("OFF", "frozen", "dumb"):
        bar(space, long=90.0, wide=90.0, layer=layer)
        block = document.blocks.new(layer)
        bar(block, long=80.0, wide=80.0)  # on layer 0: that of the block's place
        space.add_blockref(layer, (0, 0), dxfattribs={"layer": layer})
    bar(document.blocks.get("OFF"), layer="seen")
    bar(document.blocks.get("frozen"), long=70.0, wide=70.0, layer="seen")


def texts(space, document):
    bar(space)
    space.add_text("x")
    space.add_text("y")
    document.add_xref_def("other.dxf", "XR")
    space.add_blockref("XR", (0, 0))


def one_gap(space, _):
    """A single polyline whose ends are 0.002 apart."""
    space.add_lwpolyline([(0, 0), (28, 0), (28, 8), (0, 8), (0, 0.002)])


@pytest.mark.parametrize(
    ("draw", "expected", "note"),
    [
        (border, 224.0, "left out a frame of 287 x 200 mm, in a sheet of paper"),
        (
            own_frame,
            300.0 * 200.0 - 224.0,
            "took the rectangle of 300 x 200 mm for the body, and what lies in it for holes",
        ),
        (construction, 224.0, None),
        (hidden, 224.0, "left out 6 hidden or not plotted"),
        (texts, 224.0, "left out 2 TEXT, 1 of another drawing"),
        (one_gap, 224.0, "closed a gap of 0.002 at (0, 0.002) of the drawing"),
        (partial(bar, const_width=1.0), 224.0, "took lines without their width, up to 1 mm"),
        (lambda space, _: space.add_ellipse((0, 0), (14, 0), 4 / 14, -math.pi, math.pi), 56.0 * math.pi, None),
        # a quadratic B-spline cuts 1/24 of its control polygon's corner off: 4 corners of a rectangle
        (closed_spline, 224.0 * (1.0 - 4.0 / 24.0), None),
        (fitted_spline, 56.0 * math.pi, None),
        (lambda space, _: space.add_ellipse((0, 0), (14, 0), 4 / 14, 0.0, 0.0), 56.0 * math.pi, None),
        (circle_on_plotted_layer, 25.0 * math.pi, "left out 1 hidden or not plotted"),
        (dots, 25.0 * math.pi, None),
        (twice, 100.0 - 4.0 * math.pi, "left out 2 lines that are drawn twice"),
        (gap, 224.0, "closed a gap of 0.002 at (28, 0) of the drawing"),
        (frame, 224.0, "left out a frame of 297 x 210 mm, a sheet of paper"),
    ],
)
def test_dxf_as_programs_write_it(tmp_path, draw, expected, note):
    outline = outlines.from_file(dxf(tmp_path, draw))
    assert total(outline.polygons) == pytest.approx(expected, rel=3e-4)  # the fitted spline's own error: 2e-4
    assert note in "; ".join(outline.notes) if note else not outline.notes


def test_an_ellipse_whose_second_axis_is_the_longer_is_named(tmp_path):
    path = dxf(tmp_path, lambda space, _: space.add_ellipse((0, 0), (4, 0), 0.5))
    path.write_text(path.read_text().replace("\n 40\n0.5\n", "\n 40\n3.5\n"))
    with pytest.raises(InputError, match=r"an ELLIPSE has axes of the ratio 3\.5, at most 1"):
        outlines.from_file(path)


def test_a_byte_order_mark_begins_no_other_dxf(tmp_path):
    path = dxf(tmp_path, lambda space, _: space.add_circle((0, 0), 5))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert total(from_file(path)) == pytest.approx(25.0 * math.pi, rel=1e-3)
    path.write_text("no drawing")
    assert str(tmp_path.parent) not in check_refusal(InputError, "its first lines", of=lambda: from_file(path))


@pytest.mark.parametrize(("units", "mm"), [(8, 25.4e-6), (9, 0.0254), (21, 1200e3 / 3937), (22, 1e5 / 3937)])
def test_units_of_dxf_that_the_library_does_not_know(tmp_path, units, mm):
    side = 28.0 / mm
    square = [(side * x / 10, side * y / 10) for x, y in SQUARE]
    path = dxf(tmp_path, lambda space, _: space.add_lwpolyline(square, close=True), units)
    assert np.ptp(from_file(path)[0][:, 0]) == pytest.approx(28.0, rel=1e-12)


def test_units_of_dxf(tmp_path):
    def square(space, _):
        space.add_lwpolyline(SQUARE, close=True)

    for units, length in ((1, 254.0), (4, 10.0), (5, 100.0), (13, None), (6, None)):
        path = dxf(tmp_path, square, units)
        if length is None:
            check_refusal(GeometryError, "mm long", of=lambda path=path: from_file(path))
        else:
            assert np.ptp(from_file(path)[0][:, 0]) == pytest.approx(length, rel=1e-12)
    assert np.ptp(from_file(path, 2.0)[0][:, 0]) == pytest.approx(20.0, rel=1e-12)
    check_refusal(InputError, "scale_mm", of=lambda: from_file(dxf(tmp_path, square, 0)))
    # Without a header the library would answer metres.
    headless = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\n0\n10\n0\n20\n0\n40\n1\n0\nENDSEC\n0\nEOF\n"
    path.write_text(headless)
    check_refusal(InputError, "scale_mm", of=lambda: from_file(path))
    assert total(from_file(path, 3.0)) == pytest.approx(9 * math.pi, rel=1e-4)


def open_lines(space, _):
    space.add_line((0, 0), (10, 0))
    space.add_line((10, 0), (10, 5))


def star(space, _):
    for end in ((5, 5), (3, 5), (1, 1)):
        space.add_line((0, 0), end)


def endless(space, document):
    document.blocks.new("B").add_blockref("B", (1, 0))
    space.add_blockref("B", (0, 0))


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (open_lines, ("open", "(10, 5)")),
        (star, ("meet in (0, 0)",)),
        (endless, ("20000 entities", "16 deep")),
        (lambda space, _: space.add_circle((0, 0), math.nan), ("size",)),
        (lambda space, _: [space.add_circle((0, 0), r) for r in (0, 5)], ("draws nothing",)),
        (lambda space, _: space.add_lwpolyline([(0, 0), (1, math.nan), (4, 5)]), ("finite",)),
        (lambda space, _: space.add_circle((0, 0), 1, dxfattribs={"extrusion": (0, 1, 1)}), ("flat",)),
        (lambda space, _: space.add_3dface([(0, 0), (1, 0), (1, 1)]), ("3DFACE",)),
    ],
)
def test_dxf_files_that_cannot_be_read(tmp_path, draw, words):
    text = check_refusal(InputError, *words, of=lambda: from_file(dxf(tmp_path, draw)))
    assert text.startswith("body.outline = 'shape.dxf': ")
