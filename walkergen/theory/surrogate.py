"""Surrogate of the model in space: what a simulation would give, in a millisecond, where it is known to.

Small networks on dimensionless numbers of a walker with two equal legs on a shaken plate or in a lane
(evidence/tables trains them on simulated walkers). Ten of them were trained without other tenths of the rows:
how far they differ tells how well they know a walker, scaled so that it holds at rows that none has seen.
Where that error is beyond GOAL, where walkers topple, and beyond the numbers that were sampled there is no
answer here: such a walker is simulated (`points.speeds`).
"""

import hashlib
import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from statistics import NormalDist
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError, WalkergenError
from walkergen.scene import LEAST_LABEL, Scene
from walkergen.theory.uncertain import Drawn
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

FILE = Path(__file__).with_suffix(".npz")

NORMAL_95 = NormalDist().inv_cdf(0.975)
"""Standard deviations on either side of the middle that hold 95 % of a normal distribution."""

LINEAR_BELOW = 0.25
"""Speed over the plate's peak speed below which the networks' scale, asinh, is about linear: slow walkers
scatter by an amount, fast ones by a share."""

GOAL_SHARE, GOAL_MM_S = 0.12, 1.0
"""Error (95 %) up to which the surrogate answers: the larger of a share of the speed and a speed."""

MOST_FALLS = 0.04
"""Chance that a run ends in a fall, by the networks, up to which the surrogate answers."""

FAR_OFF = 2.5
"""Logarithm of tan(tilt) over friction beyond which feet stick, or slide, as they do at it."""

SLIGHT_DEG = 1.0
"""Tilt at which speeds of small tilts, which are in proportion to it, begin to level off."""

TURN = 0.018
"""Turn (rad) that a lane allows at which its walls count for half: 0.5 mm of play of a body of 28 mm."""

FARTHEST = 3.0
"""Standard deviations beyond which a feature of a smooth function stays as it is there."""

EXPONENTS = (-6.0, 1.0)
"""Exponents of a smooth function: beyond these it is as there."""

EDGE = 0.02
"""Share of a number's range by which a walker may lie outside it: samples leave out the ends."""

BLOCK = 96
"""Inputs that are evaluated together: products so small that no library shares them out to threads."""


class UnknownError(WalkergenError):
    """The surrogate does not know a walker; the text says why, in words that a table of many says once."""


class Place(NamedTuple):
    """Dimensionless numbers on which a speed over the plate's peak speed depends; lengths over the feet's distance.

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
    """Length of a leg."""
    log_mass_ratio: float | Array
    """Logarithm of a leg's mass over the body's."""
    log_gyration_ratio: float | Array
    """Logarithms of the body's radii of gyration: in the plane of the run,"""
    log_roll_ratio: float | Array
    """about the run,"""
    log_yaw_ratio: float | Array
    """and about the vertical."""
    height_ratio: float | Array
    """Height of the centre of mass over the feet."""
    fore_ratio: float | Array
    """Place of the centre of mass before the middle of the feet, the way that the legs push."""
    unevenness_ratio: float | Array
    """Unevenness of the feet over the plate's amplitude."""
    log_foot_ratio: float | Array
    """Logarithm of the frequency of the body on a leg's axial stiffness over the drive's."""
    log_damping: float | Array
    """Logarithm of the damping ratio of a leg."""
    log_amplitude_ratio: float | Array
    """Logarithm of the plate's amplitude."""
    log_width_ratio: float | Array
    """Logarithm of the width of a foot."""
    thickness_ratio: float | Array
    """Thickness of a leg: the length of its foot."""
    slope_ratio: float | Array
    """tan(slope) over friction, positive where the slope helps a walker of this tilt along."""
    harmonic_cos: float | Array
    """Ratio of the second harmonic times the cosine of its phase."""
    harmonic_sin: float | Array
    noise_ratio: float | Array
    """Root mean square of the plate's random speed over the drive's peak speed."""
    closeness: float | Array
    """Of the walls of a lane: 1/(1 + turn that they allow/TURN); 0 on an open plane."""
    wall_friction: float | Array
    wall_restitution: float | Array
    """Both 0 on an open plane."""
    log_body_ratio: float | Array
    """Logarithms of the body's length and depth, which meet the walls."""
    log_depth_ratio: float | Array

    def drawn(self, design: Design, scene: Scene, drawn: Drawn) -> "Place":
        """Places at drawn values of the inputs of a prediction."""
        contact, modulus = scene.contact, design.material.youngs_modulus_gpa
        friction = np.maximum(drawn.of("contact.friction", contact.friction), 1e-9)
        stiffness = drawn.of("material.youngs_modulus_gpa", modulus) / modulus
        thickness, leg, body = leg_thickness(design, drawn), leg_masses(design, drawn), drawn.of("body mass", 1.0)
        unevenness = drawn.of("feet.unevenness_um", scene.feet.unevenness_um)
        hinge = self.log_hinge_ratio + np.log(thickness * np.sqrt(stiffness * thickness / leg))
        if design.rigid:
            hinge = np.full(drawn.number, self.log_hinge_ratio)
        return self._replace(
            restitution=drawn.of("contact.restitution", float(self.restitution)),
            log_friction=np.log(friction),
            log_hinge_ratio=hinge,
            log_mass_ratio=self.log_mass_ratio + np.log(leg / body),
            log_foot_ratio=self.log_foot_ratio + 0.5 * np.log(thickness * stiffness / body),
            thickness_ratio=self.thickness_ratio * thickness,
            slope_ratio=self.slope_ratio * math.exp(float(self.log_friction)) / friction,
            unevenness_ratio=1e-3 * unevenness / scene.drive.amplitude,
        )


