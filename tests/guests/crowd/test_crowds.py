"""What crowds do, by walkers of which it is known: at random, in lattices, aligned, milling."""

import numpy as np
import pytest
import shapely
from crowd_films import BOX, DISHES, gas, make_film

from walkergen.core import dish as dishes
from walkergen.core.errors import InputError
from walkergen.guests.crowd import statistics as crowds
from walkergen.guests.crowd.statistics import boxes, clusters, dish_geometry, fluctuations, order, packing, pairs, walls
from walkergen.guests.crowd.statistics.summary import RANGES


def polygon_of(dish):
    """Dish as a polygon of 4 000 corners a circle."""
    if dish.kind in ("rectangle", "periodic"):
        x, y = (0.5 * side for side in dish.box)
        return shapely.box(-x, -y, x, y)
    outer, *inner = (shapely.Point(0, 0).buffer(0.5 * size, 1000) for size in dish.sizes)
    return outer.difference(inner[0]) if inner else outer


@pytest.mark.parametrize("words", DISHES)
def test_walkers_at_random_have_the_numbers_of_chance_in_every_dish(words):
    found = crowds.measure([gas(words, 150, 25, seed) for seed in range(6)])
    g = found.curves["g"]
    assert abs((g.value - 1.0).mean()) < 0.01
    assert np.sqrt((((g.value - 1.0) / g.se) ** 2).mean()) < 2.0  # Student's t of 5 degrees: 1.3
    for name in ("polar_correlation", "nematic_correlation"):
        curve = found.curves[name]
        assert np.nanmean(np.abs(curve.value) / curve.se) < 1.7
    fluctuations_ = found.curves["fluctuations"]
    assert fluctuations_.value == pytest.approx(fluctuations_.at, rel=0.2)
    for name, chance in found.by_chance.items():
        estimate = found.numbers[name]
        if estimate.value is not None:
            assert abs(estimate.value - chance) < 5.0 * estimate.se + 0.01 * chance, name
    assert found.numbers["packing"].value == pytest.approx(150 * 3.0 / dishes.parse_dish(words).area)
    assert found.numbers["packing"].se == 0.0


@pytest.mark.parametrize("words", DISHES[:3])
def test_circles_are_cut_by_walls_as_polygons_are(words):
    dish, rng = dishes.parse_dish(words), np.random.default_rng(1)
    whole, angle = polygon_of(dish), np.linspace(0.0, 2.0 * np.pi, 4001)
    x, y = (rng.uniform(-0.5, 0.5, 400) * side for side in dish.box)
    inside = dish_geometry.wall_distance(x, y, dish) > 0
    x, y = x[inside], y[inside]
    radius = rng.uniform(0.5, 0.5 * min(dish.box), len(x))
    share = dish_geometry.share_inside(x, y, radius, dish)
    for own, *circle in zip(share, x, y, radius, strict=True):
        line = np.column_stack([np.cos(angle), np.sin(angle)]) * circle[2] + circle[:2]
        cut = shapely.LineString(line).intersection(whole).length
        assert own == pytest.approx(cut / (2.0 * np.pi * circle[2]), abs=2e-3)
    assert share.min() < 0.9


@pytest.mark.parametrize("words", DISHES[:3])
def test_the_area_beyond_a_depth_is_that_of_the_dish_shrunk(words):
    dish = dishes.parse_dish(words)
    for depth in np.linspace(0.0, dish_geometry.max_wall_distance(dish), 7):
        shrunk = polygon_of(dish).buffer(-depth, quad_segs=500, join_style="mitre").area
        assert dish_geometry.area_beyond(np.array(depth), dish) == pytest.approx(shrunk, abs=1e-3 * dish.area)


@pytest.mark.parametrize("words", DISHES)
@pytest.mark.parametrize("parts", [3, 7, 12])
def test_boxes_are_those_that_lie_inside_the_dish(words, parts):
    dish = dishes.parse_dish(words)
    grid, ground_ = boxes.inner_grid(dish, parts), polygon_of(dish)
    assert grid.used.any() or (words, parts) == ("ring:160,60", 3)
    for (column, row), used in np.ndenumerate(grid.used):
        x, y = (grid.side * (at - 0.5 * number) for at, number in zip((column, row), grid.used.shape, strict=True))
        box = shapely.box(x, y, x + grid.side, y + grid.side)
        assert used == (box.difference(ground_).area < 1e-3)
    cut = boxes.clipped_grid(dish, parts)
    assert 0.8 * dish.area < cut.areas.sum() < 1.0001 * dish.area


