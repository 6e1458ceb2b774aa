"""Theory's own error: its speeds against those of the model in space, from a stored table.

`make calibrate-models` simulates a thousand walkers (walkergen/jobs/discrepancies) and fits the
lengths of a Gaussian process to their speeds; here it is evaluated, and refused outside their
range.
"""

import hashlib
import json
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import WalkergenError
from walkergen.numerics import emulator
from walkergen.scene import LEAST_LABEL, Feet, Scene
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

TABLE = Path(__file__).with_suffix(".json")

LINEAR_BELOW = 0.25
"""Speed over the plate's peak speed below which the table's transform, asinh, is about linear:
slow walkers scatter by an amount, fast ones by a share."""

FAR_OFF = 2.5
"""Logarithm of tan(tilt) over friction beyond which feet stick, or slide, as they do at it."""

EDGE = 0.02
"""Share of a number's range by which a walker may lie outside it: Sobol's points leave out the
ends."""


class Place(NamedTuple):
    """Dimensionless numbers on which a simulated speed over the plate's peak speed depends."""

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


class UnknownError(WalkergenError):
    """The theory's own error is unknown here; the text says which number lies outside the table."""


class Found(NamedTuple):
    """Simulated speeds over the plate's peak speed: normal after asinh; arrays of shape (n,)."""

    centre: Array
    sd: Array
    """Standard deviation after asinh: from print to print, and by the interpolation."""

    def at(self, deviation: Array) -> Array:
        """Speeds over the plate's peak speed, so many standard deviations from the middle."""
        return np.asarray(LINEAR_BELOW * np.sinh(self.centre + self.sd * deviation))


def coordinates(rows: Array) -> Array:
    """Coordinates of the process, shape (n, 9): places with the friction seen against the tilt.

    Speeds change most where the tilt passes the angle of friction, there feet stick.
    """
    found = rows.copy()
    tilt = np.radians(np.maximum(rows[:, 0] ** 2, 1e-3))
    found[:, 2] = np.clip(np.log(np.tan(tilt)) - rows[:, 2], -FAR_OFF, FAR_OFF)
    return found


def transformed(speed: Array, se: Array) -> tuple[Array, Array]:
    """Speeds over the plate's peak speed and their standard errors, after asinh."""
    return np.arcsinh(speed / LINEAR_BELOW), se / np.hypot(speed, LINEAR_BELOW)


def place_of(scene: Scene, design: Design, mass: MassProperties) -> Place:
    """Place of a walker in the table. Braced legs have neither hinges nor masses of their own.

    Raises UnknownError for other legs than two equal ones.
    """
    if not design.alike:
        raise UnknownError(
            "no bounds: the theory's own error is known for two equal legs only, not for [[legs]]"
        )
    limb, leg, span, drive = design.limbs[0], mass.legs[0], design.foot_span, scene.drive
    hinge = mass_ratio = 1.0
    if not mass.rigid:
        second_moment = limb.width * limb.thickness**3 / 12.0
        spring = 3e9 * design.material.youngs_modulus_gpa * second_moment / limb.length
        turning = float(leg.j) + float(leg.m) * float(leg.c_A @ leg.c_A)
        hinge = math.sqrt(spring / turning) / drive.omega
        mass_ratio = float(leg.m) / float(mass.M)
    gyration = float(mass.J) / float(mass.M) / span**2
    return Place(
        math.sqrt(abs(design.tilt_deg)),
        max(scene.contact.restitution, LEAST_LABEL),
        math.log(max(scene.contact.friction, 1e-9)),
        drive.peak_gamma,
        math.log(hinge),
        limb.length / span,
        math.log(mass_ratio),
        0.5 * math.log(gyration),
        1e-3 * scene.feet.unevenness_um / drive.amplitude,
    )


def check(scene: Scene, place: Place, braced: bool) -> None:
    """Refuse walkers and scenes that the table does not cover. Raises UnknownError."""
    plate, feet = scene.plate, scene.feet
    plain = Feet(unevenness_um=feet.unevenness_um, unevenness_sd_um=feet.unevenness_sd_um)
    for told, neutral in (
        ("a sloping plate", plate.slope_deg == 0.0),
        ("plate noise", plate.noise_ratio == 0.0),
        ("a rough plate", plate.roughness_um == 0.0),
        ("a second harmonic", scene.drive.second_harmonic_ratio == 0.0),
        ("other feet than the usual", feet == plain),
    ):
        if not neutral:
            raise UnknownError(f"no bounds: the theory's own error is not known for {told}")
    names = ("restitution", "log_friction", "gamma") if braced else Place._fields
    for name in names:
        low, high = _table()["ranges"][name]
        value, margin = getattr(place, name), EDGE * (high - low)
        if not low - margin <= value <= high + margin:
            told, seen, ends = _in_words(name, value, low, high)
            raise UnknownError(
                f"no bounds: the theory's own error is known for {told} in {ends}, not at {seen}"
            )


def _in_words(name: str, value: float, low: float, high: float) -> tuple[str, str, str]:
    """Name, value and range of a number as people write them."""
    told = name.removeprefix("log_").removeprefix("root_").replace("_", " ")
    if name == "root_tilt":
        value, low, high = value**2, low**2, high**2
    elif name.startswith("log_"):
        value, low, high = math.exp(value), math.exp(low), math.exp(high)
    return told, f"{value:.3g}", f"{low:.2g}..{high:.2g}"


def speeds(place: Place, tilt_deg: float, braced: bool) -> Found:
    """Simulated speeds over the plate's peak speed at places with at least one array, shape (n,).

    Numbers outside the table's range are taken at its end (see `check`). Tilts of the other sign
    run the other way.
    """
    table = _table()
    count = np.broadcast(*place).size
    if braced:  # rigid legs do not run: a scatter about zero
        return Found(np.zeros(count), np.full(count, table["braced_sd"]))
    low, high = np.array([table["ranges"][name] for name in Place._fields]).T
    x = np.column_stack([np.broadcast_to(column, count) for column in place])
    scaled = coordinates(np.clip(x, low, high)) / table["lengths"]
    with emulator.alone():
        centre, sd = _process().predict(scaled, return_std=True)
    return Found(math.copysign(1.0, tilt_deg) * centre, np.hypot(sd, table["sd"]))


@cache
def _table() -> dict[str, Any]:
    """The stored table; `sd` after asinh, `braced_sd` in the plate's peak speed over the linear."""
    found: dict[str, Any] = json.loads(TABLE.read_text(encoding="utf-8"))
    return found


@cache
def _process() -> Any:
    """Gaussian process through the table, with the lengths and noise stored in it."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern

    table = _table()
    rows = np.array(table["rows"])
    y, se = transformed(rows[:, -3], rows[:, -2])
    kernel = ConstantKernel(table["amplitude"], "fixed") * Matern(1.0, "fixed", nu=1.5)
    process = GaussianProcessRegressor(kernel, alpha=(table["noise"] ** 2 + se**2), optimizer=None)
    return process.fit(coordinates(rows[:, :-3]) / table["lengths"], y)


def digest() -> str:
    """Hash of the table, 16 hexadecimal digits: bounds of two families with equal ones compare."""
    return hashlib.sha256(TABLE.read_bytes()).hexdigest()[:16]