def leg_thickness(design: Design, drawn: Drawn) -> Array:
    """Ratios of a leg's drawn thickness to its nominal one."""
    nominal = design.limbs[0].thickness
    return drawn.of("legs.thickness_mm", nominal) / nominal


def leg_masses(design: Design, drawn: Drawn) -> Array:
    """Ratios of a leg's drawn mass to its nominal one, which go with its thickness unless a balance told the mass."""
    weighed = design.weighed.leg_mass_g is not None
    return drawn.of("leg mass", 1.0) * (1.0 if weighed else leg_thickness(design, drawn))


class Speeds(NamedTuple):
    """Speeds in space over the plate's peak speed: normal after asinh; arrays of shape (n,)."""

    centre: Array
    error: Array
    """Standard error of the networks."""
    between_prints: Array
    """Standard deviation by which prints of one walker differ, as their feet are uneven."""
    falls: Array
    """Chance that a run ends in a fall."""

    def at(self, deviation: Array | float) -> Array:
        """Speeds over the plate's peak speed, so far from the middle on the scale of the networks."""
        return np.asarray(LINEAR_BELOW * np.sinh(self.centre + deviation))


class Layer(NamedTuple):
    """One layer of several networks."""

    weights: Array
    """Shape (networks, inputs, outputs)."""
    bias: Array
    """Shape (networks, 1, outputs)."""


@cache
def arrays() -> Mapping[str, Any]:
    """Arrays of the surrogate's file. Raises InputError for a file that was spoilt."""
    try:
        with np.load(io.BytesIO(FILE.read_bytes())) as stored:
            kept = {name: stored[name] for name in stored.files}
        whole = str(kept.pop("digest")) == digest_of(kept)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"{FILE}: the surrogate cannot be read: {error}; install walkergen again") from None
    if not whole:
        raise InputError(f"{FILE}: the surrogate was changed or cut: install walkergen again")
    return kept


def digest_of(kept: Mapping[str, Any]) -> str:
    """Hash of arrays by their names, 32 hexadecimal digits."""
    hasher = hashlib.sha256()
    for name in sorted(kept):
        value = np.ascontiguousarray(kept[name])
        hasher.update(f"{name} {value.dtype} {value.shape}".encode() + value.tobytes())
    return hasher.hexdigest()[:32]


@cache
def digest() -> str:
    """Hash of the surrogate: bounds of two families with equal ones compare."""
    return digest_of(arrays())


@cache
def facts() -> dict[str, Any]:
    """What the surrogate tells of itself: ranges of its numbers, and errors at rows that it has not seen."""
    stored: dict[str, Any] = json.loads(str(arrays()["facts"]))
    return stored


