"""Positions of a crowd without overlap: random one by one, or, for dense crowds, by growth.

Sparse crowds are random sequential additions, largest walkers first (B. Widom, J. Chem. Phys. 44, 3888, 1966). If such
additions find no room, walkers start smaller. They then move at random and grow in turns as far as the others allow: a
Monte Carlo compression of hard bodies. Deterministic for a given generator and given outlines.
"""

import math
from collections.abc import Sequence

import numpy as np

from walkergen.core import Array, Dish, InputError, Whole
from walkergen.guests.crowd.space import overlap
from walkergen.guests.crowd.space.overlap import Bounds, Cells, Outlines
from walkergen.readers.drawings.outlines import area

Outline = Sequence[Array]

MAX_SPARSE_PACKING = 0.4
"""Largest packing for adding walkers at their full size."""

MAX_TRIES_PER_WALKER = 400
"""Largest mean number of random poses that are tried for a walker before all walkers start smaller."""

MIN_SCALE = 0.02
"""Smallest scale at which walkers start."""

GROWTH_RATES = (0.1, 0.01, 0.001)
"""Largest relative growth of a walker in a move. Each rate is tried after the crowd has jammed at the one before."""

SHRINK_SCALE = 0.9
"""Factor by which all walkers shrink before they grow at the next rate."""

MAX_SCALE_RATIO = 1.05
"""Largest scale over the smallest: all grow together."""

STALL_MOVES, MIN_GROWTH = 200, 0.2
"""Moves of each walker, and growth rates by which the smallest scale must grow in them; else the crowd has jammed."""

MAX_MOVES = 30_000_000
"""Largest number of moves of all walkers at one growth rate, about half a minute."""

SIMPLIFY_MM = 0.01
"""Largest distance (mm) of simplified outlines inside the true ones."""


def place_outlines(outlines: Sequence[Outline], dish: Dish, rng: np.random.Generator, clearance_mm: float) -> Array:
    """Place walkers at random without overlap: x, y (mm) and heading (rad) of each origin O, shape (N, 3).

    `outlines`: contours of each walker, from O, equal walkers sharing one object. Any two are `clearance_mm` apart at
    least, and from walls half of it. Raises InputError when there is no room, with the densest packing that was
    reached.
    """
    shapes, middles = _make_outlines(outlines, 0.5 * clearance_mm)
    bounds = make_bounds(dish)
    _check_size(shapes, dish)
    areas = np.array([sum(area(ring) for ring in outline) for outline in outlines])
    packing = float(areas.sum()) / dish.area
    if packing >= 1.0:
        raise _density_error(len(outlines), packing, None)
    order = np.argsort(-areas, kind="stable")
    scale = 1.0 if packing <= MAX_SPARSE_PACKING else math.sqrt(0.75 * MAX_SPARSE_PACKING / packing)
    while True:
        scales = np.full(len(outlines), scale)
        placed = _add_walkers(shapes, bounds, scales, order, rng)
        if placed is not None:
            break
        scale *= 0.85
        if scale < MIN_SCALE:
            raise _density_error(len(outlines), packing, None)
    places, cells = placed
    if scale < 1.0 and not _grow_walkers(shapes, bounds, cells, places, scales, rng):
        raise _density_error(len(outlines), packing, float(areas @ scales**2) / dish.area)
    return _to_origin_poses(places, middles[shapes.kind])


def find_overlap(outlines: Sequence[Outline], dish: Dish, places: Array) -> int | None:
    """Return the first walker that overlaps another or a wall, or None. `places`: poses of origins O, (N, 3)."""
    shapes, middles = _make_outlines(outlines, 0.0)
    bounds = make_bounds(dish)
    about_middle = _to_origin_poses(places, -middles[shapes.kind])
    cells = overlap.empty_cells(shapes, bounds)
    first = int(overlap.find_overlap(shapes, bounds, cells, about_middle, np.ones(len(places))))
    return None if first == overlap.NO_WALKER else first


def make_bounds(dish: Dish) -> Bounds:
    """Return the walls of a dish as the kernels of `overlap` read them."""
    number = ("disc", "ring", "rectangle", "periodic").index(dish.kind)
    inner = 0.5 * dish.sizes[1] if len(dish.sizes) > 1 else 0.0
    return Bounds(number, 0.5 * dish.sizes[0], inner, dish.period)


