"""Outlines of SVG drawings compared with resvg's pictures of the same files."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw
from scipy import ndimage

from walkergen.core.errors import InputError
from walkergen.readers.drawings.outlines import area, from_file

resvg_py = pytest.importorskip("resvg_py")

NAMES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
PAGE = 'width="40mm" height="20mm" viewBox="0 0 40 20"'
BAR, ELL = '<path d="M6 6h28v8H6z"/>', '<path d="M4 4h20v4h-14v8h-6z"/>'
ILLUSTRATOR = '<!DOCTYPE svg [<!ENTITY ns_svg "http://www.w3.org/2000/svg">]>'
LINES = Path(__file__).with_name("drawings.txt").read_text().splitlines()
DRAWINGS = {name: body.replace("BAR", BAR).replace("ELL", ELL) for name, body in (line.split(" | ") for line in LINES)}

LATER = {"origin by words", "origin of itself", "nested visible"}
"""Features that browsers read and resvg does not: transform as a property, fill-box, overflow."""


ZOOM = 30
"""Pixels of the picture in a unit of the drawing."""


@pytest.mark.parametrize("name", sorted(set(DRAWINGS) - LATER))
def test_outlines_equal_resvgs_pictures(name, tmp_path):
    text = f"<svg {NAMES} {PAGE}>{DRAWINGS[name]}</svg>"
    path = tmp_path / "drawing.svg"
    path.write_text(text)
    png = bytes(resvg_py.svg_to_bytes(svg_string=text.replace("mm", ""), zoom=ZOOM))
    cover = np.array(Image.open(io.BytesIO(png)))[..., 3] / 255.0  # of each pixel, by their antialiasing
    outline = from_file(path).polygons
    assert sum(map(area, outline)) == pytest.approx(cover.sum() / ZOOM**2, rel=0.01)
    theirs = cover > 0.5
    rows, columns = np.flatnonzero(theirs.any(1)), np.flatnonzero(theirs.any(0))
    theirs = theirs[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    picture, low = Image.new("1", theirs.shape[::-1]), np.vstack(outline).min(axis=0)
    for polygon in outline:
        points = [(x, theirs.shape[0] - y) for x, y in (ZOOM * (polygon - low)).tolist()]
        ImageDraw.Draw(picture).polygon(points, fill=int(area(polygon) > 0.0))
    rim = ndimage.distance_transform_edt(~(theirs ^ ndimage.binary_erosion(theirs)))
    apart = theirs != np.array(picture)
    assert (rim * apart).max() <= 0.01 * max(theirs.shape) + 1.5  # a pixel and a half of either rim


BROWSERS = {
    '<style>:root{--c:none}.a{fill:var(--c)}</style><path class="a" d="M0 0h40v20H0z"/>BAR': 224.0,
    '<path fill="var(--fill-0, none)" d="M0 0h40v20H0z"/>BAR': 224.0,
    '<path fill="var(--fill-0, #123)" d="M6 6h28v8H6z"/>': 224.0,
    '<style>g{--a:var(--b);--b:none}</style><g fill="var(--a)"><path d="M0 0h40v20H0z"/></g>BAR': 224.0,
    '<g fill="none"><path style="fill:unset" d="M0 0h40v20H0z"/></g>BAR': 224.0,
    '<g fill="none"><path style="fill:initial" d="M6 6h28v8H6z"/></g>': 224.0,
    "<style>@namespace s url(http://www.w3.org/2000/svg);s|rect{display:none}</style><rect width='9' height='9'/>"
    "BAR": 224.0,
    '<g style="font:italic 4px/2 sans-serif"><rect width="7em" height="2em"/></g>': 224.0,
    '<g style="rotate:none;zoom:1">BAR</g>': 224.0,
    '<path style="filter:opacity(0)" d="M0 0h40v20H0z"/>BAR': 224.0,
    '<g font-size="small"><rect width="1em" height="1em"/></g>': 169.0,
}
"""Drawings whose area resvg gives otherwise than browsers do, and that in browsers."""


@pytest.mark.parametrize("body", BROWSERS)
def test_areas_as_browsers_have_them(body, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(f"<svg {NAMES} {PAGE}>{body.replace('BAR', BAR)}</svg>")
    assert sum(map(area, from_file(path).polygons)) == pytest.approx(BROWSERS[body], rel=1e-9)


@pytest.mark.parametrize(
    ("page", "expected"),
    [
        ('width="40mm" viewBox="0 0 40 20"', 224.0),
        ('height="20mm" viewBox="0 0 40 20"', 224.0),
        ('style="width:40mm;height:20mm" viewBox="0 0 40 20"', 224.0),
        ('width="40mm" height="20mm" style="width:100%;height:auto" viewBox="0 0 40 20"', 224.0),
        ('width="80mm" height="20mm" viewBox="0 0 40 20" preserveAspectRatio="none"', 448.0),
        ('font-size="4" width="40mm" height="20mm" viewBox="0 0 40 20"', 224.0),
    ],
)
def test_sizes_of_the_page(page, expected, tmp_path):
    path = tmp_path / "drawing.svg"
    bar = '<rect width="7rem" height="2rem"/>' if "font" in page else BAR
    path.write_text(f"<svg {NAMES} {page}>{bar}</svg>")
    assert sum(map(area, from_file(path).polygons)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    "transform", ["rotateX(45deg)", "matrix3d(1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1)", "translate(10%, 0)", "foo(1)"]
)
def test_transforms_that_leave_the_plane_are_named(transform, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(f'<svg {NAMES} {PAGE}><g style="transform:{transform}">{BAR}</g></svg>')
    with pytest.raises(InputError, match=re.escape(f"<g> has transform = '{transform[:38]}")):
        from_file(path)
    path.write_text(f'<svg {NAMES} {PAGE} transform="scale(2)">{BAR}</svg>')
    with pytest.raises(InputError, match="the page has a transform"):
        from_file(path)


@pytest.mark.parametrize(
    ("name", "expected"), [("origin by words", 0.25 * 116.0), ("origin of itself", 116.0), ("nested visible", 224.0)]
)
def test_what_browsers_read_and_resvg_does_not(name, expected, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(f"<svg {NAMES} {PAGE}>{DRAWINGS[name]}</svg>")
    assert sum(map(area, from_file(path).polygons)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("fill", "bar", "expected", "note"),
    [
        ("#eee", BAR, 224.0, "for paper"),
        ("#222", BAR.replace("path", 'path fill="#fd0"'), 224.0, "for paper"),
        ("#222", BAR.replace("path", 'path fill="#fff"'), 576.0, "for a body, and what is white in it for holes"),
        ("#222", '<path fill="#fd0" d="M20 0h20v20h-20z"/>', 800.0, "for a body"),  # two tones up to the edge
        ("#222", '<path fill="#fd0" opacity=".3" d="M6 6h28v8H6z"/>', 800.0, None),  # a shade
        ("#222", BAR.replace("path", 'path fill="#222"'), 800.0, None),
    ],
)
def test_a_coloured_page_is_paper_below_a_third_colour(tmp_path, fill, bar, expected, note):
    path = tmp_path / "drawing.svg"
    path.write_text(f'<svg {NAMES} {PAGE}><rect width="40" height="20" fill="{fill}"/>{bar}</svg>')
    outline = from_file(path)
    assert sum(map(area, outline.polygons)) == pytest.approx(expected)
    assert (note or "") in "".join(outline.notes)
    assert bool(note) == bool(outline.notes)


@pytest.mark.parametrize(
    ("body", "before", "size", "note"),
    [
        (f'<rect width="100%" height="100%" fill="#ffffff"/>{BAR}', "", (28, 8), "rectangle as large as the page"),
        (f'<path d="M0 0h40v20H0z" fill="none"/>{BAR}', "", (28, 8), "left out 1 hidden shape"),
        (f"<style>@media print{{.g{{display:none}}}}</style><g class='g'>{BAR}</g>", "", (28, 8), None),
        (f"<style media='print'>path{{display:none}}</style>{BAR}", "", (28, 8), None),
        (BAR, ILLUSTRATOR, (28, 8), None),
        ('<rect width="40" height="20" fill="white"/>', "", (40, 20), None),  # all there is
        *[
            (f'<rect width="40" height="20" {white}/>{BAR}', "", (28, 8), "rectangle as large as the page")
            for white in (
                'fill="rgb(100%,100%,100%)"',
                'fill="hsl(0 0% 100%)"',
                'fill="#ffffffff"',
                'fill="#fefefe"',
                'fill="#fff" stroke="#fff"',
                'fill="currentColor" color="#fff"',
                'fill="#fff" rx="2"',
            )
        ],
        (f'<filter id="f"><feGaussianBlur/></filter><g filter="url(#f)">{BAR}</g>', "", (28, 8), "left out 1 filter"),
        ('<rect x="20" y="6" width="40" height="8"/>', "", (40, 8), "took whole what the page's edge cuts"),
        ('<path stroke="red" stroke-width="2" d="M6 6h28v8H6z"/>', "", (30, 10), None),
        (f'{BAR}<path fill="none" stroke="red" stroke-width=".1" d="M6 6h9"/>', "", (28, 8), "left out 1 thin line"),
        ('<path fill="none" stroke="red" stroke-width=".5" d="M6 6h28v8H6z"/>', "", (28, 8), None),  # for a laser
        (f'<path d="M0 0h40v20H0z" fill="none" stroke="red" stroke-width=".1"/>{BAR}', "", (28, 8), "thin rectangle"),
        ('<path stroke="red" stroke-width=".1" d="M6 6h28v8H6z"/>', "", (28, 8), None),
    ],
)
def test_omitted_parts_are_reported(tmp_path, body, before, size, note):
    names = NAMES.replace("http://www.w3.org/2000/svg", "&ns_svg;") if before else NAMES
    path = tmp_path / "drawing.svg"
    path.write_text(f"{before}<svg {names} {PAGE}>{body}</svg>")
    outline = from_file(path)
    np.testing.assert_allclose(np.ptp(outline.polygons[0], axis=0), size, rtol=1e-9)
    assert len(outline.polygons) == 1
    assert (note is None) == (not outline.notes)
    assert note is None or note in outline.notes[0]
