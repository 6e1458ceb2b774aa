"""Speeds of the model in space by stored tables: what a simulation would give, in microseconds.

`make calibrate-models` simulates walkers (evidence/tables) and fits functions to their speeds, to the
scatter between prints and to the error of the fit. A table says here where it is good and is refused
outside. Shaken plates have one (`discrepancy`), motors another (`motors`). A motor that its own
table does not cover is taken as the plate that moves as far (`shaking`), if that of plates does.
"""

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import Drive
from walkergen.errors import WalkergenError
from walkergen.scene import Scene
from walkergen.theory.uncertain import FREQUENCY, MOMENT, Drawn
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

LINEAR_BELOW = 0.25
"""Speed over the plate's peak speed below which the table's transform, asinh, is about linear:
slow walkers scatter by an amount, fast ones by a share."""

FAR_OFF = 2.5
"""Logarithm of tan(tilt) over friction beyond which feet stick, or slide, as they do at it."""

FARTHEST = 3.0
"""Standard deviations beyond which a feature stays as it is there."""

EXPONENTS = (-6.0, 1.0)
"""Exponents of a smooth function: beyond these it is as there."""

TABLED: tuple[Kind, ...] = ("flexible", "braced")
"""Kinds of legs that a table may have speeds of."""

EDGE = 0.02
"""Share of a number's range by which a walker may lie outside it: samples leave out the ends."""


class UnknownError(WalkergenError):
    """The speed in space is unknown here; the text says which number lies outside the table."""


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


class Speeds(NamedTuple):
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


def features(inputs: Array) -> Array:
    """One, the inputs and their squares, of what a smooth function is made; shape (n, 1 + 2 d)."""
    near = np.clip(inputs, -FARTHEST, FARTHEST)
    return np.column_stack([np.ones(len(inputs)), near, near**2])


def smooth(terms: Array, weights: Array) -> Array:
    """Positive function of features: the exponential of their weighted sum, shape (n,)."""
    return np.asarray(np.exp(np.clip(terms @ weights, *EXPONENTS)))


@dataclass(frozen=True, eq=False)
class StoredTable:
    """Speeds at numbers of a walker by the arrays of a file: its domain, its digest, its error."""

    path: Path
    words: str
    """What it has speeds of: how a refusal of a number begins."""
    names: tuple[str, ...]
    """Numbers on which a speed depends, in order: the first those of a `Place`."""
    fitted: Callable[[Mapping[str, Any], Kind, Array], Speeds]
    """Speeds at numbers within the ranges, shape (n, names), by arrays, of a kind of legs."""
    renamed: Mapping[str, str]
    """Names that numbers have here, in words, unlike their own."""

    @cached_property
    def arrays(self) -> dict[str, Any]:
        """Arrays of the file."""
        with np.load(self.path) as stored:
            return {name: stored[name] for name in stored.files}

    @cached_property
    def facts(self) -> dict[str, Any]:
        """What the table says of itself: ranges of its numbers, and errors at rows left out."""
        facts: dict[str, Any] = json.loads(str(self.arrays["facts"]))
        return facts

    @cached_property
    def digest(self) -> str:
        """Hash of the file, 16 hexadecimal digits: bounds of two families with equal ones compare."""
        return hashlib.sha256(self.path.read_bytes()).hexdigest()[:16]

    def ends(self, kind: Kind) -> Array:
        """Lower and upper ends of the numbers' ranges for a kind of legs, shape (2, names)."""
        ranges = self.facts["ranges"]  # of flexible legs alone, where they have no kinds
        return np.array([ranges.get(kind, ranges)[name] for name in self.names]).T

    def check(self, kind: Kind, numbers: Sequence[float | Array]) -> None:
        """Raise UnknownError for numbers of a walker that lie outside the ranges."""
        if kind not in TABLED:
            raise UnknownError(f"{self.words} legs that are {' or '.join(TABLED)}, not {kind}")
        for name, value, low, high in zip(self.names, numbers, *self.ends(kind), strict=True):
            margin = EDGE * (high - low)
            if not low - margin <= value <= high + margin:
                words, seen, ends = in_words(name, float(value), low, high)
                raise UnknownError(f"{self.words} {self.renamed.get(name, words)} in {ends}, not at {seen}")

    def speeds(self, kind: Kind, numbers: Sequence[float | Array]) -> Speeds:
        """Speeds at numbers, each a number or of shape (n,); outside the ranges those at their end."""
        columns = np.empty((np.broadcast(*numbers).size, len(numbers)))
        for column, number in enumerate(numbers):
            columns[:, column] = number
        return self.fitted(self.arrays, kind, np.clip(columns, *self.ends(kind)))


def in_words(name: str, value: float, low: float, high: float) -> tuple[str, str, str]:
    """Name, value and range of a number as people write them."""
    words = name.removeprefix("log_").removeprefix("root_").replace("_", " ")
    if name == "root_tilt":
        value, low, high = value**2, low**2, high**2
    elif name.startswith("log_"):
        value, low, high = math.exp(value), math.exp(low), math.exp(high)
    return words, f"{value:.3g}", f"{low:.2g}..{high:.2g}"


