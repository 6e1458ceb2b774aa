"""Table of speeds in space of walkers on a shaken plate: small networks, by kind of legs.

Their outputs are multiplied by what turns about with the walker, and summed: what must vanish, or
change its sign, does so by its factor.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.drive import Drive
from walkergen.scene import LEAST_LABEL, Plate, Scene
from walkergen.theory.surrogate import (
    FAR_OFF,
    Place,
    Speeds,
    StoredTable,
    Tabled,
    UnknownError,
    features,
    shaken,
    smooth,
)
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

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


BLOCK = 256
"""Inputs that are evaluated together: products so small that no library shares them out to threads,
which wait for one another, on a busy machine for a hundred times the time of the work."""


class Layer(NamedTuple):
    """One layer of a network, or of several, then with a leading axis."""

    weights: Array
    """Shape (..., inputs, outputs)."""
    bias: Array
    """Shape (..., 1, outputs)."""


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


def of(scene: Scene, design: Design, mass: MassProperties) -> Tabled:
    """Walker in the table. Raises UnknownError for one, or a scene, that it does not cover."""
    place = place_of(scene, design, mass)
    for reason in _reasons(scene):
        raise UnknownError(f"speeds in space are not known for {reason}")
    TABLE.check(design.kind, place)
    plate = shaken(scene, design, mass)
    sign = math.copysign(1.0, design.tilt_deg)
    amplitude = plate.drive.amplitude
    return Tabled(TABLE, design, scene, place, (), sign, plate.swing, amplitude, plate.error_sd, plate.note)


def place_of(scene: Scene, design: Design, mass: MassProperties) -> Place:
    """Place of a walker in the table. Braced legs have neither hinges nor masses of their own.

    Raises UnknownError for other legs than two equal ones.
    """
    if not design.alike:
        raise UnknownError("speeds in space are known for two equal legs only, not for [[legs]]")
    return numbers(scene, design, mass, shaken(scene, design, mass).drive)


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


def _reasons(scene: Scene) -> Iterator[str]:
    """Properties of a scene that the table does not cover, in words."""
    plate, usual = scene.plate, Plate()
    if not abs(plate.slope_deg) <= MOST_SLOPE_DEG:
        yield f"slopes beyond {MOST_SLOPE_DEG:g} deg"
    band = (plate.noise_low_hz, plate.noise_high_hz) == (usual.noise_low_hz, usual.noise_high_hz)
    if not band and plate.noise_ratio != 0.0:
        yield "plate noise in another band than the usual"
    yield from beyond(scene)


def beyond(scene: Scene) -> list[str]:
    """Keys and values of a scene, as people write them, that the table does not cover."""
    return [
        f"{name}.{key} = {getattr(table, key)}"
        for name in type(scene).model_fields
        if name not in COVERED and (table := getattr(scene, name)) != type(table)()
        for key, field in type(table).model_fields.items()
        if f"{name}.{key}" not in COVERED and getattr(table, key) != field.default
    ]


def evaluated(layers: Sequence[Layer], inputs: Array) -> Array:
    """Outputs at inputs of shape (n, d), shape (..., n, outputs), in single precision."""
    starts = range(0, len(inputs), BLOCK)
    return np.concatenate([_passed(layers, inputs[k : k + BLOCK]) for k in starts], axis=-2)


def _passed(layers: Sequence[Layer], inputs: Array) -> Array:
    values = inputs.astype(np.float32)
    for layer in layers[:-1]:
        values = np.matmul(values, layer.weights)
        values += layer.bias
        np.tanh(values, out=values)
    return np.asarray(values @ layers[-1].weights + layers[-1].bias)


def layers_of(arrays: Mapping[str, Array], name: str) -> list[Layer]:
    """Layers of the networks that arrays have under this name."""
    weights = sorted(key for key in arrays if key.startswith(f"{name}_weights"))
    return [Layer(arrays[key], arrays[key.replace("weights", "bias")]) for key in weights]


def fitted(arrays: Mapping[str, Any], kind: Kind, places: Array) -> Speeds:
    """Speeds at places, shape (n, 16), all within the ranges, by the arrays of a table."""
    inputs, odd = coordinates(places)
    inputs = (inputs - arrays[f"{kind}_middle"]) / arrays[f"{kind}_scale"]
    layers = layers_of(arrays, kind)
    centre = (evaluated(layers, inputs).mean(axis=0) * odd).sum(axis=1)
    terms = features(inputs)
    error = smooth(terms, arrays[f"{kind}_error"])
    prints = places[:, 8] * smooth(terms, arrays[f"{kind}_prints"])
    return Speeds(centre, np.hypot(error, prints), prints)


TABLE = StoredTable(Path(__file__).with_suffix(".npz"), "speeds in space are known for", Place._fields, fitted, {})
