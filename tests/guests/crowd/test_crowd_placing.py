"""Crowds are placed without overlap, as shapely sees it, from a seed, as dense as they may be."""

import math

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from walkergen.core import dish
from walkergen.core.errors import InputError
from walkergen.guests.crowd.space import placing

BAR = [np.array([(-14.0, -4.0), (14.0, -4.0), (14.0, 4.0), (-14.0, 4.0)])]
HOOK = [np.array([(-12.0, -8), (16, -8), (16, 10), (8, 10), (8, -1), (-12, -1)])]
ANGLES = np.linspace(0.0, 2.0 * math.pi, 91)[:-1]
ROUND = [10.0 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])]
CLEARANCE = 0.2


def polygons_of(outlines, places):
    return [
        translate(
            rotate(
                shapely.union_all([shapely.Polygon(ring) for ring in outline]),
                heading,
                origin=(0.0, 0.0),
                use_radians=True,
            ),
            x,
            y,
        )
        for outline, (x, y, heading) in zip(outlines, places, strict=True)
    ]


def ground_of(ground):
    if ground.kind == "rectangle":
        length, width = ground.sizes
        return shapely.box(-0.5 * length, -0.5 * width, 0.5 * length, 0.5 * width)
    around = shapely.Point(0.0, 0.0).buffer(0.5 * ground.sizes[0], quad_segs=500)
    if ground.kind == "disc":
        return around
    return around - shapely.Point(0.0, 0.0).buffer(0.5 * ground.sizes[1], quad_segs=500)


def placed(outlines, words, seed=1):
    ground = dish.parse_dish(words)
    rng = np.random.default_rng(seed)
    return ground, placing.place_outlines(outlines, ground, rng, CLEARANCE)


def mixed(number):
    return [(BAR, HOOK, ROUND)[k % 3] for k in range(number)]


@pytest.mark.parametrize("words", ["disc:190", "ring:220,80", "rectangle:250x120", "periodic:180"])
def test_no_two_walkers_and_no_wall_are_nearer_than_the_clearance(words):
    outlines = mixed(30)
    ground, places = placed(outlines, words)
    assert placing.find_overlap(outlines, ground, places) is None
    bodies = polygons_of(outlines, places)
    if ground.kind == "periodic":
        side = ground.period
        assert np.abs(places[:, :2]).max() < 0.5 * side + 15.0
        bodies += [
            translate(body, across * side, up * side)
            for body in bodies
            for across in (-1, 0, 1)
            for up in (-1, 0, 1)
            if across or up
        ]
    else:
        inside = ground_of(ground).buffer(-0.49 * CLEARANCE)
        assert all(inside.contains(body) for body in bodies)
    tree = shapely.STRtree(bodies)
    first, second = tree.query(bodies, predicate="dwithin", distance=CLEARANCE)
    assert not np.any(first != second)


def test_a_dense_crowd_grows_where_random_addition_finds_no_room():
    outlines = [ROUND] * 40
    area = 40 * math.pi * 100.0
    words = f"disc:{2 * math.sqrt(area / math.pi / 0.7)}"  # additions end at 0.547
    ground, places = placed(outlines, words)
    bodies = polygons_of(outlines, places)
    apart = [shapely.distance(a, b) for k, a in enumerate(bodies) for b in bodies[:k]]
    assert min(apart) >= CLEARANCE
    assert all(ground_of(ground).contains(body) for body in bodies)


def test_the_same_seed_gives_the_same_places_and_another_one_others():
    for words in ("disc:300", "disc:165"):  # sparse, dense
        first, second, other = (placed(mixed(30), words, seed)[1] for seed in (1, 1, 2))
        assert first.tobytes() == second.tobytes()
        assert first.tobytes() != other.tobytes()


def test_one_disc_is_anywhere_within_its_dish_with_equal_probability():
    squares = [float((placed([ROUND], "disc:50", seed)[1][0, :2] ** 2).sum()) for seed in range(400)]
    room = 25.0 - 10.0 - 0.5 * CLEARANCE
    # Uniform in a disc: r^2 is uniform up to room^2
    assert np.mean(squares) == pytest.approx(0.5 * room**2, abs=4.0 * room**2 / math.sqrt(4800.0))
    assert max(squares) <= room**2


@pytest.mark.parametrize(
    ("number", "words", "named"),
    [
        (1, "disc:20", ("arena_mm", "29.")),
        (1, "periodic:25", ("arena_mm", "29.")),
        (1, "ring:60,50", ("not fit", "(arena)")),
        (30, "disc:100", ("fill 0.86 of it", "At most 0.66", "packing)")),
        (100, "disc:100", ("fill 2.85 of it", "(count, packing)")),
    ],
)
def test_a_crowd_without_room_is_refused_by_its_packing(number, words, named):
    with pytest.raises(InputError) as refused:
        placed([BAR] * number, words)
    assert all(word in str(refused.value) for word in named)


def test_walkers_that_start_inside_each_other_are_found_out():
    ground = dish.parse_dish("disc:200")
    small = [0.2 * ROUND[0]]
    inside = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    assert placing.find_overlap([ROUND, small], ground, inside) == 1
    assert placing.find_overlap([small, ROUND], ground, inside) == 1
    crossed = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 0.5 * math.pi)])
    assert placing.find_overlap([BAR, BAR], ground, crossed) == 1
    apart = np.array([(0.0, 0.0, 0.0), (0.0, 8.1, 0.0)])
    assert placing.find_overlap([BAR, BAR], ground, apart) is None
    assert placing.find_overlap([BAR], ground, np.array([(90.0, 0.0, 0.0)])) == 0
    around = dish.parse_dish("ring:200,10")
    assert placing.find_overlap([BAR], around, np.array([(0.0, 0.0, 0.0)])) == 0
    edge = dish.parse_dish("periodic:60")
    across = np.array([(-25.0, 0.0, 0.0), (25.0, 0.0, 0.0)])
    assert placing.find_overlap([BAR, BAR], edge, across) == 1


@pytest.mark.slow
def test_five_thousand_walkers_take_seconds():
    outlines = [BAR] * 5000
    side = math.sqrt(5000 * 224.0 / 0.45)
    ground, places = placed(outlines, f"periodic:{side}")
    assert placing.find_overlap(outlines, ground, places) is None
