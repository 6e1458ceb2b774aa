"""Pairs of walkers that meet once, in LAMMPS and by the closed form of a rigid impact."""

import math
from typing import NamedTuple

import numpy as np
from flat_cards import BOX, silent
from shapely import Polygon, affinity
from shapely.ops import nearest_points

from walkergen.core.dish import Dish
from walkergen.core.theory.impact import impact
from walkergen.guests.crowd.flat import crowd, crowd_checks

ROOM = 90.0
"""Ground of a pair, mm."""


def gliding_card(angle, **keys):
    """Card that glides without drag or noise, its outline turned against the heading."""
    outline = affinity.rotate(Polygon(BOX), angle, origin=(0, 0), use_radians=True).exterior.coords
    return silent(outline_mm=[np.round(outline[:-1], 9).tolist()], velocity_relaxation_s=1e6, **keys)


class Hit(NamedTuple):
    """One impact at the contact point: x along the surface, y the approach."""

    before: tuple[float, float]
    """Relative velocity there, mm/s."""
    H: tuple[float, float, float]
    """H_xx, H_xy, H_yy, 1/g."""
    impulse: tuple[float, float]
    """In LAMMPS, g mm/s."""
    law: tuple[float, float]
    """By the closed form, g mm/s."""
    energy: tuple[float, float]
    """Taken by the contact over that of the approach: LAMMPS, closed form."""
    restitution: float
    """- v_y after / v_y before, in LAMMPS."""
    balance: tuple[float, float]
    """Momentum and angular momentum that came from nowhere, over those exchanged."""


def collide(number, restitution, friction, seed, speed=100.0):
    """Hits of so many random pairs: any side on any side, each from any direction."""
    generator = np.random.default_rng(seed)
    offsets = np.arange(6) * math.pi / 6
    keys = {"restitution": restitution, "friction": friction}
    cards = [gliding_card(angle, speed_mm_s=speed, **keys) for angle in offsets]
    cards.append(gliding_card(0.0, speed_mm_s=0.0, **keys))
    pairs = [_pair(generator, offsets) for _ in range(number)]
    side = math.ceil(math.sqrt(number))
    middle = [((n % side - 0.5 * side + 0.5) * ROOM, (n // side - 0.5 * side + 0.5) * ROOM) for n in range(number)]
    kinds, places = [], []
    for (kind, mover, rester), (x, y) in zip(pairs, middle, strict=True):
        kinds += [kind, len(offsets)]
        places += [mover + np.array([x, y, 0.0]), rester + np.array([x, y, 0.0])]
    dish = Dish("rectangle", (side * ROOM + 40.0,) * 2)
    run = crowd.simulate(
        crowd_checks.make_crowd(cards, kinds, dish, places, seconds=0.06, rate_hz=2000.0, seed=seed, running=True)
    )
    hits = []
    for n, (kind, mover, rester) in enumerate(pairs):
        two = run.poses[:, 2 * n : 2 * n + 2] - (*middle[n], 0.0)
        hit = _hit(two, mover, rester, offsets[kind], speed, cards[0])
        if hit is not None:
            hits.append(hit)
    return hits


def _pair(generator, offsets):
    """Kind and start of one that moves, and of the other, which rests; 1 mm apart."""
    kind = int(generator.integers(len(offsets)))
    heading, rest = generator.uniform(-math.pi, math.pi, 2)
    resting = shape(np.array([0.0, 0.0, rest]))
    ahead = np.array([math.cos(heading), math.sin(heading)])
    aside = generator.uniform(-12.0, 12.0) * np.array([-ahead[1], ahead[0]])
    far, near = 35.0, 0.0
    for _ in range(60):
        middle = 0.5 * (far + near)
        moved = shape(np.array([*(aside - middle * ahead), heading + offsets[kind]]))
        far, near = (middle, near) if moved.distance(resting) > 1.0 else (far, middle)
    return kind, np.array([*(aside - far * ahead), heading]), np.array([0.0, 0.0, rest])


def shape(pose):
    """Outline at a pose."""
    turned = affinity.rotate(Polygon(BOX), pose[2], origin=(0, 0), use_radians=True)
    return affinity.translate(turned, pose[0], pose[1])


def _hit(two, mover, rester, offset, speed, kind):
    """The first impact of a pair, None for one that misses or meets a second time."""
    rates = np.diff(two, axis=0) * 2000.0
    changed = np.flatnonzero(np.abs(rates - rates[0]).max(axis=(1, 2)) > 1e-3)
    if not changed.size or changed[0] + 12 > len(rates) - 1:
        return None
    start, end = int(changed[0]), int(changed[0]) + 6
    if np.abs(rates[end] - rates[end + 5]).max() > 1e-3:  # still in touch, or again
        return None
    ahead = np.array([math.cos(mover[2]), math.sin(mover[2])])
    near, far = 0.0, 1.6
    for _ in range(60):
        middle = 0.5 * (near + far)
        moved = np.array([*(mover[:2] + middle * ahead), mover[2] + offset])
        near, far = (middle, far) if shape(moved).distance(shape(rester)) > 1e-6 else (near, middle)
    moved = np.array([*(mover[:2] + near * ahead), mover[2] + offset])
    ours, theirs = (np.array(one.coords[0]) for one in nearest_points(shape(moved), shape(rester)))
    normal = (ours - theirs) / np.linalg.norm(ours - theirs)
    along = np.array([normal[1], -normal[0]])
    m, inertia = kind.mass_g, kind.inertia_g_mm2
    arms = [ours - moved[:2], theirs - rester[:2]]
    cross = [(r[0] * normal[1] - r[1] * normal[0], r[0] * along[1] - r[1] * along[0]) for r in arms]
    H_yy = sum(1.0 / m + n**2 / inertia for n, _ in cross)
    H_xx = sum(1.0 / m + t**2 / inertia for _, t in cross)
    H_xy = sum(n * t / inertia for n, t in cross)
    v_x, v_y = speed * float(ahead @ along), speed * float(ahead @ normal)
    law = impact(H_xx, H_xy, H_yy, v_x, v_y, kind.restitution, kind.friction)
    gained = rates[end] - rates[start - 1]
    push = m * gained[0, :2]
    F_x, F_y = float(push @ along), float(push @ normal)
    after = v_y + H_xy * F_x + H_yy * F_y
    whole = m * gained[:, :2].sum(axis=0)
    places = two[start - 1, :, :2]
    spin = inertia * gained[:, 2].sum() + m * sum(
        p[0] * g[1] - p[1] * g[0] for p, g in zip(places, gained[:, :2], strict=True)
    )
    size = float(np.hypot(*push))
    taken = [
        -x * (v_x + 0.5 * (H_xx * x + H_xy * y)) - y * (v_y + 0.5 * (H_xy * x + H_yy * y))
        for x, y in ((F_x, F_y), (law.F_x, law.F_y))
    ]
    scale = 0.5 * v_y**2 / H_yy + 0.5 * v_x**2 / H_xx
    return Hit(
        (v_x, v_y),
        (H_xx, H_xy, H_yy),
        (F_x, F_y),
        (law.F_x, law.F_y),
        (taken[0] / scale, taken[1] / scale),
        -after / v_y,
        (float(np.hypot(*whole)) / size, abs(float(spin)) / (size * 14.0)),
    )
