"""Walkers that stand: where the plate throws nothing up, or nothing rubs, the speed is zero.

A body on its feet stays on the plate while the plate's largest downward acceleration, times what the
legs add to it, is below gravity's; feet then keep to the plate by friction unless the plate is steeper
than that holds. Without friction no foot ever pushes along a level plate.
"""

import math

from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.theory.hertz import tip_stiffness
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import MassProperties
from walkergen.core.walker.sections import section_of


def standing_reason(scene: Scene, design: Design, mass: MassProperties) -> str:
    """Return the reason why a walker rests; "" if it may run.

    Source: statics; the amplification is that of an undamped mass on a spring. Its rival are the runs of
    tests/core/theory/test_standing.py.
    """
    drive, plate, contact = scene.drive, scene.plate, scene.contact
    if plate.sways:
        return ""
    frictions = [contact.friction if limb.friction is None else limb.friction for limb in design.limbs]
    if max(frictions) == 0.0 and plate.slope_deg == 0.0:
        return "without friction no foot pushes: the walker bounces in place"
    if drive.kind != "plate" or plate.noise_ratio > 0.0:
        return ""
    slope = math.radians(abs(plate.slope_deg))
    if math.tan(slope) >= min(frictions):
        return ""
    thrown = _largest_acceleration(scene) * _amplification(scene, design, mass)
    if thrown >= GRAVITY * math.cos(slope):
        return ""
    return f"the plate throws nothing up (peak acceleration {drive.peak_gamma:.3g} g): the walker stands"


def _largest_acceleration(scene: Scene) -> float:
    """Bound on the plate's acceleration, mm/s^2: the second harmonic's adds up at most."""
    return scene.drive.peak_gamma * GRAVITY * (1.0 + 4.0 * scene.drive.second_harmonic_ratio)


def _amplification(scene: Scene, design: Design, mass: MassProperties) -> float:
    """Return the acceleration of a body on its legs over the plate's; infinite beyond their resonance."""
    modulus = 1e9 * design.material.youngs_modulus_gpa
    load = float(mass.total) * GRAVITY / (2 * len(design.limbs))
    tip = tip_stiffness(scene, design.material)
    softer = 0.5 / (1.5 * tip ** (2.0 / 3.0) * load ** (1.0 / 3.0))  # of both tips of a foot at rest
    stiffness = sum(1.0 / (_vertical_compliance(limb, modulus) + softer) for limb in design.limbs)
    fastest = scene.drive.omega * (2.0 if scene.drive.second_harmonic_ratio else 1.0)
    ratio = fastest**2 * float(mass.total) / stiffness
    return 1.0 / (1.0 - ratio) if ratio < 1.0 else math.inf


def _vertical_compliance(limb: Limb, modulus: float) -> float:
    """Return the vertical compliance of a leg with a sliding foot, s^2/g: it bends as a cantilever and is pressed."""
    softness = math.cos(limb.tilt) ** 2 / (modulus * limb.width * section_of(limb).axial(limb))
    if not limb.rigid:
        softness += math.sin(limb.tilt) ** 2 * limb.length**3 / (3.0 * modulus * section_of(limb).second_moment(limb))
    return softness
