"""Icons of three public sets compared with resvg's pictures of them."""

import gzip
import io
import json
from pathlib import Path

import numpy as np
import pytest
from contourpy import contour_generator
from PIL import Image
from scipy.spatial import cKDTree

from walkergen.readers.drawings.outlines import area, from_file
from walkergen.readers.drawings.svg import read_drawing

resvg_py = pytest.importorskip("resvg_py")

ICONS = json.loads(gzip.decompress(Path(__file__).with_name("icons.json.gz").read_bytes()))["icons"]

SIDE = 480
"""Pixels of a picture's side."""

POINTED = {"bootstrap/cart-fill": "its wheels touch the cart in a point, where pixels join them"}
"""Icons whose rims in the picture are apart from ours by more than 1 % of its side, and why."""


def compare_with_resvg(text, folder):
    """Return the relative difference of areas, and the Hausdorff distance over the page's side, of a drawing."""
    path = folder / "icon.svg"
    path.write_text(text, encoding="utf-8")
    contours = [ring * (1, -1) for ring in read_drawing(path, 1.0, "icon").contours]
    png = bytes(resvg_py.svg_to_bytes(svg_string=text, width=SIDE))
    cover = np.pad(np.array(Image.open(io.BytesIO(png)))[..., 3] / 255.0, 1)  # of each pixel, by their antialiasing
    left, top, width, _ = map(float, text.split('viewBox="')[1].split('"')[0].split())
    unit = width / SIDE
    covered = cover.sum() * unit**2
    rims = [unit * (line - 0.5) + (left, top) for line in contour_generator(z=cover).lines(0.5)]
    ours, theirs = (np.vstack([fill_edges(ring, 0.25 * unit) for ring in rings]) for rings in (contours, rims))
    apart = max(cKDTree(ours).query(theirs)[0].max(), cKDTree(theirs).query(ours)[0].max())
    signed = sum(abs(area(ring)) * (1 if is_outer else -1) for ring, is_outer in orient(contours))
    return signed / covered - 1.0, apart / width


def orient(contours):
    """Yield contours, and whether each is an outer one: the reader turns holes the other way."""
    largest = max(contours, key=lambda ring: abs(area(ring)))
    yield from ((ring, area(ring) * area(largest) > 0.0) for ring in contours)


def fill_edges(ring, step):
    """Return points along a ring at most a step apart."""
    following = np.roll(ring, -1, axis=0)
    counts = np.maximum(np.ceil(np.hypot(*(following - ring).T) / step).astype(int), 1)
    shares = np.concatenate([np.arange(count) / count for count in counts])[:, None]
    return np.repeat(ring, counts, axis=0) * (1.0 - shares) + np.repeat(following, counts, axis=0) * shares


def check_icon(name, folder):
    difference, distance = compare_with_resvg(ICONS[name], folder)
    assert abs(difference) < 0.01  # all of them
    assert (distance > 0.01) == (name in POINTED)


@pytest.mark.parametrize("name", list(ICONS)[::4])
def test_icons_equal_resvgs_pictures(name, tmp_path):
    check_icon(name, tmp_path)


@pytest.mark.slow
def test_all_icons_equal_resvgs_pictures(tmp_path):
    assert len(ICONS) == 360
    for name in ICONS:
        check_icon(name, tmp_path)


