"""Outlines of SVG drawings beside the pictures that resvg draws of the same files."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw
from scipy import ndimage

from walkergen.errors import InputError
from walkergen.shapes.outlines import area, from_file

resvg_py = pytest.importorskip("resvg_py")

NAMES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
PAGE = 'width="40mm" height="20mm" viewBox="0 0 40 20"'
BAR, ELL = '<path d="M6 6h28v8H6z"/>', '<path d="M4 4h20v4h-14v8h-6z"/>'
ILLUSTRATOR = '<!DOCTYPE svg [<!ENTITY ns_svg "http://www.w3.org/2000/svg">]>'
LINES = Path(__file__).with_name("drawings.txt").read_text().splitlines()
DRAWINGS = {name: body.replace("BAR", BAR).replace("ELL", ELL) for name, body in (line.split(" | ") for line in LINES)}

LATER = {"origin by words", "origin of itself", "nested visible"}
"""Those of which resvg reads less than browsers do: transform as a property, fill-box, overflow."""

UNREAD = {
    "@supports (display:grid){path{display:none}}": "@supports",
    "@layer x{path{display:none}}": "@layer",
    "@media (min-width:1px){path{display:none}}": "the condition '(min-width:1px)'",
    "@media not print{path{display:none}}": "the condition 'not print'",
    "svg{path{display:none}}": "rules within rules",
    "path{zoom:2}": "zoom",
}
"""Style sheets that browsers read and we do not, and what a refusal names."""


ZOOM = 30
"""Pixels of the picture in a unit of the drawing."""


@pytest.mark.parametrize("name", sorted(set(DRAWINGS) - LATER))
def test_outlines_are_what_resvg_draws(name, tmp_path):
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


@pytest.mark.parametrize(
    ("name", "expected"), [("origin by words", 0.25 * 116.0), ("origin of itself", 116.0), ("nested visible", 224.0)]
)
def test_what_browsers_read_and_resvg_does_not(name, expected, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(f"<svg {NAMES} {PAGE}>{DRAWINGS[name]}</svg>")
    assert sum(map(area, from_file(path).polygons)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("sheet", UNREAD)
def test_style_sheets_that_are_not_read_are_refused(sheet, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(f"<svg {NAMES} {PAGE}><style>{sheet}</style>{BAR}</svg>")
    with pytest.raises(InputError, match=re.escape(UNREAD[sheet])):
        from_file(path)


@pytest.mark.parametrize(
    ("body", "before", "size", "note"),
    [
        (f'<rect width="100%" height="100%" fill="#ffffff"/>{BAR}', "", (28, 8), "white rectangle"),
        (f'<path d="M0 0h40v20H0z" fill="none"/>{BAR}', "", (28, 8), "left out 1 shape that nobody sees"),
        (f"<style>@media print{{.g{{display:none}}}}</style><g class='g'>{BAR}</g>", "", (28, 8), None),
        (f"<style media='print'>path{{display:none}}</style>{BAR}", "", (28, 8), None),
        (BAR, ILLUSTRATOR, (28, 8), None),
        ('<rect width="40" height="20" fill="white"/>', "", (40, 20), None),  # all there is
    ],
)
def test_what_is_left_out_is_said(tmp_path, body, before, size, note):
    names = NAMES.replace("http://www.w3.org/2000/svg", "&ns_svg;") if before else NAMES
    path = tmp_path / "drawing.svg"
    path.write_text(f"{before}<svg {names} {PAGE}>{body}</svg>")
    outline = from_file(path)
    np.testing.assert_allclose(np.ptp(outline.polygons[0], axis=0), size, rtol=1e-9)
    assert len(outline.polygons) == 1
    assert (note is None) == (not outline.notes)
    assert note is None or note in outline.notes[0]