@cache
def layers_of(name: str) -> tuple[Layer, ...]:
    """Layers of the networks of this name."""
    kept = arrays()
    layers: list[Layer] = []
    while f"{name}_weights{len(layers)}" in kept:
        layers.append(Layer(kept[f"{name}_weights{len(layers)}"], kept[f"{name}_bias{len(layers)}"]))
    return tuple(layers)


def evaluated(layers: Sequence[Layer], inputs: Array) -> Array:
    """Outputs at inputs of shape (n, d), shape (networks, n, outputs), in single precision."""
    starts = range(0, len(inputs), BLOCK)
    return np.concatenate([_passed(layers, inputs[k : k + BLOCK]) for k in starts], axis=-2)


def _passed(layers: Sequence[Layer], inputs: Array) -> Array:
    values = inputs.astype(np.float32)
    for layer in layers[:-1]:
        values = np.matmul(values, layer.weights)
        values += layer.bias
        np.tanh(values, out=values)
    return np.asarray(np.matmul(values, layers[-1].weights) + layers[-1].bias)


def columns(place: Place) -> Array:
    """Numbers of places, shape (n, numbers)."""
    return np.column_stack(np.broadcast_arrays(*(np.atleast_1d(number) for number in place)))


def coordinates(places: Array) -> tuple[Array, Array]:
    """Inputs of the networks, shape (n, d), and the odd factors of their outputs, shape (n, 2).

    Speeds change most where the tilt passes the angle of friction, where feet stick. What turns about with the
    walker and its plate, tilt and slope, comes into the inputs by products that stay: so a walker without tilt on
    a level plate has no speed, and the mirror image the other.
    """
    of = Place(*places.T)
    tilt = of.root_tilt**2
    odd = tilt / (tilt + SLIGHT_DEG)
    against = np.log(np.tan(np.radians(np.maximum(tilt, 1e-3)))) - of.log_friction
    plain = of._replace(
        slope_ratio=odd * of.slope_ratio,
        unevenness_ratio=np.sqrt(of.unevenness_ratio),
        wall_friction=of.closeness * of.wall_friction,
        wall_restitution=of.closeness * of.wall_restitution,
        log_body_ratio=of.closeness * of.log_body_ratio,
        log_depth_ratio=of.closeness * of.log_depth_ratio,
    )
    more = (
        tilt,
        np.clip(against, -FAR_OFF, FAR_OFF),
        np.log(of.gamma),
        of.slope_ratio**2,
        np.hypot(of.harmonic_cos, of.harmonic_sin),
        np.sign(of.closeness),
    )
    return np.column_stack([*plain, *more]), np.column_stack([odd, of.slope_ratio])


def features(inputs: Array) -> Array:
    """One, the inputs and their squares, of what a smooth function is made; shape (n, 1 + 2 d)."""
    near = np.clip(inputs, -FARTHEST, FARTHEST)
    return np.column_stack([np.ones(len(inputs)), near, near**2])


def smooth(terms: Array, weights: Array) -> Array:
    """Positive function of features: the exponential of their weighted sum, shape (n,)."""
    return np.asarray(np.exp(np.clip(terms @ weights, *EXPONENTS)))


def speeds_at(kind: Kind, places: Array) -> Speeds:
    """Speeds at places, shape (n, numbers), of walkers with legs of a kind."""
    kept = arrays()
    plain, odd = coordinates(places)
    inputs = (plain - kept[f"{kind}_middle"]) / kept[f"{kind}_scale"]
    values = (evaluated(layers_of(kind), inputs) * odd).sum(axis=-1)
    terms, uneven = features(inputs), places[:, Place._fields.index("unevenness_ratio")]
    prints = uneven * smooth(terms, kept[f"{kind}_prints"])
    run_sd = np.hypot(smooth(terms, kept[f"{kind}_in_time"]), prints)
    level = np.minimum(np.abs(odd).sum(axis=1), 1.0)  # none without tilt on a level plate, by symmetry
    parts = np.stack([values.std(axis=0, ddof=1), run_sd * level, level])
    error = np.sqrt(kept[f"{kind}_error"] ** 2 @ parts**2)
    falls = 1.0 / (1.0 + np.exp(-evaluated(layers_of(f"{kind}_falls"), inputs)[..., 0].mean(axis=0)))
    return Speeds(values.mean(axis=0), error, prints, falls)