def test_a_fixed_number_in_the_dish_does_not_calm_its_boxes():
    """The largest boxes hold a ninth of the dish: uncorrected they would vary by 11 % less."""
    found = fluctuations.measure([gas("periodic:150", 60, 2500, 6)])
    assert found.variances[0] / found.means == pytest.approx(1.0, abs=0.05)
    assert found.exponents[0] == pytest.approx(0.5, abs=0.02)


def test_a_lattice_hardly_fluctuates():
    """Commensurate boxes not at all; of a lattice at random places and turns only the edges."""
    line = 5.0 * (np.arange(30) - 14.5)
    lattice = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    still = np.zeros((6, 900, 3))
    still[..., :2] = lattice
    frozen = fluctuations.measure([make_film(still, "periodic:150")])
    assert not frozen.variances.any()
    rng, places = np.random.default_rng(3), []
    for _ in range(200):
        c, s = np.cos(turn := rng.uniform(0, 7)), np.sin(turn)
        places.append(lattice @ [[c, s], [-s, c]] + rng.uniform(-2.5, 2.5, 2))
    places = np.concatenate([places, np.zeros((200, 900, 1))], axis=2)
    moved = fluctuations.measure([make_film(places, "disc:100")])
    large = moved.means > 10
    assert (moved.variances[0] < 0.35 * moved.means)[large].all()
    assert moved.exponents[0] < 0.35


def test_a_phase_that_moves_from_side_to_side_fluctuates_with_power_one():
    rng, places = np.random.default_rng(4), np.zeros((200, 3000, 3))
    places[..., 0] = rng.uniform(0, 100, (200, 3000)) * rng.choice([-1, 1], (200, 1))
    places[..., 1] = rng.uniform(-50, 50, (200, 3000))
    found = fluctuations.measure([make_film(places, "rectangle:200x100")])
    assert found.exponents[0] > 0.85


def test_headings_one_way_and_both_ways_along_a_line():
    film = gas("disc:100", 60, 5, 1)
    theta = np.full(film.x.shape, 0.7) + 2.0 * np.pi * np.arange(60)  # full turns do not count
    assert order.polar_order(film._replace(theta=theta)) == pytest.approx(1.0)
    both = theta + np.pi * (np.arange(60) % 2)
    assert order.polar_order(film._replace(theta=both)) == pytest.approx(0.0, abs=1e-12)
    assert order.nematic_order(film._replace(theta=both)) == pytest.approx(1.0)
    found = pairs.measure(film._replace(theta=both), np.linspace(0, 50, 21))
    assert np.nanmean(found.near_nematic) == pytest.approx(1.0)


@pytest.mark.parametrize("walkers", [20, 300])
def test_the_order_of_chance_falls_as_the_root_of_the_number(walkers):
    film = gas("disc:100", walkers, 1500, 2)
    for values, chance in (
        (order.polar_order(film), order.random_order(walkers)),
        (order.nematic_order(film), order.random_order(walkers)),
        (np.abs(order.circulation(film)), order.random_circulation(walkers)),
    ):
        error = values.std() / np.sqrt(len(values))
        assert abs(values.mean() - chance) < 4.0 * error + 0.01 * chance


def mill(walkers, frames, rate=2.0, radius=40.0, clockwise=False):
    """Walkers that circle about the middle at `rate` (rad/s), places and headings, (F, N, 3)."""
    sense = -1.0 if clockwise else 1.0
    start = np.linspace(0.0, 2.0 * np.pi, walkers, endpoint=False)
    angle = start + sense * rate * 0.05 * np.arange(frames)[:, None]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return np.stack([x, y, angle + sense * 0.5 * np.pi], axis=2)


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_mill_circles_along_its_wall_and_comes_back(clockwise):
    film = make_film(mill(30, 400, clockwise=clockwise), "disc:84", interval=0.05)
    found = crowds.measure([film])
    sense = -1.0 if clockwise else 1.0
    assert found.numbers["circulation"].value == pytest.approx(sense)
    assert found.numbers["milling"].value == pytest.approx(1.0)
    assert found.numbers["wall_alignment"].value == pytest.approx(1.0)
    chord = 2.0 * 40.0 * np.sin(0.5 * 2.0 * 0.05) / 0.05
    assert found.numbers["speed"].value == pytest.approx(chord)
    assert found.numbers["polar_order"].value == pytest.approx(0.0, abs=1e-12)
    lag, squares, _ = found.curves["msd"]
    assert squares == pytest.approx(2.0 * 40.0**2 * (1.0 - np.cos(2.0 * lag)), abs=1e-6)


