"""Table of speeds in space of walkers that carry a motor (docs/physics.md section 8): a process.

Speeds are those over that of the swing, S Omega/M.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import AXES
from walkergen.numerics import odd_process
from walkergen.scene import Scene
from walkergen.theory import discrepancy
from walkergen.theory.surrogate import FAR_OFF, Place, Speeds, StoredTable, Tabled, UnknownError, features, smooth
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind
from walkergen.walker.mass import MassProperties, from_centre

Array = npt.NDArray[np.float64]

KNOWN = "speeds of walkers with a motor are known for"
"""Beginning of what an UnknownError says."""


class Ride(NamedTuple):
    """Dimensionless numbers of a walker and its motor beside those of `Place`.

    Lengths are over the distance of the feet, from the centre of mass.
    """

    lean: float
    """Sign of the tilt."""
    log_count: float
    """Logarithm of the number of legs."""
    log_breadth_ratio: float
    """Logarithm of the breadth of the feet, over all, across the run."""
    log_roll_ratio: float
    """Logarithm of the body's radius of gyration about the run."""
    fore_ratio: float
    """Place of the centre of mass ahead of the middle of the feet."""
    height_ratio: float
    """Height of the centre of mass over the feet."""
    axis_along: float
    """Components of the rotor's axis, of which one is 1 or -1."""
    axis_across: float
    axis_up: float
    lever_along: float
    """Place of the motor."""
    lever_up: float
    lever_across: float


SIGNED = frozenset(Ride._fields) - {"log_count", "log_breadth_ratio", "log_roll_ratio", "height_ratio", "lever_up"}
"""Names of numbers whose other sign belongs to a mirror image, which the table knows too."""

SHARED = 12
"""Number of those numbers of a place that a motor has: no slope, harmonic or noise of a plate."""

NAMES = (*Place._fields[:SHARED], *Ride._fields)
"""Names of the numbers on which a speed depends."""


def of(scene: Scene, design: Design, mass: MassProperties) -> Tabled:
    """Walker with a motor in the table. Raises UnknownError for one that it does not cover."""
    for reason, covered in _conditions(scene, design):
        if not covered:
            raise UnknownError(f"{KNOWN} {reason}")
    tabled = placed(scene, design, mass)
    TABLE.check(design.kind, (*tabled.place[:SHARED], *tabled.beside))
    return tabled


def placed(scene: Scene, design: Design, mass: MassProperties) -> Tabled:
    """Walker with a motor, whether the table covers it or not; its legs are alike.

    Its place is that on a plate that swings as far, whatever way.
    """
    whole = scene.drive.beneath(float(mass.total))
    place = discrepancy.numbers(scene, design, mass, whole)
    return Tabled(TABLE, design, scene, place, _ride(scene, design, mass), 1.0, whole.peak_speed, whole.amplitude)


def _conditions(scene: Scene, design: Design) -> list[tuple[str, bool]]:
    """What the table covers, in words, and whether a walker and its scene are so."""
    limbs, axis = design.limbs, scene.drive.direction(design.driving_motor().axis)
    first = limbs[0]
    alike = all(
        limb._replace(along=first.along, across=first.across, bottom=first.bottom) == first
        and limb.friction is None
        and limb.restitution is None
        for limb in limbs
    )
    named = any(np.allclose(np.abs(axis), np.abs(own), atol=1e-6) for own in AXES.values())
    beyond = discrepancy.beyond(scene)
    return [
        ("legs that are all alike", alike and len(limbs) > 1),
        ("flexible legs", all(limb.kind == "flexible" for limb in limbs)),
        ("legs that are alike left and right", design.symmetric),
        ("an axis along, across or up", named),
        ("level plates", scene.plate.slope_deg == 0.0),
        ("still plates", scene.plate.noise_ratio == 0.0),
        *((f"no {key}", False) for key in beyond),
    ]


