"""Dimensionless numbers of a walker, its plate and its lane, the inputs of the surrogate."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.scene import MIN_RESTITUTION, Scene
from walkergen.core.theory.hertz import contact_modulus
from walkergen.core.theory.uncertain_inputs import Drawn
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

HALF_WEIGHT_TURN_RAD = 0.018
"""Turn (rad) that a lane allows at which its walls count for half: 0.5 mm of play of a body of 28 mm."""

DEFAULT_PLAY_MM = 0.5
"""Default gap of a lane over the depth of the body, as in `simulation.effects.walls`."""


class DimensionlessNumbers(NamedTuple):
    """Dimensionless numbers on which a speed over the plate's peak speed depends; lengths over the feet's distance.

    A walker of the other tilt on the other slope is the mirror image: it has the same numbers. Fields are floats, or
    arrays of one shape (n,) for n draws.
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
    """Position of the centre of mass before the middle of the feet, the way that the legs push."""
    unevenness_ratio: float | Array
    """Unevenness of the feet over the plate's amplitude."""
    log_foot_ratio: float | Array
    """Logarithm of the frequency of the body on a leg's axial stiffness over the drive's."""
    log_tip_ratio: float | Array
    """Logarithm of the frequency of the walker on one tip over the drive's; the tip as stiff as where it has stopped
    the walker, (E*^4 R^2 M v^2)^(1/5), v the plate's peak speed."""
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
    """Narrowness of a lane: 1/(1 + turn that its walls allow/HALF_WEIGHT_TURN_RAD); 0 on an open plane."""
    wall_friction: float | Array
    wall_restitution: float | Array
    """Both 0 on an open plane."""
    log_body_ratio: float | Array
    """Logarithms of the body's length and depth, which meet the walls."""
    log_depth_ratio: float | Array

    def with_inputs(self, design: Design, scene: Scene, drawn: Drawn) -> "DimensionlessNumbers":
        """Return these numbers for random draws of the uncertain inputs; affected numbers have the shape (draws,)."""
        contact, material = scene.contact, design.material
        modulus = material.youngs_modulus_gpa
        friction = np.maximum(drawn.input_values("contact.friction", contact.friction), 1e-9)
        stiffness = drawn.input_values("material.youngs_modulus_gpa", modulus) / modulus
        radius = drawn.input_values("feet.tip_radius_um", scene.feet.tip_radius_um) / scene.feet.tip_radius_um
        # Share of the foot in the compliance of foot and plate, and E* over the nominal one
        foot_share = contact_modulus(scene, material) * (1.0 - material.poisson_ratio**2) / material.youngs_modulus
        hardness = 1.0 / (1.0 - foot_share + foot_share / stiffness)
        thickness, leg, body = (
            leg_thickness_ratios(design, drawn),
            leg_mass_ratios(design, drawn),
            drawn.input_values("body mass", 1.0),
        )
        unevenness = drawn.input_values("feet.unevenness_um", scene.feet.unevenness_um)
        hinge = self.log_hinge_ratio + np.log(thickness * np.sqrt(stiffness * thickness / leg))
        if design.rigid:
            hinge = np.full(drawn.number, self.log_hinge_ratio)
        return self._replace(
            restitution=drawn.input_values("contact.restitution", float(self.restitution)),
            log_friction=np.log(friction),
            log_hinge_ratio=hinge,
            log_mass_ratio=self.log_mass_ratio + np.log(leg / body),
            log_foot_ratio=self.log_foot_ratio + 0.5 * np.log(thickness * stiffness / body),
            log_tip_ratio=self.log_tip_ratio + 0.4 * np.log(hardness) + 0.2 * np.log(radius) - 0.4 * np.log(body),
            thickness_ratio=self.thickness_ratio * thickness,
            slope_ratio=self.slope_ratio * math.exp(float(self.log_friction)) / friction,
            unevenness_ratio=1e-3 * unevenness / scene.drive.amplitude,
        )


