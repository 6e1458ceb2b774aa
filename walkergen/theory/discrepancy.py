"""Speed of the model in space, from a table: what a simulation would give, in microseconds.

`make calibrate-models` simulates some ten thousand walkers (walkergen/jobs/discrepancies) and fits
small networks to their speeds, and smooth functions to the scatter between prints and to the error
of the fit; here they are evaluated, and refused outside the range of the table.
"""

import hashlib
import json
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import Drive
from walkergen.errors import WalkergenError
from walkergen.numerics import network
from walkergen.scene import LEAST_LABEL, Plate, Scene
from walkergen.theory import shaking
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

TABLE = Path(__file__).with_suffix(".npz")

LINEAR_BELOW = 0.25
"""Speed over the plate's peak speed below which the table's transform, asinh, is about linear:
slow walkers scatter by an amount, fast ones by a share."""

FAR_OFF = 2.5
"""Logarithm of tan(tilt) over friction beyond which feet stick, or slide, as they do at it."""

SLIGHT_DEG = 1.0
"""Tilt at which speeds of small tilts, which are in proportion to it, begin to level off."""

MOST_SLOPE_DEG = 5.0

COVERED = frozenset(
    {
        "name",
        "description",
        "drive",
        "contact",
        "prediction",
        "arena",
        "legs",
        "run",
        "effects",
        "plate.slope_deg",
        "plate.noise_ratio",
        "plate.noise_low_hz",
        "plate.noise_high_hz",
        "plate.roughness_length_mm",
        "feet.unevenness_um",
        "feet.unevenness_sd_um",
    }
)
"""Tables and keys of a scene that the table covers, each in a range of its own; of any other key
it covers the default."""

EDGE = 0.02
"""Share of a number's range by which a walker may lie outside it: samples leave out the ends."""


class Place(NamedTuple):
    """Dimensionless numbers on which a simulated speed over the plate's peak speed depends.

    A walker of the other tilt on the other slope is the mirror image: it has the same place.
    """

    root_tilt: float | Array
    """Square root of the magnitude of the tilt in degrees."""
    restitution: float | Array
    log_friction: float | Array
    gamma: float | Array
    log_hinge_ratio: float | Array
    """Logarithm of the frequency of a leg on its hinge over the drive's."""
    length_ratio: float | Array
    """Length of a leg over the distance of the feet."""
    log_mass_ratio: float | Array
    """Logarithm of a leg's mass over the body's."""
    log_gyration_ratio: float | Array
    """Logarithm of the body's radius of gyration over the distance of the feet."""
    unevenness_ratio: float | Array
    """Unevenness of the feet over the plate's amplitude."""
    log_foot_ratio: float | Array
    """Logarithm of the frequency of the body on a leg's axial stiffness over the drive's."""
    log_amplitude_ratio: float | Array
    """Logarithm of the plate's amplitude over the distance of the feet."""
    log_width_ratio: float | Array
    """Logarithm of the width of a foot over the distance of the feet."""
    slope_ratio: float | Array
    """tan(slope) over friction, positive where the slope helps a walker of this tilt along."""
    harmonic_cos: float | Array
    """Ratio of the second harmonic times the cosine of its phase."""
    harmonic_sin: float | Array
    noise_ratio: float | Array
    """Root mean square of the plate's random speed over the drive's peak speed."""

    def drawn(
        self,
        restitution: Array,
        friction: Array,
        thickness: Array,
        modulus: Array,
        body_mass: Array,
        leg_mass: Array,
        unevenness: Array,
    ) -> "Place":
        """Places of draws of a walker: restitution, friction and unevenness (over the plate's
        amplitude) as they are, the others over those of this place; each of shape (n,).
        """
        safe = np.maximum(friction, 1e-9)
        return self._replace(
            restitution=restitution,
            log_friction=np.log(safe),
            log_hinge_ratio=self.log_hinge_ratio + np.log(thickness * np.sqrt(modulus * thickness / leg_mass)),
            log_mass_ratio=self.log_mass_ratio + np.log(leg_mass / body_mass),
            log_foot_ratio=self.log_foot_ratio + 0.5 * np.log(thickness * modulus / body_mass),
            slope_ratio=self.slope_ratio * math.exp(float(self.log_friction)) / safe,
            unevenness_ratio=unevenness,
        )

    def driven(self, pace: Array, moment: Array) -> "Place":
        """Places at frequencies and moments of a motor over those of this place, shape (n,)."""
        return self._replace(
            gamma=self.gamma * moment * pace**2,
            log_hinge_ratio=self.log_hinge_ratio - np.log(pace),
            log_foot_ratio=self.log_foot_ratio - np.log(pace),
            log_amplitude_ratio=self.log_amplitude_ratio + np.log(moment),
        )


