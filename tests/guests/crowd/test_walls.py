"""Walkers by walls: where the nearest wall is, and how it turns what runs against it."""

import math

import numpy as np
import pytest
import shapely
import shapely.affinity

from walkergen.core import dish
from walkergen.guests.crowd.cards import walls

INTERVAL = 1.0 / 90.0
OUTLINE = np.array([(-14.0, -4.0), (14.0, -4.0), (14.0, 4.0), (-14.0, 4.0)])

GROUNDS = {
    "disc:120": shapely.Point(0, 0).buffer(60.0, quad_segs=2000),
    "ring:160,60": shapely.Point(0, 0)
    .buffer(80.0, quad_segs=2000)
    .difference(shapely.Point(0, 0).buffer(30.0, quad_segs=2000)),
    "rectangle:200x100": shapely.box(-100, -50, 100, 50),
}


@pytest.mark.parametrize("words", GROUNDS)
def test_the_nearest_wall_is_the_dish_s_boundary(words):
    """Against shapely, of outlines of many corners: of four, a ring's inner wall meets edges."""
    body = shapely.segmentize(shapely.Polygon(OUTLINE), 0.2)
    outline = np.asarray(body.exterior.coords)[:-1]
    rng, rows = np.random.default_rng(1), []
    while len(rows) < 60:
        x, y = rng.uniform(-100, 100, 2)
        turn = rng.uniform(-math.pi, math.pi)
        placed = shapely.affinity.rotate(body, turn, (0, 0), use_radians=True)
        if GROUNDS[words].contains(shapely.affinity.translate(placed, x, y)):
            rows.append((x, y, turn))
    gaps, outs = walls.nearest_wall(np.array(rows), outline, dish.parse_dish(words))
    for (x, y, turn), gap, out in zip(rows, gaps, outs, strict=True):
        placed = shapely.affinity.rotate(body, turn, (0, 0), use_radians=True)
        placed = shapely.affinity.translate(placed, x, y)
        wall = GROUNDS[words].boundary
        assert gap == pytest.approx(placed.distance(wall), abs=2e-3)
        # Moved out by the gap it touches; by more it is no longer within
        way = math.cos(out), math.sin(out)
        for share, within in ((0.98, True), (1.02, False)):
            there = shapely.affinity.translate(placed, *(share * gap * part for part in way))
            assert GROUNDS[words].contains(there) == within or gap < 0.1


def leaning(seed, rate, runs=16, seconds=3.0):
    """Runs of walkers at the right wall of a square, which turns them by `rate` sin(2 angle)."""
    rng, made = np.random.default_rng(seed), []
    for start in np.linspace(-1.4, 1.4, runs):
        angle, rows = start, []
        for _ in range(round(seconds / INTERVAL)):
            noise = math.sqrt(2.0 * 0.02 * INTERVAL) * rng.normal()
            reach = 14.0 * abs(math.cos(angle)) + 4.0 * abs(math.sin(angle))
            rows.append((100.0 - reach - 0.1, 0.0, angle))
            angle += rate * math.sin(2.0 * angle) * INTERVAL + noise
        made.append(np.array(rows))
    return made


@pytest.mark.parametrize("rate", [2.0, -2.0])
def test_turning_and_alignment_are_those_put_in(rate):
    square = dish.parse_dish("rectangle:200x200")
    runs = leaning(3, rate)
    found = walls.measure(runs, INTERVAL, OUTLINE, square)
    assert found.share.value == 1.0
    angles = np.concatenate([rows[:-1, 2] for rows in runs])
    askew = (np.abs(angles) > walls.OBLIQUE_ANGLES[0]) & (np.abs(angles) < walls.OBLIQUE_ANGLES[1])
    expected = rate * np.sin(2.0 * np.abs(angles[askew])).mean()
    assert abs(found.turning.value - expected) < 3.5 * found.turning.se
    assert found.turning.se < 0.4 * abs(expected)
    assert found.alignment.value * rate > 1.6  # nearly all along the wall, or head on
    width = found.angles[1] - found.angles[0]
    assert found.density.sum() * width == pytest.approx(1.0)


def test_walkers_far_from_walls_tell_nothing_of_them():
    rows = [np.zeros((100, 3)) for _ in range(10)]
    found = walls.measure(rows, INTERVAL, OUTLINE, dish.parse_dish("disc:120"))
    assert found.share.value == 0.0
    assert found.alignment.value is None
    assert "smaller dish" in found.alignment.refused
    few = walls.measure(rows[:2], INTERVAL, OUTLINE, dish.parse_dish("disc:120"))
    assert "at least" in few.turning.refused
