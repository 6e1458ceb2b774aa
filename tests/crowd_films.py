"""Films of made-up crowds, whose statistics are known in closed form."""

import numpy as np

from walkergen.core import dish as dishes
from walkergen.guests.crowd.statistics import dish_geometry, film

DISHES = ("disc:120", "ring:160,60", "rectangle:200x100", "periodic:150")

BOX = np.array([(-1.5, -0.5), (1.5, -0.5), (1.5, 0.5), (-1.5, 0.5)])
"""Outline of a body of 3 x 1 mm."""


def make_film(places, dish, outline=BOX, interval=0.1):
    """Film of places of shape (F, N, 3), of one kind of body or, with None, of no known outline."""
    times = interval * np.arange(len(places))
    outlines = {} if outline is None else {"walker": (outline,)}
    kinds = ["walker"] * np.shape(places)[1]
    return film.from_positions(times, np.asarray(places, float), kinds, outlines, dishes.parse_dish(dish))


def gas(dish, walkers, frames, seed, outline=BOX):
    """Return walkers with random places and headings in every frame."""
    rng, own = np.random.default_rng(seed), dishes.parse_dish(dish)
    places = rng.uniform(-0.5, 0.5, (8 * frames * walkers, 2)) * own.box
    inside = ~(dish_geometry.wall_distance(*places.T, own) < 0)
    places = places[inside][: frames * walkers].reshape(frames, walkers, 2)
    theta = rng.uniform(-np.pi, np.pi, (frames, walkers, 1))
    return make_film(np.concatenate([places, theta], axis=2), dish, outline)
