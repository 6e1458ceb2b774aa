"""Speed of walkers that carry a motor, from a table of the model in space (docs/physics.md section
8).

As `discrepancy` for shaken plates: `make calibrate-models` simulates walkers with coin motors and
fits a process to their speeds over that of the swing, S Omega/M; here it is evaluated, and refused
outside the range of the table.
"""

import hashlib
import json
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import AXES
from walkergen.numerics import network, odd_process
from walkergen.scene import Scene
from walkergen.theory import discrepancy, shaking
from walkergen.theory.discrepancy import EDGE, FAR_OFF, Found, Place, UnknownError
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, from_centre

Array = npt.NDArray[np.float64]

TABLE = Path(__file__).with_suffix(".npz")

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

NAMES = (*Place._fields[:12], *Ride._fields)
"""Names of the numbers on which a speed depends: no slope, harmonic or noise of a plate."""


class Ridden(NamedTuple):
    """Walker with its motor in the table."""

    place: Place
    """Its numbers as on a plate that swings as far, whatever way."""
    ride: Ride
    swing: float
    """Peak speed of the swing, mm/s."""
    amplitude: float
    """Radius of the swing, mm."""


def of(scene: Scene, design: Design, mass: MassProperties) -> Ridden:
    """Place of a walker with a motor in the table.

    Raises UnknownError for one that the table does not cover.
    """
    for reason, covered in _conditions(scene, design):
        if not covered:
            raise UnknownError(f"{KNOWN} {reason}")
    ridden = placed(scene, design, mass)
    _check(ridden)
    return ridden


def placed(scene: Scene, design: Design, mass: MassProperties) -> Ridden:
    """Place of a walker with a motor, whether the table covers it or not; its legs are alike."""
    whole = scene.drive.beneath(float(mass.total))
    place = discrepancy.numbers(scene, design, mass, whole)
    return Ridden(place, _ride(scene, design, mass), whole.peak_speed, whole.amplitude)


def _conditions(scene: Scene, design: Design) -> list[tuple[str, bool]]:
    """What the table covers, in words, and whether a walker and its scene are so."""
    limbs, axis = design.limbs, scene.drive.direction(shaking.motor_of(design).axis)
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
        ("flexible legs", not any(limb.braced for limb in limbs)),
        ("legs that are alike left and right", design.symmetric),
        ("an axis along, across or up", named),
        ("level plates", scene.plate.slope_deg == 0.0),
        ("still plates", scene.plate.noise_ratio == 0.0),
        *((f"no {key}", False) for key in beyond),
    ]


def _ride(scene: Scene, design: Design, mass: MassProperties) -> Ride:
    """Numbers of a walker and its motor beside those of its place."""
    limbs, span, motor = design.limbs, design.foot_span, shaking.motor_of(design)
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


def _check(ridden: Ridden) -> None:
    """Refuse numbers that lie outside the table. Raises UnknownError."""
    ranges = _facts()["ranges"]
    for name, value in zip(NAMES, values(ridden.place, ridden.ride)[0], strict=True):
        low, high = ranges[name]
        margin = EDGE * (high - low)
        if not low - margin <= value <= high + margin:
            reason, seen, ends = discrepancy.in_words(name, float(value), low, high)
            reason = "push over weight" if name == "gamma" else reason
            raise UnknownError(f"{KNOWN} {reason} in {ends}, not at {seen}")


def values(place: Place, ride: Ride) -> Array:
    """Numbers in the order of NAMES, shape (n, 24); those of the place may have shape (n,)."""
    numbers = (*place[:12], *ride)
    columns = np.empty((np.broadcast(*place[:12]).size, len(numbers)))
    for column, number in enumerate(numbers):
        columns[:, column] = number
    return columns


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


def speeds(place: Place, ride: Ride) -> Found:
    """Speeds over that of the swing at places, of numbers or arrays of shape (n,).

    Numbers outside the table's range are taken at its end.
    """
    low, high = _ends()
    return fitted(_arrays(), np.clip(values(place, ride), low, high))


def fitted(arrays: dict[str, Any], numbers: Array) -> Found:
    """Speeds at numbers in the order of NAMES, all within the ranges, by the arrays of a table."""
    inputs = scaled(arrays, numbers)
    centre, variance = odd_process.process_of(arrays)(inputs)
    features = network.features(even(inputs))
    prints = uneven(numbers) * network.smooth(features, arrays["prints"])
    error = float(arrays["widened"]) * np.sqrt(variance)
    return Found(centre, np.hypot(error, prints), prints)


def scaled(arrays: Mapping[str, Any], numbers: Array) -> Array:
    """Inputs at numbers, of about unit scatter."""
    return np.asarray((coordinates(numbers) - arrays["middle"]) / arrays["scale"])


def uneven(numbers: Array) -> Array:
    """What the scatter of prints is in proportion to, shape (n,)."""
    return np.asarray(np.sqrt(numbers[:, NAMES.index("unevenness_ratio")]))


@cache
def _arrays() -> dict[str, Any]:
    """Arrays of the stored table."""
    with np.load(TABLE) as stored:
        return {name: stored[name] for name in stored.files}


@cache
def _facts() -> dict[str, Any]:
    """What the stored table says of itself: ranges of the numbers, and errors."""
    facts: dict[str, Any] = json.loads(str(_arrays()["facts"]))
    return facts


@cache
def _ends() -> tuple[Array, Array]:
    """Ends of the table's ranges, each of shape (24,)."""
    low, high = np.array([_facts()["ranges"][name] for name in NAMES]).T
    return low, high


def digest() -> str:
    """Hash of the table, 16 hexadecimal digits."""
    return hashlib.sha256(TABLE.read_bytes()).hexdigest()[:16]