BAR = '<rect x="6" y="6" width="28" height="8" fill="#c00"/>'
HALF = "M6 6h14v8h-14z"
MASK = '<mask id="m" maskUnits="userSpaceOnUse" x="0" y="0" width="40" height="20">'
ALPHA = 'mask-type="alpha" id'
GRADIENT = '<linearGradient id="g"><stop stop-color="{}"/><stop offset="1" stop-color="#ddf"/></linearGradient>'
PAINTED = {
    "a second tone": f'{BAR}<path fill="#f80" d="{HALF}"/>',
    "white over half": f'{BAR}<path fill="#fff" d="{HALF}"/>',
    "a shade": f'{BAR}<path opacity=".2" d="{HALF}"/>',
    "a white shine": f'{BAR}<path fill="#fff" fill-opacity=".3" d="{HALF}"/>',
    "a shine that covers": f'{BAR}<path fill="#fff" fill-opacity=".97" d="{HALF}"/>',
    "a shade on paper": '<rect x="6" y="6" width="28" height="8" opacity=".2"/>',
    "a tint of paper": f'{BAR}<rect x="2" y="2" width="36" height="16" opacity=".03"/>',
    "tints add up": BAR + 3 * '<rect x="2" y="2" width="36" height="16" opacity=".03"/>',
    "a white line": f'{BAR}<path stroke="#fff" stroke-width="1" d="M20 0v20"/>',
    "below": f'<path d="M0 0h40v9h-40z"/><path fill="#fff" d="M1 1h38v7h-38z"/>{BAR}',
    "an island in a hole": f'{BAR}<circle fill="#fff" cx="20" cy="10" r="3"/><circle cx="20" cy="10" r="1"/>',
    "a clear layer": f'<g opacity=".04">{BAR}{BAR}{BAR}</g><path d="{HALF}"/>',
    "white in a layer": f'<g opacity=".5">{BAR}<path fill="#fff" d="{HALF}"/></g>',
    "a layer over a body": f'{BAR}<g opacity=".5"><path d="{HALF}"/><path fill="#fff" d="{HALF}"/></g>',
    "a mask": f'{MASK}<rect width="40" height="20" fill="#fff"/><circle cx="20" cy="10" r="3"/></mask>'
    f'<g mask="url(#m)">{BAR}</g>',
    "a mask of alpha": f'{MASK.replace("id", ALPHA)}<circle cx="20" cy="10" r="6"/></mask><g mask="url(#m)">{BAR}</g>',
    "a gradient": f'{GRADIENT.format("#07c")}<circle cx="20" cy="10" r="6" fill="#fd0"/>'
    '<rect x="6" y="8" width="20" height="3" fill="url(#g)"/>',
    "a white gradient": f'{GRADIENT.format("#fff").replace("#ddf", "#fff")}{BAR}<path fill="url(#g)" d="{HALF}"/>',
    "round": '<path fill="none" stroke="#000" stroke-width="3" stroke-linecap="round" d="M6 6h20l-20 8"/>',
    "square": '<path fill="none" stroke="#000" stroke-width="3" stroke-linecap="square" d="M6 6h20l-4 8"/>',
    "mitered": '<path fill="none" stroke="#000" stroke-width="2" d="M6 6l14 6-12 4v-5z"/>',
    "bevelled": '<path fill="none" stroke="#000" stroke-width="2" stroke-linejoin="bevel" d="M6 6h20v8h-20z"/>',
    "miter limits": '<path fill="none" stroke="#000" stroke-width="2" stroke-miterlimit="9" d="M6 5l20 2-20 3"/>',
    "dashes": '<path fill="none" stroke="#000" stroke-width="2" stroke-dasharray="4 2 1" d="M6 6h20v8h-20z"/>',
    "dots": '<path fill="none" stroke="#000" stroke-width="4" stroke-linecap="round" d="M6 6h0M16 6h.01M26 6z"/>',
    "stretched": '<circle r="5" transform="translate(20 10) scale(3 1)" fill="none" stroke="#000" stroke-width="2"/>',
    "fill and line": '<path fill="#fd0" stroke="#000" stroke-width="2" d="M6 6h20v8h-20z"/>',
    "line below fill": f'<path fill="#c00" stroke="#fff" stroke-width="4" paint-order="stroke" d="{HALF}"/>',
    "open fills": '<polyline points="6,6 34,6 34,14"/><path d="M6 15h20v3"/>',
}
"""Drawings in several colours."""

FINE = 40
"""Pixels in a unit of these."""


@pytest.mark.parametrize("name", PAINTED)
def test_what_differs_from_white_paper_is_the_body(name, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 20">{PAINTED[name]}</svg>')
    contours = read_drawing(path, 1.0, name).contours
    shown = resvg_py.svg_to_bytes(svg_path=str(path), width=40 * FINE, shape_rendering="crisp_edges", background="#fff")
    darkest = np.array(Image.open(io.BytesIO(bytes(shown))))[..., :3].min(axis=-1)
    outlines = sum(abs(area(ring)) * (1 if is_outer else -1) for ring, is_outer in orient(contours))
    assert outlines == pytest.approx((darkest < 255 * 0.95).sum() / FINE**2, rel=0.005)


PROGRAMS = {
    '<rect width="28" height="8" fill="#f80"/><rect x="14" width="14" height="8" fill="#c60"/>': 224.0,
    '<path d="M4 0H24A4 4 0 0 1 24 8H4A4 4 0 0 1 4 0z" fill="#07c"/><path d="M4 4H24V8H4z" fill="#05a"/>': 210.27,
    '<rect width="28" height="8"/><rect x="24" y="2" width="4" height="4"/>': 224.0,
    '<rect width="28" height="8"/><rect x="0.05" y="0.05" width="27.9" height="7.9"/>': 224.0,
    '<rect width="28" height="8" fill="#ccc"/><rect width="28" height="8" fill="none" stroke="#000" stroke-width=".2"/>'
    "": 224.0,
    '<path fill-rule="evenodd" d="M0 0H28V8H0zM14 0L18 4L14 6L10 4z"/>': 200.0,
    '<path d="M0 0H28V8H0V0.002"/>': 224.0,
    '<path d="M0 0H28V8H0zM4 2V6H8V2.001"/>': 208.0,
    '<rect width="14" height="8"/><rect x="14.004" width="13.996" height="8" fill="#c60"/>': 224.0,  # a seam
    '<rect width="28" height="8" fill="#fff" stroke="#000" stroke-width=".1"/>'
    '<circle cx="9" cy="4" r="2" fill="#fff" stroke="#000" stroke-width=".1"/>': 211.43,  # outlines filled white
    '<rect width="28" height="8" fill="none" stroke="red" stroke-width=".1"/><circle cx="9" cy="4" r="2"/>': 224.0,
    '<rect width="28" height="8" fill="#fff"/>': 224.0,  # white on nothing
}
"""Drawings as programs write them, and the area of the body."""


@pytest.mark.parametrize("body", PROGRAMS)
def test_bodies_as_programs_draw_them(body, tmp_path):
    path = tmp_path / "drawing.svg"
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="-6 -6 40 20">{body}</svg>'
    )
    outline = from_file(path)
    assert sum(map(area, outline.polygons)) == pytest.approx(PROGRAMS[body], rel=1e-4)
    assert np.ptp(np.vstack(outline.polygons), axis=0) == pytest.approx((28.0, 8.0), rel=1e-6)
    assert ("touch only in a point, and stay apart there: (14, 0) mm" in "".join(outline.notes)) == ("evenodd" in body)