def _make_outlines(outlines: Sequence[Outline], margin: float) -> tuple[Outlines, Array]:
    """Return outlines of all kinds, widened by a margin (mm), and their middles from O, (kinds, 2), mm."""
    import shapely

    numbers: dict[int, int] = {}
    distinct = [each for each in outlines if numbers.setdefault(id(each), len(numbers)) is not None]
    kinds = {id(each): each for each in distinct}
    edges, starts, middles, outer, inner = [], [], [], [], []
    for outline in kinds.values():
        whole = shapely.union_all([shapely.Polygon(ring) for ring in outline])
        if margin > 0.0:
            whole = whole.buffer(margin + SIMPLIFY_MM, join_style="mitre").simplify(SIMPLIFY_MM)
        middle = shapely.minimum_bounding_circle(whole).centroid
        rings = [np.asarray(part.exterior.coords)[:-1] - (middle.x, middle.y) for part in shapely.get_parts(whole)]
        edges.append(np.vstack([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings]))
        starts.append(np.array([ring[0] for ring in rings]))
        middles.append((middle.x, middle.y))
        outer.append(float(np.hypot(*np.vstack(rings).T).max()))
        holds_middle = whole.contains(middle)
        inner.append(float(whole.exterior.distance(middle)) if holds_middle else 0.0)
    return Outlines(
        np.array([numbers[id(each)] for each in outlines], np.int64),
        np.cumsum([0, *map(len, edges)]),
        np.vstack(edges),
        np.cumsum([0, *map(len, starts)]),
        np.vstack(starts),
        np.array(outer),
        np.array(inner),
    ), np.array(middles)


def _to_origin_poses(places: Array, middles: Array) -> Array:
    """Convert poses of the outlines' middles to poses of the origins O. `middles`: from O, shape (N, 2), mm."""
    c, s = np.cos(places[:, 2]), np.sin(places[:, 2])
    x, y = middles.T
    turned = np.column_stack([c * x - s * y, s * x + c * y])
    return np.column_stack([places[:, :2] - turned, places[:, 2]])


def _add_walkers(
    shapes: Outlines, bounds: Bounds, scales: Array, order: Whole, rng: np.random.Generator
) -> tuple[Array, Cells] | None:
    """Add walkers at random in `order`. Return the poses of their middles, (N, 3), and cells; None without room."""
    cells = overlap.empty_cells(shapes, bounds)
    places = np.zeros((len(order), 3))
    done, tries = 0, MAX_TRIES_PER_WALKER * len(order)
    while tries > 0:
        batch = min(tries, 100_000)
        randoms = rng.random((batch, 3))
        done = overlap.add_walkers(shapes, bounds, cells, places, scales, order, done, randoms)
        if done == len(order):
            return places, cells
        tries -= batch
    return None


def _grow_walkers(
    shapes: Outlines, bounds: Bounds, cells: Cells, places: Array, scales: Array, rng: np.random.Generator
) -> bool:
    """Move walkers and grow them to full size, in `cells`, `places` and `scales`. Return False if there is no room."""
    for number, rate in enumerate(GROWTH_RATES):
        if number > 0:
            scales *= SHRINK_SCALE
        if _grow_at_rate(shapes, bounds, cells, places, scales, rng, rate):
            return True
    return False


def _grow_at_rate(
    shapes: Outlines, bounds: Bounds, cells: Cells, places: Array, scales: Array, rng: np.random.Generator, rate: float
) -> bool:
    """Move walkers in place and grow them by at most `rate` (relative) a move. Return whether all reach full size."""
    n, largest = len(places), float(shapes.outer.max())
    steps, smallest = np.array([0.3 * largest, 0.5]), float(scales.min())  # shift (mm) and turn (rad)
    min_steps, max_steps = np.array([1e-4 * largest, 1e-4]), np.array([largest, math.pi])
    for number in range(max(MAX_MOVES // n, STALL_MOVES)):
        max_scale, randoms = min(1.0, MAX_SCALE_RATIO * float(scales.min())), rng.random((n, 4))
        moved = overlap.move_and_grow(shapes, bounds, cells, places, scales, randoms, steps, rate, max_scale)
        if scales.min() == 1.0:
            return True
        steps = np.clip(steps * (1.1 if moved > 0.4 * n else 0.9), min_steps, max_steps)
        if number % STALL_MOVES == STALL_MOVES - 1:
            if float(scales.min()) < smallest * (1.0 + MIN_GROWTH * rate):
                return False
            smallest = float(scales.min())
    return False


def _check_size(shapes: Outlines, dish: Dish) -> None:
    """Raise InputError if the dish has no room for the largest walker alone."""
    across = 2.0 * float(shapes.outer.max())
    room = min(dish.box)
    alone = across > dish.sizes[0] if dish.kind == "disc" else across > dish.period > 0.0
    if alone:
        raise InputError(
            f"crowd.arena_mm = {dish.words!r}: a walker with its clearance is {across:.4g} mm wide, and the dish "
            f"{room:g} mm. Use a larger dish."
        )


def _density_error(count: int, packing: float, reached: float | None) -> InputError:
    """Return the error for a crowd without room; `reached`: largest packing that fitted, if known."""
    number = "one walker does" if count == 1 else f"{count} walkers do"
    dense = "" if reached is None else f" At most {reached:.2f} was reached."
    return InputError(
        f"{number} not fit into this dish: they would fill {packing:.2f} of it.{dense} "
        "Use fewer walkers (‹count›, ‹packing›), or a larger dish (‹arena›)."
    )
