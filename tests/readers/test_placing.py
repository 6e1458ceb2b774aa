"""Legs that place themselves: under outlines of any shape, about the centre of mass, or a reason."""

import math

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from walkergen.core.errors import GeometryError
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import to_centre_frame
from walkergen.files import templates
from walkergen.readers.walkers.leg_rows import MIN_EDGE_MM, MIN_LEG_WIDTH_MM, MIN_SPAN_PER_HEIGHT, Reach, find_rows

LEG_REACH = Reach(1.1, 1.5)  # 7.5 mm at 10 deg: its top is ahead of its foot


def star(radii):
    angles = np.linspace(0, 2 * math.pi, len(radii), endpoint=False)
    return shapely.Polygon(np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))


def place_legs(ground, height=8.0, reach=LEG_REACH):
    centre = ground.centroid
    return find_rows(ground, (centre.x, centre.y), height, reach)


def check(ground, found, reach=LEG_REACH, height=8.0):
    centre, (back, front) = ground.centroid, found
    assert back.along < centre.x < front.along
    assert front.along - back.along >= MIN_SPAN_PER_HEIGHT * height - 1e-9
    for row in found:
        for across, width in row.legs:
            assert width >= MIN_LEG_WIDTH_MM
            low, high = across - 0.5 * width, across + 0.5 * width
            top = shapely.box(row.along + reach.back, low, row.along + reach.front, high)
            assert ground.buffer(0.01).contains(top)  # ROUNDED_MM


def test_a_rectangle_gets_the_papers_legs():
    back, front = place_legs(shapely.box(-14, -4, 14, 4))
    assert front.along == pytest.approx(-back.along)
    assert front.along - back.along == pytest.approx(13.0, abs=0.4)  # the grid of tries
    assert back.legs == front.legs == ((0.0, pytest.approx(8.0 - 2 * MIN_EDGE_MM)),)


SHAPES = {
    "disc": shapely.Point(0, 0).buffer(14),
    "hexagon": star([15.0] * 6),
    "dumb-bell": shapely.union_all([shapely.Point(-12, 0).buffer(8), shapely.Point(12, 0).buffer(8)]).union(
        shapely.box(-8, -2, 8, 2)
    ),
    "ring": shapely.Point(0, 0).buffer(14).difference(shapely.Point(0, 0).buffer(9)),
    "slotted": shapely.box(-14, -6, 14, 6).difference(shapely.box(-14, -2, 10, 2)),
    "triangle": shapely.Polygon([(-14, -10), (14, 0), (-14, 10)]),
    "arrow": shapely.Polygon([(-14, -4), (2, -4), (2, -10), (14, 0), (2, 10), (2, 4), (-14, 4)]),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("reach", [Reach(-0.2, 0.2), LEG_REACH, Reach(3.5, 4.2), Reach(-4.2, -3.5), Reach(-0.3, 1.5)])
def test_automatic_legs_stand_under_common_shapes(name, reach):
    found = place_legs(SHAPES[name], reach=reach)
    check(SHAPES[name], found, reach)
    centre = SHAPES[name].centroid
    assert 0.5 * (found[0].along + found[1].along) == pytest.approx(
        centre.x, abs=0.16 * np.ptp([r.along for r in found])
    )


def test_a_hole_divides_a_row():
    back, front = place_legs(SHAPES["slotted"])
    assert len(back.legs) == 2
    assert sum(across for across, _ in back.legs) == pytest.approx(0.0, abs=1e-9)  # left and right alike
    assert back.along < front.along


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.floats(6.0, 20.0), min_size=5, max_size=24))
def test_stars_of_any_kind_stand_or_are_refused_with_a_reason(radii):
    ground = star(radii)
    try:
        found = place_legs(ground)
    except GeometryError:
        assume(False)
    check(ground, found)


@pytest.mark.parametrize("ground", [shapely.Point(0, 0).buffer(1.0), shapely.box(-14, -0.4, 14, 0.4)])
def test_an_unstable_body_is_refused_with_a_remedy(ground):
    with pytest.raises(GeometryError, match=r"it tips from any legs$"):
        place_legs(ground)


def svg(folder, path):
    file = folder / "own shape.svg"
    page = 'xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"'
    file.write_text(f'<svg {page}><path d="{path}"/></svg>')
    return file


DRAWN_PATHS = {
    "disc": "M6 15a14 14 0 1 0 28 0a14 14 0 1 0 -28 0z",
    "hexagon": "M5 15L12.5 5H27.5L35 15L27.5 25H12.5z",
    "bell": "M10 7A8 8 0 1 0 10 23L14 19L26 19L30 23A8 8 0 1 0 30 7L26 11L14 11Z",
    "heart": "M20 27C-2 14 8 2 20 9C32 2 42 14 20 27z",
    "fish": "M3 15Q16 2 27 13L37 8V22L27 17Q16 28 3 15z",
    "ring": "M6 15a14 14 0 1 0 28 0a14 14 0 1 0 -28 0zM11 15a9 9 0 1 1 18 0a9 9 0 1 1 -18 0z",
    "arrow": "M4 11H22V5L36 15L22 25V19H4z",
    "cross": "M15 3H25V10H36V20H25V27H15V20H4V10H15z",
}


@pytest.mark.parametrize("shape", DRAWN_PATHS)
def test_a_drawing_is_a_walker_with_automatic_legs(tmp_path, shape):
    path = svg(tmp_path, DRAWN_PATHS[shape])
    design = templates.load(path, "walkers", Design)
    assert design.name == "own-shape"
    for tilt in (0.0, 10.0, 20.0, -10.0):
        walker = design.variant(tilt_deg=tilt)
        solid = solids.build(walker)
        assert solid.walker.vertices[:, 1].min() < solid.body.vertices[:, 1].min() - 5.0  # it stands on its legs
        mass, feet = solids.mass_of(walker), [limb.along for limb in walker.limbs]
        middle = float(to_centre_frame(walker.limbs, mass, np.zeros((1, 2)))[0, 0])
        assert min(feet) < -middle < max(feet)
    assert design.variant(tilt_deg=20.0).tilt_deg == 20.0


def test_symmetric_bodies_have_equal_legs(tmp_path):
    design = templates.load(svg(tmp_path, DRAWN_PATHS["bell"]), "walkers", Design)
    assert design.is_symmetric_pair


def test_a_mesh_stands_on_its_rounded_side(tmp_path):
    egg = trimesh.creation.icosphere(subdivisions=3)
    egg.apply_scale((12.0, 6.0, 5.0))
    path = tmp_path / "egg.stl"
    path.write_bytes(egg.export(file_type="stl"))
    for tilt in (0.0, 10.0, 25.0):
        design = templates.load(path, "walkers", Design).variant(tilt_deg=tilt)
        solid = solids.build(design)
        lowest = [leg.vertices[:, 1].min() + limb.bottom for leg, limb in zip(solid.legs, design.limbs, strict=True)]
        assert lowest == pytest.approx([lowest[0]] * len(lowest), abs=1e-6)  # all feet on the plate


def test_written_places_are_kept(tmp_path):
    design = templates.load(svg(tmp_path, DRAWN_PATHS["disc"]), "walkers", Design)
    written = design.variant(**{"legs.contact_spacing_mm": 11.0, "legs.width_mm": 6.0})
    assert [(limb.along, limb.width) for limb in written.limbs] == [(-5.5, 6.0), (5.5, 6.0)]
    again = written.variant(**{"legs.placement": "auto"})
    assert again.limbs == design.limbs