class UnknownError(WalkergenError):
    """The speed in space is unknown here; the text says which number lies outside the table."""


class Found(NamedTuple):
    """Speeds in space over the plate's peak speed: normal after asinh; arrays of shape (n,)."""

    centre: Array
    sd: Array
    """Standard deviation after asinh: from print to print, and by the interpolation."""
    between_prints: Array
    """Part of it by which prints of one walker differ, as their feet are uneven."""

    def at(self, deviation: Array) -> Array:
        """Speeds over the plate's peak speed, so many standard deviations from the middle."""
        return np.asarray(LINEAR_BELOW * np.sinh(self.centre + self.sd * deviation))


def transformed(speed: Array, se: Array) -> tuple[Array, Array]:
    """Speeds over the plate's peak speed and their standard errors, after asinh."""
    return np.arcsinh(speed / LINEAR_BELOW), se / np.hypot(speed, LINEAR_BELOW)


def coordinates(places: Array) -> tuple[Array, Array]:
    """Inputs of the networks, shape (n, 18), and the odd factors of their outputs, shape (n, 2).

    Speeds change most where the tilt passes the angle of friction, where feet stick. What turns
    about with the walker and its plate, tilt and slope, comes into the inputs by products that
    stay: so a walker without tilt on a level plate has no speed, and the mirror image the other.
    """
    root, slope = places[:, 0], places[:, 12]
    tilt = root**2
    odd = tilt / (tilt + SLIGHT_DEG)
    against = np.log(np.tan(np.radians(np.maximum(tilt, 1e-3)))) - places[:, 2]
    inputs = places.copy()
    inputs[:, 12] = odd * slope
    more = np.clip(against, -FAR_OFF, FAR_OFF), slope**2
    return np.column_stack([inputs, *more]), np.column_stack([odd, slope])


def place_of(scene: Scene, design: Design, mass: MassProperties) -> Place:
    """Place of a walker in the table. Braced legs have neither hinges nor masses of their own.

    Raises UnknownError for other legs than two equal ones.
    """
    if not design.alike:
        raise UnknownError("speeds in space are known for two equal legs only, not for [[legs]]")
    return numbers(scene, design, mass, shaking.of(scene, design, mass).drive)


def numbers(scene: Scene, design: Design, mass: MassProperties, drive: Drive) -> Place:
    """Numbers of a walker, all of whose legs are alike, on a plate of this drive."""
    limb, leg, span = design.limbs[0], mass.legs[0], design.foot_span
    hinge = mass_ratio = 1.0
    modulus = 1e9 * design.material.youngs_modulus_gpa
    if not mass.rigid:
        spring = modulus * limb.width * limb.thickness**3 / (4.0 * limb.length)
        turning = float(leg.j) + float(leg.m) * float(leg.c_A @ leg.c_A)
        hinge = math.sqrt(spring / turning) / drive.omega
        mass_ratio = float(leg.m) / float(mass.M)
    axial = modulus * limb.width * limb.thickness / limb.length
    friction = max(scene.contact.friction, 1e-9)
    phase = math.radians(drive.second_harmonic_phase_deg)
    along = math.copysign(1.0, design.tilt_deg)
    return Place(
        math.sqrt(abs(design.tilt_deg)),
        max(scene.contact.restitution, LEAST_LABEL),
        math.log(friction),
        drive.peak_gamma,
        math.log(hinge),
        limb.length / span,
        math.log(mass_ratio),
        0.5 * math.log(float(mass.J) / float(mass.M) / span**2),
        1e-3 * scene.feet.unevenness_um / drive.amplitude,
        0.5 * math.log(axial / float(mass.M)) - math.log(drive.omega),
        math.log(drive.amplitude / span),
        math.log(limb.width / span),
        along * math.tan(math.radians(scene.plate.slope_deg)) / friction,
        drive.second_harmonic_ratio * math.cos(phase),
        drive.second_harmonic_ratio * math.sin(phase),
        scene.plate.noise_ratio,
    )