class Known(NamedTuple):
    """Walker in a scene that the surrogate knows."""

    design: Design
    scene: Scene
    place: Place

    @property
    def sign(self) -> float:
        """Sign of the tilt: places know its magnitude alone."""
        return math.copysign(1.0, self.design.tilt_deg)

    @property
    def peak_speed(self) -> float:
        """Peak speed of the plate, mm/s, over which the surrogate has speeds."""
        return self.scene.drive.peak_speed

    def at(self, place: Place) -> Speeds:
        """Speeds at a place, or at places, beyond the sampled numbers as at their ends."""
        kind = self.design.kind
        speeds = speeds_at(kind, np.clip(columns(place), *_ends(kind)))
        return speeds._replace(centre=self.sign * speeds.centre)

    @property
    def nominal(self) -> tuple[float, float]:
        """Speed of the walker as designed and its standard error, mm/s."""
        return self.in_mm_s(self.at(self.place))

    def in_mm_s(self, speeds: Speeds) -> tuple[float, float]:
        """First of some speeds and its standard error, mm/s."""
        slope = LINEAR_BELOW * math.cosh(speeds.centre[0])
        return self.peak_speed * float(speeds.at(0.0)[0]), self.peak_speed * slope * float(speeds.error[0])

    def drawn(self, drawn: Drawn) -> Speeds:
        """Speeds at drawn values of the inputs of a prediction."""
        return self.at(self.place.drawn(self.design, self.scene, drawn))


def of(scene: Scene, design: Design, mass: MassProperties, within_goal: bool = True) -> Known:
    """Walker that the surrogate knows. Raises UnknownError, which says why, for one that is to be simulated.

    Whoever bears its error, as a fit does, asks for walkers that are not `within_goal` too.
    """
    for reason in _reasons(scene, design):
        raise UnknownError(reason)
    known = Known(design, scene, place_of(scene, design, mass))
    _check_ranges(design.kind, known.place)
    speeds = known.at(known.place)
    if speeds.falls[0] > MOST_FALLS:
        raise UnknownError("such walkers may fall over")
    speed, se = known.in_mm_s(speeds)
    goal = max(GOAL_SHARE * abs(speed), GOAL_MM_S)
    if within_goal and NORMAL_95 * se > goal:
        raise UnknownError(f"the surrogate does not know it to {100.0 * GOAL_SHARE:g} % or {GOAL_MM_S:g} mm/s")
    return known


def place_of(scene: Scene, design: Design, mass: MassProperties) -> Place:
    """Place of a walker with two equal legs on a shaken plate. Braced legs have neither hinges nor own masses."""
    limb, leg, span, drive = design.limbs[0], mass.legs[0], design.foot_span, scene.drive
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
    fore, height = (mass.centre - np.mean([one.foot for one in mass.legs], axis=0)) / span
    gyration = [0.5 * math.log(inertia / float(mass.M) / span**2) for inertia in _inertias(mass)]
    size, arena = design.size, scene.arena
    closeness = 0.0
    if arena.kind == "lane":
        play = DEFAULT_PLAY_MM if arena.gap_mm is None else arena.gap_mm - size.depth
        closeness = 1.0 / (1.0 + max(play, 0.0) / size.length / TURN)
    return Place(
        root_tilt=math.sqrt(abs(design.tilt_deg)),
        restitution=max(scene.contact.restitution, LEAST_LABEL),
        log_friction=math.log(friction),
        gamma=drive.peak_gamma,
        log_hinge_ratio=math.log(hinge),
        length_ratio=limb.length / span,
        log_mass_ratio=math.log(mass_ratio),
        log_gyration_ratio=gyration[2],
        log_roll_ratio=gyration[0],
        log_yaw_ratio=gyration[1],
        height_ratio=float(height),
        fore_ratio=along * float(fore),
        unevenness_ratio=1e-3 * scene.feet.unevenness_um / drive.amplitude,
        log_foot_ratio=0.5 * math.log(axial / float(mass.M)) - math.log(drive.omega),
        log_damping=math.log(max(scene.legs.damping_ratio, 1e-9)),
        log_amplitude_ratio=math.log(drive.amplitude / span),
        log_width_ratio=math.log(limb.width / span),
        thickness_ratio=limb.thickness / span,
        slope_ratio=along * math.tan(math.radians(scene.plate.slope_deg)) / friction,
        harmonic_cos=drive.second_harmonic_ratio * math.cos(phase),
        harmonic_sin=drive.second_harmonic_ratio * math.sin(phase),
        noise_ratio=scene.plate.noise_ratio,
        closeness=closeness,
        wall_friction=arena.wall_friction if closeness else 0.0,
        wall_restitution=arena.wall_restitution if closeness else 0.0,
        log_body_ratio=math.log(size.length / span),
        log_depth_ratio=math.log(size.depth / span),
    )