def test_all_walkers_at_the_wall_are_as_dense_as_the_strip_is_small():
    film = make_film(mill(30, 10, radius=41.0), "disc:84")
    found, near = walls.measure(film), walls.near_distance(film)
    strip = 1.0 - (1.0 - near / 42.0) ** 2
    assert found.near_density == pytest.approx(1.0 / strip)
    assert np.isnan(found.speed[-1])
    assert found.density[-1] == 0.0
    # All of the dish is in the bins: the densities weighted with their areas are 1
    half = 0.5 * (found.at[1] - found.at[0])
    inner, outer = 42.0 - found.at - half, 42.0 - found.at + half
    assert found.density @ (outer**2 - inner**2) / 42.0**2 == pytest.approx(1.0)
    assert inner[-1] == pytest.approx(0.0, abs=1e-9)


def chains(side):
    """Bars of 24 x 4 mm: five and three end to end, two side by side but 2 mm apart, one alone."""
    rows = [(24.2 * n - 60.0, 30.0, 0.0) for n in range(5)]
    rows += [(24.2 * n - 60.0, -30.0, np.pi) for n in range(3)]
    rows += [(30.0, -40.0, 0.5 * np.pi), (36.0, -40.0, 0.5 * np.pi), (side, 0.0, 0.0)]
    return np.repeat(np.array(rows)[None], 4, axis=0)


BAR = BOX * (8.0, 4.0)


def test_clusters_are_of_outlines_that_touch_and_of_no_others():
    film = make_film(chains(0.0), "rectangle:200x100", BAR)
    found = clusters.measure(film)
    assert found.number == pytest.approx(5.0)
    assert found.largest == pytest.approx(5 / 11)
    assert found.size == pytest.approx((25 + 9 + 3) / 11)
    assert found.alone == pytest.approx(3 / 11)
    assert found.touching == pytest.approx(2 * 6 / 11)
    assert found.shares == pytest.approx([3 / 11, 3 / 11, 5 / 11, 0.0])
    # By outer radii alone the two side by side are one, as is every chain
    round_ = clusters.measure(film._replace(outlines={}))
    assert round_.number == pytest.approx(4.0)


def test_walkers_touch_across_the_edges_of_a_periodic_square():
    places = np.repeat([[(74.0, 0.0, 0.0), (-53.0, 0.0, 0.0), (0.0, 60.0, 0.0)]], 4, axis=0)
    film = make_film(places, "periodic:150", BAR)
    assert clusters.measure(film).number == pytest.approx(2.0)
    shifted = film._replace(x=film.x + 300.0)  # not wrapped: the same walkers two squares away
    assert clusters.measure(shifted).number == pytest.approx(2.0)


def test_packing_is_the_share_covered_and_its_mean_over_boxes_that_cover_the_dish():
    film = gas("rectangle:200x100", 400, 50, 5)
    local = packing.local_packing(film)
    assert local.mean() == pytest.approx(packing.total_packing(film).mean(), rel=1e-9)
    disc = gas("disc:120", 400, 200, 5)  # some of it lies in boxes that are mostly outside
    assert packing.local_packing(disc).mean() == pytest.approx(packing.total_packing(disc).mean(), rel=0.03)


def test_errors_are_the_scatter_of_the_runs():
    found = crowds.measure([gas("disc:100", 40, 8, seed) for seed in range(5)])
    for name in ("polar_order", "speed", "cluster_size", "wall_density", "fluctuation_exponent"):
        values = found.by_run[name]
        assert found.numbers[name].value == pytest.approx(values.mean())
        assert found.numbers[name].se == pytest.approx(values.std(ddof=1) / np.sqrt(5))
        assert found.numbers[name].freedom == 4
    course = found.series["polar_order"]
    assert len(course.at) == 8
    assert (course.se > 0).all()


