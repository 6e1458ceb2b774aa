"""Places of a crowd without overlap: at random one by one, or, where it is dense, by growth.

Sparse crowds are random sequential additions, largest walkers first (B. Widom, J. Chem. Phys. 44,
3888, 1966). Where such additions find no room, walkers start smaller, and then in turns move at
random and grow as far as the others let them, which is a compression by Monte Carlo moves of hard
bodies. Deterministic: a generator and outlines give places.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from walkergen.core.dish import Dish
from walkergen.core.errors import InputError
from walkergen.guests.crowd.space import overlap
from walkergen.guests.crowd.space.overlap import Bounds, Cells, Outlines
from walkergen.readers.drawings.outlines import area

Array = npt.NDArray[np.float64]
Outline = Sequence[Array]

SPARSE = 0.4
"""Packing up to which walkers are added at their full size."""

TRIES = 400
"""Random places that are tried for each walker at most, on average, before all start smaller."""

SMALLEST = 0.02
"""Scale at which walkers start at the least."""

PACES = (0.1, 0.01, 0.001)
"""Largest growth of a walker with a move: slower where a crowd has jammed."""

LOOSENED = 0.9
"""Scale by which all shrink before they grow at a slower pace."""

TOGETHER = 1.05
"""Largest scale over the smallest: all grow together."""

STALLED, LEAST_GROWTH = 200, 0.2
"""Moves of each walker within which the smallest scale must grow by so many paces."""

MOST_MOVES = 30_000_000
"""Moves of all walkers at a pace at most: half a minute."""

ROUNDING = 0.01
"""Distance (mm) that simplified outlines may lie inside what they stand for."""


def place(outlines: Sequence[Outline], dish: Dish, rng: np.random.Generator, clearance_mm: float) -> Array:
    """Place x, y (mm) and heading (rad) of every walker's O, shape (N, 3), without overlap.

    `outlines`: contours of each walker, from O, equal walkers sharing one object; any two are
    `clearance_mm` apart at least, and from walls half of it. Raises InputError when there is no
    room, with the densest packing that there is.
    """
    shapes, middles = _shapes(outlines, 0.5 * clearance_mm)
    bounds = bounds_of(dish)
    _refuse_too_large(shapes, dish)
    areas = np.array([sum(area(ring) for ring in outline) for outline in outlines])
    packing = float(areas.sum()) / dish.area
    if packing >= 1.0:
        raise _too_dense(len(outlines), packing, None)
    order = np.argsort(-areas, kind="stable")
    scale = 1.0 if packing <= SPARSE else math.sqrt(0.75 * SPARSE / packing)
    while True:
        scales = np.full(len(outlines), scale)
        placed = _added(shapes, bounds, scales, order, rng)
        if placed is not None:
            break
        scale *= 0.85
        if scale < SMALLEST:
            raise _too_dense(len(outlines), packing, None)
    places, cells = placed
    if scale < 1.0 and not _grown(shapes, bounds, cells, places, scales, rng):
        raise _too_dense(len(outlines), packing, float(areas @ scales**2) / dish.area)
    return _about_O(places, middles[shapes.kind])


def overlapping(outlines: Sequence[Outline], dish: Dish, places: Array) -> int | None:
    """Find the first walker that overlaps another or a wall, placed by O; None without any."""
    shapes, middles = _shapes(outlines, 0.0)
    bounds = bounds_of(dish)
    about_middle = _about_O(places, -middles[shapes.kind])
    cells = overlap.cells_of(shapes, bounds)
    first = int(overlap.overlapping(shapes, bounds, cells, about_middle, np.ones(len(places))))
    return None if first == overlap.NONE else first


def bounds_of(dish: Dish) -> Bounds:
    """Return the walls of a dish as kernels read them."""
    number = ("disc", "ring", "rectangle", "periodic").index(dish.kind)
    inner = 0.5 * dish.sizes[1] if len(dish.sizes) > 1 else 0.0
    return Bounds(number, 0.5 * dish.sizes[0], inner, dish.period)


def _shapes(outlines: Sequence[Outline], margin: float) -> tuple[Outlines, Array]:
    """Outlines of all kinds, larger by a margin (mm), and their middles from O, (kinds, 2), mm."""
    import shapely

    numbers: dict[int, int] = {}
    distinct = [each for each in outlines if numbers.setdefault(id(each), len(numbers)) is not None]
    kinds = {id(each): each for each in distinct}
    edges, starts, middles, outer, inner = [], [], [], [], []
    for outline in kinds.values():
        whole = shapely.union_all([shapely.Polygon(ring) for ring in outline])
        if margin > 0.0:
            whole = whole.buffer(margin + ROUNDING, join_style="mitre").simplify(ROUNDING)
        middle = shapely.minimum_bounding_circle(whole).centroid
        rings = [np.asarray(part.exterior.coords)[:-1] - (middle.x, middle.y) for part in shapely.get_parts(whole)]
        edges.append(np.vstack([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings]))
        starts.append(np.array([ring[0] for ring in rings]))
        middles.append((middle.x, middle.y))
        outer.append(float(np.hypot(*np.vstack(rings).T).max()))
        held = whole.contains(middle)
        inner.append(float(whole.exterior.distance(middle)) if held else 0.0)
    return Outlines(
        np.array([numbers[id(each)] for each in outlines], np.int64),
        np.cumsum([0, *map(len, edges)]),
        np.vstack(edges),
        np.cumsum([0, *map(len, starts)]),
        np.vstack(starts),
        np.array(outer),
        np.array(inner),
    ), np.array(middles)


def _about_O(places: Array, middles: Array) -> Array:
    """Poses of O of walkers whose middles, from O, have these poses."""
    c, s = np.cos(places[:, 2]), np.sin(places[:, 2])
    x, y = middles.T
    turned = np.column_stack([c * x - s * y, s * x + c * y])
    return np.column_stack([places[:, :2] - turned, places[:, 2]])


def _added(
    shapes: Outlines, bounds: Bounds, scales: Array, order: npt.NDArray[np.int64], rng: np.random.Generator
) -> tuple[Array, Cells] | None:
    """Places of middles, and cells, of walkers added one by one; None where one found no room."""
    cells = overlap.cells_of(shapes, bounds)
    places = np.zeros((len(order), 3))
    done, tries = 0, TRIES * len(order)
    while tries > 0:
        batch = min(tries, 100_000)
        randoms = rng.random((batch, 3))
        done = overlap.add(shapes, bounds, cells, places, scales, order, done, randoms)
        if done == len(order):
            return places, cells
        tries -= batch
    return None


def _grown(
    shapes: Outlines, bounds: Bounds, cells: Cells, places: Array, scales: Array, rng: np.random.Generator
) -> bool:
    """Move walkers and let them grow to their size; False where they find no room for it."""
    for number, pace in enumerate(PACES):
        if number > 0:
            scales *= LOOSENED
        if _paced(shapes, bounds, cells, places, scales, rng, pace):
            return True
    return False


def _paced(
    shapes: Outlines, bounds: Bounds, cells: Cells, places: Array, scales: Array, rng: np.random.Generator, pace: float
) -> bool:
    """Move walkers and let them grow at a pace, until all have their size or no room for it."""
    n, largest = len(places), float(shapes.outer.max())
    steps, smallest = np.array([0.3 * largest, 0.5]), float(scales.min())
    least, most_steps = np.array([1e-4 * largest, 1e-4]), np.array([largest, math.pi])
    for number in range(max(MOST_MOVES // n, STALLED)):
        most, randoms = min(1.0, TOGETHER * float(scales.min())), rng.random((n, 4))
        moved = overlap.sweep(shapes, bounds, cells, places, scales, randoms, steps, pace, most)
        if scales.min() == 1.0:
            return True
        steps = np.clip(steps * (1.1 if moved > 0.4 * n else 0.9), least, most_steps)
        if number % STALLED == STALLED - 1:
            if float(scales.min()) < smallest * (1.0 + LEAST_GROWTH * pace):
                return False
            smallest = float(scales.min())
    return False


def _refuse_too_large(shapes: Outlines, dish: Dish) -> None:
    """Raise InputError for a dish in which the largest walker has no room alone."""
    across = 2.0 * float(shapes.outer.max())
    room = min(dish.box)
    alone = across > dish.sizes[0] if dish.kind == "disc" else across > dish.period > 0.0
    if alone:
        raise InputError(
            f"crowd.arena_mm = {dish.words!r}: a walker is {across:.4g} mm across with its "
            f"clearance, the dish {room:g} mm: give a larger dish"
        )


def _too_dense(count: int, packing: float, reached: float | None) -> InputError:
    """Error of a crowd that has no room."""
    number = "one walker finds" if count == 1 else f"{count} walkers find"
    dense = "" if reached is None else f" beyond {reached:.2f} at most"
    return InputError(
        f"crowd.packing = {packing:.2f}: {number} no room{dense} in this dish; give fewer "
        "(‹count›, ‹packing›), or a larger dish (‹arena›)"
    )