DEFAULT_PLAY_MM = 0.5
"""Gap of a lane over the depth of the body unless the scene says, as `simulation.effects.walls` has it."""


def _inertias(mass: MassProperties) -> tuple[float, float, float]:
    """Moments of inertia of the body about the run, the vertical and across the run, g mm^2."""
    assert mass.spatial is not None
    roll, yaw = (float(mass.spatial.body[axis, axis]) for axis in (0, 1))
    return roll, yaw, float(mass.J)


def _reasons(scene: Scene, design: Design) -> Iterator[str]:
    """What of a walker and its scene the surrogate has never met, in words."""
    if scene.drive.kind == "motor":
        yield "walkers with a motor are simulated"
    if not design.alike:
        yield "walkers of other legs than two equal ones are simulated"
    if design.kind not in ("flexible", "braced"):
        yield f"walkers on legs that are {design.kind} are simulated"
    limb = design.limbs[0]
    if limb.foot != "flat" or limb.friction is not None or limb.restitution is not None:
        yield "walkers on feet of another shape or material are simulated"
    if scene.legs.model not in ("auto", "space"):
        yield f"legs.model = {scene.legs.model} is simulated: the surrogate is of the model in space"
    yield from beyond(scene)


BESIDE = frozenset({"name", "description", "prediction", "run", "crowd", "contact", "drive", "arena"})
"""Tables of a scene that the surrogate reads, or that change no mean speed."""

READ = {
    "plate": {"slope_deg", "noise_ratio"},
    "feet": {"unevenness_um", "unevenness_sd_um"},
    "legs": {"model", "damping_ratio", "damping_ratio_sd"},
}
"""Keys of other tables that the surrogate reads, or that it draws."""


def beyond(scene: Scene) -> list[str]:
    """Keys and values of a scene, as people write them, that the surrogate has never met.

    What shapes noise or roughness counts only where there is some.
    """
    reasons = []
    for name in type(scene).model_fields:
        if name in BESIDE:
            continue
        table = getattr(scene, name)
        for key, field in type(table).model_fields.items():
            idle = key == "roughness_length_mm" and scene.plate.roughness_um == 0.0
            idle |= key.startswith("noise_") and scene.plate.noise_ratio == 0.0
            idle |= name == "tether" and scene.tether.stiffness_n_per_m == 0.0
            value = getattr(table, key)
            if key not in READ.get(name, ()) and not idle and value != field.default:
                reasons.append(f"{name}.{key} = {value} is simulated")
    return reasons


def _ends(kind: Kind) -> Array:
    """Lower and upper ends of the sampled numbers for a kind of legs, shape (2, numbers)."""
    ranges = facts()["ranges"][kind]
    return np.array([ranges[name] for name in Place._fields]).T


def _check_ranges(kind: Kind, place: Place) -> None:
    """Raise UnknownError for a walker with a number that was not sampled."""
    for name, value, low, high in zip(Place._fields, place, *_ends(kind), strict=True):
        margin = EDGE * (high - low) + 1e-9
        if not low - margin <= float(value) <= high + margin:
            words, ends = in_words(name, low, high)
            side = "less" if float(value) < low else "more"
            raise UnknownError(f"the surrogate knows a {words} of {ends}, and here it is {side}")


def in_words(name: str, low: float, high: float) -> tuple[str, str]:
    """Name and range of a number as people write them."""
    words = name.removeprefix("log_").removeprefix("root_").replace("_", " ")
    if name == "root_tilt":
        low, high = low**2, high**2
    elif name.startswith("log_"):
        low, high = math.exp(low), math.exp(high)
    return words, f"{low:.2g} to {high:.2g}"
