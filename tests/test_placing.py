"""Legs that place themselves: under outlines of any shape, about the centre of mass, or a reason."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from walkergen.errors import GeometryError
from walkergen.walker.placing import EDGE_MM, NARROWEST_MM, STEADY, Reach, rows

LEG = Reach(1.1, 1.5)  # 7.5 mm at 10 deg: its top is ahead of its foot


def star(radii):
    angles = np.linspace(0, 2 * math.pi, len(radii), endpoint=False)
    return shapely.Polygon(np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))


def placed(ground, height=8.0, reach=LEG):
    centre = ground.centroid
    return rows(ground, (centre.x, centre.y), height, reach)


def check(ground, found, reach=LEG, height=8.0):
    centre, (back, front) = ground.centroid, found
    assert back.along < centre.x < front.along
    assert front.along - back.along >= STEADY * height - 1e-9
    for row in found:
        for across, width in row.legs:
            assert width >= NARROWEST_MM
            low, high = across - 0.5 * width, across + 0.5 * width
            top = shapely.box(row.along + reach.back, low, row.along + reach.front, high)
            assert ground.buffer(0.01).contains(top)  # ROUNDED_MM


def test_a_rectangle_gets_the_papers_legs():
    back, front = placed(shapely.box(-14, -4, 14, 4))
    assert front.along == pytest.approx(-back.along)
    assert front.along - back.along == pytest.approx(13.0, abs=0.4)  # the grid of tries
    assert back.legs == front.legs == ((0.0, pytest.approx(8.0 - 2 * EDGE_MM)),)


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
@pytest.mark.parametrize("reach", [Reach(-0.2, 0.2), LEG, Reach(3.5, 4.2), Reach(-4.2, -3.5), Reach(-0.3, 1.5)])
def test_legs_stand_under_shapes_that_people_bring(name, reach):
    found = placed(SHAPES[name], reach=reach)
    check(SHAPES[name], found, reach)
    centre = SHAPES[name].centroid
    assert 0.5 * (found[0].along + found[1].along) == pytest.approx(
        centre.x, abs=0.16 * np.ptp([r.along for r in found])
    )


def test_a_hole_divides_a_row():
    back, front = placed(SHAPES["slotted"])
    assert len(back.legs) == 2
    assert sum(across for across, _ in back.legs) == pytest.approx(0.0, abs=1e-9)  # left and right alike
    assert back.along < front.along


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.floats(6.0, 20.0), min_size=5, max_size=24))
def test_stars_of_any_kind_stand_or_say_why(radii):
    ground = star(radii)
    try:
        found = placed(ground)
    except GeometryError:
        assume(False)
    check(ground, found)


@pytest.mark.parametrize("ground", [shapely.Point(0, 0).buffer(1.0), shapely.box(-14, -0.4, 14, 0.4)])
def test_what_does_not_stand_says_what_would(ground):
    with pytest.raises(GeometryError, match=r"^legs.place: no two rows .* make it larger, or its legs shorter$"):
        placed(ground)