@pytest.mark.parametrize("runs", [1, 2, 3])
def test_fewer_than_four_short_runs_have_values_and_no_bounds(runs):
    found = crowds.measure([gas("disc:100", 40, 8, seed) for seed in range(runs)])
    count = "one run is too short" if runs == 1 else f"{runs} runs are too few"
    for name in ("polar_order", "speed", "cluster_size", "wall_density", "fluctuation_exponent"):
        number = found.numbers[name]
        assert number.value == pytest.approx(found.by_run[name].mean())
        assert (number.se, number.interval(), number.refused) == (None, None, f"{count} for bounds")
    assert found.numbers["packing"].se == 0.0
    assert np.isnan(found.series["polar_order"].se).all()
    assert np.isnan(found.curves["g"].se).all()


def test_bounds_stay_within_possible_values():
    found = crowds.measure([gas("disc:100", 3, 4, seed) for seed in range(4)])
    known = [name for name in RANGES if found.numbers[name].known]
    assert len(known) > 8
    for name in known:
        least, most = RANGES[name]
        low, high = found.numbers[name].interval()
        assert least <= low <= found.numbers[name].value <= high <= most, name
    clipped = [found.numbers[name] for name in known if found.numbers[name].ends is not None]
    assert clipped
    for number in clipped:
        wide = number._replace(ends=None).interval()
        assert wide[0] < RANGES[number.key][0] or wide[1] > RANGES[number.key][1]


@pytest.mark.slow
def test_one_run_has_an_error_where_it_is_long_and_none_where_it_is_short():
    long = crowds.measure([gas("disc:100", 40, 200, 1)]).numbers["polar_order"]
    many = crowds.measure([gas("disc:100", 40, 200, seed) for seed in range(6)])
    assert long.se == pytest.approx(many.by_run["polar_order"].std(ddof=1), rel=0.7)
    short = crowds.measure([gas("disc:100", 40, 30, 1)])
    assert short.numbers["polar_order"].se is None
    assert short.numbers["polar_order"].value is not None
    assert np.isnan(short.curves["g"].se).all()
    # A run that drifts all the while has no error, however many frames it has
    film = gas("disc:100", 40, 200, 1)
    narrowing = film.theta * np.linspace(1.0, 0.1, 200)[:, None]
    drifting = crowds.measure([film._replace(theta=narrowing)])
    assert drifting.numbers["polar_order"].se is None


def test_walkers_that_are_not_seen_are_left_out():
    film = gas("disc:100", 80, 40, 3)
    hidden = np.random.default_rng(1).random(film.x.shape) < 0.5
    half = [np.where(hidden, np.nan, part) for part in (film.x, film.y, film.theta)]
    found = crowds.measure([film._replace(x=half[0], y=half[1], theta=half[2])])
    assert found.walkers in (39, 40, 41)
    assert found.curves["g"].value.mean() == pytest.approx(1.0, abs=0.03)
    assert found.numbers["packing"].value == pytest.approx(40 * 3.0 / film.dish.area, rel=0.05)
    assert found.numbers["polar_order"].value == pytest.approx(order.random_order(40), rel=0.2)


def test_what_is_not_known_is_refused_with_its_reason():
    places = gas("periodic:100", 30, 10, 1, None)
    found = crowds.measure([places, places])
    assert found.numbers["packing"].refused == "no outlines known"
    assert found.numbers["wall_speed"].refused == "a periodic dish has no wall"
    blind = places._replace(theta=np.full(places.x.shape, np.nan))
    found = crowds.measure([blind])
    assert found.numbers["polar_order"].refused == "no headings known"
    assert found.numbers["speed"].value > 0


@pytest.mark.parametrize(
    ("films", "named"),
    [
        ([], "no run"),
        ([gas("disc:100", 9, 8, 1), gas("disc:90", 9, 8, 1)], "disc:90 and walker in disc:100"),
        ([gas("disc:100", 9, 3, 1)], "3 frames. At least 4 are needed"),
    ],
)
def test_crowds_that_cannot_be_measured_are_refused(films, named):
    with pytest.raises(InputError, match=named):
        crowds.measure(films)