def compute_numbers(scene: Scene, design: Design, mass: MassProperties) -> DimensionlessNumbers:
    """Compute the dimensionless numbers of a walker with two equal legs. With braced legs two ratios are 1."""
    limb, leg, span, drive = design.limbs[0], mass.legs[0], design.foot_span, scene.drive
    hinge = mass_ratio = 1.0
    modulus = 1e9 * design.material.youngs_modulus_gpa
    if not mass.rigid:
        spring = modulus * limb.width * limb.thickness**3 / (4.0 * limb.length)
        turning = float(leg.j) + float(leg.m) * float(leg.c_A @ leg.c_A)
        hinge = math.sqrt(spring / turning) / drive.omega
        mass_ratio = float(leg.m) / float(mass.M)
    axial = modulus * limb.width * limb.thickness / limb.length
    friction = max(scene.contact.friction, 1e-9)  # finite logarithm without friction
    phase = math.radians(drive.second_harmonic_phase_deg)
    along = math.copysign(1.0, design.tilt_deg)
    fore, height = (mass.centre - np.mean([one.foot for one in mass.legs], axis=0)) / span
    gyration = [0.5 * math.log(inertia / float(mass.M) / span**2) for inertia in _inertias(mass)]
    size, arena = design.size, scene.arena
    closeness = 0.0
    if arena.kind == "lane":
        play = DEFAULT_PLAY_MM if arena.gap_mm is None else arena.gap_mm - size.depth
        closeness = 1.0 / (1.0 + max(play, 0.0) / size.length / HALF_WEIGHT_TURN_RAD)
    return DimensionlessNumbers(
        root_tilt=math.sqrt(abs(design.tilt_deg)),
        restitution=max(scene.contact.restitution, MIN_RESTITUTION),
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
        log_tip_ratio=_log_tip_ratio(scene, design, float(mass.M)),
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


def _log_tip_ratio(scene: Scene, design: Design, mass: float) -> float:
    """Return `DimensionlessNumbers.log_tip_ratio` of a walker of `mass` g."""
    modulus, radius, drive = contact_modulus(scene, design.material), 1e-3 * scene.feet.tip_radius_um, scene.drive
    stiffness = (modulus**4 * radius**2 * mass * drive.peak_speed**2) ** 0.2
    return 0.5 * math.log(stiffness / mass) - math.log(drive.omega)


def _inertias(mass: MassProperties) -> tuple[float, float, float]:
    """Return the body's moments of inertia about the axis along the run, the vertical, and the axis across, g mm^2."""
    assert mass.spatial is not None
    roll, yaw = (float(mass.spatial.body[axis, axis]) for axis in (0, 1))
    return roll, yaw, float(mass.J)


def leg_thickness_ratios(design: Design, drawn: Drawn) -> Array:
    """Return the thickness of a leg in each random draw over its nominal thickness, shape (draws,)."""
    nominal = design.limbs[0].thickness
    return drawn.input_values("legs.thickness_mm", nominal) / nominal


def leg_mass_ratios(design: Design, drawn: Drawn) -> Array:
    """Return the mass of a leg in each random draw over its nominal mass; it follows the thickness unless weighed."""
    weighed = design.weighed.leg_mass_g is not None
    return drawn.input_values("leg mass", 1.0) * (1.0 if weighed else leg_thickness_ratios(design, drawn))


def to_matrix(numbers: DimensionlessNumbers) -> Array:
    """Return the dimensionless numbers of n walkers or draws as a matrix of shape (n, fields)."""
    return np.column_stack(np.broadcast_arrays(*(np.atleast_1d(number) for number in numbers)))


def describe_number(name: str, low: float, high: float) -> tuple[str, str]:
    """Return the field `name` in words, and the range of its values as text, converted from logarithm or root."""
    words = name.removeprefix("log_").removeprefix("root_").replace("_", " ")
    if name == "root_tilt":
        low, high = low**2, high**2
    elif name.startswith("log_"):
        low, high = math.exp(low), math.exp(high)
    return words, f"{low:.2g} to {high:.2g}"