def check(scene: Scene, place: Place, braced: bool) -> None:
    """Refuse walkers and scenes that the table does not cover. Raises UnknownError."""
    plate = scene.plate
    band = (plate.noise_low_hz, plate.noise_high_hz) == (Plate().noise_low_hz, Plate().noise_high_hz)
    for reason, covered in (
        (f"slopes beyond {MOST_SLOPE_DEG:g} deg", abs(plate.slope_deg) <= MOST_SLOPE_DEG),
        ("plate noise in another band than the usual", band or plate.noise_ratio == 0.0),
        *((key, False) for key in beyond(scene)),
    ):
        if not covered:
            raise UnknownError(f"speeds in space are not known for {reason}")
    ranges = _facts()["ranges"]["braced" if braced else "flexible"]
    for name in Place._fields:
        low, high = ranges[name]
        value, margin = getattr(place, name), EDGE * (high - low)
        if not low - margin <= value <= high + margin:
            reason, seen, ends = in_words(name, value, low, high)
            raise UnknownError(f"speeds in space are known for {reason} in {ends}, not at {seen}")


def beyond(scene: Scene) -> list[str]:
    """Keys and values of a scene, as people write them, that the table does not cover."""
    return [
        f"{name}.{key} = {getattr(table, key)}"
        for name in type(scene).model_fields
        if name not in COVERED and (table := getattr(scene, name)) != type(table)()
        for key, field in type(table).model_fields.items()
        if f"{name}.{key}" not in COVERED and getattr(table, key) != field.default
    ]


def in_words(name: str, value: float, low: float, high: float) -> tuple[str, str, str]:
    """Name, value and range of a number as people write them."""
    words = name.removeprefix("log_").removeprefix("root_").replace("_", " ")
    if name == "root_tilt":
        value, low, high = value**2, low**2, high**2
    elif name.startswith("log_"):
        value, low, high = math.exp(value), math.exp(low), math.exp(high)
    return words, f"{value:.3g}", f"{low:.2g}..{high:.2g}"


def speeds(place: Place, tilt_deg: float, braced: bool) -> Found:
    """Speeds in space at places, numbers or arrays of shape (n,).

    Numbers outside the table's range are taken at its end (see `check`). Tilts of the other sign
    run the other way.
    """
    kind = "braced" if braced else "flexible"
    places = np.empty((np.broadcast(*place).size, len(place)))
    for column, number in enumerate(place):
        places[:, column] = number
    low, high = _ends(kind)
    logs = fitted(_arrays(), kind, np.minimum(np.maximum(places, low), high))
    return logs._replace(centre=math.copysign(1.0, tilt_deg) * logs.centre)


def fitted(arrays: dict[str, Any], kind: str, places: Array) -> Found:
    """Speeds at places, shape (n, 16), all within the ranges, by the arrays of a table."""
    inputs, odd = coordinates(places)
    inputs = (inputs - arrays[f"{kind}_middle"]) / arrays[f"{kind}_scale"]
    layers = network.layers_of(arrays, kind)
    centre = (network.evaluated(layers, inputs).mean(axis=0) * odd).sum(axis=1)
    features = network.features(inputs)
    error = network.smooth(features, arrays[f"{kind}_error"])
    prints = places[:, 8] * network.smooth(features, arrays[f"{kind}_prints"])
    return Found(centre, np.hypot(error, prints), prints)


@cache
def _arrays() -> dict[str, Any]:
    """Arrays of the stored table."""
    with np.load(TABLE) as stored:
        return {name: stored[name] for name in stored.files}


@cache
def _facts() -> dict[str, Any]:
    """What the stored table says of itself: ranges of places by kind of legs, and errors."""
    facts: dict[str, Any] = json.loads(str(_arrays()["facts"]))
    return facts


@cache
def _ends(kind: str) -> tuple[Array, Array]:
    """Ends of the table's ranges, each of shape (16,)."""
    low, high = np.array([_facts()["ranges"][kind][name] for name in Place._fields]).T
    return low, high


def digest() -> str:
    """Hash of the table, 16 hexadecimal digits: bounds of two families with equal ones compare."""
    return hashlib.sha256(TABLE.read_bytes()).hexdigest()[:16]