def _ride(scene: Scene, design: Design, mass: MassProperties) -> Ride:
    """Numbers of a walker and its motor beside those of its place."""
    limbs, span, motor = design.limbs, design.foot_span, design.driving_motor()
    feet = np.mean([leg.foot for leg in mass.legs], axis=0)
    fore, height = (mass.centre - feet) / span
    place = from_centre(design, mass, np.array([motor.along_mm, motor.up_mm])) - mass.centre
    spatial = mass.spatial
    roll = float(mass.J) if spatial is None else float(spatial.body[0, 0])
    aside = motor.across_mm - (0.0 if spatial is None else spatial.z)
    breadth = 2.0 * max(abs(limb.across) + 0.5 * limb.width for limb in limbs)
    along, across, up = scene.drive.direction(motor.axis)
    return Ride(
        math.copysign(1.0, design.tilt_deg),
        math.log(len(limbs)),
        math.log(breadth / span),
        0.5 * math.log(roll / float(mass.M) / span**2),
        float(fore),
        float(height),
        along,
        across,
        up,
        float(place[0]) / span,
        float(place[1]) / span,
        aside / span,
    )


def coordinates(numbers: Array) -> Array:
    """Inputs of the process at numbers in the order of NAMES, shape (n, 27), those of ODD first.

    The mirror image from left to right has the same inputs: it runs alike.
    """
    of = dict(zip(NAMES, numbers.T, strict=True))
    tilt, aside = of["root_tilt"] ** 2, of["lever_across"]
    against = np.log(np.tan(np.radians(np.maximum(tilt, 1e-3)))) - of["log_friction"]
    return np.column_stack(
        [
            of["lean"] * of["root_tilt"],
            of["lean"] * tilt / (tilt + SLIGHT_DEG),
            of["fore_ratio"],
            of["lever_along"],
            of["axis_across"],
            of["axis_up"] * aside,
            of["axis_along"] * aside,
            of["axis_along"] ** 2,
            of["axis_up"] ** 2,
            np.abs(aside),
            of["lever_up"],
            np.clip(against, -FAR_OFF, FAR_OFF),
            np.log(of["gamma"]),
            np.sqrt(of["unevenness_ratio"]),
            *(of[name] for name in PLAIN),
        ]
    )


ODD = 6
"""Number of inputs that change their sign in the mirror image of a walker, which runs the other
way."""

PLAIN = (
    "restitution",
    "log_friction",
    "log_hinge_ratio",
    "length_ratio",
    "log_mass_ratio",
    "log_gyration_ratio",
    "log_foot_ratio",
    "log_amplitude_ratio",
    "log_width_ratio",
    "log_count",
    "log_breadth_ratio",
    "log_roll_ratio",
    "height_ratio",
)
"""Names of the numbers that are inputs as they are."""

SLIGHT_DEG = 4.0
"""Tilt at which speeds begin to level off."""


def even(inputs: Array) -> Array:
    """Inputs that are the same for the mirror image, of which errors are functions."""
    return np.column_stack([np.abs(inputs[:, :ODD]), inputs[:, ODD:]])


def fitted(arrays: Mapping[str, Any], kind: Kind, numbers: Array) -> Speeds:
    """Speeds at numbers in the order of NAMES, all within the ranges, by the arrays of a table."""
    inputs = scaled(arrays, numbers)
    centre, variance = odd_process.process_of(arrays)(inputs)
    terms = features(even(inputs))
    prints = uneven(numbers) * smooth(terms, arrays["prints"])
    error = float(arrays["widened"]) * np.sqrt(variance)
    return Speeds(centre, np.hypot(error, prints), prints)


def scaled(arrays: Mapping[str, Any], numbers: Array) -> Array:
    """Inputs at numbers, of about unit scatter."""
    return np.asarray((coordinates(numbers) - arrays["middle"]) / arrays["scale"])


def uneven(numbers: Array) -> Array:
    """What the scatter of prints is in proportion to, shape (n,)."""
    return np.asarray(np.sqrt(numbers[:, NAMES.index("unevenness_ratio")]))


TABLE = StoredTable(Path(__file__).with_suffix(".npz"), KNOWN, NAMES, fitted, {"gamma": "push over weight"})