class Shaken(NamedTuple):
    """Plate that stands for a drive."""

    drive: Drive
    """The plate's vertical vibration."""
    swing: float
    """Peak speed of the whole swing, mm/s: the plate's own, unless the axis leans."""
    error_sd: float
    """Standard error of the stand-in, on the scale of `Prediction.model_sd`; 0 of a plate."""
    note: str = ""
    """What the stand-in leaves out, in words."""


def shaken(scene: Scene, design: Design, mass: MassProperties) -> Shaken:
    """Plate under a walker, or the one that stands for its motor. Raises InputError without one."""
    if scene.drive.kind == "plate":
        return Shaken(scene.drive, scene.drive.peak_speed, 0.0)
    from walkergen.theory import shaking

    return shaking.of(scene, design, mass)


class Tabled(NamedTuple):
    """Walker in a scene that a table covers."""

    table: StoredTable
    design: Design
    scene: Scene
    place: Place
    beside: tuple[float, ...]
    """Numbers beside those of the place."""
    sign: float
    """Sign of the tilt where the table knows the magnitude alone, else 1."""
    swing: float
    """Peak speed (mm/s) over which the table has speeds: of the plate, or of the motor's swing."""
    amplitude: float
    """Amplitude of that swing, mm."""
    error_sd: float = 0.0
    """Standard error of a plate in place of a motor, on the scale of `Prediction.model_sd`."""
    note: str = ""
    """What such a plate leaves out, in words, and why it stands in."""

    def at(self, place: Place) -> Speeds:
        """Speeds over the swing's peak speed at a place of numbers, or of arrays of shape (n,)."""
        shared = len(self.table.names) - len(self.beside)
        speeds = self.table.speeds(self.design.kind, (*place[:shared], *self.beside))
        return speeds._replace(centre=self.sign * speeds.centre)

    def speeds(self, drawn: Drawn) -> Speeds:
        """Speeds over the swing's peak speed at values of the inputs."""
        return self.at(self._places(drawn))

    @property
    def sense(self) -> float:
        """Sign that the mirror image has the other way: a walker's own has mirrored errors."""
        return math.copysign(1.0, self.at(self.place).centre[0]) if self.beside else self.sign

    def _places(self, drawn: Drawn) -> Place:
        pace, moment = of_motor(self.scene, drawn)
        design, scene, place = self.design, self.scene, self.place
        modulus = design.material.youngs_modulus_gpa
        unevenness = drawn.of("feet.unevenness_um", scene.feet.unevenness_um)
        return place.drawn(
            restitution=drawn.of("contact.restitution", float(place.restitution)),
            friction=drawn.of("contact.friction", scene.contact.friction),
            thickness=thickness(design, drawn),
            modulus=drawn.of("material.youngs_modulus_gpa", modulus) / modulus,
            body_mass=drawn.of("body mass", 1.0),
            leg_mass=leg_masses(design, drawn),
            unevenness=1e-3 * unevenness / (self.amplitude * moment),
        ).driven(pace, moment)


def of(scene: Scene, design: Design, mass: MassProperties) -> Tabled:
    """Table that covers a walker. Raises UnknownError, which says why, where none does."""
    reason = ""
    if scene.drive.kind == "motor":
        from walkergen.theory import motors

        try:
            return motors.of(scene, design, mass)
        except UnknownError as error:
            reason = str(error)
    from walkergen.theory import discrepancy

    try:
        tabled = discrepancy.of(scene, design, mass)
    except UnknownError as error:
        raise UnknownError("; ".join(filter(None, (reason, str(error))))) from None
    return tabled._replace(note=f"{tabled.note} ({reason})") if reason else tabled


def digests(scene: Scene) -> list[str]:
    """Hashes of the tables that a scene's predictions may rest on."""
    from walkergen.theory import discrepancy

    if scene.drive.kind == "plate":
        return [discrepancy.TABLE.digest]
    from walkergen.theory import motors

    return [discrepancy.TABLE.digest, motors.TABLE.digest]


def of_motor(scene: Scene, drawn: Drawn) -> tuple[Array, Array]:
    """Ratios of a motor's drawn frequency and moment to its nominal ones."""
    drive = scene.drive
    if drive.kind == "plate":
        return np.ones(drawn.number), np.ones(drawn.number)
    pace = drawn.of(FREQUENCY, drive.frequency) / drive.frequency
    return pace, drawn.of(MOMENT, drive.eccentric) / drive.eccentric


def thickness(design: Design, drawn: Drawn) -> Array:
    """Ratios of a leg's drawn thickness to its nominal one."""
    nominal = design.limbs[0].thickness
    return drawn.of("legs.thickness_mm", nominal) / nominal


def leg_masses(design: Design, drawn: Drawn) -> Array:
    """Ratios of a leg's drawn mass to its nominal one, which go with its thickness unless a balance
    told the mass.
    """
    weighed = design.weighed.leg_mass_g is not None
    return drawn.of("leg mass", 1.0) * (1.0 if weighed else thickness(design, drawn))
