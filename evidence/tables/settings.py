"""Settings of the rows: walkers on shaken plates as people write them, each key at its default or in a range.

Every row has a liveliness of its own: the share of its keys that leave their defaults. So the rows are
dense about the walker that people meet first, and reach the ends of all ranges together. Ends of ranges
are settings too: what lies beyond one is put there.
"""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import GeometryError, InputError
from walkergen.core.scene import Arena, Contact, Drive, Feet, LegModel, Plate, Run, Scene
from walkergen.core.walker.body import Body
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Kind, Legs
from walkergen.core.walker.spec import Material

Array = npt.NDArray[np.float64]

Row = dict[str, float | None]
"""Numbers of a row by the names of `KEYS`; None where a lane's walls, or a key of its own, are not there."""


class Key(NamedTuple):
    """Key of a row: its default, its range, and how often a lively row leaves the default."""

    default: float | None
    low: float
    high: float
    log: bool = False
    often: float = 1.0

    def value_at(self, share: float) -> float:
        """Value at a share of its range, from 0 to 1."""
        if self.log:
            return math.exp(math.log(self.low) + share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)


KEYS = {
    "tilt_deg": Key(None, 0.0, 60.0),
    "braced": Key(0.0, 1.0, 1.0, often=0.05),
    "restitution": Key(0.8, 0.02, 1.0),
    "friction": Key(0.25, 0.02, 1.2, log=True),
    "tip_radius_um": Key(5.0, 1.0, 200.0, log=True),
    "gamma": Key(1.8, 0.8, 4.0),
    "frequency_hz": Key(90.0, 20.0, 250.0, log=True),
    "size": Key(1.0, 0.3, 4.0, log=True, often=0.4),
    "thickness_mm": Key(0.4, 0.25, 0.8, log=True),
    "modulus_gpa": Key(3.0, 1.4, 4.0, log=True, often=0.5),
    "density_g_cm3": Key(1.24, 0.9, 1.5, often=0.4),
    "damping_ratio": Key(0.05, 0.005, 0.3, log=True, often=0.3),
    "length_mm": Key(7.5, 5.0, 10.0),
    "spacing_mm": Key(13.0, 9.0, 17.0),
    "width_share": Key(None, 0.4, 1.0, often=0.25),
    "unevenness_um": Key(0.0, 0.0, 20.0),
    "body_length_mm": Key(28.0, 22.0, 36.0, often=0.7),
    "body_thickness_mm": Key(3.0, 2.0, 5.0, often=0.7),
    "depth_mm": Key(8.0, 5.0, 12.0, often=0.7),
    "play_mm": Key(0.5, 0.05, 4.0, log=True),
    "wall_friction": Key(0.25, 0.0, 0.8, often=0.5),
    "wall_restitution": Key(0.5, 0.02, 1.0, often=0.4),
    "harmonic_ratio": Key(0.0, 0.0, 0.4, often=0.3),
    "harmonic_phase_deg": Key(0.0, -180.0, 180.0),
    "slope_deg": Key(0.0, -5.0, 5.0, often=0.15),
    "noise_ratio": Key(0.0, 0.0, 0.5, often=0.15),
}
"""Keys of a row, as people write them but for `braced`, `width_share` (of a leg, over the body's depth) and
`play_mm` (of a lane over the body's depth); all lengths of a walker are times its `size`."""

PLANE_SHARE = 0.35
"""Share of the rows on an open plane."""

OVERSHOOT = 0.08
"""Share of a range that draws reach beyond either end; such draws are clipped to the end."""

MEDIAN_TILT_DEG = 16.0
"""Tilt below which half of the tilts lie: speeds change most there."""

LENGTH_KEYS = (
    *("thickness_mm", "length_mm", "spacing_mm", "body_length_mm", "body_thickness_mm", "depth_mm", "play_mm"),
)
"""Keys of a walker's and its lane's lengths."""

ROWS, TESTS = 11_000, 700
"""Proportion of rows to learn from and of held-out ones."""

SEED = 57

TRAINING_RUN = Run(seconds=1.5, discard_seconds=0.3, runs=6)
"""Runs of a row: 7.2 s of measured walk. Many rows with noise tell more than few without."""

