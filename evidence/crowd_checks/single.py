"""Single check: walkers alone in a plane, measured as the card was, have the card's numbers."""

import math

import numpy as np

from evidence.crowd_checks import runs, setting
from evidence.crowd_checks.setting import RATE_HZ, Size
from walkergen.analysis import tracks
from walkergen.analysis.values import Value
from walkergen.crowd.card import Card
from walkergen.crowd.cards import walker_card, walker_motion
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.dish import Dish
from walkergen.files.progress import Progress
from walkergen.numerics.quantity import Quantity
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

SIDE = 8
"""Walkers along a side of the plane: so many squared, alone."""

FORGOTTEN_S = 1.0
"""Start of a run that is left out, s."""

UNITS = {
    "speed": "mm/s",
    "turning": "rad/s",
    "D_R": "rad^2/s",
    "D_T": "mm^2/s",
    "velocity relaxes within": "s",
    "turning relaxes within": "s",
    "delay": "s",
}
"""Units of the numbers of a walker alone."""


def in_space(size: Size, design: Design, mass: MassProperties, progress: Progress) -> tuple[Card, Measured]:
    """Card of the walker, and the motion that it is from."""
    scene = setting.scene(size, size.alone_seconds, FORGOTTEN_S, size.alone_runs)
    measured = walker_motion.simulated(scene, design, mass, progress)
    return walker_card.of(scene, design, mass, measured), measured


def in_plane(size: Size, card: Card) -> Measured:
    """Motion of walkers of a card in a plane, so far apart that none meets another."""
    seconds = FORGOTTEN_S + size.alone_seconds
    apart = 4.0 * (card.length_mm + abs(card.speed_mm_s.value) * seconds)
    line = (np.arange(SIDE) - 0.5 * (SIDE - 1)) * apart
    x, y = np.meshgrid(line, line)
    rng = np.random.default_rng(np.random.SeedSequence(size.seed, spawn_key=(3,)))
    start = np.column_stack((x.ravel(), y.ravel(), rng.uniform(-math.pi, math.pi, SIDE**2)))
    (run,) = runs.in_plane(card, Dish("periodic", (SIDE * apart,)), [start], seconds, RATE_HZ, size.seed)
    kept = run.poses[run.times >= FORGOTTEN_S - 1e-9]
    own = tracks.of_places([kept[:, i] for i in range(SIDE**2)], 1.0 / RATE_HZ, lane=False)
    return walker_motion.of_tracks(own, True, ())


def numbers(measured: Measured) -> dict[str, Value]:
    """Numbers that are known, by the keys of UNITS."""
    known = measured.motion.estimates
    estimates = (
        known["speed"],
        known["turning_bias"],
        known["rotational_diffusion"],
        measured.translation,
        measured.velocity.time,
        measured.turning.time,
        measured.delay.mean,
    )
    values = {name: _value(one) for name, one in zip(UNITS, estimates, strict=True)}
    return {name: value for name, value in values.items() if value is not None}


def _value(estimate: Quantity) -> Value | None:
    if estimate.value is None or estimate.se is None:
        return None
    return Value(float(estimate.value), float(estimate.se))