HELD_OUT_RUN = Run(seconds=3.5, discard_seconds=0.5, runs=12)
"""Runs of a held-out row."""


GOAL_SHARE, GOAL_MM_S = 0.10, 1.0
"""Goal: 95 % of the surrogate's answers are off by at most a share of the speed, or by a speed if that is more."""


def goal_error(speed: Array) -> Array:
    """Return the goal for the error of answers of these speeds, mm/s, of the same shape."""
    return np.maximum(GOAL_SHARE * np.abs(speed), GOAL_MM_S)


class Case(NamedTuple):
    """Walker and scene of a row."""

    scene: Scene
    design: Design


def draw_settings(count: int, seed: int, held_out: bool, braced: bool = False) -> Iterator[Row]:
    """Yield about `count` settings that can be built; a larger count begins with the same ones.

    With `braced` all have braced legs.
    """
    for number in range(count):
        row = _draw_row(np.random.default_rng([seed, number]))
        row["held_out"] = float(held_out)
        row["braced"] = 1.0 if braced else row["braced"]
        try:
            make_case(row)
        except (GeometryError, InputError):
            continue
        yield row


def _draw_row(rng: np.random.Generator) -> Row:
    lively = rng.uniform(0.1, 1.0)
    row: Row = {}
    for name, key in KEYS.items():
        share = min(max(rng.uniform(-OVERSHOOT, 1.0 + OVERSHOOT), 0.0), 1.0)
        chance, leaves = key.often * lively, rng.uniform()
        row[name] = key.value_at(share) if leaves < chance else key.default
        if name == "tilt_deg":
            row[name] = key.value_at(share ** (math.log(MEDIAN_TILT_DEG / key.high) / math.log(0.5)))
    if rng.uniform() < PLANE_SHARE:
        row |= dict.fromkeys(("play_mm", "wall_friction", "wall_restitution"))
    if not row["harmonic_ratio"]:
        row["harmonic_phase_deg"] = 0.0
    return {name: None if value is None else float(f"{value:.4g}") for name, value in row.items()}


def make_case(row: Mapping[str, float | None]) -> Case:
    """Walker and scene of a row. Raises GeometryError for one that cannot be built."""
    number = {key: value or 0.0 for key, value in row.items()}
    number |= {key: number["size"] * number[key] for key in LENGTH_KEYS}
    kind: Kind = "braced" if number["braced"] else "flexible"
    width = row["width_share"]
    body = Body(
        length_mm=number["body_length_mm"], thickness_mm=number["body_thickness_mm"], depth_mm=number["depth_mm"]
    )
    legs = Legs(
        kind=kind,
        tilt_deg=number["tilt_deg"],
        length_mm=number["length_mm"],
        contact_spacing_mm=number["spacing_mm"],
        width_mm=None if width is None else width * number["depth_mm"],
        flexible_thickness_mm=number["thickness_mm"],
    )
    material = Material(density_g_cm3=number["density_g_cm3"], youngs_modulus_gpa=number["modulus_gpa"])
    drive = Drive(
        frequency_hz=number["frequency_hz"],
        gamma=number["gamma"],
        second_harmonic_ratio=number["harmonic_ratio"],
        second_harmonic_phase_deg=number["harmonic_phase_deg"],
    )
    walls = Arena(kind="plane")
    if row["play_mm"] is not None:
        walls = Arena(
            gap_mm=number["depth_mm"] + number["play_mm"],
            wall_friction=number["wall_friction"],
            wall_restitution=number["wall_restitution"],
        )
    scene = Scene(
        drive=drive,
        contact=Contact(restitution=number["restitution"], friction=number["friction"]),
        plate=Plate(slope_deg=number["slope_deg"], noise_ratio=number["noise_ratio"]),
        arena=walls,
        legs=LegModel(damping_ratio=number["damping_ratio"]),
        feet=Feet(unevenness_um=number["unevenness_um"], tip_radius_um=number["tip_radius_um"]),
        run=HELD_OUT_RUN if number["held_out"] else TRAINING_RUN,
    )
    return Case(scene, Design(body=body, legs=legs, material=material))
